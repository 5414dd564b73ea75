// SPDX-License-Identifier: Apache-2.0
// The determinant of three vector-valued pieces.
#include "bezier/combine.h"

kn_status kn_bezier_determinant(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b,
                                const kn_bezier *c)
{
    kn_status status = kn_bezier_check_pair(ctx, "determinant", a, b);
    if (status == KN_OK) status = kn_bezier_check_pair(ctx, "determinant", a, c);
    if (status != KN_OK) return status;
    const kn_bezier *const operands[] = {a, b, c};
    for (int i = 0; i < 3; i++)
        if (kn_bezier_dim(operands[i]) != 3)
            return kn_fail(ctx, KN_EDOMAIN, "determinant: %d components", kn_bezier_dim(operands[i]));
    kn_determinant_terms terms;
    kn_formula f = kn_determinant_formula(&terms, a->rational || b->rational || c->rational);
    return kn_bezier_multiply(ctx, "determinant", out, operands, &f);
}
