// SPDX-License-Identifier: Apache-2.0
// The life of a tile.
#include "kernel/context.h"

#include <knurl/tile.h>
#include <string.h>

kn_status kn_tile_init(kn_ctx *ctx, kn_tile *out, const char *name, int nparts)
{
    if (nparts < 1) return kn_fail(ctx, KN_EDOMAIN, "tile: %d parts", nparts);
    if (strlen(name) >= KN_NAME_BYTES)
        return kn_fail(ctx, KN_ELIMIT, "tile: a name longer than %d bytes", KN_NAME_BYTES - 1);
    kn_tile tile = {.aspect = 1.0, .nparts = nparts};
    memcpy(tile.name, name, strlen(name));
    tile.parts = kn_alloc_zero(ctx, (size_t)nparts, sizeof *tile.parts);
    if (!tile.parts) return KN_ENOMEM;
    *out = tile;
    return KN_OK;
}

void kn_tile_clear(kn_ctx *ctx, kn_tile *tile)
{
    if (!tile) return;
    for (int p = 0; p < tile->nparts; p++) {
        kn_tile_part *part = &tile->parts[p];
        for (int s = 0; s < part->nsplines; s++) kn_spline_clear(ctx, &part->splines[s]);
        kn_free(ctx, part->splines);
    }
    kn_free(ctx, tile->parts);
    *tile = (kn_tile){0};
}

kn_status kn_tile_add(kn_ctx *ctx, kn_tile *tile, int part, const kn_spline *surface)
{
    if (part < 0 || part >= tile->nparts) return kn_fail(ctx, KN_EDOMAIN, "tile: part %d of %d", part, tile->nparts);
    kn_tile_part *to = &tile->parts[part];
    size_t n = (size_t)to->nsplines;
    kn_spline copy = {0}, *list = kn_alloc(ctx, n + 1, sizeof *list);
    kn_status status = list ? kn_spline_copy(ctx, &copy, surface) : KN_ENOMEM;
    if (status != KN_OK) {
        kn_free(ctx, list);
        return status;
    }
    for (size_t i = 0; i < n; i++) list[i] = to->splines[i];
    list[n] = copy;
    kn_free(ctx, to->splines);
    to->splines = list;
    to->nsplines++;
    return KN_OK;
}
