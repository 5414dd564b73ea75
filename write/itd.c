// SPDX-License-Identifier: Apache-2.0
// IRIT data files (io/read_itd.c tells the format). A trimmed surface is "[TRIMSRF surface [TRIMCRV [TRIMCRVSEG curve]
// ..] ..]": a TRIMCRV for each loop, a TRIMCRVSEG with a curve of the parameter plane for each curve of it.
#include "write/text_sink.h"

#include "io/color.h"

#include <stdio.h>

static void put_knots(kn_text *text, const kn_spline *s)
{
    for (int d = 0; d < s->nvars; d++) {
        kn_text_put(text, "  [KV");
        for (int i = 0; i <= s->count[d] + s->degree[d]; i++) kn_write_real(text, s->knots[d][i]);
        kn_text_put(text, "]\n");
    }
}

// Weights come first, the first variable runs fastest.
static void put_points(kn_text *text, const kn_spline *s)
{
    size_t n = kn_spline_count(s);
    int dim = kn_spline_dim(s);
    for (size_t k = 0; k < n; k++) {
        size_t at = kn_write_place(s, k);
        kn_text_put(text, "  [");
        for (int i = 0; i < s->ncomp; i++) {
            int c = !s->rational ? i : i == 0 ? dim : i - 1;
            if (i > 0) kn_text_char(text, ' ');
            kn_text_plain_real(text, s->coef[(size_t)c * n + at], 17);
        }
        kn_text_put(text, "]\n");
    }
}

static bool is_piece(const kn_spline *s)
{
    for (int d = 0; d < s->nvars; d++) {
        int last = s->count[d] + s->degree[d];
        if (s->count[d] != s->degree[d] + 1 || s->knots[d][0] != 0.0 || s->knots[d][last] != 1.0) return false;
    }
    return true;
}

// A Bezier piece over [0,1] needs no knots.
static void put_spline(kn_text *text, const kn_spline *s)
{
    static const char *const words[] = {"", "[CURVE ", "[SURFACE ", "[TRIVAR "};
    bool piece = is_piece(s);
    kn_text_put(text, words[s->nvars]);
    kn_text_put(text, piece ? "BEZIER" : "BSPLINE");
    for (int d = 0; d < s->nvars; d++) {
        kn_text_char(text, ' ');
        kn_text_integer(text, (uint64_t)s->count[d]);
    }
    for (int d = 0; d < s->nvars && !piece; d++) {
        kn_text_char(text, ' ');
        kn_text_integer(text, (uint64_t)s->degree[d] + 1);
    }
    kn_text_put(text, s->rational ? " P" : " E");
    kn_text_integer(text, (uint64_t)kn_spline_dim(s));
    kn_text_newline(text);
    if (!piece) put_knots(text, s);
    put_points(text, s);
    kn_text_put(text, "]\n");
}

static void put_trim(kn_text *text, const kn_trim *trim)
{
    for (int loop = 0, i = 0; loop < trim->nloops; loop++) {
        kn_text_put(text, "[TRIMCRV\n");
        for (; i < trim->loop_end[loop]; i++) {
            kn_text_put(text, "[TRIMCRVSEG\n");
            put_spline(text, &trim->curves[i]);
            kn_text_put(text, "]\n");
        }
        kn_text_put(text, "]\n");
    }
}

static void put_polygons(kn_text *text, const kn_mesh *mesh)
{
    for (size_t t = 0; t < mesh->ntriangles; t++) {
        kn_text_put(text, "[POLYGON 3\n");
        for (size_t k = 0; k < 3; k++) {
            const double *p = mesh->position + 3 * (size_t)mesh->triangle[3 * t + k];
            kn_text_put(text, "  [");
            for (int c = 0; c < 3; c++) {
                if (c > 0) kn_text_char(text, ' ');
                kn_text_plain_real(text, p[c], 17);
            }
            kn_text_put(text, "]\n");
        }
        kn_text_put(text, "]\n");
    }
}

// Names are words: letters, digits and underscores.
static void put_name(kn_text *text, const kn_patch_id *id, const char *part)
{
    char name[KN_NAME_BYTES + 96];
    int n = snprintf(name, sizeof name, "s%d_c%d_%d_%s_%d", id->surface, id->cell[0], id->cell[1], part, id->patch);
    if (id->piece > 0 || id->instance > 0)
        (void)snprintf(name + n, sizeof name - (size_t)n, "_%d_%d", id->piece, id->instance);
    for (char *c = name; *c; c++) {
        bool word = (*c >= '0' && *c <= '9') || (*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z');
        kn_text_char(text, word ? *c : '_');
    }
}

static kn_status put_patch(kn_ctx *worker, kn_text *text, const kn_write_text *w, const kn_write_item *item)
{
    (void)worker, (void)w;
    const double *color = item->look->material.base_color;
    kn_text_put(text, "[OBJECT [RGB \"");
    for (int c = 0; c < 3; c++) {
        if (c > 0) kn_text_char(text, ',');
        kn_text_integer(text, (uint64_t)kn_color_srgb_byte(color[c]));
    }
    kn_text_put(text, "\"] ");
    put_name(text, &item->patch->id, item->look->name);
    kn_text_newline(text);
    bool trimmed = item->trim.nloops > 0;
    if (trimmed) kn_text_put(text, "[TRIMSRF\n");
    if (item->patch->mesh)
        put_polygons(text, item->patch->mesh);
    else
        put_spline(text, &item->spline);
    if (trimmed) {
        put_trim(text, &item->trim);
        kn_text_put(text, "]\n");
    }
    kn_text_put(text, "]\n");
    return KN_OK;
}

static void put_head(kn_text *text, const kn_write_text *w)
{
    (void)w;
    kn_text_put(text, "knurl " KN_VERSION_STRING "\n");
}

kn_status kn_itd_sink(kn_ctx *ctx, kn_sink *out, const char *path)
{
    static const kn_write_format format = {
        .name = "IRIT .itd",
        .holds = KN_WRITE_CURVES | KN_WRITE_SURFACES | KN_WRITE_VOLUMES | KN_WRITE_TRIMMED | KN_WRITE_MESHES,
        .head = put_head,
        .patch = put_patch,
    };
    return kn_write_text_sink(ctx, out, path, &format);
}
