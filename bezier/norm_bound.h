// SPDX-License-Identifier: Apache-2.0
// Tight upper bounds of how far pieces are from zero.
#ifndef BEZIER_NORM_BOUND_H
#define BEZIER_NORM_BOUND_H

#include "bezier/shape.h"

// Of all components but the last, or of all when radius < 0, the Euclidean norm; radius >= 0 adds radius |last|.
// *bound becomes the larger of itself and an upper bound of it over [0,1]^nvars for d, rounding included, at most
// 1.25 times the maximum where halving can show that within some hundred pieces. *least rises to values that d takes:
// what is below 1.25 *least is not looked at more closely, so that one pair serves many pieces. Start with 0 and 0.
// INFINITY where coefficients are not finite. KN_ENOMEM.
kn_status kn_bezier_norm_bound(kn_ctx *ctx, double *bound, double *least, const kn_bezier *d, double radius);

// The largest Euclidean norm of a coefficient vector, components first .. first+count-1, to a few roundings.
double kn_largest_vector(const kn_bezier *b, int first, int count);

// x with the rounding of a few operations on top: upper bounds stay upper bounds.
static inline double kn_round_up(double x)
{
    return x * (1.0 + 0x1p-46);
}
// gamma(n), rounded up.
static inline double kn_gamma_up(double n)
{
    double nu = n * 0x1p-53;
    return kn_round_up(nu / (1.0 - nu));
}

// The difference of a and b as a vector field e whose norm (kn_bezier_norm_bound with *radius) over *weight bounds
// |a - b|: d holds a's coefficients less b's. Polynomial: *radius = -1, *weight = 1, e = d. Rational, P/w and Q/v: for
// any point C and R >= |Q/v - C|, w (a - b) = (P - Q) - (w - v) C - (w - v) (Q/v - C); *radius = R, *weight = min w.
// In place on d, n points of ncomp numbers, component c of point i at d[c * n + i]; na and nb points of a and b,
// theirs alike. *extra: what rounding here added to |e|, at most. false: a weight is not positive.
typedef struct kn_deviation {
    double radius, weight, extra, length; // length = |C|
    double least, apart;                  // min v, max |w - v|
} kn_deviation;
bool kn_deviation_of(kn_deviation *v, double *d, size_t n, int ncomp, bool rational, const double *a, size_t na,
                     const double *b, size_t nb);

// Rounding of coordinates and of weights.
typedef struct kn_parts {
    double coordinate, weight;
} kn_parts;
// rounding += factor times the largest coordinate and the largest weight (in rational pieces, the last component).
void kn_parts_add(kn_parts *rounding, double factor, const double *coef, size_t n, int ncomp, bool rational);
// The bound of |a - b| from that of the norm of e, when each coefficient of d, of a and of b was wrong by `rounding` at
// most. INFINITY where weights then need not be positive.
double kn_deviation_bound(const kn_deviation *v, double bound, const kn_parts *rounding, int ncomp);

#endif
