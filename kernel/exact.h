// SPDX-License-Identifier: Apache-2.0
// Signs of small sums, decided exactly: expansions of doubles (Shewchuk, Adaptive precision floating-point
// arithmetic, Discrete Comput. Geom. 18, 1997).
#ifndef KERNEL_EXACT_H
#define KERNEL_EXACT_H

#include <stdbool.h>

enum { KN_EXACT_TERMS = 64 };

// Whether sum_i (a[i] - b[i]) c[i] is zero, i < n <= KN_EXACT_TERMS, in exact arithmetic. Where products come near
// the ends of the range of doubles, which would hide a part of them, the answer is false.
bool kn_exact_zero(const double *a, const double *b, const double *c, int n);

#endif
