// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ files with free-form curves and surfaces.
//
// "v x y z w": control points, w the weight, x, y, z not multiplied by it; "cstype [rat] bspline", "deg p q", "surf u0 u1
// v0 v1 .." with the first variable fastest, "parm u .." all knots, "trim u0 u1 curve .." loops of curves of the
// parameter plane, each "curv2 .." over "vp u v", "end". Source: Wavefront, Advanced Visualizer manual, appendix B1.
#include "write/text_sink.h"

#include "io/obj.h"
#include "kernel/context.h"

static void put_indices(kn_text *text, size_t n)
{
    for (size_t k = n; k > 0; k--) {
        kn_text_put(text, " -");
        kn_text_integer(text, k);
    }
    kn_text_newline(text);
}

static void put_parm(kn_text *text, const kn_spline *s)
{
    for (int d = 0; d < s->nvars; d++) {
        kn_text_put(text, d == 0 ? "parm u" : "parm v");
        for (int i = 0; i <= s->count[d] + s->degree[d]; i++) kn_write_real(text, s->knots[d][i]);
        kn_text_newline(text);
    }
}

static void put_range(kn_text *text, const kn_spline *s)
{
    for (int d = 0; d < s->nvars; d++) {
        double lo, hi;
        kn_spline_domain(s, d, &lo, &hi);
        kn_write_real(text, lo);
        kn_write_real(text, hi);
    }
}

static void put_kind(kn_text *text, const kn_spline *s)
{
    kn_text_put(text, s->rational ? "cstype rat bspline\ndeg" : "cstype bspline\ndeg");
    for (int d = 0; d < s->nvars; d++) {
        kn_text_char(text, ' ');
        kn_text_integer(text, (uint64_t)s->degree[d]);
    }
    kn_text_newline(text);
}

// A curve of the parameter plane.
static void put_trim_curve(kn_text *text, const kn_spline *c)
{
    size_t n = kn_spline_count(c);
    for (size_t k = 0; k < n; k++) {
        kn_text_put(text, "vp");
        kn_write_real(text, c->coef[k]);
        kn_write_real(text, c->coef[n + k]);
        kn_text_newline(text);
    }
    put_kind(text, c);
    kn_text_put(text, "curv2");
    put_indices(text, n);
    put_parm(text, c);
    kn_text_put(text, "end\n");
}

// Twice the area that a loop of straight chords encloses: holes run clockwise.
static double turn_of(const kn_trim *trim, int begin, int end)
{
    double sum = 0.0;
    for (int i = begin; i < end; i++) {
        const kn_spline *c = &trim->curves[i];
        size_t n = kn_spline_count(c);
        for (size_t k = 0; k + 1 < n; k++) sum += c->coef[k] * c->coef[n + k + 1] - c->coef[k + 1] * c->coef[n + k];
    }
    return sum;
}

static void put_loops(kn_text *text, const kn_trim *trim)
{
    for (int loop = 0, i = 0; loop < trim->nloops; i = trim->loop_end[loop++]) {
        int end = trim->loop_end[loop];
        kn_text_put(text, turn_of(trim, i, end) < 0.0 ? "hole" : "trim");
        for (int k = i; k < end; k++) {
            put_range(text, &trim->curves[k]);
            kn_text_put(text, " -");
            kn_text_integer(text, (uint64_t)(trim->ncurves - k));
        }
        kn_text_newline(text);
    }
}

static void put_spline(kn_text *text, const kn_spline *s, const kn_trim *trim)
{
    size_t n = kn_spline_count(s);
    for (int i = 0; trim && i < trim->ncurves; i++) put_trim_curve(text, &trim->curves[i]);
    for (size_t k = 0; k < n; k++) {
        size_t at = kn_write_place(s, k);
        kn_text_char(text, 'v');
        for (size_t c = 0; c < 3; c++)
            kn_write_real(text, s->rational ? s->coef[c * n + at] / s->coef[3 * n + at] : s->coef[c * n + at]);
        if (s->rational) kn_write_real(text, s->coef[3 * n + at]);
        kn_text_newline(text);
    }
    put_kind(text, s);
    kn_text_put(text, s->nvars == 1 ? "curv" : "surf");
    put_range(text, s);
    put_indices(text, n);
    put_parm(text, s);
    if (trim) put_loops(text, trim);
    kn_text_put(text, "end\n");
}

// The faces of a volume that lie outside: P_p x P_q of the two other variables looks along +var for var 0 and 2 in a
// right-handed volume, and back for 1.
static kn_status put_volume(kn_ctx *worker, kn_text *text, const kn_spline *s, uint8_t hidden)
{
    static const int swap[2] = {1, 0};
    kn_spline face = {0};
    kn_status status = KN_OK;
    for (int k = 0; status == KN_OK && k < 6; k++) {
        double range[2];
        int var = k / 2, end = k % 2;
        if (hidden >> k & 1) continue;
        kn_spline_domain(s, var, &range[0], &range[1]);
        status = kn_spline_isoparametric(worker, &face, s, var, range[end]);
        if (status == KN_OK && (end == 0) != (var == 1)) status = kn_spline_permute(worker, &face, &face, swap);
        if (status == KN_OK) put_spline(text, &face, NULL);
    }
    kn_spline_clear(worker, &face);
    return status;
}

// Variables of a reversed volume are swapped: its hidden faces with them.
static uint8_t hidden_faces(const kn_patch *patch)
{
    unsigned h = patch->hidden;
    return (uint8_t)(patch->reversed ? (h & ~15u) | (h & 3) << 2 | (h >> 2 & 3) : h);
}

static kn_status put_patch(kn_ctx *worker, kn_text *text, const kn_patch *patch)
{
    static const kn_write_format format = {
        .name = "OBJ", .holds = KN_WRITE_CURVES | KN_WRITE_SURFACES | KN_WRITE_VOLUMES | KN_WRITE_TRIMMED};
    kn_write_item item = {0};
    kn_status status = kn_write_check(worker, &format, patch->look + 1, patch);
    if (status == KN_OK) status = kn_write_item_init(worker, &item, patch);
    if (status != KN_OK) return status;
    if (item.spline.nvars == 3)
        status = put_volume(worker, text, &item.spline, hidden_faces(patch));
    else
        put_spline(text, &item.spline, item.trim.nloops > 0 ? &item.trim : NULL);
    kn_write_item_clear(worker, &item);
    return status;
}

kn_status kn_obj_surfaces_sink(kn_ctx *ctx, kn_sink *out, const char *path)
{
    return kn_obj_open(ctx, out, path, put_patch);
}
