// SPDX-License-Identifier: Apache-2.0
// kn_json_tile_read: a tile from its description.
#include "bridges/jansson/tile.h"
#include "bridges/jansson/text.h"
#include "io/in_file.h"
#include "kernel/context.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct reader {
    kn_ctx *ctx;
    const char *path;
    char at[KN_NAME_BYTES]; // what keys are of: "parts[1]." or ""
    kn_tile_part_reader *read;
    void *user;
    kn_tile_file file;
    double cell[4], height, aspect;
} reader;

// ---- values ----

static kn_status bad(const reader *r, const char *key, const char *expected)
{
    return kn_fail(r->ctx, KN_EPARSE, "%s: \"%s%s\": expected %s", r->path, r->at, key, expected);
}

static kn_status unknown(const reader *r, const char *key)
{
    return kn_fail(r->ctx, KN_EPARSE, "%s: unknown key \"%s%.80s\"", r->path, r->at, key);
}

static kn_status get_text(const reader *r, const char *key, const json_t *value, char *out, size_t bytes)
{
    const char *text = json_string_value(value);
    if (!text || !*text) return bad(r, key, "a text");
    if (strlen(text) >= bytes)
        return kn_fail(r->ctx, KN_ELIMIT, "%s: \"%s%s\": more than %zu bytes", r->path, r->at, key, bytes - 1);
    memcpy(out, text, strlen(text) + 1);
    return KN_OK;
}

static kn_status get_number(const reader *r, const char *key, const json_t *value, double *out)
{
    double x = json_number_value(value);
    if (!json_is_number(value) || !isfinite(x)) return bad(r, key, "a number");
    *out = x;
    return KN_OK;
}

static kn_status get_above_zero(const reader *r, const char *key, const json_t *value, double *out)
{
    kn_status status = get_number(r, key, value, out);
    return status == KN_OK && !(*out > 0.0) ? bad(r, key, "a number above 0") : status;
}

static kn_status get_numbers(const reader *r, const char *key, const json_t *value, double *out, size_t n)
{
    char expected[32];
    snprintf(expected, sizeof expected, "an array of %zu numbers", n);
    if (json_array_size(value) != n) return bad(r, key, expected);
    for (size_t i = 0; i < n; i++)
        if (get_number(r, key, json_array_get(value, i), &out[i]) != KN_OK) return KN_EPARSE;
    return KN_OK;
}

static kn_status get_share(const reader *r, const char *key, const json_t *value, double *out)
{
    kn_status status = get_number(r, key, value, out);
    return status == KN_OK && !(*out >= 0.0 && *out <= 1.0) ? bad(r, key, "a number from 0 to 1") : status;
}

static kn_status get_flag(const reader *r, const char *key, const json_t *value, bool *out)
{
    if (!json_is_boolean(value)) return bad(r, key, "true or false");
    *out = json_is_true(value);
    return KN_OK;
}

// An array of 1 .. most objects.
static kn_status check_list(const reader *r, const char *key, const json_t *value, int most)
{
    if (!json_is_array(value) || json_array_size(value) == 0) return bad(r, key, "an array of objects");
    for (size_t i = 0; i < json_array_size(value); i++)
        if (!json_is_object(json_array_get(value, i))) return bad(r, key, "an array of objects");
    if (json_array_size(value) > (size_t)most)
        return kn_fail(r->ctx, KN_ELIMIT, "%s: \"%s\": more than %d", r->path, key, most);
    return KN_OK;
}

// ---- files ----

// Paths count from the description's folder.
static kn_status read_file(reader *r, const char *key, const json_t *value, kn_tile_part *part)
{
    const char *name = json_string_value(value), *slash = strrchr(r->path, '/');
    if (!name || !*name) return bad(r, key, "the path of a file");
    size_t folder = slash && name[0] != '/' ? (size_t)(slash - r->path) + 1 : 0, length = strlen(name);
    char *path = kn_alloc(r->ctx, folder + length + 1, 1);
    if (!path) return KN_ENOMEM;
    memcpy(path, r->path, folder);
    memcpy(path + folder, name, length + 1);
    kn_status status = r->read(r->ctx, r->user, part, path);
    kn_free(r->ctx, path);
    return status;
}

