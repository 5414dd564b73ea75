// SPDX-License-Identifier: Apache-2.0
// The variables in another order.
#include "bezier/shape.h"
#include "kernel/array.h"

kn_status kn_bezier_permute(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const int *order)
{
    kn_status status = kn_bezier_check_operand(ctx, "permute", a);
    if (status == KN_OK && !kn_array_is_order(a->nvars, order))
        status = kn_fail(ctx, KN_EDOMAIN, "permute: not the order of %d variables", a->nvars);
    if (status != KN_OK) return status;
    kn_bezier c = *a;
    int count[KN_MAX_VARS];
    for (int d = 0; d < a->nvars; d++) count[d] = a->degree[d] + 1, c.degree[d] = a->degree[order[d]];
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_bezier_begin(ctx, &c, out, kn_bezier_is(out, a), "permute");
    if (status == KN_OK) {
        kn_array_permute(c.coef, a->coef, (size_t)a->ncomp, a->nvars, count, order);
        kn_bezier_end(ctx, out, &c);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
