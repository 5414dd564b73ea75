// SPDX-License-Identifier: Apache-2.0
// Recipes: the arguments of `knurl apply` as a JSON file, format 1. The schema is docs/recipe.schema.json.
// Paths are relative to the recipe's folder; unknown keys are errors, so that a slip of the pen is not silence.
#include "cli/cli.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct recipe {
    const char *path;
    cli_apply *apply;
} recipe;

// The name of a key for messages of functions that options share: the recipe's path and the key.
typedef struct label {
    char text[512];
} label;
static label in_recipe(const recipe *r, const char *key)
{
    label out;
    snprintf(out.text, sizeof out.text, "%.400s: \"%.80s\"", r->path, key);
    return out;
}

static bool bad(const recipe *r, const char *key, const char *expected)
{
    cli_error("%s: \"%s\": expected %s", r->path, key, expected);
    return false;
}

// The text as a path beside the recipe, owned by the apply. Built-in tile names stay as they are.
static const char *own(const recipe *r, const char *text, bool is_path)
{
    const char *slash = strrchr(r->path, '/');
    size_t folder = is_path && slash && text[0] != '/' ? (size_t)(slash - r->path) + 1 : 0;
    size_t length = strlen(text) + 1;
    char *copy = malloc(folder + length);
    if (!copy) {
        cli_error("out of memory");
        return NULL;
    }
    memcpy(copy, r->path, folder);
    memcpy(copy + folder, text, length);
    r->apply->owned[r->apply->nowned++] = copy;
    return copy;
}

static bool get_text(const recipe *r, const char *key, const json_t *value, bool is_path, const char **out)
{
    if (!json_is_string(value) || !*json_string_value(value)) return bad(r, key, "a text");
    return (*out = own(r, json_string_value(value), is_path)) != NULL;
}

static bool get_number(const recipe *r, const char *key, const json_t *value, double *out)
{
    if (!json_is_number(value)) return bad(r, key, "a number");
    *out = json_number_value(value);
    return true;
}

static bool get_above_zero(const recipe *r, const char *key, const json_t *value, double *out)
{
    return get_number(r, key, value, out) && (*out > 0 || bad(r, key, "a number above 0"));
}

// A number for both directions, or an array of two.
static bool get_pair(const recipe *r, const char *key, const json_t *value, double out[2])
{
    if (json_is_array(value) && json_array_size(value) == 2)
        return get_above_zero(r, key, json_array_get(value, 0), &out[0]) &&
               get_above_zero(r, key, json_array_get(value, 1), &out[1]);
    return get_above_zero(r, key, value, &out[0]) && (out[1] = out[0], true);
}

static bool get_count(const recipe *r, const json_t *value)
{
    double pair[2];
    if (!get_pair(r, "count", value, pair)) return false;
    for (int d = 0; d < 2; d++) {
        if (pair[d] != floor(pair[d]) || pair[d] > CLI_MAX_COUNT)
            return bad(r, "count", "whole numbers from 1 to 65536");
        r->apply->job.options.count[d] = (int)pair[d];
    }
    return true;
}

static bool get_max_degree(const recipe *r, const json_t *value)
{
    char text[32];
    if (json_is_string(value))
        snprintf(text, sizeof text, "%s", json_string_value(value));
    else if (json_is_integer(value))
        snprintf(text, sizeof text, "%lld", (long long)json_integer_value(value));
    else
        return bad(r, "max_degree", "a whole number or a profile");
    return cli_set_max_degree(in_recipe(r, "max_degree").text, text, &r->apply->job.options);
}

// A number in the base's unit, or a text with a unit of its own.
static bool get_length(const recipe *r, const char *key, const json_t *value, cli_length *out, bool above_zero)
{
    cli_length l = {.value = json_number_value(value)};
    if (json_is_string(value)) {
        if (!cli_length_of(in_recipe(r, key).text, json_string_value(value), &l)) return false;
    } else if (!json_is_number(value))
        return bad(r, key, "a number or a length such as \"3mm\"");
    if (above_zero && !(l.value > 0)) return bad(r, key, "a length above 0");
    *out = l;
    return true;
}

