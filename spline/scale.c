// SPDX-License-Identifier: Apache-2.0
// Multiplication of a spline by a number.
#include "spline/internal.h"

kn_status kn_spline_scale(kn_ctx *ctx, kn_spline *out, const kn_spline *a, double factor)
{
    kn_status status = kn_spline_expect(ctx, "spline_scale", a, 0);
    if (status == KN_OK) status = kn_spline_store(ctx, out, a);
    if (status != KN_OK) return status;
    size_t n = (size_t)kn_spline_dim(out) * kn_spline_count(out);
    for (size_t i = 0; i < n; i++) out->coef[i] *= factor;
    return KN_OK;
}
