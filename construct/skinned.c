// SPDX-License-Identifier: Apache-2.0
// Surfaces through curves, volumes through surfaces: control points of compatible sections, interpolated one by one.
#include <knurl/fit.h>

#include "construct/internal.h"
#include "kernel/banded.h"
#include "kernel/context.h"
#include "spline/internal.h"

static const char call[] = "construct_skinned";

static kn_status chord_lengths(kn_ctx *ctx, double *site, const kn_spline *s, int n)
{
    size_t count = kn_spline_count(s), dim = (size_t)kn_spline_dim(s);
    double *points = kn_scratch(ctx, (size_t)n * count * dim, sizeof *points), *to = points;
    if (!points) return KN_ENOMEM;
    for (int k = 0; k < n; k++)
        for (size_t i = 0; i < count; i++)
            for (size_t c = 0; c < dim; c++, to++) {
                *to = s[k].coef[c * count + i];
                if (s[k].rational) *to /= s[k].coef[dim * count + i];
            }
    return kn_fit_parameters(ctx, site, 2, (int)dim, (const int[]){n, (int)count}, points, 0, 1.0);
}

static kn_status solve(kn_ctx *ctx, kn_spline *s, const double *site)
{
    int var = s->nvars - 1, n = s->count[var], p = s->degree[var];
    kn_collocation c = {.count = n, .degree = p};
    int *span = kn_scratch(ctx, (size_t)n, sizeof *span);
    c.band = kn_scratch(ctx, kn_collocation_room(n, p), sizeof *c.band);
    if (!span || !c.band) return KN_ENOMEM;
    for (int i = 0; i < n; i++) span[i] = kn_knots_span(s->knots[var], p, n, site[i]);
    kn_collocation_factor(&c, s->knots[var], site, span);
    if (!kn_collocation_regular(&c)) return kn_fail(ctx, KN_EUNDECIDED, "%s: sites are too close", call);
    kn_collocation_solve(&c, s->coef, kn_spline_count(s) / (size_t)n * (size_t)s->ncomp, 1);
    return KN_OK;
}

static kn_status skin(kn_ctx *ctx, kn_spline *out, int n, const kn_spline *sections, int degree, const double *sites)
{
    kn_spline *s = kn_scratch(ctx, (size_t)n, sizeof *s), skin;
    double *site = kn_scratch(ctx, (size_t)n, sizeof *site);
    kn_status status = s && site ? kn_construct_compatible(ctx, call, s, sections, n) : KN_ENOMEM;
    if (status == KN_OK && !sites) status = chord_lengths(ctx, site, s, n);
    for (int i = 0; i < n && sites; i++) site[i] = sites[i];
    if (status == KN_OK) status = kn_construct_extend(ctx, call, &skin, &s[0], degree, n);
    if (status == KN_OK) status = kn_fit_averaged_knots(ctx, skin.knots[s[0].nvars], degree, n, n, site);
    if (status != KN_OK) return status;
    size_t count = kn_spline_count(&s[0]) * (size_t)skin.ncomp;
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < (size_t)n; k++) skin.coef[i * (size_t)n + k] = s[k].coef[i];
    status = solve(ctx, &skin, site);
    if (status == KN_OK) status = kn_construct_check_weights(ctx, call, &skin);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &skin);
    return status;
}

kn_status kn_construct_skinned(kn_ctx *ctx, kn_spline *out, int n, const kn_spline *sections, int degree,
                               const double *sites)
{
    if (n < 2 || degree < 1 || degree >= n)
        return kn_fail(ctx, KN_EDOMAIN, "%s: %d sections and degree %d", call, n, degree);
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = skin(ctx, out, n, sections, degree, sites);
    kn_scratch_release(ctx, mark);
    return status;
}
