// SPDX-License-Identifier: Apache-2.0
// Multi-indices of partial derivatives, and the derivatives of a quotient.
#include "kernel/multi_index.h"

#include <stdbool.h>
#include <stddef.h>

#include <knurl/base.h>

#include "kernel/binomial.h"

void kn_multi_index_next(int nvars, int *a)
{
    int last = nvars - 1, rest = a[last], j = last - 1;
    a[last] = 0;
    while (j >= 0 && a[j] == 0) j--;
    if (j < 0) { // (0 .. 0, rest) ends its order
        a[0] = rest + 1;
    } else {
        a[j]--;
        a[j + 1] = rest + 1;
    }
}

// C(n + k, k) as an int; the product is exact at each step.
static int choose(int n, int k)
{
    long long c = 1;
    for (int i = 1; i <= k; i++) c = c * (n + i) / i;
    return (int)c;
}

// Before a come all indices of lower order, C(nvars + |a| - 1, nvars) of them; then, for each variable in turn,
// those of equal order that agree so far and have more of it: what is left after it shrinks, C(rest - 1 + vars,
// vars) of them.
int kn_multi_index_place(int nvars, const int *a)
{
    int rest = 0, place = 0;
    for (int d = 0; d < nvars; d++) rest += a[d];
    for (int d = 0; d < nvars && rest > 0; d++) {
        place += choose(rest - 1, nvars - d);
        rest -= a[d];
    }
    return place;
}

// Leibniz: N_a = sum_{b <= a} C(a,b) w_b f_{a-b}, solved for f_a (Piegl and Tiller, The NURBS Book, section 4.3).
void kn_quotient_derivatives(double *out, const double *in, int nvars, int dim, int order)
{
    int a[KN_MAX_VARS] = {0}, size = dim + 1;
    for (int place = 0, total = 0;; place++) {
        double *f = out + (size_t)place * (size_t)dim;
        for (int c = 0; c < dim; c++) f[c] = in[(size_t)place * (size_t)size + (size_t)c];
        int b[KN_MAX_VARS] = {0}, left[KN_MAX_VARS];
        for (int at = 1; at <= place; at++) {
            double factor = 1.0;
            kn_multi_index_next(nvars, b);
            for (int d = 0; d < nvars; d++) {
                left[d] = a[d] - b[d];
                factor = left[d] < 0 ? 0.0 : factor * kn_binomial(a[d], b[d]);
                if (factor == 0.0) break;
            }
            if (factor == 0.0) continue;
            factor *= in[(size_t)at * (size_t)size + (size_t)dim];
            const double *g = out + (size_t)kn_multi_index_place(nvars, left) * (size_t)dim;
            for (int c = 0; c < dim; c++) f[c] -= factor * g[c];
        }
        for (int c = 0; c < dim; c++) f[c] /= in[dim];
        kn_multi_index_next(nvars, a);
        total = 0;
        for (int d = 0; d < nvars; d++) total += a[d];
        if (total > order) return;
    }
}
