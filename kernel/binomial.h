// SPDX-License-Identifier: Apache-2.0
// Binomial coefficients.
#ifndef KERNEL_BINOMIAL_H
#define KERNEL_BINOMIAL_H

// C(n, k), exact, for 0 <= n <= KN_MAX_DEGREE; 0 when k is outside 0 .. n.
double kn_binomial(int n, int k);
// row[k] = C(n, k) for k = 0 .. n, exact.
void kn_binomial_row(double *row, int n);

#endif
