// SPDX-License-Identifier: Apache-2.0
// Lines at equal steps of length.
#include <knurl/cells.h>

kn_status kn_cells_even_lines(kn_ctx *ctx, double **lines, const kn_spline *surface, int var, int count)
{
    return kn_cells_shared_lines(ctx, lines, &(kn_cells_along){.surface = surface, .var = var}, 1, count);
}