static bool get_size(const recipe *r, const json_t *value)
{
    cli_job *job = &r->apply->job;
    bool pair = json_is_array(value) && json_array_size(value) == 2;
    return job->has_size = get_length(r, "size", pair ? json_array_get(value, 0) : value, &job->size[0], true) &&
                           get_length(r, "size", pair ? json_array_get(value, 1) : value, &job->size[1], true);
}

// A file beside the recipe, a vector, or for a thickness a number.
static bool get_field(const recipe *r, const char *key, const json_t *value, cli_field_kind kind)
{
    cli_field *field = &r->apply->job.field[kind];
    bool scalar = kind == CLI_FIELD_THICKNESS;
    const char *text = json_string_value(value);
    field->given = true;
    if (text && (cli_has_ending(text, "g2") || cli_has_ending(text, "bpt")))
        return get_text(r, key, value, true, &field->path);
    field->path = NULL;
    if (scalar && !json_is_array(value))
        return get_number(r, key, value, &field->value[0]) &&
               cli_field_makes_sense(in_recipe(r, key).text, kind, field);
    if (scalar || !json_is_array(value) || json_array_size(value) != 3)
        return bad(r, key, scalar ? "a number or a .g2 file" : "[x, y, z] or a .g2 file");
    for (size_t c = 0; c < 3; c++)
        if (!get_number(r, key, json_array_get(value, c), &field->value[c])) return false;
    return cli_field_makes_sense(in_recipe(r, key).text, kind, field);
}

static bool get_flag(const recipe *r, const char *key, const json_t *value, bool *out)
{
    *out = json_is_true(value);
    return json_is_boolean(value) || bad(r, key, "true or false");
}

static bool get_power(const recipe *r, const char *key, const json_t *value)
{
    json_int_t power = json_integer_value(value); // 0 when it is none
    r->apply->job.options.attraction_power = power > 0 && power <= KN_MAX_DEGREE ? (int)power : 0;
    r->apply->job.has_power = true;
    return r->apply->job.options.attraction_power > 0 || bad(r, key, "a whole number above 0");
}

// Keys that tell where cells lie.
static bool cells_key(const recipe *r, const char *key, const json_t *value, bool *known)
{
    kn_job_options *o = &r->apply->job.options;
    const char *text = json_string_value(value);
    *known = true;
    if (strcmp(key, "count") == 0) return get_count(r, value);
    if (strcmp(key, "size") == 0) return get_size(r, value);
    if (strcmp(key, "spacing") == 0) return cli_set_spacing(in_recipe(r, key).text, text ? text : "", o);
    if (strcmp(key, "rows") == 0) return get_flag(r, key, value, &o->rows);
    if (strcmp(key, "stretch") == 0) return get_flag(r, key, value, &o->stretch);
    *known = false;
    return true;
}

static bool layer_key(const recipe *r, const char *key, const json_t *value)
{
    cli_job *job = &r->apply->job;
    const char *text = json_string_value(value);
    double number;
    bool known, ok = cells_key(r, key, value, &known);
    if (known) return ok;
    if (strcmp(key, "tile") == 0) return get_text(r, key, value, text && strchr(text, '.'), &job->tile);
    if (strcmp(key, "height") == 0)
        return get_length(r, key, value, &job->height, false) &&
               (job->height.value != 0 || bad(r, key, "a length other than 0"));
    if (strcmp(key, "offset") == 0) return get_length(r, key, value, &job->offset, false);
    if (strcmp(key, "side") == 0) return cli_set_side(in_recipe(r, key).text, text ? text : "", &job->options);
    if (strcmp(key, "rotate") == 0)
        return get_number(r, key, value, &number) && cli_set_rotation(in_recipe(r, key).text, number, &job->options);
    if (strcmp(key, "direction") == 0) return get_field(r, key, value, CLI_FIELD_DIRECTION);
    if (strcmp(key, "thickness") == 0) return get_field(r, key, value, CLI_FIELD_THICKNESS);
    if (strcmp(key, "attraction") == 0) return get_field(r, key, value, CLI_FIELD_ATTRACTION);
    if (strcmp(key, "attraction_power") == 0) return get_power(r, key, value);
    cli_error("%s: unknown key \"%s\" in a layer", r->path, key);
    return false;
}

