// SPDX-License-Identifier: Apache-2.0
// knurl convert: a model from one kind of file to others.
#include "cli/cli.h"

#include <jansson.h>
#include <string.h>

enum { OUTPUT, MAX_DEGREE, TOL, UNIT, OBJ_SURFACES, JSON, THREADS, QUIET, HELP };
static const cli_option options[] = {
    [OUTPUT] = {"output", 'o', CLI_TEXT},
    [MAX_DEGREE] = {"max-degree", 0, CLI_TEXT},
    [TOL] = {"tol", 0, CLI_TEXT},
    [UNIT] = {"unit", 0, CLI_TEXT},
    [OBJ_SURFACES] = {"obj-surfaces", 0, CLI_NOTHING},
    [JSON] = {"json", 0, CLI_NOTHING},
    [THREADS] = {"threads", 'j', CLI_TEXT},
    [QUIET] = {"quiet", 'q', CLI_NOTHING},
    [HELP] = {"help", 'h', CLI_NOTHING},
};

#define DEFAULT_TOL_MM 0.01

typedef struct request {
    const char *in, *out[CLI_MAX_OUTPUTS];
    int nout, threads;
    int max_degree; // 0: none
    double unit_mm;
    cli_length tol; // value 0: the default
    bool obj_surfaces, json, quiet;
} request;

// What IN is: a model, or faces of a CAD file.
typedef struct input {
    kn_model model;
    kn_cad cad;
} input;

// What went into one file.
typedef struct outcome {
    kn_limit_summary limits;
    double bytes;
} outcome;

static bool set_max_degree(const char *text, int *out)
{
    if (!cli_set_max_degree("--max-degree", text, out)) return false;
    if (*out == KN_MAX_DEGREE) *out = 0; // exact
    return true;
}

static bool add_output(request *r, const char *path)
{
    if (!cli_can_write(path)) {
        cli_error("-o: no writer for '%s'; endings: %s", path, cli_writable_endings());
        return false;
    }
    return cli_take_output("-o", r->out, &r->nout, CLI_MAX_OUTPUTS, path);
}

static bool set_option(request *r, int option, const char *value)
{
    switch (option) {
    case OUTPUT: return add_output(r, value);
    case MAX_DEGREE: return set_max_degree(value, &r->max_degree);
    case TOL: return cli_positive_length("--tol", value, &r->tol);
    case UNIT: return cli_set_unit("--unit", value, &r->unit_mm);
    case OBJ_SURFACES: return r->obj_surfaces = true;
    case JSON: return r->json = true;
    case THREADS: return cli_int("--threads", value, 1, 1024, &r->threads);
    case QUIET: return r->quiet = true;
    default: return false;
    }
}

// EXIT_OK, an exit code after a message, or -1 when help was asked for and given.
static int read_arguments(request *r, int argc, char **argv)
{
    cli_args args = {.argc = argc,
                     .at = 1,
                     .argv = argv,
                     .options = options,
                     .command = "convert",
                     .noptions = sizeof options / sizeof *options};
    const char *value;
    for (int option; (option = cli_next(&args, &value)) != CLI_END;) {
        if (option == CLI_BAD) return EXIT_USAGE;
        if (option == HELP) return cli_help(stdout, "convert") == EXIT_OK ? -1 : EXIT_FAILED;
        if (option == CLI_POSITIONAL && r->in) {
            cli_error("convert: one file at a time, got '%s' and '%s'", r->in, value);
            return EXIT_USAGE;
        }
        if (option == CLI_POSITIONAL)
            r->in = value;
        else if (!set_option(r, option, value))
            return EXIT_USAGE;
    }
    if (r->in && r->nout > 0) return EXIT_OK;
    cli_error("convert: %s", r->in ? "no output: give -o OUT" : "a file IN is missing");
    cli_usage_hint("convert");
    return EXIT_USAGE;
}

// ---- one file ----

static double length(const cli_length *l, double unit_mm)
{
    return l->unit_mm > 0.0 ? l->value * l->unit_mm / unit_mm : l->value;
}

// Degrees are lowered for files of splines alone: triangles are made of what is there.
static kn_status open_sinks(kn_ctx *ctx, kn_sink *out, const request *r, const input *in, const char *path,
                            double tol, outcome *done)
{
    kn_sink inner = {0};
    const cli_output_options output = {
        .unit_mm = r->unit_mm, .obj_surfaces = r->obj_surfaces, .cad = in->cad.nfaces > 0 ? &in->cad : NULL};
    kn_status status = cli_open_sink(ctx, &inner, path, &output);
    if (status != KN_OK || r->max_degree == 0) {
        *out = inner;
        return status;
    }
    const kn_limit_options o = {.max_degree = r->max_degree, .tolerance = tol};
    status = kn_limit_sink(ctx, out, &inner, 1, &o, &done->limits);
    if (status != KN_OK) kn_sink_close(ctx, &inner);
    return status;
}

