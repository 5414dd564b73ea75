// SPDX-License-Identifier: Apache-2.0
// A spline's Bezier pieces, by knot insertion to full multiplicity.
#include "spline/internal.h"
#include "kernel/context.h"

// Every interior knot of var to multiplicity degree; those of degree + 1 stay. Neighbours then have one array.
static kn_status saturate(kn_ctx *ctx, kn_spline *s, int var)
{
    kn_grid grid;
    kn_status status = kn_spline_breaks(ctx, &grid, s, var);
    if (status != KN_OK) return status;
    int p = s->degree[var], n = grid.nbreaks[var], *times = grid.times[var];
    double *to = kn_scratch(ctx, (size_t)n * (size_t)(p + 1), sizeof *to);
    if (!to) return KN_ENOMEM;
    for (int i = 0; i < n; i++)
        if (times[i] < p) times[i] = p;
    int rows = kn_knots_repeat(to, grid.breaks[var], times, n) - p - 1;
    return rows == s->count[var] ? KN_OK : kn_spline_refine_in_scratch(ctx, s, var, to, rows);
}

static kn_status copy_pieces(kn_ctx *ctx, kn_bezier *pieces, size_t npieces, const kn_spline *s)
{
    int span[KN_MAX_VARS], first[KN_MAX_VARS];
    for (int d = 0; d < s->nvars; d++) span[d] = s->degree[d];
    for (size_t i = 0; i < npieces; i++) {
        kn_status status = kn_bezier_init(ctx, &pieces[i], s->nvars, s->ncomp, s->rational, s->degree);
        if (status != KN_OK) return status;
        for (int d = 0; d < s->nvars; d++) first[d] = span[d] - s->degree[d];
        kn_spline_get_piece(&pieces[i], s, first);
        for (int d = s->nvars - 1; d >= 0; d--) {
            span[d] = kn_knots_next_span(s->knots[d], s->degree[d], s->count[d], span[d]);
            if (span[d] < s->count[d]) break;
            span[d] = s->degree[d];
        }
    }
    return KN_OK;
}

kn_status kn_spline_to_bezier(kn_ctx *ctx, kn_bezier **pieces, size_t *npieces, const kn_spline *a)
{
    kn_status status = kn_spline_expect(ctx, "spline_to_bezier", a, 0);
    if (status != KN_OK) return status;
    size_t n = 1;
    for (int d = 0; d < a->nvars; d++) n *= (size_t)kn_spline_spans(a, d);

    kn_spline s = *a;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_bezier *all = kn_alloc_zero(ctx, n, sizeof *all);
    status = all ? KN_OK : KN_ENOMEM;
    for (int d = 0; d < a->nvars && status == KN_OK; d++) status = saturate(ctx, &s, d);
    if (status == KN_OK) status = copy_pieces(ctx, all, n, &s);
    if (status == KN_OK) {
        *pieces = all, *npieces = n;
    } else if (all) {
        for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &all[i]);
        kn_free(ctx, all);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
