// SPDX-License-Identifier: Apache-2.0
// A copy of a spline.
#include "spline/internal.h"

kn_status kn_spline_copy(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    static const kn_spline empty = {0};
    return kn_spline_store(ctx, out, a->nvars > 0 ? a : &empty);
}
