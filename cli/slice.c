// SPDX-License-Identifier: Apache-2.0
// knurl slice: contours of a texture on a base, layer by layer, as drawings or as one 3MF file.
#include "cli/plan.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#if KN_WITH_LIB3MF
#include "bridges/lib3mf/slices.h"
#endif

enum { LAYER = CLI_JOB_OPTIONS, FROM, TO, OUTPUT, HELP, END };
static const cli_option options[END - CLI_JOB_OPTIONS] = {
    [LAYER - CLI_JOB_OPTIONS] = {"layer", 'l', CLI_TEXT},  [FROM - CLI_JOB_OPTIONS] = {"from", 0, CLI_TEXT},
    [TO - CLI_JOB_OPTIONS] = {"to", 0, CLI_TEXT},          [OUTPUT - CLI_JOB_OPTIONS] = {"output", 'o', CLI_TEXT},
    [HELP - CLI_JOB_OPTIONS] = {"help", 'h', CLI_NOTHING},
};

typedef struct slicing {
    cli_recipe recipe;
    cli_length layer, from, to;
    bool has_from, has_to;
    // what the work finds
    double unit_mm, step, box[4], bottom, top;
    size_t count, written, empty; // layers that there may be; that are written; that wait for contours above them
    cli_plan plan;
    kn_slice_options options;
    kn_slice_job_report report;
    size_t nloops, nopen, npoints, doubtful;
    double gap, error;
    size_t bytes[CLI_MAX_OUTPUTS];
#if KN_WITH_LIB3MF
    kn_3mf_slices *stacks[CLI_MAX_OUTPUTS];
#endif
} slicing;

static bool can_write(const char *path)
{
#if KN_WITH_LIB3MF
    if (cli_has_ending(path, "3mf")) return true;
#endif
    return cli_has_ending(path, "svg");
}

static bool add_output(slicing *s, const char *path)
{
    if (!can_write(path)) {
#if KN_WITH_LIB3MF
        cli_error("-o: '%s': slices are written as .svg or .3mf", path);
#else
        cli_error("-o: '%s': slices are written as .svg (built without lib3mf: no .3mf)", path);
#endif
        return false;
    }
    return cli_take_output("-o", s->recipe.outputs, &s->recipe.noutputs, CLI_MAX_OUTPUTS, path);
}

static bool set_option(slicing *s, int option, const char *value)
{
    if (option < CLI_JOB_OPTIONS) return cli_recipe_set(&s->recipe, option, value);
    switch (option) {
    case LAYER: return cli_positive_length("--layer", value, &s->layer);
    case FROM: return s->has_from = cli_length_of("--from", value, &s->from);
    case TO: return s->has_to = cli_length_of("--to", value, &s->to);
    case OUTPUT: return add_output(s, value);
    default: return false;
    }
}

// EXIT_OK, an exit code after a message, or -1 when help was asked for and given.
static int read_arguments(slicing *s, int argc, char **argv)
{
    cli_args args = {.argc = argc,
                     .at = 1,
                     .argv = argv,
                     .options = options,
                     .job = true,
                     .command = "slice",
                     .noptions = sizeof options / sizeof *options};
    const char *value;
    for (int option; (option = cli_next(&args, &value)) != CLI_END;) {
        if (option == CLI_BAD) return EXIT_USAGE;
        if (option == HELP) return cli_help(stdout, "slice") == EXIT_OK ? -1 : EXIT_FAILED;
        if (option == CLI_POSITIONAL && s->recipe.layer[0].base) {
            cli_error("slice: one base at a time, got '%s' and '%s'", s->recipe.layer[0].base, value);
            return EXIT_USAGE;
        }
        if (option == CLI_POSITIONAL) {
            int code = cli_recipe_base(&s->recipe, value);
            s->recipe.noutputs = 0; // those of the recipe are apply's
            if (code != EXIT_OK) return code;
        } else if (!set_option(s, option, value))
            return EXIT_USAGE;
    }
    return EXIT_OK;
}

