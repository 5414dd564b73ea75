// SPDX-License-Identifier: Apache-2.0
// kn_trim_restrict: a region within a box, which becomes [0,1]^2.
#include "kernel/context.h"
#include "trim/internal.h"

#include <math.h>

// Coordinates this near to a side of the box lie on it.
static const double on_side = 1e-9;

// Keeps what lies above (or below) x_v = at.
static kn_status keep(kn_ctx *ctx, bool *any, kn_trim *trim, int v, double at, bool above)
{
    double f[2] = {-at, 1.0 - at};
    const kn_bezier line = {.nvars = 2, .ncomp = 1, .degree = {v == 0, v == 1}, .coef = f};
    kn_trim side[2] = {0};
    kn_trim_cut_report report;
    kn_status status = kn_trim_cut(ctx, &side[0], &side[1], &report, trim, &line, 1e-3);
    if (status == KN_OK) {
        kn_trim kept = side[above];
        side[above] = *trim;
        *trim = kept;
        *any = above ? report.above : report.below;
    }
    kn_trim_clear(ctx, &side[0]);
    kn_trim_clear(ctx, &side[1]);
    return status;
}

static double snap(double x)
{
    return fabs(x) <= on_side ? 0.0 : fabs(x - 1.0) <= on_side ? 1.0 : x;
}

// Into the box's own coordinates. A curve along a side of it becomes a line on that side.
static kn_status move(kn_ctx *ctx, kn_spline *curve, const double lo[2], const double hi[2])
{
    int n = curve->count[0];
    bool along = false;
    for (int c = 0; c < 2; c++) {
        double *x = curve->coef + (size_t)c * (size_t)n;
        double least = INFINITY, most = -INFINITY;
        for (int k = 0; k < n; k++) {
            x[k] = (x[k] - lo[c]) / (hi[c] - lo[c]);
            least = fmin(least, x[k]), most = fmax(most, x[k]);
        }
        x[0] = snap(x[0]), x[n - 1] = snap(x[n - 1]);
        along = along || (x[0] == x[n - 1] && (x[0] == 0.0 || x[0] == 1.0) && fabs(least - x[0]) <= on_side &&
                          fabs(most - x[0]) <= on_side);
    }
    if (!along || (curve->degree[0] == 1 && n == 2)) return KN_OK;
    const double ends[4] = {curve->coef[0], curve->coef[n], curve->coef[n - 1], curve->coef[2 * n - 1]};
    return kn_trim_polyline(ctx, curve, ends, 2);
}

kn_status kn_trim_restrict(kn_ctx *ctx, kn_trim *out, bool *any, const kn_trim *trim, const double lo[2],
                           const double hi[2])
{
    kn_trim rest = {0};
    bool some = true;
    double area = 0.0;
    for (int c = 0; c < 2; c++)
        if (!(lo[c] >= 0.0 && lo[c] < hi[c] && hi[c] <= 1.0))
            return kn_fail(ctx, KN_EDOMAIN, "trim: the box [%g, %g] in variable %d", lo[c], hi[c], c);
    kn_status status = kn_trim_copy(ctx, &rest, trim);
    for (int v = 0; v < 2 && trim->nloops > 0; v++) {
        if (status == KN_OK && some && lo[v] > 0.0) status = keep(ctx, &some, &rest, v, lo[v], true);
        if (status == KN_OK && some && hi[v] < 1.0) status = keep(ctx, &some, &rest, v, hi[v], false);
    }
    for (int k = 0; status == KN_OK && some && k < rest.ncurves; k++) status = move(ctx, &rest.curves[k], lo, hi);
    for (int k = 0; status == KN_OK && some && k < rest.ncurves; k++)
        status = kn_trim_add_area(ctx, &area, &rest.curves[k]);
    some = some && (area > 0.0 || rest.nloops == 0); // what was thinner than that is gone
    if (status == KN_OK) {
        kn_trim old = *out;
        *out = some ? rest : (kn_trim){0};
        if (some) rest = (kn_trim){0};
        kn_trim_clear(ctx, &old);
        *any = some;
    }
    kn_trim_clear(ctx, &rest);
    return status;
}
