// SPDX-License-Identifier: Apache-2.0
// knurl info: what is in a file.
#include "cli/cli.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#if KN_WITH_TINYGLTF
#include "bridges/tinygltf/gltf.h"
#endif

enum { JSON, HELP };
static const cli_option options[] = {[JSON] = {"json", 0, CLI_NOTHING}, [HELP] = {"help", 'h', CLI_NOTHING}};

typedef struct box {
    double lo[3], hi[3];
    bool any;
} box;

static void grow(box *b, const double *lo, const double *hi, int dim)
{
    for (int c = 0; c < 3; c++) {
        double l = c < dim ? lo[c] : 0, h = c < dim ? hi[c] : 0;
        b->lo[c] = !b->any || l < b->lo[c] ? l : b->lo[c];
        b->hi[c] = !b->any || h > b->hi[c] ? h : b->hi[c];
    }
    b->any = true;
}

static json_t *box_json(const box *b)
{
    if (!b->any) return json_null();
    return json_pack("[[fff],[fff]]", b->lo[0], b->lo[1], b->lo[2], b->hi[0], b->hi[1], b->hi[2]);
}

static void print_json(json_t *object)
{
    json_dumpf(object, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(15));
    putchar('\n');
    json_decref(object);
}

static void print_box(const box *b)
{
    if (b->any)
        printf("box   (%g, %g, %g) to (%g, %g, %g)\n", b->lo[0], b->lo[1], b->lo[2], b->hi[0], b->hi[1], b->hi[2]);
}

typedef struct spline_summary {
    int curves, surfaces, volumes, others, rational;
    size_t points, pieces;
    int lowest[2], highest[2]; // degrees of surfaces in u and v
    box box;
} spline_summary;

static kn_status summarize(kn_ctx *ctx, spline_summary *sum, const kn_spline *s)
{
    int *kind = s->nvars == 1   ? &sum->curves
                : s->nvars == 2 ? &sum->surfaces
                : s->nvars == 3 ? &sum->volumes
                                : &sum->others;
    (*kind)++;
    sum->rational += s->rational;
    sum->points += kn_spline_count(s);
    size_t pieces = 1;
    for (int d = 0; d < s->nvars; d++) pieces *= (size_t)kn_spline_spans(s, d);
    sum->pieces += pieces;
    if (s->nvars == 2)
        for (int d = 0; d < 2; d++) {
            if (sum->surfaces == 1 || s->degree[d] < sum->lowest[d]) sum->lowest[d] = s->degree[d];
            if (s->degree[d] > sum->highest[d]) sum->highest[d] = s->degree[d];
        }
    double lo[KN_MAX_COMPS], hi[KN_MAX_COMPS];
    kn_status status = kn_spline_box(ctx, lo, hi, s);
    if (status == KN_OK) grow(&sum->box, lo, hi, kn_spline_dim(s) < 3 ? kn_spline_dim(s) : 3);
    return status;
}

static void print_splines(const char *file, const spline_summary *s, json_t *notes, bool json)
{
    const char *format = cli_has_ending(file, "g2") ? "GoTools g2" : "Bezier patches (bpt)";
    if (json) {
        json_t *o = json_pack("{s:o,s:s,s:n,s:i,s:i,s:i,s:i,s:I,s:I,s:[ii],s:o}", "file", cli_json_text(file),
                              "format", format, "unit", "curves", s->curves, "surfaces", s->surfaces, "volumes",
                              s->volumes, "rational", s->rational, "pieces", (json_int_t)s->pieces, "control_points",
                              (json_int_t)s->points, "degree", s->highest[0], s->highest[1], "box",
                              box_json(&s->box));
        json_object_update(o, notes);
        print_json(o);
        return;
    }
    printf("%s: %s, no unit\n", file, format);
    printf("      %d curves, %d surfaces, %d volumes; %d rational\n", s->curves, s->surfaces, s->volumes,
           s->rational);
    printf("      %zu polynomial pieces, %zu control points\n", s->pieces, s->points);
    if (s->surfaces > 0)
        printf("      surface degrees %d..%d in u, %d..%d in v\n", s->lowest[0], s->highest[0], s->lowest[1],
               s->highest[1]);
    print_box(&s->box);
    cli_print_edges(notes);
}

