// SPDX-License-Identifier: Apache-2.0
// Splines evaluated in long double by de Boor's algorithm on control values: independent of the library's basis
// functions and blossoms.
#ifndef TESTS_SPLINE_ORACLE_H
#define TESTS_SPLINE_ORACLE_H

#include "tests/support/support.h"

#include <knurl/spline.h>

// value[c], c < ncomp: the homogeneous components (not projected) of the derivative of orders a[] (NULL: the value)
// at `at`, by the polynomials of the spans span[] (NULL: those that serve `at`). size[c], when not NULL, receives the
// same computation with every number replaced by its absolute value: rounding errors are a multiple of it.
void oracle_homogeneous(long double *value, long double *size, const kn_spline *s, const double *at, const int *a,
                        const int *span);
// The projected value, dim numbers.
void oracle_value(long double *value, const kn_spline *s, const double *at);
// A bound of |computed - exact| for a value that is computed in doubles by `operations` roundings on numbers whose
// absolute sum is size: gamma_n size (Higham, Accuracy and Stability of Numerical Algorithms, section 3.4).
double oracle_gamma(int operations);
// Roundings that one term of kn_spline_eval's sum sees: 5 per level of the basis, a product and p additions for each
// variable.
int oracle_eval_operations(const kn_spline *s);
// Asserts that two splines over the same variables have the same homogeneous components at `points` random points of
// s's domain and `beyond` (in parameter units) outside it; salt seeds them, within factor gamma(operations) times the
// absolute sums of both. t: the same function on other knots.
void oracle_assert_same(const kn_spline *s, const kn_spline *t, uint64_t salt, int points, double beyond,
                        int operations);
// The largest |coefficient|.
double oracle_largest(const kn_spline *s);
// The smaller of two.
int oracle_lower(int a, int b);
// How often `at` occurs among the knots of variable var.
int oracle_multiplicity(const kn_spline *s, int var, double at);
// J: how much errors of pieces can grow on the way to out's coefficients, the largest sum of |weights|. At most 64
// coefficients and 16 breaks in a variable.
double oracle_growth(const kn_spline *out);
// The largest distance of two splines of at most 3 variables and dimension 3 at n random points, projected.
double oracle_sampled_distance(const kn_spline *a, const kn_spline *b, test_rng *rng, int n);

#endif
