// SPDX-License-Identifier: Apache-2.0
// Binomial coefficients.
#ifndef KERNEL_BINOMIAL_H
#define KERNEL_BINOMIAL_H

#include <knurl/base.h>

// C(n, k), exact, for 0 <= n <= KN_MAX_DEGREE; 0 when k is outside 0 .. n.
double kn_binomial(int n, int k);
// row[k] = C(n, k) for k = 0 .. n, exact.
void kn_binomial_row(double *row, int n);

// Row n of Pascal's triangle where it stands, n <= KN_MAX_DEGREE, and its reciprocals, rounded to nearest. Vectors may
// read up to 8 numbers beyond a row.
enum { KN_TRIANGLE = (KN_MAX_DEGREE + 1) * (KN_MAX_DEGREE + 2) / 2 + 8 };
extern const double kn_triangle[KN_TRIANGLE], kn_triangle_inverse[KN_TRIANGLE];
static inline const double *kn_pascal(int n)
{
    return kn_triangle + n * (n + 1) / 2;
}
static inline const double *kn_pascal_inverse(int n)
{
    return kn_triangle_inverse + n * (n + 1) / 2;
}

#endif
