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
    kn_bezier c = {.nvars = a->nvars, .ncomp = 1 + rational, .rational = rational};
    kn_term terms[KN_MAX_COMPS + 1];
    return kn_bezier_combine_to(ctx, "dot", out, &c, a, b, terms, kn_dot_terms(terms, dim, rational));
}
