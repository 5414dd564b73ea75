// SPDX-License-Identifier: Apache-2.0
// Scenes for POV-Ray: bicubic polynomial pieces as bicubic patches, all else as triangles with normals, curves as
// thin tubes; a material for each part, and at the end a camera, lights and a floor for the box of it all.
#include "write/text_sink.h"

#include "kernel/context.h"

#include <math.h>

enum { DIGITS = 9, COLOUR_DIGITS = 4, MOST_STEPS = 5 };

static void put_vector(kn_text *text, const double x[3])
{
    kn_text_char(text, '<');
    for (int c = 0; c < 3; c++) {
        if (c > 0) kn_text_char(text, ',');
        kn_text_plain_real(text, x[c], DIGITS);
    }
    kn_text_char(text, '>');
}

static void put_list_break(kn_text *text)
{
    kn_text_char(text, ',');
    if (text->bytes - text->line > 100) kn_text_newline(text);
}

static void put_texture(kn_text *text, const kn_write_text *w, const kn_write_item *item)
{
    kn_text_put(text, " texture { Part_");
    kn_text_integer(text, (uint64_t)(item->look - w->looks));
    kn_text_put(text, " } }\n");
}

// ---- triangles ----

static void put_vectors(kn_text *text, const char *what, const double *x, size_t n)
{
    kn_text_put(text, what);
    kn_text_put(text, " { ");
    kn_text_integer(text, n);
    for (size_t i = 0; i < n; i++) {
        put_list_break(text);
        put_vector(text, x + 3 * i);
    }
    kn_text_put(text, " }\n");
}

static void put_mesh(kn_text *text, const kn_write_text *w, const kn_write_item *item, const kn_mesh *mesh)
{
    if (mesh->ntriangles == 0) return;
    kn_text_put(text, "mesh2 { ");
    put_vectors(text, "vertex_vectors", mesh->position, mesh->nvertices);
    if (mesh->normal) put_vectors(text, "normal_vectors", mesh->normal, mesh->nvertices);
    kn_text_put(text, "face_indices { ");
    kn_text_integer(text, mesh->ntriangles);
    for (size_t t = 0; t < mesh->ntriangles; t++) {
        put_list_break(text);
        kn_text_char(text, '<');
        for (size_t k = 0; k < 3; k++) {
            if (k > 0) kn_text_char(text, ',');
            kn_text_integer(text, mesh->triangle[3 * t + k]);
        }
        kn_text_char(text, '>');
    }
    kn_text_put(text, " }");
    put_texture(text, w, item);
}

static kn_status put_triangles(kn_ctx *worker, kn_text *text, const kn_write_text *w, const kn_write_item *item)
{
    kn_mesh mesh = {0};
    kn_status status = kn_patch_tessellate(worker, &mesh, item->patch);
    if (status == KN_OK) put_mesh(text, w, item, &mesh);
    kn_mesh_clear(worker, &mesh);
    return status;
}

// ---- bicubic patches ----

static bool is_cubic(const kn_spline *s)
{
    return s->nvars == 2 && !s->rational && s->degree[0] <= 3 && s->degree[1] <= 3;
}

// The least s with 2^s >= n: POV-Ray halves a patch so often.
static int steps_for(int n)
{
    int s = 2;
    while (s < MOST_STEPS && 1 << s < n) s++;
    return s;
}

static void put_bicubic(kn_text *text, const kn_write_text *w, const kn_write_item *item, const kn_bezier *b,
                        const int steps[2])
{
    kn_text_put(text, "bicubic_patch { type 1 flatness 0 u_steps ");
    kn_text_integer(text, (uint64_t)steps[1]);
    kn_text_put(text, " v_steps ");
    kn_text_integer(text, (uint64_t)steps[0]);
    for (size_t k = 0; k < 16; k++) {
        const double p[3] = {b->coef[k], b->coef[16 + k], b->coef[32 + k]};
        if (k > 0)
            put_list_break(text);
        else
            kn_text_char(text, ' ');
        put_vector(text, p);
    }
    put_texture(text, w, item);
}

static kn_status put_pieces(kn_ctx *worker, kn_text *text, const kn_write_text *w, const kn_write_item *item)
{
    static const int cubic[2] = {3, 3};
    kn_bezier *list = NULL;
    size_t n = 0;
    int steps[2];
    for (int d = 0; d < 2; d++) {
        int var = item->patch->reversed ? 1 - d : d;
        steps[d] = steps_for(item->patch->segments[var] / kn_spline_spans(&item->spline, d));
    }
    kn_status status = kn_spline_to_bezier(worker, &list, &n, &item->spline);
    for (size_t i = 0; i < n; i++) {
        if (status == KN_OK) status = kn_bezier_elevate(worker, &list[i], &list[i], cubic);
        if (status == KN_OK) put_bicubic(text, w, item, &list[i], steps);
        kn_bezier_clear(worker, &list[i]);
    }
    kn_free(worker, list);
    return status;
}

