// SPDX-License-Identifier: Apache-2.0
// Cell corners that move over the surface until cells are as even as they get.
#include "cells/internal.h"
#include "cells/relax.h"
#include "kernel/context.h"

#include <math.h>
#include <string.h>

static kn_status check(kn_ctx *ctx, const kn_spline *surface, const int count[2], const kn_cells_relax_options *o)
{
    kn_status status = kn_cells_expect(ctx, "relax", surface);
    if (status != KN_OK) return status;
    for (int d = 0; d < 2; d++)
        if (count[d] < 1) return kn_fail(ctx, KN_EDOMAIN, "relax: %d cells in variable %d", count[d], d);
    for (int d = 0; d < 2 && status == KN_OK; d++)
        if (o->lines[d]) status = kn_cells_expect_lines(ctx, "relax", surface, d, o->lines[d], count[d] + 1, true);
    if (status != KN_OK) return status;
    if ((size_t)count[0] > KN_MAX_COEFS / 64 / (size_t)count[1])
        return kn_fail(ctx, KN_ELIMIT, "relax: %d x %d cells", count[0], count[1]);
    if (o->iterations < 0) return kn_fail(ctx, KN_EDOMAIN, "relax: %d iterations", o->iterations);
    if (!(o->area >= 0.0) || isinf(o->area)) return kn_fail(ctx, KN_EDOMAIN, "relax: a weight %g of areas", o->area);
    return KN_OK;
}

// The bilinear spline with these corners over [0,n] in both variables.
static kn_status corners_to_map(kn_ctx *ctx, kn_spline *map, const kn_corner_grid *g)
{
    const int degree[2] = {1, 1}, count[2] = {g->n[0] + 1, g->n[1] + 1};
    double *knots[2];
    size_t n = kn_corner_count(g);
    double *coef = kn_scratch(ctx, n, 2 * sizeof *coef);
    if (!coef) return KN_ENOMEM;
    for (int d = 0; d < 2; d++) {
        knots[d] = kn_scratch(ctx, (size_t)g->n[d] + 3, sizeof *knots[d]);
        if (!knots[d]) return KN_ENOMEM;
        for (int i = 0; i <= g->n[d]; i++) knots[d][i + 1] = i;
        knots[d][0] = 0.0, knots[d][g->n[d] + 2] = g->n[d];
    }
    for (size_t k = 0; k < n; k++) coef[k] = g->corners[2 * k], coef[n + k] = g->corners[2 * k + 1];
    kn_spline s = {0};
    kn_status status = kn_spline_init(ctx, &s, 2, 2, false, degree, count,
                                      (const double *const[]){knots[0], knots[1]}, coef);
    if (status == KN_OK) kn_spline_swap(map, &s);
    kn_spline_clear(ctx, &s);
    return status;
}

kn_status kn_cells_relax(kn_ctx *ctx, kn_spline *map, const kn_spline *surface, const int count[2],
                         const kn_cells_relax_options *options)
{
    const kn_cells_relax_options none = {.iterations = 0}, *o = options ? options : &none;
    kn_status status = check(ctx, surface, count, o);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_corner_grid g = {.surface = surface, .n = {count[0], count[1]}, .closed = {o->closed[0], o->closed[1]}};
    memcpy(g.fixed, o->fixed, sizeof g.fixed);
    g.area = o->area > 0.0 ? o->area : 4.0;
    status = kn_relax_start(ctx, &g, o->lines, o->all_knots);
    if (status == KN_OK && !kn_corners_unfolded(&g, g.corners))
        status = kn_fail(ctx, KN_EUNDECIDED, "relax: %d x %d cells, too many to tell apart", count[0], count[1]);
    double *start = status == KN_OK ? kn_scratch(ctx, kn_corner_count(&g), 2 * sizeof *start) : NULL;
    if (status == KN_OK && !start) status = KN_ENOMEM;
    if (status == KN_OK) memcpy(start, g.corners, 2 * kn_corner_count(&g) * sizeof *start);
    if (status == KN_OK) status = kn_relax_search(ctx, &g, o->iterations > 0 ? o->iterations : 200);
    if (status == KN_OK) status = o->smooth ? kn_relax_smooth(ctx, map, &g, start) : corners_to_map(ctx, map, &g);
    kn_scratch_release(ctx, mark);
    return status;
}