static kn_status write_one(kn_ctx *ctx, const request *r, const input *in, const char *path, outcome *done)
{
    char name[KN_NAME_BYTES];
    kn_sink sink = {0};
    double tol = r->tol.value > 0.0 ? length(&r->tol, r->unit_mm) : DEFAULT_TOL_MM / r->unit_mm;
    bool cad = cli_writes_cad(path), free_form = r->obj_surfaces && cli_has_ending(path, "obj");
    const kn_stream_options o = {.mesh_tol = r->tol.value > 0.0 ? tol : 0.0,
                                 .split = cad,
                                 .unit_domains = cad || r->max_degree > 0,
                                 .max_degree = r->max_degree};
    cli_name_of(name, r->in);
    kn_status status = open_sinks(ctx, &sink, r, in, path, tol, done);
    if (status == KN_OK && in->cad.nfaces > 0)
        status = cli_stream_cad(ctx, &in->cad, name,
                                &(cli_cad_options){.trims = cli_holds_trims(path) || free_form,
                                                   .edges = cad,
                                                   .max_degree = r->max_degree,
                                                   .mesh_tol = o.mesh_tol},
                                &sink, 1);
    else if (status == KN_OK)
        status = kn_stream_model(ctx, &in->model, name, &o, &sink, 1);
    if (status == KN_OK && sink.bytes) done->bytes = (double)sink.bytes(sink.user);
    kn_sink_close(ctx, &sink);
    return status;
}

// ---- reports ----

static int left_out(const kn_model *model)
{
    int n = 0;
    for (int i = 0; i < model->nsplines; i++) {
        int dim = kn_spline_dim(&model->splines[i]), nvars = model->splines[i].nvars;
        n += nvars < 1 || nvars > 3 || dim < 2 || dim > 3;
    }
    return n;
}

static json_t *limits_json(const request *r, const kn_limit_summary *s)
{
    if (r->max_degree == 0) return json_null();
    return json_pack("{s:i,s:o,s:I,s:I,s:[i,i]}", "max_degree", r->max_degree, "certified_error",
                     cli_json_upper(s->error), "exact", (json_int_t)s->exact, "limited", (json_int_t)s->limited,
                     "degree", s->degree[0], s->degree[1]);
}

static void print_json(const request *r, const input *in, const outcome *done)
{
    const kn_model *model = &in->model;
    json_t *files = json_array();
    for (int i = 0; i < r->nout; i++)
        json_array_append_new(files, json_pack("{s:o,s:I,s:o}", "file", cli_json_text(r->out[i]), "bytes",
                                               (json_int_t)done[i].bytes, "fit", limits_json(r, &done[i].limits)));
    json_t *o = json_pack("{s:o,s:i,s:i,s:I,s:i,s:o}", "file", cli_json_text(r->in), "splines", model->nsplines,
                          "faces", in->cad.nfaces, "triangles", (json_int_t)model->mesh.ntriangles, "left_out",
                          left_out(model), "outputs", files);
    json_dumpf(o, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(15));
    putchar('\n');
    json_decref(o);
}

static void print_text(const request *r, const input *in, const outcome *done)
{
    if (in->cad.nfaces > 0)
        printf("%s: %d face%s, %d bod%s\n", r->in, in->cad.nfaces, in->cad.nfaces == 1 ? "" : "s", in->cad.nbodies,
               in->cad.nbodies == 1 ? "y" : "ies");
    else
        printf("%s: %d splines, %zu triangles\n", r->in, in->model.nsplines, in->model.mesh.ntriangles);
    for (int i = 0; i < r->nout; i++) {
        const kn_limit_summary *s = &done[i].limits;
        printf("%s  %.3g kB", r->out[i], done[i].bytes / 1000);
        if (s->limited > 0)
            printf("; %zu of %zu patches within %.2g, of degrees up to %d, %d", s->limited, s->limited + s->exact,
                   cli_outward(s->error, 1, CLI_TEXT_DIGITS), s->degree[0], s->degree[1]);
        putchar('\n');
    }
}

// ---- the command ----

static kn_status read_input(kn_ctx *ctx, input *out, const char *path)
{
    if (cli_is_mesh(path)) return cli_read_mesh(ctx, &out->model.mesh, path);
    return cli_is_cad(path) ? cli_read_cad(ctx, &out->cad, path) : kn_read_model(ctx, &out->model, path);
}

static int convert(cli_session *session, const request *r)
{
    kn_ctx *ctx = cli_ctx(session);
    input in = {0};
    outcome done[CLI_MAX_OUTPUTS] = {{.bytes = 0.0}};
    kn_status status = read_input(ctx, &in, r->in);
    int code = status == KN_OK ? EXIT_OK : cli_fail_on(session, status, r->in, true);
    if (code == EXIT_OK && left_out(&in.model) > 0)
        cli_warn(session, "%s: %d of its %d splines do not lie in space and are left out", r->in, left_out(&in.model),
                 in.model.nsplines);
    for (int i = 0; code == EXIT_OK && i < r->nout; i++) {
        status = write_one(ctx, r, &in, r->out[i], &done[i]);
        if (status != KN_OK) code = cli_fail_on(session, status, r->in, false);
    }
    if (code == EXIT_OK && r->json) print_json(r, &in, done);
    if (code == EXIT_OK && !r->json && !r->quiet) print_text(r, &in, done);
    kn_model_clear(ctx, &in.model);
    kn_cad_clear(ctx, &in.cad);
    return code;
}

int cli_command_convert(int argc, char **argv)
{
    request r = {.unit_mm = 1.0};
    int code = read_arguments(&r, argc, argv);
    if (code != EXIT_OK) return code < 0 ? EXIT_OK : code;
    cli_session *session = cli_session_begin((cli_session_options){.threads = r.threads, .quiet = r.quiet});
    if (!session) return EXIT_FAILED;
    code = convert(session, &r);
    cli_session_end(session);
    return code;
}
