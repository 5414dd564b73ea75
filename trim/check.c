// SPDX-License-Identifier: Apache-2.0
// kn_trim_check.
#include "kernel/context.h"
#include "trim/internal.h"

static kn_status check_curve(kn_ctx *ctx, const kn_trim *trim, int i)
{
    const kn_spline *c = &trim->curves[i];
    if (c->nvars != 1 || c->ncomp != 2 || c->rational)
        return kn_fail(ctx, KN_EDOMAIN, "trim: curve %d is no polynomial curve in the plane", i);
    kn_status status = kn_spline_check(ctx, c);
    if (status != KN_OK) return status;
    int n = c->count[0];
    for (int k = 0; k < 2 * n; k++) {
        bool end = k % n == 0 || k % n == n - 1;
        double reach = end ? 0.0 : 1.0;
        if (!(c->coef[k] >= -reach && c->coef[k] <= 1.0 + reach))
            return kn_fail(ctx, KN_EDOMAIN, "trim: control point %d of curve %d lies outside the square", k % n, i);
    }
    return KN_OK;
}

static kn_status check_loops(kn_ctx *ctx, const kn_trim *trim)
{
    if (trim->nloops < 0 || (trim->nloops == 0 && trim->ncurves != 0) || (trim->nloops > 0 && !trim->loop_end) ||
        (trim->ncurves > 0 && !trim->curves))
        return kn_fail(ctx, KN_EDOMAIN, "trim: %d curves in %d loops", trim->ncurves, trim->nloops);
    for (int i = 0, first = 0; i < trim->nloops; first = trim->loop_end[i++])
        if (trim->loop_end[i] <= first || trim->loop_end[i] > trim->ncurves ||
            (i == trim->nloops - 1 && trim->loop_end[i] != trim->ncurves))
            return kn_fail(ctx, KN_EDOMAIN, "trim: loop %d ends at curve %d of %d", i, trim->loop_end[i],
                           trim->ncurves);
    return KN_OK;
}

// The integral of x dy along all pieces of a curve, with the degree's own product rule for Bernstein polynomials:
// B_i^n B_j^(n-1) integrates to C(n,i) C(n-1,j) / C(2n-1,i+j) / 2n.
kn_status kn_trim_add_area(kn_ctx *ctx, double *area, const kn_spline *curve)
{
    kn_bezier *pieces = NULL, x = {0}, dy = {0};
    size_t n = 0;
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, curve);
    for (size_t i = 0; status == KN_OK && i < n; i++) {
        double part = 0.0;
        status = kn_bezier_components(ctx, &x, &pieces[i], 0, 1);
        if (status == KN_OK) status = kn_bezier_components(ctx, &dy, &pieces[i], 1, 1);
        if (status == KN_OK) status = kn_bezier_derivative(ctx, &dy, &dy, 0);
        if (status == KN_OK) status = kn_bezier_product(ctx, &x, &x, &dy);
        if (status == KN_OK) status = kn_bezier_integral(ctx, &part, &x);
        *area += part;
    }
    kn_bezier_clear(ctx, &x);
    kn_bezier_clear(ctx, &dy);
    for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    return status;
}

kn_status kn_trim_check(kn_ctx *ctx, const kn_trim *trim)
{
    kn_status status = check_loops(ctx, trim);
    double area = 0.0;
    for (int i = 0; status == KN_OK && i < trim->ncurves; i++) status = check_curve(ctx, trim, i);
    for (int i = 0, first = 0; status == KN_OK && i < trim->nloops; first = trim->loop_end[i++])
        for (int k = first; status == KN_OK && k < trim->loop_end[i]; k++) {
            int next = k + 1 < trim->loop_end[i] ? k + 1 : first;
            double end[2], start[2];
            kn_trim_ends(&trim->curves[k], NULL, end);
            kn_trim_ends(&trim->curves[next], start, NULL);
            if (end[0] != start[0] || end[1] != start[1])
                status = kn_fail(ctx, KN_EDOMAIN,
                                 "trim: curve %d ends at (%.17g, %.17g) and curve %d begins at "
                                 "(%.17g, %.17g)",
                                 k, end[0], end[1], next, start[0], start[1]);
        }
    for (int i = 0; status == KN_OK && i < trim->ncurves; i++)
        status = kn_trim_add_area(ctx, &area, &trim->curves[i]);
    if (status == KN_OK && trim->nloops > 0 && !(area > 0.0))
        return kn_fail(ctx, KN_EDOMAIN, "trim: the region has the area %g", area);
    return status;
}
