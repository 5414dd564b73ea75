// SPDX-License-Identifier: Apache-2.0
// Multiplication by a number.
#include "bezier/shape.h"

kn_status kn_bezier_scale(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, double factor)
{
    kn_status status = kn_bezier_check_operand(ctx, "scale", a);
    if (status == KN_OK) status = kn_bezier_store(ctx, out, a);
    if (status != KN_OK) return status;
    size_t n = (size_t)kn_bezier_dim(out) * kn_bezier_count(out);
    for (size_t i = 0; i < n; i++) out->coef[i] *= factor;
    return KN_OK;
}
