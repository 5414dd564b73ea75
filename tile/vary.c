// SPDX-License-Identifier: Apache-2.0
// kn_tile_vary: a tile with its parameters at given values.
#include "tile/blend.h"
#include "tile/internal.h"

#include <math.h>

// x += s (target - x at the parameter's value): where they agree nothing changes, not even a bit.
static void move(double *x, const double *base, const double *target, size_t n, double s)
{
    for (size_t i = 0; i < n; i++) x[i] += s * (target[i] - base[i]);
}

static void move_part(kn_tile_part *part, const kn_tile_part *base, int k, double s)
{
    for (int i = 0; base->targets && i < base->nsplines; i++) {
        const kn_spline *from = &base->splines[i], *target = &base->targets[k * base->nsplines + i];
        size_t n = (size_t)from->ncomp * kn_spline_count(from);
        if (target->coef) move(part->splines[i].coef, from->coef, target->coef, n, s);
    }
    if (base->mesh_targets && base->mesh_targets[k])
        move(part->mesh.position, base->mesh.position, base->mesh_targets[k], 3 * base->mesh.nvertices, s);
}

static void drop_targets(kn_ctx *ctx, kn_tile *tile)
{
    for (int p = 0; p < tile->nparts; p++) {
        kn_tile_part *part = &tile->parts[p];
        kn_tile_free_splines(ctx, part->targets, tile->nparameters * part->nsplines);
        for (int k = 0; part->mesh_targets && k < tile->nparameters; k++) kn_free(ctx, part->mesh_targets[k]);
        kn_free(ctx, part->mesh_targets);
        part->targets = NULL;
        part->mesh_targets = NULL;
        if (part->mesh.normal && tile->nparameters > 0) { // of the unvaried one
            kn_free(ctx, part->mesh.normal);
            part->mesh.normal = NULL;
        }
    }
    kn_free(ctx, tile->parameters);
    tile->parameters = NULL;
    tile->nparameters = 0;
}

kn_status kn_tile_vary(kn_ctx *ctx, kn_tile *out, const kn_tile *tile, const double *values)
{
    for (int k = 0; k < tile->nparameters; k++)
        if (!isfinite(values[k]))
            return kn_fail(ctx, KN_EDOMAIN, "tile: parameter \"%s\" is %g", tile->parameters[k].name, values[k]);
    kn_status status = kn_tile_check_parameters(ctx, tile);
    kn_tile varied = {0};
    if (status == KN_OK) status = kn_tile_copy(ctx, &varied, tile);
    if (status != KN_OK) return status;
    for (int k = 0; k < tile->nparameters; k++) {
        double s = kn_tile_blend(&tile->parameters[k], values[k]);
        for (int i = 0; s != 0.0 && i < tile->nparts; i++) move_part(&varied.parts[i], &tile->parts[i], k, s);
    }
    drop_targets(ctx, &varied);
    *out = varied;
    return KN_OK;
}
