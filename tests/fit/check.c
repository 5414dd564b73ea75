// SPDX-License-Identifier: Apache-2.0
// What the tests of fits share.
#include "kernel/knots.h"
#include "tests/fit/check.h"

#include <math.h>
#include <stdlib.h>

double check_gamma(double n)
{
    return n * 0x1p-53 / (1.0 - n * 0x1p-53);
}

double check_size(kn_ctx *ctx, const kn_spline *s, const double *at)
{
    kn_spline a = {0};
    double value[KN_MAX_COMPS], largest = 0.0;
    assert_int_equal(kn_spline_copy(ctx, &a, s), KN_OK);
    for (size_t i = 0; i < kn_spline_count(s) * (size_t)s->ncomp; i++) a.coef[i] = fabs(a.coef[i]);
    assert_int_equal(kn_spline_eval(ctx, value, &a, at), KN_OK);
    for (int c = 0; c < s->ncomp; c++) largest = fmax(largest, value[c]);
    kn_spline_clear(ctx, &a);
    return largest * (1.0 + 1e-9);
}

double check_eval_operations(const kn_spline *s)
{
    double n = 0.0;
    for (int d = 0; d < s->nvars; d++) n += 6 * s->degree[d] + 1;
    return n;
}

// Sorting keeps t_i < x_i < t_i+p+1: both sides increase with i.
void check_random_sites(test_rng *rng, double *sites, const double *knots, int degree, int count)
{
    for (int i = 0; i < count; i++) {
        double lo = knots[i], hi = knots[i + degree + 1];
        sites[i] = test_uniform(rng, lo + 1e-3 * (hi - lo), hi - 1e-3 * (hi - lo));
    }
    if (test_int(rng, 0, 1)) sites[0] = knots[0];
    if (test_int(rng, 0, 1)) sites[count - 1] = knots[count];
    qsort(sites, (size_t)count, sizeof *sites, kn_knots_by_value);
}

void check_grid_place(double *at, size_t i, int nvars, const int *n, const double *const *sites)
{
    for (int d = nvars - 1; d >= 0; d--) {
        at[d] = sites[d][i % (size_t)n[d]];
        i /= (size_t)n[d];
    }
}

size_t check_product(const int *n, int nvars)
{
    size_t total = 1;
    for (int d = 0; d < nvars; d++) total *= (size_t)n[d];
    return total;
}
