// SPDX-License-Identifier: Apache-2.0
// The face nearest to a point.
#include "cad/near.h"
#include "kernel/context.h"

#include <math.h>

static double apart(const double *a, const double *b)
{
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

// From the point to the box of control points: no more than the distance.
static kn_status box_distance(kn_ctx *ctx, double *out, const kn_spline *s, const double *point)
{
    double lo[3], hi[3], d[3];
    kn_status status = kn_spline_box(ctx, lo, hi, s);
    for (int c = 0; c < 3; c++) d[c] = fmax(0.0, fmax(lo[c] - point[c], point[c] - hi[c]));
    *out = hypot(hypot(d[0], d[1]), d[2]);
    return status;
}

// What is looked at: a face and a point, and the nearest so far.
typedef struct look {
    kn_ctx *ctx;
    const kn_cad_face *face;
    const double *point;
    double nearest;
} look;

static kn_status distance_at(look *k, const double square[2], double *out)
{
    const kn_spline *s = &k->face->surface;
    double at[2], p[3];
    for (int d = 0; d < 2; d++) {
        double lo, hi;
        kn_spline_domain(s, d, &lo, &hi);
        at[d] = lo + square[d] * (hi - lo);
    }
    kn_status status = kn_spline_eval(k->ctx, p, s, at);
    if (status == KN_OK) *out = apart(p, k->point);
    return status;
}

static kn_status distance_along(look *k, const kn_spline *curve, double t, double *out)
{
    double square[2];
    kn_status status = kn_spline_eval(k->ctx, square, curve, &t);
    return status == KN_OK ? distance_at(k, square, out) : status;
}

// One span of a curve: the nearest of 64 places, and golden sections about it.
static kn_status look_along(look *k, const kn_spline *curve, double lo, double hi)
{
    enum { STEPS = 64, SECTIONS = 40 };
    const double golden = 0.61803398874989485;
    double best = INFINITY, place = lo, step = (hi - lo) / STEPS;
    kn_status status = KN_OK;
    for (int i = 0; status == KN_OK && i <= STEPS; i++) {
        double d = INFINITY, t = i < STEPS ? lo + i * step : hi;
        status = distance_along(k, curve, t, &d);
        if (d < best) best = d, place = t;
    }
    double a = fmax(lo, place - step), b = fmin(hi, place + step);
    for (int i = 0; status == KN_OK && i < SECTIONS; i++) {
        double x = b - golden * (b - a), y = a + golden * (b - a), dx = INFINITY, dy = INFINITY;
        status = distance_along(k, curve, x, &dx);
        if (status == KN_OK) status = distance_along(k, curve, y, &dy);
        if (dx < dy)
            b = y;
        else
            a = x;
        best = fmin(best, fmin(dx, dy));
    }
    k->nearest = fmin(k->nearest, best);
    return status;
}

static kn_status look_around(look *k)
{
    const kn_trim *trim = &k->face->trim;
    kn_status status = KN_OK;
    for (int i = 0; status == KN_OK && i < trim->ncurves; i++) {
        const kn_spline *c = &trim->curves[i];
        for (int j = c->degree[0]; status == KN_OK && j < c->count[0]; j++)
            if (c->knots[0][j] < c->knots[0][j + 1]) status = look_along(k, c, c->knots[0][j], c->knots[0][j + 1]);
    }
    return status;
}

static kn_status look_inside(look *k)
{
    enum { GRID = 33 };
    kn_status status = KN_OK;
    for (int i = 0; status == KN_OK && i < GRID * GRID; i++) {
        double d = INFINITY, square[2] = {(i / GRID) / (GRID - 1.0), (i % GRID) / (GRID - 1.0)};
        status = distance_at(k, square, &d);
        if (status != KN_OK || !(d < k->nearest)) continue;
        kn_answer inside = KN_NO;
        status = kn_trim_contains(k->ctx, &inside, &k->face->trim, square);
        if (inside == KN_YES) k->nearest = d;
    }
    return status;
}

// Of the face whole, and where its nearest point lies in the trim: certified. *done: it does.
static kn_status look_at_surface(look *k, bool *done)
{
    const kn_spline *s = &k->face->surface;
    kn_closest *all = NULL;
    size_t n = 0;
    kn_solve_report report;
    const kn_solve_options options = kn_solve_defaults();
    kn_status status = kn_solve_closest(k->ctx, &all, &n, NULL, &report, s, k->point, &options);
    for (size_t i = 0; status == KN_OK && !*done && i < n; i++) {
        double square[2];
        kn_answer inside = k->face->whole ? KN_YES : KN_NO;
        for (int d = 0; d < 2; d++) {
            double lo, hi;
            kn_spline_domain(s, d, &lo, &hi);
            square[d] = (all[i].at[d] - lo) / (hi - lo);
        }
        if (!k->face->whole) status = kn_trim_contains(k->ctx, &inside, &k->face->trim, square);
        *done = inside != KN_NO;
        if (*done) k->nearest = all[i].distance;
    }
    kn_free(k->ctx, all);
    return status;
}

kn_status kn_cad_nearest(kn_ctx *ctx, int *face, const kn_cad *cad, const bool *among, const double point[3])
{
    double nearest = INFINITY;
    kn_status status = KN_OK;
    for (int i = 0; status == KN_OK && i < cad->nfaces; i++) {
        look k = {.ctx = ctx, .face = &cad->faces[i], .point = point, .nearest = INFINITY};
        double least = 0.0;
        bool done = false;
        if (!among[i]) continue;
        status = kn_progress(ctx, "near", (double)i / cad->nfaces);
        if (status == KN_OK) status = box_distance(ctx, &least, &k.face->surface, point);
        if (status != KN_OK || least >= nearest) continue;
        status = look_at_surface(&k, &done);
        if (status == KN_OK && !done) status = look_around(&k);
        if (status == KN_OK && !done) status = look_inside(&k);
        if (status == KN_OK && k.nearest < nearest) nearest = k.nearest, *face = i;
    }
    return status;
}
