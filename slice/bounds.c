// SPDX-License-Identifier: Apache-2.0
// How fast (x, y) of a patch changes, and what rounding does to it: upper bounds from coefficients.
#include "slice/internal.h"

#include "bezier/norm_bound.h"

#include <float.h>
#include <math.h>

// (x - cx w, y - cy w, w) as one polynomial: c the patch's first corner.
typedef struct centred {
    kn_bezier piece;
    double least_weight, most_weight, largest; // largest: of |x|, |y|, over the weight
    double error;                              // of a coefficient (x, y), as a vector
} centred;

static kn_status centre(kn_ctx *ctx, centred *out, const kn_bezier *p)
{
    size_t n = kn_bezier_count(p);
    kn_status status = kn_bezier_init(ctx, &out->piece, 2, 3, false, p->degree);
    if (status != KN_OK) return status;
    const double *w = p->rational ? p->coef + 3 * n : NULL;
    double c[2] = {p->coef[0] / (w ? w[0] : 1.0), p->coef[n] / (w ? w[0] : 1.0)}, terms = 0.0;
    out->least_weight = INFINITY;
    for (size_t i = 0; i < n; i++) {
        double weight = w ? w[i] : 1.0;
        for (size_t d = 0; d < 2; d++) {
            double x = p->coef[d * n + i];
            out->piece.coef[d * n + i] = x - c[d] * weight;
            out->largest = fmax(out->largest, kn_round_up(fabs(x) / weight));
            terms = fmax(terms, fabs(x) + fabs(c[d]) * weight);
        }
        out->piece.coef[2 * n + i] = weight;
        out->least_weight = fmin(out->least_weight, weight);
        out->most_weight = fmax(out->most_weight, weight);
    }
    // gamma(2), and as much for differences of differences; 1.5 > sqrt(2), DBL_MIN against underflow
    out->error = kn_round_up(1.5 * kn_gamma_up(4.0) * terms);
    out->error += DBL_MIN;
    return KN_OK;
}

// Derivatives of X / W in terms of those of X and W: P_a = (X_a - W_a P) / W, and
// P_ab = (X_ab - W_a P_b - W_b P_a - W_ab P) / W.
static kn_status find(kn_ctx *ctx, kn_slice_bounds *out, const kn_bezier *p, centred *c)
{
    enum { ALL, R, T, RR, RT, TT, N };
    kn_bezier d[N] = {{0}};
    const double n = p->degree[0], m = p->degree[1];
    const double raised[N] = {1.0, 2.0 * n, 2.0 * m, 4.0 * n * n, 4.0 * n * m, 4.0 * m * m}; // a coefficient's error
    double w = c->least_weight, lost = p->rational ? kn_gamma_up(4.0) * c->most_weight : 0.0, x[N], v[N];
    kn_status status = KN_OK;
    kn_bezier_swap(&d[ALL], &c->piece);
    for (int k = R; status == KN_OK && k < N; k++)
        status = kn_bezier_derivative(ctx, &d[k], &d[k <= T ? ALL : k == TT ? T : R], k == T || k == RT || k == TT);
    for (int k = 0; status == KN_OK && k < N; k++) {
        x[k] = kn_round_up(kn_largest_vector(&d[k], 0, 2) + raised[k] * c->error);
        v[k] = kn_round_up(kn_largest_vector(&d[k], 2, 1) + (k == ALL ? 0.0 : raised[k] * lost));
    }
    if (status == KN_OK) {
        double at = x[ALL] / w, first[2] = {(x[R] + v[R] * at) / w, (x[T] + v[T] * at) / w};
        double rr = (x[RR] + 2.0 * v[R] * first[0] + v[RR] * at) / w;
        double rt = (x[RT] + v[R] * first[1] + v[T] * first[0] + v[RT] * at) / w;
        double tt = (x[TT] + 2.0 * v[T] * first[1] + v[TT] * at) / w;
        out->first = fmax(kn_round_up(first[0] + first[1]), DBL_MIN);
        out->second = fmax(kn_round_up(rr + 2.0 * rt + tt), DBL_MIN);
        // sums of products with both bases: gamma(4 (n + m) + 2), twice and one more over a weight; as a vector
        double q = c->most_weight / w;
        out->value = kn_round_up(4.5 * kn_gamma_up(5.0 * (n + m) + 8.0) * q * c->largest) + DBL_MIN;
    }
    for (int k = 0; k < N; k++) kn_bezier_clear(ctx, &d[k]);
    return status;
}

kn_status kn_slice_find_bounds(kn_ctx *ctx, kn_slice_bounds *out, const kn_bezier *p)
{
    centred c = {0};
    kn_status status = centre(ctx, &c, p);
    if (status == KN_OK) status = find(ctx, out, p, &c);
    kn_bezier_clear(ctx, &c.piece);
    return status;
}
