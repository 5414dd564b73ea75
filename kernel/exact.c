// SPDX-License-Identifier: Apache-2.0
// Signs of small sums, decided exactly.
#include "kernel/exact.h"

#include <assert.h>
#include <math.h>

// sum + error = a + b exactly (Knuth).
static inline double two_sum(double a, double b, double *error)
{
    double sum = a + b, part = sum - a;
    *error = (a - (sum - part)) + (b - part);
    return sum;
}

// The expansion e of n parts that do not overlap becomes that of their sum with x.
static int grow(double *e, int n, double x)
{
    double q = x, rest;
    int to = 0;
    for (int i = 0; i < n; i++) {
        q = two_sum(q, e[i], &rest);
        if (rest != 0.0) e[to++] = rest;
    }
    if (q != 0.0) e[to++] = q;
    return to;
}

bool kn_exact_zero(const double *a, const double *b, const double *c, int n)
{
    double e[4 * KN_EXACT_TERMS];
    int parts = 0;
    assert(n <= KN_EXACT_TERMS);
    for (int i = 0; i < n; i++) {
        double low, factor[2];
        factor[0] = two_sum(a[i], -b[i], &low);
        factor[1] = low;
        for (int k = 0; k < 2; k++) {
            double product = factor[k] * c[i];
            if (factor[k] == 0.0 || c[i] == 0.0) continue;
            if (!(fabs(product) > 0x1p-900 && fabs(product) < 0x1p1000)) return false; // its error would be lost
            parts = grow(e, parts, fma(factor[k], c[i], -product));
            parts = grow(e, parts, product);
        }
    }
    return parts == 0;
}
