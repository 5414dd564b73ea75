// SPDX-License-Identifier: Apache-2.0
// knurl render: a picture of a scene file, or of plain surfaces.
#include "cli/cli.h"

#include <stdlib.h>
#include <string.h>

#if KN_WITH_EMBREE && KN_WITH_PNG && KN_WITH_TINYGLTF
#define CAN_RENDER 1
#include "bridges/embree/render.h"
#include "bridges/png/png.h"
#include "bridges/tinygltf/gltf.h"
#else
#define CAN_RENDER 0
#endif

enum { OUTPUT, WIDTH, HEIGHT, SAMPLES, AZIMUTH, ELEVATION, THREADS, QUIET, HELP };
static const cli_option options[] = {
    [OUTPUT] = {"output", 'o', CLI_TEXT},   [WIDTH] = {"width", 0, CLI_TEXT},
    [HEIGHT] = {"height", 0, CLI_TEXT},     [SAMPLES] = {"samples", 0, CLI_TEXT},
    [AZIMUTH] = {"azimuth", 0, CLI_TEXT},   [ELEVATION] = {"elevation", 0, CLI_TEXT},
    [THREADS] = {"threads", 'j', CLI_TEXT}, [QUIET] = {"quiet", 'q', CLI_NOTHING},
    [HELP] = {"help", 'h', CLI_NOTHING},
};

typedef struct request {
    const char *in, *out;
    int width, height, samples, threads;
    double azimuth, elevation;
    bool quiet;
} request;

#if CAN_RENDER
// The breaks of variable d, over [0,1]: one more than there are spans. For free().
static double *breaks_of(const kn_spline *s, int d)
{
    double lo, hi, *out = malloc(((size_t)kn_spline_spans(s, d) + 1) * sizeof *out);
    int n = 0;
    kn_spline_domain(s, d, &lo, &hi);
    for (int k = s->degree[d]; out && k <= s->count[d]; k++)
        if (k == s->count[d] || s->knots[d][k] < s->knots[d][k + 1]) out[n++] = (s->knots[d][k] - lo) / (hi - lo);
    return out;
}

// Piece by piece, what the trim leaves of each; NULL: all.
static kn_status add_surface(kn_ctx *ctx, kn_mesh *mesh, const kn_spline *s, const kn_trim *trim)
{
    kn_bezier *pieces = NULL;
    size_t n = 0, across = (size_t)kn_spline_spans(s, 1);
    double *u = breaks_of(s, 0), *v = breaks_of(s, 1);
    kn_status status = u && v ? kn_spline_to_bezier(ctx, &pieces, &n, s) : KN_ENOMEM;
    for (size_t k = 0; k < n; k++) {
        kn_trim part = {0};
        bool any = true;
        size_t i = k / across, j = k % across;
        if (status == KN_OK && trim)
            status = kn_trim_restrict(ctx, &part, &any, trim, (double[2]){u[i], v[j]},
                                      (double[2]){u[i + 1], v[j + 1]});
        if (status == KN_OK && any)
            status = kn_mesh_add_trimmed(ctx, mesh, &pieces[k], &part, (int[2]){24, 24}, false);
        kn_trim_clear(ctx, &part);
        kn_bezier_clear(ctx, &pieces[k]);
    }
    kn_free(ctx, pieces);
    free(u), free(v);
    return status;
}

// Surfaces without a texture, as glazed ceramic.
static int tessellate(cli_session *session, kn_scene_item *out, const char *path)
{
    kn_ctx *ctx = cli_ctx(session);
    cli_base base = {0};
    int code = cli_read_base(session, &base, path, false);
    if (code != EXIT_OK) return code;
    kn_status status = KN_OK;
    for (int i = 0; i < base.nsurfaces && status == KN_OK; i++)
        status = add_surface(ctx, &out->mesh, &base.surfaces[i], base.trims ? &base.trims[i] : NULL);
    out->material = (kn_material){{0.80, 0.78, 0.74}, 0.0, 0.35};
    cli_base_clear(session, &base);
    return status == KN_OK ? EXIT_OK : cli_fail(session, status, false);
}