static bool get_layers(const recipe *r, json_t *layers)
{
    if (!json_is_array(layers) || json_array_size(layers) != 1 || !json_is_object(json_array_get(layers, 0)))
        return bad(r, "layers", "an array of one object");
    const char *key;
    json_t *value;
    json_object_foreach(json_array_get(layers, 0), key, value)
    {
        if (!layer_key(r, key, value)) return false;
    }
    const json_t *layer = json_array_get(layers, 0);
    if (json_object_get(layer, "count") && json_object_get(layer, "size"))
        return bad(r, "layers", "count or size, not both");
    r->apply->job.recipe_cells = true;
    return true;
}

static bool get_outputs(const recipe *r, const json_t *outputs)
{
    size_t n = json_array_size(outputs);
    if (!json_is_array(outputs) || n > CLI_MAX_OUTPUTS) return bad(r, "outputs", "an array of at most 16 paths");
    for (size_t i = 0; i < n; i++) {
        const char *path;
        if (!get_text(r, "outputs", json_array_get(outputs, i), true, &path) ||
            !cli_add_output(r->apply, in_recipe(r, "outputs").text, path))
            return false;
    }
    return true;
}

static bool top_key(const recipe *r, const char *key, json_t *value)
{
    cli_apply *a = r->apply;
    if (strcmp(key, "format") == 0)
        return (json_is_integer(value) && json_integer_value(value) == 1) || bad(r, key, "1");
    if (strcmp(key, "base") == 0) return get_text(r, key, value, true, &a->job.base);
    if (strcmp(key, "unit") == 0)
        return json_is_string(value) ? cli_set_unit(in_recipe(r, key).text, json_string_value(value), &a->job.unit_mm)
                                     : bad(r, key, "mm, cm, m or in");
    if (strcmp(key, "layers") == 0) return get_layers(r, value);
    if (strcmp(key, "outputs") == 0) return get_outputs(r, value);
    if (strcmp(key, "normal") == 0)
        return a->job.has_normal = cli_set_normal(
                   in_recipe(r, key).text, json_is_string(value) ? json_string_value(value) : "", &a->job.options);
    if (strcmp(key, "normal_tol") == 0) return get_above_zero(r, key, value, &a->job.options.normal_tol);
    if (strcmp(key, "tol") == 0) return get_length(r, key, value, &a->job.mesh_tol, true);
    if (strcmp(key, "cells_tol") == 0) return get_length(r, key, value, &a->job.cells_tol, true);
    if (strcmp(key, "max_degree") == 0) return get_max_degree(r, value);
    cli_error("%s: unknown key \"%s\"", r->path, key);
    return false;
}

int cli_read_recipe(cli_apply *apply, const char *path)
{
    json_error_t error;
    json_t *root = json_load_file(path, JSON_REJECT_DUPLICATES, &error);
    if (!root && error.line < 0) {
        cli_error("%s", error.text); // "unable to open PATH: reason"
        return EXIT_BAD_INPUT;
    }
    if (!root) {
        cli_error("%s:%d: %s", path, error.line > 0 ? error.line : 1, error.text);
        return EXIT_BAD_INPUT;
    }
    recipe r = {path, apply};
    apply->job.base = NULL;
    bool ok = json_is_object(root) || bad(&r, "recipe", "an object");
    if (ok && !json_object_get(root, "format")) ok = bad(&r, "format", "1");
    const char *key;
    json_t *value;
    if (ok) json_object_foreach(root, key, value)
        {
            if (!top_key(&r, key, value)) {
                ok = false;
                break;
            }
        }
    if (ok && !apply->job.base) ok = bad(&r, "base", "the path of a spline file");
    if (ok && !apply->job.tile) ok = bad(&r, "layers", "a layer with a tile");
    json_decref(root);
    return ok ? EXIT_OK : EXIT_BAD_INPUT;
}
