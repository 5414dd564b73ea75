// SPDX-License-Identifier: Apache-2.0
// Products of splines, piece by piece.
#include "spline/internal.h"

static kn_status op(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b, const double *size,
                    const void *user)
{
    (void)size, (void)user;
    return kn_bezier_product(ctx, out, a, b);
}

kn_status kn_spline_product(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b)
{
    return kn_spline_by_pieces(ctx, "spline_product", out, a, b, op, NULL, -1);
}