static int check_arguments(const slicing *s)
{
    const cli_recipe *r = &s->recipe;
    const char *missing = !r->layer[0].base         ? "a BASE file is missing"
                          : !r->layer[0].tile       ? "--tile is missing ('knurl tiles' lists them)"
                          : !(s->layer.value > 0.0) ? "--layer L, the distance of layers, is missing"
                          : r->noutputs == 0        ? "no output: give -o OUT.svg or OUT.3mf"
                                                    : cli_recipe_conflict(r);
    if (!missing) return EXIT_OK;
    cli_error("slice: %s", missing);
    cli_usage_hint("slice");
    return EXIT_USAGE;
}

static double in_units(const slicing *s, cli_length length)
{
    return length.unit_mm > 0 ? length.value * (length.unit_mm / s->unit_mm) : length.value;
}

// Layers lie between the lowest and the highest point of all jobs, or where they are asked for; contours are taken in
// the middle of each.
static int find_layers(cli_session *session, slicing *s)
{
    kn_ctx *ctx = cli_ctx(session);
    double lo = INFINITY, hi = -INFINITY;
    for (int i = 0; i < s->plan.nshown; i++) {
        kn_job_slabs *slabs = NULL;
        double z[2];
        kn_status status = kn_job_slabs_create(ctx, &slabs, s->plan.shown[i]);
        if (status != KN_OK) return cli_fail(session, status, false);
        kn_job_slabs_range(slabs, z);
        kn_job_slabs_destroy(ctx, slabs);
        lo = fmin(lo, z[0]);
        hi = fmax(hi, z[1]);
    }
    s->step = in_units(s, s->layer);
    if (lo > hi || (!isfinite(lo) && !s->has_from) || (!isfinite(hi) && !s->has_to)) {
        cli_error("slice: %s: %s", s->recipe.layer[0].base,
                  lo > hi ? "no cell is left of the texture"
                          : "how high the texture reaches is not known: say it by --from and --to");
        return EXIT_BAD_INPUT;
    }
    s->bottom = s->has_from ? in_units(s, s->from) : lo;
    s->top = s->has_to ? in_units(s, s->to) : hi;
    double n = ceil((s->top - s->bottom) / s->step - 1e-9);
    if (!(n >= 1)) {
        cli_error("slice: no layer between z = %g and %g", s->bottom, s->top);
        return EXIT_BAD_INPUT;
    }
    if (n > 1 << 20) {
        cli_error("slice: %.0f layers between z = %g and %g; at most %d are made", n, s->bottom, s->top, 1 << 20);
        return EXIT_BAD_INPUT;
    }
    s->count = (size_t)n;
    const cli_job *job = &s->recipe.layer[0];
    double tol = job->options.mesh_tol > 0 ? job->options.mesh_tol : s->step / 20;
    s->options = (kn_slice_options){
        .first = s->bottom + 0.5 * s->step, .step = s->step, .count = s->count, .tol = tol};
    return EXIT_OK;
}

// The drawing: the base's box, and the height all around.
static int find_box(cli_session *session, slicing *s, const cli_inputs *in)
{
    double margin = 0;
    for (int d = 0; d < 2; d++) s->box[d] = INFINITY, s->box[2 + d] = -INFINITY;
    for (int i = 0; i < in->base.nsurfaces; i++) {
        double lo[3], hi[3];
        kn_status status = kn_spline_box(cli_ctx(session), lo, hi, &in->base.surfaces[i]);
        if (status != KN_OK) return cli_fail(session, status, false);
        for (int d = 0; d < 2; d++) {
            s->box[d] = fmin(s->box[d], lo[d]);
            s->box[2 + d] = fmax(s->box[2 + d], hi[d]);
        }
    }
    for (int i = 0; i < s->plan.nshown; i++) {
        const kn_job_report report = kn_job_describe(s->plan.shown[i]);
        margin += fabs(report.height) +
                  fabs(s->recipe.layer[s->plan.shown_layer[i]].options.offset); // one may lie on another
    }
    for (int d = 0; d < 2; d++) {
        s->box[d] -= 1.1 * margin + s->step;
        s->box[2 + d] += 1.1 * margin + s->step;
    }
    return EXIT_OK;
}

