// SPDX-License-Identifier: Apache-2.0
// Whether a spline can be part of a tile: its values, that it is no less than it should be, and its trim.
#include "tile/internal.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

static const char *const KIND[] = {"", "curve", "surface", "volume"};

static double largest(const kn_bezier *b)
{
    double most = 0.0;
    size_t n = (size_t)b->ncomp * kn_bezier_count(b);
    for (size_t i = 0; i < n; i++) most = fmax(most, fabs(b->coef[i]));
    return most;
}

// P_r of a curve, P_r x P_s of a surface, det(P_r, P_s, P_t) of a volume. *noise: below this its coefficients are
// rounding of differences and products of coefficients.
static kn_status measure(kn_ctx *ctx, kn_bezier *out, double *noise, const kn_bezier *patch)
{
    kn_bezier d[3] = {{0}, {0}, {0}};
    kn_status status = KN_OK;
    double slope = 0.0, steps = 0.0;
    for (int v = 0; status == KN_OK && v < patch->nvars; v++) {
        status = kn_bezier_derivative(ctx, &d[v], patch, v);
        if (status == KN_OK) slope += largest(&d[v]);
        steps += patch->degree[v];
    }
    *noise = 16.0 * DBL_EPSILON * steps * largest(patch);
    for (int v = 1; v < patch->nvars; v++) *noise *= slope;
    if (status == KN_OK && patch->nvars == 1) kn_bezier_swap(out, &d[0]);
    if (status == KN_OK && patch->nvars > 1) status = kn_bezier_cross(ctx, out, &d[0], &d[1]);
    if (status == KN_OK && patch->nvars > 2) status = kn_bezier_dot(ctx, out, out, &d[2]);
    for (int v = 0; v < 3; v++) kn_bezier_clear(ctx, &d[v]);
    return status;
}

// Some piece has to have length, area or volume, and a volume none that is certainly turned inside out: its
// determinant would be negative everywhere.
static kn_status check_size(kn_ctx *ctx, const kn_tile_part *part, int spline)
{
    static const char *const LACKS[] = {"", "length", "area", "volume"};
    const kn_spline *s = &part->splines[spline];
    kn_bezier *pieces = NULL, m = {0};
    size_t n = 0;
    bool yes = false, left = false;
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, s);
    for (size_t i = 0; status == KN_OK && (!yes || s->nvars == 3) && i < n; i++) {
        double noise;
        status = measure(ctx, &m, &noise, &pieces[i]);
        if (status != KN_OK) continue;
        yes = yes || largest(&m) > noise;
        size_t k = 0, count = kn_bezier_count(&m);
        while (k < count && m.coef[k] < -noise) k++;
        left = left || (s->nvars == 3 && k == count);
    }
    for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    kn_bezier_clear(ctx, &m);
    if (status == KN_OK && !yes)
        return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\", %s %d has no %s", part->name, KIND[s->nvars], spline,
                       LACKS[s->nvars]);
    if (status == KN_OK && left)
        return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\", volume %d is left-handed", part->name, spline);
    return status;
}

static kn_status check_trim(kn_ctx *ctx, const kn_tile_part *part, int spline)
{
    const kn_trim *t = &part->trims[spline];
    if (t->nloops == 0) return KN_OK;
    if (part->splines[spline].nvars != 2)
        return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\", %s %d cannot be trimmed", part->name,
                       KIND[part->splines[spline].nvars], spline);
    kn_status status = kn_trim_check(ctx, t);
    if (status != KN_EDOMAIN) return status;
    char message[400]; // which does not say where
    (void)snprintf(message, sizeof message, "%s", kn_ctx_message(ctx));
    kn_ctx_clear_error(ctx);
    return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\", surface %d: %s", part->name, spline, message);
}

kn_status kn_tile_check_spline(kn_ctx *ctx, const kn_tile_part *part, int spline)
{
    const kn_spline *s = &part->splines[spline];
    if (s->nvars < 1 || s->nvars > 3)
        return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\", spline %d is no curve, surface or volume", part->name,
                       spline);
    if (s->ncomp != 3 || s->rational)
        return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\", %s %d has no polynomial values (u,v,w)", part->name,
                       KIND[s->nvars], spline);
    size_t n = 3 * kn_spline_count(s);
    for (size_t i = 0; s->coef && i < n; i++)
        if (!isfinite(s->coef[i]))
            return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\", %s %d is not finite", part->name, KIND[s->nvars],
                           spline);
    kn_status status = kn_spline_check(ctx, s);
    if (status == KN_OK) status = check_size(ctx, part, spline);
    return status == KN_OK && part->trims ? check_trim(ctx, part, spline) : status;
}
