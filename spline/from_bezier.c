// SPDX-License-Identifier: Apache-2.0
// A spline from its Bezier pieces: the exact inverse of kn_spline_to_bezier.
#include <math.h>
#include <string.h>

#include "kernel/context.h"
#include "spline/internal.h"

static kn_status check_breaks(kn_ctx *ctx, const kn_bezier *shape, const int *nbreaks, const double *const *breaks,
                              const int *continuity)
{
    if (shape->nvars < 1) return kn_fail(ctx, KN_EDOMAIN, "spline_from_bezier: a piece without variables");
    for (int d = 0; d < shape->nvars; d++) {
        if (nbreaks[d] < 2)
            return kn_fail(ctx, KN_EDOMAIN, "spline_from_bezier: %d breaks, variable %d", nbreaks[d], d);
        if ((size_t)nbreaks[d] > KN_MAX_COEFS)
            return kn_fail(ctx, KN_ELIMIT, "spline_from_bezier: %d breaks, variable %d", nbreaks[d], d);
        if (continuity[d] < -1 || continuity[d] >= shape->degree[d])
            return kn_fail(ctx, KN_EDOMAIN, "spline_from_bezier: continuity %d, degree %d in variable %d",
                           continuity[d], shape->degree[d], d);
        if (!isfinite(breaks[d][nbreaks[d] - 1] - breaks[d][0]))
            return kn_fail(ctx, KN_EDOMAIN, "spline_from_bezier: breaks not finite in variable %d", d);
        for (int i = 1; i < nbreaks[d]; i++)
            if (!(breaks[d][i - 1] < breaks[d][i]))
                return kn_fail(ctx, KN_EDOMAIN, "spline_from_bezier: break %d of variable %d does not increase", i,
                               d);
    }
    return KN_OK;
}

static bool same_shape(const kn_bezier *a, const kn_bezier *b)
{
    return a->nvars == b->nvars && a->ncomp == b->ncomp && a->rational == b->rational &&
           memcmp(a->degree, b->degree, (size_t)a->nvars * sizeof *a->degree) == 0;
}

static kn_status fill_grid(kn_ctx *ctx, kn_grid *grid, const kn_bezier *shape, const double *const *breaks,
                           const int *continuity)
{
    for (int d = 0; d < shape->nvars; d++) {
        size_t n = (size_t)grid->nbreaks[d];
        grid->breaks[d] = kn_scratch(ctx, n, sizeof(double));
        grid->times[d] = kn_scratch(ctx, n, sizeof(int));
        if (!grid->breaks[d] || !grid->times[d]) return KN_ENOMEM;
        memcpy(grid->breaks[d], breaks[d], n * sizeof(double));
        for (size_t i = 0; i < n; i++) grid->times[d][i] = continuity[d];
        kn_grid_multiplicities(grid, d, shape->degree[d]);
    }
    return KN_OK;
}

static kn_status put_pieces(kn_ctx *ctx, kn_spline *s, const kn_bezier *pieces, const kn_grid *grid)
{
    int index[KN_MAX_VARS] = {0}, first[KN_MAX_VARS];
    size_t i = 0;
    do {
        if (!pieces[i].coef || !same_shape(&pieces[i], &pieces[0]))
            return kn_fail(ctx, KN_EDOMAIN, "spline_from_bezier: piece %zu has another shape than piece 0", i);
        for (int d = 0; d < s->nvars; d++) first[d] = index[d] * (s->degree[d] + 1);
        kn_spline_put_piece(s, &pieces[i++], first);
    } while (kn_grid_next(index, grid, s->nvars));
    return KN_OK;
}

kn_status kn_spline_from_bezier(kn_ctx *ctx, kn_spline *out, const kn_bezier *pieces, const int *nbreaks,
                                const double *const *breaks, const int *continuity)
{
    const kn_bezier *shape = &pieces[0];
    kn_status status = check_breaks(ctx, shape, nbreaks, breaks, continuity);
    if (status != KN_OK) return status;
    kn_spline s = {.nvars = shape->nvars, .ncomp = shape->ncomp, .rational = shape->rational};
    kn_grid grid;
    for (int d = 0; d < s.nvars; d++) s.degree[d] = shape->degree[d], grid.nbreaks[d] = nbreaks[d];
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_spline_pieces_in_scratch(ctx, "spline_from_bezier", &s, &grid);
    if (status == KN_OK) status = fill_grid(ctx, &grid, shape, breaks, continuity);
    if (status == KN_OK) status = put_pieces(ctx, &s, pieces, &grid);
    if (status == KN_OK) status = kn_spline_join_on_grid(ctx, &s, &grid);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    kn_scratch_release(ctx, mark);
    return status;
}
