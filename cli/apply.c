// SPDX-License-Identifier: Apache-2.0
// knurl apply: a tile over a base, composed and written.
#include "cli/cli.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_DEGREE = CLI_JOB_OPTIONS, TOL, CELLS_TOL, DRY_RUN, SYMBOLIC, OUTPUT, HELP, END };
static const cli_option options[END - CLI_JOB_OPTIONS] = {
    [MAX_DEGREE - CLI_JOB_OPTIONS] = {"max-degree", 0, true}, [TOL - CLI_JOB_OPTIONS] = {"tol", 0, true},
    [CELLS_TOL - CLI_JOB_OPTIONS] = {"cells-tol", 0, true},   [DRY_RUN - CLI_JOB_OPTIONS] = {"dry-run", 'n', false},
    [SYMBOLIC - CLI_JOB_OPTIONS] = {"symbolic", 0, false},    [OUTPUT - CLI_JOB_OPTIONS] = {"output", 'o', true},
    [HELP - CLI_JOB_OPTIONS] = {"help", 'h', false},
};

static bool set_option(cli_apply *a, int option, const char *value)
{
    cli_job *job = &a->job;
    if (option < CLI_JOB_OPTIONS) return cli_job_set(job, option, value);
    switch (option) {
    case MAX_DEGREE: return cli_set_max_degree("--max-degree", value, &job->options);
    case TOL: return cli_length_of("--tol", value, &job->mesh_tol) && cli_above_zero("--tol", job->mesh_tol.value);
    case CELLS_TOL:
        return cli_length_of("--cells-tol", value, &job->cells_tol) &&
               cli_above_zero("--cells-tol", job->cells_tol.value);
    case DRY_RUN: return a->dry_run = true;
    case SYMBOLIC: return job->options.symbolic = true;
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
                     .job = true,
                     .command = "apply",
                     .noptions = sizeof options / sizeof *options};
    const char *value;
    for (int option; (option = cli_next(&args, &value)) != CLI_END;) {
        if (option == CLI_BAD) return EXIT_USAGE;
        if (option == HELP) return cli_help(stdout, "apply") == EXIT_OK ? -1 : EXIT_FAILED;
        if (option == CLI_POSITIONAL) {
            if (a->job.base) {
                cli_error("apply: one base at a time, got '%s' and '%s'", a->job.base, value);
                return EXIT_USAGE;
            }
            a->job.base = value;
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
    const char *missing = !a->job.base                      ? "a BASE file is missing"
                          : !a->job.tile                    ? "--tile is missing ('knurl tiles' lists them)"
                          : a->noutputs == 0 && !a->dry_run ? "no output: give -o OUT, or --dry-run"
                                                            : cli_job_conflict(&a->job);
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
        status = cli_open_sink(ctx, &sinks[open], a->outputs[open], a->job.unit_mm);
    if (status == KN_OK) status = kn_job_run(ctx, job, sinks, open);
    for (int i = 0; i < open; i++) {
        bytes[i] = sinks[i].bytes ? (double)sinks[i].bytes(sinks[i].user) : 0.0;
        kn_sink_close(ctx, &sinks[i]);
    }
    return status;
}

// STEP files say that points within a micrometre are one, and CAD systems merge what is closer: a base in another
// unit than the one that was said shows here.
static void warn_of_size(cli_session *session, const cli_apply *a, const char *path, const kn_job_report *report)
{
    double cell_mm = report->cell_size * a->job.unit_mm;
    if (cell_mm < 0.01)
        cli_warn(session,
                 "%s: cells of %.2g mm are too small for CAD systems, which merge points within 0.001 mm; "
                 "is --unit right?",
                 path, cell_mm);
}

// What is beyond a receiver's degree it leaves out, often without a word.
static void warn_of_degree(cli_session *session, const char *path, const kn_job_report *report)
{
    int degree = report->degree[0] > report->degree[1] ? report->degree[0] : report->degree[1];
    if (degree > 25)
        cli_warn(session,
                 "%s: faces of degree up to %d: OCCT reads none above 25, CATIA none above 15, VDA-FS none above 11 "
                 "(--max-degree)",
                 path, degree);
}

static void warn_of_receivers(cli_session *session, const cli_apply *a, const kn_job_report *report)
{
    for (int i = 0; i < a->noutputs; i++)
        if (cli_has_ending(a->outputs[i], "step") || cli_has_ending(a->outputs[i], "stp")) {
            warn_of_size(session, a, a->outputs[i], report);
            warn_of_degree(session, a->outputs[i], report);
            return;
        }
}

static int apply(cli_session *session, cli_apply *a, const cli_base *base, const kn_tile *tile, cli_timing *timing)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_job *job = NULL;
    double bytes[CLI_MAX_OUTPUTS], began = cli_seconds();
    kn_status status = kn_job_create(ctx, &job, base->surfaces, base->nsurfaces, tile, &a->job.options);
    if (status != KN_OK) return cli_fail_on_job(session, status, &a->job);
    kn_job_report report = kn_job_describe(job);
    timing->plan = cli_seconds() - began;
    warn_of_receivers(session, a, &report);
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
    cli_apply a = {.job = cli_job_defaults()};
    cli_session *session = NULL;
    cli_base base = {0};
    kn_tile tile = {0};
    cli_timing timing = {0};
    int code = read_arguments(&a, argc, argv);
    if (code == EXIT_OK) code = check_arguments(&a);
    if (code == EXIT_OK) {
        session = cli_session_begin((cli_session_options){.threads = a.job.threads, .quiet = a.job.quiet});
        if (!session) code = EXIT_FAILED;
    }
    double began = cli_seconds();
    if (code == EXIT_OK) code = cli_job_begin(session, &a.job);
    if (code == EXIT_OK) code = cli_read_tile(session, &tile, a.job.tile, a.job.has_cell ? a.job.cell : NULL);
    if (code == EXIT_OK) code = cli_read_base(session, &base, a.job.base, true);
    timing.read = cli_seconds() - began;
    if (code == EXIT_OK) code = apply(session, &a, &base, &tile, &timing);
    if (session) {
        cli_base_clear(session, &base);
        kn_tile_clear(cli_ctx(session), &tile);
        cli_job_end(session, &a.job);
    }
    cli_session_end(session);
    for (int i = 0; i < a.nowned; i++) free(a.owned[i]);
    return code < 0 ? EXIT_OK : code;
}
