// SPDX-License-Identifier: Apache-2.0
// Common zeros of splines.
#include "solve/cells.h"

#include "kernel/context.h"

kn_status kn_zeros_within(kn_ctx *ctx, kn_root **roots, size_t *nroots, kn_solve_report *report, const kn_spline *f,
                          int nf, const double *error, const kn_solve_options *options)
{
    kn_solve_options o;
    kn_cells cells = {0};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_solve_settle(ctx, &o, options);
    if (status == KN_OK) status = kn_cells_of_splines(ctx, &cells, f, nf, error, o.residual);
    if (status == KN_OK) status = kn_cells_solve(ctx, roots, nroots, report, &cells, &o);
    kn_cells_clear(ctx, &cells);
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_solve_zeros(kn_ctx *ctx, kn_root **roots, size_t *nroots, kn_solve_report *report, const kn_spline *f,
                         int nf, const kn_solve_options *options)
{
    return kn_zeros_within(ctx, roots, nroots, report, f, nf, NULL, options);
}
