// SPDX-License-Identifier: Apache-2.0
// kn_builtin_tile: the tiles that knurl brings along. tools/tiles makes them: their geometry, data/tiles/<tile>/<part>.g2
// and <part>@<parameter>.g2 (the part with a parameter at its target), which the build puts into the library
// (io/embedded.h), and io/builtin_table.h. docs/tiles.md describes them.
#include "io/embedded.h"
#include "kernel/context.h"

#include <knurl/io.h>

#include <stdio.h>
#include <string.h>

typedef struct part_source {
    const char *name; // of the part and of its file
    kn_material material;
} part_source;

typedef struct tile_source {
    const char *name, *about;
    double aspect;
    const part_source *part;
    const kn_tile_parameter *parameter;
    int nparts, nparameters;
    bool covering;
} tile_source;

static const tile_source SOURCES[] = {
#include "io/builtin_table.h"
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

static kn_status parse(kn_ctx *ctx, kn_model *model, const kn_embedded_file *file)
{
    return kn_parse_g2(ctx, model, file->path, file->bytes, file->size);
}

static kn_status load_part(kn_ctx *ctx, kn_tile_part *part, const char *tile, const part_source *source)
{
    char path[2 * KN_NAME_BYTES];
    snprintf(path, sizeof path, "%s/%s.g2", tile, source->name);
    const kn_embedded_file *file = find_file(path);
    if (!file) return kn_fail(ctx, KN_ENOTBUILT, "tile %s: this build lacks data/tiles/%s", tile, path);
    kn_model model = {0};
    kn_status status = parse(ctx, &model, file);
    if (status != KN_OK) return status;
    snprintf(part->name, sizeof part->name, "%s", source->name);
    part->material = source->material;
    part->splines = model.splines;
    part->nsplines = model.nsplines;
    return KN_OK;
}

static bool same_points(const kn_spline *a, const kn_spline *b)
{
    size_t n = (size_t)a->ncomp * kn_spline_count(a), i = 0;
    if (n != (size_t)b->ncomp * kn_spline_count(b)) return false;
    while (i < n && a->coef[i] == b->coef[i]) i++;
    return i == n;
}

// The targets of parameter k of the part, where it has a file: splines that it leaves as they are stay empty.
static kn_status load_targets(kn_ctx *ctx, kn_tile *tile, kn_tile_part *part, int k)
{
    char path[4 * KN_NAME_BYTES];
    snprintf(path, sizeof path, "%s/%s@%s.g2", tile->name, part->name, tile->parameters[k].name);
    const kn_embedded_file *file = find_file(path);
    if (!file) return KN_OK;
    size_t n = (size_t)part->nsplines;
    if (!part->targets) part->targets = kn_alloc_zero(ctx, (size_t)tile->nparameters * n, sizeof *part->targets);
    if (!part->targets) return KN_ENOMEM;
    kn_model model = {0};
    kn_status status = parse(ctx, &model, file);
    if (status == KN_OK && (size_t)model.nsplines != n)
        status = kn_fail(ctx, KN_EDOMAIN, "data/tiles/%s has %d splines, not %d", path, model.nsplines,
                         part->nsplines);
    for (size_t i = 0; i < n && status == KN_OK; i++) {
        if (same_points(&model.splines[i], &part->splines[i])) continue;
        part->targets[(size_t)k * n + i] = model.splines[i];
        model.splines[i] = (kn_spline){0};
    }
    kn_model_clear(ctx, &model);
    return status;
}

static kn_status load_parameters(kn_ctx *ctx, kn_tile *tile, const tile_source *source)
{
    if (source->nparameters == 0) return KN_OK;
    size_t n = (size_t)source->nparameters;
    tile->parameters = kn_alloc(ctx, n, sizeof *tile->parameters);
    if (!tile->parameters) return KN_ENOMEM;
    memcpy(tile->parameters, source->parameter, n * sizeof *tile->parameters);
    tile->nparameters = source->nparameters;
    kn_status status = KN_OK;
    for (int p = 0; p < tile->nparts; p++)
        for (int k = 0; k < tile->nparameters && status == KN_OK; k++)
            status = load_targets(ctx, tile, &tile->parts[p], k);
    return status;
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
    if (status == KN_OK) status = load_parameters(ctx, &tile, source);
    if (status == KN_OK) status = kn_tile_check(ctx, &tile);
    if (status == KN_OK)
        *out = tile;
    else
        kn_tile_clear(ctx, &tile);
    return status;
}