static void clear_geometry(kn_ctx *ctx, kn_tile_part *part)
{
    for (int i = 0; i < part->nsplines; i++) kn_spline_clear(ctx, &part->splines[i]);
    kn_free(ctx, part->splines);
    kn_mesh_clear(ctx, &part->mesh);
}

// ---- parts ----

static kn_status get_material(reader *r, json_t *object, kn_material *out)
{
    const char *key;
    json_t *value;
    kn_status status = KN_OK;
    if (!json_is_object(object)) return bad(r, "material", "an object");
    json_object_foreach(object, key, value)
    {
        if (strcmp(key, "color") == 0) {
            status = get_numbers(r, key, value, out->base_color, 3);
            for (int c = 0; c < 3 && status == KN_OK; c++)
                if (!(out->base_color[c] >= 0 && out->base_color[c] <= 1))
                    status = bad(r, key, "three numbers from 0 to 1");
        } else if (strcmp(key, "metallic") == 0)
            status = get_share(r, key, value, &out->metallic);
        else if (strcmp(key, "roughness") == 0)
            status = get_share(r, key, value, &out->roughness);
        else
            status = unknown(r, key);
        if (status != KN_OK) return status;
    }
    return KN_OK;
}

static kn_status get_part(reader *r, kn_tile_part *part, json_t *object)
{
    const char *key;
    json_t *value, *file = json_object_get(object, "file");
    kn_status status = KN_OK;
    part->material = (kn_material){{0.6, 0.6, 0.6}, 0.0, 0.4};
    part->plain = !json_object_get(object, "material");
    json_object_foreach(object, key, value)
    {
        if (strcmp(key, "name") == 0)
            status = get_text(r, key, value, part->name, sizeof part->name);
        else if (strcmp(key, "material") == 0)
            status = get_material(r, value, &part->material);
        else if (strcmp(key, "file") != 0)
            status = unknown(r, key);
        if (status != KN_OK) return status;
    }
    if (!*part->name) return bad(r, "name", "a text");
    return read_file(r, "file", file, part);
}

static kn_status get_parts(reader *r, const json_t *parts)
{
    kn_tile *tile = &r->file.tile;
    for (int p = 0; p < tile->nparts; p++) {
        snprintf(r->at, sizeof r->at, "parts[%d].", p);
        kn_status status = get_part(r, &tile->parts[p], json_array_get(parts, (size_t)p));
        for (int q = 0; q < p && status == KN_OK; q++)
            if (strcmp(tile->parts[p].name, tile->parts[q].name) == 0)
                status = bad(r, "name", "a name that no other part has");
        if (status != KN_OK) return status;
    }
    r->at[0] = '\0';
    return KN_OK;
}

// ---- parameters ----

static int find_part(const kn_tile *tile, const char *name)
{
    for (int p = 0; p < tile->nparts; p++)
        if (strcmp(tile->parts[p].name, name) == 0) return p;
    return -1;
}

// What the file says of each spline and of the mesh, as far as it differs from the part itself.
static kn_status set_targets(reader *r, int k, int p, const char *name, const kn_tile_part *from)
{
    kn_tile *tile = &r->file.tile;
    const kn_tile_part *part = &tile->parts[p];
    if (from->nsplines != part->nsplines || from->mesh.nvertices != part->mesh.nvertices)
        return kn_fail(r->ctx, KN_EPARSE,
                       "%s: \"%sfiles.%s\": %d splines and %zu vertices, but the part has %d and %zu", r->path, r->at,
                       name, from->nsplines, from->mesh.nvertices, part->nsplines, part->mesh.nvertices);
    kn_status status = KN_OK;
    for (int s = 0; s < part->nsplines && status == KN_OK; s++)
        status = kn_tile_set_target(r->ctx, tile, k, p, s, &from->splines[s]);
    if (status == KN_OK && part->mesh.nvertices > 0)
        status = kn_tile_set_mesh_target(r->ctx, tile, k, p, from->mesh.position);
    return status;
}

