// SPDX-License-Identifier: Apache-2.0
// T, its Jacobian matrix, and the true unit normal at a point.
#include "kernel/context.h"
#include "trivar/internal.h"

#include <math.h>

kn_status kn_shell_eval(kn_ctx *ctx, double point[3], double *jacobian, const kn_shell *shell, double u, double v,
                        double w)
{
    double s[9], n[9]; // value, d/du, d/dv of three components each
    const double at[2] = {u, v};
    if (!isfinite(u) || !isfinite(v) || !isfinite(w))
        return kn_fail(ctx, KN_EDOMAIN, "shell: evaluation at (%g, %g, %g)", u, v, w);
    int order = jacobian ? 1 : 0;
    kn_status status = kn_spline_derivatives(ctx, s, &shell->surface, at, order);
    if (status == KN_OK) status = kn_spline_derivatives(ctx, n, &shell->normal, at, order);
    for (int c = 0; c < 3 && status == KN_OK; c++) {
        point[c] = s[c] + w * n[c];
        if (!jacobian) continue;
        jacobian[3 * c] = s[3 + c] + w * n[3 + c];
        jacobian[3 * c + 1] = s[6 + c] + w * n[6 + c];
        jacobian[3 * c + 2] = n[c];
    }
    return status;
}

kn_status kn_shell_unit_normal(kn_ctx *ctx, double normal[3], const kn_shell *shell, double u, double v)
{
    const double at[2] = {u, v};
    double x[2], unit[3];
    int span[2];
    if (!isfinite(u) || !isfinite(v)) return kn_fail(ctx, KN_EDOMAIN, "shell: normal at (%g, %g)", u, v);
    for (int k = 0; k < 2; k++) {
        const double *knot = shell->knot[k];
        span[k] = kn_interval(knot, shell->nknots[k], at[k]);
        x[k] = (at[k] - knot[span[k]]) / (knot[span[k] + 1] - knot[span[k]]);
    }
    if (!kn_direction_unit(unit, &shell->direction[span[0] * (shell->nknots[1] - 1) + span[1]].n, x))
        return kn_fail(ctx, KN_EUNDEFINED, "shell: the surface has no normal at (%.17g, %.17g)", u, v);
    for (int c = 0; c < 3; c++) normal[c] = unit[c];
    return KN_OK;
}