static kn_status picture(kn_ctx *ctx, const request *r, const kn_scene *scene, bool scene_file)
{
    kn_render_options o = kn_render_defaults();
    o.width = r->width;
    o.height = r->height;
    o.samples = r->samples;
    o.azimuth = r->azimuth;
    o.elevation = r->elevation;
    o.up = scene_file ? KN_UP_Y : KN_UP_Z;
    uint8_t *rgb = malloc((size_t)r->width * (size_t)r->height * 3);
    if (!rgb) return KN_ENOMEM;
    kn_status status = kn_render(ctx, rgb, scene, &o);
    if (status == KN_OK) status = kn_png_write(ctx, r->out, rgb, r->width, r->height, 3);
    free(rgb);
    return status;
}

static int render_scene(cli_session *session, const request *r)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_scene scene = {0};
    kn_status status = kn_gltf_read(ctx, &scene, r->in);
    if (status != KN_OK) return cli_fail(session, status, true);
    status = picture(ctx, r, &scene, true);
    kn_scene_clear(ctx, &scene);
    return status == KN_OK ? EXIT_OK : cli_fail(session, status, false);
}

static int render_surfaces(cli_session *session, const request *r)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_scene_item item = {0};
    int code = tessellate(session, &item, r->in);
    if (code == EXIT_OK) {
        kn_status status = picture(ctx, r, &(kn_scene){&item, 1}, false);
        if (status != KN_OK) code = cli_fail(session, status, false);
    }
    kn_mesh_clear(ctx, &item.mesh);
    return code;
}

static int render(const request *r)
{
    cli_session *session = cli_session_begin((cli_session_options){.threads = r->threads, .quiet = r->quiet});
    if (!session) return EXIT_FAILED;
    bool scene = cli_has_ending(r->in, "glb") || cli_has_ending(r->in, "gltf");
    int code = scene ? render_scene(session, r) : render_surfaces(session, r);
    cli_session_end(session);
    return code;
}
#else
static int render(const request *r)
{
    cli_error("render: cannot draw '%s': built without embree, libpng or tinygltf", r->in);
    return EXIT_FAILED;
}
#endif

static bool set_option(request *r, int option, const char *value)
{
    switch (option) {
    case OUTPUT:
        if (!cli_has_ending(value, "png")) {
            cli_error("-o: a picture is a .png, got '%s'", value);
            return false;
        }
        r->out = value;
        return true;
    case WIDTH: return cli_int("--width", value, 16, 16384, &r->width);
    case HEIGHT: return cli_int("--height", value, 16, 16384, &r->height);
    case SAMPLES: return cli_int("--samples", value, 1, 16384, &r->samples);
    case AZIMUTH: return cli_double("--azimuth", value, &r->azimuth);
    case ELEVATION: return cli_double("--elevation", value, &r->elevation);
    case THREADS: return cli_int("--threads", value, 1, 1024, &r->threads);
    case QUIET: return r->quiet = true;
    default: return false;
    }
}

int cli_command_render(int argc, char **argv)
{
    cli_args args = {.argc = argc,
                     .at = 1,
                     .argv = argv,
                     .options = options,
                     .command = "render",
                     .noptions = sizeof options / sizeof *options};
    request r = {.width = 1600, .height = 1200};
    const char *value;
    for (int option; (option = cli_next(&args, &value)) != CLI_END;) {
        if (option == HELP) return cli_help(stdout, "render");
        if (option == CLI_BAD || (option >= 0 && !set_option(&r, option, value))) return EXIT_USAGE;
        if (option == CLI_POSITIONAL && r.in) {
            cli_error("render: one file at a time, got '%s' and '%s'", r.in, value);
            return EXIT_USAGE;
        }
        if (option == CLI_POSITIONAL) r.in = value;
    }
    if (r.in && r.out) return render(&r);
    cli_error("render: %s is missing", r.in ? "-o OUT.png" : "an input file");
    cli_usage_hint("render");
    return EXIT_USAGE;
}
