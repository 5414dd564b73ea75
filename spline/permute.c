// SPDX-License-Identifier: Apache-2.0
// The variables of a spline in another order.
#include "kernel/array.h"
#include "kernel/context.h"
#include "spline/internal.h"

kn_status kn_spline_permute(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const int *order)
{
    kn_status status = kn_spline_expect(ctx, "spline_permute", a, 0);
    if (status != KN_OK) return status;
    if (!kn_array_is_order(a->nvars, order))
        return kn_fail(ctx, KN_EDOMAIN, "spline_permute: not the order of %d variables", a->nvars);
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline s = *a;
    for (int d = 0; d < a->nvars; d++) {
        s.degree[d] = a->degree[order[d]], s.count[d] = a->count[order[d]];
        s.knots[d] = a->knots[order[d]];
    }
    s.coef = kn_scratch(ctx, kn_spline_count(a) * (size_t)a->ncomp, sizeof *s.coef);
    status = s.coef ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        kn_array_permute(s.coef, a->coef, (size_t)a->ncomp, a->nvars, a->count, order);
        status = kn_spline_store(ctx, out, &s);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
