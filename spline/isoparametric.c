// SPDX-License-Identifier: Apache-2.0
// The spline of one variable less where one parameter is fixed.
#include "spline/internal.h"
#include "kernel/context.h"

// A map to one row: c(..) = sum_k N_k(at) c(.., first + k, ..), terms with N_k = 0 left out.
static void contract(double *to, const kn_spline *a, int var, double at)
{
    double w[KN_MAX_DEGREE + 1];
    int p = a->degree[var], span = kn_knots_span(a->knots[var], p, a->count[var], at), first = span - p;
    kn_knots_basis(w, a->knots[var], p, span, at, 0);
    kn_band row = {.rows = 1, .width = p + 1, .first = &first, .w = w};
    kn_band_apply(to, &row, a->coef, kn_spline_outer(a, var), a->count[var], kn_spline_inner(a, var));
}

kn_status kn_spline_isoparametric(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var, double at)
{
    kn_status status = kn_spline_expect(ctx, "spline_isoparametric", a, var);
    if (status != KN_OK) return status;
    if (a->nvars == 1)
        return kn_fail(ctx, KN_EDOMAIN, "spline_isoparametric: a curve; its points come from kn_spline_eval");
    kn_spline s = {.nvars = a->nvars - 1, .ncomp = a->ncomp, .rational = a->rational};
    for (int d = 0, n = 0; d < a->nvars; d++)
        if (d != var) s.degree[n] = a->degree[d], s.count[n] = a->count[d], s.knots[n++] = a->knots[d];
    kn_mark mark = kn_scratch_mark(ctx);
    s.coef = kn_scratch(ctx, kn_spline_count(&s) * (size_t)s.ncomp, sizeof *s.coef);
    status = s.coef ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        contract(s.coef, a, var, at);
        status = kn_spline_store(ctx, out, &s); // last: out may be a
    }
    kn_scratch_release(ctx, mark);
    return status;
}
