// SPDX-License-Identifier: Apache-2.0
// knurl apply: a tile over a base, composed and written.
#include "cli/body.h"
#include "cli/plan.h"

#include <string.h>

enum { DRY_RUN = CLI_JOB_OPTIONS, SYMBOLIC, RESUME, OBJ_SURFACES, OUTPUT, HELP, END };
static const cli_option options[END - CLI_JOB_OPTIONS] = {
    [DRY_RUN - CLI_JOB_OPTIONS] = {"dry-run", 'n', CLI_NOTHING},
    [SYMBOLIC - CLI_JOB_OPTIONS] = {"symbolic", 0, CLI_NOTHING},
    [RESUME - CLI_JOB_OPTIONS] = {"resume", 0, CLI_NOTHING},
    [OBJ_SURFACES - CLI_JOB_OPTIONS] = {"obj-surfaces", 0, CLI_NOTHING},
    [OUTPUT - CLI_JOB_OPTIONS] = {"output", 'o', CLI_TEXT},
    [HELP - CLI_JOB_OPTIONS] = {"help", 'h', CLI_NOTHING},
};

static bool set_symbolic(cli_recipe *recipe)
{
    for (int i = 0; i < recipe->nlayers; i++) recipe->layer[i].options.symbolic = true;
    return true;
}

static bool set_option(cli_apply *a, int option, const char *value)
{
    if (option < CLI_JOB_OPTIONS) return cli_recipe_set(&a->recipe, option, value);
    switch (option) {
    case DRY_RUN: return a->dry_run = true;
    case SYMBOLIC: return set_symbolic(&a->recipe);
    case RESUME: return a->resume = true;
    case OBJ_SURFACES: return a->obj_surfaces = true;
    case OUTPUT: return cli_add_output(&a->recipe, "-o", value);
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
        if (option == CLI_POSITIONAL && a->recipe.layer[0].base) {
            cli_error("apply: one base at a time, got '%s' and '%s'", a->recipe.layer[0].base, value);
            return EXIT_USAGE;
        }
        if (option == CLI_POSITIONAL) {
            int code = cli_recipe_base(&a->recipe, value);
            if (code != EXIT_OK) return code;
        } else if (!set_option(a, option, value))
            return EXIT_USAGE;
    }
    return EXIT_OK;
}

// A journal is of sinks that write as they go. A glTF file begins with numbers that only its end knows.
static const char *resume_conflict(const cli_apply *a)
{
    if (a->recipe.layer[0].merge)
        return "--resume: patches that --merge puts together wait in memory: one or the other";
    if (a->recipe.layer[0].instances) return "--resume: what --instances compares waits in memory: one or the other";
    for (int i = 0; i < a->recipe.noutputs; i++)
        if (cli_has_ending(a->recipe.outputs[i], "glb") || cli_has_ending(a->recipe.outputs[i], "gltf"))
            return "--resume: a glTF file is held in memory until its end: write .step, .stl or .obj, or without "
                   "--resume";
    for (int i = 0; i < a->recipe.noutputs; i++)
        if (cli_has_ending(a->recipe.outputs[i], "stpz") || cli_has_ending(a->recipe.outputs[i], "3dm") ||
            cli_has_ending(a->recipe.outputs[i], "mesh"))
            return "--resume: .stpz, .3dm and .mesh files cannot be gone on with: write .step, or without --resume";
    return NULL;
}

static const char *instances_conflict(const cli_apply *a)
{
    const cli_job *job = &a->recipe.layer[0];
    if (!job->instances) return NULL;
    if (job->merge) return "--instances: faces that --merge puts together belong to several cells: one or the other";
    return job->step == KN_STEP_AP203 ? "--instances: AP203 controls each part of an assembly: AP214 or AP242" : NULL;
}

static int check_arguments(const cli_apply *a)
{
    const cli_recipe *r = &a->recipe;
    const char *no_resume = a->resume && !a->dry_run ? resume_conflict(a) : NULL;
    const char *apart = instances_conflict(a);
    const char *missing = !r->layer[0].base                 ? "a BASE file is missing"
                          : !r->layer[0].tile               ? "--tile is missing ('knurl tiles' lists them)"
                          : r->noutputs == 0 && !a->dry_run ? "no output: give -o OUT, or --dry-run"
                          : no_resume                       ? no_resume
                          : apart                           ? apart
                                                            : cli_recipe_conflict(r);
    if (!missing) return EXIT_OK;
    cli_error("apply: %s", missing);
    cli_usage_hint("apply");
    return EXIT_USAGE;
}

