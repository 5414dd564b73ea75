// SPDX-License-Identifier: Apache-2.0
// The integral of a spline over its domain.
#include "kernel/array.h"
#include "kernel/context.h"
#include "spline/internal.h"

// The integral of a B-spline is (t_(i+p+1) - t_i) / (p + 1) (de Boor, A Practical Guide to Splines, ch. X); the
// divisors, whose product is below 2^53, come last.
kn_status kn_spline_integral(kn_ctx *ctx, double *out, const kn_spline *a)
{
    kn_status status = kn_spline_expect(ctx, "spline_integral", a, 0);
    if (status != KN_OK) return status;
    if (a->rational) return kn_fail(ctx, KN_EDOMAIN, "spline_integral: of a rational spline");
    kn_mark mark = kn_scratch_mark(ctx);
    const double *weight[KN_MAX_VARS];
    double divisor = 1.0;
    for (int d = 0; d < a->nvars && status == KN_OK; d++) {
        int p = a->degree[d];
        double *length = kn_scratch(ctx, (size_t)a->count[d], sizeof *length);
        if (!length) status = KN_ENOMEM;
        for (int i = 0; i < a->count[d] && length; i++) length[i] = a->knots[d][i + p + 1] - a->knots[d][i];
        weight[d] = length;
        divisor *= p + 1;
    }
    for (int c = 0; c < a->ncomp && status == KN_OK; c++)
        out[c] = kn_array_weighted_sum(a->coef + (size_t)c * kn_spline_count(a), a->nvars, a->count, weight) /
                 divisor;
    kn_scratch_release(ctx, mark);
    return status;
}
