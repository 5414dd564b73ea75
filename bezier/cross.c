// SPDX-License-Identifier: Apache-2.0
// The vector product of two pieces in space.
#include "bezier/combine.h"

kn_status kn_bezier_cross(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b)
{
    kn_status status = kn_bezier_check_pair(ctx, "cross", a, b);
    if (status != KN_OK) return status;
    if (kn_bezier_dim(a) != 3 || kn_bezier_dim(b) != 3)
        return kn_fail(ctx, KN_EDOMAIN, "cross: %d and %d components", kn_bezier_dim(a), kn_bezier_dim(b));
    bool rational = a->rational || b->rational;
    kn_term terms[7];
    const kn_bezier *const operands[] = {a, b};
    kn_formula f = {.ncomp = 3 + rational, .rational = rational, .terms = terms};
    f.nterms = kn_cross_terms(terms, rational);
    return kn_bezier_multiply(ctx, "cross", out, operands, &f);
}
