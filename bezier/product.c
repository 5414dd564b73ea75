// SPDX-License-Identifier: Apache-2.0
// Products, component by component.
#include "bezier/combine.h"

kn_status kn_bezier_product(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b)
{
    kn_status status = kn_bezier_check_pair(ctx, "product", a, b);
    if (status != KN_OK) return status;
    int na = kn_bezier_dim(a), nb = kn_bezier_dim(b), dim = na > nb ? na : nb;
    if (na != nb && na != 1 && nb != 1) return kn_fail(ctx, KN_EDOMAIN, "product: %d and %d components", na, nb);
    bool rational = a->rational || b->rational;
    kn_term terms[KN_MAX_COMPS + 1];
    const kn_bezier *const operands[] = {a, b};
    kn_formula f = {.ncomp = dim + rational, .rational = rational, .terms = terms};
    f.nterms = kn_product_terms(terms, na, nb, rational);
    return kn_bezier_multiply(ctx, "product", out, operands, &f);
}
