// SPDX-License-Identifier: Apache-2.0
// S(map) without approximation.
#include "cells/internal.h"
#include "kernel/context.h"

#include <knurl/compose.h>
#include <math.h>

// KN_OK where all coefficients of the map in each cell lie between two neighbouring knots of S, but for 2^-40 of the
// largest parameter, which is what kn_spline_compose does not count.
static kn_status check_cells(kn_ctx *ctx, const kn_spline *surface, const kn_bezier *pieces, size_t npieces,
                             int columns)
{
    for (int d = 0; d < 2; d++) {
        int n;
        double *breaks = kn_cells_breaks(ctx, &n, surface, d);
        if (!breaks) return KN_ENOMEM;
        double slack = 0x1p-40 * fmax(fabs(breaks[0]), fabs(breaks[n - 1]));
        for (size_t cell = 0; cell < npieces; cell++) {
            size_t count = kn_bezier_count(&pieces[cell]);
            const double *x = pieces[cell].coef + (size_t)d * count;
            double lo = x[0], hi = x[0];
            for (size_t k = 1; k < count; k++) lo = fmin(lo, x[k]), hi = fmax(hi, x[k]);
            for (int i = 1; i + 1 < n; i++)
                if (breaks[i] > lo + slack && breaks[i] < hi - slack)
                    return kn_fail(ctx, KN_EDOMAIN,
                                   "compose: cell (%zu,%zu) crosses the knot %g in variable %d; it can be fitted",
                                   cell / (size_t)columns, cell % (size_t)columns, breaks[i], d);
        }
    }
    return KN_OK;
}

kn_status kn_cells_compose(kn_ctx *ctx, kn_spline *out, const kn_spline *surface, const kn_spline *map)
{
    kn_status status = kn_cells_expect(ctx, "compose", surface);
    if (status == KN_OK) status = kn_cells_expect_map(ctx, "compose", surface, map);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_bezier *pieces = NULL;
    size_t n = 0;
    status = kn_spline_to_bezier(ctx, &pieces, &n, map);
    if (status == KN_OK) status = check_cells(ctx, surface, pieces, n, kn_spline_spans(map, 1));
    for (size_t k = 0; k < n; k++) kn_bezier_clear(ctx, &pieces[k]);
    kn_free(ctx, pieces);
    kn_scratch_release(ctx, mark);
    return status == KN_OK ? kn_spline_compose(ctx, out, surface, map) : status;
}
