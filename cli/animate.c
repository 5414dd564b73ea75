// SPDX-License-Identifier: Apache-2.0
// knurl animate: a texture that changes with time, as one glTF file with morph targets, as pictures, or as a video.
//
// Time t runs from 0 to 1. Wherever a value of --vary (in a recipe: "vary") says {t}, it is put in for every frame;
// the frames are then textures like any other.
#include "cli/plan.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#if KN_WITH_EMBREE && KN_WITH_PNG && KN_WITH_TINYGLTF
#define CAN_ANIMATE 1
#include "bridges/embree/render.h"
#include "bridges/png/png.h"
#include "bridges/tinygltf/gltf.h"
#else
#define CAN_ANIMATE 0
#endif

enum { FRAMES = CLI_JOB_OPTIONS, SECONDS, OUTPUT, WIDTH, HEIGHT_OF, SAMPLES, AZIMUTH, ELEVATION, HELP, END };
static const cli_option options[END - CLI_JOB_OPTIONS] = {
    [FRAMES - CLI_JOB_OPTIONS] = {"frames", 0, CLI_TEXT},
    [SECONDS - CLI_JOB_OPTIONS] = {"seconds", 0, CLI_TEXT},
    [OUTPUT - CLI_JOB_OPTIONS] = {"output", 'o', CLI_TEXT},
    [WIDTH - CLI_JOB_OPTIONS] = {"picture-width", 0, CLI_TEXT},
    [HEIGHT_OF - CLI_JOB_OPTIONS] = {"picture-height", 0, CLI_TEXT},
    [SAMPLES - CLI_JOB_OPTIONS] = {"samples", 0, CLI_TEXT},
    [AZIMUTH - CLI_JOB_OPTIONS] = {"azimuth", 0, CLI_TEXT},
    [ELEVATION - CLI_JOB_OPTIONS] = {"elevation", 0, CLI_TEXT},
    [HELP - CLI_JOB_OPTIONS] = {"help", 'h', CLI_NOTHING},
};

enum { MAX_FRAMES = 1000, MAX_TEXT = 1024 };
typedef struct animate {
    cli_recipe recipe;
    int frames, width, height, samples;
    double seconds, azimuth, elevation;
} animate;

#if CAN_ANIMATE

// ---- one frame ----

// How finely each patch is drawn, in the order in which they come: as in the frame that asks for most, so that all
// frames have the same triangles.
typedef struct detail {
    int (*segments)[3];
    size_t count, room;
    unsigned long changes; // how often some patch asked for more than frames before
} detail;

// Tessellates what a job makes: an item for each part of the tile.
typedef struct collector {
    kn_scene *scene;
    detail *detail;
    size_t *at; // patches of this frame so far
    int first;  // item of part 0
} collector;

static bool make_room(detail *d, size_t count)
{
    if (count <= d->room) return true;
    size_t room = 2 * d->room > count ? 2 * d->room : count;
    void *more = realloc(d->segments, room * sizeof *d->segments);
    if (!more) return false;
    d->segments = more;
    d->room = room;
    return true;
}

// The greater of what the patch asks for and what others have asked for, for both.
static bool agree(detail *d, size_t k, int segments[3])
{
    if (!make_room(d, k + 1)) return false;
    if (k == d->count) memcpy(d->segments[d->count++], segments, sizeof d->segments[0]);
    for (int i = 0; i < 3; i++) {
        if (segments[i] > d->segments[k][i]) d->segments[k][i] = segments[i], d->changes++;
        segments[i] = d->segments[k][i];
    }
    return true;
}

// All triangles of the grid over a surface, also those that are points or lines now: they may not be in other frames.
// The room is there, kn_mesh_add_patch wants it for them all.
static void keep_triangles(kn_mesh *mesh, size_t first, size_t triangles, const kn_patch *patch)
{
    size_t a = (size_t)patch->segments[0], b1 = (size_t)patch->segments[1] + 1;
    uint32_t *to = mesh->triangle + 3 * triangles;
    for (size_t i = 0; i < a; i++)
        for (size_t j = 0; j + 1 < b1; j++, to += 6) {
            size_t p = first + i * b1 + j, q = p + b1;
            const size_t corners[2][6] = {{p, q, q + 1, p, q + 1, p + 1}, {p, q + 1, q, p, p + 1, q + 1}};
            for (int k = 0; k < 6; k++) to[k] = (uint32_t)corners[patch->reversed][k];
        }
    mesh->ntriangles = triangles + 2 * a * (b1 - 1);
}

