// SPDX-License-Identifier: Apache-2.0
// Common zeros of pieces.
#include "solve/cells.h"

#include "kernel/context.h"

// A spline with the coefficients of the piece, and knots 0 .. 0 1 .. 1, which start at knots[KN_MAX_DEGREE - degree].
static void borrow(kn_spline *out, const kn_bezier *a, double *knots)
{
    *out = (kn_spline){.nvars = a->nvars, .ncomp = a->ncomp, .rational = a->rational, .coef = a->coef};
    for (int d = 0; d < a->nvars && d < KN_MAX_VARS; d++) {
        out->degree[d] = a->degree[d];
        out->count[d] = a->degree[d] + 1;
        out->knots[d] = knots +
                        (a->degree[d] >= 0 && a->degree[d] <= KN_MAX_DEGREE ? KN_MAX_DEGREE - a->degree[d] : 0);
    }
}

kn_status kn_solve_zeros_bezier(kn_ctx *ctx, kn_root **roots, size_t *nroots, kn_solve_report *report,
                                const kn_bezier *f, int nf, const kn_solve_options *options)
{
    double knots[2 * (KN_MAX_DEGREE + 1)];
    if (nf < 1 || nf > KN_MAX_COMPS) return kn_fail(ctx, KN_EDOMAIN, "zeros: %d functions", nf);
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline *s = kn_scratch(ctx, (size_t)nf, sizeof *s);
    kn_status status = s ? KN_OK : KN_ENOMEM;
    for (int i = 0; i < 2 * (KN_MAX_DEGREE + 1); i++) knots[i] = i > KN_MAX_DEGREE;
    for (int i = 0; i < nf && status == KN_OK; i++) {
        if (!f[i].coef) status = kn_fail(ctx, KN_EDOMAIN, "zeros: function %d is empty", i);
        borrow(&s[i], &f[i], knots);
    }
    if (status == KN_OK) status = kn_solve_zeros(ctx, roots, nroots, report, s, nf, options);
    kn_scratch_release(ctx, mark);
    return status;
}
