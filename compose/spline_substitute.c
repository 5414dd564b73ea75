// SPDX-License-Identifier: Apache-2.0
// kn_spline_substitute: one variable replaced by a spline of it; the other variables keep knots and coefficients.
#include "compose/crossings.h"
#include "compose/substitute.h"
#include "kernel/bernstein.h"
#include "kernel/knots.h"
#include "spline/internal.h"

#include <knurl/compose.h>

#include <limits.h>

typedef struct work {
    kn_grid theirs, own, grid; // breaks of a in var, of g in its own variable, of the result in var
    kn_spline split;           // in scratch, as the next two: a with full multiplicity in var
    kn_spline function;        // g split where it crosses a's knots
    kn_spline out;
    int *span; // of a, for each piece of g
    kn_bezier piece;
} work;

static void get_piece(kn_bezier *piece, const kn_spline *function, int index)
{
    int first = index * (function->degree[0] + 1);
    kn_spline_get_piece(piece, function, &first);
}

static kn_status find_breaks(kn_ctx *ctx, work *w, int var, const kn_spline *g)
{
    const double *own = w->own.breaks[0], *theirs = w->theirs.breaks[var];
    int n = w->own.nbreaks[0];
    kn_numbers list = {0};
    w->function = *g;
    kn_status status = kn_spline_split_on_grid(ctx, &w->function, &w->own);
    size_t m = (size_t)g->degree[0] + 1;
    for (int k = 0; status == KN_OK && k < n - 1; k++) {
        get_piece(&w->piece, &w->function, k);
        for (int i = 1; status == KN_OK && i < w->theirs.nbreaks[var] - 1; i++)
            status = kn_crossings(ctx, &list, w->piece.coef, g->rational ? w->piece.coef + m : NULL, g->degree[0],
                                  theirs[i], own[k], own[k + 1]);
    }
    for (int k = 0; status == KN_OK && k < n; k++) status = kn_numbers_add(ctx, &list, own[k]);
    if (status != KN_OK) return status;
    kn_numbers_merge(&list, own, n, kn_nearness(own, n));
    w->grid.breaks[var] = list.list, w->grid.nbreaks[var] = list.count;
    w->grid.times[var] = kn_scratch(ctx, (size_t)list.count, sizeof *w->grid.times[var]);
    w->span = kn_scratch(ctx, (size_t)list.count, sizeof *w->span);
    return w->grid.times[var] && w->span ? KN_OK : KN_ENOMEM;
}

// g and a split, the latter in var alone.
static kn_status split(kn_ctx *ctx, work *w, const kn_spline *a, int var, const kn_spline *g)
{
    kn_grid there;
    there.breaks[0] = w->grid.breaks[var], there.nbreaks[0] = w->grid.nbreaks[var];
    w->function = *g, w->split = *a;
    kn_status status = kn_spline_split_in_scratch(ctx, &w->function, 0, &there);
    return status == KN_OK ? kn_spline_split_in_scratch(ctx, &w->split, var, &w->theirs) : status;
}

// out: a's shape but for var, where every break has full multiplicity.
static kn_status make_out(kn_ctx *ctx, work *w, const kn_spline *a, int var, const kn_spline *g)
{
    int pieces = w->grid.nbreaks[var] - 1, q = a->degree[var] * g->degree[0];
    if ((size_t)pieces > KN_MAX_COEFS / ((size_t)q + 1))
        return kn_fail(ctx, KN_ELIMIT, "spline_substitute: %d pieces of degree %d", pieces, q);
    w->out = *a;
    w->out.degree[var] = q, w->out.count[var] = pieces * (q + 1);
    w->out.rational = a->rational || g->rational;
    w->out.ncomp = kn_spline_dim(a) + w->out.rational;
    kn_status status = kn_spline_in_scratch(ctx, "spline_substitute", &w->out);
    for (int d = 0; status == KN_OK && d < a->nvars; d++)
        if (d != var) w->out.knots[d] = a->knots[d];
    return status;
}

static kn_status substitute_piece(kn_ctx *ctx, work *w, int var, int k)
{
    kn_substitution map;
    const double *ends = w->grid.breaks[var] + k, *theirs = w->theirs.breaks[var];
    double blur = kn_nearness(w->own.breaks[0], w->own.nbreaks[0]) / (ends[1] - ends[0]);
    get_piece(&w->piece, &w->function, k);
    kn_status status = kn_locate(ctx, "spline_substitute", &w->span[k], &w->piece, 0, theirs, w->theirs.nbreaks[var],
                                 &blur);
    if (status != KN_OK) return status;
    int s = w->span[k], p = w->split.degree[var];
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_substitution_init(ctx, &map, p, &w->piece, theirs[s], theirs[s + 1]);
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

// The continuity at a break: g's there and, where g passes from one span of a to another, a's at the knots between.
static int continuity_at(const work *w, int k, int var, int p, int m)
{
    int continuity = INT_MAX, from = w->span[k - 1], to = w->span[k];
    for (int i = 1; i < w->own.nbreaks[0] - 1; i++)
        if (w->own.breaks[0][i] == w->grid.breaks[var][k]) continuity = m - w->own.times[0][i];
    for (int i = (from < to ? from : to) + 1; i <= (from < to ? to : from); i++)
        if (p - w->theirs.times[var][i] < continuity) continuity = p - w->theirs.times[var][i];
    return continuity;
}

static kn_status substitute(kn_ctx *ctx, work *w, const kn_spline *a, int var, const kn_spline *g)
{
    kn_status status = kn_spline_breaks(ctx, &w->theirs, a, var);
    if (status == KN_OK) status = kn_spline_breaks(ctx, &w->own, g, 0);
    if (status == KN_OK) status = kn_bezier_init(ctx, &w->piece, 1, g->ncomp, g->rational, g->degree);
    if (status == KN_OK) status = find_breaks(ctx, w, var, g);
    if (status == KN_OK) status = split(ctx, w, a, var, g);
    if (status == KN_OK) status = make_out(ctx, w, a, var, g);
    int n = w->grid.nbreaks[var];
    for (int k = 0; status == KN_OK && k < n - 1; k++) status = substitute_piece(ctx, w, var, k);
    if (status != KN_OK) return status;
    for (int k = 1; k < n - 1; k++) w->grid.times[var][k] = continuity_at(w, k, var, a->degree[var], g->degree[0]);
    kn_grid_multiplicities(&w->grid, var, w->out.degree[var]);
    return kn_spline_join_in_scratch(ctx, &w->out, var, &w->grid);
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
    if (status == KN_OK) status = kn_spline_store(ctx, out, &w.out); // last: out may be an operand
    kn_bezier_clear(ctx, &w.piece);
    kn_scratch_release(ctx, mark);
    return status;
}
