// SPDX-License-Identifier: Apache-2.0
// Spheres.
#include <math.h>

#include "construct/internal.h"
#include "kernel/context.h"

// The profile is half a turn from angle -pi/2 on: (cos, sin)(t - pi/2) = (sin t, -cos t).
kn_status kn_construct_sphere(kn_ctx *ctx, kn_spline *out, const double center[3], double radius)
{
    static const char call[] = "construct_sphere";
    static const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0};
    if (!(radius > 0.0 && isfinite(radius))) return kn_fail(ctx, KN_EDOMAIN, "%s: a radius of %g", call, radius);
    kn_turn half;
    kn_status status = kn_construct_finite(ctx, call, center, 3);
    if (status == KN_OK) status = kn_construct_turn(ctx, call, &half, 2.0 * KN_QUARTER_TURN);
    if (status != KN_OK) return status;
    kn_profile p = {.degree = 2, .n = half.n};
    for (int i = 0; i < half.n; i++) p.rho[i] = radius * half.s[i], p.z[i] = -radius * half.c[i], p.w[i] = half.w[i];
    for (int i = 0; i < half.n + 3; i++) p.knots[i] = half.knots[i];
    return kn_construct_lathe(ctx, call, out, &p, center, z, x, y);
}
