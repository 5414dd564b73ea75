// SPDX-License-Identifier: Apache-2.0
// The shell that a trivariate spline is.
#include "kernel/binomial.h"
#include "kernel/context.h"
#include "trivar/internal.h"

#include <math.h>

static kn_status check(kn_ctx *ctx, const kn_spline *v)
{
    kn_status status = kn_spline_check(ctx, v);
    if (status != KN_OK) return status;
    if (v->nvars != 3 || kn_spline_dim(v) != 3)
        return kn_fail(ctx, KN_EDOMAIN, "shell: %d variables and %d components, not a volume in space", v->nvars,
                       kn_spline_dim(v));
    for (int d = 0; d < 3; d++)
        if (v->degree[d] < 1) return kn_fail(ctx, KN_EDOMAIN, "shell: degree 0 in variable %d: no volume", d);
    if (kn_spline_spans(v, 2) == 1 && v->degree[2] >= KN_SHELL_TERMS)
        return kn_fail(ctx, KN_ELIMIT, "shell: degree %d in w, at most %d", v->degree[2], KN_SHELL_TERMS - 1);
    return KN_OK;
}

// The heights count from 0.
static kn_status take(kn_ctx *ctx, kn_shell *s, const kn_spline *volume)
{
    double lo, hi;
    kn_spline_domain(volume, 2, &lo, &hi);
    kn_status status = kn_spline_reparameterize(ctx, &s->volume, volume, 2, 0.0, hi - lo);
    return status == KN_OK ? kn_spline_isoparametric(ctx, &s->surface, &s->volume, 2, 0.0) : status;
}

// With Bernstein coefficients b_0 .. b_m over [0,H]: sum_k C(m,k) (difference k of b at 0) (w/H)^k.
static kn_status take_powers(kn_ctx *ctx, kn_shell *s)
{
    const kn_spline *v = &s->volume;
    int m = v->degree[2], degree[2] = {v->degree[0], v->degree[1]}, count[2] = {v->count[0], v->count[1]};
    const double *knots[2] = {v->knots[0], v->knots[1]};
    size_t points = kn_spline_count(&s->surface) * (size_t)v->ncomp, row = (size_t)m + 1;
    double height = v->knots[2][row], b[KN_SHELL_TERMS], scale = 1.0;
    kn_status status = KN_OK;
    for (int k = 0; k < m && status == KN_OK; k++) {
        status = kn_spline_init(ctx, &s->field[k].whole, 2, v->ncomp, false, degree, count, knots, NULL);
        s->field[k].power = k + 1;
        s->nfields = k + 1;
    }
    for (size_t i = 0; i < points && status == KN_OK; i++) {
        for (int j = 0; j <= m; j++) b[j] = v->coef[i * row + (size_t)j];
        for (int k = 1; k <= m; k++) {
            for (int j = 0; j <= m - k; j++) b[j] = b[j + 1] - b[j];
            s->field[k - 1].whole.coef[i] = kn_binomial(m, k) * b[0];
        }
    }
    for (int k = 0; k < m && status == KN_OK; k++) {
        scale /= height;
        for (size_t i = 0; i < points; i++) s->field[k].whole.coef[i] *= scale;
        status = kn_spline_check(ctx, &s->field[k].whole);
    }
    s->homogeneous = v->rational;
    return status;
}

kn_status kn_shell_from_volume(kn_ctx *ctx, kn_shell **out, const kn_spline *volume, const kn_shell_options *options)
{
    kn_shell_options o;
    kn_status status = kn_shell_resolve(ctx, &o, options);
    if (status == KN_OK) status = check(ctx, volume);
    if (status != KN_OK) return status;
    kn_shell *s = kn_alloc_zero(ctx, 1, sizeof *s);
    if (!s) return KN_ENOMEM;
    s->kind = KN_SHELL_VOLUME;
    s->normal_tol = o.normal_tol;
    status = take(ctx, s, volume);
    if (status == KN_OK && kn_spline_spans(&s->volume, 2) == 1) status = take_powers(ctx, s);
    if (status == KN_OK) status = kn_shell_set_grid(ctx, s, &o);
    if (status == KN_OK)
        *out = s;
    else
        kn_shell_destroy(ctx, s);
    return status;
}