static kn_status get_files(reader *r, int k, json_t *files)
{
    const char *name;
    json_t *value;
    if (!json_is_object(files)) return bad(r, "files", "an object: names of parts and their files");
    json_object_foreach(files, name, value)
    {
        kn_tile_part from = {0};
        int p = find_part(&r->file.tile, name);
        if (p < 0) return kn_fail(r->ctx, KN_EPARSE, "%s: \"%sfiles\": no part '%.60s'", r->path, r->at, name);
        kn_status status = read_file(r, "files", value, &from);
        if (status == KN_OK) status = set_targets(r, k, p, name, &from);
        clear_geometry(r->ctx, &from);
        if (status != KN_OK) return status;
    }
    return KN_OK;
}

static kn_status get_parameter(reader *r, int k, json_t *object)
{
    const char *key;
    json_t *value;
    char name[KN_NAME_BYTES] = "";
    double at = 0, target = 1, range[2] = {NAN, NAN};
    kn_status status = KN_OK;
    json_object_foreach(object, key, value)
    {
        if (strcmp(key, "name") == 0)
            status = get_text(r, key, value, name, sizeof name);
        else if (strcmp(key, "value") == 0)
            status = get_number(r, key, value, &at);
        else if (strcmp(key, "target") == 0)
            status = get_number(r, key, value, &target);
        else if (strcmp(key, "range") == 0)
            status = get_numbers(r, key, value, range, 2);
        else if (strcmp(key, "files") != 0)
            status = unknown(r, key);
        if (status != KN_OK) return status;
    }
    if (!*name) return bad(r, "name", "a text");
    if (isnan(range[0])) range[0] = fmin(at, target), range[1] = fmax(at, target);
    status = kn_tile_add_parameter(r->ctx, &r->file.tile, name, at, target, range[0], range[1]);
    return status == KN_OK ? get_files(r, k, json_object_get(object, "files")) : status;
}

static kn_status get_parameters(reader *r, const json_t *parameters)
{
    kn_status status = parameters ? check_list(r, "parameters", parameters, KN_TILE_MAX_PARAMETERS) : KN_OK;
    for (size_t k = 0; status == KN_OK && k < json_array_size(parameters); k++) {
        snprintf(r->at, sizeof r->at, "parameters[%zu].", k);
        status = get_parameter(r, (int)k, json_array_get(parameters, k));
    }
    r->at[0] = '\0';
    return status;
}

// ---- defaults ----

