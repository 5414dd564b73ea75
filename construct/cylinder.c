// SPDX-License-Identifier: Apache-2.0
// Cylinders.
#include <math.h>

#include "construct/internal.h"
#include "kernel/context.h"

kn_status kn_construct_cylinder(kn_ctx *ctx, kn_spline *out, const double base[3], const double axis[3],
                                double radius)
{
    if (!(radius > 0.0 && isfinite(radius)))
        return kn_fail(ctx, KN_EDOMAIN, "construct_cylinder: a radius of %g", radius);
    return kn_construct_cone(ctx, out, base, axis, radius, radius);
}
