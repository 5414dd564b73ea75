// SPDX-License-Identifier: Apache-2.0
// kn_spline_compose: outer(inner) piece by piece, inner split where it crosses knots of outer along parameter lines.
#include "compose/crossings.h"
#include "compose/nest.h"
#include "kernel/knots.h"
#include "spline/internal.h"

#include <knurl/compose.h>

#include <limits.h>
#include <math.h>
#include <string.h>

typedef struct work {
    const kn_spline *outer;
    kn_grid theirs; // breaks of outer, and how often it has them
    kn_bezier *outer_piece;
    size_t nouter_pieces;

    kn_grid own;          // breaks of inner, and how often it has them
    kn_grid grid;         // of the result
    kn_spline inner, out; // in scratch: inner split at the grid's breaks, the result's pieces
    int *span;            // of each piece and component
    kn_bezier piece, value;
} work;

static kn_status check(kn_ctx *ctx, const kn_spline *outer, const kn_spline *inner)
{
    kn_status status = kn_spline_expect(ctx, "spline_compose", outer, 0);
    if (status == KN_OK) status = kn_spline_expect(ctx, "spline_compose", inner, 0);
    if (status != KN_OK) return status;
    if (kn_spline_dim(inner) != outer->nvars)
        return kn_fail(ctx, KN_EDOMAIN, "spline_compose: %d outer variables, %d inner components", outer->nvars,
                       kn_spline_dim(inner));
    int sum = 0;
    for (int d = 0; d < outer->nvars; d++) sum += outer->degree[d];
    for (int d = 0; d < inner->nvars; d++)
        if (sum * inner->degree[d] > KN_MAX_DEGREE)
            return kn_fail(ctx, KN_ELIMIT, "spline_compose: degree %d in variable %d", sum * inner->degree[d], d);
    return KN_OK;
}

static void get_piece(kn_bezier *piece, const kn_spline *split, const int *index)
{
    int first[KN_MAX_VARS];
    for (int d = 0; d < split->nvars; d++) first[d] = index[d] * (split->degree[d] + 1);
    kn_spline_get_piece(piece, split, first);
}

// Adds where component c of a piece crosses knots of outer, when it depends on one variable alone.
static kn_status add_crossings(kn_ctx *ctx, kn_numbers *lists, const work *w, const int *index, int c)
{
    double x[KN_MAX_DEGREE + 1], weight[KN_MAX_DEGREE + 1];
    int d = kn_depends_alone(x, weight, &w->piece, c);
    if (d < 0) return KN_OK;
    double lo = w->own.breaks[d][index[d]], hi = w->own.breaks[d][index[d] + 1];
    kn_status status = KN_OK;
    for (int i = 1; status == KN_OK && i < w->theirs.nbreaks[c] - 1; i++)
        status = kn_crossings(ctx, &lists[d], x, weight, w->piece.degree[d], w->theirs.breaks[c][i], lo, hi);
    return status;
}

// The breaks of the result: inner's, and where it crosses.
static kn_status find_breaks(kn_ctx *ctx, work *w, const kn_spline *inner)
{
    kn_numbers lists[KN_MAX_VARS] = {{0}};
    int index[KN_MAX_VARS] = {0};
    kn_status status = KN_OK;
    do {
        get_piece(&w->piece, &w->inner, index);
        for (int c = 0; status == KN_OK && c < w->outer->nvars; c++) status = add_crossings(ctx, lists, w, index, c);
    } while (status == KN_OK && kn_grid_next(index, &w->own, inner->nvars));
    for (int d = 0; status == KN_OK && d < inner->nvars; d++) {
        const double *own = w->own.breaks[d];
        int n = w->own.nbreaks[d];
        for (int i = 0; status == KN_OK && i < n; i++) status = kn_numbers_add(ctx, &lists[d], own[i]);
        if (status != KN_OK) break;
        kn_numbers_merge(&lists[d], own, n, kn_nearness(own, n));
        w->grid.nbreaks[d] = lists[d].count;
        w->grid.breaks[d] = lists[d].list;
        w->grid.times[d] = kn_scratch(ctx, (size_t)lists[d].count, sizeof(int));
        if (!w->grid.times[d]) status = KN_ENOMEM;
    }
    return status;
}

static kn_status compose_piece(kn_ctx *ctx, work *w, const int *index, int *span)
{
    double lo[KN_MAX_VARS], hi[KN_MAX_VARS], blur[KN_MAX_VARS];
    int first[KN_MAX_VARS];
    size_t at = 0;
    kn_status status = KN_OK;
    get_piece(&w->piece, &w->inner, index);
    for (int d = 0; d < w->inner.nvars; d++) {
        const double *ends = w->grid.breaks[d] + index[d];
        blur[d] = kn_nearness(w->own.breaks[d], w->own.nbreaks[d]) / (ends[1] - ends[0]);
    }
    for (int c = 0; status == KN_OK && c < w->outer->nvars; c++) {
        status = kn_locate(ctx, "spline_compose", &span[c], &w->piece, c, w->theirs.breaks[c], w->theirs.nbreaks[c],
                           blur);
        if (status != KN_OK) return status;
        lo[c] = w->theirs.breaks[c][span[c]];
        hi[c] = w->theirs.breaks[c][span[c] + 1];
        at = at * (size_t)(w->theirs.nbreaks[c] - 1) + (size_t)span[c];
    }
    status = kn_compose_over(ctx, &w->value, &w->outer_piece[at], &w->piece, lo, hi);
    const kn_bezier *v = &w->value;
    if (status == KN_OK && w->out.nvars == 0) { // the first piece tells the shape of all
        w->out = (kn_spline){.nvars = v->nvars, .ncomp = v->ncomp, .rational = v->rational};
        memcpy(w->out.degree, v->degree, sizeof v->degree);
        status = kn_spline_pieces_in_scratch(ctx, "spline_compose", &w->out, &w->grid);
    }
    if (status != KN_OK) return status;
    for (int d = 0; d < w->out.nvars; d++) first[d] = index[d] * (w->out.degree[d] + 1);
    kn_spline_put_piece(&w->out, v, first);
    return KN_OK;
}

