// SPDX-License-Identifier: Apache-2.0
// knurl tiles: what is built in; with --check what is proved of one tile.
#include "cli/cli.h"

#include <jansson.h>
#include <string.h>

enum { CHECK, CELL, JSON, HELP };
static const cli_option options[] = {[CHECK] = {"check", 0, CLI_TEXT},
                                     [CELL] = {"tile-cell", 0, CLI_TEXT},
                                     [JSON] = {"json", 0, CLI_NOTHING},
                                     [HELP] = {"help", 'h', CLI_NOTHING}};

typedef struct request {
    const char *check; // a tile's name or file; NULL: list
    double cell[4];
    bool has_cell, json;
} request;

static size_t count_patches(const kn_tile *tile)
{
    size_t patches = 0;
    for (int p = 0; p < tile->nparts; p++)
        for (int s = 0; s < tile->parts[p].nsplines; s++) {
            const kn_spline *surface = &tile->parts[p].splines[s];
            patches += (size_t)kn_spline_spans(surface, 0) * (size_t)kn_spline_spans(surface, 1);
        }
    return patches;
}

static void tile_degree(const kn_tile *tile, int degree[2])
{
    degree[0] = degree[1] = 0;
    for (int p = 0; p < tile->nparts; p++)
        for (int s = 0; s < tile->parts[p].nsplines; s++)
            for (int d = 0; d < 2; d++)
                if (tile->parts[p].splines[s].degree[d] > degree[d]) degree[d] = tile->parts[p].splines[s].degree[d];
}

static json_t *tile_json(const kn_tile *tile)
{
    int degree[2];
    tile_degree(tile, degree);
    json_t *parts = json_array();
    for (int p = 0; p < tile->nparts; p++) json_array_append_new(parts, json_string(tile->parts[p].name));
    json_t *parameters = json_array();
    for (int k = 0; k < tile->nparameters; k++) {
        const kn_tile_parameter *p = &tile->parameters[k];
        json_array_append_new(parameters, json_pack("{s:s,s:f,s:f,s:[f,f]}", "name", p->name, "value", p->value,
                                                    "target", p->target, "range", p->lo, p->hi));
    }
    return json_pack("{s:s,s:s,s:s,s:f,s:i,s:[ii],s:o,s:o}", "name", tile->name, "about", tile->about, "kind",
                     tile->covering ? "covering" : "casual", "aspect", tile->aspect, "patches",
                     (int)count_patches(tile), "degree", degree[0], degree[1], "parts", parts, "parameters",
                     parameters);
}

static int list(cli_session *session, bool json)
{
    kn_ctx *ctx = cli_ctx(session);
    json_t *all = json ? json_array() : NULL;
    int code = EXIT_OK;
    for (int i = 0; i < kn_builtin_tile_count() && code == EXIT_OK; i++) {
        kn_tile tile = {0};
        kn_status status = kn_builtin_tile(ctx, &tile, kn_builtin_tile_name(i));
        if (status != KN_OK)
            code = cli_fail(session, status, false);
        else if (json)
            json_array_append_new(all, tile_json(&tile));
        else
            printf("%-10s %-8s %3zu patches  %s\n", tile.name, tile.covering ? "covering" : "casual",
                   count_patches(&tile), tile.about);
        kn_tile_clear(ctx, &tile);
    }
    if (json && code == EXIT_OK) {
        json_dumpf(all, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(6));
        putchar('\n');
    }
    json_decref(all);
    return code;
}

static int check(cli_session *session, const request *r)
{
    kn_tile tile = {0};
    int code = cli_read_tile(session, &tile, r->check, r->has_cell ? r->cell : NULL);
    if (code == EXIT_OK) code = cli_check_tile(session, &tile, r->json);
    kn_tile_clear(cli_ctx(session), &tile);
    return code;
}

static bool set_option(request *r, int option, const char *value)
{
    if (option == CHECK) return (r->check = value) != NULL;
    if (option == CELL) return r->has_cell = cli_set_cell("--tile-cell", value, r->cell);
    return r->json = true;
}

int cli_command_tiles(int argc, char **argv)
{
    cli_args args = {.argc = argc,
                     .at = 1,
                     .argv = argv,
                     .options = options,
                     .command = "tiles",
                     .noptions = sizeof options / sizeof *options};
    request r = {0};
    const char *value;
    for (int option; (option = cli_next(&args, &value)) != CLI_END;) {
        if (option == HELP) return cli_help(stdout, "tiles");
        if (option == CLI_BAD || (option >= 0 && !set_option(&r, option, value))) return EXIT_USAGE;
        if (option == CLI_POSITIONAL) {
            cli_error("tiles: takes no file, got '%s' (--check TILE looks at one)", value);
            return EXIT_USAGE;
        }
    }
    cli_session *session = cli_session_begin((cli_session_options){.threads = 1});
    if (!session) return EXIT_FAILED;
    int code = r.check ? check(session, &r) : list(session, r.json);
    cli_session_end(session);
    return code;
}
