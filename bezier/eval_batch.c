// SPDX-License-Identifier: Apache-2.0
// Evaluation at many points.
#include "bezier/eval_function.h"

kn_status kn_bezier_eval_batch(kn_ctx *ctx, double *out, const kn_bezier *b, size_t npoints, const double *at)
{
    kn_status status = kn_bezier_check_operand(ctx, "eval_batch", b);
    if (status != KN_OK) return status;
    for (size_t i = 0; b->nvars == 0 && i < npoints && status == KN_OK; i++) // a constant
        status = kn_bezier_eval(ctx, out + i * (size_t)kn_bezier_dim(b), b, at);
    if (b->nvars == 0) return status;
    kn_bezier_function f;
    kn_bezier_as_function(&f, b);
    return kn_eval_batch(ctx, out, &f.f, npoints, at, false);
}
