// SPDX-License-Identifier: Apache-2.0
// kn_tile_set_mesh.
#include "tile/internal.h"

kn_status kn_tile_set_mesh(kn_ctx *ctx, kn_tile *tile, int part, const kn_mesh *mesh)
{
    if (part < 0 || part >= tile->nparts) return kn_fail(ctx, KN_EDOMAIN, "tile: part %d of %d", part, tile->nparts);
    kn_tile_part *to = &tile->parts[part];
    kn_status status = kn_mesh_copy(ctx, &to->mesh, mesh);
    if (status != KN_OK) return status;
    for (int k = 0; to->mesh_targets && k < tile->nparameters; k++) kn_free(ctx, to->mesh_targets[k]);
    kn_free(ctx, to->mesh_targets);
    to->mesh_targets = NULL;
    return KN_OK;
}
