// SPDX-License-Identifier: Apache-2.0
// The divergence of a vector field in spline form.
#include "bezier/gradient.h"
#include "kernel/context.h"
#include "spline/calculus.h"

static kn_status rational_piece(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const double *size, const void *user)
{
    (void)user;
    return kn_bezier_divergence_over(ctx, "spline_divergence", out, a, size);
}

// to = sum_v d_v a_v on the grid; part: as large.
static kn_status sum_partials(kn_ctx *ctx, double *to, double *part, const kn_spline *a, const kn_spline *grid)
{
    kn_status status = kn_spline_partial(ctx, to, a, 0, 0, grid);
    for (int v = 1; v < a->nvars && status == KN_OK; v++) {
        status = kn_spline_partial(ctx, part, a, v, v, grid);
        for (size_t i = 0; i < kn_spline_count(grid); i++) to[i] += status == KN_OK ? part[i] : 0.0;
    }
    return status;
}

kn_status kn_spline_divergence(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    kn_status status = kn_spline_expect(ctx, "spline_divergence", a, 0);
    if (status != KN_OK) return status;
    if (kn_spline_dim(a) != a->nvars)
        return kn_fail(ctx, KN_EDOMAIN, "spline_divergence: %d components over %d variables", kn_spline_dim(a),
                       a->nvars);
    if (a->rational) {
        kn_bezier shape = {.nvars = a->nvars, .ncomp = 2, .rational = true};
        for (int d = 0; d < a->nvars; d++) shape.degree[d] = 2 * a->degree[d];
        return kn_spline_by_pieces(ctx, "spline_divergence", out, a, &shape, rational_piece, NULL, KN_EVERY_VAR);
    }
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline g;
    status = kn_spline_partial_knots(ctx, &g, a);
    g.ncomp = 1;
    if (status == KN_OK)
        status = kn_spline_shape(ctx, "spline_divergence", g.nvars, g.ncomp, false, g.degree, g.count);
    if (status == KN_OK) {
        double *part = kn_scratch(ctx, kn_spline_count(&g), sizeof *part);
        g.coef = kn_scratch(ctx, kn_spline_count(&g), sizeof *g.coef);
        status = part && g.coef ? sum_partials(ctx, g.coef, part, a, &g) : KN_ENOMEM;
    }
    if (status == KN_OK) status = kn_spline_store(ctx, out, &g);
    kn_scratch_release(ctx, mark);
    return status;
}
