// SPDX-License-Identifier: Apache-2.0
// knurl check: how high a texture may be before the base folds or meets itself.
#include "cli/check.h"
#include "io/out_file.h"

#include <stdlib.h>
#include <string.h>

enum { COLOR = CLI_JOB_OPTIONS, PIXELS, WORK, LAYER, OUTPUT, HELP, END };
static const cli_option options[END - CLI_JOB_OPTIONS] = {
    [COLOR - CLI_JOB_OPTIONS] = {"color", 0, CLI_TEXT}, [PIXELS - CLI_JOB_OPTIONS] = {"pixels", 0, CLI_TEXT},
    [WORK - CLI_JOB_OPTIONS] = {"work", 0, CLI_TEXT},   [OUTPUT - CLI_JOB_OPTIONS] = {"output", 'o', CLI_TEXT},
    [LAYER - CLI_JOB_OPTIONS] = {"layer", 0, CLI_TEXT}, [HELP - CLI_JOB_OPTIONS] = {"help", 'h', CLI_NOTHING},
};

static bool set_color(check *c, const char *text)
{
    c->by_jacobian = strcmp(text, "jacobian") == 0;
    if (c->by_jacobian || strcmp(text, "safe-height") == 0) return true;
    cli_error("--color: expected safe-height or jacobian, got '%s'", text);
    return false;
}

static bool add_output(check *c, const char *path)
{
    const int most = sizeof c->outputs / sizeof *c->outputs;
    return check_can_draw(path) && cli_take_output("-o", c->outputs, &c->noutputs, most, path);
}

static bool set_option(check *c, int option, const char *value)
{
    int work;
    if (option < CLI_JOB_OPTIONS) return cli_recipe_set(&c->recipe, option, value);
    switch (option) {
    case COLOR: return set_color(c, value);
    case PIXELS: return cli_int_pair("--pixels", value, 160, 8192, c->pixels);
    case WORK:
        if (!cli_int("--work", value, 1, 2000000000, &work)) return false;
        c->work = (size_t)work;
        return true;
    case LAYER: return cli_int("--layer", value, 1, CLI_MAX_LAYERS, &c->layer);
    case OUTPUT: return add_output(c, value);
    default: return false;
    }
}

// EXIT_OK, an exit code after a message, or -1 when help was asked for and given.
static int read_arguments(check *c, int argc, char **argv)
{
    cli_args args = {.argc = argc,
                     .at = 1,
                     .argv = argv,
                     .options = options,
                     .job = true,
                     .command = "check",
                     .noptions = sizeof options / sizeof *options};
    const char *value;
    for (int option; (option = cli_next(&args, &value)) != CLI_END;) {
        if (option == CLI_BAD) return EXIT_USAGE;
        if (option == HELP) return cli_help(stdout, "check") == EXIT_OK ? -1 : EXIT_FAILED;
        if (option == CLI_POSITIONAL && c->recipe.layer[0].base) {
            cli_error("check: one base at a time, got '%s' and '%s'", c->recipe.layer[0].base, value);
            return EXIT_USAGE;
        }
        if (option == CLI_POSITIONAL) {
            int code = cli_recipe_base(&c->recipe, value); // its outputs do not matter
            if (code != EXIT_OK) return code;
        } else if (!set_option(c, option, value))
            return EXIT_USAGE;
    }
    return EXIT_OK;
}

// One layer is looked at: the first of one, or the one that was asked for.
static const char *choose_layer(check *c)
{
    int n = c->recipe.nlayers;
    if (c->layer > n) return "--layer: the recipe has fewer layers";
    if (n > 1 && c->layer == 0) return "the recipe has several layers: say which one, --layer N";
    c->job = c->recipe.layer[c->layer > 0 ? c->layer - 1 : 0];
    return NULL;
}

static int check_arguments(check *c)
{
    const char *wrong = choose_layer(c);
    const cli_job *job = &c->job;
    bool cells = job->options.count[0] || job->has_size || job->options.spacing || job->options.rows ||
                 job->options.stretch || job->options.quarter_turns || check_by_cell(c) || job->mask.text ||
                 job->nfaces > 0 || job->nface_texts > 0 || job->has_camera || job->nvary > 0 ||
                 job->scatter.value > 0 || job->taper.value > 0;
    const char *missing = wrong                                              ? wrong
                          : !job->base                                       ? "a BASE file is missing"
                          : cells && !job->tile                              ? "cells need a --tile"
                          : job->offset.value != 0 && job->height.value == 0 ? "--offset needs --height"
                                                                             : cli_job_conflict(job);
    if (!missing) return EXIT_OK;
    cli_error("check: %s", missing);
    cli_usage_hint("check");
    return EXIT_USAGE;
}

