// SPDX-License-Identifier: Apache-2.0
// Splines in the making, in scratch.
#include "spline/view.h"

#include <limits.h>
#include <string.h>

#include "kernel/context.h"

kn_status kn_view_band(kn_ctx *ctx, kn_band *band, int rows, int width)
{
    *band = (kn_band){.rows = rows, .width = width};
    band->first = kn_scratch(ctx, (size_t)rows, sizeof *band->first);
    band->terms = band->first ? kn_scratch(ctx, (size_t)rows, sizeof *band->terms) : NULL;
    band->w = band->terms ? kn_scratch(ctx, (size_t)rows * (size_t)width, sizeof *band->w) : NULL;
    return band->w ? KN_OK : KN_ENOMEM;
}

kn_status kn_view_map(kn_ctx *ctx, kn_spline *view, int var, int degree, double *knots, const kn_band *band)
{
    kn_spline to = *view;
    to.degree[var] = degree, to.count[var] = band->rows, to.knots[var] = knots;
    kn_status status = kn_spline_shape(ctx, "spline", to.nvars, to.ncomp, to.rational, to.degree, to.count);
    if (status != KN_OK) return status;
    to.coef = kn_scratch(ctx, kn_spline_count(&to) * (size_t)to.ncomp, sizeof *to.coef);
    if (!to.coef) return KN_ENOMEM;
    kn_band_apply(to.coef, band, view->coef, kn_spline_outer(view, var), view->count[var],
                  kn_spline_inner(view, var));
    *view = to;
    return KN_OK;
}

kn_status kn_view_refine(kn_ctx *ctx, kn_spline *view, int var, double *to, int rows)
{
    kn_band band;
    int p = view->degree[var];
    kn_status status = kn_view_band(ctx, &band, rows, p + 1);
    if (status != KN_OK) return status;
    kn_band_refine(&band, view->knots[var], p, view->count[var], to);
    return kn_view_map(ctx, view, var, p, to, &band);
}

// The union of the knots of `t` with each break once more.
static int raise_knots(double *to, const double *knots, int nknots)
{
    int n = 0;
    for (int i = 0; i < nknots; i++) {
        to[n++] = knots[i];
        if (i + 1 == nknots || knots[i + 1] > knots[i]) to[n++] = knots[i];
    }
    return n;
}

// sum = the band `then` after the band `now`, weights and divisors multiplied. No weight is negative, so a zero is
// exact; by uniqueness of coefficients what is not zero fits into `then`'s span of the first spline, width wide.
static void compose(kn_band *both, const kn_band *then, const kn_band *now, int width)
{
    double sum[2 * KN_MAX_DEGREE + 3];
    both->divisor = (then->divisor != 0.0 ? then->divisor : 1.0) * (now->divisor != 0.0 ? now->divisor : 1.0);
    for (int i = 0; i < then->rows; i++) {
        const double *w = then->w + (size_t)i * (size_t)then->width;
        int lowest = INT_MAX, end = 0;
        for (int k = 0; k < then->terms[i]; k++) {
            int row = then->first[i] + k, first = now->first[row], last = first + now->terms[row];
            lowest = first < lowest ? first : lowest;
            end = last > end ? last : end;
        }
        for (int k = 0; k < end - lowest; k++) sum[k] = 0.0;
        for (int k = 0; k < then->terms[i]; k++) {
            int row = then->first[i] + k, n = now->terms[row];
            const double *v = now->w + (size_t)row * (size_t)now->width;
            double factor = n == 1 ? w[k] * now->divisor : w[k]; // a copy's weight 1 stands for the divisor
            for (int q = 0; q < n; q++) sum[now->first[row] - lowest + q] += factor * v[q];
        }
        both->first[i] = lowest, both->terms[i] = end - lowest;
        if (both->terms[i] == 1) sum[0] = 1.0;
        memcpy(both->w + (size_t)i * (size_t)width, sum, (size_t)both->terms[i] * sizeof *sum);
    }
}

kn_status kn_view_elevate(kn_ctx *ctx, kn_spline *view, int var, int degree)
{
    int p = view->degree[var], n = view->count[var] + p + 1, spans = kn_spline_spans(view, var), count = n - p - 1;
    double *knots = view->knots[var];
    kn_band band = {0};
    for (int q = p; q < degree; q++) {
        kn_band step, both;
        if (n > INT_MAX - spans - 1) return kn_fail(ctx, KN_ELIMIT, "spline: too many knots");
        double *to = kn_scratch(ctx, (size_t)n + (size_t)spans + 1, sizeof *to);
        if (!to) return KN_ENOMEM;
        n = raise_knots(to, knots, n);
        kn_status status = kn_view_band(ctx, &step, n - q - 2, q + 1);
        if (status != KN_OK) return status;
        kn_band_elevate(&step, knots, q, count, to);
        knots = to, count = step.rows;
        if (q > p) {
            status = kn_view_band(ctx, &both, step.rows, p + 1);
            if (status != KN_OK) return status;
            compose(&both, &step, &band, p + 1);
            step = both;
        }
        band = step;
    }
    return degree > p ? kn_view_map(ctx, view, var, degree, knots, &band) : KN_OK;
}

kn_status kn_view_union(kn_ctx *ctx, kn_spline *view, int var, const double *more, int n)
{
    int p = view->degree[var], have = view->count[var] + p + 1;
    int total = kn_knots_union(NULL, view->knots[var], have, more, n);
    if (total == have) return KN_OK;
    double *to = kn_scratch(ctx, (size_t)total, sizeof *to);
    if (!to) return KN_ENOMEM;
    kn_knots_union(to, view->knots[var], have, more, n);
    return kn_view_refine(ctx, view, var, to, total - p - 1);
}

static bool same_sizes(const kn_spline *a, const kn_spline *b)
{
    if (a->nvars != b->nvars || a->ncomp != b->ncomp) return false;
    for (int d = 0; d < a->nvars; d++)
        if (a->degree[d] != b->degree[d] || a->count[d] != b->count[d]) return false;
    return true;
}

kn_status kn_view_store(kn_ctx *ctx, kn_spline *out, const kn_spline *view)
{
    kn_spline to = *out;
    bool reuse = same_sizes(out, view);
    if (!reuse) {
        kn_status status = kn_spline_alloc(ctx, &to, view->nvars, view->ncomp, view->rational, view->degree,
                                           view->count);
        if (status != KN_OK) return status;
    }
    for (int d = 0; d < view->nvars; d++)
        if (to.knots[d] != view->knots[d])
            memcpy(to.knots[d], view->knots[d],
                   ((size_t)view->count[d] + (size_t)view->degree[d] + 1) * sizeof *to.knots[d]);
    if (to.coef != view->coef)
        memcpy(to.coef, view->coef, kn_spline_count(view) * (size_t)view->ncomp * sizeof *to.coef);
    to.rational = view->rational;
    if (!reuse) kn_spline_clear(ctx, out);
    *out = to;
    return KN_OK;
}
