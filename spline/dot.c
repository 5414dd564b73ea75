// SPDX-License-Identifier: Apache-2.0
// Scalar products of splines, piece by piece.
#include "spline/internal.h"

static kn_status op(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b, const double *size,
                    const void *user)
{
    (void)size, (void)user;
    return kn_bezier_dot(ctx, out, a, b);
}

kn_status kn_spline_dot(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b)
{
    return kn_spline_by_pieces(ctx, "spline_dot", out, a, b, op, NULL, -1);
}
