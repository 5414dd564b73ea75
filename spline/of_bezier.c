// SPDX-License-Identifier: Apache-2.0
// A Bezier piece as a spline over [0,1]^nvars.
#include <string.h>

#include "spline/internal.h"
#include "kernel/context.h"

kn_status kn_spline_of_bezier(kn_ctx *ctx, kn_spline *out, const kn_bezier *a)
{
    kn_spline s = {0};
    int count[KN_MAX_VARS];
    if (a->coef) {
        if (a->nvars < 1) return kn_fail(ctx, KN_EDOMAIN, "spline_of_bezier: a piece without variables");
        for (int d = 0; d < a->nvars; d++) count[d] = a->degree[d] + 1;
        kn_status status = kn_spline_alloc(ctx, &s, a->nvars, a->ncomp, a->rational, a->degree, count);
        if (status != KN_OK) return status;
        for (int d = 0; d < a->nvars; d++)
            for (int i = 0; i < 2 * count[d]; i++) s.knots[d][i] = i < count[d] ? 0.0 : 1.0;
        memcpy(s.coef, a->coef, kn_bezier_count(a) * (size_t)a->ncomp * sizeof *s.coef);
    }
    kn_spline_swap(out, &s);
    kn_spline_clear(ctx, &s);
    return KN_OK;
}