static int info_splines(cli_session *session, const char *file, bool json)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_model model = {0};
    spline_summary sum = {0};
    kn_status status = kn_read_model(ctx, &model, file);
    for (int i = 0; i < model.nsplines && status == KN_OK; i++) status = summarize(ctx, &sum, &model.splines[i]);
    json_t *notes = json_object();
    if (status == KN_OK) status = cli_look_at_edges(ctx, notes, &model);
    if (status == KN_OK) print_splines(file, &sum, notes, json);
    json_decref(notes);
    kn_model_clear(ctx, &model);
    return status == KN_OK ? EXIT_OK : cli_fail(session, status, true);
}

static int info_arguments(int argc, char **argv, const char **file, bool *json)
{
    cli_args args = {.argc = argc,
                     .at = 1,
                     .argv = argv,
                     .options = options,
                     .command = "info",
                     .noptions = sizeof options / sizeof *options};
    const char *value;
    for (int option; (option = cli_next(&args, &value)) != CLI_END;) {
        if (option == CLI_BAD) return EXIT_USAGE;
        if (option == HELP) return cli_help(stdout, "info") == EXIT_OK ? -1 : EXIT_FAILED;
        if (option == JSON) *json = true;
        if (option == CLI_POSITIONAL && *file) {
            cli_error("info: one file at a time, got '%s' and '%s'", *file, value);
            return EXIT_USAGE;
        }
        if (option == CLI_POSITIONAL) *file = value;
    }
    if (*file) return EXIT_OK;
    cli_error("info: a FILE is missing");
    cli_usage_hint("info");
    return EXIT_USAGE;
}

#if KN_WITH_TINYGLTF
static int info_scene(cli_session *session, const char *file, bool json)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_scene scene = {0};
    kn_status status = kn_gltf_read(ctx, &scene, file);
    if (status != KN_OK) return cli_fail(session, status, true);
    size_t vertices = 0, triangles = 0;
    box all = {0};
    for (int i = 0; i < scene.nitems; i++) {
        const kn_mesh *m = &scene.items[i].mesh;
        vertices += m->nvertices;
        triangles += m->ntriangles;
        for (size_t v = 0; v < m->nvertices; v++) grow(&all, m->position + 3 * v, m->position + 3 * v, 3);
    }
    if (json)
        print_json(json_pack("{s:o,s:s,s:s,s:i,s:I,s:I,s:o}", "file", cli_json_text(file), "format", "glTF 2.0",
                             "unit", "m", "meshes", scene.nitems, "vertices", (json_int_t)vertices, "triangles",
                             (json_int_t)triangles, "box", box_json(&all)));
    else {
        printf("%s: glTF 2.0, metres, y up\n", file);
        printf("      %d meshes, %zu vertices, %zu triangles\n", scene.nitems, vertices, triangles);
        print_box(&all);
    }
    kn_scene_clear(ctx, &scene);
    return EXIT_OK;
}
#endif

int cli_command_info(int argc, char **argv)
{
    const char *file = NULL;
    bool json = false;
    int code = info_arguments(argc, argv, &file, &json);
    if (code != EXIT_OK) return code < 0 ? EXIT_OK : code;
    cli_session *session = cli_session_begin((cli_session_options){.threads = 1});
    if (!session) return EXIT_FAILED;
#if KN_WITH_TINYGLTF
    if (cli_has_ending(file, "glb") || cli_has_ending(file, "gltf"))
        code = info_scene(session, file, json);
    else
#endif
        code = cli_is_cad(file) ? cli_info_cad(session, file, json) : info_splines(session, file, json);
    cli_session_end(session);
    return code;
}
