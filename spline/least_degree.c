// SPDX-License-Identifier: Apache-2.0
// The least degrees of a spline.
#include "spline/reduction.h"
#include "spline/removal.h"
#include "kernel/context.h"

// Lowers var of *now as long as its distance from a stays within the tolerance; at 0, as long as elevation gives the
// same numbers again.
static kn_status lower(kn_ctx *ctx, kn_spline *now, const kn_spline *a, int var, double tolerance)
{
    kn_spline from = *now;
    for (int q = from.degree[var] - 1; q >= 0; q--) {
        kn_spline next = from;
        bool same = true;
        double error = 0.0;
        kn_status status = kn_spline_reduce_axis(ctx, &next, &same, var, q);
        if (status == KN_OK && tolerance > 0.0) status = kn_spline_reduction_error(ctx, &error, a, &next);
        if (status != KN_OK) return status;
        if (tolerance > 0.0 ? !(error <= tolerance) : !same) break;
        *now = next;
    }
    return KN_OK;
}

kn_status kn_spline_least_degree(kn_ctx *ctx, int *degree, const kn_spline *a, double tolerance)
{
    kn_status status = kn_spline_expect(ctx, "spline_least_degree", a, 0);
    if (status == KN_OK) status = kn_spline_expect_tolerance(ctx, "spline_least_degree", tolerance);
    if (status != KN_OK) return status;
    kn_spline now = *a;
    kn_mark mark = kn_scratch_mark(ctx);
    for (int d = 0; d < a->nvars && status == KN_OK; d++) status = lower(ctx, &now, a, d, tolerance);
    for (int d = 0; d < a->nvars && status == KN_OK; d++) degree[d] = now.degree[d];
    kn_scratch_release(ctx, mark);
    return status;
}
