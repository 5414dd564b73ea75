// SPDX-License-Identifier: Apache-2.0
// Values and first partial derivatives at many points.
#include "bezier/eval_function.h"

kn_status kn_bezier_eval_batch_partials(kn_ctx *ctx, double *out, const kn_bezier *b, size_t npoints,
                                        const double *at)
{
    kn_status status = kn_bezier_check_operand(ctx, "eval_batch_partials", b);
    if (status != KN_OK) return status;
    if (b->nvars == 0) return kn_bezier_eval_batch(ctx, out, b, npoints, at); // a constant has no partials
    kn_bezier_function f;
    kn_bezier_as_function(&f, b);
    return kn_eval_batch(ctx, out, &f.f, npoints, at, true);
}
