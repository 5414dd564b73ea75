// SPDX-License-Identifier: Apache-2.0
// A spline run the other way in one variable, over the same domain.
#include "kernel/array.h"
#include "kernel/context.h"
#include "spline/internal.h"

// lo + hi - t for each interior knot t; equal knots stay equal, the ends are exact. Rounding may make knots equal
// that were not: only then the vector can break a rule.
static kn_status mirror(kn_ctx *ctx, double *to, const double *knots, int p, int count)
{
    double lo = knots[0], hi = knots[count];
    for (int i = 0; i <= p; i++) to[i] = lo, to[count + i] = hi;
    for (int i = p + 1; i < count; i++) {
        double t = lo + (hi - knots[count + p - i]);
        to[i] = t > hi ? hi : t;
    }
    const char *fault = kn_knots_fault(to, p, count);
    return fault ? kn_fail(ctx, KN_EDOMAIN, "spline_reverse: mirrored, rounded knots: %s", fault) : KN_OK;
}

kn_status kn_spline_reverse(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var)
{
    kn_status status = kn_spline_expect(ctx, "spline_reverse", a, var);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline s = *a;
    size_t nknots = (size_t)a->count[var] + (size_t)a->degree[var] + 1;
    s.knots[var] = kn_scratch(ctx, nknots, sizeof *s.knots[var]);
    s.coef = kn_scratch(ctx, kn_spline_count(a) * (size_t)a->ncomp, sizeof *s.coef);
    status = s.knots[var] && s.coef ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) status = mirror(ctx, s.knots[var], a->knots[var], a->degree[var], a->count[var]);
    if (status == KN_OK) {
        kn_array_reverse(s.coef, a->coef, kn_spline_outer(a, var), (size_t)a->count[var], kn_spline_inner(a, var));
        status = kn_spline_store(ctx, out, &s);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
