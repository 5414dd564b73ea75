// SPDX-License-Identifier: Apache-2.0
// A small oriented box around a piece.
#include "bezier/bounds.h"

kn_status kn_bezier_oriented_box(kn_ctx *ctx, kn_oriented_box *out, const kn_bezier *a)
{
    kn_status status = kn_bezier_check_operand(ctx, "oriented_box", a);
    if (status != KN_OK) return status;
    int count[KN_MAX_VARS];
    for (int d = 0; d < a->nvars; d++) count[d] = a->degree[d] + 1;
    return kn_oriented_box_of(ctx, "oriented_box", out, a->coef, kn_bezier_dim(a), a->rational, a->nvars, count);
}
