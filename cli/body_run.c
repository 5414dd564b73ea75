// SPDX-License-Identifier: Apache-2.0
// The body of a CAD base in the STEP files of a run: which of its faces the texture replaces, and what knurl-cad makes
// of the others.
#include "cli/body.h"
#include "cli/plan.h"
#include "kernel/context.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <string.h>

enum { BODY, OPTIONS };
static const cli_option options[OPTIONS] = {[BODY] = {"body", 0, CLI_TEXT}};

static bool set(cli_job *job, const char *name, int option, const char *text)
{
    static const char *const names[] = {"replace", "cover", "none"};
    int i = option == BODY ? cli_choice(name, text, names, 3, "replace, cover or none") : -1;
    if (i >= 0) job->body = (cli_body_mode)(CLI_BODY_REPLACE + i);
    return i >= 0;
}

const cli_theme cli_body_options = {options, OPTIONS, CLI_OF_RECIPE, set};

// ---- what the texture covers ----

static bool is_step(const char *path)
{
    return cli_has_ending(path, "step") || cli_has_ending(path, "stp") || cli_has_ending(path, "stpz");
}

static bool has_step(const cli_apply *a)
{
    bool step = false;
    for (int i = 0; i < a->recipe.noutputs; i++) step = step || is_step(a->recipe.outputs[i]);
    return step;
}

// IGES is for CAD as well, and there the body does not go out.
static void warn_of_iges(cli_session *session, const cli_apply *a)
{
    for (int i = 0; i < a->recipe.noutputs; i++) {
        const char *path = a->recipe.outputs[i];
        if (cli_has_ending(path, "igs") || cli_has_ending(path, "iges"))
            cli_warn(session, "%s: the texture alone: bodies (--body) go out in STEP", path);
    }
}

static kn_status is_sheet(kn_ctx *ctx, bool *is, const kn_job *job)
{
    kn_job_report r = kn_job_describe(job);
    kn_tile_coverage_report cover = {0};
    kn_status status = kn_tile_coverage(ctx, &cover, kn_job_tile(job), NULL);
    *is = status == KN_OK && cover.covers == KN_YES && r.volumes == 0 && r.meshes == 0 && r.curves == 0;
    kn_tile_coverage_clear(ctx, &cover);
    return status;
}

static size_t left_out(const kn_job *job)
{
    kn_job_report r = kn_job_describe(job);
    size_t n = 0;
    for (int i = 0; i < KN_DROP_REASONS; i++)
        if (i != KN_DROP_SURFACE) n += r.dropped[i];
    return n;
}

static bool is_selected(const kn_job_selection *s, int surface)
{
    for (int i = 0; i < s->nsurfaces && s->surfaces; i++)
        if (s->surfaces[i] == surface) return true;
    return !s->surfaces;
}

// The edges of a job's patches at the ends of surfaces, limited as they will be in the file, go to the others.
static kn_status add_border(kn_ctx *ctx, cli_body_run *run, const kn_job *job, const cli_job *layer)
{
    cli_border border;
    kn_sink sink;
    bool cad = true;
    cli_fit fit = {.options = cli_limits_of(layer)};
    kn_status status = cli_border_sink(ctx, &sink, &border, job);
    if (status != KN_OK) return status;
    status = cli_fit_sinks(ctx, &fit, &sink, &cad, 1, layer);
    if (status == KN_OK) {
        status = kn_job_run(ctx, job, fit.sinks, fit.nsinks);
        for (int i = 0; i < fit.nsinks; i++) kn_sink_close(ctx, &fit.sinks[i]);
    }
    if (status == KN_OK) status = cli_border_move(ctx, &run->border, &border);
    cli_border_clear(ctx, &border);
    return status;
}

static kn_status take_layer(kn_ctx *ctx, cli_body_run *run, const kn_job *job, const cli_job *layer,
                            const cli_base *base)
{
    bool sheet = false;
    cli_body_plan *plan = &run->plan;
    kn_status status = is_sheet(ctx, &sheet, job);
    if (status != KN_OK || !sheet || layer->on > 0) return status;
    if (left_out(job) > 0) snprintf(plan->why, sizeof plan->why, "cells are left out: the texture would have holes");
    for (int s = 0; s < base->nsurfaces; s++) {
        if (!is_selected(&layer->options.select, s)) continue;
        if (run->face[s] >= 0) snprintf(plan->why, sizeof plan->why, "two textures cover face %d", base->face[s]);
        run->face[s] = base->face[s];
    }
    return plan->why[0] ? KN_OK : add_border(ctx, run, job, layer);
}

// What can be replaced, or why nothing can: run->plan.
static kn_status make_plan(kn_ctx *ctx, cli_body_run *run, const cli_apply *a, const cli_plan *plan,
                           const cli_base *base)
{
    kn_status status = KN_OK;
    bool any = false;
    for (int i = 0; i < plan->nshown && status == KN_OK && !run->plan.why[0]; i++)
        status = take_layer(ctx, run, plan->shown[i], &a->recipe.layer[plan->shown_layer[i]], base);
    for (int s = 0; s < base->nsurfaces; s++) any = any || run->face[s] >= 0;
    if (status != KN_OK || run->plan.why[0]) return status;
    cli_border_sort(&run->border);
    if (any)
        return cli_body_plan_add(ctx, &run->plan, &base->cad, run->face, base->joined.turns, base->nsurfaces,
                                 &run->border);
    snprintf(run->plan.why, sizeof run->plan.why,
             "the tile leaves gaps: it stands on its faces and does not replace them");
    return KN_OK;
}

// ---- knurl-cad ----

