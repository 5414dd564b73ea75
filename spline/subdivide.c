// SPDX-License-Identifier: Apache-2.0
// A spline cut in two.
#include "spline/internal.h"
#include "kernel/context.h"

kn_status kn_spline_subdivide(kn_ctx *ctx, kn_spline *left, kn_spline *right, const kn_spline *a, int var, double at)
{
    kn_status status = kn_spline_expect(ctx, "spline_subdivide", a, var);
    if (status != KN_OK) return status;
    double lo[KN_MAX_VARS], hi[KN_MAX_VARS];
    for (int d = 0; d < a->nvars; d++) kn_spline_domain(a, d, &lo[d], &hi[d]);
    if (!(at > lo[var] && at < hi[var]))
        return kn_fail(ctx, KN_EDOMAIN, "spline_subdivide: %g is not inside (%g, %g)", at, lo[var], hi[var]);

    kn_spline l = {0}, r = {0};
    double end = hi[var];
    hi[var] = at;
    status = kn_spline_restrict(ctx, &l, a, lo, hi);
    hi[var] = end, lo[var] = at;
    if (status == KN_OK) status = kn_spline_restrict(ctx, &r, a, lo, hi);
    if (status == KN_OK) {
        kn_spline_swap(left, &l);
        kn_spline_swap(right, &r);
    }
    kn_spline_clear(ctx, &l);
    kn_spline_clear(ctx, &r);
    return status;
}
