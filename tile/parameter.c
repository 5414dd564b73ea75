// SPDX-License-Identifier: Apache-2.0
// kn_tile_add_parameter, kn_tile_set_target, kn_tile_set_mesh_target: by what a tile can be varied.
#include "tile/internal.h"

#include <string.h>

// Lists that are there get empty entries for one more parameter. On failure they may be longer than they say.
static kn_status lengthen(kn_ctx *ctx, kn_tile_part *part, int nparameters)
{
    size_t k = (size_t)nparameters, n = (size_t)part->nsplines;
    if (part->targets) {
        kn_spline *targets = kn_resize(ctx, part->targets, (k + 1) * n, sizeof *targets);
        if (!targets) return KN_ENOMEM;
        part->targets = targets;
        memset(targets + k * n, 0, n * sizeof *targets);
    }
    if (part->mesh_targets) {
        double **list = kn_resize(ctx, part->mesh_targets, k + 1, sizeof *list);
        if (!list) return KN_ENOMEM;
        part->mesh_targets = list;
        list[k] = NULL;
    }
    return KN_OK;
}

kn_status kn_tile_add_parameter(kn_ctx *ctx, kn_tile *tile, const char *name, double value, double target, double lo,
                                double hi)
{
    if (strlen(name) >= KN_NAME_BYTES)
        return kn_fail(ctx, KN_ELIMIT, "tile: a parameter's name longer than %d bytes", KN_NAME_BYTES - 1);
    size_t n = (size_t)tile->nparameters;
    kn_tile_parameter *list = n > 0 ? kn_resize(ctx, tile->parameters, n + 1, sizeof *list)
                                    : kn_alloc(ctx, 1, sizeof *list);
    if (!list) return KN_ENOMEM;
    tile->parameters = list;
    kn_status status = KN_OK;
    for (int p = 0; status == KN_OK && p < tile->nparts; p++)
        status = lengthen(ctx, &tile->parts[p], tile->nparameters);
    if (status != KN_OK) return status;
    list[n] = (kn_tile_parameter){.value = value, .target = target, .lo = lo, .hi = hi};
    memcpy(list[n].name, name, strlen(name));
    tile->nparameters++;
    return KN_OK;
}

static bool same_knots(const kn_spline *a, const kn_spline *b, int var)
{
    int n = a->count[var] + a->degree[var] + 1;
    for (int i = 0; i < n; i++)
        if (a->knots[var][i] != b->knots[var][i]) return false;
    return true;
}

bool kn_tile_same_kind(const kn_spline *a, const kn_spline *b)
{
    bool same = a->nvars == b->nvars && a->ncomp == b->ncomp && a->rational == b->rational;
    for (int v = 0; same && v < a->nvars; v++)
        same = a->degree[v] == b->degree[v] && a->count[v] == b->count[v] && same_knots(a, b, v);
    return same;
}

static kn_status check_place(kn_ctx *ctx, const kn_tile *tile, int parameter, int part)
{
    if (part < 0 || part >= tile->nparts) return kn_fail(ctx, KN_EDOMAIN, "tile: part %d of %d", part, tile->nparts);
    if (parameter < 0 || parameter >= tile->nparameters)
        return kn_fail(ctx, KN_EDOMAIN, "tile: parameter %d of %d", parameter, tile->nparameters);
    return KN_OK;
}

kn_status kn_tile_set_target(kn_ctx *ctx, kn_tile *tile, int parameter, int part, int spline, const kn_spline *target)
{
    kn_status status = check_place(ctx, tile, parameter, part);
    if (status != KN_OK) return status;
    kn_tile_part *to = &tile->parts[part];
    if (spline < 0 || spline >= to->nsplines)
        return kn_fail(ctx, KN_EDOMAIN, "tile: spline %d of %d", spline, to->nsplines);
    if (!kn_tile_same_kind(&to->splines[spline], target))
        return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\", spline %d: its target has other degrees or knots",
                       to->name, spline);
    size_t n = (size_t)to->nsplines;
    if (!to->targets) to->targets = kn_alloc_zero(ctx, (size_t)tile->nparameters * n, sizeof *to->targets);
    if (!to->targets) return KN_ENOMEM;
    return kn_spline_copy(ctx, &to->targets[(size_t)parameter * n + (size_t)spline], target);
}

kn_status kn_tile_set_mesh_target(kn_ctx *ctx, kn_tile *tile, int parameter, int part, const double *position)
{
    kn_status status = check_place(ctx, tile, parameter, part);
    if (status != KN_OK) return status;
    kn_tile_part *to = &tile->parts[part];
    size_t n = 3 * to->mesh.nvertices;
    if (n == 0) return kn_fail(ctx, KN_EDOMAIN, "tile: part \"%s\" has no mesh", to->name);
    double *copy = kn_alloc(ctx, n, sizeof *copy);
    if (copy && !to->mesh_targets)
        to->mesh_targets = kn_alloc_zero(ctx, (size_t)tile->nparameters, sizeof *to->mesh_targets);
    if (!copy || !to->mesh_targets) {
        kn_free(ctx, copy);
        return KN_ENOMEM;
    }
    memcpy(copy, position, n * sizeof *copy);
    kn_free(ctx, to->mesh_targets[parameter]);
    to->mesh_targets[parameter] = copy;
    return KN_OK;
}
