// SPDX-License-Identifier: Apache-2.0
// Products of splines.
#include "kernel/context.h"
#include "spline/combine.h"

kn_status kn_spline_product(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b)
{
    int na = kn_spline_dim(a), nb = kn_spline_dim(b), dim = na > nb ? na : nb;
    bool rational = a->rational || b->rational;
    if (a->nvars > 0 && b->nvars > 0 && na != nb && na != 1 && nb != 1)
        return kn_fail(ctx, KN_EDOMAIN, "spline_product: %d and %d components", na, nb);
    kn_term terms[KN_MAX_COMPS + 1];
    const kn_spline *const operands[] = {a, b};
    kn_formula f = {.ncomp = dim + rational, .rational = rational, .terms = terms};
    f.nterms = kn_product_terms(terms, na, nb, rational);
    return kn_spline_multiply(ctx, "spline_product", out, operands, &f);
}
