// SPDX-License-Identifier: Apache-2.0
// Whether two faces meet smoothly along a whole side of both, with matching parameter lines.
#include "cad/join.h"
#include "kernel/context.h"

#include <math.h>

// In the square of a trim: what lies on a side.
static const double on_side = 1e-7;

// The side of the square along all of which a curve of a trim runs; -1: none.
static int side_of(const kn_spline *curve)
{
    int n = curve->count[0];
    for (int v = 0; v < 2; v++) {
        const double *x = curve->coef + v * n, *y = curve->coef + (1 - v) * n;
        double from = fmin(y[0], y[n - 1]), to = fmax(y[0], y[n - 1]), end = round(x[0]);
        bool along = fabs(from) <= on_side && fabs(to - 1.0) <= on_side;
        for (int i = 0; along && i < n; i++) along = fabs(x[i] - end) <= on_side;
        if (along && (end == 0.0 || end == 1.0)) return 2 * v + (end == 1.0);
    }
    return -1;
}

kn_status kn_cad_side_curve(kn_ctx *ctx, kn_spline *out, const kn_spline *surface, int side)
{
    double lo, hi;
    kn_spline_domain(surface, side / 2, &lo, &hi);
    kn_status status = kn_spline_isoparametric(ctx, out, surface, side / 2, side % 2 == 0 ? lo : hi);
    return status == KN_OK ? kn_spline_reparameterize(ctx, out, out, 0, 0.0, 1.0) : status;
}

// Knots of b next to knots of a become those.
static void snap_knots(kn_spline *b, const kn_spline *a)
{
    int n = b->count[0] + b->degree[0] + 1, m = a->count[0] + a->degree[0] + 1;
    for (int i = 0; i < n; i++)
        for (int k = 0; k < m; k++)
            if (fabs(b->knots[0][i] - a->knots[0][k]) <= KN_CAD_SAME) b->knots[0][i] = a->knots[0][k];
}

// Whether two curves over [0,1] have the same control points, to `tol`, once their degrees and knots are the same.
static kn_status same_curve(kn_ctx *ctx, bool *same, const kn_spline *a, const kn_spline *b, double tol)
{
    kn_spline pair[2] = {{0}, {0}};
    kn_status status = kn_spline_copy(ctx, &pair[0], a);
    if (status == KN_OK) status = kn_spline_copy(ctx, &pair[1], b);
    if (status == KN_OK) snap_knots(&pair[1], &pair[0]);
    if (status == KN_OK) status = kn_spline_make_compatible(ctx, pair, 2);
    int n = status == KN_OK ? pair[0].count[0] : 0;
    double scale = 0.0;
    *same = status == KN_OK;
    for (int i = 0; i < n && *same; i++) {
        double w[2], square = 0.0;
        for (int k = 0; k < 2; k++) w[k] = pair[k].rational ? pair[k].coef[3 * n + i] : 1.0;
        if (i == 0) scale = w[1] / w[0];
        for (int c = 0; c < 3; c++) {
            double d = pair[0].coef[c * n + i] / w[0] - pair[1].coef[c * n + i] / w[1];
            square += d * d;
        }
        *same = sqrt(square) <= tol && fabs(w[1] / (w[0] * scale) - 1.0) <= KN_CAD_SAME;
    }
    kn_spline_clear(ctx, &pair[0]);
    kn_spline_clear(ctx, &pair[1]);
    return status;
}

static kn_status compare(kn_ctx *ctx, kn_cad_match *m, const kn_spline *const surface[2], double tol)
{
    kn_spline curve[2] = {{0}, {0}};
    bool same = false;
    kn_status status = KN_OK;
    for (int k = 0; status == KN_OK && k < 2; k++) status = kn_cad_side_curve(ctx, &curve[k], surface[k], m->side[k]);
    for (int way = 0; status == KN_OK && !same && way < 2; way++) {
        if (way == 1) status = kn_spline_reverse(ctx, &curve[1], &curve[1], 0);
        if (status == KN_OK) status = same_curve(ctx, &same, &curve[0], &curve[1], tol);
        m->reversed = way == 1;
    }
    if (status == KN_OK && !same) m->why = "parameter lines";
    kn_spline_clear(ctx, &curve[0]);
    kn_spline_clear(ctx, &curve[1]);
    return status;
}

