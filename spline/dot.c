// SPDX-License-Identifier: Apache-2.0
// Scalar products of splines.
#include "kernel/context.h"
#include "spline/combine.h"

kn_status kn_spline_dot(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b)
{
    int dim = kn_spline_dim(a);
    bool rational = a->rational || b->rational;
    if (a->nvars > 0 && b->nvars > 0 && dim != kn_spline_dim(b))
        return kn_fail(ctx, KN_EDOMAIN, "spline_dot: %d and %d components", dim, kn_spline_dim(b));
    kn_term terms[KN_MAX_COMPS + 1];
    const kn_spline *const operands[] = {a, b};
    kn_formula f = {.ncomp = 1 + rational, .rational = rational, .terms = terms};
    f.nterms = kn_dot_terms(terms, dim, rational);
    return kn_spline_multiply(ctx, "spline_dot", out, operands, &f);
}