// Only volumes bring their own heights.
static int check_height(const check *c)
{
    if (c->job.height.value != 0 || c->job.tile) return EXIT_OK;
    for (int i = 0; i < c->base.nsurfaces; i++)
        if (c->base.surfaces[i].nvars == 2) {
            cli_error("check: --height H is missing");
            cli_usage_hint("check");
            return EXIT_USAGE;
        }
    return EXIT_OK;
}

static int find_intersection(cli_session *session, check *c)
{
    kn_ctx *ctx = cli_ctx(session);
    if (c->job.tile && c->nregions == 0) return EXIT_OK; // no cell has a tile
    const kn_shell **shells = malloc((size_t)c->nshells * sizeof(void *));
    if (!shells) {
        cli_error("out of memory");
        return EXIT_FAILED;
    }
    for (int i = 0; i < c->nshells; i++) shells[i] = c->shells[i].shell;
    kn_fold_options o = {.work = c->work};
    kn_status status = kn_fold_self_intersection(ctx, &c->global, shells, c->nshells, c->regions, c->nregions,
                                                 c->range, &o);
    free(shells);
    return status == KN_OK ? EXIT_OK : cli_fail_on(session, status, c->job.base, false);
}

// Whether each output can be made, before the work is done that it would show.
static int try_outputs(cli_session *session, const check *c)
{
    kn_ctx *ctx = cli_ctx(session);
    for (int i = 0; i < c->noutputs; i++) {
        kn_out_file *file = NULL;
        kn_status status = kn_out_open(ctx, &file, c->outputs[i]);
        if (status != KN_OK) return cli_fail(session, status, false);
        kn_out_close(ctx, file);
    }
    return EXIT_OK;
}

// The report comes even if a picture of it fails.
static int draw_and_print(cli_session *session, check *c, double began)
{
    int code = EXIT_OK;
    while (c->ndrawn < c->noutputs && code == EXIT_OK) {
        code = check_draw(session, c, c->outputs[c->ndrawn]);
        c->ndrawn += code == EXIT_OK;
    }
    c->seconds = cli_seconds() - began;
    if (code != EXIT_CANCELLED) check_print(c);
    return code == EXIT_OK && !check_passed(c) ? EXIT_CHECK_FAILED : code;
}

static int examine(cli_session *session, check *c)
{
    double began = cli_seconds();
    int code = try_outputs(session, c);
    if (code == EXIT_OK && c->job.tile) code = cli_read_job_tile(session, &c->tile, &c->job);
    if (code == EXIT_OK) code = cli_job_begin(session, &c->job);
    if (code == EXIT_OK) code = cli_read_base(session, &c->base, c->job.base, true);
    if (code == EXIT_OK) code = cli_choose_faces(session, &c->job, 1, &c->base);
    if (code == EXIT_OK) code = check_height(c);
    if (code == EXIT_OK) code = check_make_shells(session, c);
    if (code == EXIT_OK) {
        kn_status status = check_make_regions(cli_ctx(session), c);
        if (status != KN_OK) code = cli_fail(session, status, false);
    }
    if (code == EXIT_OK && c->job.tile && c->nregions == 0)
        cli_warn(session, "%s: no cell is left of the texture", c->job.base);
    if (code == EXIT_OK) code = check_examine(session, c);
    if (code == EXIT_OK) code = find_intersection(session, c);
    return code == EXIT_OK ? draw_and_print(session, c, began) : code;
}

int cli_command_check(int argc, char **argv)
{
    check c = {.work = CHECK_WORK, .pixels = {1280, 960}};
    cli_recipe_begin(&c.recipe);
    int code = read_arguments(&c, argc, argv);
    if (code == EXIT_OK) code = check_arguments(&c);
    cli_session *session = NULL;
    if (code == EXIT_OK) {
        session = cli_session_begin((cli_session_options){.threads = c.job.threads, .quiet = c.job.quiet});
        code = session ? examine(session, &c) : EXIT_FAILED;
    }
    if (session) check_clear(session, &c);
    cli_session_end(session);
    cli_recipe_end(&c.recipe);
    return code < 0 ? EXIT_OK : code;
}