// What the job cannot know of its own options: fields are known by the texts that they were made of.
static uint64_t identity_of(const cli_job *job, uint64_t hash) // FNV-1a
{
    for (int i = -1; i < job->nvary; i++) {
        const char *texts[2] = {i < 0 ? job->color.field.text : job->vary[i].parameter,
                                i < 0 ? job->mask.text : job->vary[i].value.text};
        for (int k = 0; k < 2; k++) // each with the zero byte at its end
            for (const char *c = texts[k] ? texts[k] : "", *end = c + strlen(c) + 1; c < end; c++)
                hash = (hash ^ (unsigned char)*c) * UINT64_C(0x100000001b3);
    }
    return hash;
}

// With a journal beside the first output, when it is to be resumed.
static kn_status run_jobs(kn_ctx *ctx, const cli_apply *a, const cli_plan *plan, kn_sink *sinks, int n)
{
    if (!a->resume) {
        if (plan->nshown == 1) return kn_job_run(ctx, plan->shown[0], sinks, n);
        return kn_job_run_layers(ctx, plan->shown, plan->nshown, sinks, n);
    }
    char journal[4096];
    snprintf(journal, sizeof journal, "%s.journal", a->recipe.outputs[0]);
    uint64_t identity = UINT64_C(0xcbf29ce484222325);
    for (int i = 0; i < plan->nshown; i++) identity = identity_of(&a->recipe.layer[plan->shown_layer[i]], identity);
    return kn_run_with_journal(ctx, plan->shown, plan->nshown, sinks, n, journal, true, 0, identity);
}

// Opens the sinks, runs the jobs, closes them all whatever happened.
static kn_status run(kn_ctx *ctx, const cli_apply *a, const cli_plan *plan, const cli_body_run *body, cli_fit *fit,
                     double *bytes)
{
    const kn_step_host *host = body->body.host.entities ? &body->body.host : NULL;
    kn_sink opened[CLI_MAX_OUTPUTS];
    bool cad[CLI_MAX_OUTPUTS];
    int open = 0;
    kn_status status = KN_OK;
    for (; open < a->recipe.noutputs && status == KN_OK; open += status == KN_OK) {
        cad[open] = cli_writes_cad(a->recipe.outputs[open]);
        status = cli_open_sink(ctx, &opened[open], a->recipe.outputs[open],
                               &(cli_output_options){.unit_mm = a->recipe.layer[0].unit_mm,
                                                     .obj_surfaces = a->obj_surfaces,
                                                     .host = host,
                                                     .schema = a->recipe.layer[0].step,
                                                     .gap_mm = body->body.gap,
                                                     .instances = a->recipe.layer[0].instances,
                                                     .base = plan->base});
    }
    if (status != KN_OK)
        for (int i = 0; i < open; i++) kn_sink_close(ctx, &opened[i]);
    if (status == KN_OK) status = cli_fit_sinks(ctx, fit, opened, cad, open, &a->recipe.layer[0]);
    if (status != KN_OK) return status;
    status = run_jobs(ctx, a, plan, fit->sinks, fit->nsinks);
    for (int i = 0; i < open; i++) bytes[i] = opened[i].bytes ? (double)opened[i].bytes(opened[i].user) : 0.0;
    for (int i = 0; i < fit->nsinks; i++) kn_sink_close(ctx, &fit->sinks[i]);
    return status;
}

// STEP files say that points within a micrometre are one, and CAD systems merge what is closer: a base in another
// unit than the one that was said shows here.
static void warn_of_size(cli_session *session, const cli_apply *a, const char *path, const kn_job_report *report)
{
    double cell_mm = report->cell_size * a->recipe.layer[0].unit_mm;
    if (cell_mm < 0.01)
        cli_warn(session,
                 "%s: cells of %.2g mm are too small for CAD systems, which merge points within 0.001 mm; "
                 "is --unit right?",
                 path, cell_mm);
}

