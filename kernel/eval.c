// SPDX-License-Identifier: Apache-2.0
// Batched evaluation: the plain versions, one point at a time.
#include "kernel/eval.h"

#include "kernel/binomial.h"
#include "kernel/knots.h"

const char *kn_eval_level_name(kn_eval_level level)
{
    static const char names[][8] = {"plain", "SSE2", "AVX2", "AVX-512"};
    return level < KN_EVAL_LEVELS ? names[level] : "?";
}

// values[r] = C(p,r) x^r (1-x)^(p-r), each power by repeated multiplication.
static void bernstein(double *values, int degree, double x)
{
    double xr = 1.0, yr = 1.0, y = 1.0 - x;
    for (int r = 0; r <= degree; r++, xr *= x) values[r] = kn_binomial(degree, r) * xr;
    for (int r = degree; r >= 0; r--, yr *= y) values[r] *= yr;
}

// g[r] = scale (b_(r-1) - b_r), b of degree - 1: derivatives of the Bernstein polynomials when scale = degree.
static void slopes(double *g, int degree, double x, double scale)
{
    bernstein(g, degree - 1, x);
    for (int r = degree; r >= 0; r--) g[r] = scale * ((r > 0 ? g[r - 1] : 0.0) - (r < degree ? g[r] : 0.0));
}

// One variable at one point.
typedef struct local {
    size_t first;                                       // coefficient
    double b[KN_MAX_DEGREE + 1], g[KN_MAX_DEGREE + 1];  // Bernstein polynomials and derivatives
    double n[KN_MAX_DEGREE + 1], dn[KN_MAX_DEGREE + 1]; // B-splines and derivatives
} local;

// Row r of the extraction matrix of span s.
static void extraction(double *row, const kn_eval_function *f, int d, int s, int r)
{
    double args[KN_MAX_DEGREE + 1];
    int p = f->degree[d];
    for (int k = 0; k < p; k++) args[k] = k < p - r ? f->knots[d][s] : f->knots[d][s + 1];
    kn_knots_blossom(row, f->knots[d], p, s, args);
}

static void find(local *a, const kn_eval_function *f, int d, double t)
{
    double row[KN_MAX_DEGREE + 1];
    int p = f->degree[d], s = p;
    const double *knots = f->knots[d];
    double lo = 0.0, inverse = 1.0, end = knots ? knots[f->count[d]] : 1.0;
    if (knots) {
        s = kn_knots_span(knots, p, f->count[d], t);
        lo = knots[s], inverse = 1.0 / (knots[s + 1] - lo);
    }
    double x = t == end ? 1.0 : (t - lo) * inverse;
    bernstein(a->b, p, x);
    slopes(a->g, p, x, p * inverse);
    a->first = (size_t)(s - p);
    for (int r = 0; r <= p; r++) {
        if (knots) extraction(row, f, d, s, r);
        for (int k = 0; k <= p && knots; k++) {
            a->n[k] = r == 0 ? a->b[0] * row[k] : a->n[k] + a->b[r] * row[k];
            a->dn[k] = r == 0 ? a->g[0] * row[k] : a->dn[k] + a->g[r] * row[k];
        }
        if (!knots) a->n[r] = a->b[r], a->dn[r] = a->g[r];
    }
}

typedef struct point {
    const kn_eval_function *f;
    bool split;
    double matrix[KN_MAX_DEGREE + 1][KN_MAX_DEGREE + 1]; // extraction of the last variable when it is split
    local in[KN_MAX_VARS];
    size_t stride[KN_MAX_VARS];
} point;

// The coefficient at c, k steps along the last variable, or the Bezier coefficient k.
static double leaf(const point *at, const double *c, int k)
{
    int p = at->f->degree[at->f->nvars - 1];
    if (!at->split) return c[k];
    double sum = at->matrix[k][0] * c[0];
    for (int j = 1; j <= p; j++) sum += at->matrix[k][j] * c[j];
    return sum;
}

// sum[0 .. d+1] += weight times the value and partials s[0 .. d] of the variables before d; slope: of variable d.
static void add(double *sum, const double *s, double weight, double slope, bool first, int d)
{
    sum[1 + d] = first ? slope * s[0] : sum[1 + d] + slope * s[0];
    for (int m = 0; m <= d; m++) sum[m] = first ? weight * s[m] : sum[m] + weight * s[m];
}

