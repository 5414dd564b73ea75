// SPDX-License-Identifier: Apache-2.0
// Exact division by the power of x or 1 - x that vanishes on an edge.
#include "bezier/shape.h"
#include "kernel/binomial.h"

static bool layer_is_zero(const kn_bezier *a, kn_axis x, int n, int i)
{
    for (size_t o = 0; o < x.outer; o++)
        for (size_t j = 0; j < x.inner; j++)
            if (a->coef[(o * (size_t)(n + 1) + (size_t)i) * x.inner + j] != 0.0) return false;
    return true;
}

// x^k q = p in degree n: C(n,i+k) p_(i+k) = C(n-k,i) q_i. For (1-x)^k q = p: C(n,i) p_i = C(n-k,i) q_i.
static void divide(double *q, const double *p, kn_axis x, int n, int k, int shift)
{
    for (size_t o = 0; o < x.outer; o++)
        for (int i = 0; i <= n - k; i++) {
            double over = kn_binomial(n, i + shift), under = kn_binomial(n - k, i);
            const double *from = p + (o * (size_t)(n + 1) + (size_t)(i + shift)) * x.inner;
            double *to = q + (o * (size_t)(n - k + 1) + (size_t)i) * x.inner;
            for (size_t j = 0; j < x.inner; j++) to[j] = from[j] * over / under;
        }
}

kn_status kn_bezier_divide_edge(kn_ctx *ctx, kn_bezier *out, int *order, const kn_bezier *a, int var, bool at_end)
{
    kn_status status = kn_bezier_check_operand(ctx, "divide_edge", a);
    if (status == KN_OK) status = kn_bezier_check_var(ctx, "divide_edge", a, var);
    if (status != KN_OK) return status;
    int n = a->degree[var], k = 0;
    kn_axis x = kn_bezier_axis(a, var);
    while (k <= n && layer_is_zero(a, x, n, at_end ? n - k : k)) k++;
    if (k > n) return kn_fail(ctx, KN_EUNDEFINED, "divide_edge: the piece is zero");
    kn_bezier c = *a;
    c.degree[var] = n - k;
    status = kn_bezier_alloc(ctx, &c, "divide_edge");
    if (status == KN_OK) {
        divide(c.coef, a->coef, x, n, k, at_end ? 0 : k);
        *order = k;
    }
    return kn_bezier_finish(ctx, out, &c, status);
}
