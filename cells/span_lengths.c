// SPDX-License-Identifier: Apache-2.0
// Lengths of the knot spans of isoparametric curves, by Gauss's rule on quarters of them.
#include "cells/internal.h"
#include "kernel/context.h"

enum { PANELS = 4, POINTS = 8 };

static kn_status measure(kn_ctx *ctx, double *length, const kn_spline *surface, int var, double at, const double *b,
                         int spans)
{
    double gx[POINTS], gw[POINTS], point[2 * PANELS * POINTS], value[9 * PANELS * POINTS];
    kn_cells_gauss(gx, gw, POINTS);
    for (int s = 0; s < spans; s++) {
        double step = (b[s + 1] - b[s]) / PANELS;
        for (int k = 0; k < PANELS * POINTS; k++) {
            point[2 * k + var] = b[s] + step * (k / POINTS + gx[k % POINTS]);
            point[2 * k + 1 - var] = at;
        }
        kn_status status = kn_spline_eval_batch_partials(ctx, value, surface, PANELS * POINTS, point);
        if (status != KN_OK) return status;
        length[s] = 0.0;
        for (int k = 0; k < PANELS * POINTS; k++)
            length[s] += step * gw[k % POINTS] * kn_cells_norm(value + 9 * k + 3 * (1 + var));
    }
    return KN_OK;
}

kn_status kn_cells_span_lengths(kn_ctx *ctx, double *length, const kn_spline *surface, int var, double at)
{
    int n = 0;
    kn_status status = kn_cells_expect(ctx, "lengths", surface);
    if (status != KN_OK) return status;
    if (var < 0 || var > 1 || !isfinite(at))
        return kn_fail(ctx, KN_EDOMAIN, "lengths: variable %d of a surface, at %g", var, at);
    kn_mark mark = kn_scratch_mark(ctx);
    const double *b = kn_cells_breaks(ctx, &n, surface, var);
    double *made = b ? kn_scratch(ctx, (size_t)n, sizeof *made) : NULL;
    status = made ? measure(ctx, made, surface, var, at, b, n - 1) : KN_ENOMEM;
    for (int i = 0; status == KN_OK && i < n - 1; i++) length[i] = made[i];
    kn_scratch_release(ctx, mark);
    return status;
}