// value[0 .. d+1] over the variables 0 .. d, d < nvars - 1; the last one's index is k.
static void contract(double *value, const point *at, const double *c, int d, int k)
{
    if (d < 0) {
        value[0] = leaf(at, c, k);
        return;
    }
    for (int i = 0; i <= at->f->degree[d]; i++) {
        double inner[KN_MAX_VARS + 1];
        contract(inner, at, c + (size_t)i * at->stride[d], d - 1, k);
        add(value, inner, at->in[d].n[i], at->in[d].dn[i], i == 0, d);
    }
}

// Even and odd terms of the last variable.
static void contract_last(double *value, const point *at, const double *c)
{
    double inner[KN_MAX_VARS + 1], odd[KN_MAX_VARS + 1];
    int last = at->f->nvars - 1, p = at->f->degree[last];
    const double *n = at->split ? at->in[last].b : at->in[last].n, *g = at->split ? at->in[last].g : at->in[last].dn;
    for (int k = 0; k <= p; k++) {
        contract(inner, at, c, last - 1, k);
        add(k % 2 ? odd : value, inner, n[k], g[k], k < 2, last);
    }
    for (int m = 0; m <= last + 1 && p > 0; m++) value[m] += odd[m];
}

static void locate(point *to, const kn_eval_function *f, const double *at)
{
    int last = f->nvars - 1;
    size_t all = 1;
    *to = (point){.f = f, .split = kn_eval_splits(f)};
    for (int d = last; d >= 0; all *= (size_t)f->count[d], d--) {
        to->stride[d] = all;
        find(&to->in[d], f, d, at[d]);
    }
    int s = f->degree[last] + (int)to->in[last].first;
    for (int r = 0; r <= f->degree[last] && to->split; r++) extraction(to->matrix[r], f, last, s, r);
}

void kn_eval_plain(double *out, const kn_eval_function *f, size_t npoints, const double *at, bool partials)
{
    point here;
    double value[KN_MAX_COMPS][KN_MAX_VARS + 1];
    size_t all = 1;
    int dim = f->ncomp - f->rational, results = partials ? 1 + f->nvars : 1;
    for (int d = 0; d < f->nvars; d++) all *= (size_t)f->count[d];
    for (size_t i = 0; i < npoints; i++, at += f->nvars, out += dim * results) {
        size_t first = 0;
        locate(&here, f, at);
        for (int d = 0; d < f->nvars; d++) first += here.stride[d] * here.in[d].first;
        for (int c = 0; c < f->ncomp; c++) contract_last(value[c], &here, f->coef + (size_t)c * all + first);
        const double *w = value[dim]; // the weight's, when rational
        for (int c = 0; c < dim; c++)
            for (int m = 0; m < results; m++) {
                double *to = out + m * dim + c;
                *to = !f->rational ? value[c][m] : m == 0 ? value[c][0] / w[0] : (value[c][m] - out[c] * w[m]) / w[0];
            }
    }
}

// The last variable innermost, all sums ascending; `left` variables are still to do.
static double contract_grid(const point *at, const double *c, int left)
{
    if (left == 0) return *c;
    double sum = 0.0;
    int d = at->f->nvars - left;
    for (int k = 0; k <= at->f->degree[d]; k++) {
        double term = at->in[d].n[k] * contract_grid(at, c + (size_t)k * at->stride[d], left - 1);
        sum = k == 0 ? term : sum + term;
    }
    return sum;
}

void kn_eval_grid_plain(double *out, const kn_eval_function *f, const size_t *n, const double *const *at)
{
    point here;
    size_t all = 1, points = 1, k[KN_MAX_VARS] = {0};
    int dim = f->ncomp - f->rational;
    for (int d = 0; d < f->nvars; d++) all *= (size_t)f->count[d], points *= n[d];
    for (size_t i = 0; i < points; i++, out += dim) {
        double t[KN_MAX_VARS] = {0}, value[KN_MAX_COMPS];
        size_t first = 0;
        for (int d = 0; d < f->nvars; d++) t[d] = at[d][k[d]];
        locate(&here, f, t);
        for (int d = 0; d < f->nvars; d++) first += here.stride[d] * here.in[d].first;
        for (int c = 0; c < f->ncomp; c++)
            value[c] = contract_grid(&here, f->coef + (size_t)c * all + first, f->nvars);
        for (int c = 0; c < dim; c++) out[c] = f->rational ? value[c] / value[dim] : value[c];
        for (int d = f->nvars - 1; d >= 0 && ++k[d] == n[d]; d--) k[d] = 0;
    }
}
