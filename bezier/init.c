// SPDX-License-Identifier: Apache-2.0
// The life of a kn_bezier.
#include "bezier/shape.h"

kn_status kn_bezier_init(kn_ctx *ctx, kn_bezier *out, int nvars, int ncomp, bool rational, const int *degree)
{
    kn_status status = kn_bezier_check(ctx, "init", nvars, ncomp, rational, degree);
    if (status != KN_OK) return status;
    kn_bezier b = {.nvars = nvars, .ncomp = ncomp, .rational = rational};
    for (int d = 0; d < nvars; d++) b.degree[d] = degree[d];
    b.coef = kn_alloc_zero(ctx, (size_t)ncomp * kn_bezier_count(&b), sizeof *b.coef);
    if (!b.coef) return KN_ENOMEM;
    *out = b;
    return KN_OK;
}

void kn_bezier_clear(kn_ctx *ctx, kn_bezier *b)
{
    if (!b) return;
    kn_free(ctx, b->coef);
    *b = (kn_bezier){0};
}

void kn_bezier_swap(kn_bezier *a, kn_bezier *b)
{
    kn_bezier t = *a;
    *a = *b;
    *b = t;
}

kn_status kn_bezier_copy(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a)
{
    kn_status status = a->coef ? kn_bezier_check_operand(ctx, "copy", a) : KN_OK;
    return status == KN_OK ? kn_bezier_store(ctx, out, a) : status;
}
