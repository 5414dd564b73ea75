// SPDX-License-Identifier: Apache-2.0
// Heat maps: the base coloured by how much room there is at each place, as a picture with a legend or as a scene.
#include "cli/check.h"
#include "kernel/context.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#if KN_WITH_TINYGLTF
#include "bridges/tinygltf/gltf.h"
#endif
#if KN_WITH_EMBREE && KN_WITH_PNG && KN_WITH_CAIRO
#define CAN_DRAW 1
#include "bridges/cairo/legend.h"
#include "bridges/embree/render.h"
#include "bridges/png/png.h"
#else
#define CAN_DRAW 0
#endif

bool check_can_draw(const char *path)
{
    bool scene = cli_has_ending(path, "glb") || cli_has_ending(path, "gltf"), picture = cli_has_ending(path, "png");
    if (!scene && !picture) {
        cli_error("-o: no writer for '%s'; endings: .png .glb .gltf", path);
        return false;
    }
    if (picture && !CAN_DRAW) cli_error("-o: cannot draw '%s': built without embree, libpng or cairo", path);
#if KN_WITH_TINYGLTF
    return scene || CAN_DRAW;
#else
    if (scene) cli_error("-o: cannot write '%s': built without tinygltf", path);
    return picture && CAN_DRAW;
#endif
}

#if KN_WITH_TINYGLTF || CAN_DRAW

enum { VERTICES = 300000, MOST_SEGMENTS = 48, LEAST_SEGMENTS = 4, SAMPLES = 64, BISECTIONS = 30 };
// Safe heights are shown from a quarter to four times what was asked for, by their logarithm.
static const double most_room = 4;

// ---- what is shown at a place ----

// det dT/d(u,v,w) as polynomials in w; a weight's power is a factor that changes no sign.
typedef struct jacobian {
    kn_spline *coefficient;
    int n, weight_power;
} jacobian;

typedef struct polynomial {
    double c[KN_MAX_DEGREE + 1];
    int n;
} polynomial;

static double value_at(const polynomial *p, double w)
{
    double sum = 0;
    for (int k = p->n - 1; k >= 0; k--) sum = sum * w + p->c[k];
    return sum;
}

// Where sign * p is least on [lo, hi], by thirds.
static double lowest(const polynomial *p, double sign, double most, double lo, double hi)
{
    for (int k = 0; k < BISECTIONS; k++) {
        double x = lo + (hi - lo) / 3, y = hi - (hi - lo) / 3;
        if (sign * value_at(p, x * most) < sign * value_at(p, y * most))
            hi = y;
        else
            lo = x;
    }
    return 0.5 * (lo + hi);
}

// The least height up to `most`, a signed one, at which the polynomial vanishes, as a share of it; 1: none. A sphere's
// touches 0 and turns back: less than 1e-6 of its value on the base counts as 0.
static double first_zero(const polynomial *p, double most)
{
    const double touching = 1e-6 * fabs(p->c[0]), sign = p->c[0] < 0 ? -1 : 1;
    double before = 0, value[3] = {fabs(p->c[0]), fabs(p->c[0]), 0};
    for (int i = 1; i <= SAMPLES; i++) {
        double lo = before, hi = (double)i / SAMPLES;
        value[2] = sign * value_at(p, hi * most);
        if (value[1] <= value[0] && value[1] <= value[2]) {
            double least = lowest(p, sign, most, fmax(hi - 2.0 / SAMPLES, 0.0), hi);
            if (sign * value_at(p, least * most) <= touching) return least;
        }
        value[0] = value[1], value[1] = value[2];
        if (value[2] > 0) {
            before = hi;
            continue;
        }
        for (int k = 0; k < BISECTIONS; k++) {
            double middle = 0.5 * (lo + hi);
            if (sign * value_at(p, middle * most) > 0)
                lo = middle;
            else
                hi = middle;
        }
        return lo;
    }
    return 1;
}

// How many times the height fits, by logarithm: -1 a quarter or less, 0 just so, 1 four times or more.
static double room_at(const polynomial *p, const double range[2])
{
    double room = most_room;
    for (int end = 0; end < 2; end++)
        if (end ? range[1] > 0 : range[0] < 0) room = fmin(room, most_room * first_zero(p, most_room * range[end]));
    return room > 0 ? fmax(log(room) / log(most_room), -1.0) : -1.0;
}

