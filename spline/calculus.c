// SPDX-License-Identifier: Apache-2.0
// Partial derivatives of a spline on one grid that holds them all.
#include <string.h>

#include "kernel/context.h"
#include "spline/calculus.h"

kn_status kn_spline_partial_knots(kn_ctx *ctx, kn_spline *to, const kn_spline *a)
{
    *to = *a;
    to->coef = NULL;
    for (int d = 0; d < a->nvars; d++) {
        int p = a->degree[d], last = a->count[d] + p, n = 0;
        const double *t = a->knots[d];
        double *knots = kn_scratch(ctx, 2 * ((size_t)last + 1), sizeof *knots);
        if (!knots) return KN_ENOMEM;
        for (int i = 0, times = 1; i <= last; i++, times++) {
            knots[n++] = t[i];
            if (i < last && t[i + 1] == t[i]) continue;
            if (times <= p) knots[n++] = t[i];
            times = 0;
        }
        to->knots[d] = knots, to->count[d] = n - p - 1;
    }
    return KN_OK;
}

// The derivative has the knots of a, at most `degree` times each, and is raised to a's degree: every knot once more.
static kn_status differentiate(kn_ctx *ctx, kn_spline *s, int var, const kn_spline *grid)
{
    int p = s->degree[var], rows = grid->count[var];
    kn_band band;
    kn_status status = kn_spline_differentiate_in_scratch(ctx, s, var);
    if (status == KN_OK) status = kn_spline_band(ctx, &band, rows, p);
    if (status != KN_OK) return status;
    kn_band_elevate(&band, s->knots[var], p - 1, s->count[var], grid->knots[var]);
    return kn_spline_map_in_scratch(ctx, s, var, p, grid->knots[var], &band);
}

kn_status kn_spline_partial(kn_ctx *ctx, double *out, const kn_spline *a, int comp, int var, const kn_spline *grid)
{
    size_t n = kn_spline_count(grid);
    if (a->degree[var] == 0) {
        memset(out, 0, n * sizeof *out);
        return KN_OK;
    }
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline s = *a;
    s.ncomp = 1, s.rational = false;
    s.coef += (size_t)comp * kn_spline_count(a);
    kn_status status = differentiate(ctx, &s, var, grid);
    for (int d = 0; d < a->nvars && status == KN_OK; d++)
        if (d != var) status = kn_spline_refine_in_scratch(ctx, &s, d, grid->knots[d], grid->count[d]);
    if (status == KN_OK) memcpy(out, s.coef, n * sizeof *out);
    kn_scratch_release(ctx, mark);
    return status;
}
