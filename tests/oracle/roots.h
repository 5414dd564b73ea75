// SPDX-License-Identifier: Apache-2.0
// Exact counts of the real roots of univariate Bernstein polynomials (FLINT): Sturm chains over the integers.
#ifndef TESTS_ORACLE_ROOTS_H
#define TESTS_ORACLE_ROOTS_H

#include <flint/fmpz_poly.h>

#include <stdbool.h>

// Bernstein coefficients over [0,1] times a common power of two, as integers in the coefficients of `out`.
void roots_of_array(fmpz_poly_t out, const double *coef, int n);
// The same over [a/q, b/q], up to a positive factor.
void roots_restrict(fmpz_poly_t coef, int n, unsigned long a, unsigned long b, unsigned long q);

// What there is in the closed interval; the polynomial is not zero.
typedef struct roots_facts {
    int inside;      // distinct roots in the open interval
    int odd;         // those of odd multiplicity
    int left, right; // the multiplicity of a root at 0, at 1
    int start;       // the sign at 0, or right of it when there is a root at 0
} roots_facts;
roots_facts roots_look(const fmpz_poly_t coef, int n);
bool roots_zero(const fmpz_poly_t coef);
// Distinct roots in (a, b) and at its ends, any doubles 0 <= a <= b <= 1.
int roots_between(const double *coef, int n, double a, double b);
// The sign of the polynomial at x.
int roots_sign(const double *coef, int n, double x);

#endif
