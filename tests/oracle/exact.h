// SPDX-License-Identifier: Apache-2.0
// An exact oracle: polynomials over the rationals in the power basis (FLINT), made from pieces and splines bit for
// bit, and a judge that compares computed coefficients with exact ones and with the bound that a header states.
//
//     exact a, b, c = exact_new(), ...
//     exact_of_bezier(&a, &x, 0, false);             // component 0 of x, as a polynomial
//     exact_mul(&c, &a, &b);
//     exact_bernstein(&c, &c, degree);               // its Bernstein coefficients of these degrees
//     exact_judge(&judge, computed, &c, &size, NULL, roundings);
//
// Nothing here uses the formulas of the library for values: products are products of integer polynomials, splines are
// sums of basis functions as polynomials (Cox, de Boor), their coefficients dual functionals on powers.
#ifndef TESTS_ORACLE_EXACT_H
#define TESTS_ORACLE_EXACT_H

#include "tests/support/support.h"

#include <flint/fmpq.h>
#include <flint/fmpz_vec.h>

// ---- tensors of rationals over one denominator ----
// prod_d (degree[d] + 1) numbers num[i] / den, the last variable fastest. As a polynomial number k is the coefficient
// of x^k; functions say where they mean Bernstein coefficients instead. Outputs may be operands.
typedef struct exact {
    int nvars;
    int degree[KN_MAX_VARS];
    fmpz *num;
    fmpz den[1];
} exact;

exact exact_new(void); // empty: the zero of no variables
void exact_free(exact *a);
size_t exact_count(const exact *a);
// count zeros; out's old numbers are gone.
void exact_shape(exact *out, int nvars, const int *degree);
void exact_copy(exact *out, const exact *a);
void exact_swap(exact *a, exact *b);
// The array as it is: exact_bernstein's way back, or numbers of another kind. Finite numbers only.
void exact_of_array(exact *out, int nvars, const int *degree, const double *array, bool absolute);
// The same from rationals; of many this is much faster than exact_set one by one.
void exact_of_fractions(exact *out, int nvars, const int *degree, const fmpq *array);
void exact_constant(exact *out, int nvars, double value);
void exact_get(fmpq_t out, const exact *a, size_t i);
void exact_set(exact *a, size_t i, const fmpq_t value);
void exact_abs(exact *a); // every number, in place
void fmpq_of_double(fmpq_t out, double x);

// ---- polynomials ----
// Component comp of b (comp == kn_bezier_dim of a polynomial piece: its weight, 1); absolute: with the absolute
// values of its Bernstein coefficients.
void exact_of_bezier(exact *out, const kn_bezier *b, int comp, bool absolute);
// Bernstein coefficients of these degrees, not below a's.
void exact_bernstein(exact *out, const exact *a, const int *degree);
void exact_power(exact *a); // the way back, in place
void exact_mul(exact *out, const exact *a, const exact *b);
void exact_add(exact *out, const exact *a, const exact *b);
void exact_sub(exact *out, const exact *a, const exact *b);
void exact_scale(exact *out, const exact *a, const fmpq_t factor);
void exact_derivative(exact *out, const exact *a, int var);
void exact_antiderivative(exact *out, const exact *a, int var); // zero at 0
// out(.., x_var, ..) = a(.., lo + x_var (hi - lo), ..).
void exact_substitute(exact *out, const exact *a, int var, double lo, double hi);
// out = a / x_var^k, which is exact: the coefficients below k are zero.
void exact_divide_power(exact *out, const exact *a, int var, int k);
void exact_value(fmpq_t out, const exact *a, const double *at);
// out(t) = weight^(sum p) outer(inner_0 / weight, ..) for inner functions over the same variables; weight NULL: 1.
// p_d = outer->degree[d].
void exact_compose(exact *out, const exact *outer, const exact *inner, const exact *weight);

// ---- linear maps of arrays along a variable; a matrix is an array of two variables: rows, columns ----
void exact_map(exact *out, const exact *a, int var, const exact *matrix);
// The matrix of exact_substitute on Bernstein coefficients of degree n; its row k has degree + 1 numbers.
void exact_restriction_matrix(exact *out, int n, double lo, double hi);

// ---- splines ----
// Component comp (dim of a polynomial spline: 1) on the box of non-empty spans that holds `at`, right-hand ones at
// knots, as a polynomial in the spline's own parameters. absolute: the same sum of B-splines times |coefficients|.
void exact_of_spline(exact *out, const kn_spline *s, int comp, const double *at, bool absolute);
// The B-splines on the span that holds `at`: array (power, B-spline), and the number of the first one.
void exact_basis(exact *out, int *first, const kn_spline *s, int var, double at);
// The coefficients of r (degrees, counts, knots; its coef is not looked at) of the piecewise function f: an array of
// degrees count[d] - 1. f gives the polynomial on the box that holds `at`; coefficient j is asked of the first box
// in its support.
typedef void (*exact_piece)(exact *out, const double *at, void *user);
void exact_spline_coefs(exact *out, const kn_spline *r, exact_piece f, void *user);

// ---- the judge ----
// Collects error / bound of every number that is not exact, and fails the test when one is above 1.
typedef struct exact_judge_t {
    const char *name;
    double *ratio;           // error / bound
    size_t count, room, all; // ratios, room for, numbers seen
    double most;             // max error / bound
    double relative;         // max error / (size u): how many units of rounding
} exact_judge_t;

// computed[i] against the exact numbers: |computed - exact| <= gamma(n_i) size_i, n_i = roundings[i], or `all` when
// roundings is NULL. size NULL: |exact|.
void exact_judge(exact_judge_t *judge, const double *computed, const exact *value, const exact *size,
                 const int *roundings, int all);
void exact_judge_one(exact_judge_t *judge, double computed, const fmpq_t value, const fmpq_t size, int roundings);
// Any other stated bound: |computed - exact| <= bound.
void exact_judge_bound(exact_judge_t *judge, double computed, const fmpq_t value, const fmpq_t bound);
// computed[i] is the double nearest to the exact number: what data of small integers must give.
void exact_assert_nearest(const double *computed, const exact *value);
// Prints a line, and asserts that the median of bound / error is at most slack (0: no such claim). Starts afresh.
void exact_judge_end(exact_judge_t *judge, double slack);

// ---- coefficients to try ----
typedef enum exact_kind {
    EXACT_INTEGERS, // -9 .. 9
    EXACT_UNIFORM,  // [-1, 1]
    EXACT_SCALES,   // 1e-80 .. 1e80 in one piece, either sign
    EXACT_HUGE,     // about 1e80, all of one size
    EXACT_TINY,     // about 1e-80
    EXACT_CANCEL,   // a large common part, alternating, and noise 1e-12 of it
    EXACT_KINDS
} exact_kind;
void exact_fill(double *out, size_t n, test_rng *rng, exact_kind kind);
// *out: overwritten. Weights are positive, [1/2, 2], whatever the kind (integers: 1 .. 4).
void exact_random_bezier(kn_ctx *ctx, kn_bezier *out, test_rng *rng, int nvars, int ncomp, bool rational,
                         const int *degree, exact_kind kind);
void exact_random_spline(kn_ctx *ctx, kn_spline *out, test_rng *rng, int nvars, int ncomp, bool rational,
                         const int *degree, const int *count, exact_kind kind);

#endif
