// SPDX-License-Identifier: Apache-2.0
// What `knurl info` says of surfaces as bases: creases, poles, apexes, and places without a normal.
#include "cli/cli.h"

#include <jansson.h>
#include <math.h>

static const double kink_angle = 1e-3;  // radians: creases below that are not seen, and still parts of a job
static const double rough_normal = 0.1; // its tolerance: only whether there is one matters here

static const char *const variables[] = {"u", "v"};
static const char *const edge_names[2][2] = {{"u0", "u1"}, {"v0", "v1"}};

// ---- creases ----

static void cross(double out[3], const double a[3], const double b[3])
{
    for (int c = 0; c < 3; c++) out[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

static kn_status normal_at(kn_ctx *ctx, double out[3], const kn_spline *s, const double uv[2])
{
    double v[9]; // S, S_u, S_v
    kn_status status = kn_spline_derivatives(ctx, v, s, uv, 1);
    if (status == KN_OK) cross(out, v + 3, v + 6);
    return status;
}

// The largest angle between the normals of two pieces that was seen along their common edge, where one is at its end
// in variable d and the other at its beginning.
static kn_status angle_between(kn_ctx *ctx, double *most, const kn_spline *before, const kn_spline *after, int d)
{
    enum { SAMPLES = 33 };
    double lo, hi, from, to, end;
    kn_spline_domain(before, 1 - d, &lo, &hi);
    kn_spline_domain(after, d, &from, &to);
    kn_spline_domain(before, d, &to, &end);
    for (int i = 0; i < SAMPLES; i++) {
        double uv[2], a[3], b[3], n[3];
        uv[1 - d] = lo + (hi - lo) * i / (SAMPLES - 1);
        uv[d] = end;
        kn_status status = normal_at(ctx, a, before, uv);
        uv[d] = from;
        if (status == KN_OK) status = normal_at(ctx, b, after, uv);
        if (status != KN_OK) return status;
        cross(n, a, b);
        double size[2] = {hypot(hypot(a[0], a[1]), a[2]), hypot(hypot(b[0], b[1]), b[2])};
        double angle = atan2(hypot(hypot(n[0], n[1]), n[2]), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
        if (size[0] > 0 && size[1] > 0) *most = fmax(*most, angle);
    }
    return KN_OK;
}

static kn_status add_creases(kn_ctx *ctx, json_t *creases, const kn_spline *pieces, const int counts[2], int surface)
{
    for (int d = 0; d < 2; d++)
        for (int line = 1; line < counts[d]; line++) {
            double angle = 0, knot = 0, end;
            for (int other = 0; other < counts[1 - d]; other++) {
                int after = d == 0 ? line * counts[1] + other : other * counts[1] + line;
                int before = d == 0 ? after - counts[1] : after - 1;
                kn_status status = angle_between(ctx, &angle, &pieces[before], &pieces[after], d);
                if (status != KN_OK) return status;
                kn_spline_domain(&pieces[after], d, &knot, &end);
            }
            json_array_append_new(creases, json_pack("{s:i,s:s,s:f,s:f}", "surface", surface, "variable",
                                                     variables[d], "knot", knot, "angle_rad", angle));
        }
    return KN_OK;
}

// ---- edges ----

// Those edges of a piece that are edges of the surface, as part of which the first piece of a row speaks for all.
static void add_edges(json_t *notes, const kn_shell *shell, const int at[2], const int counts[2], int surface)
{
    kn_shell_edge edges[2][2];
    kn_shell_edges(shell, edges);
    for (int d = 0; d < 2; d++)
        for (int end = 0; end < 2; end++) {
            const kn_shell_edge *e = &edges[d][end];
            if (e->kind == KN_EDGE_CURVE || at[d] != (end ? counts[d] - 1 : 0) || at[1 - d] != 0) continue;
            json_array_append_new(json_object_get(notes, e->kind == KN_EDGE_POLE ? "poles" : "apexes"),
                                  json_pack("{s:i,s:s,s:[fff]}", "surface", surface, "edge", edge_names[d][end],
                                            "point", e->point[0], e->point[1], e->point[2]));
        }
}

static kn_status look_at_piece(kn_ctx *ctx, json_t *notes, const kn_spline *piece, const int at[2],
                               const int counts[2], int surface)
{
    kn_shell *shell = NULL;
    kn_status status = kn_shell_create(ctx, &shell, piece, &(kn_shell_options){.normal_tol = rough_normal});
    if (status == KN_OK) add_edges(notes, shell, at, counts, surface);
    kn_shell_destroy(ctx, shell);
    if (status == KN_OK || status == KN_ENOMEM || status == KN_ECANCELLED) return status;
    json_array_append_new(json_object_get(notes, "without_normal"),
                          json_pack("{s:i,s:o}", "surface", surface, "message", cli_json_text(kn_ctx_message(ctx))));
    kn_ctx_clear_error(ctx);
    return KN_OK;
}

static kn_status look_at_surface(kn_ctx *ctx, json_t *notes, const kn_spline *s, int surface)
{
    kn_spline *pieces = NULL;
    int counts[2] = {0, 0};
    kn_status status = kn_shell_split_creases(ctx, &pieces, counts, s, cli_crease_angle(0));
    if (status == KN_ENOMEM || status == KN_ECANCELLED) return status;
    if (status != KN_OK) kn_ctx_clear_error(ctx); // it is no base, and has no creases that matter
    status = add_creases(ctx, json_object_get(notes, "creases"), pieces, counts, surface);
    for (int i = 0; i < counts[0] && status == KN_OK; i++)
        for (int j = 0; j < counts[1] && status == KN_OK; j++)
            status = look_at_piece(ctx, notes, &pieces[i * counts[1] + j], (int[2]){i, j}, counts, surface);
    for (int k = 0; k < counts[0] * counts[1]; k++) kn_spline_clear(ctx, &pieces[k]);
    kn_free(ctx, pieces);
    return status;
}

kn_status cli_look_at_edges(kn_ctx *ctx, json_t *notes, const kn_model *model)
{
    static const char *const keys[] = {"creases", "poles", "apexes", "without_normal"};
    for (int k = 0; k < 4; k++) json_object_set_new(notes, keys[k], json_array());
    kn_status status = KN_OK;
    for (int i = 0, surface = 0; i < model->nsplines && status == KN_OK; i++) {
        const kn_spline *s = &model->splines[i];
        bool is_base = (s->nvars == 2 || s->nvars == 3) && kn_spline_dim(s) == 3;
        if (is_base && s->nvars == 2) status = look_at_surface(ctx, notes, s, surface);
        surface += is_base;
    }
    return status;
}

// ---- text ----

static const char *text_of(const json_t *note, const char *key)
{
    const char *text = json_string_value(json_object_get(note, key));
    return text ? text : "";
}

static void print_point(const json_t *note)
{
    const json_t *p = json_object_get(note, "point");
    double x[3];
    for (size_t c = 0; c < 3; c++) x[c] = json_number_value(json_array_get(p, c));
    printf("surface %d: %s, at (%g, %g, %g)\n", (int)json_integer_value(json_object_get(note, "surface")),
           text_of(note, "edge"), x[0], x[1], x[2]);
}

void cli_print_edges(const json_t *notes)
{
    enum { MOST = 6 };
    static const char *const keys[] = {"creases", "poles", "apexes", "without_normal"};
    static const char *const names[] = {"crease", "pole", "apex", "trouble"};
    for (int k = 0; k < 4; k++) {
        const json_t *list = json_object_get(notes, keys[k]);
        size_t n = json_array_size(list);
        for (size_t i = 0; i < n && i < MOST; i++) {
            const json_t *note = json_array_get(list, i);
            int surface = (int)json_integer_value(json_object_get(note, "surface"));
            bool kink = k == 0 && json_number_value(json_object_get(note, "angle_rad")) < kink_angle;
            printf("%-7s ", kink ? "kink" : names[k]);
            if (k == 0)
                printf("surface %d: %s = %g, up to %.3g degrees\n", surface, text_of(note, "variable"),
                       json_number_value(json_object_get(note, "knot")),
                       json_number_value(json_object_get(note, "angle_rad")) * (180 / 3.14159265358979324));
            else if (k == 3)
                printf("surface %d: %s\n", surface, text_of(note, "message"));
            else
                print_point(note);
        }
        if (n > MOST) printf("%-7s and %zu more\n", "", n - MOST);
    }
}
