// SPDX-License-Identifier: Apache-2.0
// The contours of one Bezier patch P = X / W: zero curves of f = Z - c W.
//
// A polyline q_0, q_1, .. in the parameter plane whose chords are within d of the zero curve and not longer than l
// gives points P(q_i) in space. The true contour lies within L d of P(chord), L = max |P_r| + max |P_t|, and P(chord)
// within M l^2 / 8 of the straight line between its ends, M = max |P_rr| + 2 max |P_rt| + max |P_tt|: both from
// coefficients. Each gets half of the tolerance.
#include "slice/internal.h"

#include "bezier/norm_bound.h"
#include "kernel/bernstein.h"
#include "solve/curves.h"

#include <float.h>
#include <math.h>
#include <string.h>

// ---- bounds ----

typedef struct bounds {
    double first, second; // L and M of (x, y)
} bounds;

// (x - cx w, y - cy w, w) as one polynomial: c the patch's first corner.
static kn_status centred(kn_ctx *ctx, kn_bezier *out, double *least_weight, const kn_bezier *p)
{
    size_t n = kn_bezier_count(p);
    kn_status status = kn_bezier_init(ctx, out, 2, 3, false, p->degree);
    if (status != KN_OK) return status;
    const double *w = p->rational ? p->coef + 3 * n : NULL;
    double c[2] = {p->coef[0] / (w ? w[0] : 1.0), p->coef[n] / (w ? w[0] : 1.0)};
    *least_weight = INFINITY;
    for (size_t i = 0; i < n; i++) {
        double weight = w ? w[i] : 1.0;
        for (size_t d = 0; d < 2; d++) out->coef[d * n + i] = p->coef[d * n + i] - c[d] * weight;
        out->coef[2 * n + i] = weight;
        *least_weight = fmin(*least_weight, weight);
    }
    return KN_OK;
}

// Derivatives of X / W in terms of those of X and W: P_a = (X_a - W_a P) / W, and
// P_ab = (X_ab - W_a P_b - W_b P_a - W_ab P) / W.
static kn_status find_bounds(kn_ctx *ctx, bounds *out, const kn_bezier *p)
{
    enum { ALL, R, T, RR, RT, TT, N };
    kn_bezier d[N] = {{0}};
    double w, x[N], v[N];
    kn_status status = centred(ctx, &d[ALL], &w, p);
    for (int k = R; status == KN_OK && k < N; k++)
        status = kn_bezier_derivative(ctx, &d[k], &d[k <= T ? ALL : k == TT ? T : R], k == T || k == RT || k == TT);
    for (int k = 0; status == KN_OK && k < N; k++)
        x[k] = kn_largest_vector(&d[k], 0, 2), v[k] = kn_largest_vector(&d[k], 2, 1);
    if (status == KN_OK) {
        double at = x[ALL] / w, first[2] = {(x[R] + v[R] * at) / w, (x[T] + v[T] * at) / w};
        double rr = (x[RR] + 2.0 * v[R] * first[0] + v[RR] * at) / w;
        double rt = (x[RT] + v[R] * first[1] + v[T] * first[0] + v[RT] * at) / w;
        double tt = (x[TT] + 2.0 * v[T] * first[1] + v[TT] * at) / w;
        *out = (bounds){first[0] + first[1], rr + 2.0 * rt + tt};
    }
    for (int k = 0; k < N; k++) kn_bezier_clear(ctx, &d[k]);
    return status;
}

// ---- edges ----

// An edge in the direction that does not depend on the patch it is taken from: the one in which its control points
// come first in lexicographic order.
typedef struct edge {
    int degree;
    bool reversed;
    double coef[4][KN_MAX_DEGREE + 1], f[KN_MAX_DEGREE + 1];
    kn_sign_changes changes; // in the patch's direction
    double (*points)[2];     // of each change
} edge;

// Sides as kn_solve_trace has them.
static void take_edge(edge *e, const kn_bezier *p, int side)
{
    size_t n = kn_bezier_count(p), row = (size_t)p->degree[1] + 1;
    bool along_t = side < 2;
    size_t start = side == 1 ? (size_t)p->degree[0] * row : side == 3 ? row - 1 : 0, step = along_t ? 1 : row;
    e->degree = p->degree[along_t ? 1 : 0];
    e->reversed = false;
    int order = 0;
    for (int i = 0; order == 0 && 2 * i < e->degree; i++)
        for (int c = 0; order == 0 && c < p->ncomp; c++) {
            double a = p->coef[(size_t)c * n + start + (size_t)i * step];
            double b = p->coef[(size_t)c * n + start + (size_t)(e->degree - i) * step];
            order = (a > b) - (a < b);
        }
    e->reversed = order > 0;
    for (int c = 0; c < p->ncomp; c++)
        for (int i = 0; i <= e->degree; i++) {
            int from = e->reversed ? e->degree - i : i;
            e->coef[c][i] = p->coef[(size_t)c * n + start + (size_t)from * step];
        }
}