// The least Jacobian between the heights, over that of the base.
static double least_jacobian(const polynomial *p, const double range[2])
{
    double least = INFINITY;
    for (int i = 0; i <= SAMPLES; i++)
        least = fmin(least, value_at(p, range[0] + (range[1] - range[0]) * i / SAMPLES));
    double ratio = p->c[0] != 0 ? least / p->c[0] : 0;
    return fmin(fmax(ratio, -1.0), 1.0);
}

static kn_status shade(kn_ctx *ctx, double *t, const check *c, const check_shell *s, const jacobian *j,
                       const double uv[2])
{
    polynomial p = {.n = j->n};
    kn_status status = KN_OK;
    for (int k = 0; k < j->n && status == KN_OK; k++) status = kn_spline_eval(ctx, &p.c[k], &j->coefficient[k], uv);
    if (status == KN_OK) *t = c->by_jacobian ? least_jacobian(&p, s->range) : room_at(&p, s->range);
    return status;
}

// ---- the base with colours ----

static int breaks(const kn_spline *s, int d, double *out)
{
    int n = 0, m = s->count[d] + s->degree[d] + 1;
    for (int i = 0; i < m; i++)
        if (n == 0 || s->knots[d][i] > out[n - 1]) out[n++] = s->knots[d][i];
    return n;
}

// The colours of a patch over the box: vertices with u slowest. At the domain's edges, where a pole may be, a place just
// inside counts.
static kn_status color_patch(kn_ctx *ctx, float *out, const check *c, const check_shell *s, const jacobian *j,
                             const double lo[2], const double hi[2], int segments)
{
    const double inset = 1e-4;
    kn_status status = KN_OK;
    for (int a = 0; a <= segments; a++)
        for (int b = 0; b <= segments && status == KN_OK; b++, out += 3) {
            double x[2] = {(double)a / segments, (double)b / segments}, uv[2], t = 0;
            for (int d = 0; d < 2; d++) uv[d] = lo[d] + fmin(fmax(x[d], inset), 1 - inset) * (hi[d] - lo[d]);
            status = shade(ctx, &t, c, s, j, uv);
            heat_linear_color(t, out);
        }
    return status;
}

static kn_status grow_colors(kn_ctx *ctx, kn_scene_item *item)
{
    size_t n = item->mesh.nvertices;
    float *grown = item->color ? kn_resize(ctx, item->color, n, 3 * sizeof *grown)
                               : kn_alloc(ctx, n, 3 * sizeof *grown);
    if (!grown) return KN_ENOMEM;
    item->color = grown;
    return KN_OK;
}

static kn_status add_patches(kn_ctx *ctx, kn_scene_item *item, const check *c, const check_shell *s,
                             const jacobian *j, int segments)
{
    const kn_spline *surface = kn_shell_surface(s->shell);
    kn_bezier *pieces = NULL;
    size_t n = 0;
    double *at[2] = {NULL, NULL};
    int count[2] = {0, 0};
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, surface);
    for (int d = 0; d < 2; d++) {
        at[d] = malloc((size_t)(surface->count[d] + surface->degree[d] + 1) * sizeof(double));
        if (at[d])
            count[d] = breaks(surface, d, at[d]) - 1;
        else
            status = KN_ENOMEM;
    }
    for (size_t k = 0; k < n; k++) {
        size_t first = item->mesh.nvertices, u = count[1] ? k / (size_t)count[1] : 0, v = k - u * (size_t)count[1];
        if (status == KN_OK)
            status = kn_mesh_add_patch(ctx, &item->mesh, &pieces[k], (int[2]){segments, segments}, false);
        if (status == KN_OK) status = grow_colors(ctx, item);
        if (status == KN_OK)
            status = color_patch(ctx, item->color + 3 * first, c, s, j, (double[2]){at[0][u], at[1][v]},
                                 (double[2]){at[0][u + 1], at[1][v + 1]}, segments);
        if (status == KN_OK) status = kn_progress(ctx, "heat map", (double)k / (double)n);
        kn_bezier_clear(ctx, &pieces[k]);
    }
    kn_free(ctx, pieces);
    for (int d = 0; d < 2; d++) free(at[d]);
    return status;
}

