// SPDX-License-Identifier: Apache-2.0
// What the operations on kn_spline share: storage, and maps along one variable.
#include <string.h>

#include "spline/internal.h"

#include "kernel/context.h"

kn_status kn_spline_shape(kn_ctx *ctx, const char *call, int nvars, int ncomp, bool rational, const int *degree,
                          const int *count)
{
    if (nvars < 1 || ncomp < 1 + rational)
        return kn_fail(ctx, KN_EDOMAIN, "%s: nvars %d, ncomp %d%s", call, nvars, ncomp, rational ? ", rational" : "");
    if (nvars > KN_MAX_VARS || ncomp > KN_MAX_COMPS)
        return kn_fail(ctx, KN_ELIMIT, "%s: nvars %d, ncomp %d", call, nvars, ncomp);
    size_t total = (size_t)ncomp;
    for (int d = 0; d < nvars; d++) {
        if (degree[d] < 0 || count[d] < degree[d] + 1)
            return kn_fail(ctx, KN_EDOMAIN, "%s: degree %d, count %d in variable %d", call, degree[d], count[d], d);
        if (degree[d] > KN_MAX_DEGREE)
            return kn_fail(ctx, KN_ELIMIT, "%s: degree %d in variable %d", call, degree[d], d);
        if ((size_t)count[d] > KN_MAX_COEFS / total)
            return kn_fail(ctx, KN_ELIMIT, "%s: more than %zu coefficients", call, KN_MAX_COEFS);
        total *= (size_t)count[d];
    }
    return KN_OK;
}

kn_status kn_spline_alloc(kn_ctx *ctx, kn_spline *out, int nvars, int ncomp, bool rational, const int *degree,
                          const int *count)
{
    kn_spline s = {.nvars = nvars, .ncomp = ncomp, .rational = rational};
    bool ok = true;
    for (int d = 0; d < nvars; d++) {
        s.degree[d] = degree[d], s.count[d] = count[d];
        if (ok) s.knots[d] = kn_alloc(ctx, (size_t)count[d] + (size_t)degree[d] + 1, sizeof(double));
        ok = ok && s.knots[d];
    }
    if (ok) s.coef = kn_alloc(ctx, kn_spline_count(&s) * (size_t)ncomp, sizeof(double));
    if (!s.coef) {
        kn_spline_clear(ctx, &s);
        return KN_ENOMEM;
    }
    *out = s;
    return KN_OK;
}

kn_status kn_spline_in_scratch(kn_ctx *ctx, const char *call, kn_spline *s)
{
    kn_status status = kn_spline_shape(ctx, call, s->nvars, s->ncomp, s->rational, s->degree, s->count);
    if (status != KN_OK) return status;
    for (int d = 0; d < s->nvars; d++) {
        s->knots[d] = kn_scratch(ctx, (size_t)s->count[d] + (size_t)s->degree[d] + 1, sizeof *s->knots[d]);
        if (!s->knots[d]) return KN_ENOMEM;
    }
    s->coef = kn_scratch(ctx, kn_spline_count(s) * (size_t)s->ncomp, sizeof *s->coef);
    return s->coef ? KN_OK : KN_ENOMEM;
}

kn_status kn_spline_expect(kn_ctx *ctx, const char *call, const kn_spline *s, int var)
{
    if (s->nvars < 1) return kn_fail(ctx, KN_EDOMAIN, "%s: an empty spline", call);
    if (var < 0 || var >= s->nvars) return kn_fail(ctx, KN_EDOMAIN, "%s: variable %d of %d", call, var, s->nvars);
    return KN_OK;
}

size_t kn_spline_inner(const kn_spline *s, int var)
{
    size_t n = 1;
    for (int d = var + 1; d < s->nvars; d++) n *= (size_t)s->count[d];
    return n;
}

size_t kn_spline_outer(const kn_spline *s, int var)
{
    size_t n = (size_t)s->ncomp;
    for (int d = 0; d < var; d++) n *= (size_t)s->count[d];
    return n;
}

