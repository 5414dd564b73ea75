// SPDX-License-Identifier: Apache-2.0
// Sums of products of components: what product, dot, cross and the rational sums come down to.
#ifndef BEZIER_COMBINE_H
#define BEZIER_COMBINE_H

#include "bezier/shape.h"

// Component `to` of the result += sign * component a of the first operand * component b of the second.
// The component kn_bezier_dim(x) is the weight of x: 1 for a polynomial piece.
typedef struct kn_term {
    int to, a, b;
    double sign;
} kn_term;

enum { KN_MAX_TERMS = 2 * KN_MAX_COMPS };

// result: nvars, ncomp and rational set, no coefficients; its degrees become the sums of the operands'. Allocated
// here; on failure nothing is.
kn_status kn_bezier_combine(kn_ctx *ctx, const char *what, kn_bezier *result, const kn_bezier *a, const kn_bezier *b,
                            const kn_term *terms, int nterms);
// The term that multiplies the weights, for a rational result.
static inline kn_term kn_weight_term(const kn_bezier *result, const kn_bezier *a, const kn_bezier *b)
{
    return (kn_term){kn_bezier_dim(result), kn_bezier_dim(a), kn_bezier_dim(b), 1.0};
}

#endif
