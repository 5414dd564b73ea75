// SPDX-License-Identifier: Apache-2.0
// The spline of one variable less where one parameter is fixed.
#include "spline/internal.h"
#include "kernel/context.h"

#include <string.h>

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
    kn_spline s = {0};
    int degree[KN_MAX_VARS], count[KN_MAX_VARS], n = 0, from[KN_MAX_VARS];
    for (int d = 0; d < a->nvars; d++)
        if (d != var) degree[n] = a->degree[d], count[n] = a->count[d], from[n++] = d;
    status = kn_spline_alloc(ctx, &s, n, a->ncomp, a->rational, degree, count);
    if (status != KN_OK) return status;
    for (int d = 0; d < n; d++)
        memcpy(s.knots[d], a->knots[from[d]], ((size_t)count[d] + (size_t)degree[d] + 1) * sizeof(double));
    contract(s.coef, a, var, at);
    kn_spline_swap(out, &s); // last: out may be a
    kn_spline_clear(ctx, &s);
    return KN_OK;
}
