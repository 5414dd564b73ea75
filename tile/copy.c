// SPDX-License-Identifier: Apache-2.0
// kn_tile_copy.
#include "tile/internal.h"

#include <string.h>

void kn_tile_free_splines(kn_ctx *ctx, kn_spline *list, int n)
{
    for (int i = 0; list && i < n; i++) kn_spline_clear(ctx, &list[i]);
    kn_free(ctx, list);
}

kn_spline *kn_tile_copy_splines(kn_ctx *ctx, const kn_spline *list, int n)
{
    kn_spline *copy = kn_alloc_zero(ctx, (size_t)n, sizeof *copy);
    kn_status status = copy ? KN_OK : KN_ENOMEM;
    for (int i = 0; status == KN_OK && i < n; i++)
        if (list[i].coef) status = kn_spline_copy(ctx, &copy[i], &list[i]);
    if (status == KN_OK) return copy;
    kn_tile_free_splines(ctx, copy, n);
    return NULL;
}

static kn_status copy_trims(kn_ctx *ctx, kn_tile_part *to, const kn_tile_part *from)
{
    to->trims = kn_alloc_zero(ctx, (size_t)from->nsplines, sizeof *to->trims);
    kn_status status = to->trims ? KN_OK : KN_ENOMEM;
    for (int s = 0; status == KN_OK && s < from->nsplines; s++)
        status = kn_trim_copy(ctx, &to->trims[s], &from->trims[s]);
    return status;
}

static kn_status copy_mesh(kn_ctx *ctx, kn_tile_part *to, const kn_tile_part *from, int nparameters)
{
    kn_status status = kn_mesh_copy(ctx, &to->mesh, &from->mesh);
    if (status != KN_OK || !from->mesh_targets) return status;
    to->mesh_targets = kn_alloc_zero(ctx, (size_t)nparameters, sizeof *to->mesh_targets);
    if (!to->mesh_targets) return KN_ENOMEM;
    for (int k = 0; k < nparameters; k++) {
        if (!from->mesh_targets[k]) continue;
        size_t n = 3 * from->mesh.nvertices;
        to->mesh_targets[k] = kn_alloc(ctx, n, sizeof **to->mesh_targets);
        if (!to->mesh_targets[k]) return KN_ENOMEM;
        memcpy(to->mesh_targets[k], from->mesh_targets[k], n * sizeof **to->mesh_targets);
    }
    return KN_OK;
}

// On failure too *to can be cleared.
static kn_status copy_part(kn_ctx *ctx, kn_tile_part *to, const kn_tile_part *from, int nparameters)
{
    kn_status status = KN_OK;
    memcpy(to->name, from->name, sizeof to->name);
    to->material = from->material;
    to->plain = from->plain;
    if (from->nsplines > 0) {
        to->splines = kn_tile_copy_splines(ctx, from->splines, from->nsplines);
        if (!to->splines) return KN_ENOMEM;
        to->nsplines = from->nsplines;
        if (from->trims) status = copy_trims(ctx, to, from);
        if (status == KN_OK && from->targets) {
            to->targets = kn_tile_copy_splines(ctx, from->targets, nparameters * from->nsplines);
            if (!to->targets) status = KN_ENOMEM;
        }
    }
    return status == KN_OK ? copy_mesh(ctx, to, from, nparameters) : status;
}

kn_status kn_tile_copy(kn_ctx *ctx, kn_tile *out, const kn_tile *tile)
{
    kn_tile copy = *tile;
    size_t n = (size_t)tile->nparts, k = (size_t)tile->nparameters;
    copy.parameters = NULL;
    copy.parts = kn_alloc_zero(ctx, n, sizeof *copy.parts);
    if (copy.parts && k > 0) copy.parameters = kn_alloc(ctx, k, sizeof *copy.parameters);
    if (!copy.parts || (k > 0 && !copy.parameters)) {
        kn_free(ctx, copy.parts);
        return KN_ENOMEM;
    }
    if (k > 0) memcpy(copy.parameters, tile->parameters, k * sizeof *copy.parameters);
    kn_status status = KN_OK;
    for (size_t p = 0; status == KN_OK && p < n; p++)
        status = copy_part(ctx, &copy.parts[p], &tile->parts[p], tile->nparameters);
    if (status == KN_OK)
        *out = copy;
    else
        kn_tile_clear(ctx, &copy);
    return status;
}
