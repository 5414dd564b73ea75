// SPDX-License-Identifier: Apache-2.0
// Whether a vector function vanishes nowhere on a box.
#include "solve/net.h"

#include "kernel/context.h"

enum { PLANES = 24 }; // tried before a box is halved

// Coefficient k, weighed by the planes' normals so far.
static double along(const kn_net *net, const double *coef, const double *normal, size_t k)
{
    double sum = 0.0;
    for (int c = 0; c < net->ncomp; c++) sum += normal[c] * coef[(size_t)c * net->count + k];
    return sum;
}

// The coefficient that lies farthest on the wrong side of the plane, and how much of its side the rounding is:
// |fl(v.c) - v.c| <= gamma(m) |v|.|c|, and v.(error).
static double worst(const kn_net *net, const double *coef, const double *error, const double *normal, size_t *which)
{
    double least = INFINITY, slack = kn_underflow();
    for (int c = 0; c < net->ncomp; c++) {
        double big = kn_largest(coef + (size_t)c * net->count, net->count);
        slack += fabs(normal[c]) * (error[c] + kn_rounding(net->ncomp + 4.0) * big);
    }
    *which = 0;
    for (size_t k = 0; k < net->count; k++) {
        double x = along(net, coef, normal, k);
        if (!(x >= least)) least = x, *which = k;
    }
    return least - slack * (1.0 + 0x1p-40);
}

// The values lie in the hull of the coefficients, and 0 does not when a plane through it has all of them on one side.
// Gilbert's iteration for the point of the hull nearest to 0 gives normals: x <- the nearest of [x, worst c].
static kn_verdict vanishes(void *user, const kn_net *net, const double *coef, const double *error)
{
    bool *zero = user;
    double x[KN_MAX_COMPS], mean = 1.0 / (double)net->count;
    for (int c = 0; c < net->ncomp; c++) {
        x[c] = 0.0;
        for (size_t k = 0; k < net->count; k++) x[c] += mean * coef[(size_t)c * net->count + k];
    }
    for (int plane = 0; plane < PLANES; plane++) {
        size_t k = 0;
        double xx = 0.0, xd = 0.0, dd = 0.0;
        if (worst(net, coef, error, x, &k) > 0.0) return KN_DONE;
        for (int c = 0; c < net->ncomp; c++) {
            double d = coef[(size_t)c * net->count + k] - x[c];
            xx += x[c] * x[c], xd += x[c] * d, dd += d * d;
        }
        if (!(dd > 0.0) || !(xx > 0.0) || xd >= 0.0) break;
        double t = fmin(-xd / dd, 1.0);
        for (int c = 0; c < net->ncomp; c++) x[c] += t * (coef[(size_t)c * net->count + k] - x[c]);
    }
    bool corner = true; // a coefficient at a corner is a value
    for (int c = 0; c < net->ncomp; c++) corner = corner && coef[(size_t)c * net->count] == 0.0 && error[c] == 0.0;
    *zero = *zero || corner;
    return corner ? KN_STOP : KN_HALVE;
}

kn_status kn_solve_nonzero(kn_ctx *ctx, kn_answer *out, const kn_bezier *f, const double *lo, const double *hi,
                           int depth)
{
    kn_mark mark = kn_scratch_mark(ctx);
    kn_net net = {0};
    kn_sign sign = KN_SIGN_UNKNOWN;
    double *coef = NULL, *error = NULL;
    bool settled = false, zero = false;
    kn_status status = kn_predicate_start(ctx, "nonzero", &net, &coef, &error, f, lo, hi, depth);
    if (status == KN_OK && net.ncomp == 1) { // between two signs there is a zero
        status = kn_predicate_sign(ctx, &sign, &net, coef, error, depth);
        settled = sign == KN_SIGN_POSITIVE || sign == KN_SIGN_NEGATIVE;
        zero = sign == KN_SIGN_MIXED;
    } else if (status == KN_OK) {
        status = kn_net_divide(ctx, &settled, &net, coef, error, depth, vanishes, &zero);
    }
    if (status == KN_OK) *out = settled ? KN_YES : zero ? KN_NO : KN_UNKNOWN;
    kn_scratch_release(ctx, mark);
    return status;
}
