// SPDX-License-Identifier: Apache-2.0
// Binomial coefficients as exact doubles.
#include "kernel/binomial.h"

#include <assert.h>
#include <knurl/base.h>
#include <string.h>

// C(n, k) = C(n, k-1) (n-k+1) / k. In integers each division is exact; 64 bits hold the product before it:
// C(56, 28) * 29 < 2^58.
double kn_binomial(int n, int k)
{
    assert(n >= 0 && n <= KN_MAX_DEGREE);
    if (k < 0 || k > n) return 0.0;
    if (k > n - k) k = n - k;
    uint64_t c = 1;
    for (int i = 1; i <= k; i++) c = c * (uint64_t)(n - i + 1) / (uint64_t)i;
    return (double)c;
}

void kn_binomial_row(double *row, int n)
{
    memcpy(row, kn_pascal(n), ((size_t)n + 1) * sizeof *row);
}

const double kn_triangle[KN_TRIANGLE] = {
#define N(c) (double)c,
#include "kernel/binomial_rows.h"
#undef N
};

const double kn_triangle_inverse[KN_TRIANGLE] = {
#define N(c) 1.0 / (double)c,
#include "kernel/binomial_rows.h"
#undef N
};
