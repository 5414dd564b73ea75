// SPDX-License-Identifier: Apache-2.0
// kn_tile_add, kn_tile_add_trimmed: splines of a part.
#include "tile/internal.h"

#include <string.h>

// The lists of a part with one more spline in them; what is not wanted stays NULL.
typedef struct longer {
    kn_spline *splines, *targets;
    kn_trim *trims;
} longer;

static void drop(kn_ctx *ctx, longer *l)
{
    kn_free(ctx, l->splines);
    kn_free(ctx, l->targets);
    kn_free(ctx, l->trims);
}

static kn_status make_room(kn_ctx *ctx, longer *l, const kn_tile_part *part, int nparameters, bool trimmed)
{
    size_t n = (size_t)part->nsplines + 1, k = (size_t)nparameters;
    bool trims = trimmed || part->trims;
    l->splines = kn_alloc_zero(ctx, n, sizeof *l->splines);
    if (l->splines && trims) l->trims = kn_alloc_zero(ctx, n, sizeof *l->trims);
    if (l->splines && part->targets) l->targets = kn_alloc_zero(ctx, k * n, sizeof *l->targets);
    if (l->splines && (l->trims || !trims) && (l->targets || !part->targets)) return KN_OK;
    drop(ctx, l);
    return KN_ENOMEM;
}

static void take(kn_ctx *ctx, longer *l, kn_tile_part *part, int nparameters)
{
    size_t n = (size_t)part->nsplines;
    if (n > 0) memcpy(l->splines, part->splines, n * sizeof *l->splines);
    if (n > 0 && part->trims) memcpy(l->trims, part->trims, n * sizeof *l->trims);
    for (size_t k = 0; n > 0 && part->targets && k < (size_t)nparameters; k++)
        memcpy(l->targets + k * (n + 1), part->targets + k * n, n * sizeof *l->targets);
    kn_free(ctx, part->splines);
    kn_free(ctx, part->trims);
    kn_free(ctx, part->targets);
    part->splines = l->splines;
    part->trims = l->trims;
    part->targets = l->targets;
    part->nsplines++;
}

kn_status kn_tile_add_trimmed(kn_ctx *ctx, kn_tile *tile, int part, const kn_spline *surface, const kn_trim *trim)
{
    if (part < 0 || part >= tile->nparts) return kn_fail(ctx, KN_EDOMAIN, "tile: part %d of %d", part, tile->nparts);
    if (trim && surface->nvars != 2)
        return kn_fail(ctx, KN_EDOMAIN, "tile: a spline of %d variables cannot be trimmed", surface->nvars);
    kn_tile_part *to = &tile->parts[part];
    int n = to->nsplines;
    longer l = {0};
    kn_spline copy = {0};
    kn_trim region = {0};
    kn_status status = kn_spline_copy(ctx, &copy, surface);
    if (status == KN_OK && trim) status = kn_trim_copy(ctx, &region, trim);
    if (status == KN_OK) status = make_room(ctx, &l, to, tile->nparameters, trim != NULL);
    if (status != KN_OK) {
        kn_spline_clear(ctx, &copy);
        kn_trim_clear(ctx, &region);
        return status;
    }
    take(ctx, &l, to, tile->nparameters);
    to->splines[n] = copy;
    if (to->trims) to->trims[n] = region;
    return KN_OK;
}

kn_status kn_tile_add(kn_ctx *ctx, kn_tile *tile, int part, const kn_spline *spline)
{
    return kn_tile_add_trimmed(ctx, tile, part, spline, NULL);
}
