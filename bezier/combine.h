// SPDX-License-Identifier: Apache-2.0
// Sums of products of components: what product, dot, cross, determinant and the rational sums come down to, for a
// piece and for many pieces side by side.
#ifndef BEZIER_COMBINE_H
#define BEZIER_COMBINE_H

#include "bezier/shape.h"
#include "kernel/convolve.h"
#include "kernel/convolve_small.h"

// A term (kn_term, kernel/convolve_small.h): component `to` of the result += sign * component a of the first operand *
// component b of the second. The component kn_bezier_dim(x) is the weight of x: 1 for a polynomial piece.
enum { KN_MAX_TERMS = 2 * KN_MAX_COMPS };

// out = the result of the terms. c: its nvars, ncomp and rational; its degrees become the sums of the operands'. out
// may be an operand, and is unchanged by a failure.
kn_status kn_bezier_combine(kn_ctx *ctx, const char *what, kn_bezier *out, kn_bezier *c, const kn_bezier *a,
                            const kn_bezier *b, const kn_term *terms, int nterms);
// The term that multiplies the weights, for a rational result.
static inline kn_term kn_weight_term(const kn_bezier *result, const kn_bezier *a, const kn_bezier *b)
{
    return (kn_term){kn_bezier_dim(result), kn_bezier_dim(a), kn_bezier_dim(b), 1.0};
}

// Lists of terms, for operands of these dimensions, with the term of the weights at the end when rational (dim the
// result's, which for a determinant's last step is the operands' place of the weight). They return how many.
int kn_product_terms(kn_term *terms, int na, int nb, bool rational);
int kn_dot_terms(kn_term *terms, int dim, bool rational);
int kn_cross_terms(kn_term *terms, bool rational);
// (a wb + sign b wa) / (wa wb).
int kn_sum_terms(kn_term *terms, int dim, double sign);

// ---- the steps, for pieces that lie in arrays of any layout ----
typedef struct kn_operand {
    const double *coef;
    size_t component;         // from one component to the next
    size_t step[KN_MAX_VARS]; // from one index of a variable to the next; 1 for the last
    int ncomp;
    bool with_one; // component ncomp is the constant 1
    bool unscaled; // the coefficients have their binomials already
} kn_operand;
void kn_operand_init(kn_operand *o, const kn_bezier *a, bool with_one);
// Whether a term wants the component n of the first operand (which 0) or the second (1).
bool kn_terms_want(const kn_term *terms, int nterms, int which, int n);

// Products of pieces of these degrees, and their room in scratch.
typedef struct kn_pairing {
    kn_convolution plan;
    int ncomp;                  // of the result
    double *thin, *wide, *sums; // components one after the other
    size_t thin_comps, wide_comps;
} kn_pairing;
// na, nb: components with the constant 1.
kn_status kn_pairing_init(kn_ctx *ctx, kn_pairing *p, int nvars, const int *da, const int *db, int na, int nb,
                          int ncomp);
// sums = the sum of the terms. The operands are read here and never again.
void kn_pairing_run(const kn_pairing *p, const kn_operand *a, const kn_operand *b, const kn_term *terms, int nterms);
// The sums as an operand of another product.
void kn_pairing_result(kn_operand *o, const kn_pairing *p);
// The coefficients themselves, to an array in which components are `component` apart.
void kn_pairing_store(const kn_pairing *p, double *out, size_t component, const size_t *step);

// A product of two operands, terms of (a, b), or of three, terms of (a, the inner terms of (b, c)): no coefficient is
// divided by its binomials before the end.
typedef struct kn_formula {
    int ncomp; // of the result, the weight included when rational
    bool rational;
    const kn_term *terms, *inner;
    int nterms, ninner; // ninner 0: two operands
    int inner_comps;
} kn_formula;
typedef struct kn_chain {
    const kn_formula *formula;
    kn_pairing outer, inner;
} kn_chain;
// Whether operand i (0 .. 2) needs the constant 1: a polynomial in a rational formula.
bool kn_formula_wants_one(const kn_formula *f, int i, int ncomp);
// degree[i], comps[i] (the constant 1 included): of the operands.
kn_status kn_chain_init(kn_ctx *ctx, kn_chain *c, const kn_formula *f, int nvars, const int *const *degree,
                        const int *comps);
void kn_chain_run(const kn_chain *c, const kn_operand *operands, double *out, size_t component, const size_t *step);
// out = the formula of two or three pieces over the same variables, checked already.
kn_status kn_bezier_multiply(kn_ctx *ctx, const char *what, kn_bezier *out, const kn_bezier *const *operands,
                             const kn_formula *f);
// det(a, b, c): a . (b x c). The lists live in *room.
typedef struct kn_determinant_terms {
    kn_term outer[4], inner[7];
} kn_determinant_terms;
kn_formula kn_determinant_formula(kn_determinant_terms *room, bool rational);

#endif
