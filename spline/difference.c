// SPDX-License-Identifier: Apache-2.0
// Differences of splines.
#include "spline/combine.h"

kn_status kn_spline_difference(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b)
{
    return kn_spline_add(ctx, "spline_difference", out, a, b, -1.0);
}
