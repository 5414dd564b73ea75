// SPDX-License-Identifier: Apache-2.0
// Antiderivatives and partial derivatives in Bernstein form.
#include "kernel/calculus.h"

// The derivative of sum_k c_k B^(n+1)_k is (n+1) sum_k (c_(k+1) - c_k) B^n_k: hence c_k = (p_0 + .. + p_(k-1)) /
// (n+1). Sums first, one division each: exact where the quotient is an integer.
void kn_bernstein_integrate(double *out, const double *in, size_t outer, int n, size_t inner)
{
    for (size_t o = 0; o < outer; o++, in += (size_t)(n + 1) * inner, out += (size_t)(n + 2) * inner) {
        for (size_t j = 0; j < inner; j++) out[j] = 0.0;
        for (size_t j = 0; j < (size_t)(n + 1) * inner; j++) out[j + inner] = out[j] + in[j];
        for (size_t j = inner; j < (size_t)(n + 2) * inner; j++) out[j] /= n + 1;
    }
}

// n (p_(i+1) - p_i), raised from degree n - 1 to n by c_k = (k q_(k-1) + (n-k) q_k) / n: the factor n cancels.
void kn_bernstein_partial(double *out, const double *in, size_t outer, int n, size_t inner)
{
    for (size_t o = 0; o < outer; o++)
        for (int k = 0; k <= n; k++, in += inner, out += inner)
            for (size_t j = 0; j < inner; j++) {
                double c = k > 0 ? k * (in[j] - (in - inner)[j]) : 0.0;
                out[j] = k < n ? c + (n - k) * (in[j + inner] - in[j]) : c;
            }
}
