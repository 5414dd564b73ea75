// SPDX-License-Identifier: Apache-2.0
// Recipes: the arguments of `knurl apply` as a JSON file, format 1. The schema is docs/recipe.schema.json.
// Keys are the names of options with '_' for '-', and their values mean what the options' texts mean. Paths are
// relative to the recipe's folder; unknown keys are errors, so that a slip of the pen is not silence.
#include "bridges/jansson/text.h"
#include "cli/cli.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A text of the recipe, freed with it.
typedef struct cli_owned {
    struct cli_owned *next;
    char text[];
} cli_owned;

typedef struct reader {
    const char *path;
    cli_recipe *recipe;
} reader;

// The name of a key for messages of functions that options share: the recipe's path and the key.
typedef struct label {
    char text[512];
} label;
static label in_recipe(const reader *r, const char *key)
{
    label out;
    snprintf(out.text, sizeof out.text, "%.400s: \"%.80s\"", r->path, key);
    return out;
}

static bool bad(const reader *r, const char *key, const char *expected)
{
    cli_error("%s: \"%s\": expected %s", r->path, key, expected);
    return false;
}

// The three texts one after the other, owned by the recipe.
static char *own(const reader *r, const char *a, size_t na, const char *b, const char *c)
{
    size_t nb = strlen(b), nc = strlen(c);
    cli_owned *block = malloc(sizeof *block + na + nb + nc + 1);
    if (!block) {
        cli_error("out of memory");
        return NULL;
    }
    memcpy(block->text, a, na);
    memcpy(block->text + na, b, nb);
    memcpy(block->text + na + nb, c, nc + 1);
    block->next = r->recipe->owned;
    r->recipe->owned = block;
    return block->text;
}

void cli_recipe_end(cli_recipe *recipe)
{
    while (recipe->owned) {
        cli_owned *block = recipe->owned;
        recipe->owned = block->next;
        free(block);
    }
}

// The folder that a path counts from: so many bytes of the recipe's own path.
static size_t folder_bytes(const reader *r, const char *path)
{
    const char *slash = strrchr(r->path, '/');
    return slash && path[0] != '/' ? (size_t)(slash - r->path) + 1 : 0;
}

static bool get_path(const reader *r, const char *key, const json_t *value, const char **out)
{
    const char *text = json_string_value(value);
    if (!text || !*text) return bad(r, key, "a text");
    return (*out = own(r, r->path, folder_bytes(r, text), text, "")) != NULL;
}

// Names of built-in tiles have no dot.
static bool names_a_file(const cli_option *option, const char *text)
{
    if (strcmp(option->name, "tile") == 0 || strcmp(option->name, "morph") == 0) return strchr(text, '.') != NULL;
    return (option->takes == CLI_FILE || option->takes == CLI_FILES) && cli_scalar_is_file(text);
}

// The option of a key as its text would set it. prefix: "NAME=" or "".
static bool set_text(const reader *r, cli_job *job, int number, const cli_option *option, const char *key,
                     const char *prefix, const json_t *value)
{
    char *text = kn_json_text(value);
    if (!text || !*text) {
        free(text);
        return bad(r, key, "a number, a text, or an array of them");
    }
    // prefix + folder + text: a path keeps its place behind the name of a parameter.
    size_t folder = names_a_file(option, text) ? folder_bytes(r, text) : 0;
    char *path = own(r, r->path, folder, text, ""), *whole = path ? own(r, prefix, strlen(prefix), path, "") : NULL;
    free(text);
    return whole && cli_job_set_key(job, number, in_recipe(r, key).text, whole);
}

static bool set_pairs(const reader *r, cli_job *job, int number, const cli_option *option, const char *key,
                      json_t *object)
{
    const char *name;
    json_t *value;
    if (!json_is_object(object)) return bad(r, key, "an object, names and values");
    json_object_foreach(object, name, value)
    {
        const char *prefix = own(r, name, strlen(name), "=", "");
        if (!prefix || !set_text(r, job, number, option, key, prefix, value)) return false;
    }
    return true;
}

// false in *known: no option has this key.
static bool set_key(const reader *r, cli_job *job, cli_place place, const char *key, json_t *value, bool *known)
{
    const cli_option *option = NULL;
    int number = cli_job_find_key(key, place, &option);
    *known = number >= 0;
    if (!*known) return true;
    if (option->takes == CLI_PAIRS || option->takes == CLI_FILES)
        return set_pairs(r, job, number, option, key, value);
    if (option->takes != CLI_NOTHING) return set_text(r, job, number, option, key, "", value);
    if (!json_is_boolean(value)) return bad(r, key, "true or false");
    return json_is_false(value) || cli_job_set_key(job, number, in_recipe(r, key).text, NULL);
}