// ---- curves ----

static kn_status put_curve(kn_ctx *worker, kn_text *text, const kn_write_text *w, const kn_write_item *item)
{
    size_t n = kn_patch_line_points(item->patch);
    if (n == 0) return KN_OK;
    kn_mark mark = kn_scratch_mark(worker);
    double *p = kn_scratch(worker, n, 3 * sizeof *p);
    kn_status status = p ? kn_patch_line(worker, p, item->patch) : KN_ENOMEM;
    if (status == KN_OK) {
        kn_text_put(text, "sphere_sweep { linear_spline ");
        kn_text_integer(text, n);
        for (size_t i = 0; i < n; i++) {
            put_list_break(text);
            put_vector(text, p + 3 * i);
            kn_text_put(text, ",Thickness");
        }
        put_texture(text, w, item);
    }
    kn_scratch_release(worker, mark);
    return status;
}

static kn_status put_patch(kn_ctx *worker, kn_text *text, const kn_write_text *w, const kn_write_item *item)
{
    if (item->patch->mesh) {
        put_mesh(text, w, item, item->patch->mesh);
        return KN_OK;
    }
    if (item->spline.nvars == 1) return put_curve(worker, text, w, item);
    if (is_cubic(&item->spline) && item->trim.nloops == 0) return put_pieces(worker, text, w, item);
    return put_triangles(worker, text, w, item);
}

// ---- the scene ----

static void put_number(kn_text *text, const char *before, double x, const char *after)
{
    kn_text_put(text, before);
    kn_text_plain_real(text, x, COLOUR_DIGITS);
    kn_text_put(text, after);
}

static void put_head(kn_text *text, const kn_write_text *w)
{
    kn_text_put(text, "// knurl " KN_VERSION_STRING "; to make a picture: povray +A +W1200 +H900 THIS.pov\n"
                      "#version 3.7;\nglobal_settings { assumed_gamma 1.0 }\n");
    put_number(text, "#declare Thickness = ", w->cell_size / 60.0, "; // of curves\n");
    for (int i = 0; i < w->nlooks; i++) {
        const kn_material *m = &w->looks[i].material;
        kn_text_put(text, "#declare Part_");
        kn_text_integer(text, (uint64_t)i);
        kn_text_put(text, " = texture { pigment { color rgb <");
        for (int c = 0; c < 3; c++) put_number(text, c > 0 ? "," : "", m->base_color[c], "");
        put_number(text, "> } finish { ambient 0 diffuse ", 0.85 - 0.35 * m->metallic, "");
        put_number(text, " specular ", 0.7 * (1.0 - 0.7 * m->roughness), "");
        put_number(text, " roughness ", fmax(0.003, 0.15 * m->roughness * m->roughness), "");
        if (m->metallic > 0.0) put_number(text, " metallic reflection { ", 0.3 * m->metallic, " metallic }");
        kn_text_put(text, " } } // ");
        kn_text_utf8(text, w->looks[i].name);
        kn_text_newline(text);
    }
}

static void put_tail(kn_text *text, const kn_write_text *w)
{
    static const double none[2][3] = {{0, 0, 0}, {1, 1, 1}}; // the camera needs a place to look at
    bool any = w->lo[0] <= w->hi[0];
    kn_text_put(text, "#declare Low = ");
    put_vector(text, any ? w->lo : none[0]);
    kn_text_put(text, ";\n#declare High = ");
    put_vector(text, any ? w->hi : none[1]);
    kn_text_put(
        text, ";\n#declare Middle = (Low + High) / 2;\n#declare Size = vlength(High - Low);\n"
              "camera {\n  location Middle + 1.6 * Size * vnormalize(<0.62, -1, 0.62>)\n"
              "  sky z\n  up z\n  right -x * image_width / image_height\n  angle 33\n  look_at Middle\n}\n"
              "light_source {\n  Middle + Size * <1.2, -2.2, 3>, rgb 1.15\n"
              "  area_light x * Size * 0.7, y * Size * 0.7, 5, 5 adaptive 1 jitter circular orient\n}\n"
              "light_source { Middle + Size * <-2.5, -1.2, 1.2>, rgb 0.35 shadowless }\n"
              "background { rgb <0.86, 0.88, 0.91> }\n"
              "plane { z, Low.z - 0.002 * Size pigment { rgb <0.80, 0.80, 0.79> } finish { ambient 0 diffuse 0.75 } "
              "}\n");
}

kn_status kn_pov_sink(kn_ctx *ctx, kn_sink *out, const char *path)
{
    static const kn_write_format format = {
        .name = "POV-Ray",
        .holds = KN_WRITE_CURVES | KN_WRITE_SURFACES | KN_WRITE_VOLUMES | KN_WRITE_TRIMMED | KN_WRITE_MESHES,
        .head = put_head,
        .patch = put_patch,
        .tail = put_tail,
    };
    return kn_write_text_sink(ctx, out, path, &format);
}
