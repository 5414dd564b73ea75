// SPDX-License-Identifier: Apache-2.0
// Batched evaluation: the plain version, one point at a time.
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

// The B-splines of variable d that act at t, and the first coefficient they belong to.
static int basis(double *values, const kn_eval_function *f, int d, double t)
{
    double b[KN_MAX_DEGREE + 1], args[KN_MAX_DEGREE + 1], row[KN_MAX_DEGREE + 1];
    int p = f->degree[d];
    const double *knots = f->knots[d];
    if (!knots) {
        bernstein(values, p, t);
        return 0;
    }
    int s = kn_knots_span(knots, p, f->count[d], t);
    double lo = knots[s], hi = knots[s + 1];
    bernstein(b, p, t == knots[f->count[d]] ? 1.0 : (t - lo) * (1.0 / (hi - lo)));
    for (int r = 0; r <= p; r++) {
        for (int k = 0; k < p; k++) args[k] = k < p - r ? lo : hi;
        kn_knots_blossom(row, knots, p, s, args);
        for (int k = 0; k <= p; k++) values[k] = r == 0 ? b[0] * row[k] : values[k] + b[r] * row[k];
    }
    return s - p;
}

// sum over variables d, d-1, .. 0, the first one innermost. stride[d]: of coefficients along d.
static double contract(double (*n)[KN_MAX_DEGREE + 1], const int *degree, const size_t *stride, const double *coef,
                       int d)
{
    double sum = 0.0;
    for (int k = 0; k <= degree[d]; k++) {
        const double *c = coef + (size_t)k * stride[d];
        double term = n[d][k] * (d > 0 ? contract(n, degree, stride, c, d - 1) : *c);
        sum = k == 0 ? term : sum + term;
    }
    return sum;
}

void kn_eval_plain(double *out, const kn_eval_function *f, size_t npoints, const double *at)
{
    double n[KN_MAX_VARS][KN_MAX_DEGREE + 1], value[KN_MAX_COMPS];
    size_t stride[KN_MAX_VARS], all = 1;
    int dim = f->ncomp - f->rational;
    for (int d = f->nvars - 1; d >= 0; all *= (size_t)f->count[d], d--) stride[d] = all;
    for (size_t i = 0; i < npoints; i++, at += f->nvars, out += dim) {
        size_t first = 0;
        for (int d = 0; d < f->nvars; d++) first += stride[d] * (size_t)basis(n[d], f, d, at[d]);
        for (int c = 0; c < f->ncomp; c++)
            value[c] = contract(n, f->degree, stride, f->coef + (size_t)c * all + first, f->nvars - 1);
        for (int c = 0; c < dim; c++) out[c] = f->rational ? value[c] / value[dim] : value[c];
    }
}
