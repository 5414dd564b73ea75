// SPDX-License-Identifier: Apache-2.0
// Evaluation at many points.
#include "bezier/shape.h"

kn_status kn_bezier_eval_batch(kn_ctx *ctx, double *out, const kn_bezier *b, size_t npoints, const double *at)
{
    kn_status status = kn_bezier_check_operand(ctx, "eval_batch", b);
    int dim = kn_bezier_dim(b);
    for (size_t i = 0; i < npoints && status == KN_OK; i++)
        status = kn_bezier_eval(ctx, out + i * (size_t)dim, b, at + i * (size_t)b->nvars);
    return status;
}
