// SPDX-License-Identifier: Apache-2.0
// A copy of a spline.
#include <string.h>

#include "spline/internal.h"

kn_status kn_spline_copy(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    kn_spline s = {0};
    if (a->nvars > 0) {
        kn_status status = kn_spline_alloc(ctx, &s, a->nvars, a->ncomp, a->rational, a->degree, a->count);
        if (status != KN_OK) return status;
        for (int d = 0; d < a->nvars; d++)
            memcpy(s.knots[d], a->knots[d], ((size_t)a->count[d] + (size_t)a->degree[d] + 1) * sizeof *s.knots[d]);
        memcpy(s.coef, a->coef, kn_spline_count(a) * (size_t)a->ncomp * sizeof *s.coef);
    }
    kn_spline_swap(out, &s);
    kn_spline_clear(ctx, &s);
    return KN_OK;
}
