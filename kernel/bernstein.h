// SPDX-License-Identifier: Apache-2.0
// Bernstein form on raw arrays: no allocation, no status; the caller sees to sizes.
// Most act along one axis of an array seen as (outer, n + 1, inner), n the degree: element (o, i, j) lies at
// (o * (n + 1) + i) * inner + j. Arrays do not overlap unless a function says that they may be the same.
#ifndef KERNEL_BERNSTEIN_H
#define KERNEL_BERNSTEIN_H

#include <stddef.h>

// basis[i] = C(n,i) t^i (1-t)^(n-i), i = 0 .. n; any real t. Non-negative on [0,1].
void kn_bernstein_basis(double *basis, int n, double t);
// out (outer, inner) = sum_i basis[i] in(., i, .), for m = n + 1 numbers in basis. out may be in.
void kn_bernstein_contract(double *out, const double *in, size_t outer, int m, size_t inner, const double *basis);
// De Casteljau at t: left is the piece over [0,t], right over [t,1]. left may be in; right may be in; any t.
void kn_bernstein_split(double *left, double *right, const double *in, size_t outer, int n, size_t inner, double t);
// out (outer, to + 1, inner) = in (outer, n + 1, inner) with degree `to` >= n.
void kn_bernstein_elevate(double *out, const double *in, size_t outer, int n, int to, size_t inner);
// out[0 .. n] = x^power, power <= n, over [lo,hi] in degree n: coefficient j is the polar form at lo (n - j times) and
// hi (j times), the mean of the products over all choices of `power` of these numbers,
//     sum_i C(j, i) C(n - j, power - i) / C(n, power) hi^i lo^(power - i).
// error:  gamma(2 power + 8) of the same sum with |lo| and |hi|.
void kn_bernstein_power(double *out, int power, int n, double lo, double hi);
// out (outer, n, inner) = the derivative along the axis, n >= 1; for n = 0 out (outer, 1, inner) is zero.
// out may be in.
void kn_bernstein_differentiate(double *out, const double *in, size_t outer, int n, size_t inner);

// The number of coefficients, prod_d (degree[d] + 1).
size_t kn_bernstein_count(int nvars, const int *degree);
// weights[i] = prod_d C(degree[d], i_d): exact below 2^53. A coefficient times its weight is called scaled.
void kn_bernstein_weights(double *weights, int nvars, const int *degree);
// at[i] = the place of coefficient i of an array with `degree` in an array with `target` >= degree.
void kn_bernstein_places(size_t *at, int nvars, const int *degree, const int *target);
// c += sign a b, all three scaled. place_a, place_b: of a's and b's coefficients in c (kn_bernstein_places);
// row_b = b's last degree + 1.
void kn_bernstein_convolve(double *c, const double *a, const size_t *place_a, size_t na, const double *b,
                           const size_t *place_b, size_t nb, int row_b, double sign);

// matrix (n + 1, n + 1) turns coefficients over [0,1] into those over [lo,hi], any real lo and hi: row i holds the
// weights of the blossom value f[lo,..,lo,hi,..,hi] with i times hi. Non-negative for lo, hi in [0,1].
void kn_bernstein_restriction(double *matrix, int n, double lo, double hi);
// out (outer, rows, inner) = matrix (rows, columns) times in (outer, columns, inner).
void kn_bernstein_transform(double *out, const double *in, size_t outer, int rows, int columns, size_t inner,
                            const double *matrix);
// The same bits for inner = 1, from the matrix transposed: turned (columns, rows).
void kn_bernstein_transform_rows(double *out, const double *in, size_t outer, int rows, int columns,
                                 const double *turned);

#endif