static bool get_name(const reader *r, cli_job *job, const json_t *value)
{
    const char *text = json_string_value(value);
    if (!text || !*text || strlen(text) >= sizeof job->name) return bad(r, "name", "a text of up to 63 bytes");
    snprintf(job->name, sizeof job->name, "%s", text);
    return true;
}

// What a layer is among the others: its name, and whether it is written.
static bool own_key(const reader *r, cli_job *job, const char *key, const json_t *value, bool *known)
{
    *known = true;
    if (strcmp(key, "on") == 0) return json_is_string(value) || bad(r, key, "the name of an earlier layer");
    if (strcmp(key, "name") == 0) return get_name(r, job, value);
    if (strcmp(key, "base_only") == 0) {
        job->base_only = json_is_true(value);
        return json_is_boolean(value) || bad(r, key, "true or false");
    }
    *known = false;
    return true;
}

// The earlier layer that each lies on, by its name.
static bool find_bases(const reader *r, const json_t *layers)
{
    cli_recipe *recipe = r->recipe;
    bool shown = false;
    for (int i = 0; i < recipe->nlayers; i++) {
        const char *on = json_string_value(json_object_get(json_array_get(layers, (size_t)i), "on"));
        int k = 0;
        while (on && k < i && strcmp(recipe->layer[k].name, on) != 0) k++;
        if (on && k == i) return bad(r, "on", "the name of an earlier layer");
        recipe->layer[i].on = on ? k + 1 : 0;
        shown = shown || !recipe->layer[i].base_only;
    }
    return shown || bad(r, "base_only", "a layer that is written");
}

static bool get_layer(const reader *r, cli_job *job, json_t *layer)
{
    const char *key;
    json_t *value;
    bool known;
    if (!json_is_object(layer)) return bad(r, "layers", "an array of objects");
    json_object_foreach(layer, key, value)
    {
        if (!own_key(r, job, key, value, &known)) return false;
        if (known) continue;
        if (!set_key(r, job, CLI_OF_LAYER, key, value, &known)) return false;
        if (!known) {
            cli_error("%s: unknown key \"%s\" in a layer", r->path, key);
            return false;
        }
    }
    if (json_object_get(layer, "count") && json_object_get(layer, "size"))
        return bad(r, "layers", "count or size, not both");
    if (!job->tile) return bad(r, "layers", "a tile in each layer");
    return job->recipe_cells = true;
}

static bool get_layers(const reader *r, const json_t *layers)
{
    cli_recipe *recipe = r->recipe;
    size_t n = json_array_size(layers);
    if (!json_is_array(layers) || n < 1 || n > CLI_MAX_LAYERS) return bad(r, "layers", "an array of 1 to 16 objects");
    for (size_t i = n; i-- > 0;) { // from the back: the first holds what all begin with
        recipe->layer[i] = recipe->layer[0];
        if (!get_layer(r, &recipe->layer[i], json_array_get(layers, i))) return false;
    }
    recipe->nlayers = (int)n;
    return find_bases(r, layers);
}

static bool get_outputs(const reader *r, const json_t *outputs)
{
    size_t n = json_array_size(outputs);
    if (!json_is_array(outputs) || n > CLI_MAX_OUTPUTS) return bad(r, "outputs", "an array of at most 16 paths");
    for (size_t i = 0; i < n; i++) {
        const char *path;
        if (!get_path(r, "outputs", json_array_get(outputs, i), &path) ||
            !cli_add_output(r->recipe, in_recipe(r, "outputs").text, path))
            return false;
    }
    return true;
}

// What all layers share.
static bool top_key(const reader *r, const char *key, json_t *value)
{
    bool known, ok;
    if (strcmp(key, "format") == 0)
        return (json_is_integer(value) && json_integer_value(value) == 1) || bad(r, key, "1");
    if (strcmp(key, "base") == 0) return get_path(r, key, value, &r->recipe->layer[0].base);
    if (strcmp(key, "layers") == 0) return true;
    if (strcmp(key, "outputs") == 0) return get_outputs(r, value);
    ok = set_key(r, &r->recipe->layer[0], CLI_OF_RECIPE, key, value, &known);
    if (!known) cli_error("%s: unknown key \"%s\"", r->path, key);
    return ok && known;
}

static bool get_all(const reader *r, json_t *root)
{
    const char *key;
    json_t *value;
    if (!json_is_object(root)) return bad(r, "recipe", "an object");
    if (!json_object_get(root, "format")) return bad(r, "format", "1");
    json_object_foreach(root, key, value)
    {
        if (!top_key(r, key, value)) return false;
    }
    return (r->recipe->layer[0].base || bad(r, "base", "the path of a spline file")) &&
           get_layers(r, json_object_get(root, "layers"));
}

int cli_read_recipe(cli_recipe *recipe, const char *path)
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
    reader r = {path, recipe};
    recipe->layer[0].base = NULL;
    bool ok = get_all(&r, root);
    json_decref(root);
    return ok ? EXIT_OK : EXIT_BAD_INPUT;
}
