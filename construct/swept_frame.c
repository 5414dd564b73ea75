// SPDX-License-Identifier: Apache-2.0
// A profile that turns with its trajectory: T(v) + M(v) P(u), M fitted, the rest exact.
#include <math.h>

#include <knurl/fit.h>

#include "construct/internal.h"
#include "kernel/context.h"
#include "spline/internal.h"

static const char call[] = "construct_swept_frame";

typedef struct frame {
    kn_ctx *ctx;
    const kn_spline *trajectory;
    double up[3]; // of length 1
} frame;

// value[3 r + c]: row r, column c of M, whose columns are n, b, t.
static kn_status frame_at(void *user, double *value, const double *at)
{
    const frame *f = user;
    double d[6], n[3], b[3], t[3];
    kn_status status = kn_spline_derivatives(f->ctx, d, f->trajectory, at, 1);
    if (status != KN_OK) return status;
    for (int c = 0; c < 3; c++) t[c] = d[3 + c];
    if (!kn_construct_normalize(t, t)) return kn_fail(f->ctx, KN_EUNDEFINED, "%s: no tangent at %g", call, at[0]);
    double along = kn_construct_dot(f->up, t);
    for (int c = 0; c < 3; c++) b[c] = f->up[c] - along * t[c];
    if (!(sqrt(kn_construct_dot(b, b)) > 1e-8) || !kn_construct_normalize(b, b)) // else b has no correct digits
        return kn_fail(f->ctx, KN_EUNDEFINED, "%s: the tangent at %g is parallel to up", call, at[0]);
    kn_construct_cross(n, b, t);
    for (int r = 0; r < 3; r++) value[3 * r] = n[r], value[3 * r + 1] = b[r], value[3 * r + 2] = t[r];
    return KN_OK;
}

static kn_status check(kn_ctx *ctx, const kn_spline *p, const kn_spline *t, const double up[3], double tolerance)
{
    kn_status status = kn_spline_expect(ctx, call, p, 0);
    if (status == KN_OK) status = kn_spline_expect(ctx, call, t, 0);
    if (status == KN_OK) status = kn_construct_finite(ctx, call, up, 3);
    if (status != KN_OK) return status;
    if (kn_spline_dim(p) != 3 || kn_spline_dim(t) != 3 || t->nvars != 1 || !(tolerance > 0.0))
        return kn_fail(ctx, KN_EDOMAIN, "%s: dimensions %d and %d, a trajectory of %d variables, tolerance %g", call,
                       kn_spline_dim(p), kn_spline_dim(t), t->nvars, tolerance);
    return KN_OK;
}

// The largest distance of a control point from the origin.
static kn_status profile_size(kn_ctx *ctx, double *size, const kn_spline *p)
{
    size_t n = kn_spline_count(p);
    *size = 0.0;
    for (size_t i = 0; i < n; i++) {
        double w = p->rational ? p->coef[3 * n + i] : 1.0, x[3];
        if (!(w > 0.0)) return kn_fail(ctx, KN_EDOMAIN, "%s: a weight of %g", call, w);
        for (size_t c = 0; c < 3; c++) x[c] = p->coef[c * n + i] / w;
        *size = fmax(*size, sqrt(kn_construct_dot(x, x)));
    }
    return isfinite(*size) ? KN_OK : kn_fail(ctx, KN_EDOMAIN, "%s: a control point is not finite", call);
}

// m becomes w M where the trajectory has the weight w.
static kn_status times_weight(kn_ctx *ctx, kn_spline *m, const kn_spline *t)
{
    if (!t->rational) return KN_OK;
    kn_spline w = {0};
    kn_status status = kn_spline_components(ctx, &w, t, 3, 1);
    if (status == KN_OK) status = kn_spline_product(ctx, m, m, &w);
    kn_spline_clear(ctx, &w);
    return status;
}

// (T + w M P/p) / w = (T p + (w M) P) / (w p), t and m on one grid.
static void place(kn_spline *s, const kn_spline *p, const kn_spline *t, const kn_spline *m)
{
    size_t np = kn_spline_count(p), nt = kn_spline_count(t);
    double *to = s->coef;
    for (size_t c = 0; c < (size_t)s->ncomp; c++)
        for (size_t i = 0; i < np; i++)
            for (size_t j = 0; j < nt; j++, to++) {
                double wp = p->rational ? p->coef[3 * np + i] : 1.0, sum;
                if (c == 3) {
                    *to = wp * (t->rational ? t->coef[3 * nt + j] : 1.0);
                    continue;
                }
                sum = t->coef[c * nt + j] * wp;
                for (size_t k = 0; k < 3; k++) sum += m->coef[(3 * c + k) * nt + j] * p->coef[k * np + i];
                *to = sum;
            }
}

static kn_status assemble(kn_ctx *ctx, kn_spline *out, const kn_spline *p, const kn_spline *t, const kn_spline *m)
{
    kn_spline grid[2] = {*t, *m}, s, shape = *p;
    kn_status status = kn_construct_unite(ctx, call, grid, (const int[]){0, 0}, 2, 1);
    if (status != KN_OK) return status;
    shape.rational = p->rational || t->rational, shape.ncomp = 3 + shape.rational;
    status = kn_construct_extend(ctx, call, &s, &shape, grid[0].degree[0], grid[0].count[0]);
    if (status != KN_OK) return status;
    for (int i = 0; i <= grid[0].count[0] + grid[0].degree[0]; i++) s.knots[p->nvars][i] = grid[0].knots[0][i];
    place(&s, p, &grid[0], &grid[1]);
    return kn_spline_store(ctx, out, &s);
}

kn_status kn_construct_swept_frame(kn_ctx *ctx, kn_spline *out, double *estimate, const kn_spline *profile,
                                   const kn_spline *trajectory, const double up[3], double tolerance)
{
    double size, found, lo, hi;
    kn_status status = check(ctx, profile, trajectory, up, tolerance);
    if (status == KN_OK) status = profile_size(ctx, &size, profile);
    if (status != KN_OK) return status;
    frame f = {.ctx = ctx, .trajectory = trajectory};
    if (!kn_construct_normalize(f.up, up)) return kn_fail(ctx, KN_EUNDEFINED, "%s: up is zero", call);
    kn_spline m = {0};
    kn_spline_domain(trajectory, 0, &lo, &hi);
    status = kn_fit_to_tolerance(ctx, &m, &found, 1, 9, (const int[]){3}, &lo, &hi, frame_at, &f,
                                 size > 0.0 ? tolerance / size : 1.0, 0);
    if (status == KN_OK) status = times_weight(ctx, &m, trajectory);
    kn_mark mark = kn_scratch_mark(ctx);
    if (status == KN_OK) status = assemble(ctx, out, profile, trajectory, &m);
    if (status == KN_OK && estimate) *estimate = found * size;
    kn_scratch_release(ctx, mark);
    kn_spline_clear(ctx, &m);
    return status;
}
