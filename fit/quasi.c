// SPDX-License-Identifier: Apache-2.0
// Quasi-interpolation: values at Greville's sites, then one banded map for each variable.
#include <string.h>

#include "fit/internal.h"
#include "kernel/context.h"
#include "spline/internal.h"

static kn_status find_sites(kn_ctx *ctx, double **sites, const kn_spline *s)
{
    for (int d = 0; d < s->nvars; d++) {
        sites[d] = kn_scratch(ctx, (size_t)s->count[d], sizeof *sites[d]);
        if (!sites[d]) return KN_ENOMEM;
        kn_status status = kn_fit_greville(ctx, sites[d], s->knots[d], s->degree[d], s->count[d]);
        if (status != KN_OK) return status;
        for (int i = 1; i < s->count[d]; i++)
            if (!(sites[d][i - 1] < sites[d][i]))
                return kn_fail(ctx, KN_EDOMAIN, "fit_quasi: variable %d: a jump at knot %g", d, sites[d][i]);
    }
    return KN_OK;
}

kn_status kn_fit_sample(kn_ctx *ctx, kn_spline *s, double *const *sites, kn_fit_function function, void *user)
{
    size_t n = kn_spline_count(s);
    int k[KN_MAX_VARS] = {0};
    double at[KN_MAX_VARS], value[KN_MAX_COMPS];
    for (size_t i = 0; i < n; i++) {
        for (int d = 0; d < s->nvars; d++) at[d] = sites[d][k[d]];
        kn_status status = function(user, value, at);
        if (status != KN_OK) return kn_fail(ctx, status, "fit: the function failed at site %zu", i);
        for (size_t c = 0; c < (size_t)s->ncomp; c++) s->coef[c * n + i] = value[c];
        for (int d = s->nvars - 1; d >= 0 && ++k[d] == s->count[d]; d--) k[d] = 0;
    }
    return KN_OK;
}

kn_status kn_fit_quasi_apply(kn_ctx *ctx, kn_spline *s, double *const *sites)
{
    kn_mark mark = kn_scratch_mark(ctx);
    size_t n = kn_spline_count(s) * (size_t)s->ncomp;
    double *work = kn_scratch(ctx, n, sizeof *work);
    kn_status status = work ? KN_OK : KN_ENOMEM;
    for (int d = 0; d < s->nvars && status == KN_OK; d++) {
        kn_mark inner = kn_scratch_mark(ctx);
        kn_band band;
        status = kn_fit_quasi_band(ctx, &band, s->knots[d], s->degree[d], s->count[d], sites[d]);
        if (status == KN_OK) {
            memcpy(work, s->coef, n * sizeof *work);
            kn_band_apply(s->coef, &band, work, kn_spline_outer(s, d), s->count[d], kn_spline_inner(s, d));
        }
        kn_scratch_release(ctx, inner);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_fit_quasi(kn_ctx *ctx, kn_spline *out, int nvars, int dim, const int *degree, const int *count,
                       const double *const *knots, kn_fit_function function, void *user)
{
    kn_spline s;
    double *sites[KN_MAX_VARS] = {NULL};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_fit_start(ctx, "fit_quasi", &s, nvars, dim, degree, count, knots);
    if (status == KN_OK) status = find_sites(ctx, sites, &s);
    if (status == KN_OK) status = kn_fit_sample(ctx, &s, sites, function, user);
    if (status == KN_OK) status = kn_fit_quasi_apply(ctx, &s, sites);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    kn_scratch_release(ctx, mark);
    return status;
}
