// SPDX-License-Identifier: Apache-2.0
// Ruled surfaces, and volumes between surfaces.
#include "construct/internal.h"
#include "kernel/context.h"
#include "spline/internal.h"

kn_status kn_construct_ruled(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b)
{
    static const char call[] = "construct_ruled";
    kn_spline ends[2] = {*a, *b}, s;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_construct_compatible(ctx, call, ends, (const kn_spline[]){*a, *b}, 2);
    if (status == KN_OK) status = kn_construct_extend(ctx, call, &s, &ends[0], 1, 2);
    if (status == KN_OK) {
        size_t n = kn_spline_count(&ends[0]) * (size_t)s.ncomp;
        double *knots = s.knots[s.nvars - 1];
        knots[0] = knots[1] = 0.0, knots[2] = knots[3] = 1.0;
        for (size_t i = 0; i < n; i++) s.coef[2 * i] = ends[0].coef[i], s.coef[2 * i + 1] = ends[1].coef[i];
        status = kn_spline_store(ctx, out, &s);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
