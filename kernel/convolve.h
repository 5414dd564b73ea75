// SPDX-License-Identifier: Apache-2.0
// Products of multivariate coefficient arrays: the arithmetic of every product and composition. No allocation.
#ifndef KERNEL_CONVOLVE_H
#define KERNEL_CONVOLVE_H

#include <stddef.h>

// c += sign * a * b: c[k] += sign sum_(i + j = k) a[i] b[j] over multi-indices of nvars variables; arrays dense, the
// last variable fastest, a of degrees da[d], b of db[d], c of da[d] + db[d]. With a, b and c scaled Bernstein
// coefficients (kn_bernstein_weights) it is the product of the polynomials.
// in:     sign 1 or -1; a and b may be the same, c is apart from both. work: kn_convolve_work numbers, 64-byte
//         aligned, not cleared.
// error:  T terms in a sum: gamma(T + 1) sum |a_i b_j| beside what c held; products and sums may be fused, in an
//         order that depends on the machine alone, never on the call. Small integers are exact.
void kn_convolve(double *c, int nvars, const double *a, const int *da, const double *b, const int *db, double sign,
                 double *work);
size_t kn_convolve_work(int nvars, const int *da, const int *db);
// The plain reference, one term after the other.
void kn_convolve_plain(double *c, int nvars, const double *a, const int *da, const double *b, const int *db,
                       double sign);

#endif
