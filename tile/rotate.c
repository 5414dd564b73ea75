// SPDX-License-Identifier: Apache-2.0
// Quarter turns of a tile.
#include "kernel/context.h"

#include <knurl/tile.h>

// One quarter turn counterclockwise about (1/2, 1/2): (u, v) -> (1 - v, u). Integers stay exact, so edges on cell
// lines stay on them.
static void quarter(kn_spline *s)
{
    size_t n = kn_spline_count(s);
    double *u = s->coef, *v = s->coef + n;
    for (size_t i = 0; i < n; i++) {
        double turned = 1.0 - v[i];
        v[i] = u[i];
        u[i] = turned;
    }
}

kn_status kn_tile_rotate(kn_ctx *ctx, kn_tile *tile, int quarter_turns)
{
    for (int p = 0; p < tile->nparts; p++)
        for (int s = 0; s < tile->parts[p].nsplines; s++)
            if (tile->parts[p].splines[s].ncomp != 3 || tile->parts[p].splines[s].rational)
                return kn_fail(ctx, KN_EDOMAIN, "rotate: part %d, surface %d is no polynomial (u,v,w) surface", p, s);
    int turns = (quarter_turns % 4 + 4) % 4;
    for (int p = 0; p < tile->nparts; p++)
        for (int s = 0; s < tile->parts[p].nsplines; s++)
            for (int k = 0; k < turns; k++) quarter(&tile->parts[p].splines[s]);
    return KN_OK;
}
