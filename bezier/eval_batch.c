// SPDX-License-Identifier: Apache-2.0
// Evaluation at many points.
#include "bezier/shape.h"
#include "kernel/eval.h"

kn_status kn_bezier_eval_batch(kn_ctx *ctx, double *out, const kn_bezier *b, size_t npoints, const double *at)
{
    kn_status status = kn_bezier_check_operand(ctx, "eval_batch", b);
    if (status != KN_OK) return status;
    const double *unit[KN_MAX_VARS] = {NULL}; // no knots: over [0,1]
    int count[KN_MAX_VARS];
    for (int d = 0; d < b->nvars; d++) count[d] = b->degree[d] + 1;
    kn_eval_function f = {.nvars = b->nvars,
                          .ncomp = b->ncomp,
                          .rational = b->rational,
                          .degree = b->degree,
                          .count = count,
                          .knots = unit,
                          .coef = b->coef};
    if (b->nvars > 0) return kn_eval_batch(ctx, out, &f, npoints, at);
    for (size_t i = 0; i < npoints && status == KN_OK; i++) // a constant
        status = kn_bezier_eval(ctx, out + i * (size_t)kn_bezier_dim(b), b, at);
    return status;
}
