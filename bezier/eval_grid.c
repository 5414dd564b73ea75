// SPDX-License-Identifier: Apache-2.0
// Evaluation on a grid.
#include "bezier/eval_function.h"

kn_status kn_bezier_eval_grid(kn_ctx *ctx, double *out, const kn_bezier *b, const size_t *n, const double *const *at)
{
    kn_status status = kn_bezier_check_operand(ctx, "eval_grid", b);
    if (status != KN_OK) return status;
    if (b->nvars == 0) return kn_bezier_eval_batch(ctx, out, b, 1, NULL); // the grid of no variables: one point
    kn_bezier_function f;
    kn_bezier_as_function(&f, b);
    return kn_eval_grid(ctx, out, &f.f, n, at);
}
