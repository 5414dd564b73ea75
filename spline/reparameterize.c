// SPDX-License-Identifier: Apache-2.0
// An affine change of one parameter: coefficients stay, knots move.
#include <math.h>
#include <string.h>

#include "spline/internal.h"
#include "kernel/context.h"

// An unevaluated sum hi + lo of twice the precision (Dekker, A floating-point technique for extending the available
// precision, Numer. Math. 18, 1971).
typedef struct twice {
    double hi, lo;
} twice;

static twice add(double a, double b) // exact
{
    double sum = a + b, part = sum - a;
    return (twice){sum, (a - (sum - part)) + (b - part)};
}

static twice times(twice a, twice b)
{
    double hi = a.hi * b.hi;
    return add(hi, fma(a.hi, b.hi, -hi) + (a.hi * b.lo + a.lo * b.hi));
}

static twice divided(twice a, twice b)
{
    double q = a.hi / b.hi;
    double rest = fma(-q, b.hi, a.hi) + (a.lo - q * b.lo);
    return add(q, rest / b.hi);
}

// lo + (t - a) / (b - a) (hi - lo): the value has twice the precision before it is rounded once.
static double moved(double t, double a, double b, double lo, double hi)
{
    twice x = times(divided(add(t, -a), add(b, -a)), add(hi, -lo)), sum = add(lo, x.hi);
    return sum.hi + (sum.lo + x.lo);
}

kn_status kn_spline_reparameterize(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var, double lo, double hi)
{
    kn_status status = kn_spline_expect(ctx, "spline_reparameterize", a, var);
    if (status != KN_OK) return status;
    if (!(lo < hi) || !isfinite(hi - lo)) return kn_fail(ctx, KN_EDOMAIN, "spline_reparameterize: [%g, %g]", lo, hi);
    const double *old = a->knots[var];
    int n = a->count[var] + a->degree[var] + 1;
    kn_spline s = *a;
    kn_mark mark = kn_scratch_mark(ctx);
    double *to = s.knots[var] = kn_scratch(ctx, (size_t)n, sizeof *to);
    status = to ? KN_OK : KN_ENOMEM;
    bool same = lo == old[0] && hi == old[n - 1];
    for (int i = 0; i < n && status == KN_OK; i++) {
        if (same || old[i] == old[0] || old[i] == old[n - 1])
            to[i] = same ? old[i] : old[i] == old[0] ? lo : hi;
        else
            to[i] = moved(old[i], old[0], old[n - 1], lo, hi);
        if (i > 0 && (old[i] > old[i - 1] ? !(to[i] > to[i - 1]) : to[i] != to[i - 1]))
            status = kn_fail(ctx, KN_EDOMAIN, "spline_reparameterize: knots %.17g and %.17g become one", old[i - 1],
                             old[i]);
    }
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    kn_scratch_release(ctx, mark);
    return status;
}
