// SPDX-License-Identifier: Apache-2.0
// Whether a function grows or falls along a variable over a box.
#include "solve/net.h"

#include "kernel/bernstein.h"
#include "kernel/context.h"

// The sign of f' is that of the differences, each of which rounds once; of (N/w)' that of N' w - w' N.
static kn_status numerator(kn_ctx *ctx, kn_bezier *out, double *error, const kn_bezier *f, int var)
{
    kn_status status = kn_bezier_derivative(ctx, out, f, var);
    if (status != KN_OK) return status;
    size_t n = kn_bezier_count(f);
    double big = kn_largest(f->coef, n), terms = 2.0, steps = 2.0 * f->degree[var];
    *error = kn_rounding(2.0) * steps * big;
    if (f->rational) {
        for (int d = 0; d < f->nvars; d++) terms *= f->degree[d] + 1;
        *error = kn_rounding(terms + 3.0 * f->nvars + 8.0) * 2.0 * steps * (big * kn_largest(f->coef + n, n));
    }
    *error += kn_underflow();
    return KN_OK;
}

static kn_status decide(kn_ctx *ctx, kn_sign *out, const kn_bezier *f, int var, const double *lo, const double *hi,
                        int depth)
{
    kn_net net = {0};
    double *coef = NULL, *error = NULL, slack = 0.0;
    kn_bezier slope = {0};
    kn_status status = kn_predicate_start(ctx, "monotone", &net, &coef, &error, f, NULL, NULL, depth); // checks
    if (status == KN_OK) status = numerator(ctx, &slope, &slack, f, var);
    slope.rational = false; // the denominator is a square: the first component has the sign
    slope.ncomp = 1;
    if (status == KN_OK) status = kn_predicate_start(ctx, "monotone", &net, &coef, &error, &slope, lo, hi, depth);
    if (status == KN_OK) {
        *error += 2.0 * slack; // a restriction within [0,1] does not raise it
        status = kn_predicate_sign(ctx, out, &net, coef, error, depth);
    }
    kn_bezier_clear(ctx, &slope);
    return status;
}

kn_status kn_solve_monotone(kn_ctx *ctx, kn_sign *out, const kn_bezier *f, int var, const double *lo,
                            const double *hi, int depth)
{
    if (f->coef && (kn_bezier_dim(f) != 1 || var < 0 || var >= f->nvars))
        return kn_fail(ctx, KN_EDOMAIN, "monotone: dimension %d, variable %d of %d", kn_bezier_dim(f), var, f->nvars);
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = decide(ctx, out, f, var, lo, hi, depth);
    kn_scratch_release(ctx, mark);
    return status;
}
