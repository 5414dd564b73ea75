// SPDX-License-Identifier: Apache-2.0
// A factor for heights that follows the local stretch of S.
//
// With a(u,v) = |S_u x S_v| du(u) dv(v) / mean the wanted factor is t = P^(1/4), P = (a^2 + e^2) / (1 + e^2): a
// spline over each cell, positive where a vanishes. h interpolates t. For rational S, |S_u x S_v|^2 = |N|^2 / W^6,
//     N = W (P_u x P_v) - W_v (P_u x P) - W_u (P x P_v),
// and h^4 / t^4 - 1 = D / T, D = (1 + e^2) W^6 h^4 - T, T = |N|^2 (du dv / mean)^2 + e^2 W^6. In Bernstein form of
// one degree the quotient is at every point a mean of the quotients of coefficients, weighted by those of T > 0.
#include "bezier/norm_bound.h"
#include "cells/internal.h"
#include "kernel/bounds.h"
#include "kernel/context.h"

#include <knurl/fit.h>
#include <math.h>

static const double floor2 = 1.0 / 256.0; // e^2: t is never below (e^2 / (1 + e^2))^(1/4) = 0.2497

enum { DEPTH = 6, LARGEST_DEGREE = 3 };

// ---- the target at points ----

// The size of cells as a function of one variable: piecewise linear, at a line the mean of the two cells there.
static double line_step(const double *lines, int n, int i)
{
    double left = i > 0 ? lines[i] - lines[i - 1] : lines[1] - lines[0];
    double right = i < n - 1 ? lines[i + 1] - lines[i] : lines[n - 1] - lines[n - 2];
    return 0.5 * (left + right);
}

static double step_at(const double *lines, int n, double x)
{
    int i = 0, end = n - 1;
    while (end - i > 1) {
        int middle = (i + end) / 2;
        if (lines[middle] <= x)
            i = middle;
        else
            end = middle;
    }
    double t = (x - lines[i]) / (lines[i + 1] - lines[i]);
    return (1.0 - t) * line_step(lines, n, i) + t * line_step(lines, n, i + 1);
}

typedef struct stretch {
    const kn_spline *surface;
    const double *const *lines;
    const int *nlines;
    double mean;
    int degree;
} stretch;

