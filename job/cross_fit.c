// SPDX-License-Identifier: Apache-2.0
// A surface or volume of the tile over several knot boxes: one untrimmed patch, close to T(D) everywhere.
//
// It interpolates T(D) at sites that crowd towards the ends, so that its edges and faces depend on T(D) along them
// alone. The bound: where D meets one knot box the difference is a polynomial, composed exactly; where it meets several,
// every one of their polynomials is bounded over the whole part, for each point has its image in one of the boxes.
// Parts are cut in halves each way until the bound is met.
#include "bezier/norm_bound.h"
#include "job/cross.h"

#include <knurl/compose.h>
#include <knurl/fit.h>
#include <math.h>

enum { DEPTH = 6, PARTS = 400, VOLUME_PARTS = 60, PROBES = 8, VARS = KN_JOB_VARS };

typedef struct fitting {
    kn_crossing *x;
    kn_bezier fit; // three components, polynomial
    double tol, bound;
    int parts; // that may still be looked at
    kn_bezier error[KN_CROSS_LINES + 1][KN_CROSS_LINES + 1];
    double weight[KN_CROSS_LINES + 1][KN_CROSS_LINES + 1], rounding[KN_CROSS_LINES + 1][KN_CROSS_LINES + 1];
} fitting;

static int box_of(const kn_crossing *x, int var, double at)
{
    int k = 0;
    while (k < x->n[var] && at > x->line[var][k]) k++;
    return k;
}

// T(D) at (r,t): the piece of the box where D(r,t) lies.
static kn_status value_at(kn_ctx *ctx, double out[3], const kn_crossing *x, const double *at)
{
    double d[3], origin[2], width[2], sum[4] = {0.0, 0.0, 0.0, 1.0};
    kn_status status = kn_bezier_eval(ctx, d, x->d, at);
    if (status != KN_OK) return status;
    int i = box_of(x, 0, d[0]), j = box_of(x, 1, d[1]);
    const kn_shell_piece *piece = &x->plan->pieces.list[x->piece[i][j]].piece;
    kn_crossing_map(origin, width, x, i, j);
    const double uv[2] = {(d[0] - origin[0]) / width[0], (d[1] - origin[1]) / width[1]};
    for (int t = 0; status == KN_OK && t < piece->nterms; t++) {
        kn_bezier view = piece->term[t];
        double value[4], scale = pow(d[2], piece->power[t]);
        view.rational = false;
        status = kn_bezier_eval(ctx, value, &view, uv);
        for (int c = 0; c < view.ncomp; c++) sum[c] = c == 3 && t == 0 ? value[3] : sum[c] + scale * value[c];
    }
    for (int c = 0; c < 3; c++) out[c] = sum[c] / sum[3];
    return status;
}

double kn_cross_site(int k, int degree)
{
    if (2 * k == degree) return 0.5;
    double x = 0.5 - 0.5 * cos(3.14159265358979323846 * (2 * k < degree ? k : degree - k) / degree);
    return 2 * k < degree ? x : 1.0 - x;
}

static kn_status interpolate(kn_ctx *ctx, fitting *f, int degree)
{
    double sites[KN_MAX_DEGREE + 1], line[2 * (KN_MAX_DEGREE + 1)];
    const int nvars = f->x->d->nvars, count = degree + 1;
    kn_spline s = {0};
    kn_bezier *pieces = NULL;
    size_t n = 1, npieces = 0;
    for (int v = 0; v < nvars; v++) n *= (size_t)count;
    kn_mark mark = kn_scratch_mark(ctx);
    double *values = kn_scratch(ctx, 3 * n, sizeof *values);
    kn_status status = values ? KN_OK : KN_ENOMEM;
    for (int k = 0; k < count; k++) {
        sites[k] = kn_cross_site(k, degree);
        line[k] = 0.0, line[count + k] = 1.0;
    }
    for (size_t k = 0; status == KN_OK && k < n; k++) {
        double at[VARS];
        size_t rest = k;
        for (int v = nvars - 1; v >= 0; v--, rest /= (size_t)count) at[v] = sites[rest % (size_t)count];
        status = value_at(ctx, values + 3 * k, f->x, at);
    }
    const int degrees[VARS] = {degree, degree, degree}, counts[VARS] = {count, count, count};
    const double *const knot[VARS] = {line, line, line}, *const where[VARS] = {sites, sites, sites};
    if (status == KN_OK) status = kn_fit_interpolate(ctx, &s, nvars, 3, degrees, counts, knot, where, values);
    if (status == KN_OK) status = kn_spline_to_bezier(ctx, &pieces, &npieces, &s);
    if (status == KN_OK) kn_bezier_swap(&f->fit, &pieces[0]);
    for (size_t k = 0; k < npieces; k++) kn_bezier_clear(ctx, &pieces[k]);
    kn_free(ctx, pieces);
    kn_spline_clear(ctx, &s);
    kn_scratch_release(ctx, mark);
    return status;
}

