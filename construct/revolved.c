// SPDX-License-Identifier: Apache-2.0
// Curves and surfaces turned about an axis.
#include <math.h>
#include <string.h>

#include "construct/internal.h"
#include "kernel/context.h"
#include "spline/internal.h"

static const char call[] = "construct_revolved";

// A control point (x, w), seen from the axis: x = center + r, r across the axis, s = axis x r.
typedef struct arm {
    double center[3], r[3], s[3];
} arm;

static arm arm_of(const double x[3], double w, const double origin[3], const double axis[3])
{
    arm a;
    double from[3], size = 0.0, along, largest = 0.0;
    for (int c = 0; c < 3; c++) from[c] = x[c] - w * origin[c];
    along = kn_construct_dot(from, axis);
    for (int c = 0; c < 3; c++) {
        a.center[c] = w * origin[c] + along * axis[c];
        a.r[c] = from[c] - along * axis[c];
        size += fabs(x[c]) + fabs(w * origin[c]);
        largest = fmax(largest, fabs(a.r[c]));
    }
    if (largest <= 0x1p-49 * size) { // on the axis, within rounding
        memcpy(a.center, x, sizeof a.center);
        memset(a.r, 0, sizeof a.r);
    }
    kn_construct_cross(a.s, axis, a.r);
    return a;
}

static void turn_points(kn_spline *s, const kn_spline *a, const kn_turn *turn, const double origin[3],
                        const double axis[3])
{
    size_t n = kn_spline_count(a), nt = (size_t)turn->n;
    for (size_t i = 0; i < n; i++) {
        double x[3] = {a->coef[i], a->coef[n + i], a->coef[2 * n + i]}, w = a->rational ? a->coef[3 * n + i] : 1.0;
        arm m = arm_of(x, w, origin, axis);
        for (size_t k = 0; k < nt; k++) {
            bool own = k == 0 || (turn->closed && k == nt - 1); // bit for bit where it started
            for (size_t c = 0; c < 3; c++)
                s->coef[(c * n + i) * nt + k] =
                    own ? x[c] : turn->w[k] * m.center[c] + (turn->c[k] * m.r[c] + turn->s[k] * m.s[c]);
            s->coef[(3 * n + i) * nt + k] = turn->w[k] * w;
        }
    }
}

kn_status kn_construct_revolved(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const double origin[3],
                                const double axis[3], double angle)
{
    kn_turn turn;
    double x[3], y[3], unit[3];
    kn_status status = kn_spline_expect(ctx, call, a, 0);
    if (status != KN_OK) return status;
    if (kn_spline_dim(a) != 3) return kn_fail(ctx, KN_EDOMAIN, "%s: dimension %d", call, kn_spline_dim(a));
    status = kn_construct_finite(ctx, call, origin, 3);
    if (status == KN_OK) status = kn_construct_frame(ctx, call, x, y, unit, axis);
    if (status == KN_OK) status = kn_construct_turn(ctx, call, &turn, angle);
    if (status != KN_OK) return status;
    kn_spline s, shape = *a;
    shape.ncomp = 4, shape.rational = true;
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_construct_extend(ctx, call, &s, &shape, 2, turn.n);
    if (status == KN_OK) {
        memcpy(s.knots[s.nvars - 1], turn.knots, (size_t)(turn.n + 3) * sizeof *turn.knots);
        turn_points(&s, a, &turn, origin, unit);
        status = kn_spline_store(ctx, out, &s);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
