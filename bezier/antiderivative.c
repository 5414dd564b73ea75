// SPDX-License-Identifier: Apache-2.0
// The antiderivative as a piece.
#include "bezier/shape.h"
#include "kernel/calculus.h"

kn_status kn_bezier_antiderivative(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int var)
{
    kn_status status = kn_bezier_check_operand(ctx, "antiderivative", a);
    if (status == KN_OK) status = kn_bezier_check_var(ctx, "antiderivative", a, var);
    if (status != KN_OK) return status;
    if (a->rational) return kn_fail(ctx, KN_EDOMAIN, "antiderivative: that of a rational piece is none");
    kn_bezier c = *a;
    c.degree[var]++;
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_bezier_begin(ctx, &c, out, kn_bezier_is(out, a), "antiderivative");
    if (status == KN_OK) {
        kn_axis x = kn_bezier_axis(a, var);
        kn_bernstein_integrate(c.coef, a->coef, x.outer, a->degree[var], x.inner);
        kn_bezier_end(ctx, out, &c);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
