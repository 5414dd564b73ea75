// SPDX-License-Identifier: Apache-2.0
// A spline over a sub-box of its domain, or over a box that reaches beyond it.
#include <math.h>

#include "spline/internal.h"
#include "kernel/context.h"

// The coefficients on the new knots are the old pieces' polar forms there; beyond the domain those of the end pieces.
static kn_status restrict_variable(kn_ctx *ctx, kn_spline *s, int var, double lo, double hi)
{
    int p = s->degree[var], n = 0;
    kn_mark mark = kn_scratch_mark(ctx);
    double *to = kn_scratch(ctx, (size_t)s->count[var] + (size_t)p + 1, sizeof *to);
    kn_status status = KN_ENOMEM;
    if (to) {
        for (int k = 0; k <= p; k++) to[n++] = lo;
        for (int i = p + 1; i < s->count[var]; i++) // interior knots
            if (s->knots[var][i] > lo && s->knots[var][i] < hi) to[n++] = s->knots[var][i];
        for (int k = 0; k <= p; k++) to[n++] = hi;
        status = kn_spline_refine_axis(ctx, s, var, to, n - p - 1);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_spline_restrict(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const double *lo, const double *hi)
{
    kn_status status = kn_spline_expect(ctx, "spline_restrict", a, 0);
    if (status != KN_OK) return status;
    for (int d = 0; d < a->nvars; d++)
        if (!(lo[d] < hi[d]) || !isfinite(hi[d] - lo[d]))
            return kn_fail(ctx, KN_EDOMAIN, "spline_restrict: [%g, %g] in variable %d", lo[d], hi[d], d);
    kn_spline s = {0};
    status = kn_spline_copy(ctx, &s, a);
    for (int d = 0; d < a->nvars && status == KN_OK; d++) status = restrict_variable(ctx, &s, d, lo[d], hi[d]);
    if (status == KN_OK) kn_spline_swap(out, &s);
    kn_spline_clear(ctx, &s);
    return status;
}