static kn_status compose_all(kn_ctx *ctx, work *w)
{
    int index[KN_MAX_VARS] = {0};
    size_t pieces = 1, k = 0;
    for (int d = 0; d < w->inner.nvars; d++) pieces *= (size_t)w->grid.nbreaks[d] - 1;
    w->span = kn_scratch(ctx, pieces * (size_t)w->outer->nvars, sizeof *w->span);
    kn_status status = w->span ? KN_OK : KN_ENOMEM;
    if (status != KN_OK) return status;
    do status = compose_piece(ctx, w, index, w->span + k++ * (size_t)w->outer->nvars);
    while (status == KN_OK && kn_grid_next(index, &w->grid, w->inner.nvars));
    return status;
}

// The continuity of outer where x_c passes from span a to span b.
static int continuity_between(const work *w, int c, int a, int b)
{
    int least = INT_MAX;
    for (int i = (a < b ? a : b) + 1; i <= (a < b ? b : a); i++) {
        int continuity = w->outer->degree[c] - w->theirs.times[c][i];
        if (continuity < least) least = continuity;
    }
    return least;
}

// A break is as smooth as inner is there, and as outer is at the knots that lie between the pieces of its two sides
// (chain rule). Where inner has no knot and no pieces are divided by one, nothing is left of the break.
static void find_continuity(work *w, const kn_spline *inner)
{
    int index[KN_MAX_VARS] = {0}, n = w->outer->nvars;
    size_t step[KN_MAX_VARS], k = 0, all = 1;
    for (int d = inner->nvars - 1; d >= 0; d--) {
        step[d] = all;
        all *= (size_t)w->grid.nbreaks[d] - 1;
        int own = 0;
        for (int i = 0; i < w->grid.nbreaks[d]; i++) {
            w->grid.times[d][i] = INT_MAX;
            while (own < w->own.nbreaks[d] && w->own.breaks[d][own] < w->grid.breaks[d][i]) own++;
            if (own < w->own.nbreaks[d] && w->own.breaks[d][own] == w->grid.breaks[d][i])
                w->grid.times[d][i] = inner->degree[d] - w->own.times[d][own];
        }
    }
    do {
        for (int d = 0; d < inner->nvars; d++)
            for (int c = 0; index[d] > 0 && c < n; c++) {
                int before = w->span[(k - step[d]) * (size_t)n + (size_t)c],
                    after = w->span[k * (size_t)n + (size_t)c];
                int continuity = continuity_between(w, c, before, after), *least = &w->grid.times[d][index[d]];
                if (continuity < *least) *least = continuity;
            }
        k++;
    } while (kn_grid_next(index, &w->grid, inner->nvars));
    for (int d = 0; d < inner->nvars; d++) kn_grid_multiplicities(&w->grid, d, w->out.degree[d]);
}

static kn_status compose(kn_ctx *ctx, work *w, const kn_spline *inner)
{
    kn_status status = KN_OK;
    for (int c = 0; status == KN_OK && c < w->outer->nvars; c++)
        status = kn_spline_breaks(ctx, &w->theirs, w->outer, c);
    for (int d = 0; status == KN_OK && d < inner->nvars; d++) status = kn_spline_breaks(ctx, &w->own, inner, d);
    if (status == KN_OK) status = kn_spline_to_bezier(ctx, &w->outer_piece, &w->nouter_pieces, w->outer);
    if (status == KN_OK)
        status = kn_bezier_init(ctx, &w->piece, inner->nvars, inner->ncomp, inner->rational, inner->degree);
    w->inner = *inner;
    if (status == KN_OK) status = kn_spline_split_on_grid(ctx, &w->inner, &w->own);
    if (status == KN_OK) status = find_breaks(ctx, w, inner);
    w->inner = *inner;
    if (status == KN_OK) status = kn_spline_split_on_grid(ctx, &w->inner, &w->grid);
    if (status == KN_OK) status = compose_all(ctx, w);
    if (status == KN_OK) {
        find_continuity(w, inner);
        status = kn_spline_join_on_grid(ctx, &w->out, &w->grid);
    }
    return status;
}

kn_status kn_spline_compose(kn_ctx *ctx, kn_spline *out, const kn_spline *outer, const kn_spline *inner)
{
    kn_status status = check(ctx, outer, inner);
    if (status != KN_OK) return status;
    work w = {.outer = outer};
    kn_mark mark = kn_scratch_mark(ctx);
    status = compose(ctx, &w, inner);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &w.out); // last: out may be an operand
    for (size_t i = 0; i < w.nouter_pieces; i++) kn_bezier_clear(ctx, &w.outer_piece[i]);
    kn_free(ctx, w.outer_piece);
    kn_bezier_clear(ctx, &w.piece);
    kn_bezier_clear(ctx, &w.value);
    kn_scratch_release(ctx, mark);
    return status;
}
