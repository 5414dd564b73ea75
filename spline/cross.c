// SPDX-License-Identifier: Apache-2.0
// Vector products of splines.
#include "kernel/context.h"
#include "spline/combine.h"

kn_status kn_spline_cross(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b)
{
    bool rational = a->rational || b->rational;
    if (a->nvars > 0 && b->nvars > 0 && (kn_spline_dim(a) != 3 || kn_spline_dim(b) != 3))
        return kn_fail(ctx, KN_EDOMAIN, "spline_cross: %d and %d components", kn_spline_dim(a), kn_spline_dim(b));
    kn_term terms[7];
    const kn_spline *const operands[] = {a, b};
    kn_formula f = {.ncomp = 3 + rational, .rational = rational, .terms = terms};
    f.nterms = kn_cross_terms(terms, rational);
    return kn_spline_multiply(ctx, "spline_cross", out, operands, &f);
}