static kn_status draw_surface(kn_ctx *ctx, kn_mesh *mesh, const kn_patch *patch)
{
    size_t first = mesh->nvertices, triangles = mesh->ntriangles;
    kn_status status = kn_patch_tessellate(ctx, mesh, patch);
    if (status == KN_OK && patch->bezier.nvars == 2 && !patch->trim) keep_triangles(mesh, first, triangles, patch);
    return status;
}

static kn_status draw_patch(kn_ctx *ctx, kn_mesh *mesh, const kn_patch *patch)
{
    if (patch->mesh || patch->bezier.nvars != 3) return draw_surface(ctx, mesh, patch);
    kn_status status = KN_OK;
    for (int face = 0; status == KN_OK && face < 6; face++) {
        kn_patch side = {0};
        if (patch->hidden >> face & 1) continue;
        status = kn_patch_face(ctx, &side, patch, face);
        if (status == KN_OK) status = draw_surface(ctx, mesh, &side);
        kn_bezier_clear(ctx, &side.bezier);
    }
    return status;
}

static kn_status commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)product;
    const collector *c = user;
    kn_status status = KN_OK;
    for (size_t i = 0; status == KN_OK && i < block->count; i++) {
        kn_patch patch = block->patches[i];
        if (!agree(c->detail, (*c->at)++, patch.segments)) return KN_ENOMEM;
        status = draw_patch(ctx, &c->scene->items[c->first + patch.look].mesh, &patch);
    }
    return status;
}

static kn_status collect(kn_ctx *ctx, kn_scene *scene, detail *d, size_t *at, const kn_job *job)
{
    const kn_tile *tile = kn_job_look_tile(job);
    collector c = {scene, d, at, scene->nitems};
    kn_sink sink = {.user = &c, .commit = commit};
    for (int p = 0; p < tile->nparts; p++)
        scene->items[scene->nitems++] = (kn_scene_item){.material = tile->parts[p].material};
    return kn_job_run(ctx, job, &sink, 1);
}

// The text with every {t} replaced; NULL and a message when it grows too long.
static char *at_time(const char *text, double t)
{
    char *out = malloc(MAX_TEXT);
    size_t n = 0;
    for (; out && *text; text++) {
        int k = strncmp(text, "{t}", 3) == 0 ? snprintf(out + n, MAX_TEXT - n, "(%.17g)", t)
                                             : snprintf(out + n, MAX_TEXT - n, "%c", *text);
        if (k < 0 || (size_t)k >= MAX_TEXT - n) break;
        n += (size_t)k;
        if (*text == '{' && strncmp(text, "{t}", 3) == 0) text += 2;
    }
    if (out && !*text) return out;
    cli_error("animate: a value is longer than %d characters, or out of memory", MAX_TEXT - 1);
    free(out);
    return NULL;
}

// The recipe with time put in; texts[] are the frame's own.
static bool set_time(cli_recipe *frame, char *texts[CLI_MAX_LAYERS * CLI_MAX_VARY], int *ntexts, double t)
{
    for (int l = 0; l < frame->nlayers; l++)
        for (int k = 0; k < frame->layer[l].nvary; k++) {
            cli_scalar *value = &frame->layer[l].vary[k].value;
            if (!value->text || !strstr(value->text, "{t}")) continue;
            char *text = at_time(value->text, t);
            if (!text) return false;
            value->text = texts[(*ntexts)++] = text;
        }
    return true;
}

static int make_layers(cli_session *session, kn_scene *scene, detail *d, const cli_recipe *r, const cli_inputs *in)
{
    cli_plan plan = {0};
    size_t nparts = 0, at = 0;
    int code = cli_plan_begin(session, &plan, r, in);
    for (int i = 0; i < plan.nshown; i++) nparts += (size_t)kn_job_look_tile(plan.shown[i])->nparts;
    kn_scene_item *items = calloc(nparts + 1, sizeof *items); // and the box
    *scene = (kn_scene){.items = items};
    if (!items && code == EXIT_OK) code = cli_fail_at(session, KN_ENOMEM, "animate: out of memory");
    for (int i = 0; i < plan.nshown && code == EXIT_OK; i++) {
        kn_status status = collect(cli_ctx(session), scene, d, &at, plan.shown[i]);
        if (status != KN_OK) code = cli_fail(session, status, false);
    }
    cli_plan_end(session, &plan);
    return code;
}

