// SPDX-License-Identifier: Apache-2.0
// The sign of a function over a box.
#include "solve/net.h"

#include "kernel/context.h"

kn_status kn_solve_sign(kn_ctx *ctx, kn_sign *out, const kn_bezier *f, const double *lo, const double *hi, int depth)
{
    if (f->coef && kn_bezier_dim(f) != 1)
        return kn_fail(ctx, KN_EDOMAIN, "sign: a function of dimension %d", kn_bezier_dim(f));
    kn_mark mark = kn_scratch_mark(ctx);
    kn_net net = {0};
    double *coef = NULL, *error = NULL;
    kn_status status = kn_predicate_start(ctx, "sign", &net, &coef, &error, f, lo, hi, depth);
    if (status == KN_OK) status = kn_predicate_sign(ctx, out, &net, coef, error, depth);
    kn_scratch_release(ctx, mark);
    return status;
}
