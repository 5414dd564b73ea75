// SPDX-License-Identifier: Apache-2.0
// Whole circles.
#include <math.h>

#include "construct/internal.h"
#include "kernel/context.h"

kn_status kn_construct_circle(kn_ctx *ctx, kn_spline *out, const double center[3], const double normal[3],
                              double radius)
{
    double x[3], y[3], unit[3];
    if (!(radius > 0.0 && isfinite(radius)))
        return kn_fail(ctx, KN_EDOMAIN, "construct_circle: a radius of %g", radius);
    kn_status status = kn_construct_frame(ctx, "construct_circle", x, y, unit, normal);
    if (status != KN_OK) return status;
    for (int c = 0; c < 3; c++) x[c] *= radius, y[c] *= radius;
    return kn_construct_arc(ctx, out, center, x, y, KN_WHOLE_TURN);
}
