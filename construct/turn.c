// SPDX-License-Identifier: Apache-2.0
// The unit circle as a rational quadratic, and surfaces made with it.
#include <math.h>
#include <string.h>

#include "construct/internal.h"
#include "kernel/context.h"
#include "spline/internal.h"

// Control points of a piece from t - h to t + h: (cos, sin)(t -+ h) with the weight 1, and between them the corner
// (cos t, sin t) / cos h with the weight cos h: homogeneous coordinates are points of the unit circle throughout.
kn_status kn_construct_turn(kn_ctx *ctx, const char *call, kn_turn *out, double angle)
{
    const double root = sqrt(0.5), eighth[8] = {1.0, root, 0.0, -root, -1.0, -root, 0.0, root};
    if (!(angle > 0.0 && angle <= KN_WHOLE_TURN)) return kn_fail(ctx, KN_EDOMAIN, "%s: an angle of %g", call, angle);
    int pieces = 1;
    while (angle > pieces * KN_QUARTER_TURN) pieces++;
    bool quarters = angle == pieces * KN_QUARTER_TURN;
    double half = angle / (2 * pieces);
    out->n = 2 * pieces + 1;
    out->closed = quarters && pieces == 4;
    for (int i = 0; i < out->n; i++) {
        out->c[i] = quarters ? eighth[i % 8] : cos(i * half);
        out->s[i] = quarters ? eighth[(i + 6) % 8] : sin(i * half);
        out->w[i] = i % 2 == 0 ? 1.0 : quarters ? root : cos(half);
    }
    for (int i = 0; i < 3; i++) out->knots[i] = 0.0; // then each end of a piece twice, and 1 1 1
    for (int i = 3; i < out->n; i++) out->knots[i] = (double)((i - 1) / 2) / pieces;
    for (int i = 0; i < 3; i++) out->knots[out->n + i] = 1.0;
    return KN_OK;
}

double kn_construct_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void kn_construct_cross(double out[3], const double a[3], const double b[3])
{
    double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    memcpy(out, c, sizeof c);
}

bool kn_construct_normalize(double unit[3], const double v[3])
{
    double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
    if (!(largest > 0.0 && isfinite(largest))) return false;
    double t[3] = {v[0] / largest, v[1] / largest, v[2] / largest}, length = sqrt(kn_construct_dot(t, t));
    for (int c = 0; c < 3; c++) unit[c] = t[c] / length;
    return length > 0.0; // false for NaN, too
}

kn_status kn_construct_frame(kn_ctx *ctx, const char *call, double x[3], double y[3], double unit[3],
                             const double z[3])
{
    kn_status status = kn_construct_finite(ctx, call, z, 3);
    if (status != KN_OK) return status;
    if (!kn_construct_normalize(unit, z)) return kn_fail(ctx, KN_EUNDEFINED, "%s: an axis without direction", call);
    int least = 0;
    for (int c = 1; c < 3; c++)
        if (fabs(unit[c]) < fabs(unit[least])) least = c;
    double e[3] = {0.0, 0.0, 0.0};
    e[least] = 1.0;
    kn_construct_cross(y, unit, e);
    (void)kn_construct_normalize(y, y);
    kn_construct_cross(x, y, unit);
    return KN_OK;
}

kn_status kn_construct_lathe(kn_ctx *ctx, const char *call, kn_spline *out, const kn_profile *profile,
                             const double origin[3], const double up[3], const double x[3], const double y[3])
{
    kn_turn turn;
    kn_status status = kn_construct_turn(ctx, call, &turn, KN_WHOLE_TURN);
    if (status != KN_OK) return status;
    kn_spline s = {.nvars = 2, .ncomp = 4, .rational = true};
    s.degree[0] = 2, s.degree[1] = profile->degree, s.count[0] = turn.n, s.count[1] = profile->n;
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_spline_in_scratch(ctx, call, &s);
    if (status == KN_OK) {
        double *to = s.coef;
        memcpy(s.knots[0], turn.knots, (size_t)(turn.n + 3) * sizeof *turn.knots);
        memcpy(s.knots[1], profile->knots, (size_t)(profile->n + profile->degree + 1) * sizeof *profile->knots);
        for (int c = 0; c < 4; c++)
            for (int i = 0; i < turn.n; i++)
                for (int j = 0; j < profile->n; j++, to++) {
                    *to = turn.w[i] * profile->w[j];
                    if (c < 3)
                        *to = turn.w[i] * (profile->w[j] * origin[c] + profile->z[j] * up[c]) +
                              profile->rho[j] * (turn.c[i] * x[c] + turn.s[i] * y[c]);
                }
        status = kn_construct_finite(ctx, call, s.coef, 4 * s.count[0] * s.count[1]);
    }
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    kn_scratch_release(ctx, mark);
    return status;
}