static void frame_clear(kn_ctx *ctx, kn_scene *scene)
{
    for (int i = 0; i < scene->nitems; i++) kn_scene_item_clear(ctx, &scene->items[i]);
    free(scene->items);
    *scene = (kn_scene){0};
}

static int make_frame(cli_session *session, kn_scene *scene, detail *d, const animate *a, double t)
{
    cli_recipe *frame = malloc(sizeof *frame);
    char *texts[CLI_MAX_LAYERS * CLI_MAX_VARY];
    int ntexts = 0, code = EXIT_FAILED;
    cli_inputs inputs = {0};
    if (!frame) return cli_fail_at(session, KN_ENOMEM, "animate: out of memory");
    *frame = a->recipe;
    if (set_time(frame, texts, &ntexts, t)) {
        code = cli_inputs_begin(session, &inputs, frame);
        if (code == EXIT_OK) code = make_layers(session, scene, d, frame, &inputs);
        cli_inputs_end(session, &inputs, frame);
    }
    for (int i = 0; i < ntexts; i++) free(texts[i]);
    free(frame);
    return code;
}

// ---- pictures and videos ----

// An item that cannot be seen and has the box of all frames, so that each is framed alike: triangles without area.
static kn_status add_box(kn_ctx *ctx, kn_scene *scene, const double box[2][3])
{
    static const uint32_t points[6] = {0, 0, 0, 1, 1, 1};
    double corners[6];
    memcpy(corners, box, sizeof corners);
    uint32_t triangle[6];
    memcpy(triangle, points, sizeof triangle);
    const kn_mesh two = {.nvertices = 2, .ntriangles = 2, .position = corners, .triangle = triangle};
    kn_scene_item item = {.material = {{1.0, 1.0, 1.0}, 0.0, 1.0}};
    kn_status status = kn_mesh_copy(ctx, &item.mesh, &two);
    if (status == KN_OK) scene->items[scene->nitems++] = item; // one more than parts: make_layers
    return status;
}

static kn_status draw(kn_ctx *ctx, const animate *a, const kn_scene *scene, const char *path)
{
    kn_render_options o = kn_render_defaults();
    o.width = a->width, o.height = a->height, o.samples = a->samples;
    o.azimuth = a->azimuth, o.elevation = a->elevation;
    o.up = KN_UP_Z;
    uint8_t *rgb = malloc((size_t)a->width * (size_t)a->height * 3);
    if (!rgb) return KN_ENOMEM;
    kn_status status = kn_render(ctx, rgb, scene, &o);
    if (status == KN_OK) status = kn_png_write(ctx, path, rgb, a->width, a->height, 3);
    free(rgb);
    return status;
}

// OUT.png and OUT.mp4 -> OUT-0001.png ..
static void frame_path(char path[MAX_TEXT], const char *out, const char *number)
{
    (void)snprintf(path, MAX_TEXT, "%.*s-%s.png", (int)(strlen(out) - 4), out, number);
}

static int add_boxes(cli_session *session, const animate *a, kn_scene *frames)
{
    double box[2][3] = {{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}};
    for (int f = 0; f < a->frames; f++)
        for (int i = 0; i < frames[f].nitems; i++)
            for (size_t v = 0; v < 3 * frames[f].items[i].mesh.nvertices; v++) {
                double x = frames[f].items[i].mesh.position[v];
                if (x < box[0][v % 3]) box[0][v % 3] = x;
                if (x > box[1][v % 3]) box[1][v % 3] = x;
            }
    kn_status status = KN_OK;
    for (int f = 0; f < a->frames && status == KN_OK; f++)
        status = add_box(cli_ctx(session), &frames[f], (const double(*)[3])box);
    return status == KN_OK ? EXIT_OK : cli_fail(session, status, false);
}

