// SPDX-License-Identifier: Apache-2.0
// kn_builtin_tile: the tiles that knurl brings along. Their geometry is data/tiles/<tile>/<part>.g2, which the build
// puts into the library (io/embedded.h) and tools/model_tiles.py made; docs/tiles.md describes them.
#include "io/embedded.h"
#include "kernel/context.h"

#include <knurl/io.h>

#include <stdio.h>
#include <string.h>

enum { MAX_PARTS = 2 };

typedef struct part_source {
    const char *name; // of the part and of its file
    kn_material material;
} part_source;

typedef struct tile_source {
    const char *name, *about;
    double aspect; // as in tools/model_tiles.py
    part_source part[MAX_PARTS];
    int nparts;
    bool covering;
} tile_source;

static const tile_source SOURCES[] = {
    {.name = "chain",
     .about = "chain mail: a flat ring in each cell, joined to all four neighbours by upright links",
     .aspect = 0.5,
     .part = {{"ring", {{1.0, 0.71, 0.29}, 1.0, 0.22}}, {"link", {{0.96, 0.64, 0.49}, 1.0, 0.26}}},
     .nparts = 2},
    {.name = "scale",
     .about = "overlapping scales with a ridge, two staggered rows in each cell, tips towards +v",
     .aspect = 0.3125,
     .part = {{"scale", {{0.04, 0.27, 0.19}, 0.25, 0.28}}},
     .nparts = 1,
     .covering = true},
    {.name = "thorn",
     .about = "a smooth sheet out of which one bent thorn grows, leaning towards +u",
     .aspect = 0.75,
     .part = {{"thorn", {{0.42, 0.28, 0.14}, 0.0, 0.4}}},
     .nparts = 1,
     .covering = true},
    {.name = "knurl",
     .about = "diamond knurling: pyramids with flattened crests between crossing V grooves",
     .aspect = 0.1875,
     .part = {{"knurl", {{0.55, 0.56, 0.58}, 1.0, 0.32}}},
     .nparts = 1,
     .covering = true},
    {.name = "bump",
     .about = "one smooth dome in each cell",
     .aspect = 0.25,
     .part = {{"bump", {{0.5, 0.05, 0.03}, 0.0, 0.25}}},
     .nparts = 1,
     .covering = true},
};

enum { SOURCE_COUNT = sizeof SOURCES / sizeof *SOURCES };

int kn_builtin_tile_count(void)
{
    return SOURCE_COUNT;
}

const char *kn_builtin_tile_name(int index)
{
    return index >= 0 && index < SOURCE_COUNT ? SOURCES[index].name : NULL;
}

static const kn_embedded_file *find_file(const char *path)
{
    for (const kn_embedded_file *file = kn_embedded_files; file->path; file++)
        if (strcmp(file->path, path) == 0) return file;
    return NULL;
}

static kn_status load_part(kn_ctx *ctx, kn_tile_part *part, const char *tile, const part_source *source)
{
    char path[2 * KN_NAME_BYTES];
    snprintf(path, sizeof path, "%s/%s.g2", tile, source->name);
    const kn_embedded_file *file = find_file(path);
    if (!file) return kn_fail(ctx, KN_ENOTBUILT, "tile %s: this build lacks data/tiles/%s", tile, path);
    kn_model model = {0};
    kn_status status = kn_parse_g2(ctx, &model, path, file->bytes, file->size);
    if (status != KN_OK) return status;
    snprintf(part->name, sizeof part->name, "%s", source->name);
    part->material = source->material;
    part->splines = model.splines;
    part->nsplines = model.nsplines;
    return KN_OK;
}

kn_status kn_builtin_tile(kn_ctx *ctx, kn_tile *out, const char *name)
{
    const tile_source *source = NULL;
    for (int i = 0; i < SOURCE_COUNT; i++)
        if (strcmp(SOURCES[i].name, name) == 0) source = &SOURCES[i];
    if (!source) return kn_fail(ctx, KN_EDOMAIN, "there is no built-in tile named '%s'", name);

    kn_tile tile = {0};
    kn_status status = kn_tile_init(ctx, &tile, source->name, source->nparts);
    if (status != KN_OK) return status;
    snprintf(tile.about, sizeof tile.about, "%s", source->about);
    tile.covering = source->covering;
    tile.aspect = source->aspect;
    for (int i = 0; i < source->nparts && status == KN_OK; i++)
        status = load_part(ctx, &tile.parts[i], source->name, &source->part[i]);
    if (status == KN_OK) status = kn_tile_check(ctx, &tile);
    if (status == KN_OK)
        *out = tile;
    else
        kn_tile_clear(ctx, &tile);
    return status;
}
