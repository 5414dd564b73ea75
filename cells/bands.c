// SPDX-License-Identifier: Apache-2.0
// Bands of rows with counts of their own.
#include <knurl/cells.h>

kn_status kn_cells_bands(kn_ctx *ctx, kn_cells_band **bands, int *nbands, const kn_spline *surface,
                         const double size[2])
{
    return kn_cells_shared_bands(ctx, bands, nbands, &(kn_cells_along){.surface = surface, .var = 1}, 1, size);
}
