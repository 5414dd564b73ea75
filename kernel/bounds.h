// SPDX-License-Identifier: Apache-2.0
// Bounds that hold in spite of rounding, from Bernstein and B-spline coefficients: no allocation, no status.
#ifndef KERNEL_BOUNDS_H
#define KERNEL_BOUNDS_H

#include <stdbool.h>
#include <stddef.h>

// [*lo,*hi] contains all x_k' / w_k' for |x_k' - x_k| <= ex_k, |w_k' - w_k| <= ew_k, n of them, and by convexity the
// values of the function with these coefficients. w NULL: 1; errors NULL: 0. Weights less their errors are positive.
// Without errors the ends are the tightest doubles. A NaN among the numbers gives [-infinity, infinity].
void kn_hull_range(double *lo, double *hi, size_t n, const double *x, const double *ex, const double *w,
                   const double *ew);
// Whether all weights are finite and, less their errors, positive.
bool kn_hull_positive(size_t n, const double *w, const double *ew);
// A number that is at least the Euclidean norm of every one of n vectors, component c of vector k at x[c * n + k],
// whose components may be wrong by gamma(8) of themselves each; INFINITY when one is not finite.
double kn_hull_norm(size_t n, int dim, const double *x);

// kn_bernstein_restriction with |t| and |1 - t| in place of t and 1 - t: what its rounding errors are relative to.
// Inside [0,1] the same matrix, bit for bit.
void kn_bernstein_restriction_size(double *matrix, int n, double lo, double hi);
// kn_knots_blossom with the absolute values of its factors.
void kn_knots_blossom_size(double *w, const double *knots, int degree, int s, const double *args);
// The largest sum of |.| over the rows of a matrix.
double kn_row_growth(const double *matrix, int rows, int columns);
// size[k] = a bound of the error of the number k whose roundings, gamma(roundings) in all, are relative to size[k];
// size[k] itself is rounded as often. floor: added, for what underflow may have taken.
void kn_hull_errors(double *size, size_t n, double roundings, double floor);

#endif
