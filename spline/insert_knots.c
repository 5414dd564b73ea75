// SPDX-License-Identifier: Apache-2.0
// Knot insertion.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "spline/in_scratch.h"
#include "kernel/context.h"

// fresh = the new knots in order, after a check that they lie inside (lo, hi). Most callers have them in order.
static kn_status sort(kn_ctx *ctx, double *fresh, const double *knots, int n, double lo, double hi)
{
    bool in_order = true;
    for (int i = 0; i < n; i++) {
        if (!(knots[i] > lo && knots[i] < hi))
            return kn_fail(ctx, KN_EDOMAIN, "spline_insert_knots: knot %g is not inside (%g, %g)", knots[i], lo, hi);
        fresh[i] = knots[i];
        in_order = in_order && (i == 0 || knots[i - 1] <= knots[i]);
    }
    if (!in_order) qsort(fresh, (size_t)n, sizeof *fresh, kn_knots_by_value);
    return KN_OK;
}

// to = old and new knots, equal ones old first, so that they stay the old ones bit for bit (-0 and 0 are equal).
// Answers whether no knot occurs more than degree + 1 times.
static bool merge(double *to, const double *old, int nold, const double *fresh, int n, int degree)
{
    int at = 0, i = 0;
    for (int j = 0; j < n; j++) {
        while (i < nold && old[i] <= fresh[j]) to[at++] = old[i++];
        to[at++] = fresh[j];
        if (at > degree + 1 && to[at - degree - 2] == fresh[j]) return false;
    }
    memcpy(to + at, old + i, (size_t)(nold - i) * sizeof *to);
    return true;
}

kn_status kn_spline_insert_knots(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var, const double *knots, int n)
{
    kn_status status = kn_spline_expect(ctx, "spline_insert_knots", a, var);
    if (status != KN_OK) return status;
    if (n < 0) return kn_fail(ctx, KN_EDOMAIN, "spline_insert_knots: %d knots", n);
    if ((size_t)n > KN_MAX_COEFS) return kn_fail(ctx, KN_ELIMIT, "spline_insert_knots: %d knots", n);
    kn_spline s = *a;
    s.count[var] += n;
    status = kn_spline_shape(ctx, "spline_insert_knots", s.nvars, s.ncomp, s.rational, s.degree, s.count);
    if (status != KN_OK) return status;

    s = *a;
    int p = a->degree[var], count = a->count[var], old = count + p + 1;
    kn_mark mark = kn_scratch_mark(ctx);
    double *fresh = kn_scratch(ctx, (size_t)n, sizeof *fresh);
    double *to = kn_scratch(ctx, (size_t)old + (size_t)n, sizeof *to);
    status = fresh && to ? sort(ctx, fresh, knots, n, a->knots[var][0], a->knots[var][count]) : KN_ENOMEM;
    if (status == KN_OK && !merge(to, a->knots[var], old, fresh, n, p))
        status = kn_fail(ctx, KN_EDOMAIN, "spline_insert_knots: a knot occurs more than degree + 1 times");
    if (status == KN_OK && n > 0) status = kn_spline_refine_in_scratch(ctx, &s, var, to, count + n);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s); // last: out may be a
    kn_scratch_release(ctx, mark);
    return status;
}