// The unit normal of a surface at t along a side; *any: there is one.
static kn_status normal_at(kn_ctx *ctx, bool *any, double out[3], const kn_spline *s, int side, double t)
{
    double at[2], lo, hi, d[9], square = 0.0;
    kn_spline_domain(s, side / 2, &lo, &hi);
    at[side / 2] = side % 2 == 0 ? lo : hi;
    kn_spline_domain(s, 1 - side / 2, &lo, &hi);
    at[1 - side / 2] = lo + t * (hi - lo);
    kn_status status = kn_spline_derivatives(ctx, d, s, at, 1);
    if (status != KN_OK) return status;
    const double *u = d + 3 * kn_derivative_index(2, (const int[2]){1, 0});
    const double *v = d + 3 * kn_derivative_index(2, (const int[2]){0, 1});
    for (int c = 0; c < 3; c++) {
        out[c] = u[(c + 1) % 3] * v[(c + 2) % 3] - u[(c + 2) % 3] * v[(c + 1) % 3];
        square += out[c] * out[c];
    }
    *any = square > 0.0 && isfinite(square);
    for (int c = 0; c < 3 && *any; c++) out[c] /= sqrt(square);
    return KN_OK;
}

static kn_status measure(kn_ctx *ctx, kn_cad_match *m, const kn_spline *const surface[2])
{
    enum { PLACES = 33 };
    kn_status status = KN_OK;
    for (int i = 0; status == KN_OK && i < PLACES; i++) {
        double n[2][3], t = (double)i / (PLACES - 1), cross[3], dot = 0.0, square = 0.0;
        bool any[2] = {false, false};
        for (int k = 0; status == KN_OK && k < 2; k++)
            status = normal_at(ctx, &any[k], n[k], surface[k], m->side[k], k == 1 && m->reversed ? 1.0 - t : t);
        if (status != KN_OK || !any[0] || !any[1]) continue;
        for (int c = 0; c < 3; c++) {
            cross[c] = n[0][(c + 1) % 3] * n[1][(c + 2) % 3] - n[0][(c + 2) % 3] * n[1][(c + 1) % 3];
            dot += n[0][c] * n[1][c], square += cross[c] * cross[c];
        }
        m->angle = fmax(m->angle, atan2(sqrt(square), dot));
    }
    return status;
}

kn_status kn_cad_match_edge(kn_ctx *ctx, kn_cad_match *out, const kn_cad *cad, int edge,
                            const kn_cad_join_options *options)
{
    const kn_cad_edge *e = &cad->edges[edge];
    const kn_spline *surface[2];
    kn_cad_match m = {.angle = e->angle};
    for (int k = 0; k < 2; k++) {
        const kn_cad_face *f = &cad->faces[e->face[k]];
        surface[k] = &f->surface;
        m.side[k] = side_of(&f->trim.curves[e->curve[k]]);
    }
    m.why = options->none                    ? "not wanted"
            : e->more                        ? "more faces"
            : e->point                       ? "a point"
            : e->angle > options->angle      ? "angle"
            : m.side[0] < 0 || m.side[1] < 0 ? "part of a side"
                                             : NULL;
    kn_status status = m.why ? KN_OK : compare(ctx, &m, surface, options->tolerance);
    if (status == KN_OK && !m.why) status = measure(ctx, &m, surface);
    if (!m.why && m.angle > options->angle) m.why = "angle";
    if (status == KN_OK) *out = m;
    return status;
}
