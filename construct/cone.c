// SPDX-License-Identifier: Apache-2.0
// Cones and frusta.
#include <math.h>

#include "construct/internal.h"
#include "kernel/context.h"

kn_status kn_construct_cone(kn_ctx *ctx, kn_spline *out, const double base[3], const double axis[3],
                            double base_radius, double top_radius)
{
    static const char call[] = "construct_cone";
    if (!(base_radius >= 0.0 && top_radius >= 0.0 && base_radius + top_radius > 0.0 &&
          isfinite(base_radius + top_radius)))
        return kn_fail(ctx, KN_EDOMAIN, "%s: radii %g and %g", call, base_radius, top_radius);
    double x[3], y[3], unit[3];
    kn_status status = kn_construct_finite(ctx, call, base, 3);
    if (status == KN_OK) status = kn_construct_frame(ctx, call, x, y, unit, axis);
    if (status != KN_OK) return status;
    const kn_profile p = {1, 2, {base_radius, top_radius}, {0.0, 1.0}, {1.0, 1.0}, {0.0, 0.0, 1.0, 1.0}};
    return kn_construct_lathe(ctx, call, out, &p, base, axis, x, y);
}