static int segments_for(const check *c)
{
    double pieces = 0;
    for (int i = 0; i < c->nshells; i++) {
        const kn_spline *s = kn_shell_surface(c->shells[i].shell);
        pieces += (double)kn_spline_spans(s, 0) * (double)kn_spline_spans(s, 1);
    }
    int n = (int)sqrt(VERTICES / pieces);
    return n > MOST_SEGMENTS ? MOST_SEGMENTS : n < LEAST_SEGMENTS ? LEAST_SEGMENTS : n;
}

static kn_status make_item(kn_ctx *ctx, kn_scene_item *item, const check *c)
{
    kn_status status = KN_OK;
    item->material = (kn_material){{1, 1, 1}, 0.0, 0.75};
    for (int i = 0; i < c->nshells && status == KN_OK; i++) {
        jacobian j = {0};
        status = kn_shell_jacobian(ctx, &j.coefficient, &j.n, &j.weight_power, c->shells[i].shell);
        if (status == KN_OK) status = add_patches(ctx, item, c, &c->shells[i], &j, segments_for(c));
        for (int k = 0; k < j.n; k++) kn_spline_clear(ctx, &j.coefficient[k]);
        kn_free(ctx, j.coefficient);
    }
    return status;
}

// ---- the scale ----

typedef struct tick {
    double t, value;
    char label[48];
} tick;
enum { TICKS = 5 };

static double asked(const check *c)
{
    return fmax(fabs(c->range[0]), fabs(c->range[1]));
}

static void make_ticks(const check *c, tick out[TICKS])
{
    for (int i = 0; i < TICKS; i++) {
        tick *k = &out[i];
        k->t = -1 + 0.5 * i;
        k->value = c->by_jacobian ? k->t : asked(c) * pow(most_room, k->t);
        const char *sign = i == 0 ? "\u2264 " : i == TICKS - 1 && !c->by_jacobian ? "\u2265 " : "";
        snprintf(k->label, sizeof k->label, "%s%.3g", sign, k->value);
    }
}

static const char *quantity(const check *c)
{
    if (c->by_jacobian) return "Least Jacobian, share of the base's";
    if (isfinite(c->shells[0].heights[1])) return "Safe height above the lower face";
    if (c->range[0] < 0 && c->range[1] > 0) return "Safe height, both sides";
    return c->range[0] < 0 ? "Safe height below the base" : "Safe height above the base";
}

#if KN_WITH_TINYGLTF
// The legend of a scene, which has no place for a picture of one: values with their colours.
static char *extras(const check *c)
{
    enum { STOPS = 17 };
    json_t *stops = json_array();
    for (int i = 0; i < STOPS; i++) {
        double t = -1 + 2.0 * i / (STOPS - 1), srgb[3];
        heat_color(t, srgb);
        json_array_append_new(stops,
                              json_pack("{s:f,s:[fff]}", "value", c->by_jacobian ? t : asked(c) * pow(most_room, t),
                                        "srgb", srgb[0], srgb[1], srgb[2]));
    }
    json_t *o = json_pack("{s:{s:s,s:s,s:f,s:o}}", "legend", "quantity", quantity(c), "unit",
                          c->by_jacobian ? "of the base's" : cli_unit_name(c->job.unit_mm), "asked", asked(c),
                          "scale", stops);
    char *text = json_dumps(o, JSON_COMPACT);
    json_decref(o);
    return text;
}

static kn_status write_scene(kn_ctx *ctx, const check *c, const kn_scene *scene, const char *path)
{
    char *text = extras(c);
    kn_status status = kn_gltf_write(
        ctx, path, scene, &(kn_gltf_options){.name = "knurl check", .unit_mm = c->job.unit_mm, .extras = text});
    free(text);
    return status;
}
#endif

