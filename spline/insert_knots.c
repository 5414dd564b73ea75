// SPDX-License-Identifier: Apache-2.0
// Knot insertion.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "spline/internal.h"
#include "kernel/context.h"

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// to = the old knots and the new ones, in order. Equal knots stay the old ones bit for bit (-0 and 0 are equal).
static kn_status merge(kn_ctx *ctx, double *to, const kn_spline *a, int var, const double *knots, int n)
{
    int old = a->count[var] + a->degree[var] + 1;
    const double *have = a->knots[var];
    for (int i = 0; i < n; i++)
        if (!(knots[i] > have[0] && knots[i] < have[old - 1]))
            return kn_fail(ctx, KN_EDOMAIN, "spline_insert_knots: knot %g is not inside (%g, %g)", knots[i], have[0],
                           have[old - 1]);
    memcpy(to, have, (size_t)old * sizeof *to);
    for (int i = 0; i < n; i++) to[old + i] = knots[i];
    qsort(to, (size_t)(old + n), sizeof *to, by_value);
    const char *fault = kn_knots_fault(to, a->degree[var], a->count[var] + n);
    return fault ? kn_fail(ctx, KN_EDOMAIN, "spline_insert_knots: %s", fault) : KN_OK;
}

kn_status kn_spline_insert_knots(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var, const double *knots, int n)
{
    kn_status status = kn_spline_expect(ctx, "spline_insert_knots", a, var);
    if (status != KN_OK) return status;
    if (n < 0) return kn_fail(ctx, KN_EDOMAIN, "spline_insert_knots: %d knots", n);
    if ((size_t)n > KN_MAX_COEFS) return kn_fail(ctx, KN_ELIMIT, "spline_insert_knots: %d knots", n);

    kn_spline s = {0};
    kn_mark mark = kn_scratch_mark(ctx);
    double *to = kn_scratch(ctx, (size_t)(a->count[var] + a->degree[var] + 1) + (size_t)n, sizeof *to);
    status = to ? merge(ctx, to, a, var, knots, n) : KN_ENOMEM;
    if (status == KN_OK) status = kn_spline_copy(ctx, &s, a);
    if (status == KN_OK) status = kn_spline_refine_axis(ctx, &s, var, to, a->count[var] + n);
    if (status == KN_OK) kn_spline_swap(out, &s); // last: out may be a
    kn_spline_clear(ctx, &s);
    kn_scratch_release(ctx, mark);
    return status;
}
