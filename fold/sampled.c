// SPDX-License-Identifier: Apache-2.0
// The grid on which zero sets of the Jacobian are drawn.
#include "fold/internal.h"
#include "kernel/context.h"

enum { MOST = 1 << 26 }; // points

void kn_fold_clear_splines(kn_ctx *ctx, kn_spline *list, int n)
{
    for (int k = 0; list && k < n; k++) kn_spline_clear(ctx, &list[k]);
    kn_free(ctx, list);
}

// Cell lines are where the boxes of the grid change cells.
static kn_status lines(kn_ctx *ctx, double *line, const kn_shell *shell, int var)
{
    int n[3], at[3] = {0}, cell = -1;
    kn_shell_jacobian_grid(shell, n);
    kn_status status = KN_OK;
    for (int i = 0; i < n[var] && status == KN_OK; i++) {
        kn_shell_jacobian_piece p = {0};
        at[var] = i;
        status = kn_shell_jacobian_piece_init(ctx, &p, shell, at);
        if (status == KN_OK && p.cell[var] != cell) {
            cell = p.cell[var];
            line[cell] = p.lo[var];
        }
        if (status == KN_OK) line[cell + 1] = p.hi[var];
        kn_shell_jacobian_piece_clear(ctx, &p);
    }
    return status;
}

kn_status kn_fold_parameters(kn_ctx *ctx, double *at[2], size_t n[2], const kn_shell *shell, int steps)
{
    int cells[2];
    kn_status status = KN_OK;
    kn_shell_cells(shell, cells);
    if (steps < 1) return kn_fail(ctx, KN_EDOMAIN, "fold: %d steps", steps);
    if ((double)cells[0] * steps * ((double)cells[1] * steps) > MOST)
        return kn_fail(ctx, KN_ELIMIT, "fold: %d steps in each of %d x %d cells", steps, cells[0], cells[1]);
    for (int v = 0; v < 2; v++) {
        n[v] = (size_t)cells[v] * (size_t)steps + 1;
        at[v] = NULL;
    }
    for (int v = 0; v < 2 && status == KN_OK; v++) {
        kn_mark mark = kn_scratch_mark(ctx);
        double *line = kn_scratch(ctx, (size_t)cells[v] + 1, sizeof *line);
        at[v] = kn_alloc(ctx, n[v], sizeof *at[v]);
        status = line && at[v] ? lines(ctx, line, shell, v) : KN_ENOMEM;
        for (size_t i = 0; i < n[v] && status == KN_OK; i++) {
            size_t c = i / (size_t)steps, k = i % (size_t)steps;
            at[v][i] = k == 0 ? line[c] : line[c] + (line[c + 1] - line[c]) * (double)k / steps;
        }
        if (status == KN_OK) {
            at[v][0] += 1e-6 * (at[v][1] - at[v][0]);
            at[v][n[v] - 1] -= 1e-6 * (at[v][n[v] - 1] - at[v][n[v] - 2]);
        }
        kn_scratch_release(ctx, mark);
    }
    for (int v = 0; v < 2 && status != KN_OK; v++) {
        kn_free(ctx, at[v]);
        at[v] = NULL;
    }
    return status;
}
