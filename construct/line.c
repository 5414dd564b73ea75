// SPDX-License-Identifier: Apache-2.0
// Segments.
#include "construct/internal.h"
#include "kernel/context.h"

kn_status kn_construct_line(kn_ctx *ctx, kn_spline *out, int dim, const double *a, const double *b)
{
    if (dim < 1 || dim > KN_MAX_COMPS)
        return kn_fail(ctx, dim < 1 ? KN_EDOMAIN : KN_ELIMIT, "construct_line: dimension %d", dim);
    double points[2 * KN_MAX_COMPS];
    for (int c = 0; c < dim; c++) points[c] = a[c], points[dim + c] = b[c];
    return kn_construct_polyline(ctx, out, dim, 2, points);
}
