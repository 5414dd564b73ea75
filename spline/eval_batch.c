// SPDX-License-Identifier: Apache-2.0
// The values of a spline at many points.
#include "spline/eval_function.h"

kn_status kn_spline_eval_batch(kn_ctx *ctx, double *out, const kn_spline *s, size_t npoints, const double *at)
{
    kn_status status = kn_spline_expect(ctx, "spline_eval_batch", s, 0);
    if (status != KN_OK) return status;
    const double *knots[KN_MAX_VARS];
    kn_eval_function f;
    kn_spline_as_function(&f, knots, s);
    return kn_eval_batch(ctx, out, &f, npoints, at, false);
}
