// SPDX-License-Identifier: Apache-2.0
// An operation on splines piece by piece: split at the common breaks, operate, join on the minimal knots.
#include <limits.h>

#include "spline/internal.h"
#include "kernel/context.h"

// Lowers continuity[i] to degree - multiplicity at the breaks that are knots of s.
static void lower_continuity(int *continuity, const double *breaks, int nbreaks, const kn_spline *s, int var)
{
    const double *knots = s->knots[var];
    int k = 0, last = s->count[var] + s->degree[var];
    for (int i = 0; i < nbreaks; i++) {
        int times = 0;
        for (; k <= last && knots[k] == breaks[i]; k++) times++;
        if (times > 0 && s->degree[var] - times < continuity[i]) continuity[i] = s->degree[var] - times;
    }
}

// The union of the breaks of a and b; grid->times receives the continuity there for the time being.
static kn_status merge_breaks(kn_ctx *ctx, kn_grid *grid, int var, const kn_spline *a, const kn_spline *b)
{
    const kn_spline *operand[2] = {a, b};
    int n[2] = {0, 0};
    double *breaks[2] = {NULL, NULL};
    for (int i = 0; i < 2; i++) {
        const kn_spline *s = operand[i];
        if (!s) continue;
        breaks[i] = kn_scratch(ctx, (size_t)kn_spline_spans(s, var) + 1, sizeof(double));
        if (!breaks[i]) return KN_ENOMEM;
        n[i] = kn_knots_breaks(breaks[i], NULL, s->knots[var], s->degree[var], s->count[var]);
    }
    int total = kn_knots_union(NULL, breaks[0], n[0], breaks[1], n[1]);
    grid->nbreaks[var] = total;
    grid->breaks[var] = kn_scratch(ctx, (size_t)total, sizeof(double));
    grid->times[var] = kn_scratch(ctx, (size_t)total, sizeof(int));
    if (!grid->breaks[var] || !grid->times[var]) return KN_ENOMEM;
    kn_knots_union(grid->breaks[var], breaks[0], n[0], breaks[1], n[1]);
    for (int i = 0; i < total; i++) grid->times[var][i] = INT_MAX;
    for (int i = 0; i < 2; i++)
        if (operand[i]) lower_continuity(grid->times[var], grid->breaks[var], total, operand[i], var);
    return KN_OK;
}

// A copy of a, split at the grid's breaks, and room for one of its pieces.
static kn_status split_operand(kn_ctx *ctx, kn_spline *split, kn_bezier *piece, const kn_spline *a,
                               const kn_grid *grid)
{
    kn_status status = kn_spline_copy(ctx, split, a);
    for (int d = 0; d < a->nvars && status == KN_OK; d++)
        status = kn_spline_split_at(ctx, split, d, grid->breaks[d], grid->nbreaks[d]);
    if (status == KN_OK) status = kn_bezier_init(ctx, piece, a->nvars, a->ncomp, a->rational, a->degree);
    return status;
}

static void piece_start(int *first, const kn_spline *s, const int *index)
{
    for (int d = 0; d < s->nvars; d++) first[d] = index[d] * (s->degree[d] + 1);
}

typedef struct work {
    kn_spline a, b, out;       // split
    kn_bezier piece[2], value; // of one box
    kn_grid grid;
} work;

static kn_status do_piece(kn_ctx *ctx, work *w, const int *index, bool two, kn_piece_op op, const void *user)
{
    int first[KN_MAX_VARS];
    double size[KN_MAX_VARS];
    for (int d = 0; d < w->a.nvars; d++) size[d] = w->grid.breaks[d][index[d] + 1] - w->grid.breaks[d][index[d]];
    piece_start(first, &w->a, index);
    kn_spline_get_piece(&w->piece[0], &w->a, first);
    if (two) {
        piece_start(first, &w->b, index);
        kn_spline_get_piece(&w->piece[1], &w->b, first);
    }
    kn_status status = op(ctx, &w->value, &w->piece[0], two ? &w->piece[1] : NULL, size, user);
    const kn_bezier *v = &w->value;
    if (status == KN_OK && w->out.nvars == 0) // the first piece tells the shape of all
        status = kn_spline_alloc_split(ctx, &w->out, v->nvars, v->ncomp, v->rational, v->degree, &w->grid);
    if (status == KN_OK) {
        piece_start(first, &w->out, index);
        kn_spline_put_piece(&w->out, v, first);
    }
    return status;
}

static kn_status do_all_pieces(kn_ctx *ctx, work *w, bool two, kn_piece_op op, const void *user)
{
    int index[KN_MAX_VARS] = {0};
    for (;;) {
        kn_status status = do_piece(ctx, w, index, two, op, user);
        if (status != KN_OK) return status;
        int d = w->a.nvars - 1;
        while (d >= 0 && ++index[d] == w->grid.nbreaks[d] - 1) index[d--] = 0;
        if (d < 0) return KN_OK;
    }
}

// A break of continuity c keeps q - c knots at degree q, at most q + 1.
static void continuity_to_times(kn_grid *grid, const kn_spline *out, int rough)
{
    for (int d = 0; d < out->nvars; d++)
        for (int i = 1; i < grid->nbreaks[d] - 1; i++) {
            int q = out->degree[d], c = grid->times[d][i] - (d == rough || rough == KN_EVERY_VAR);
            grid->times[d][i] = c < -1 ? q + 1 : q - c;
        }
}

kn_status kn_spline_by_pieces(kn_ctx *ctx, const char *call, kn_spline *out, const kn_spline *a, const kn_spline *b,
                              kn_piece_op op, const void *user, int rough)
{
    kn_status status = b ? kn_spline_expect_pair(ctx, call, a, b) : kn_spline_expect(ctx, call, a, 0);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    work w = {0};
    for (int d = 0; d < a->nvars && status == KN_OK; d++) status = merge_breaks(ctx, &w.grid, d, a, b);
    if (status == KN_OK) status = split_operand(ctx, &w.a, &w.piece[0], a, &w.grid);
    if (status == KN_OK && b) status = split_operand(ctx, &w.b, &w.piece[1], b, &w.grid);
    if (status == KN_OK) status = do_all_pieces(ctx, &w, b != NULL, op, user);
    if (status == KN_OK) {
        continuity_to_times(&w.grid, &w.out, rough);
        status = kn_spline_join(ctx, &w.out, &w.grid);
    }
    if (status == KN_OK) kn_spline_swap(out, &w.out); // last: out may be an operand
    kn_spline_clear(ctx, &w.a);
    kn_spline_clear(ctx, &w.b);
    kn_spline_clear(ctx, &w.out);
    for (int i = 0; i < 2; i++) kn_bezier_clear(ctx, &w.piece[i]);
    kn_bezier_clear(ctx, &w.value);
    kn_scratch_release(ctx, mark);
    return status;
}
