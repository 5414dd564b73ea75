// SPDX-License-Identifier: Apache-2.0
// T as one trivariate spline.
#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "trivar/internal.h"

#include <math.h>

static kn_status gather(kn_ctx *ctx, kn_spline *term, int *power, int *degree, const kn_shell *shell, int n)
{
    kn_status status = KN_OK;
    *degree = 1;
    for (int t = 0; t < n && status == KN_OK; t++) {
        status = kn_shell_term(ctx, &term[t], &power[t], shell, t);
        if (power[t] > *degree) *degree = power[t];
    }
    return status == KN_OK ? kn_spline_make_compatible(ctx, term, n) : status;
}

static kn_status combine(kn_ctx *ctx, kn_spline *out, const kn_spline *term, const int *power, int n, int top,
                         bool rational, const double w[2])
{
    const kn_spline *first = &term[0];
    double knots[2 * (KN_MAX_DEGREE + 1)], wk[KN_MAX_DEGREE + 1];
    int degree[3] = {first->degree[0], first->degree[1], top}, count[3] = {first->count[0], first->count[1], top + 1};
    const double *all[3] = {first->knots[0], first->knots[1], knots};
    for (int i = 0; i <= top; i++) knots[i] = w[0], knots[top + 1 + i] = w[1];
    kn_spline v = {0};
    kn_status status = kn_spline_init(ctx, &v, 3, first->ncomp, rational, degree, count, all, NULL);
    if (status != KN_OK) return status;
    size_t points = kn_spline_count(first) * (size_t)first->ncomp, row = (size_t)top + 1;
    for (int t = 0; t < n; t++) {
        kn_bernstein_power(wk, power[t], top, w[0], w[1]);
        for (size_t i = 0; i < points; i++)
            for (size_t j = 0; j < row; j++) v.coef[i * row + j] += term[t].coef[i] * wk[j];
    }
    kn_spline_swap(out, &v);
    kn_spline_clear(ctx, &v);
    return KN_OK;
}

static kn_status from_terms(kn_ctx *ctx, kn_spline *out, const kn_shell *shell, const double w[2])
{
    kn_spline term[KN_SHELL_TERMS + 1] = {{0}};
    int power[KN_SHELL_TERMS + 1], top = 0, n = kn_shell_nterms(shell);
    kn_status status = gather(ctx, term, power, &top, shell, n);
    if (status == KN_OK) status = combine(ctx, out, term, power, n, top, shell->surface.rational, w);
    for (int t = 0; t < n; t++) kn_spline_clear(ctx, &term[t]);
    return status;
}

kn_status kn_shell_volume(kn_ctx *ctx, kn_spline *out, const kn_shell *shell, double w0, double w1)
{
    const double w[2] = {w0, w1};
    if (!(w0 < w1) || !isfinite(w1 - w0)) return kn_fail(ctx, KN_EDOMAIN, "shell: heights [%g, %g]", w0, w1);
    if (!shell->volume.coef) return from_terms(ctx, out, shell, w);
    double lo[3], hi[3];
    for (int v = 0; v < 2; v++) kn_spline_domain(&shell->volume, v, &lo[v], &hi[v]);
    lo[2] = w0, hi[2] = w1;
    return kn_spline_restrict(ctx, out, &shell->volume, lo, hi);
}
