// SPDX-License-Identifier: Apache-2.0
// A piece run the other way in one variable.
#include "bezier/shape.h"
#include "kernel/array.h"

// B^n_i(1 - x) = B^n_(n-i)(x).
kn_status kn_bezier_reverse(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int var)
{
    kn_status status = kn_bezier_check_operand(ctx, "reverse", a);
    if (status == KN_OK) status = kn_bezier_check_var(ctx, "reverse", a, var);
    if (status != KN_OK) return status;
    kn_bezier c = *a;
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_bezier_begin(ctx, &c, out, kn_bezier_is(out, a), "reverse");
    if (status == KN_OK) {
        kn_axis x = kn_bezier_axis(a, var);
        kn_array_reverse(c.coef, a->coef, x.outer, (size_t)a->degree[var] + 1, x.inner);
        kn_bezier_end(ctx, out, &c);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
