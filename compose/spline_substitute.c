// SPDX-License-Identifier: Apache-2.0
// kn_spline_substitute: one variable replaced by a spline of it; the other variables keep knots and coefficients.
#include "compose/crossings.h"
#include "compose/substitute.h"
#include "kernel/bernstein.h"
#include "kernel/knots.h"
#include "spline/internal.h"

#include <knurl/compose.h>

#include <math.h>
#include <string.h>

typedef struct axis_breaks {
    double *at;
    int *times, n;
} axis_breaks;

static kn_status breaks_of(kn_ctx *ctx, axis_breaks *b, const kn_spline *s, int var)
{
    b->n = kn_spline_spans(s, var) + 1;
    b->at = kn_scratch(ctx, (size_t)b->n, sizeof *b->at);
    b->times = kn_scratch(ctx, (size_t)b->n, sizeof *b->times);
    if (!b->at || !b->times) return KN_ENOMEM;
    kn_knots_breaks(b->at, b->times, s->knots[var], s->degree[var], s->count[var]);
    return KN_OK;
}

typedef struct work {
    axis_breaks a, g;   // of the operands
    kn_spline split;    // a with full multiplicity in var
    kn_spline function; // g split where it crosses a's knots
    kn_numbers breaks;  // there
    int *span;          // of a, for each piece of g
    kn_bezier piece;
    kn_spline out;
} work;

static kn_status split_copy(kn_ctx *ctx, kn_spline *out, const kn_spline *s, int var, const double *breaks, int n)
{
    kn_status status = kn_spline_copy(ctx, out, s);
    return status == KN_OK ? kn_spline_split_at(ctx, out, var, breaks, n) : status;
}

static void get_piece(kn_bezier *piece, const kn_spline *function, int index)
{
    int first = index * (function->degree[0] + 1);
    kn_spline_get_piece(piece, function, &first);
}

static kn_status find_breaks(kn_ctx *ctx, work *w, const kn_spline *g)
{
    kn_status status = split_copy(ctx, &w->function, g, 0, w->g.at, w->g.n);
    size_t m = (size_t)g->degree[0] + 1;
    for (int k = 0; status == KN_OK && k < w->g.n - 1; k++) {
        get_piece(&w->piece, &w->function, k);
        for (int i = 1; status == KN_OK && i < w->a.n - 1; i++)
            status = kn_crossings(ctx, &w->breaks, w->piece.coef, g->rational ? w->piece.coef + m : NULL,
                                  g->degree[0], w->a.at[i], w->g.at[k], w->g.at[k + 1]);
    }
    for (int k = 0; status == KN_OK && k < w->g.n; k++) status = kn_numbers_add(ctx, &w->breaks, w->g.at[k]);
    if (status != KN_OK) return status;
    kn_numbers_merge(&w->breaks, w->g.at, w->g.n, kn_nearness(w->g.at, w->g.n));
    w->span = kn_scratch(ctx, (size_t)w->breaks.count, sizeof *w->span);
    return w->span ? split_copy(ctx, &w->function, g, 0, w->breaks.list, w->breaks.count) : KN_ENOMEM;
}

// out: a's shape but for var, where every break has full multiplicity.
static kn_status make_out(kn_ctx *ctx, work *w, const kn_spline *a, int var, const kn_spline *g)
{
    int degree[KN_MAX_VARS], count[KN_MAX_VARS], pieces = w->breaks.count - 1;
    memcpy(degree, a->degree, sizeof degree);
    memcpy(count, a->count, sizeof count);
    degree[var] *= g->degree[0];
    if ((size_t)pieces > KN_MAX_COEFS / ((size_t)degree[var] + 1))
        return kn_fail(ctx, KN_ELIMIT, "spline_substitute: %d pieces of degree %d", pieces, degree[var]);
    count[var] = pieces * (degree[var] + 1);
    bool rational = a->rational || g->rational;
    int ncomp = kn_spline_dim(a) + rational;
    kn_status status = kn_spline_shape(ctx, "spline_substitute", a->nvars, ncomp, rational, degree, count);
    if (status == KN_OK) status = kn_spline_alloc(ctx, &w->out, a->nvars, ncomp, rational, degree, count);
    if (status != KN_OK) return status;
    for (int d = 0; d < a->nvars; d++)
        if (d != var) memcpy(w->out.knots[d], a->knots[d], (size_t)(count[d] + degree[d] + 1) * sizeof(double));
    for (int i = 0; i < count[var] + degree[var] + 1; i++)
        w->out.knots[var][i] = w->breaks.list[i / (degree[var] + 1)];
    return KN_OK;
}

