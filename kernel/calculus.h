// SPDX-License-Identifier: Apache-2.0
// Antiderivatives and partial derivatives in Bernstein form along one axis, on raw arrays seen as in bernstein.h.
#ifndef KERNEL_CALCULUS_H
#define KERNEL_CALCULUS_H

#include <stddef.h>

// out (outer, n + 2, inner) = the antiderivative of in (outer, n + 1, inner) that is zero at 0.
// error:  out_k: gamma(k) sum_(i<k) |p_i| / (n + 1).
void kn_bernstein_integrate(double *out, const double *in, size_t outer, int n, size_t inner);
// out (outer, n + 1, inner) = the derivative of in along the axis, at the same degree n.
// error:  out_k: gamma(3) (k |p_k - p_(k-1)| + (n-k) |p_(k+1) - p_k|).
void kn_bernstein_partial(double *out, const double *in, size_t outer, int n, size_t inner);

#endif
