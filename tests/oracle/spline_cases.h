// SPDX-License-Identifier: Apache-2.0
// Random splines for the oracle's tests, and sums of them as piecewise polynomials.
#ifndef TESTS_ORACLE_SPLINE_CASES_H
#define TESTS_ORACLE_SPLINE_CASES_H

#include "tests/oracle/exact.h"

typedef struct spline_world {
    test_memory memory;
    kn_ctx *ctx;
    test_rng rng;
    exact value, size;
    fmpq_t x, s;
} spline_world;

void spline_begin(spline_world *w, uint64_t salt);
void spline_end(spline_world *w);

// Calls body for random polynomial splines of one component, in one to three variables, of every kind; with knots
// apart by anything for one of them, by integers for the others.
typedef void (*spline_case)(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *a);
void spline_for_all(spline_world *w, exact_judge_t *judge, spline_case body);

// s[0], or s[0] + s[1] (less: s[0] - s[1]), or with absolute values of all coefficients.
typedef struct spline_sum {
    const kn_spline *s[2];
    bool absolute, minus;
    int times[2]; // that the absolute values count (0: once)
} spline_sum;
// Judges r's coefficients against the sum on r's knots, and gamma(roundings) times that of absolute values.
void spline_judge_sum(spline_world *w, exact_judge_t *judge, const kn_spline *r, spline_sum f, const int *roundings,
                      int all);
// The most arguments of a coefficient of r that are no knots of a, in a variable.
int spline_fresh_arguments(const kn_spline *r, const kn_spline *a, int var);

// Sums of products of components; comp == kn_spline_dim of a spline: its weight, or 1.
typedef struct spline_term {
    double sign;
    const kn_spline *s[3]; // NULL: 1
    int comp[3];
} spline_term;
// Judges component comp of r, made by pieces: the sum of the terms, against gamma(roundings, and those of the maps to
// the piece and back) times the sum with absolute values on the piece that a coefficient is taken from, weighted by
// the absolute values of the factors of its blossom.
void spline_judge_terms(spline_world *w, exact_judge_t *judge, const kn_spline *r, int comp, const spline_term *terms,
                        int nterms, int roundings);
// Their exact coefficients on r's knots.
void spline_exact_terms(exact *out, const kn_spline *r, const spline_term *terms, int nterms);
// That weighting for any f; the pieces of f have degrees not above r's.
void spline_join_sizes(exact *out, const kn_spline *r, exact_piece f, void *user);

#endif
