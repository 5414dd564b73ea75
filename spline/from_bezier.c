// SPDX-License-Identifier: Apache-2.0
// A spline from its Bezier pieces: the exact inverse of kn_spline_to_bezier.
#include <limits.h>
#include <math.h>
#include <string.h>

#include "kernel/context.h"
#include "spline/combine.h"

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

static kn_status make_grid(kn_ctx *ctx, kn_grid *grid, const kn_bezier *shape, const int *nbreaks,
                           const double *const *breaks, const int *continuity)
{
    for (int d = 0; d < shape->nvars; d++) {
        size_t n = (size_t)nbreaks[d];
        grid->nbreaks[d] = nbreaks[d];
        grid->breaks[d] = kn_scratch(ctx, n, sizeof(double));
        grid->times[d] = kn_scratch(ctx, n, sizeof(int));
        if (!grid->breaks[d] || !grid->times[d]) return KN_ENOMEM;
        memcpy(grid->breaks[d], breaks[d], n * sizeof(double));
        for (size_t i = 0; i < n; i++) grid->times[d][i] = shape->degree[d] - continuity[d];
        grid->times[d][0] = grid->times[d][n - 1] = shape->degree[d] + 1;
    }
    return KN_OK;
}

static kn_status put_pieces(kn_ctx *ctx, kn_spline *s, const kn_bezier *pieces, const kn_grid *grid)
{
    int index[KN_MAX_VARS] = {0}, first[KN_MAX_VARS];
    for (size_t i = 0;; i++) {
        if (!pieces[i].coef || !same_shape(&pieces[i], &pieces[0]))
            return kn_fail(ctx, KN_EDOMAIN, "spline_from_bezier: piece %zu has another shape than piece 0", i);
        for (int d = 0; d < s->nvars; d++) first[d] = index[d] * (s->degree[d] + 1);
        kn_spline_put_piece(s, &pieces[i], first);
        int d = s->nvars - 1;
        while (d >= 0 && ++index[d] == grid->nbreaks[d] - 1) index[d--] = 0;
        if (d < 0) return KN_OK;
    }
}

kn_status kn_spline_from_bezier(kn_ctx *ctx, kn_spline *out, const kn_bezier *pieces, const int *nbreaks,
                                const double *const *breaks, const int *continuity)
{
    const kn_bezier *shape = &pieces[0];
    kn_status status = check_breaks(ctx, shape, nbreaks, breaks, continuity);
    if (status != KN_OK) return status;
    kn_spline s = {.nvars = shape->nvars, .ncomp = shape->ncomp, .rational = shape->rational};
    kn_grid grid;
    for (int d = 0; d < s.nvars; d++) {
        s.degree[d] = shape->degree[d];
        if (nbreaks[d] - 1 > INT_MAX / (s.degree[d] + 1))
            return kn_fail(ctx, KN_ELIMIT, "spline_from_bezier: %d breaks, variable %d", nbreaks[d], d);
        s.count[d] = (nbreaks[d] - 1) * (s.degree[d] + 1);
    }
    kn_mark mark = kn_scratch_mark(ctx);
    status = make_grid(ctx, &grid, shape, nbreaks, breaks, continuity);
    if (status == KN_OK) status = kn_spline_in_scratch(ctx, "spline_from_bezier", &s);
    if (status == KN_OK) status = put_pieces(ctx, &s, pieces, &grid);
    if (status == KN_OK) status = kn_spline_join_on_grid(ctx, &s, &grid);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    kn_scratch_release(ctx, mark);
    return status;
}