// What is beyond a receiver's degree it leaves out, often without a word.
static void warn_of_degree(cli_session *session, const cli_apply *a, const char *path, const kn_job_report *report)
{
    int degree = report->degree[0] > report->degree[1] ? report->degree[0] : report->degree[1];
    int most = cli_limits_of(&a->recipe.layer[0]).max_degree;
    if (degree > most) degree = most;
    if (degree > 25)
        cli_warn(session,
                 "%s: faces of degree up to %d: OCCT reads none above 25, CATIA none above 15, VDA-FS none above 11 "
                 "(--max-degree)",
                 path, degree);
}

static void warn_of_receivers(cli_session *session, const cli_apply *a, const kn_job_report *report)
{
    for (int i = 0; i < a->recipe.noutputs; i++)
        if (cli_has_ending(a->recipe.outputs[i], "step") || cli_has_ending(a->recipe.outputs[i], "stp")) {
            warn_of_size(session, a, a->recipe.outputs[i], report);
            warn_of_degree(session, a, a->recipe.outputs[i], report);
            return;
        }
}

// Whether a file is for CAD; so is what is only asked about.
static bool has_cad(const cli_apply *a)
{
    bool cad = a->recipe.noutputs == 0;
    for (int i = 0; i < a->recipe.noutputs; i++) cad = cad || cli_writes_cad(a->recipe.outputs[i]);
    return cad;
}

// Whether a file holds triangles where the texture has patches.
static bool has_triangles(const cli_apply *a)
{
    static const char *const endings[] = {"stl", "glb", "gltf", "pov", "vtu"}; // the last one of trimmed patches
    bool any = false;
    for (int i = 0; i < a->recipe.noutputs; i++) {
        for (size_t k = 0; k < sizeof endings / sizeof *endings; k++)
            any = any || cli_has_ending(a->recipe.outputs[i], endings[k]);
        any = any || (cli_has_ending(a->recipe.outputs[i], "obj") && !a->obj_surfaces);
    }
    return any;
}

// Options for faces of CAD files. A degree above the usual one is also what patches are composed with.
static void warn_without_cad(cli_session *session, const cli_apply *a)
{
    const cli_job *job = &a->recipe.layer[0];
    if (has_cad(a)) return;
    if (job->max_degree > 0 && job->options.max_degree == 0)
        cli_warn(session, "--max-degree: no CAD file is written, patches keep their degrees");
    if (job->mesh_tol.value > 0 && !has_triangles(a))
        cli_warn(session, "--tol: neither a CAD file nor triangles are written");
    if (job->seam_angle > 0) cli_warn(session, "--seam-angle: no CAD file is written, patches keep their normals");
    if (job->merge) cli_warn(session, "--merge: no CAD file is written, patches stay apart");
}

// Options that mean nothing for this base and these files.
static void warn_of_idle_options(cli_session *session, const cli_apply *a, const cli_base *base)
{
    const cli_job *job = &a->recipe.layer[0];
    bool step = a->recipe.noutputs == 0; // a dry run
    for (int i = 0; i < a->recipe.noutputs; i++) {
        const char *path = a->recipe.outputs[i];
        step = step || cli_has_ending(path, "step") || cli_has_ending(path, "stp") || cli_has_ending(path, "stpz");
    }
    if (job->step != KN_STEP_AP214 && !step) cli_warn(session, "--step: no STEP file is written");
    if (job->instances && !step) cli_warn(session, "--instances: no STEP file is written");
    warn_without_cad(session, a);
    if (base->cad.nfaces > 0) return;
    if (job->join_angle > 0.0)
        cli_warn(session, "--join-angle: %s is no CAD file, none of its surfaces are joined", job->base);
    if (job->options.trimmed != KN_TRIMMED_KEEP)
        cli_warn(session, "--trimmed: %s is no CAD file, none of its surfaces are trimmed", job->base);
}

// What is wrong with a journal is said with its path.
static int fail_on_run(cli_session *session, kn_status status, const cli_apply *a)
{
    char journal[4096];
    const char *message = kn_ctx_message(cli_ctx(session));
    bool blame = a->resume && (strstr(message, "interrupted run") || strstr(message, "no state of a run"));
    if (!blame) return cli_fail(session, status, false);
    snprintf(journal, sizeof journal, "%s.journal", a->recipe.outputs[0]);
    return cli_fail_on(session, status, journal, false);
}

