// SPDX-License-Identifier: Apache-2.0
// Whether a tile can be used.
#include "kernel/context.h"

#include <float.h>
#include <knurl/tile.h>
#include <math.h>

static double largest(const kn_bezier *b)
{
    double most = 0.0;
    size_t n = (size_t)b->ncomp * kn_bezier_count(b);
    for (size_t i = 0; i < n; i++) most = fmax(most, fabs(b->coef[i]));
    return most;
}

// S_r x S_t, whose coefficients all vanish, up to the rounding of differences and products of the coefficients, when
// the patch has no area.
static kn_status has_area(kn_ctx *ctx, bool *yes, const kn_bezier *patch)
{
    kn_bezier dr = {0}, dt = {0}, n = {0};
    kn_status status = kn_bezier_derivative(ctx, &dr, patch, 0);
    if (status == KN_OK) status = kn_bezier_derivative(ctx, &dt, patch, 1);
    if (status == KN_OK) status = kn_bezier_cross(ctx, &n, &dr, &dt);
    if (status == KN_OK) {
        double size = largest(patch), slope = largest(&dr) + largest(&dt);
        double steps = patch->degree[0] + patch->degree[1];
        *yes = largest(&n) > 16.0 * DBL_EPSILON * steps * size * slope;
    }
    kn_bezier_clear(ctx, &dr);
    kn_bezier_clear(ctx, &dt);
    kn_bezier_clear(ctx, &n);
    return status;
}

static kn_status check_area(kn_ctx *ctx, const kn_tile_part *part, int surface)
{
    kn_bezier *pieces = NULL;
    size_t n = 0;
    bool yes = false;
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, &part->splines[surface]);
    for (size_t i = 0; status == KN_OK && !yes && i < n; i++) status = has_area(ctx, &yes, &pieces[i]);
    for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    if (status == KN_OK && !yes)
        return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\", surface %d has no area", part->name, surface);
    return status;
}

static kn_status check_surface(kn_ctx *ctx, const kn_tile_part *part, int surface)
{
    const kn_spline *s = &part->splines[surface];
    if (s->nvars != 2 || s->ncomp != 3 || s->rational)
        return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\", surface %d is no polynomial (u,v,w) surface", part->name,
                       surface);
    size_t n = 3 * kn_spline_count(s);
    for (size_t i = 0; s->coef && i < n; i++)
        if (!isfinite(s->coef[i]))
            return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\", surface %d is not finite", part->name, surface);
    kn_status status = kn_spline_check(ctx, s);
    return status == KN_OK ? check_area(ctx, part, surface) : status;
}

kn_status kn_tile_check(kn_ctx *ctx, const kn_tile *tile)
{
    int surfaces = 0;
    kn_status status = KN_OK;
    if (!isfinite(tile->aspect) || tile->aspect < 0.0)
        return kn_fail(ctx, KN_EDOMAIN, "tile: aspect %g", tile->aspect);
    for (int p = 0; p < tile->nparts; p++)
        for (int s = 0; status == KN_OK && s < tile->parts[p].nsplines; s++, surfaces++)
            status = check_surface(ctx, &tile->parts[p], s);
    if (status == KN_OK && surfaces == 0) return kn_fail(ctx, KN_EDOMAIN, "tile: no surfaces");
    return status;
}