static void edge_point(double out[2], const edge *e, double t, bool rational)
{
    double basis[KN_MAX_DEGREE + 1], w = 1.0;
    size_t m = (size_t)e->degree + 1;
    kn_bernstein_basis(basis, e->degree, t);
    if (rational) kn_bernstein_contract(&w, e->coef[3], 1, (int)m, 1, basis);
    for (int c = 0; c < 2; c++) {
        kn_bernstein_contract(&out[c], e->coef[c], 1, (int)m, 1, basis);
        out[c] /= w;
    }
}

// Where the edge goes through the plane, and the points there.
static kn_status cut_edge(kn_ctx *ctx, edge *e, size_t *doubtful, double z, bool rational)
{
    for (int i = 0; i <= e->degree; i++) e->f[i] = e->coef[2][i] - z * (rational ? e->coef[3][i] : 1.0);
    e->changes.count = 0;
    kn_status status = kn_solve_sign_changes(ctx, &e->changes, doubtful, e->f, e->degree);
    size_t n = e->changes.count;
    if (status != KN_OK || n == 0) return status;
    e->points = kn_scratch(ctx, n, sizeof *e->points);
    if (!e->points) return KN_ENOMEM;
    for (size_t i = 0; i < n; i++) edge_point(e->points[i], e, e->changes.list[i].at, rational);
    for (size_t i = 0, j = n; e->reversed && i < j--; i++) {
        kn_sign_change a = e->changes.list[i], b = e->changes.list[j];
        double p[2];
        memcpy(p, e->points[i], sizeof p);
        memcpy(e->points[i], e->points[j], sizeof p);
        memcpy(e->points[j], p, sizeof p);
        e->changes.list[i] = (kn_sign_change){1.0 - b.at, !b.rise};
        e->changes.list[j] = (kn_sign_change){1.0 - a.at, !a.rise};
    }
    return KN_OK;
}

// The point of the edge that the end of a curve lies on; false: none, it is inside.
static bool known_point(double out[2], const edge *edges, const double at[2])
{
    for (int side = 0; side < 4; side++) {
        if (at[side / 2] != (double)(side % 2)) continue;
        for (size_t i = 0; i < edges[side].changes.count; i++)
            if (edges[side].changes.list[i].at == at[1 - side / 2]) {
                memcpy(out, edges[side].points[i], 2 * sizeof *out);
                return true;
            }
    }
    return false;
}

// ---- contours ----