kn_status kn_spline_band(kn_ctx *ctx, kn_band *band, int rows, int width)
{
    *band = (kn_band){.rows = rows, .width = width};
    band->first = kn_scratch(ctx, (size_t)rows, sizeof *band->first);
    band->w = kn_scratch(ctx, (size_t)rows * (size_t)width, sizeof *band->w);
    return band->first && band->w ? KN_OK : KN_ENOMEM;
}

kn_status kn_spline_refining_band(kn_ctx *ctx, kn_band *band, int rows, int width)
{
    kn_status status = kn_spline_band(ctx, band, rows, width);
    if (status == KN_OK) band->terms = kn_scratch(ctx, (size_t)rows, sizeof *band->terms);
    return status == KN_OK && !band->terms ? KN_ENOMEM : status;
}

// to = s with other knots, rows + degree + 1 of them, in var; its arrays of var and of coefficients are new, the latter
// not filled.
static kn_status remade(kn_ctx *ctx, kn_spline *to, const kn_spline *s, int var, int degree, const double *knots,
                        int rows)
{
    *to = *s;
    to->degree[var] = degree, to->count[var] = rows;
    kn_status status = kn_spline_shape(ctx, "spline", to->nvars, to->ncomp, to->rational, to->degree, to->count);
    if (status != KN_OK) return status;
    size_t nknots = (size_t)rows + (size_t)degree + 1;
    to->knots[var] = kn_scratch(ctx, nknots, sizeof *to->knots[var]);
    to->coef = kn_scratch(ctx, kn_spline_count(to) * (size_t)to->ncomp, sizeof *to->coef);
    if (!to->knots[var] || !to->coef) return KN_ENOMEM;
    memcpy(to->knots[var], knots, nknots * sizeof *knots);
    return KN_OK;
}

kn_status kn_spline_map_in_scratch(kn_ctx *ctx, kn_spline *s, int var, int degree, const double *knots,
                                   const kn_band *band)
{
    kn_spline to;
    kn_status status = remade(ctx, &to, s, var, degree, knots, band->rows);
    if (status != KN_OK) return status;
    kn_band_apply(to.coef, band, s->coef, kn_spline_outer(s, var), s->count[var], kn_spline_inner(s, var));
    *s = to;
    return KN_OK;
}

// The result's arrays are taken before the band, which is given back.
kn_status kn_spline_refine_in_scratch(kn_ctx *ctx, kn_spline *s, int var, const double *to, int rows)
{
    kn_spline t;
    kn_status status = remade(ctx, &t, s, var, s->degree[var], to, rows);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_band band;
    status = kn_spline_refining_band(ctx, &band, rows, s->degree[var] + 1);
    if (status == KN_OK) {
        kn_band_refine(&band, s->knots[var], s->degree[var], s->count[var], to);
        kn_band_apply(t.coef, &band, s->coef, kn_spline_outer(s, var), s->count[var], kn_spline_inner(s, var));
        *s = t;
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_spline_expect_pair(kn_ctx *ctx, const char *call, const kn_spline *a, const kn_spline *b)
{
    kn_status status = kn_spline_expect(ctx, call, a, 0);
    if (status == KN_OK) status = kn_spline_expect(ctx, call, b, 0);
    if (status != KN_OK) return status;
    if (a->nvars != b->nvars) return kn_fail(ctx, KN_EDOMAIN, "%s: %d and %d variables", call, a->nvars, b->nvars);
    for (int d = 0; d < a->nvars; d++) {
        double lo[2], hi[2];
        kn_spline_domain(a, d, &lo[0], &hi[0]);
        kn_spline_domain(b, d, &lo[1], &hi[1]);
        if (lo[0] != lo[1] || hi[0] != hi[1])
            return kn_fail(ctx, KN_EDOMAIN, "%s: variable %d: domains [%g, %g] and [%g, %g]", call, d, lo[0], hi[0],
                           lo[1], hi[1]);
    }
    return KN_OK;
}
