// SPDX-License-Identifier: Apache-2.0
// An operation on a spline piece by piece: split at the breaks, operate, join on the knots that are needed.
#include "bezier/shape.h"
#include "kernel/context.h"
#include "spline/internal.h"

static kn_status operate(kn_ctx *ctx, kn_spline *r, const kn_spline *split, const kn_grid *grid, kn_bezier *piece,
                         kn_bezier *value, kn_piece_op op, const void *user)
{
    int index[KN_MAX_VARS] = {0}, first[KN_MAX_VARS];
    double size[KN_MAX_VARS];
    do {
        for (int d = 0; d < split->nvars; d++) {
            const double *ends = grid->breaks[d] + index[d];
            first[d] = index[d] * (split->degree[d] + 1);
            size[d] = ends[1] - ends[0];
        }
        kn_spline_get_piece(piece, split, first);
        kn_status status = op(ctx, value, piece, size, user);
        if (status != KN_OK) return status;
        for (int d = 0; d < split->nvars; d++) first[d] = index[d] * (r->degree[d] + 1);
        kn_spline_put_piece(r, value, first);
    } while (kn_grid_next(index, grid, split->nvars));
    return KN_OK;
}

kn_status kn_spline_by_pieces(kn_ctx *ctx, const char *call, kn_spline *out, const kn_spline *a,
                              const kn_bezier *shape, kn_piece_op op, const void *user, int rough)
{
    kn_status status = kn_spline_expect(ctx, call, a, 0);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline split = *a, r = {.nvars = a->nvars, .ncomp = shape->ncomp, .rational = shape->rational};
    kn_bezier value = *shape, piece = {.nvars = a->nvars, .ncomp = a->ncomp, .rational = a->rational};
    kn_grid grid;
    for (int d = 0; d < a->nvars; d++) piece.degree[d] = a->degree[d], r.degree[d] = shape->degree[d];
    status = kn_bezier_scratch(ctx, &piece, call);
    if (status == KN_OK) status = kn_bezier_scratch(ctx, &value, call);
    for (int d = 0; d < a->nvars && status == KN_OK; d++) status = kn_spline_breaks(ctx, &grid, a, d);
    if (status == KN_OK) status = kn_spline_split_on_grid(ctx, &split, &grid);
    if (status == KN_OK) status = kn_spline_pieces_in_scratch(ctx, call, &r, &grid);
    if (status == KN_OK) status = operate(ctx, &r, &split, &grid, &piece, &value, op, user);
    for (int d = 0; d < a->nvars && status == KN_OK; d++) {
        int lost = d == rough || rough == KN_EVERY_VAR;
        for (int i = 0; i < grid.nbreaks[d]; i++) grid.times[d][i] = a->degree[d] - grid.times[d][i] - lost;
        kn_grid_multiplicities(&grid, d, r.degree[d]);
    }
    if (status == KN_OK) status = kn_spline_join_on_grid(ctx, &r, &grid);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &r); // last: out may be a
    kn_scratch_release(ctx, mark);
    return status;
}