// "cup.svg" -> "cup-0012.svg"
static void drawing_path(char *out, size_t room, const slicing *s, const char *path, size_t index)
{
    int digits = 1;
    for (size_t n = s->count; n >= 10; n /= 10) digits++;
    size_t stem = strlen(path) - 4;
    snprintf(out, room, "%.*s-%0*zu.svg", (int)stem, path, digits, index + 1);
}

static kn_status open_stacks(kn_ctx *ctx, slicing *s, double bottom)
{
    kn_status status = KN_OK;
#if KN_WITH_LIB3MF
    for (int i = 0; i < s->recipe.noutputs && status == KN_OK; i++)
        if (!s->stacks[i] && cli_has_ending(s->recipe.outputs[i], "3mf"))
            status = kn_3mf_slices_create(ctx, &s->stacks[i], s->recipe.outputs[i], s->unit_mm, bottom,
                                          0.5 * s->step);
#else
    (void)ctx, (void)s, (void)bottom;
#endif
    return status;
}

static kn_status write_layer(kn_ctx *ctx, slicing *s, const kn_slice *layer)
{
    kn_status status = s->written == 0 ? open_stacks(ctx, s, layer->z - 0.5 * s->step) : KN_OK;
    for (int i = 0; i < s->recipe.noutputs && status == KN_OK; i++) {
        const char *path = s->recipe.outputs[i];
        char name[4096];
        if (cli_has_ending(path, "svg")) {
            kn_svg_options o = {.unit_mm = s->unit_mm, .box = {s->box[0], s->box[1], s->box[2], s->box[3]}};
            drawing_path(name, sizeof name, s, path, s->written);
            status = kn_write_svg_slice(ctx, name, layer, &o);
        }
#if KN_WITH_LIB3MF
        if (s->stacks[i]) status = kn_3mf_slices_add(ctx, s->stacks[i], layer);
#endif
    }
    s->written++;
    return status;
}

// Heights come from control points, beyond which nothing reaches, but some layers may be empty below all contours and
// above: without --from and --to these do not count.
static kn_status take_layer(kn_ctx *ctx, void *user, const kn_slice *layer)
{
    slicing *s = user;
    if (layer->nloops == 0 && ((s->written == 0 && !s->has_from) || !s->has_to)) {
        s->empty += s->written > 0 || s->has_from;
        return KN_OK;
    }
    kn_status status = KN_OK;
    if (s->written == 0) s->bottom = layer->z - (0.5 + (double)s->empty) * s->step;
    for (; s->empty > 0 && status == KN_OK; s->empty--)
        status = write_layer(ctx, s, &(kn_slice){.z = layer->z - (double)s->empty * s->step});
    if (status == KN_OK) status = write_layer(ctx, s, layer);
    if (!s->has_to) s->top = layer->z + 0.5 * s->step;
    s->nloops += layer->nloops;
    s->nopen += layer->nopen;
    s->doubtful += layer->doubtful;
    s->gap = fmax(s->gap, layer->gap);
    s->error = fmax(s->error, layer->error);
    for (size_t i = 0; i < layer->nloops; i++) s->npoints += layer->loops[i].npoints;
    return status;
}

static kn_status end_stacks(kn_ctx *ctx, slicing *s, kn_status status)
{
#if KN_WITH_LIB3MF
    for (int i = 0; i < s->recipe.noutputs; i++) {
        if (s->stacks[i] && status == KN_OK) status = kn_3mf_slices_write(ctx, s->stacks[i], &s->bytes[i]);
        kn_3mf_slices_destroy(ctx, s->stacks[i]);
    }
#else
    (void)ctx, (void)s;
#endif
    return status;
}

