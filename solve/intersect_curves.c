// SPDX-License-Identifier: Apache-2.0
// Where two curves meet.
#include "solve/cells.h"

#include "kernel/context.h"

kn_status kn_solve_intersect_curves(kn_ctx *ctx, kn_root **roots, size_t *nroots, kn_solve_report *report,
                                    const kn_spline *a, const kn_spline *b, const kn_solve_options *options)
{
    if (a->nvars != 1 || b->nvars != 1)
        return kn_fail(ctx, KN_EDOMAIN, "intersect curves: %d and %d variables", a->nvars, b->nvars);
    return kn_meet(ctx, "intersect curves", roots, nroots, report, a, b, options);
}
