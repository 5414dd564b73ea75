// SPDX-License-Identifier: Apache-2.0
// The scalar product of two vector-valued pieces.
#include "bezier/combine.h"

kn_status kn_bezier_dot(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b)
{
    kn_status status = kn_bezier_check_pair(ctx, "dot", a, b);
    if (status != KN_OK) return status;
    int dim = kn_bezier_dim(a);
    if (dim != kn_bezier_dim(b)) return kn_fail(ctx, KN_EDOMAIN, "dot: %d and %d components", dim, kn_bezier_dim(b));
    bool rational = a->rational || b->rational;
    kn_term terms[KN_MAX_COMPS + 1];
    const kn_bezier *const operands[] = {a, b};
    kn_formula f = {.ncomp = 1 + rational, .rational = rational, .terms = terms};
    f.nterms = kn_dot_terms(terms, dim, rational);
    return kn_bezier_multiply(ctx, "dot", out, operands, &f);
}
