// SPDX-License-Identifier: Apache-2.0
// A spline over a sub-box of its domain, or over a box that reaches beyond it.
#include <math.h>

#include "spline/in_scratch.h"
#include "kernel/context.h"

// The coefficients on the new knots are the old pieces' polar forms there; beyond the domain those of the end pieces.
kn_status kn_spline_restrict_in_scratch(kn_ctx *ctx, kn_spline *s, int var, double lo, double hi)
{
    int p = s->degree[var], count = s->count[var], n = 0;
    const double *knots = s->knots[var];
    if (lo == knots[0] && hi == knots[count]) return KN_OK;
    double *to = kn_scratch(ctx, (size_t)count + (size_t)p + 1, sizeof *to);
    if (!to) return KN_ENOMEM;
    for (int k = 0; k <= p; k++) to[n++] = lo;
    for (int i = p + 1; i < count; i++) // interior knots
        if (knots[i] > lo && knots[i] < hi) to[n++] = knots[i];
    for (int k = 0; k <= p; k++) to[n++] = hi;
    return kn_spline_refine_in_scratch(ctx, s, var, to, n - p - 1);
}

kn_status kn_spline_restrict(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const double *lo, const double *hi)
{
    kn_status status = kn_spline_expect(ctx, "spline_restrict", a, 0);
    if (status != KN_OK) return status;
    for (int d = 0; d < a->nvars; d++)
        if (!(lo[d] < hi[d]) || !isfinite(hi[d] - lo[d]))
            return kn_fail(ctx, KN_EDOMAIN, "spline_restrict: [%g, %g] in variable %d", lo[d], hi[d], d);
    kn_spline s = *a;
    kn_mark mark = kn_scratch_mark(ctx);
    for (int d = a->nvars - 1; d >= 0 && status == KN_OK; d--)
        status = kn_spline_restrict_in_scratch(ctx, &s, d, lo[d], hi[d]);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    kn_scratch_release(ctx, mark);
    return status;
}
