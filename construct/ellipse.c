// SPDX-License-Identifier: Apache-2.0
// Whole ellipses.
#include "construct/internal.h"

kn_status kn_construct_ellipse(kn_ctx *ctx, kn_spline *out, const double center[3], const double x[3],
                               const double y[3])
{
    return kn_construct_arc(ctx, out, center, x, y, KN_WHOLE_TURN);
}