// The options that may be proposed: counts, heights and what belongs to a tile, and nothing of the base.
static bool can_be_default(const char *key)
{
    static const char *const keys[] = {"count",  "size",    "height", "offset",   "side",
                                       "rotate", "spacing", "rows",   "stretch",  "stagger",
                                       "mirror", "shift",   "border", "crossing", "scatter"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        if (strcmp(key, keys[i]) == 0) return true;
    return false;
}

static kn_status get_default(reader *r, const char *key, const json_t *value)
{
    kn_tile_default *to = &r->file.defaults[r->file.ndefaults];
    if (!can_be_default(key)) return unknown(r, key);
    snprintf(to->key, sizeof to->key, "%s", key);
    if (json_is_boolean(value)) {
        to->value[0] = '\0';
        r->file.ndefaults += json_is_true(value);
        return KN_OK;
    }
    char *text = kn_json_text(value);
    kn_status status = !text || !*text                    ? bad(r, key, "a number, a text, or an array of them")
                       : strlen(text) >= sizeof to->value ? bad(r, key, "a shorter text")
                                                          : KN_OK;
    if (status == KN_OK) {
        memcpy(to->value, text, strlen(text) + 1);
        r->file.ndefaults++;
    }
    free(text);
    return status;
}

static kn_status get_defaults(reader *r, json_t *object)
{
    const char *key;
    json_t *value;
    if (!json_is_object(object)) return bad(r, "defaults", "an object");
    snprintf(r->at, sizeof r->at, "defaults.");
    json_object_foreach(object, key, value)
    {
        kn_status status = get_default(r, key, value);
        if (status != KN_OK) return status;
    }
    r->at[0] = '\0';
    return KN_OK;
}

// ---- the whole ----

static kn_status get_key(reader *r, const char *key, json_t *value)
{
    kn_tile *tile = &r->file.tile;
    const char *kind = json_string_value(value);
    if (strcmp(key, "format") == 0)
        return json_is_integer(value) && json_integer_value(value) == 1 ? KN_OK : bad(r, key, "1");
    if (strcmp(key, "kind") == 0) return kind && strcmp(kind, "tile") == 0 ? KN_OK : bad(r, key, "\"tile\"");
    if (strcmp(key, "name") == 0) return get_text(r, key, value, tile->name, sizeof tile->name);
    if (strcmp(key, "about") == 0) return get_text(r, key, value, tile->about, sizeof tile->about);
    if (strcmp(key, "covering") == 0) return get_flag(r, key, value, &tile->covering);
    if (strcmp(key, "cell") == 0) {
        kn_status status = get_numbers(r, key, value, r->cell, 4);
        bool fine = status != KN_OK || (r->cell[0] < r->cell[2] && r->cell[1] < r->cell[3]);
        return fine ? status : bad(r, key, "u0, v0, u1, v1 with u0 < u1 and v0 < v1");
    }
    if (strcmp(key, "height") == 0) return get_above_zero(r, key, value, &r->height);
    if (strcmp(key, "aspect") == 0) return get_above_zero(r, key, value, &r->aspect);
    if (strcmp(key, "defaults") == 0) return get_defaults(r, value);
    return strcmp(key, "parts") == 0 || strcmp(key, "parameters") == 0 ? KN_OK : unknown(r, key);
}

static kn_status get_tile(reader *r, json_t *root)
{
    const char *key;
    json_t *value, *parts = json_object_get(root, "parts");
    kn_tile *tile = &r->file.tile;
    if (!json_is_object(root)) return kn_fail(r->ctx, KN_EPARSE, "%s:1: expected an object", r->path);
    if (!json_object_get(root, "format")) return bad(r, "format", "1");
    if (!json_object_get(root, "kind")) return bad(r, "kind", "\"tile\"");
    if (!json_object_get(root, "name")) return bad(r, "name", "a text");
    kn_status status = check_list(r, "parts", parts, KN_TILE_MAX_PARTS);
    if (status == KN_OK) status = kn_tile_init(r->ctx, tile, "tile", (int)json_array_size(parts));
    if (status != KN_OK) return status;
    json_object_foreach(root, key, value)
    {
        status = get_key(r, key, value);
        if (status != KN_OK) return status;
    }
    status = get_parts(r, parts);
    if (status == KN_OK) status = get_parameters(r, json_object_get(root, "parameters"));
    if (status == KN_OK) status = kn_tile_set_cell(r->ctx, tile, r->cell, r->height);
    if (r->aspect > 0) tile->aspect = r->aspect;
    return status == KN_OK ? kn_tile_check(r->ctx, tile) : status;
}

kn_status kn_json_tile_read(kn_ctx *ctx, kn_tile_file *out, const char *path, kn_tile_part_reader *read, void *user)
{
    reader r = {.ctx = ctx, .path = path, .read = read, .user = user, .cell = {0, 0, 1, 1}, .height = 1};
    char *text = NULL;
    size_t bytes = 0;
    json_error_t error;
    kn_status status = kn_in_read(ctx, &text, &bytes, path);
    if (status != KN_OK) return status;
    json_t *root = json_loadb(text, bytes, JSON_REJECT_DUPLICATES, &error);
    kn_free(ctx, text);
    if (root)
        status = get_tile(&r, root);
    else if (json_error_code(&error) == json_error_out_of_memory)
        status = KN_ENOMEM;
    else
        status = kn_fail(ctx, KN_EPARSE, "%s:%d: %s", path, error.line > 0 ? error.line : 1, error.text);
    json_decref(root);
    if (status == KN_OK)
        *out = r.file;
    else
        kn_tile_clear(ctx, &r.file.tile);
    return status;
}
