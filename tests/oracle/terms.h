// SPDX-License-Identifier: Apache-2.0
// Sums of products of components, exactly: what product, dot, cross, sums and quotient rules come down to.
#ifndef TESTS_ORACLE_TERMS_H
#define TESTS_ORACLE_TERMS_H

#include "tests/oracle/exact.h"

// sign * product of up to three polynomials, each with its absolute counterpart.
typedef struct exact_factor {
    exact value, size;
} exact_factor;
typedef struct exact_term {
    double sign;
    const exact_factor *f[3]; // NULL: 1
} exact_term;

// Component comp of b; comp == b->ncomp: the weight 1.
exact_factor exact_factor_of(const kn_bezier *b, int comp);
// The derivative in var: its size has the absolute values of the differences.
exact_factor exact_factor_derivative(const kn_bezier *b, int comp, int var);
void exact_factor_free(exact_factor *f);

// Judges component comp of c: the sum of the terms, against gamma(n_k) times the sum of their sizes. per: the
// number of products of pieces of degrees m and n; the roundings L of bezier.h and `more` make n_k.
void exact_judge_terms(exact_judge_t *judge, const kn_bezier *c, int comp, const exact_term *terms, int nterms,
                       const int *m, const int *n, int per, int more);
// Component comp of c is the sum of the terms, rounded to nearest.
void exact_assert_terms(const kn_bezier *c, int comp, const exact_term *terms, int nterms);

#endif