static int draw_frames(cli_session *session, const animate *a, const kn_scene *frames, const char *out)
{
    kn_status status = KN_OK;
    for (int f = 0; f < a->frames && status == KN_OK; f++) {
        char path[MAX_TEXT], number[16];
        (void)snprintf(number, sizeof number, "%04d", f + 1);
        frame_path(path, out, number);
        status = draw(cli_ctx(session), a, &frames[f], path);
    }
    return status == KN_OK ? EXIT_OK : cli_fail(session, status, false);
}

// ---- the whole ----

static int write_output(cli_session *session, const animate *a, kn_scene *frames, const char *out, bool *boxed)
{
    if (cli_has_ending(out, "glb") || cli_has_ending(out, "gltf")) {
        const kn_gltf_options o = {.unit_mm = a->recipe.layer[0].unit_mm};
        kn_status status = kn_gltf_write_frames(cli_ctx(session), out, frames, a->frames, a->seconds, &o);
        return status == KN_OK ? EXIT_OK : cli_fail(session, status, false);
    }
    int code = *boxed ? EXIT_OK : add_boxes(session, a, frames);
    *boxed = true;
    if (code == EXIT_OK) code = draw_frames(session, a, frames, out);
    return code == EXIT_OK && cli_has_ending(out, "mp4") ? cli_make_video(session, out, a->frames / a->seconds)
                                                         : code;
}

// Frames that were drawn more coarsely than a later one asked for are made once more.
static int make_frames(cli_session *session, kn_scene *frames, const animate *a)
{
    detail d = {0};
    int code = EXIT_OK;
    unsigned long *changes = calloc((size_t)a->frames, sizeof *changes);
    if (!changes) return cli_fail_at(session, KN_ENOMEM, "animate: out of memory");
    for (int pass = 0; pass < 2; pass++)
        for (int f = 0; f < a->frames && code == EXIT_OK; f++) {
            if (pass == 1 && changes[f] == d.changes) continue;
            frame_clear(cli_ctx(session), &frames[f]);
            code = make_frame(session, &frames[f], &d, a, a->frames > 1 ? (double)f / (a->frames - 1) : 0.0);
            changes[f] = d.changes;
        }
    free(changes);
    free(d.segments);
    return code;
}

