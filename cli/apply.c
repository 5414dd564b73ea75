// SPDX-License-Identifier: Apache-2.0
// knurl apply: a tile over a base, composed and written.
#include "cli/cli.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    TILE,
    TILE_CELL,
    COUNT,
    SIZE,
    HEIGHT,
    OFFSET,
    ROTATE,
    NORMAL,
    NORMAL_TOL,
    MAX_DEGREE,
    TOL,
    UNIT,
    THREADS,
    DRY_RUN,
    JSON,
    QUIET,
    SYMBOLIC,
    OUTPUT,
    HELP
};
static const cli_option options[] = {
    [TILE] = {"tile", 't', true},
    [TILE_CELL] = {"tile-cell", 0, true},
    [COUNT] = {"count", 'c', true},
    [SIZE] = {"size", 's', true},
    [HEIGHT] = {"height", 0, true},
    [OFFSET] = {"offset", 0, true},
    [ROTATE] = {"rotate", 0, true},
    [NORMAL] = {"normal", 0, true},
    [NORMAL_TOL] = {"normal-tol", 0, true},
    [MAX_DEGREE] = {"max-degree", 0, true},
    [TOL] = {"tol", 0, true},
    [UNIT] = {"unit", 0, true},
    [THREADS] = {"threads", 'j', true},
    [DRY_RUN] = {"dry-run", 'n', false},
    [JSON] = {"json", 0, false},
    [QUIET] = {"quiet", 'q', false},
    [SYMBOLIC] = {"symbolic", 0, false},
    [OUTPUT] = {"output", 'o', true},
    [HELP] = {"help", 'h', false},
};

static bool positive(const char *name, double value)
{
    if (value > 0) return true;
    cli_error("%s: expected a number above 0, got %g", name, value);
    return false;
}

static bool set_normal(const char *text)
{
    if (strcmp(text, "fitted") == 0) return true;
    cli_error("--normal: this version has 'fitted' alone, got '%s'", text);
    return false;
}

static bool set_cell(cli_apply *a, const char *text)
{
    int n = cli_list("--tile-cell", text, a->cell, 4);
    if (n == 4 && a->cell[0] < a->cell[2] && a->cell[1] < a->cell[3]) return a->has_cell = true;
    if (n > 0) cli_error("--tile-cell: expected U0,V0,U1,V1 with U0 < U1 and V0 < V1, got '%s'", text);
    return false;
}

static bool set_height(cli_apply *a, const char *text)
{
    if (!cli_double("--height", text, &a->job.height)) return false;
    if (a->job.height != 0) return true;
    cli_error("--height: a texture of height 0 is flat; leave it out for the tile's own proportions");
    return false;
}

static bool set_option(cli_apply *a, int option, const char *value)
{
    kn_job_options *job = &a->job;
    double number;
    if ((option == COUNT || option == SIZE) && a->recipe_cells) {
        job->count[0] = job->count[1] = 0;
        job->size[0] = job->size[1] = 0;
        a->recipe_cells = false;
    }
    switch (option) {
    case TILE: a->tile = value; return true;
    case TILE_CELL: return set_cell(a, value);
    case COUNT: return cli_int_pair("--count", value, 1, CLI_MAX_COUNT, job->count);
    case SIZE:
        return cli_double_pair("--size", value, job->size) && positive("--size", job->size[0]) &&
               positive("--size", job->size[1]);
    case HEIGHT: return set_height(a, value);
    case OFFSET: return cli_double("--offset", value, &job->offset);
    case ROTATE: return cli_double("--rotate", value, &number) && cli_set_rotation("--rotate", number, job);
    case NORMAL: return set_normal(value);
    case NORMAL_TOL:
        return cli_double("--normal-tol", value, &job->normal_tol) && positive("--normal-tol", job->normal_tol);
    case MAX_DEGREE: return cli_set_max_degree("--max-degree", value, job);
    case TOL: return cli_double("--tol", value, &job->mesh_tol) && positive("--tol", job->mesh_tol);
    case UNIT: return cli_set_unit("--unit", value, &a->unit_mm);
    case THREADS: return cli_int("--threads", value, 1, 1024, &a->threads);
    case DRY_RUN: return a->dry_run = true;
    case JSON: return a->json = true;
    case QUIET: return a->quiet = true;
    case SYMBOLIC: return job->symbolic = true;
    case OUTPUT: return cli_add_output(a, "-o", value);
    default: return false;
    }
}

// EXIT_OK, an exit code after a message, or -1 when help was asked for and given.
static int read_arguments(cli_apply *a, int argc, char **argv)
{
    cli_args args = {.argc = argc,
                     .at = 1,
                     .argv = argv,
                     .options = options,
                     .command = "apply",
                     .noptions = sizeof options / sizeof *options};
    const char *value;
    for (int option; (option = cli_next(&args, &value)) != CLI_END;) {
        if (option == CLI_BAD) return EXIT_USAGE;
        if (option == HELP) return cli_help(stdout, "apply") == EXIT_OK ? -1 : EXIT_FAILED;
        if (option == CLI_POSITIONAL) {
            if (a->base) {
                cli_error("apply: one base at a time, got '%s' and '%s'", a->base, value);
                return EXIT_USAGE;
            }
            a->base = value;
            if (cli_has_ending(value, "json")) {
                int code = cli_read_recipe(a, value);
                if (code != EXIT_OK) return code;
            }
        } else if (!set_option(a, option, value))
            return EXIT_USAGE;
    }
    return EXIT_OK;
}