static kn_status sample_target(kn_ctx *ctx, double *value, const stretch *s, const double *const sites[2],
                               const int count[2])
{
    kn_mark mark = kn_scratch_mark(ctx);
    size_t n = (size_t)count[1];
    double *at = kn_scratch(ctx, 2 * n, sizeof *at), *d = kn_scratch(ctx, 9 * n, sizeof *d);
    kn_status status = at && d ? KN_OK : KN_ENOMEM;
    for (int i = 0; status == KN_OK && i < count[0]; i++) {
        double du = step_at(s->lines[0], s->nlines[0], sites[0][i]);
        for (size_t j = 0; j < n; j++) at[2 * j] = sites[0][i], at[2 * j + 1] = sites[1][j];
        status = kn_spline_eval_batch_partials(ctx, d, s->surface, n, at);
        for (size_t j = 0; status == KN_OK && j < n; j++) {
            const double *a = d + 9 * j + 3, *b = d + 9 * j + 6;
            double dv = step_at(s->lines[1], s->nlines[1], sites[1][j]);
            double area = kn_cells_area(a, b) * du * dv / s->mean;
            value[(size_t)i * n + j] = sqrt(sqrt((area * area + floor2) / (1.0 + floor2)));
            if (!isfinite(area)) status = kn_fail(ctx, KN_EDOMAIN, "stretch: cells of size %g", area);
        }
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// h of one degree in both variables, its knots the lines.
static kn_status interpolate(kn_ctx *ctx, kn_spline *out, const stretch *s)
{
    int p = s->degree, degree[2] = {p, p}, count[2];
    double *knots[2], *sites[2], *value;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = KN_OK;
    for (int d = 0; status == KN_OK && d < 2; d++) {
        int n = s->nlines[d];
        count[d] = n - 1 + p;
        knots[d] = kn_scratch(ctx, (size_t)(n + 2 * p), sizeof *knots[d]);
        sites[d] = kn_scratch(ctx, (size_t)count[d], sizeof *sites[d]);
        if (!knots[d] || !sites[d]) status = KN_ENOMEM;
        for (int i = 0; status == KN_OK && i < n + 2 * p; i++)
            knots[d][i] = s->lines[d][i < p ? 0 : i - p < n ? i - p : n - 1];
        if (status == KN_OK) status = kn_fit_greville(ctx, sites[d], knots[d], p, count[d]);
    }
    if (status == KN_OK) {
        value = kn_scratch(ctx, (size_t)count[0] * (size_t)count[1], sizeof *value);
        const double *at[2] = {sites[0], sites[1]}, *k[2] = {knots[0], knots[1]};
        status = value ? sample_target(ctx, value, s, at, count) : KN_ENOMEM;
        if (status == KN_OK) status = kn_fit_interpolate(ctx, out, 2, 1, degree, count, k, at, value);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// ---- the certificate: numbers with bounds of their sizes and of their errors ----

typedef struct bound {
    double size, error;
} bound;

// A product of two, every coefficient of which has gamma(roundings) of rounding.
static bound times(bound a, bound b, double roundings)
{
    double up = 1.0 + 0x1p-40, top = (a.size + a.error) * (b.size + b.error) * up;
    double carried = a.size * b.error + b.size * a.error + a.error * b.error;
    return (bound){top, (carried + kn_gamma_up(roundings) * top) * up};
}

static bound plus(bound a, bound b)
{
    double up = 1.0 + 0x1p-40, top = (a.size + b.size) * up;
    return (bound){top, (a.error + b.error + kn_gamma_up(2.0) * top) * up};
}

static bound measured(const kn_bezier *b, int dim, double error)
{
    return (bound){kn_hull_norm(kn_bezier_count(b), dim, b->coef), error};
}

enum { P, W, PX, PY, WX, WY, N, N2, W6, H, T, F, G, A, B, NWORK };

typedef struct work {
    kn_bezier b[NWORK];
    bound size[NWORK];
    double roundings; // of a product of any two
    bool rational;
    double lo, hi; // of D / T so far
} work;

static kn_status multiply(kn_ctx *ctx, work *w, int out, int a, int b)
{
    bound size = times(w->size[a], w->size[b], w->roundings);
    kn_status status = kn_bezier_product(ctx, &w->b[out], &w->b[a], &w->b[b]);
    if (status == KN_OK) w->size[out] = size;
    return status;
}

static kn_status cross(kn_ctx *ctx, work *w, int out, int a, int b)
{
    bound size = times(w->size[a], w->size[b], 2.0 * w->roundings);
    kn_status status = kn_bezier_cross(ctx, &w->b[out], &w->b[a], &w->b[b]);
    if (status == KN_OK) w->size[out] = size;
    return status;
}

// w->b[N] of a rational piece, from P and W and their derivatives.
static kn_status rational_normal(kn_ctx *ctx, work *w)
{
    static const int terms[2][3] = {{WY, PX, P}, {WX, P, PY}};
    kn_status status = cross(ctx, w, N, PX, PY);
    if (status == KN_OK) status = multiply(ctx, w, N, W, N);
    for (int k = 0; status == KN_OK && k < 2; k++) {
        status = cross(ctx, w, A, terms[k][1], terms[k][2]);
        if (status == KN_OK) status = multiply(ctx, w, A, terms[k][0], A);
        if (status == KN_OK) status = kn_bezier_difference(ctx, &w->b[N], &w->b[N], &w->b[A]);
        w->size[N] = plus(w->size[N], w->size[A]);
        w->size[N].error += kn_gamma_up(w->roundings) * w->size[N].size; // of elevation, where degrees differ
    }
    return status;
}

// out = the fourth or sixth power of `of`.
static kn_status power(kn_ctx *ctx, work *w, int out, int of, int exponent)
{
    kn_status status = multiply(ctx, w, A, of, of);
    if (status == KN_OK) status = multiply(ctx, w, out, A, A);
    if (status == KN_OK && exponent == 6) status = multiply(ctx, w, out, out, A);
    return status;
}

// P, W and H over the cell, and their sizes.
static kn_status load_cell(kn_ctx *ctx, work *w, const stretch *s, const kn_spline *h, const double lo[2],
                           const double hi[2], const bound base[3])
{
    kn_spline piece = {0};
    kn_bezier all = {.nvars = 2};
    kn_status status = kn_spline_restrict(ctx, &piece, s->surface, lo, hi);
    all.ncomp = piece.ncomp, all.rational = piece.rational, all.coef = piece.coef;
    for (int d = 0; d < 2; d++) all.degree[d] = piece.degree[d];
    if (status == KN_OK) status = kn_bezier_components(ctx, &w->b[P], &all, 0, 3);
    if (status == KN_OK && w->rational) status = kn_bezier_components(ctx, &w->b[W], &all, 3, 1);
    if (status == KN_OK) status = kn_spline_restrict(ctx, &piece, h, lo, hi);
    all = (kn_bezier){.nvars = 2, .ncomp = 1, .degree = {s->degree, s->degree}, .coef = piece.coef};
    if (status == KN_OK) status = kn_bezier_copy(ctx, &w->b[H], &all);
    kn_spline_clear(ctx, &piece);
    if (status != KN_OK) return status;
    w->size[P] = measured(&w->b[P], 3, base[0].error);
    w->size[H] = measured(&w->b[H], 1, base[2].error);
    if (w->rational) w->size[W] = measured(&w->b[W], 1, base[1].error);
    return KN_OK;
}

// Derivatives in the cell's own parameters: differences of coefficients, times the degree.
static kn_status differentiate(kn_ctx *ctx, work *w)
{
    static const int of[4] = {P, P, W, W}, to[4] = {PX, PY, WX, WY};
    kn_status status = KN_OK;
    for (int k = 0; status == KN_OK && k < (w->rational ? 4 : 2); k++) {
        int var = k % 2, p = w->b[of[k]].degree[var];
        status = kn_bezier_derivative(ctx, &w->b[to[k]], &w->b[of[k]], var);
        if (status != KN_OK) break;
        double size = kn_hull_norm(kn_bezier_count(&w->b[to[k]]), k < 2 ? 3 : 1, w->b[to[k]].coef);
        double error = 2.0 * p * w->size[of[k]].error + kn_gamma_up(6.0) * 2.0 * p * w->size[of[k]].size;
        w->size[to[k]] = (bound){size, error};
    }
    return status;
}

// The squares of du / (the cell's side) and of dv / (the cell's other side), over mean^2.
static kn_status step_factor(kn_ctx *ctx, work *w, const stretch *s, const int cell[2])
{
    double f[2][2];
    for (int d = 0; d < 2; d++)
        for (int e = 0; e < 2; e++)
            f[d][e] = line_step(s->lines[d], s->nlines[d], cell[d] + e) /
                      (s->lines[d][cell[d] + 1] - s->lines[d][cell[d]]);
    double coef[4], most = 0.0;
    for (int k = 0; k < 4; k++) {
        coef[k] = f[0][k / 2] * f[1][k % 2] / s->mean;
        most = fmax(most, coef[k]);
    }
    const kn_bezier linear = {.nvars = 2, .ncomp = 1, .degree = {1, 1}, .coef = coef};
    kn_status status = kn_bezier_product(ctx, &w->b[G], &linear, &linear);
    const bound one = {most, kn_gamma_up(12.0) * most};
    w->size[G] = times(one, one, w->roundings);
    return status;
}

// T, and F = (1 + e^2) W^6 h^4, brought to one degree.
static kn_status make_sides(kn_ctx *ctx, work *w)
{
    kn_status status = KN_OK;
    if (w->rational) {
        status = rational_normal(ctx, w);
        if (status == KN_OK) status = power(ctx, w, W6, W, 6);
    } else {
        status = cross(ctx, w, N, PX, PY);
        if (status == KN_OK && !w->b[W6].coef)
            status = kn_bezier_init(ctx, &w->b[W6], 2, 1, false, (const int[]){0, 0});
        if (status == KN_OK) w->b[W6].coef[0] = 1.0;
        w->size[W6] = (bound){1.0, 0.0};
    }
    w->size[N2] = times(w->size[N], w->size[N], 2.0 * w->roundings);
    if (status == KN_OK) status = kn_bezier_dot(ctx, &w->b[N2], &w->b[N], &w->b[N]);
    if (status == KN_OK) status = multiply(ctx, w, T, N2, G);
    if (status == KN_OK) status = power(ctx, w, F, H, 4);
    if (status == KN_OK) status = multiply(ctx, w, F, F, W6);
    if (status == KN_OK) status = kn_bezier_scale(ctx, &w->b[F], &w->b[F], 1.0 + floor2);
    w->size[F] = times(w->size[F], (bound){1.0 + floor2, 0.0}, 1.0);
    if (status == KN_OK) status = kn_bezier_scale(ctx, &w->b[B], &w->b[W6], floor2); // a power of two
    if (status == KN_OK) status = kn_bezier_sum(ctx, &w->b[T], &w->b[T], &w->b[B]);
    w->size[T] = plus(w->size[T], times(w->size[W6], (bound){floor2, 0.0}, 0.0));
    int degree[2];
    for (int d = 0; d < 2; d++)
        degree[d] = w->b[T].degree[d] > w->b[F].degree[d] ? w->b[T].degree[d] : w->b[F].degree[d];
    if (status == KN_OK) status = kn_bezier_elevate(ctx, &w->b[T], &w->b[T], degree);
    if (status == KN_OK) status = kn_bezier_elevate(ctx, &w->b[F], &w->b[F], degree);
    return status;
}

// The range of F / T - 1 over [0,1]^2, with `error` in every coefficient of either; false: T may vanish.
static bool quotient_range(double *lo, double *hi, const kn_bezier *t, const kn_bezier *f, double error)
{
    *lo = INFINITY, *hi = -INFINITY;
    for (size_t i = 0; i < kn_bezier_count(t); i++) {
        double least = t->coef[i] - error, d = f->coef[i] - t->coef[i];
        if (!(least > 0.0) || !isfinite(d)) return false;
        double slack = 2.0 * error + 0x1p-50 * (fabs(f->coef[i]) + fabs(t->coef[i]));
        double low = d - slack, high = d + slack, wide = t->coef[i] + error;
        *lo = fmin(*lo, low / (low < 0.0 ? least : wide) - 0x1p-50);
        *hi = fmax(*hi, high / (high > 0.0 ? least : wide) + 0x1p-50);
    }
    return true;
}

// Widens [w->lo, w->hi] to bounds over a box, halved until they are within a tenth of what is there or of a sample.
static kn_status search(kn_ctx *ctx, work *w, const kn_bezier *t, const kn_bezier *f, double error, int depth)
{
    double lo, hi;
    bool fine = quotient_range(&lo, &hi, t, f, error);
    double corner = f->coef[0] / t->coef[0] - 1.0;
    fine = fine && lo >= fmin(1.1 * fmin(corner, 0.0) - 1e-3, w->lo) &&
           hi <= fmax(1.1 * fmax(corner, 0.0) + 1e-3, w->hi);
    if (fine || depth == DEPTH) {
        w->lo = isfinite(lo) ? fmin(w->lo, lo) : -INFINITY;
        w->hi = isfinite(hi) ? fmax(w->hi, hi) : INFINITY;
        if (!quotient_range(&lo, &hi, t, f, error)) w->lo = -INFINITY, w->hi = INFINITY;
        return KN_OK;
    }
    kn_bezier half[4] = {{0}};
    kn_status status = kn_bezier_subdivide(ctx, &half[0], &half[1], t, depth % 2, 0.5);
    if (status == KN_OK) status = kn_bezier_subdivide(ctx, &half[2], &half[3], f, depth % 2, 0.5);
    for (int k = 0; status == KN_OK && k < 2; k++) status = search(ctx, w, &half[k], &half[2 + k], error, depth + 1);
    for (int k = 0; k < 4; k++) kn_bezier_clear(ctx, &half[k]);
    return status;
}

static kn_status certify_cell(kn_ctx *ctx, work *w, const stretch *s, const kn_spline *h, const int cell[2],
                              const bound base[3])
{
    double lo[2], hi[2];
    for (int d = 0; d < 2; d++) lo[d] = s->lines[d][cell[d]], hi[d] = s->lines[d][cell[d] + 1];
    kn_status status = load_cell(ctx, w, s, h, lo, hi, base);
    if (status == KN_OK) status = differentiate(ctx, w);
    if (status == KN_OK) status = step_factor(ctx, w, s, cell);
    if (status == KN_OK) status = make_sides(ctx, w);
    if (status != KN_OK) return status;
    bound all = plus(w->size[T], w->size[F]);
    double halvings = 2.0 * (DEPTH + 3) * (w->b[T].degree[0] + w->b[T].degree[1] + 2); // and elevation
    return search(ctx, w, &w->b[T], &w->b[F], all.error + kn_gamma_up(halvings) * all.size, 0);
}

// *error: a bound of |h / t - 1|; INFINITY where none was found.
static kn_status certify(kn_ctx *ctx, double *error, const stretch *s, const kn_spline *h)
{
    const kn_spline *f = s->surface;
    size_t n = kn_spline_count(f);
    work w = {.rational = f->rational};
    kn_status status = KN_OK;
    double knot = kn_gamma_up(12.0 * (f->degree[0] + f->degree[1] + 2));
    bound base[3] = {{kn_hull_norm(n, 3, f->coef), 0.0}, {1.0, 0.0}, {0.0, 0.0}};
    if (w.rational) base[1].size = kn_hull_norm(n, 1, f->coef + 3 * n);
    base[2].size = kn_hull_norm(kn_spline_count(h), 1, h->coef);
    for (int k = 0; k < 3; k++)
        base[k].error = (k < 2 ? knot : kn_gamma_up(12.0 * (2 * s->degree + 2))) * base[k].size;
    double terms = 1.0;
    for (int d = 0; d < 2; d++) terms *= 6.0 * f->degree[d] + 4.0 * s->degree + 3.0;
    w.roundings = 4.0 * terms + 40.0; // sums of no more terms than the largest piece has coefficients
    int cell[2];
    for (cell[0] = 0; status == KN_OK && cell[0] < s->nlines[0] - 1; cell[0]++) {
        for (cell[1] = 0; status == KN_OK && cell[1] < s->nlines[1] - 1; cell[1]++)
            status = certify_cell(ctx, &w, s, h, cell, base);
        if (status == KN_OK) status = kn_progress(ctx, "stretch", (cell[0] + 1.0) / (s->nlines[0] - 1));
    }
    for (int k = 0; k < NWORK; k++) kn_bezier_clear(ctx, &w.b[k]);
    if (status != KN_OK) return status;
    // h / t = (1 + D / T)^(1/4), and h > 0 as it is nowhere 0 where D / T > -1, and positive at a corner.
    bool positive = w.lo > -1.0 && h->coef[0] > 0.0;
    double below = 1.0 - sqrt(sqrt(1.0 + w.lo)), above = sqrt(sqrt(1.0 + w.hi)) - 1.0;
    *error = positive ? fmax(0.0, fmax(below, above)) + 0x1p-48 : INFINITY;
    return KN_OK;
}

// ---- the call ----

static kn_status check(kn_ctx *ctx, const kn_spline *surface, const double *const lines[2], const int nlines[2],
                       const kn_cells_stretch_options *o)
{
    kn_status status = kn_cells_expect(ctx, "stretch", surface);
    for (int d = 0; status == KN_OK && d < 2; d++)
        status = kn_cells_expect_lines(ctx, "stretch", surface, d, lines[d], nlines[d], true);
    for (int d = 0; status == KN_OK && d < 2; d++) { // every knot is a line: cells lie in one piece of S
        const double *k = surface->knots[d];
        for (int i = 0, j = 0; status == KN_OK && i < surface->count[d] + surface->degree[d] + 1; i++) {
            while (j < nlines[d] - 1 && lines[d][j] < k[i]) j++;
            if (lines[d][j] != k[i])
                status = kn_fail(ctx, KN_EDOMAIN, "stretch: the knot %g in variable %d is no line", k[i], d);
        }
    }
    if (status != KN_OK) return status;
    if (!(o->mean >= 0.0) || isinf(o->mean) || !(o->tolerance >= 0.0) || o->degree < 0 || o->degree > LARGEST_DEGREE)
        return kn_fail(ctx, KN_EDOMAIN, "stretch: mean %g, degree %d, tolerance %g", o->mean, o->degree,
                       o->tolerance);
    for (int d = 0; d < 2; d++) {
        int top = o->degree > 0 ? o->degree : LARGEST_DEGREE, p = surface->degree[d];
        int target = surface->rational ? 6 * p : 4 * p, fitted = 4 * top + (surface->rational ? 6 * p : 0);
        if (target + 2 > KN_MAX_DEGREE || fitted > KN_MAX_DEGREE)
            return kn_fail(ctx, KN_ELIMIT, "stretch: a surface of degree %d", p);
    }
    return KN_OK;
}

kn_status kn_cells_stretch(kn_ctx *ctx, kn_spline *out, double *error, const kn_spline *surface,
                           const double *const lines[2], const int nlines[2], const kn_cells_stretch_options *options)
{
    kn_cells_stretch_options o = options ? *options : (kn_cells_stretch_options){.mean = 0.0};
    kn_cells_spread spread;
    kn_spline h = {0};
    double bound_of_h = INFINITY;
    kn_status status = check(ctx, surface, lines, nlines, &o);
    if (status != KN_OK) return status;
    if (o.tolerance == 0.0) o.tolerance = o.degree > 0 ? INFINITY : 0.05;
    if (o.mean == 0.0) {
        status = kn_cells_measure(ctx, &spread, surface, lines, nlines);
        if (status != KN_OK) return status;
        o.mean = spread.area.mean;
    }
    if (!(o.mean > 0.0)) return kn_fail(ctx, KN_EDOMAIN, "stretch: cells of area %g", o.mean);
    stretch s = {surface, lines, nlines, o.mean, o.degree > 0 ? o.degree : 1};
    for (int last = o.degree > 0 ? o.degree : LARGEST_DEGREE; status == KN_OK && s.degree <= last; s.degree++) {
        status = interpolate(ctx, &h, &s);
        if (status == KN_OK) status = certify(ctx, &bound_of_h, &s, &h);
        if (status == KN_OK && bound_of_h <= o.tolerance) break;
    }
    if (status == KN_OK && !(bound_of_h <= o.tolerance && isfinite(bound_of_h)))
        status = kn_fail(ctx, KN_EUNDECIDED, "stretch: within %g, not %g", bound_of_h, o.tolerance);
    if (status == KN_OK) {
        kn_spline_swap(out, &h);
        *error = bound_of_h;
    }
    kn_spline_clear(ctx, &h);
    return status;
}
