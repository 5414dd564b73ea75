// SPDX-License-Identifier: Apache-2.0
// GoTools .g2 files (io/read_g2.c tells the format). A bounded surface, class 210, is the class of the surface beneath
// and its body, the number of loops, for each loop the number of its curves and a tolerance in space, and for each
// curve "prefer-the-parameter-curve class-of-it class-of-the-curve-in-space" and the bodies of both; 0: there is none.
#include "write/text_sink.h"

#include "io/color.h"

enum { CURVE = 100, SURFACE = 200, BOUNDED = 210, VOLUME = 700 };

// "dimension rational", counts, orders and knots, control points.
static void put_body(kn_text *text, const kn_spline *s)
{
    size_t n = kn_spline_count(s);
    kn_text_integer(text, (uint64_t)kn_spline_dim(s));
    kn_text_put(text, s->rational ? " 1\n" : " 0\n");
    for (int d = 0; d < s->nvars; d++) {
        kn_text_integer(text, (uint64_t)s->count[d]);
        kn_text_char(text, ' ');
        kn_text_integer(text, (uint64_t)s->degree[d] + 1);
        kn_text_newline(text);
        for (int i = 0; i <= s->count[d] + s->degree[d]; i++) {
            if (i > 0) kn_text_char(text, ' ');
            kn_text_plain_real(text, s->knots[d][i], 17);
        }
        kn_text_newline(text);
    }
    for (size_t k = 0; k < n; k++) {
        size_t at = kn_write_place(s, k);
        for (int c = 0; c < s->ncomp; c++) {
            if (c > 0) kn_text_char(text, ' ');
            kn_text_plain_real(text, s->coef[(size_t)c * n + at], 17);
        }
        kn_text_newline(text);
    }
}

// The tolerance of loops: curves of a trim meet bit for bit, but points are computed from (u,v) in double precision.
static void put_loops(kn_text *text, const kn_trim *trim)
{
    kn_text_integer(text, (uint64_t)trim->nloops);
    kn_text_newline(text);
    for (int loop = 0, i = 0; loop < trim->nloops; loop++) {
        kn_text_integer(text, (uint64_t)(trim->loop_end[loop] - i));
        kn_text_put(text, " 1e-06\n");
        for (; i < trim->loop_end[loop]; i++) {
            kn_text_put(text, "1 100 0\n");
            put_body(text, &trim->curves[i]);
        }
    }
}

static kn_status put_patch(kn_ctx *worker, kn_text *text, const kn_write_text *w, const kn_write_item *item)
{
    (void)worker, (void)w;
    const kn_spline *s = &item->spline;
    bool bounded = item->trim.nloops > 0;
    static const int codes[] = {0, CURVE, SURFACE, VOLUME};
    kn_text_integer(text, (uint64_t)(bounded ? BOUNDED : codes[s->nvars]));
    kn_text_put(text, " 1 0 4");
    for (int c = 0; c < 3; c++) {
        kn_text_char(text, ' ');
        kn_text_integer(text, (uint64_t)kn_color_srgb_byte(item->look->material.base_color[c]));
    }
    kn_text_put(text, " 255\n");
    if (bounded) kn_text_put(text, "200\n");
    put_body(text, s);
    if (bounded) put_loops(text, &item->trim);
    return KN_OK;
}

kn_status kn_g2_sink(kn_ctx *ctx, kn_sink *out, const char *path)
{
    static const kn_write_format format = {
        .name = "GoTools .g2",
        .holds = KN_WRITE_CURVES | KN_WRITE_SURFACES | KN_WRITE_VOLUMES | KN_WRITE_TRIMMED,
        .patch = put_patch,
    };
    return kn_write_text_sink(ctx, out, path, &format);
}