static int check_arguments(const cli_apply *a)
{
    const char *missing = !a->base                                 ? "a BASE file is missing"
                          : !a->tile                               ? "--tile is missing ('knurl tiles' lists them)"
                          : a->noutputs == 0 && !a->dry_run        ? "no output: give -o OUT, or --dry-run"
                          : a->job.count[0] && a->job.size[0] != 0 ? "--count and --size exclude each other"
                                                                   : NULL;
    if (!missing) return EXIT_OK;
    cli_error("apply: %s", missing);
    cli_usage_hint("apply");
    return EXIT_USAGE;
}

// Opens the sinks, runs the job, closes them all whatever happened.
static kn_status run(kn_ctx *ctx, const cli_apply *a, const kn_job *job, double *bytes)
{
    kn_sink sinks[CLI_MAX_OUTPUTS];
    int open = 0;
    kn_status status = KN_OK;
    for (; open < a->noutputs && status == KN_OK; open += status == KN_OK)
        status = cli_open_sink(ctx, &sinks[open], a->outputs[open], a->unit_mm);
    if (status == KN_OK) status = kn_job_run(ctx, job, sinks, open);
    for (int i = 0; i < open; i++) {
        bytes[i] = sinks[i].bytes ? (double)sinks[i].bytes(sinks[i].user) : 0.0;
        kn_sink_close(ctx, &sinks[i]);
    }
    return status;
}

// STEP files say that points within a micrometre are one, and CAD systems merge what is closer: a base in another
// unit than the one that was said shows here.
static void warn_of_size(cli_session *session, const cli_apply *a, const kn_job_report *report)
{
    double cell_mm = report->cell_size * a->unit_mm;
    for (int i = 0; i < a->noutputs; i++)
        if ((cli_has_ending(a->outputs[i], "step") || cli_has_ending(a->outputs[i], "stp")) && cell_mm < 0.01) {
            cli_warn(session,
                     "%s: cells of %.2g mm are too small for CAD systems, which merge points within 0.001 mm; "
                     "is --unit right?",
                     a->outputs[i], cell_mm);
            return;
        }
}

static int apply(cli_session *session, cli_apply *a, const cli_base *base, const kn_tile *tile, cli_timing *timing)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_job *job = NULL;
    double bytes[CLI_MAX_OUTPUTS], began = cli_seconds();
    kn_status status = kn_job_create(ctx, &job, base->surfaces, base->nsurfaces, tile, &a->job);
    if (status != KN_OK) return cli_fail_on(session, status, a->base, false);
    kn_job_report report = kn_job_describe(job);
    timing->plan = cli_seconds() - began;
    warn_of_size(session, a, &report);
    began = cli_seconds();
    if (a->dry_run)
        for (int i = 0; i < a->noutputs; i++) bytes[i] = cli_estimate_bytes(a->outputs[i], &report);
    else
        status = run(ctx, a, job, bytes);
    timing->run = cli_seconds() - began;
    int code = status == KN_OK ? EXIT_OK : cli_fail(session, status, false);
    kn_job_destroy(ctx, job);
    if (code == EXIT_OK) cli_print_apply(a, &report, bytes, timing, kn_ctx_counters(ctx).peak_bytes);
    return code;
}

int cli_command_apply(int argc, char **argv)
{
    cli_apply a = {.job = kn_job_defaults(), .unit_mm = 1};
    cli_session *session = NULL;
    cli_base base = {0};
    kn_tile tile = {0};
    cli_timing timing = {0};
    int code = read_arguments(&a, argc, argv);
    if (code == EXIT_OK) code = check_arguments(&a);
    if (code == EXIT_OK) {
        session = cli_session_begin((cli_session_options){.threads = a.threads, .quiet = a.quiet});
        if (!session) code = EXIT_FAILED;
    }
    double began = cli_seconds();
    if (code == EXIT_OK) code = cli_read_tile(session, &tile, a.tile, a.has_cell ? a.cell : NULL);
    if (code == EXIT_OK) code = cli_read_base(session, &base, a.base);
    timing.read = cli_seconds() - began;
    if (code == EXIT_OK) code = apply(session, &a, &base, &tile, &timing);
    if (session) {
        cli_base_clear(session, &base);
        kn_tile_clear(cli_ctx(session), &tile);
    }
    cli_session_end(session);
    for (int i = 0; i < a.nowned; i++) free(a.owned[i]);
    return code < 0 ? EXIT_OK : code;
}