static double off_line(const double *p, const double *a, const double *b)
{
    double dx = b[0] - a[0], dy = b[1] - a[1], l = dx * dx + dy * dy;
    double s = l > 0.0 ? fmin(fmax(((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / l, 0.0), 1.0) : 0.0;
    return hypot(p[0] - a[0] - s * dx, p[1] - a[1] - s * dy);
}

// Adds those of points[from + 1 .. to] without which the line would leave them by more than tol (Ramer, Douglas and
// Peucker); the last one always.
static kn_status add_thinned(kn_ctx *ctx, kn_slice_lines *out, const double *points, size_t from, size_t to,
                             double tol)
{
    size_t worst = from;
    double most = tol;
    for (size_t i = from + 1; i < to; i++) {
        double off = off_line(points + 2 * i, points + 2 * from, points + 2 * to);
        if (off > most) worst = i, most = off;
    }
    if (worst == from) return kn_slice_add_point(ctx, out, points[2 * to], points[2 * to + 1]);
    kn_status status = add_thinned(ctx, out, points, from, worst, tol);
    return status == KN_OK ? add_thinned(ctx, out, points, worst, to, tol) : status;
}

// Of a closed curve two points stay.
static kn_status add_curve(kn_ctx *ctx, kn_slice_lines *out, const kn_slice_options *o, size_t plane,
                           const kn_patch_id *id, const kn_bezier *p, const kn_solve_curve *curve, const edge *edges,
                           bool reversed)
{
    size_t n = curve->npoints;
    kn_mark mark = kn_scratch_mark(ctx);
    double *points = kn_scratch(ctx, 2 * n, sizeof *points);
    kn_status status = points ? kn_slice_begin_line(ctx, out, plane, id) : KN_ENOMEM;
    for (size_t k = 0; status == KN_OK && k < n; k++) {
        size_t i = reversed ? n - 1 - k : k;
        const double *at = curve->points + 2 * i;
        bool end = !curve->closed && (i == 0 || i + 1 == n);
        double point[3];
        if (!end || !known_point(point, edges, at)) status = kn_bezier_eval(ctx, point, p, at);
        points[2 * k] = point[0], points[2 * k + 1] = point[1];
    }
    double tol = o->tol / 2.0;
    if (status == KN_OK) status = kn_slice_add_point(ctx, out, points[0], points[1]);
    if (status == KN_OK) status = add_thinned(ctx, out, points, 0, curve->closed ? n / 2 : n - 1, tol);
    if (status == KN_OK && curve->closed) status = add_thinned(ctx, out, points, n / 2, n - 1, tol);
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status cut(kn_ctx *ctx, kn_slice_lines *out, const kn_slice_options *o, size_t plane, const kn_patch_id *id,
                     const kn_bezier *p, edge *edges, const bounds *b, bool reversed)
{
    size_t n = kn_bezier_count(p), ncurves = 0;
    double z = kn_slice_height(o, plane);
    kn_mark mark = kn_scratch_mark(ctx);
    kn_bezier f = {.nvars = 2, .ncomp = 1, .degree = {p->degree[0], p->degree[1]}};
    f.coef = kn_scratch(ctx, n, sizeof *f.coef);
    kn_status status = f.coef ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < n; i++)
        f.coef[i] = p->coef[2 * n + i] - z * (p->rational ? p->coef[3 * n + i] : 1.0);
    for (int k = 0; status == KN_OK && k < 4; k++) status = cut_edge(ctx, &edges[k], &out->doubtful, z, p->rational);
    kn_sign_changes sides[4];
    for (int k = 0; k < 4; k++) sides[k] = edges[k].changes;
    kn_solve_curve *curves = NULL;
    kn_solve_report report;
    double near = fmin(0.5, o->tol / (4.0 * b->first)), longest = sqrt(2.0 * o->tol / b->second);
    if (status == KN_OK) status = kn_solve_trace(ctx, &curves, &ncurves, &report, &f, near, longest, sides);
    if (status == KN_OK) out->doubtful += report.possible + report.limited;
    for (size_t i = 0; status == KN_OK && i < ncurves; i++)
        status = add_curve(ctx, out, o, plane, id, p, &curves[i], edges, reversed);
    kn_free(ctx, curves);
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_slice_patch(kn_ctx *ctx, kn_slice_lines *out, const kn_slice_window *window, const kn_patch_id *id,
                         const kn_bezier *p, bool reversed)
{
    size_t n = kn_bezier_count(p), from, to;
    double lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; i < n; i++) {
        double w = p->rational ? p->coef[3 * n + i] : 1.0, z = p->coef[2 * n + i] / w;
        if (!(w > 0.0) || !isfinite(z))
            return kn_fail(ctx, KN_EUNDEFINED, "slice: surface %d, cell %d,%d: control point %zu has weight %g",
                           id->surface, id->cell[0], id->cell[1], i, w);
        lo = fmin(lo, z);
        hi = fmax(hi, z);
    }
    kn_slice_planes(window, lo, hi, &from, &to);
    if (from == to) return KN_OK;
    bounds b = {0};
    edge edges[4] = {{0}};
    kn_status status = find_bounds(ctx, &b, p);
    if (status == KN_OK && !(isfinite(b.first) && isfinite(b.second)))
        status = kn_fail(ctx, KN_EUNDEFINED, "slice: surface %d, cell %d,%d is beyond double precision", id->surface,
                         id->cell[0], id->cell[1]);
    b.first = fmax(b.first, DBL_MIN), b.second = fmax(b.second, DBL_MIN);
    for (int k = 0; k < 4; k++) take_edge(&edges[k], p, k);
    for (size_t plane = from; status == KN_OK && plane < to; plane++)
        status = cut(ctx, out, &window->options, plane, id, p, edges, &b, reversed);
    for (int k = 0; k < 4; k++) kn_free(ctx, edges[k].changes.list);
    return status;
}
