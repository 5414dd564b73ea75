// SPDX-License-Identifier: Apache-2.0
// The values of a spline on a grid.
#include "spline/eval_function.h"

kn_status kn_spline_eval_grid(kn_ctx *ctx, double *out, const kn_spline *s, const size_t *n, const double *const *at)
{
    kn_status status = kn_spline_expect(ctx, "spline_eval_grid", s, 0);
    if (status != KN_OK) return status;
    const double *knots[KN_MAX_VARS];
    kn_eval_function f;
    kn_spline_as_function(&f, knots, s);
    return kn_eval_grid(ctx, out, &f, n, at);
}