// The largest distance at places between the sites: a quick no.
static kn_status probe(kn_ctx *ctx, double *most, const fitting *f)
{
    kn_status status = KN_OK;
    *most = 0.0;
    int n = f->x->d->nvars == 3 ? PROBES * PROBES * PROBES : PROBES * PROBES;
    for (int k = 0; status == KN_OK && k < n; k++) {
        const double at[VARS] = {(k / PROBES % PROBES + 0.5) / PROBES, (k % PROBES + 0.5) / PROBES,
                                 (k / (PROBES * PROBES) + 0.5) / PROBES};
        double p[3], q[3];
        status = value_at(ctx, p, f->x, at);
        if (status == KN_OK) status = kn_bezier_eval(ctx, q, &f->fit, at);
        if (status == KN_OK)
            *most = fmax(*most, sqrt(pow(p[0] - q[0], 2) + pow(p[1] - q[1], 2) + pow(p[2] - q[2], 2)));
    }
    return status;
}

// T(D) - fit with the polynomial of one box, over all of D, and the least weight by which it is to be divided.
static kn_status make_error(kn_ctx *ctx, fitting *f, int i, int j)
{
    const kn_shell_piece *piece = &f->x->plan->pieces.list[f->x->piece[i][j]].piece;
    double origin[2], width[2], *weight = &f->weight[i][j];
    kn_bezier in = {0}, out = {0}, w = {0}, *e = &f->error[i][j];
    kn_crossing_map(origin, width, f->x, i, j);
    kn_status status = kn_bezier_copy(ctx, &in, f->x->d);
    size_t n = kn_bezier_count(f->x->d);
    for (size_t c = 0; status == KN_OK && c < 2; c++)
        for (size_t k = 0; k < n; k++) in.coef[c * n + k] = (in.coef[c * n + k] - origin[c]) / width[c];
    if (status == KN_OK) status = kn_compose_piece(ctx, &out, piece, &in);
    bool rational = status == KN_OK && out.rational;
    out.rational = false;
    *weight = 1.0;
    if (status == KN_OK) status = kn_bezier_components(ctx, e, &out, 0, 3);
    if (status == KN_OK && rational) status = kn_bezier_components(ctx, &w, &out, 3, 1);
    for (size_t k = 0; status == KN_OK && rational && k < kn_bezier_count(&w); k++)
        *weight = k == 0 ? w.coef[0] : fmin(*weight, w.coef[k]);
    if (status == KN_OK && rational) status = kn_bezier_product(ctx, &w, &w, &f->fit);
    if (status == KN_OK) status = kn_bezier_difference(ctx, e, e, rational ? &w : &f->fit);
    // products, sums and restrictions after the composition: well below 3 times its own rounding
    f->rounding[i][j] = 4.0 * kn_crossing_rounding(f->x, i, j);
    *weight *= 1.0 - 0x1p-30;
    kn_bezier_clear(ctx, &in);
    kn_bezier_clear(ctx, &out);
    kn_bezier_clear(ctx, &w);
    return status;
}

// *bound = that of |fit - T(D)| over a part, with the polynomial of one box: its coefficients there.
static kn_status bound_with(kn_ctx *ctx, double *bound, const fitting *f, const double *lo, const double *hi, int i,
                            int j)
{
    kn_bezier e = {0};
    kn_status status = kn_bezier_restrict(ctx, &e, &f->error[i][j], lo, hi);
    double most = 0.0;
    size_t n = status == KN_OK ? kn_bezier_count(&e) : 0;
    for (size_t k = 0; k < n; k++) {
        double x = e.coef[k], y = e.coef[n + k], z = e.coef[2 * n + k];
        most = fmax(most, x * x + y * y + z * z);
    }
    double weight = f->weight[i][j];
    *bound = weight > 0.0 ? kn_round_up((kn_round_up(sqrt(most)) + f->rounding[i][j]) / weight) : INFINITY;
    kn_bezier_clear(ctx, &e);
    return status;
}

static void boxes_met(int first[2], int last[2], const kn_crossing *x, const kn_bezier *d)
{
    size_t n = kn_bezier_count(d);
    for (int c = 0; c < 2; c++) {
        const double *a = d->coef + (size_t)c * n;
        double lo = a[0], hi = a[0];
        for (size_t k = 1; k < n; k++) lo = fmin(lo, a[k]), hi = fmax(hi, a[k]);
        first[c] = box_of(x, c, lo - 0x1p-45 * (1.0 + fabs(lo))); // D, restricted, is rounded
        last[c] = box_of(x, c, hi + 0x1p-45 * (1.0 + fabs(hi)));
    }
}

