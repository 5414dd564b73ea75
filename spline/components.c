// SPDX-License-Identifier: Apache-2.0
// Some components of a spline.
#include "kernel/context.h"
#include "spline/internal.h"

kn_status kn_spline_components(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int first, int count)
{
    kn_status status = kn_spline_expect(ctx, "spline_components", a, 0);
    if (status != KN_OK) return status;
    if (first < 0 || count < 1 || first > a->ncomp - count)
        return kn_fail(ctx, KN_EDOMAIN, "spline_components: %d from %d on, of %d", count, first, a->ncomp);
    kn_spline s = *a;
    s.ncomp = count;
    s.rational = false;
    s.coef += (size_t)first * kn_spline_count(a);
    return kn_spline_store(ctx, out, &s);
}
