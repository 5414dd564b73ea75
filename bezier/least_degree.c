// SPDX-License-Identifier: Apache-2.0
// The least degrees of a piece.
#include "bezier/reduction.h"
#include "kernel/reduce.h"

// The degree of a in var, exactly.
static int exact_degree(const kn_bezier *a, int var)
{
    double b[KN_MAX_DEGREE + 1];
    kn_axis x = kn_bezier_axis(a, var);
    int n = a->degree[var], degree = 0;
    for (size_t o = 0; o < x.outer && degree < n; o++)
        for (size_t q = 0; q < x.inner && degree < n; q++) {
            for (int i = 0; i <= n; i++) b[i] = a->coef[(o * (size_t)(n + 1) + (size_t)i) * x.inner + q];
            int own = kn_bernstein_degree(b, n);
            degree = own > degree ? own : degree;
        }
    return degree;
}

// Lowers var of *now as long as its distance from a stays within the tolerance.
static kn_status lower(kn_ctx *ctx, kn_bezier *now, const kn_bezier *a, int var, double tolerance)
{
    kn_bezier from = *now, next;
    for (int m = from.degree[var] - 1; m >= 0; m--) {
        bool exact = true;
        double error;
        kn_status status = kn_bezier_reduce_axis(ctx, &next, &exact, &from, var, m);
        if (status == KN_OK) status = kn_bezier_reduction_error(ctx, &error, a, &next);
        if (status != KN_OK) return status;
        if (!(error <= tolerance)) break;
        *now = next;
    }
    return KN_OK;
}

kn_status kn_bezier_least_degree(kn_ctx *ctx, int *degree, const kn_bezier *a, double tolerance)
{
    kn_status status = kn_bezier_check_operand(ctx, "least_degree", a);
    if (status != KN_OK) return status;
    if (!(tolerance >= 0.0)) return kn_fail(ctx, KN_EDOMAIN, "least_degree: tolerance %g", tolerance);
    kn_bezier now = *a;
    int found[KN_MAX_VARS];
    kn_mark mark = kn_scratch_mark(ctx);
    for (int d = 0; d < a->nvars && status == KN_OK; d++) {
        if (tolerance > 0.0) status = lower(ctx, &now, a, d, tolerance);
        found[d] = tolerance > 0.0 ? now.degree[d] : exact_degree(a, d);
    }
    for (int d = 0; d < a->nvars && status == KN_OK; d++) degree[d] = found[d];
    kn_scratch_release(ctx, mark);
    return status;
}
