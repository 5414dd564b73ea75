// SPDX-License-Identifier: Apache-2.0
// Where a curve meets a surface.
#include "solve/cells.h"

#include "kernel/context.h"

kn_status kn_solve_intersect_curve_surface(kn_ctx *ctx, kn_root **roots, size_t *nroots, kn_solve_report *report,
                                           const kn_spline *curve, const kn_spline *surface,
                                           const kn_solve_options *options)
{
    if (curve->nvars != 1 || surface->nvars != 2 || kn_spline_dim(curve) != 3)
        return kn_fail(ctx, KN_EDOMAIN, "intersect: %d and %d variables, dimension %d", curve->nvars, surface->nvars,
                       kn_spline_dim(curve));
    return kn_meet(ctx, "intersect curve and surface", roots, nroots, report, curve, surface, options);
}
