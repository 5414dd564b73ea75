// SPDX-License-Identifier: Apache-2.0
// Lines at equal steps in each knot span.
#include "cells/internal.h"
#include "kernel/context.h"

kn_status kn_cells_uniform_lines(kn_ctx *ctx, double **lines, const kn_spline *surface, int var, int count)
{
    kn_status status = kn_cells_expect(ctx, "uniform lines", surface);
    if (status == KN_OK) status = kn_cells_expect_count(ctx, "uniform lines", surface, var, count);
    if (status != KN_OK) return status;
    int n;
    kn_mark mark = kn_scratch_mark(ctx);
    double *breaks = kn_cells_breaks(ctx, &n, surface, var);
    int *parts = breaks ? kn_scratch(ctx, (size_t)n, sizeof *parts) : NULL;
    double *line = parts ? kn_alloc(ctx, (size_t)count + 1, sizeof *line) : NULL;
    if (line) {
        int at = 0;
        kn_cells_share(parts, breaks, n - 1, count);
        for (int i = 0; i < n - 1; i++)
            for (int j = 0; j < parts[i]; j++)
                line[at++] = breaks[i] + (breaks[i + 1] - breaks[i]) * ((double)j / parts[i]);
        line[at] = breaks[n - 1];
        *lines = line;
    }
    kn_scratch_release(ctx, mark);
    return line ? KN_OK : KN_ENOMEM;
}
