// SPDX-License-Identifier: Apache-2.0
// A spline cut in two.
#include "spline/in_scratch.h"
#include "kernel/context.h"

kn_status kn_spline_subdivide(kn_ctx *ctx, kn_spline *left, kn_spline *right, const kn_spline *a, int var, double at)
{
    kn_status status = kn_spline_expect(ctx, "spline_subdivide", a, var);
    if (status != KN_OK) return status;
    double lo, hi;
    kn_spline_domain(a, var, &lo, &hi);
    if (!(at > lo && at < hi))
        return kn_fail(ctx, KN_EDOMAIN, "spline_subdivide: %g is not inside (%g, %g)", at, lo, hi);
    kn_spline s[2] = {*a, *a}, *outs[2] = {left, right};
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_spline_restrict_in_scratch(ctx, &s[0], var, lo, at);
    if (status == KN_OK) status = kn_spline_restrict_in_scratch(ctx, &s[1], var, at, hi);
    if (status == KN_OK) status = kn_spline_store_all(ctx, outs, s, 2);
    kn_scratch_release(ctx, mark);
    return status;
}