static kn_status substitute_piece(kn_ctx *ctx, work *w, int var, int k)
{
    kn_substitution map;
    double blur = kn_nearness(w->g.at, w->g.n) / (w->breaks.list[k + 1] - w->breaks.list[k]);
    get_piece(&w->piece, &w->function, k);
    kn_status status = kn_locate(ctx, "spline_substitute", &w->span[k], &w->piece, 0, w->a.at, w->a.n, &blur);
    if (status != KN_OK) return status;
    int s = w->span[k], p = w->split.degree[var];
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_substitution_init(ctx, &map, p, &w->piece, w->a.at[s], w->a.at[s + 1]);
    if (status == KN_OK) {
        size_t inner = kn_spline_inner(&w->split, var), outer = kn_spline_outer(&w->split, var);
        size_t from = (size_t)w->split.count[var] * inner, to = (size_t)w->out.count[var] * inner;
        const double *in = w->split.coef + (size_t)(s * (p + 1)) * inner;
        double *out = w->out.coef + (size_t)(k * map.rows) * inner;
        for (size_t o = 0; o < outer; o++) kn_substitution_apply(out + o * to, in + o * from, inner, &map);
        for (size_t o = outer; o < kn_spline_outer(&w->out, var); o++)
            kn_substitution_weight(out + o * to, inner, &map);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// A break is as smooth as g is there and, where g passes from one span of a to another, as a is at the knots between.
static int times_at(const work *w, int k, int p, int m, int q)
{
    int continuity = q;
    for (int i = 1; i < w->g.n - 1; i++)
        if (w->g.at[i] == w->breaks.list[k]) continuity = m - w->g.times[i];
    int from = w->span[k - 1], to = w->span[k];
    for (int i = (from < to ? from : to) + 1; i <= (from < to ? to : from); i++)
        if (p - w->a.times[i] < continuity) continuity = p - w->a.times[i];
    return continuity < -1 ? q + 1 : continuity >= q ? 0 : q - continuity;
}

static kn_status join(kn_ctx *ctx, work *w, int var, int p, int m)
{
    int q = w->out.degree[var], n = w->breaks.count;
    kn_band band;
    int *times = kn_scratch(ctx, (size_t)n, sizeof *times);
    double *to = kn_scratch(ctx, (size_t)n * (size_t)(q + 1), sizeof *to);
    if (!times || !to) return KN_ENOMEM;
    times[0] = times[n - 1] = q + 1;
    for (int k = 1; k < n - 1; k++) times[k] = times_at(w, k, p, m, q);
    int nknots = kn_knots_repeat(to, w->breaks.list, times, n);
    kn_status status = kn_spline_band(ctx, &band, nknots - q - 1, q + 1);
    if (status != KN_OK) return status;
    kn_band_join(&band, w->breaks.list, n, q, to);
    return kn_spline_map(ctx, &w->out, var, q, to, &band);
}

static kn_status substitute(kn_ctx *ctx, work *w, const kn_spline *a, int var, const kn_spline *g)
{
    kn_status status = breaks_of(ctx, &w->a, a, var);
    if (status == KN_OK) status = breaks_of(ctx, &w->g, g, 0);
    if (status == KN_OK) status = kn_bezier_init(ctx, &w->piece, 1, g->ncomp, g->rational, g->degree);
    if (status == KN_OK) status = find_breaks(ctx, w, g);
    if (status == KN_OK) status = split_copy(ctx, &w->split, a, var, w->a.at, w->a.n);
    if (status == KN_OK) status = make_out(ctx, w, a, var, g);
    for (int k = 0; status == KN_OK && k < w->breaks.count - 1; k++) status = substitute_piece(ctx, w, var, k);
    return status == KN_OK ? join(ctx, w, var, a->degree[var], g->degree[0]) : status;
}

kn_status kn_spline_substitute(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var, const kn_spline *g)
{
    kn_status status = kn_spline_expect(ctx, "spline_substitute", a, var);
    if (status == KN_OK) status = kn_spline_expect(ctx, "spline_substitute", g, 0);
    if (status == KN_OK)
        status = kn_substitution_check(ctx, "spline_substitute", a->degree[var], g->nvars, kn_spline_dim(g),
                                       g->degree[0]);
    if (status != KN_OK) return status;
    work w = {0};
    kn_mark mark = kn_scratch_mark(ctx);
    status = substitute(ctx, &w, a, var, g);
    if (status == KN_OK) kn_spline_swap(out, &w.out); // last: out may be an operand
    kn_bezier_clear(ctx, &w.piece);
    kn_spline_clear(ctx, &w.split);
    kn_spline_clear(ctx, &w.function);
    kn_spline_clear(ctx, &w.out);
    kn_scratch_release(ctx, mark);
    return status;
}
