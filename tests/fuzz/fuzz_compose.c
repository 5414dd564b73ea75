// SPDX-License-Identifier: Apache-2.0
// Fuzzes composition: pieces in pieces, splines in splines, substitutions, sensitivities, a tile patch's matrix.
#include "tests/fuzz/feed.h"

#include <knurl/compose.h>

enum { MOST_SUM = 24 };

typedef struct operands {
    kn_bezier a, b, c;
    kn_spline s, t, u;
} operands;

static bool is_small(const int *outer, int nouter, const int *inner, int ninner)
{
    int sum = 0, most = 0;
    for (int d = 0; d < nouter; d++) sum += outer[d];
    for (int d = 0; d < ninner; d++) most = inner[d] > most ? inner[d] : most;
    return sum * most * (ninner > 1 ? 2 : 1) * (ninner > 2 ? 2 : 1) <= MOST_SUM;
}

static kn_status compose_pieces(feed *f, int call, operands *o)
{
    int index[KN_MAX_VARS];
    for (int d = 0; d < KN_MAX_VARS; d++) index[d] = feed_wild(f, 0, 2);
    if (!is_small(o->a.degree, o->a.nvars, o->b.degree, o->b.nvars)) return KN_OK;
    kn_bezier *out = feed_byte(f) % 3 == 0 ? &o->a : feed_byte(f) % 2 ? &o->b : &o->c;
    switch (call) {
    case 0: return kn_bezier_compose(f->ctx, out, &o->a, &o->b);
    case 1: return kn_bezier_substitute(f->ctx, out, &o->a, feed_wild(f, 0, 2), &o->b);
    case 2: return kn_bezier_compose_outer_sensitivity(f->ctx, out, &o->a, &o->b, index);
    default: return kn_bezier_compose_inner_sensitivity(f->ctx, out, &o->a, &o->b, feed_wild(f, 0, 2), index);
    }
}

static kn_status compose_splines(feed *f, int call, operands *o)
{
    if (!is_small(o->s.degree, o->s.nvars, o->t.degree, o->t.nvars)) return KN_OK;
    kn_spline *out = feed_byte(f) % 3 == 0 ? &o->s : feed_byte(f) % 2 ? &o->t : &o->u;
    if (call == 0) return kn_spline_compose(f->ctx, out, &o->s, &o->t);
    return kn_spline_substitute(f->ctx, out, &o->s, feed_wild(f, 0, 2), &o->t);
}

static kn_status tile_patches(feed *f, int call, operands *o)
{
    int degree[2] = {feed_wild(f, 0, 3), feed_wild(f, 0, 3)}, rows[2], power = feed_wild(f, 0, 1);
    for (int d = 0; d < 2; d++) {
        long long fits = o->a.degree[d] * ((long long)degree[0] + degree[1] + power);
        rows[d] = feed_byte(f) % 4 && fits == (int)fits ? (int)fits : feed_wild(f, 0, 20);
    }
    if (call == 0) {
        kn_compose_matrix matrix;
        for (int d = 0; d < 2; d++)
            if (rows[d] > MOST_SUM && rows[d] <= KN_MAX_DEGREE) return KN_OK;
        kn_status status = kn_compose_matrix_init(f->ctx, &matrix, &o->a, degree, power, rows, NULL);
        if (status == KN_OK) kn_compose_matrix_clear(f->ctx, &matrix);
        return status;
    }
    if (!is_small(o->b.degree, o->b.nvars, o->a.degree, o->a.nvars)) return KN_OK;
    if (!is_small(o->c.degree, o->c.nvars, o->a.degree, o->a.nvars)) return KN_OK;
    kn_bezier out = {0};
    kn_shell_piece piece = {.nterms = feed_wild(f, 0, 2), .power = {0, feed_wild(f, 0, 3)}, .term = {o->b, o->c}};
    kn_status status = kn_compose_piece(f->ctx, &out, &piece, &o->a);
    kn_bezier_clear(f->ctx, &out);
    return status;
}

// As an inner function has as many components as the outer one has variables, shapes agree more often than not.
static void make(feed *f, operands *o)
{
    int nouter = feed_int(f, 1, 3), ninner = feed_int(f, 1, 3);
    feed_bezier(f, &o->a, nouter);
    feed_bezier(f, &o->b, ninner);
    feed_bezier(f, &o->c, ninner);
    feed_spline(f, &o->s, nouter);
    feed_spline(f, &o->t, ninner);
    if (o->b.coef && !o->b.rational && o->b.ncomp > nouter && feed_byte(f) % 8)
        feed_any(kn_bezier_components(f->ctx, &o->b, &o->b, 0, nouter));
    if (o->t.nvars && !o->t.rational && o->t.ncomp > nouter && feed_byte(f) % 8)
        feed_any(kn_spline_components(f->ctx, &o->t, &o->t, 0, nouter));
    size_t n = o->t.nvars ? kn_spline_count(&o->t) * (size_t)kn_spline_dim(&o->t) : 0;
    double shift = feed_byte(f) % 2 ? 0.5 : 0.0, factor = feed_byte(f) % 2 ? 1.0 / 16.0 : 1.0; // into the domain
    for (size_t i = 0; i < n; i++) o->t.coef[i] = shift + factor * o->t.coef[i];
    feed_drop(f);
    kn_ctx_clear_error(f->ctx);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    feed f = feed_begin(data, size);
    operands o = {0};
    int call = feed_byte(&f) % 8;
    make(&f, &o);
    kn_status status = call < 4   ? compose_pieces(&f, call, &o)
                       : call < 6 ? compose_splines(&f, call - 4, &o)
                                  : tile_patches(&f, call - 6, &o);
    if ((status == KN_OK) != (kn_ctx_error(f.ctx) == KN_OK)) abort();
    kn_bezier_clear(f.ctx, &o.a), kn_bezier_clear(f.ctx, &o.b), kn_bezier_clear(f.ctx, &o.c);
    kn_spline_clear(f.ctx, &o.s), kn_spline_clear(f.ctx, &o.t), kn_spline_clear(f.ctx, &o.u);
    feed_end(&f);
    return 0;
}
