// SPDX-License-Identifier: Apache-2.0
// The determinant of three vector-valued splines.
#include "kernel/context.h"
#include "spline/combine.h"

kn_status kn_spline_determinant(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b,
                                const kn_spline *c)
{
    const kn_spline *const operands[] = {a, b, c};
    for (int i = 0; i < 3; i++)
        if (operands[i]->nvars > 0 && kn_spline_dim(operands[i]) != 3)
            return kn_fail(ctx, KN_EDOMAIN, "spline_determinant: %d components", kn_spline_dim(operands[i]));
    kn_determinant_terms terms;
    kn_formula f = kn_determinant_formula(&terms, a->rational || b->rational || c->rational);
    return kn_spline_multiply(ctx, "spline_determinant", out, operands, &f);
}
