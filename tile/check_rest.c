// SPDX-License-Identifier: Apache-2.0
// Whether meshes can be part of a tile, and parameters vary it.
#include "tile/internal.h"

#include <math.h>
#include <string.h>

kn_status kn_tile_check_mesh(kn_ctx *ctx, const kn_tile_part *part)
{
    const kn_mesh *m = &part->mesh;
    for (size_t i = 0; i < 3 * m->nvertices; i++)
        if (!isfinite(m->position[i]))
            return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\", vertex %zu of its mesh is not finite", part->name,
                           i / 3);
    for (size_t t = 0; t < m->ntriangles; t++) {
        const uint32_t *c = m->triangle + 3 * t;
        for (int k = 0; k < 3; k++)
            if (c[k] >= m->nvertices)
                return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\", triangle %zu of its mesh: vertex %lu of %zu",
                               part->name, t, (unsigned long)c[k], m->nvertices);
        if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0])
            return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\", triangle %zu of its mesh has a vertex twice",
                           part->name, t);
    }
    return KN_OK;
}

static kn_status check_parameter(kn_ctx *ctx, const kn_tile *tile, int k)
{
    const kn_tile_parameter *p = &tile->parameters[k];
    if (!p->name[0]) return kn_fail(ctx, KN_EDOMAIN, "tile: parameter %d has no name", k);
    for (int i = 0; i < k; i++)
        if (strcmp(p->name, tile->parameters[i].name) == 0)
            return kn_fail(ctx, KN_EDOMAIN, "tile: two parameters \"%s\"", p->name);
    if (!isfinite(p->value) || !isfinite(p->target) || p->value == p->target)
        return kn_fail(ctx, KN_EDOMAIN, "tile: parameter \"%s\" from %g to %g", p->name, p->value, p->target);
    if (!isfinite(p->lo) || !isfinite(p->hi) || !(p->lo <= p->value && p->value <= p->hi))
        return kn_fail(ctx, KN_EDOMAIN, "tile: parameter \"%s\" is %g, not in [%g, %g]", p->name, p->value, p->lo,
                       p->hi);
    return KN_OK;
}

static bool all_finite(const double *x, size_t n)
{
    size_t i = 0;
    while (i < n && isfinite(x[i])) i++;
    return i == n;
}

static kn_status check_targets(kn_ctx *ctx, const kn_tile_part *part, const kn_tile_parameter *parameter, int k)
{
    for (int s = 0; part->targets && s < part->nsplines; s++) {
        const kn_spline *target = &part->targets[k * part->nsplines + s];
        if (!target->coef) continue;
        if (!kn_tile_same_kind(&part->splines[s], target))
            return kn_fail(ctx, KN_EDOMAIN,
                           "tile: part \"%s\", spline %d: the target of \"%s\" has other degrees or knots",
                           part->name, s, parameter->name);
        if (!all_finite(target->coef, (size_t)target->ncomp * kn_spline_count(target)))
            return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\", spline %d: the target of \"%s\" is not finite",
                           part->name, s, parameter->name);
    }
    if (part->mesh_targets && part->mesh_targets[k] && !all_finite(part->mesh_targets[k], 3 * part->mesh.nvertices))
        return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\": the target of \"%s\" for its mesh is not finite",
                       part->name, parameter->name);
    return KN_OK;
}

kn_status kn_tile_check_parameters(kn_ctx *ctx, const kn_tile *tile)
{
    kn_status status = KN_OK;
    for (int k = 0; status == KN_OK && k < tile->nparameters; k++) {
        status = check_parameter(ctx, tile, k);
        for (int p = 0; status == KN_OK && p < tile->nparts; p++)
            status = check_targets(ctx, &tile->parts[p], &tile->parameters[k], k);
    }
    return status;
}