// Triangles have no room for curves.
static void warn_of_curves(cli_session *session, const cli_apply *a, const kn_job_report *report)
{
    for (int i = 0; i < a->recipe.noutputs && report->curves > 0; i++) {
        const char *path = a->recipe.outputs[i];
        if (cli_has_ending(path, "stl"))
            cli_warn(session, "%s: the tile's curves are left out; .step, .obj and .glb hold them", path);
    }
}

// What the files will be, before anything is written.
static kn_status estimate(kn_ctx *ctx, const cli_apply *a, const cli_plan *plan, cli_fit *fit, double *bytes)
{
    kn_job_report limited = plan->report;
    kn_status status = has_cad(a) ? cli_estimate_fit(ctx, fit, plan, &a->recipe.layer[0]) : KN_OK;
    if (status == KN_OK && fit->sum.limited > 0) limited.control_points = fit->sum.control_points;
    for (int i = 0; i < a->recipe.noutputs && status == KN_OK; i++)
        bytes[i] = cli_estimate_bytes(a->recipe.outputs[i],
                                      cli_writes_cad(a->recipe.outputs[i]) ? &limited : &plan->report);
    return status;
}

static int apply(cli_session *session, cli_apply *a, const cli_plan *plan, const cli_body_run *body,
                 cli_timing *timing)
{
    kn_ctx *ctx = cli_ctx(session);
    double bytes[CLI_MAX_OUTPUTS], began = cli_seconds();
    cli_fit fit = {.options = cli_limits_of(&a->recipe.layer[0])};
    warn_of_receivers(session, a, &plan->report);
    warn_of_curves(session, a, &plan->report);
    kn_status status = a->dry_run ? estimate(ctx, a, plan, &fit, bytes) : run(ctx, a, plan, body, &fit, bytes);
    timing->run = cli_seconds() - began;
    if (status != KN_OK) return fail_on_run(session, status, a);
    if (plan->report.cells == 0) cli_warn(session, "%s: no cell is left of the texture", a->recipe.layer[0].base);
    cli_print_apply(a, plan, &fit, body, bytes, timing, kn_ctx_counters(ctx).peak_bytes);
    return EXIT_OK;
}

static int work(cli_session *session, cli_apply *a)
{
    cli_inputs inputs = {0};
    cli_plan plan = {0};
    cli_body_run body = {.mode = CLI_BODY_NONE};
    cli_timing timing = {0};
    double began = cli_seconds();
    bool cad = has_cad(a);
    for (int i = 0; i < a->recipe.nlayers; i++) a->recipe.layer[i].options.equal_edges = cad;
    int code = cli_inputs_begin(session, &inputs, &a->recipe);
    timing.read = cli_seconds() - began;
    began = cli_seconds();
    if (code == EXIT_OK) warn_of_idle_options(session, a, &inputs.base);
    if (code == EXIT_OK) code = cli_plan_begin(session, &plan, &a->recipe, &inputs);
    timing.plan = cli_seconds() - began;
    if (code == EXIT_OK && !a->dry_run) code = cli_body_begin(session, &body, a, &plan, &inputs);
    timing.plan = cli_seconds() - began;
    if (code == EXIT_OK) code = apply(session, a, &plan, &body, &timing);
    cli_body_end(session, &body);
    cli_plan_end(session, &plan);
    cli_inputs_end(session, &inputs, &a->recipe);
    return code;
}

int cli_command_apply(int argc, char **argv)
{
    cli_apply a = {.dry_run = false};
    cli_recipe_begin(&a.recipe);
    int code = read_arguments(&a, argc, argv);
    if (code == EXIT_OK) code = check_arguments(&a);
    if (code == EXIT_OK) {
        const cli_job *job = &a.recipe.layer[0];
        cli_session *session = cli_session_begin((cli_session_options){.threads = job->threads, .quiet = job->quiet});
        code = session ? work(session, &a) : EXIT_FAILED;
        cli_session_end(session);
    }
    cli_recipe_end(&a.recipe);
    return code < 0 ? EXIT_OK : code;
}
