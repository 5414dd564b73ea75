// SPDX-License-Identifier: Apache-2.0
// kn_read_tile: a tile of one part from a spline file.
#include "kernel/context.h"

#include <knurl/io.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

static kn_status check_cell(kn_ctx *ctx, const double *cell)
{
    for (int i = 0; i < 4; i++)
        if (!isfinite(cell[i])) return kn_fail(ctx, KN_EDOMAIN, "tile cell: number %d is not finite", i + 1);
    for (int d = 0; d < 2; d++) {
        double width = cell[d + 2] - cell[d];
        if (!(width > 0.0) || !isfinite(width))
            return kn_fail(ctx, KN_EDOMAIN, "tile cell: %c from %g to %g", d ? 'v' : 'u', cell[d], cell[d + 2]);
    }
    return KN_OK;
}

// The file's name without its folder and ending, cut to what fits.
static void name_of(char name[KN_NAME_BYTES], const char *path)
{
    const char *base = strrchr(path, '/');
    base = base ? base + 1 : path;
    const char *end = strrchr(base, '.');
    size_t length = end && end > base ? (size_t)(end - base) : strlen(base);
    if (length >= KN_NAME_BYTES) length = KN_NAME_BYTES - 1;
    memcpy(name, base, length);
    name[length] = '\0';
}

// (u,v) of every control point from the cell to the unit square; a rational point carries its weight.
static void to_unit_square(kn_spline *s, const double *cell)
{
    size_t n = kn_spline_count(s);
    for (int d = 0; d < 2 && d < kn_spline_dim(s); d++)
        for (size_t i = 0; i < n; i++) {
            double *x = s->coef + (size_t)d * n + i;
            double weight = s->rational ? s->coef[(size_t)(s->ncomp - 1) * n + i] : 1.0;
            *x = (*x - weight * cell[d]) / (cell[d + 2] - cell[d]);
        }
}

kn_status kn_read_tile(kn_ctx *ctx, kn_tile *out, const char *path, const double *cell)
{
    kn_status status = cell ? check_cell(ctx, cell) : KN_OK;
    if (status != KN_OK) return status;
    char name[KN_NAME_BYTES];
    name_of(name, path);
    kn_model model = {0};
    kn_tile tile = {0};
    status = kn_read_model(ctx, &model, path);
    if (status == KN_OK) status = kn_tile_init(ctx, &tile, name, 1);
    if (status == KN_OK) {
        kn_tile_part *part = &tile.parts[0];
        snprintf(tile.about, sizeof tile.about, "from %.100s", path);
        tile.aspect = cell ? 1.0 / sqrt((cell[2] - cell[0]) * (cell[3] - cell[1])) : 1.0;
        memcpy(part->name, name, sizeof name);
        part->material = (kn_material){{0.6, 0.6, 0.6}, 0.0, 0.4};
        part->splines = model.splines;
        part->nsplines = model.nsplines;
        model = (kn_model){0};
        for (int i = 0; cell && i < part->nsplines; i++) to_unit_square(&part->splines[i], cell);
        status = kn_tile_check(ctx, &tile);
    }
    if (status == KN_OK)
        *out = tile;
    else
        kn_tile_clear(ctx, &tile);
    kn_model_clear(ctx, &model);
    return status;
}
