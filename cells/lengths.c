// SPDX-License-Identifier: Apache-2.0
// Lengths of isoparametric curves, by Gauss's rule on quarters of knot spans.
#include "cells/internal.h"
#include "kernel/context.h"

enum { PANELS = 4, POINTS = 8 };

kn_status kn_cells_lengths(kn_ctx *ctx, double *length, const kn_spline *surface, int var, const double *at, int n)
{
    int nbreaks;
    double gx[POINTS], gw[POINTS], point[2 * PANELS * POINTS], value[9 * PANELS * POINTS];
    kn_mark mark = kn_scratch_mark(ctx);
    const double *b = kn_cells_breaks(ctx, &nbreaks, surface, var);
    kn_status status = b ? KN_OK : KN_ENOMEM;
    kn_cells_gauss(gx, gw, POINTS);
    for (int i = 0; status == KN_OK && i < n; i++) {
        length[i] = 0.0;
        for (int s = 0; status == KN_OK && s < nbreaks - 1; s++) {
            double step = (b[s + 1] - b[s]) / PANELS;
            for (int k = 0; k < PANELS * POINTS; k++) {
                point[2 * k + var] = b[s] + step * (k / POINTS + gx[k % POINTS]);
                point[2 * k + 1 - var] = at[i];
            }
            status = kn_spline_eval_batch_partials(ctx, value, surface, PANELS * POINTS, point);
            for (int k = 0; status == KN_OK && k < PANELS * POINTS; k++)
                length[i] += step * gw[k % POINTS] * kn_cells_norm(value + 9 * k + 3 * (1 + var));
        }
    }
    kn_scratch_release(ctx, mark);
    return status;
}
