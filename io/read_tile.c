// SPDX-License-Identifier: Apache-2.0
// kn_read_tile: a tile of one part from a spline file.
#include "kernel/context.h"

#include <knurl/io.h>

#include <stdio.h>
#include <string.h>

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

kn_status kn_read_tile(kn_ctx *ctx, kn_tile *out, const char *path, const double *cell)
{
    static const double unit[4] = {0, 0, 1, 1};
    char name[KN_NAME_BYTES];
    name_of(name, path);
    kn_model model = {0};
    kn_tile tile = {0};
    kn_status status = kn_tile_init(ctx, &tile, name, 1);
    if (status == KN_OK) status = kn_tile_set_cell(ctx, &tile, cell ? cell : unit, 1.0); // before a file is opened
    if (status == KN_OK) status = kn_read_model(ctx, &model, path);
    if (status == KN_OK) {
        kn_tile_part *part = &tile.parts[0];
        snprintf(tile.about, sizeof tile.about, "from %.100s", path);
        memcpy(part->name, name, sizeof name);
        part->material = (kn_material){{0.6, 0.6, 0.6}, 0.0, 0.4};
        part->plain = true;
        part->splines = model.splines;
        part->nsplines = model.nsplines;
        part->mesh = model.mesh;
        model = (kn_model){0};
        if (cell) status = kn_tile_set_cell(ctx, &tile, cell, 1.0);
    }
    if (status == KN_OK) status = kn_tile_check(ctx, &tile);
    if (status == KN_OK)
        *out = tile;
    else
        kn_tile_clear(ctx, &tile);
    kn_model_clear(ctx, &model);
    return status;
}
