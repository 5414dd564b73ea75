// SPDX-License-Identifier: Apache-2.0
// What the tests of fits share.
#ifndef TESTS_FIT_CHECK_H
#define TESTS_FIT_CHECK_H

#include <knurl/fit.h>

#include "tests/support/support.h"

// n u / (1 - n u) for u = 2^-53.
double check_gamma(double n);
// The largest |component| of the spline with the absolute values of s's coefficients at `at`, rounded up generously.
double check_size(kn_ctx *ctx, const kn_spline *s, const double *at);
// Roundings of kn_spline_eval: sum_d (6 p_d + 1).
double check_eval_operations(const kn_spline *s);
// Increasing random sites, one inside the support of each B-spline; the ends of the domain among them at random.
void check_random_sites(test_rng *rng, double *sites, const double *knots, int degree, int count);
// at = the place i of the grid of sites, the last variable fastest.
void check_grid_place(double *at, size_t i, int nvars, const int *n, const double *const *sites);
size_t check_product(const int *n, int nvars);

#endif
