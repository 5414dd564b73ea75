// SPDX-License-Identifier: Apache-2.0
// Arcs of circles and ellipses.
#include <math.h>
#include <string.h>

#include "construct/internal.h"
#include "kernel/context.h"
#include "spline/internal.h"

static const char call[] = "construct_arc";

static kn_status check(kn_ctx *ctx, const double center[3], const double x[3], const double y[3])
{
    kn_status status = kn_construct_finite(ctx, call, center, 3);
    if (status == KN_OK) status = kn_construct_finite(ctx, call, x, 3);
    if (status == KN_OK) status = kn_construct_finite(ctx, call, y, 3);
    if (status != KN_OK) return status;
    double a[3], b[3], across[3], large[2] = {0.0, 0.0};
    for (int c = 0; c < 3; c++) large[0] = fmax(large[0], fabs(x[c])), large[1] = fmax(large[1], fabs(y[c]));
    for (int c = 0; c < 3; c++) a[c] = x[c] / large[0], b[c] = y[c] / large[1];
    kn_construct_cross(across, a, b);
    if (!(large[0] > 0.0 && large[1] > 0.0) || !(kn_construct_dot(across, across) > 0.0))
        return kn_fail(ctx, KN_EUNDEFINED, "%s: the half-diameters are parallel", call);
    return KN_OK;
}

kn_status kn_construct_arc(kn_ctx *ctx, kn_spline *out, const double center[3], const double x[3], const double y[3],
                           double angle)
{
    kn_turn turn;
    kn_status status = check(ctx, center, x, y);
    if (status == KN_OK) status = kn_construct_turn(ctx, call, &turn, angle);
    if (status != KN_OK) return status;
    kn_spline s = {.nvars = 1, .ncomp = 4, .rational = true, .degree = {2}, .count = {turn.n}};
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_spline_in_scratch(ctx, call, &s);
    if (status == KN_OK) {
        memcpy(s.knots[0], turn.knots, (size_t)(turn.n + 3) * sizeof *turn.knots);
        for (int i = 0; i < turn.n; i++) {
            for (int c = 0; c < 3; c++)
                s.coef[c * turn.n + i] = turn.w[i] * center[c] + (turn.c[i] * x[c] + turn.s[i] * y[c]);
            s.coef[3 * turn.n + i] = turn.w[i];
        }
        status = kn_construct_finite(ctx, call, s.coef, 4 * turn.n);
    }
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    kn_scratch_release(ctx, mark);
    return status;
}
