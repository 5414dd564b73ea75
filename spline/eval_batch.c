// SPDX-License-Identifier: Apache-2.0
// The values of a spline at many points.
#include "spline/internal.h"
#include "kernel/context.h"
#include "kernel/eval.h"

kn_status kn_spline_eval_batch(kn_ctx *ctx, double *out, const kn_spline *s, size_t npoints, const double *at)
{
    kn_status status = kn_spline_expect(ctx, "spline_eval_batch", s, 0);
    if (status != KN_OK) return status;
    const double *knots[KN_MAX_VARS];
    for (int d = 0; d < s->nvars; d++) knots[d] = s->knots[d];
    kn_eval_function f = {.nvars = s->nvars,
                          .ncomp = s->ncomp,
                          .rational = s->rational,
                          .degree = s->degree,
                          .count = s->count,
                          .knots = knots,
                          .coef = s->coef};
    return kn_eval_batch(ctx, out, &f, npoints, at);
}
