// SPDX-License-Identifier: Apache-2.0
// What functions of cells ask of a map.
#include "cells/internal.h"
#include "kernel/context.h"

kn_status kn_cells_expect_map(kn_ctx *ctx, const char *call, const kn_spline *surface, const kn_spline *map)
{
    if (map->nvars != 2 || map->ncomp != 2 || map->rational)
        return kn_fail(ctx, KN_EDOMAIN, "%s: a map of %d variables and %d components%s; it has 2 and 2, polynomial",
                       call, map->nvars, map->ncomp, map->rational ? ", rational" : "");
    kn_status status = kn_spline_check(ctx, map);
    if (status != KN_OK) return status;
    for (int d = 0; d < 2; d++) {
        double lo, hi;
        size_t n = kn_spline_count(map);
        kn_spline_domain(surface, d, &lo, &hi);
        for (size_t k = (size_t)d * n; k < (size_t)(d + 1) * n; k++)
            if (!(map->coef[k] >= lo && map->coef[k] <= hi))
                return kn_fail(ctx, KN_EDOMAIN, "%s: the map reaches %g in variable %d, whose domain is [%g,%g]",
                               call, map->coef[k], d, lo, hi);
    }
    return KN_OK;
}
