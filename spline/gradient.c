// SPDX-License-Identifier: Apache-2.0
// All first partial derivatives of a spline in one spline.
#include "bezier/gradient.h"
#include "kernel/context.h"
#include "spline/calculus.h"

static kn_status rational_piece(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const double *size, const void *user)
{
    (void)user;
    return kn_bezier_gradient_over(ctx, "spline_gradient", out, a, size);
}

kn_status kn_spline_gradient(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    kn_status status = kn_spline_expect(ctx, "spline_gradient", a, 0);
    if (status != KN_OK) return status;
    if (a->rational) {
        kn_bezier shape = {.nvars = a->nvars, .ncomp = kn_spline_dim(a) * a->nvars + 1, .rational = true};
        for (int d = 0; d < a->nvars; d++) shape.degree[d] = 2 * a->degree[d];
        return kn_spline_by_pieces(ctx, "spline_gradient", out, a, &shape, rational_piece, NULL, KN_EVERY_VAR);
    }
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline g;
    status = kn_spline_partial_knots(ctx, &g, a);
    g.ncomp = a->ncomp * a->nvars;
    if (status == KN_OK) status = kn_spline_shape(ctx, "spline_gradient", g.nvars, g.ncomp, false, g.degree, g.count);
    size_t n = kn_spline_count(&g);
    if (status == KN_OK) {
        g.coef = kn_scratch(ctx, (size_t)g.ncomp * n, sizeof *g.coef);
        if (!g.coef) status = KN_ENOMEM;
    }
    for (int i = 0; i < g.ncomp && status == KN_OK; i++)
        status = kn_spline_partial(ctx, g.coef + (size_t)i * n, a, i / a->nvars, i % a->nvars, &g);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &g);
    kn_scratch_release(ctx, mark);
    return status;
}