static void print(const slicing *s, double seconds, size_t peak)
{
    const cli_job *job = &s->recipe.layer[0];
    if (job->json) {
        json_t *o = json_pack("{s:o,s:I,s:f,s:f,s:f,s:f,s:I,s:I,s:I,s:o,s:o,s:I,s:I,s:I,s:f,s:I}", "base",
                              cli_json_text(job->base), "layers", (json_int_t)s->written, "layer", s->step, "bottom",
                              s->bottom, "top", s->top, "tolerance", s->options.tol, "contours",
                              (json_int_t)s->nloops, "open", (json_int_t)s->nopen, "points", (json_int_t)s->npoints,
                              "gap", cli_json_upper(s->gap), "error", cli_json_upper(s->error), "doubtful",
                              (json_int_t)s->doubtful, "cells_composed", (json_int_t)s->report.cells, "most_cells",
                              (json_int_t)s->report.most_cells, "seconds", seconds, "peak_bytes", (json_int_t)peak);
        json_dumpf(o, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
        putchar('\n');
        json_decref(o);
        return;
    }
    if (job->quiet) return;
    const char *unit = cli_unit_name(s->unit_mm);
    printf("%zu layers of %g %s, z from %g to %g %s\n", s->written, s->step, unit, s->bottom, s->top, unit);
    printf("%zu contours of %zu points within %g %s", s->nloops, s->npoints, s->options.tol, unit);
    if (s->nopen > 0) printf(", %zu of them open", s->nopen);
    if (s->gap > 0) printf(", ends joined over %.2g at most", s->gap);
    if (s->doubtful > 0) printf(", %zu places decided by rounding", s->doubtful);
    printf("\n%zu cells composed, at most %zu at a time; %.2f s, peak %.1f MB\n", s->report.cells,
           s->report.most_cells, seconds, 1e-6 * (double)peak);
}

// Curves have no inside, and so no contours: nothing else in a texture is an error, something else a warning.
static int check_inside(cli_session *session, const slicing *s)
{
    bool any = false;
    size_t curves = 0;
    for (int i = 0; i < s->plan.nshown; i++) {
        const kn_job_report report = kn_job_describe(s->plan.shown[i]);
        curves += report.curves;
        any = any || report.curves < report.patches;
    }
    if (curves == 0) return EXIT_OK;
    if (any) {
        cli_warn(session, "%zu curves are left out: they have no inside", curves);
        return EXIT_OK;
    }
    cli_error("slice: %s: the texture is made of curves alone, which have no inside and so no contours",
              s->recipe.layer[0].tile);
    return EXIT_BAD_INPUT;
}

static int slice(cli_session *session, slicing *s, const cli_inputs *in)
{
    kn_ctx *ctx = cli_ctx(session);
    double began = cli_seconds();
    int code = cli_plan_begin(session, &s->plan, &s->recipe, in);
    if (code == EXIT_OK) code = check_inside(session, s);
    if (code == EXIT_OK) code = find_layers(session, s);
    if (code == EXIT_OK) code = find_box(session, s, in);
    if (code == EXIT_OK) {
        kn_status status = kn_slice_job(ctx, s->plan.shown, s->plan.nshown, &s->options, take_layer, s, &s->report);
        status = end_stacks(ctx, s, status);
        if (status != KN_OK) code = cli_fail(session, status, false);
        if (code == EXIT_OK && s->written == 0) {
            cli_error("slice: no layer between z = %g and %g meets the texture: nothing is written", s->bottom,
                      s->top);
            code = EXIT_BAD_INPUT;
        }
    }
    cli_plan_end(session, &s->plan);
    if (code == EXIT_OK) print(s, cli_seconds() - began, kn_ctx_counters(ctx).peak_bytes);
    if (code == EXIT_OK && s->nopen > 0)
        cli_warn(session, "%zu contours are open: the textured object is no closed surface there", s->nopen);
    return code;
}

int cli_command_slice(int argc, char **argv)
{
    slicing s = {.unit_mm = 1};
    cli_recipe_begin(&s.recipe);
    int code = read_arguments(&s, argc, argv);
    if (code == EXIT_OK) code = check_arguments(&s);
    if (code == EXIT_OK) {
        const cli_job *job = &s.recipe.layer[0];
        s.unit_mm = job->unit_mm;
        cli_session *session = cli_session_begin((cli_session_options){.threads = job->threads, .quiet = job->quiet});
        cli_inputs inputs = {0};
        code = session ? cli_inputs_begin(session, &inputs, &s.recipe) : EXIT_FAILED;
        if (code == EXIT_OK) code = slice(session, &s, &inputs);
        if (session) cli_inputs_end(session, &inputs, &s.recipe);
        cli_session_end(session);
    }
    cli_recipe_end(&s.recipe);
    return code < 0 ? EXIT_OK : code;
}
