// SPDX-License-Identifier: Apache-2.0
// Degree reduction of splines.
#include "spline/reduction.h"
#include "kernel/context.h"

kn_status kn_spline_reduce(kn_ctx *ctx, kn_spline *out, double *error, const kn_spline *a, const int *degree)
{
    kn_status status = kn_spline_expect(ctx, "spline_reduce", a, 0);
    if (status != KN_OK) return status;
    kn_spline s = *a;
    double bound = 0.0;
    bool same = true, lower = false;
    for (int d = 0; d < a->nvars; d++) {
        if (degree[d] < 0 || degree[d] > a->degree[d])
            return kn_fail(ctx, KN_EDOMAIN, "spline_reduce: degree %d to %d in variable %d", a->degree[d], degree[d],
                           d);
        lower = lower || degree[d] < a->degree[d];
    }
    kn_mark mark = kn_scratch_mark(ctx);
    for (int d = 0; d < a->nvars && status == KN_OK; d++)
        if (degree[d] < a->degree[d]) status = kn_spline_reduce_axis(ctx, &s, &same, d, degree[d]);
    if (status == KN_OK && error && lower) status = kn_spline_reduction_error(ctx, &bound, a, &s);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    if (status == KN_OK && error) *error = bound;
    kn_scratch_release(ctx, mark);
    return status;
}
