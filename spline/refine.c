// SPDX-License-Identifier: Apache-2.0
// Refinement to a grid, all variables at once.
#include <stdlib.h>
#include <string.h>

#include "spline/in_scratch.h"
#include "kernel/context.h"

static kn_status refine_variable(kn_ctx *ctx, kn_spline *s, int var, const double *knots, int n)
{
    int p = s->degree[var];
    double lo, hi;
    kn_spline_domain(s, var, &lo, &hi);
    if (n < 0) return kn_fail(ctx, KN_EDOMAIN, "spline_refine: %d knots in variable %d", n, var);
    if ((size_t)n > KN_MAX_COEFS) return kn_fail(ctx, KN_ELIMIT, "spline_refine: %d knots in variable %d", n, var);
    double *sorted = kn_scratch(ctx, (size_t)n, sizeof *sorted);
    if (!sorted) return KN_ENOMEM;
    for (int i = 0; i < n; i++) {
        if (!(knots[i] >= lo && knots[i] <= hi))
            return kn_fail(ctx, KN_EDOMAIN, "spline_refine: knot %g is outside [%g, %g] of variable %d", knots[i], lo,
                           hi, var);
        sorted[i] = knots[i];
    }
    qsort(sorted, (size_t)n, sizeof *sorted, kn_knots_by_value);
    for (int i = p + 1; i < n; i++)
        if (sorted[i - p - 1] == sorted[i])
            return kn_fail(ctx, KN_EDOMAIN, "spline_refine: knot %g occurs more than degree + 1 times", sorted[i]);
    return kn_spline_unite_in_scratch(ctx, s, var, sorted, n);
}

kn_status kn_spline_refine(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const int *n, const double *const *knots)
{
    kn_status status = kn_spline_expect(ctx, "spline_refine", a, 0);
    if (status != KN_OK) return status;
    kn_spline s = *a;
    kn_mark mark = kn_scratch_mark(ctx);
    for (int d = a->nvars - 1; d >= 0 && status == KN_OK; d--) status = refine_variable(ctx, &s, d, knots[d], n[d]);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    kn_scratch_release(ctx, mark);
    return status;
}