// f->bound rises to the bound over the part, or beyond f->tol.
static kn_status bound_part(kn_ctx *ctx, fitting *f, const double *lo, const double *hi, int depth)
{
    kn_bezier d = {0};
    int first[2], last[2];
    double most = 0.0;
    kn_status status = kn_bezier_restrict(ctx, &d, f->x->d, lo, hi);
    if (status == KN_OK) boxes_met(first, last, f->x, &d);
    for (int i = status == KN_OK ? first[0] : 1; status == KN_OK && i <= last[0]; i++)
        for (int j = first[1]; status == KN_OK && j <= last[1]; j++) {
            double one = 0.0;
            status = bound_with(ctx, &one, f, lo, hi, i, j);
            most = fmax(most, one);
        }
    kn_bezier_clear(ctx, &d);
    if (status == KN_OK) status = kn_progress(ctx, "knot lines", 0.0);
    if (status != KN_OK) return status;
    if (most <= f->tol || depth == DEPTH || --f->parts < 0) {
        f->bound = fmax(f->bound, most);
        return KN_OK;
    }
    for (int k = 0; status == KN_OK && f->bound <= f->tol && k < 1 << f->x->d->nvars; k++) {
        double from[VARS], to[VARS];
        for (int v = 0; v < f->x->d->nvars; v++) {
            double middle = 0.5 * (lo[v] + hi[v]);
            bool upper = (k >> (f->x->d->nvars - 1 - v) & 1) != 0;
            from[v] = upper ? middle : lo[v], to[v] = upper ? hi[v] : middle;
        }
        status = bound_part(ctx, f, from, to, depth + 1);
    }
    return status;
}

static kn_status bound_all(kn_ctx *ctx, fitting *f)
{
    static const double zero[VARS] = {0.0, 0.0, 0.0}, one[VARS] = {1.0, 1.0, 1.0};
    kn_status status = KN_OK;
    for (int i = 0; i <= f->x->n[0]; i++)
        for (int j = 0; status == KN_OK && j <= f->x->n[1]; j++) status = make_error(ctx, f, i, j);
    f->bound = 0.0, f->parts = f->x->d->nvars == 3 ? VOLUME_PARTS : PARTS;
    return status == KN_OK ? bound_part(ctx, f, zero, one, 0) : status;
}

static kn_status add(kn_ctx *ctx, fitting *f)
{
    kn_crossing *x = f->x;
    kn_job_leaf part = *x->leaf;
    part.trim = (kn_trim){0};
    part.alone = true;
    part.piece = x->piece[0][0];
    kn_status status = kn_trim_copy(ctx, &part.trim, &x->leaf->trim);
    const kn_shell_piece *piece = &x->plan->pieces.list[part.piece].piece;
    if (status == KN_OK && piece->term[0].rational) { // the weight 1
        kn_bezier one = {0};
        size_t n = 3 * kn_bezier_count(&f->fit);
        status = kn_bezier_init(ctx, &one, f->fit.nvars, 4, true, f->fit.degree);
        for (size_t k = 0; status == KN_OK && k < n + n / 3; k++) one.coef[k] = k < n ? f->fit.coef[k] : 1.0;
        if (status == KN_OK) kn_bezier_swap(&f->fit, &one);
        kn_bezier_clear(ctx, &one);
    }
    kn_bezier_swap(&part.made, &f->fit);
    if (status == KN_OK) status = kn_job_add_leaf(ctx, x->plan, &part);
    if (status == KN_OK) x->plan->leaves[x->plan->count - 1].key.exact = false;
    if (status == KN_OK) x->plan->crossing = fmax(x->plan->crossing, f->bound);
    kn_bezier_clear(ctx, &part.made);
    kn_trim_clear(ctx, &part.trim);
    return status;
}

kn_status kn_cross_fit(kn_ctx *ctx, bool *crossed, kn_crossing *x)
{
    static const int degrees[] = {4, 8, 12};
    fitting f = {.x = x, .tol = x->plan->job->options.crossing_tol};
    bool fit;
    kn_status status = kn_crossing_pieces(ctx, &fit, x);
    *crossed = false;
    for (size_t k = 0; status == KN_OK && fit && !*crossed && k < sizeof degrees / sizeof *degrees; k++) {
        double seen = 0.0;
        if (degrees[k] > x->plan->job->options.max_degree) break;
        status = interpolate(ctx, &f, degrees[k]);
        if (status == KN_OK) status = probe(ctx, &seen, &f);
        if (status != KN_OK || seen > 0.4 * f.tol) continue; // the rest is for the bound, beside lines
        status = bound_all(ctx, &f);
        *crossed = status == KN_OK && f.bound <= f.tol;
    }
    if (status == KN_OK && *crossed) status = add(ctx, &f);
    kn_bezier_clear(ctx, &f.fit);
    for (int k = 0; k < (KN_CROSS_LINES + 1) * (KN_CROSS_LINES + 1); k++) kn_bezier_clear(ctx, &f.error[0][0] + k);
    return status;
}
