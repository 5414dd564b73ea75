// SPDX-License-Identifier: Apache-2.0
// Tori.
#include <math.h>

#include "construct/internal.h"
#include "kernel/context.h"

kn_status kn_construct_torus(kn_ctx *ctx, kn_spline *out, const double center[3], const double axis[3], double major,
                             double minor)
{
    static const char call[] = "construct_torus";
    if (!(0.0 < minor && minor < major && isfinite(major)))
        return kn_fail(ctx, KN_EDOMAIN, "%s: radii %g and %g", call, major, minor);
    double x[3], y[3], z[3];
    kn_turn turn;
    kn_status status = kn_construct_finite(ctx, call, center, 3);
    if (status == KN_OK) status = kn_construct_frame(ctx, call, x, y, z, axis);
    if (status == KN_OK) status = kn_construct_turn(ctx, call, &turn, KN_WHOLE_TURN);
    if (status != KN_OK) return status;
    kn_profile p = {.degree = 2, .n = turn.n};
    for (int i = 0; i < turn.n; i++)
        p.rho[i] = turn.w[i] * major + minor * turn.c[i], p.z[i] = minor * turn.s[i], p.w[i] = turn.w[i];
    for (int i = 0; i < turn.n + 3; i++) p.knots[i] = turn.knots[i];
    return kn_construct_lathe(ctx, call, out, &p, center, z, x, y);
}