#if CAN_DRAW
static kn_status draw_legend(kn_ctx *ctx, const check *c, uint8_t *rgb, int width, int height)
{
    enum { COLORS = 512 };
    uint8_t colors[3 * COLORS];
    char title[96], subtitle[160], mark_text[64];
    const char *unit = cli_unit_name(c->job.unit_mm), *slash = strrchr(c->job.base, '/');
    tick ticks[TICKS];
    kn_legend_tick labels[TICKS];
    make_ticks(c, ticks);
    for (int i = 0; i < TICKS; i++) labels[i] = (kn_legend_tick){0.5 + 0.5 * ticks[i].t, ticks[i].label};
    for (int i = 0; i < COLORS; i++) {
        double srgb[3];
        heat_color((2 * i + 1.0) / COLORS - 1, srgb);
        for (int k = 0; k < 3; k++) colors[3 * i + k] = (uint8_t)(255 * srgb[k] + 0.5);
    }
    snprintf(title, sizeof title, "%s%s%s%s", quantity(c), c->by_jacobian ? "" : " (", c->by_jacobian ? "" : unit,
             c->by_jacobian ? "" : ")");
    const char *part = isfinite(c->shells[0].heights[1]) ? ", the lower face of the volume" : "";
    snprintf(subtitle, sizeof subtitle, "%.80s%s%s%.40s", slash ? slash + 1 : c->job.base, part,
             c->job.tile ? ", " : "", c->job.tile ? c->job.tile : "");
    snprintf(mark_text, sizeof mark_text, c->by_jacobian ? "folds" : "asked for: %.3g %s", asked(c), unit);
    kn_legend_tick mark = {0.5, mark_text};
    return kn_legend_draw(ctx, rgb, width, height,
                          &(kn_legend){.title = title,
                                       .subtitle = subtitle,
                                       .colors = colors,
                                       .ncolors = COLORS,
                                       .ticks = labels,
                                       .nticks = TICKS,
                                       .mark = &mark});
}

// Speckles of the light, which would be read as values, averaged away: over neighbours of nearly the same colour.
// Source: Lee, Digital image smoothing and the sigma filter, 1983.
static void smooth(uint8_t *out, const uint8_t *rgb, int width, int height)
{
    enum { REACH = 2, ALIKE = 16 };
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++, out += 3) {
            const uint8_t *p = rgb + 3 * ((size_t)y * (size_t)width + (size_t)x);
            int n = 0, sum[3] = {0, 0, 0};
            for (int j = y < REACH ? 0 : y - REACH; j <= y + REACH && j < height; j++)
                for (int i = x < REACH ? 0 : x - REACH; i <= x + REACH && i < width; i++) {
                    const uint8_t *q = rgb + 3 * ((size_t)j * (size_t)width + (size_t)i);
                    if (abs(p[0] - q[0]) > ALIKE || abs(p[1] - q[1]) > ALIKE || abs(p[2] - q[2]) > ALIKE) continue;
                    for (int k = 0; k < 3; k++) sum[k] += q[k];
                    n++;
                }
            for (int k = 0; k < 3; k++) out[k] = (uint8_t)((sum[k] + n / 2) / n);
        }
}

static kn_status write_picture(kn_ctx *ctx, const check *c, const kn_scene *scene, const char *path)
{
    const int width = c->pixels[0], height = c->pixels[1], band = width * 156 / 1600;
    const int top = height > 2 * band ? height - band : height / 2;
    uint8_t *rgb = malloc((size_t)width * (size_t)height * 3), *rough = malloc((size_t)width * (size_t)top * 3);
    if (!rgb || !rough) {
        free(rough);
        free(rgb);
        return KN_ENOMEM;
    }
    kn_render_options o = kn_render_defaults();
    o.width = width;
    o.height = top;
    o.samples = 16; // a matt body under broad lights needs few
    o.bounces = 1;
    o.flatness = 0.6; // colours as in the legend, with just enough light to show the shape
    kn_status status = kn_render(ctx, rough, scene, &o);
    if (status == KN_OK) smooth(rgb, rough, width, top);
    free(rough);
    if (status == KN_OK) status = draw_legend(ctx, c, rgb + (size_t)width * (size_t)top * 3, width, height - top);
    if (status == KN_OK) status = kn_png_write(ctx, path, rgb, width, height, 3);
    free(rgb);
    return status;
}
#endif

int check_draw(cli_session *session, const check *c, const char *path)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_scene_item item = {0};
    kn_scene scene = {&item, 1};
    kn_status status = make_item(ctx, &item, c);
#if CAN_DRAW
    if (status == KN_OK && cli_has_ending(path, "png")) status = write_picture(ctx, c, &scene, path);
#endif
#if KN_WITH_TINYGLTF
    if (status == KN_OK && !cli_has_ending(path, "png")) status = write_scene(ctx, c, &scene, path);
#endif
    kn_scene_item_clear(ctx, &item);
    return status == KN_OK ? EXIT_OK : cli_fail(session, status, false);
}

#else
int check_draw(cli_session *session, const check *c, const char *path)
{
    (void)session;
    (void)c;
    return check_can_draw(path) ? EXIT_OK : EXIT_FAILED;
}
#endif