static void report(const animate *a)
{
    const cli_job *job = &a->recipe.layer[0];
    if (!job->json) return;
    json_t *outputs = json_array();
    for (int i = 0; i < a->recipe.noutputs; i++) json_array_append_new(outputs, cli_json_text(a->recipe.outputs[i]));
    json_t *o = json_pack("{s:o,s:i,s:f,s:o}", "base", cli_json_text(job->base), "frames", a->frames, "seconds",
                          a->seconds, "outputs", outputs);
    json_dumpf(o, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    putchar('\n');
    json_decref(o);
}

static int work(cli_session *session, const animate *a)
{
    kn_scene *frames = calloc((size_t)a->frames, sizeof *frames);
    if (!frames) return cli_fail_at(session, KN_ENOMEM, "animate: out of memory");
    bool boxed = false;
    int code = make_frames(session, frames, a);
    for (int pass = 0; pass < 2; pass++) // glTF first: pictures add to the scenes
        for (int i = 0; i < a->recipe.noutputs && code == EXIT_OK; i++) {
            const char *out = a->recipe.outputs[i];
            bool picture = cli_has_ending(out, "png") || cli_has_ending(out, "mp4");
            if (picture == (pass == 1)) code = write_output(session, a, frames, out, &boxed);
        }
    for (int f = 0; f < a->frames; f++) frame_clear(cli_ctx(session), &frames[f]);
    free(frames);
    if (code == EXIT_OK) report(a);
    return code;
}
#endif

static bool set_option(animate *a, int option, const char *value)
{
    if (option < CLI_JOB_OPTIONS) return cli_recipe_set(&a->recipe, option, value);
    switch (option) {
    case FRAMES: return cli_int("--frames", value, 1, MAX_FRAMES, &a->frames);
    case SECONDS: return cli_double("--seconds", value, &a->seconds) && cli_above_zero("--seconds", a->seconds);
    case OUTPUT:
        if (strlen(value) > MAX_TEXT - 16 || !(cli_has_ending(value, "glb") || cli_has_ending(value, "gltf") ||
                                               cli_has_ending(value, "png") || cli_has_ending(value, "mp4"))) {
            cli_error("-o: expected .glb, .gltf, .png or .mp4, got '%s'", value);
            return false;
        }
        return cli_take_output("-o", a->recipe.outputs, &a->recipe.noutputs, CLI_MAX_OUTPUTS, value);
    case WIDTH: return cli_int("--picture-width", value, 16, 16384, &a->width);
    case HEIGHT_OF: return cli_int("--picture-height", value, 16, 16384, &a->height);
    case SAMPLES: return cli_int("--samples", value, 1, 16384, &a->samples);
    case AZIMUTH: return cli_double("--azimuth", value, &a->azimuth);
    case ELEVATION: return cli_double("--elevation", value, &a->elevation);
    default: return false;
    }
}

static bool odd_video(const animate *a)
{
    bool video = false;
    for (int i = 0; i < a->recipe.noutputs; i++) video = video || cli_has_ending(a->recipe.outputs[i], "mp4");
    return video && (a->width % 2 != 0 || a->height % 2 != 0);
}

static bool uses_time(const cli_recipe *r)
{
    for (int l = 0; l < r->nlayers; l++)
        for (int k = 0; k < r->layer[l].nvary; k++) {
            const char *text = r->layer[l].vary[k].value.text;
            if (text && strstr(text, "{t}")) return true;
        }
    return false;
}

// EXIT_OK, an exit code after a message, or -1 when help was asked for and given.
static int read_arguments(animate *a, int argc, char **argv)
{
    cli_args args = {.argc = argc,
                     .at = 1,
                     .argv = argv,
                     .options = options,
                     .job = true,
                     .command = "animate",
                     .noptions = sizeof options / sizeof *options};
    const char *value;
    for (int option; (option = cli_next(&args, &value)) != CLI_END;) {
        if (option == CLI_BAD) return EXIT_USAGE;
        if (option == HELP) return cli_help(stdout, "animate") == EXIT_OK ? -1 : EXIT_FAILED;
        if (option == CLI_POSITIONAL) {
            if (a->recipe.layer[0].base) {
                cli_error("animate: one base at a time, got '%s' and '%s'", a->recipe.layer[0].base, value);
                return EXIT_USAGE;
            }
            int code = cli_recipe_base(&a->recipe, value);
            a->recipe.noutputs = 0; // the recipe's are of a still texture
            if (code != EXIT_OK) return code;
        } else if (!set_option(a, option, value))
            return EXIT_USAGE;
    }
    const cli_recipe *r = &a->recipe;
    const char *missing = !r->layer[0].base   ? "a BASE file or a recipe is missing"
                          : !r->layer[0].tile ? "--tile is missing ('knurl tiles' lists them)"
                          : r->noutputs == 0  ? "-o OUT is missing"
                          : odd_video(a) ? "videos are of even width and height: --picture-width, --picture-height"
                                         : cli_recipe_conflict(r);
    if (!missing) return EXIT_OK;
    cli_error("animate: %s", missing);
    cli_usage_hint("animate");
    return EXIT_USAGE;
}

int cli_command_animate(int argc, char **argv)
{
    animate *a = calloc(1, sizeof *a);
    if (!a) return EXIT_FAILED;
    a->frames = 25, a->width = 800, a->height = 600, a->seconds = 2.0;
    cli_recipe_begin(&a->recipe);
    int code = read_arguments(a, argc, argv);
    if (code == EXIT_OK) {
#if CAN_ANIMATE
        const cli_job *job = &a->recipe.layer[0];
        cli_session *session = cli_session_begin((cli_session_options){.threads = job->threads, .quiet = job->quiet});
        if (session && !uses_time(&a->recipe))
            cli_warn(session, "animate: no --vary with {t}: all frames are the same");
        code = session ? work(session, a) : EXIT_FAILED;
        cli_session_end(session);
#else
        cli_error("animate: built without embree, libpng or tinygltf");
        code = EXIT_FAILED;
#endif
    }
    cli_recipe_end(&a->recipe);
    free(a);
    return code < 0 ? EXIT_OK : code;
}
