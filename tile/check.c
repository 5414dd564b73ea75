// SPDX-License-Identifier: Apache-2.0
// Whether a tile can be used.
#include "tile/internal.h"

#include <math.h>

kn_status kn_tile_check(kn_ctx *ctx, const kn_tile *tile)
{
    size_t things = 0;
    kn_status status = KN_OK;
    if (!isfinite(tile->aspect) || tile->aspect < 0.0)
        return kn_fail(ctx, KN_EDOMAIN, "tile: aspect %g", tile->aspect);
    for (int p = 0; status == KN_OK && p < tile->nparts; p++) {
        const kn_tile_part *part = &tile->parts[p];
        for (int s = 0; status == KN_OK && s < part->nsplines; s++) status = kn_tile_check_spline(ctx, part, s);
        if (status == KN_OK) status = kn_tile_check_mesh(ctx, part);
        things += (size_t)part->nsplines + part->mesh.ntriangles;
    }
    if (status == KN_OK && things == 0) return kn_fail(ctx, KN_EDOMAIN, "tile: nothing in it");
    return status == KN_OK ? kn_tile_check_parameters(ctx, tile) : status;
}
