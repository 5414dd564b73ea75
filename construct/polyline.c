// SPDX-License-Identifier: Apache-2.0
// Polylines.
#include "construct/internal.h"
#include "kernel/context.h"
#include "spline/internal.h"

kn_status kn_construct_polyline(kn_ctx *ctx, kn_spline *out, int dim, int n, const double *points)
{
    static const char call[] = "construct_polyline";
    kn_spline s = {.nvars = 1, .ncomp = dim, .degree = {1}, .count = {n}};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_spline_in_scratch(ctx, call, &s);
    for (int i = 0; i < n && status == KN_OK; i++) {
        status = kn_construct_finite(ctx, call, points + (size_t)i * (size_t)dim, dim);
        s.knots[0][i + 1] = (double)i / (n - 1);
        for (int c = 0; c < dim; c++)
            s.coef[(size_t)c * (size_t)n + (size_t)i] = points[(size_t)i * (size_t)dim + (size_t)c];
    }
    if (status == KN_OK) {
        s.knots[0][0] = 0.0, s.knots[0][n + 1] = 1.0;
        status = kn_spline_store(ctx, out, &s);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