static kn_status ask(kn_ctx *ctx, cli_body_run *run, const cli_apply *a, const cli_base *base)
{
    const cli_body_plan *plan = run->mode == CLI_BODY_REPLACE ? &run->plan : NULL;
    static const char *const schemas[] = {
        [KN_STEP_AP214] = "AP214", [KN_STEP_AP242] = "AP242", [KN_STEP_AP203] = "AP203"};
    const char *const arguments[] = {"knurl-cad", "host", base->path, schemas[a->recipe.layer[0].step], NULL};
    // Edges in CAD files are up to some hundredths off their surfaces; limited patches are within their tolerance.
    double tolerance = 0.05 + 2.0 * cli_limits_of(&a->recipe.layer[0]).tolerance;
    char *request = NULL;
    unsigned char *answer = NULL;
    size_t n = 0, bytes = 0;
    kn_status status = cli_body_request(ctx, &request, &n, plan, tolerance);
    if (status != KN_OK) return status;
    FILE *file = tmpfile();
    bool written = file && fwrite(request, 1, n, file) == n && fflush(file) == 0 && fseek(file, 0, SEEK_SET) == 0;
    if (!written) status = kn_fail(ctx, KN_EIO, "a temporary file: %s", strerror(errno));
    if (status == KN_OK) status = cli_run_cad(ctx, &answer, &bytes, arguments, base->path, file);
    if (status == KN_OK)
        status = cli_body_parse(ctx, &run->body, "knurl-cad", (char *)answer, bytes, plan, run->face, base);
    if (status != KN_OK) kn_free(ctx, answer);
    if (file) fclose(file);
    kn_free(ctx, request);
    return status;
}

static int decide(cli_session *session, cli_body_run *run, const cli_apply *a, const cli_base *base)
{
    const cli_job *job = &a->recipe.layer[0];
    if (job->body == CLI_BODY_COVER || run->plan.why[0])
        run->mode = CLI_BODY_COVER;
    else
        run->mode = CLI_BODY_REPLACE;
    if (job->body == CLI_BODY_REPLACE && run->mode == CLI_BODY_COVER) {
        cli_error("%s: --body replace: %s", base->path, run->plan.why);
        return EXIT_BAD_INPUT;
    }
    if (run->plan.why[0])
        cli_warn(session, "%s: its faces stay below the texture (--body cover): %s", base->path, run->plan.why);
    return EXIT_OK;
}

int cli_body_begin(cli_session *session, cli_body_run *run, const cli_apply *a, const cli_plan *plan,
                   const cli_inputs *inputs)
{
    kn_ctx *ctx = cli_ctx(session);
    const cli_base *base = &inputs->base;
    cli_body_mode wanted = a->recipe.layer[0].body;
    *run = (cli_body_run){.mode = CLI_BODY_NONE};
    bool asked = wanted == CLI_BODY_REPLACE || wanted == CLI_BODY_COVER;
    if (asked && (base->cad.nfaces == 0 || !has_step(a))) {
        cli_error("--body: it needs a base from a CAD file and a STEP file to write");
        return EXIT_USAGE;
    }
    if (base->cad.nfaces > 0 && wanted != CLI_BODY_NONE) warn_of_iges(session, a);
    if (base->cad.nfaces == 0 || !has_step(a) || wanted == CLI_BODY_NONE) return EXIT_OK;
    run->face = kn_alloc(ctx, (size_t)base->nsurfaces, sizeof *run->face);
    for (int s = 0; run->face && s < base->nsurfaces; s++) run->face[s] = -1;
    kn_status status = run->face ? KN_OK : KN_ENOMEM;
    if (status == KN_OK && wanted != CLI_BODY_COVER) status = make_plan(ctx, run, a, plan, base);
    int code = status == KN_OK ? decide(session, run, a, base) : cli_fail(session, status, false);
    if (code == EXIT_OK) {
        status = ask(ctx, run, a, base);
        if (status != KN_OK) code = cli_fail(session, status, true);
    }
    run->body.kept = base->cad.nfaces - run->body.replaced;
    run->closed = true;
    for (int i = 0; i < run->body.host.nshells; i++) run->closed = run->closed && run->body.host.shells[i].closed;
    for (int i = 0; i < base->cad.nbodies && run->body.host.nshells == 0; i++)
        run->closed = run->closed && base->cad.bodies[i].solid;
    return code;
}

void cli_body_end(cli_session *session, cli_body_run *run)
{
    kn_ctx *ctx = cli_ctx(session);
    cli_body_clear(ctx, &run->body);
    cli_body_plan_clear(ctx, &run->plan);
    cli_border_clear(ctx, &run->border);
    kn_free(ctx, run->face);
    *run = (cli_body_run){.mode = CLI_BODY_NONE};
}

// ---- what is said of it ----

json_t *cli_body_json(const cli_body_run *run)
{
    if (run->mode == CLI_BODY_NONE) return json_null();
    json_t *o = json_pack("{s:s,s:i,s:i,s:b,s:o}", "mode", run->mode == CLI_BODY_REPLACE ? "replace" : "cover",
                          "faces_replaced", run->body.replaced, "faces_kept", run->body.kept, "closed", run->closed,
                          "gap_mm", cli_json_upper(run->body.gap));
    if (run->plan.why[0]) json_object_set_new(o, "why_not_replaced", cli_json_text(run->plan.why));
    return o;
}

void cli_print_body(const cli_body_run *run)
{
    if (run->mode == CLI_BODY_COVER) printf("over the %d faces of the base, which stay\n", run->body.kept);
    if (run->mode == CLI_BODY_REPLACE)
        printf("in the place of %d face%s of the base, beside %d that stay: %s\n", run->body.replaced,
               run->body.replaced == 1 ? "" : "s", run->body.kept, run->closed ? "closed" : "open");
}
