// SPDX-License-Identifier: Apache-2.0
// The antiderivative of a spline as a spline.
#include "kernel/context.h"
#include "spline/internal.h"

// With d_0 = 0 and d_(i+1) = d_i + c_i (t_(i+p+1) - t_i) / (p + 1) the derivative of the spline of degree p + 1 on
// the same knots, the ends once more often, has the coefficients c_i (de Boor, A Practical Guide to Splines, ch. X).
// Sums first, one division each: exact where the quotient is an integer.
static void accumulate(double *to, const double *from, const double *knots, int p, int count, size_t outer,
                       size_t inner)
{
    for (size_t o = 0; o < outer; o++) {
        double *first = to;
        for (size_t j = 0; j < inner; j++) to[j] = 0.0;
        for (int i = 0; i < count; i++, from += inner, to += inner) {
            double length = knots[i + p + 1] - knots[i];
            for (size_t j = 0; j < inner; j++) to[inner + j] = to[j] + length * from[j];
        }
        to += inner;
        for (double *d = first; d < to; d++) *d /= p + 1;
    }
}

kn_status kn_spline_antiderivative(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var)
{
    kn_status status = kn_spline_expect(ctx, "spline_antiderivative", a, var);
    if (status != KN_OK) return status;
    if (a->rational) return kn_fail(ctx, KN_EDOMAIN, "spline_antiderivative: that of a rational spline is none");
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline s = *a;
    int nknots = a->count[var] + a->degree[var] + 1;
    s.degree[var]++;
    s.count[var]++;
    status = kn_spline_shape(ctx, "spline_antiderivative", s.nvars, s.ncomp, false, s.degree, s.count);
    if (status == KN_OK) {
        double *knots = kn_scratch(ctx, (size_t)nknots + 2, sizeof *knots);
        s.coef = kn_scratch(ctx, kn_spline_count(&s) * (size_t)s.ncomp, sizeof *s.coef);
        status = knots && s.coef ? KN_OK : KN_ENOMEM;
        for (int i = 0; i < nknots + 2 && knots; i++)
            knots[i] = a->knots[var][i == 0 ? 0 : i <= nknots ? i - 1 : nknots - 1];
        s.knots[var] = knots;
    }
    if (status == KN_OK) {
        accumulate(s.coef, a->coef, a->knots[var], a->degree[var], a->count[var], kn_spline_outer(a, var),
                   kn_spline_inner(a, var));
        status = kn_spline_store(ctx, out, &s);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
