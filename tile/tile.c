// SPDX-License-Identifier: Apache-2.0
// The life of a tile.
#include "tile/internal.h"

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

static void clear_part(kn_ctx *ctx, kn_tile_part *part, int nparameters)
{
    for (int s = 0; s < part->nsplines; s++) {
        kn_spline_clear(ctx, &part->splines[s]);
        if (part->trims) kn_trim_clear(ctx, &part->trims[s]);
    }
    for (int i = 0; part->targets && i < nparameters * part->nsplines; i++) kn_spline_clear(ctx, &part->targets[i]);
    for (int k = 0; part->mesh_targets && k < nparameters; k++) kn_free(ctx, part->mesh_targets[k]);
    kn_free(ctx, part->splines);
    kn_free(ctx, part->trims);
    kn_free(ctx, part->targets);
    kn_free(ctx, part->mesh_targets);
    kn_mesh_clear(ctx, &part->mesh);
}

void kn_tile_clear(kn_ctx *ctx, kn_tile *tile)
{
    if (!tile) return;
    for (int p = 0; p < tile->nparts; p++) clear_part(ctx, &tile->parts[p], tile->nparameters);
    kn_free(ctx, tile->parts);
    kn_free(ctx, tile->parameters);
    *tile = (kn_tile){0};
}
