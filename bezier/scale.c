// SPDX-License-Identifier: Apache-2.0
// Multiplication by a number.
#include "bezier/shape.h"

kn_status kn_bezier_scale(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, double factor)
{
    kn_bezier c = {0};
    kn_status status = kn_bezier_check_operand(ctx, "scale", a);
    if (status == KN_OK) status = kn_bezier_copy(ctx, &c, a);
    if (status == KN_OK) {
        size_t n = (size_t)kn_bezier_dim(&c) * kn_bezier_count(&c);
        for (size_t i = 0; i < n; i++) c.coef[i] *= factor;
    }
    return kn_bezier_finish(ctx, out, &c, status);
}
