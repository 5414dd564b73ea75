// SPDX-License-Identifier: Apache-2.0
// The contours of one Bezier patch P = X / W: zero curves of f = Z - c W.
//
// A polyline q_0, q_1, .. in the parameter plane whose chords are within d of the zero curve and not longer than l
// gives points P(q_i) in space. The true contour lies within L d of P(chord), L = max |P_r| + max |P_t|, and P(chord)
// within M l^2 / 8 of the straight line between its ends, M = max |P_rr| + 2 max |P_rt| + max |P_tt|: both from
// coefficients. Each gets a quarter of the tolerance. Leaving points out gets what they and rounding leave.
//
// Of a trimmed patch the polyline is cut by the trim in the parameter plane. Its new ends are zeros of f along the
// trim, no farther than d from the chord that they end.
#include "slice/internal.h"

#include "bezier/norm_bound.h"
#include "kernel/bernstein.h"

#include <float.h>
#include <math.h>
#include <string.h>

// A patch ready to be cut.
typedef struct cutting {
    const kn_slice_options *options;
    const kn_patch_id *id;
    const kn_bezier *patch;
    bool reversed;
    const kn_outline *region; // NULL: all
    kn_slice_bounds bounds;
    kn_slice_edge edges[4];
    double near, longest; // in the parameter plane: d and l
} cutting;

// One plane of it.
typedef struct level {
    size_t plane, doubtful;
    double away;  // d with its rounding
    double error; // the largest of all lines
} level;

// At least the distance of p from the straight line between a and b.
static double off_line(const double *p, const double *a, const double *b)
{
    double dx = b[0] - a[0], dy = b[1] - a[1], px = p[0] - a[0], py = p[1] - a[1], l = dx * dx + dy * dy;
    double s = l > 0.0 ? fmin(fmax((px * dx + py * dy) / l, 0.0), 1.0) : 0.0; // any point of the line will do
    return hypot(px - s * dx, py - s * dy) + kn_gamma_up(8.0) * (fabs(px) + fabs(py) + fabs(dx) + fabs(dy));
}

// Adds those of points[from + 1 .. to] without which the line would leave them by more than tol (Ramer, Douglas and
// Peucker); the last one always. *most: how far it leaves them.
static kn_status add_thinned(kn_ctx *ctx, kn_slice_lines *out, double *most, const double *points, size_t from,
                             size_t to, double tol)
{
    size_t worst = from;
    double off = 0.0;
    for (size_t i = from + 1; i < to; i++) {
        double x = off_line(points + 2 * i, points + 2 * from, points + 2 * to);
        if (x > off) worst = i, off = x;
    }
    if (off <= tol) {
        *most = fmax(*most, off);
        return kn_slice_add_point(ctx, out, points[2 * to], points[2 * to + 1]);
    }
    kn_status status = add_thinned(ctx, out, most, points, from, worst, tol);
    return status == KN_OK ? add_thinned(ctx, out, most, points, worst, to, tol) : status;
}

// (x, y) of the patch at (r, t).
static void patch_point(double out[2], const kn_bezier *p, const double at[2])
{
    double b[2][KN_MAX_DEGREE + 1], line[KN_MAX_DEGREE + 1], sum[2][2];
    int n = p->degree[0], m = p->degree[1];
    size_t row = (size_t)m + 1, all = row * ((size_t)n + 1);
    for (int d = 0; d < 2; d++) kn_bernstein_basis(b[d], p->degree[d], at[d]);
    for (int c = 0; c < (p->rational ? 3 : 2); c++) {
        const double *from = p->coef + (c == 2 ? 3 : (size_t)c) * all;
        for (int j = 0; j <= m; j++) line[j] = b[0][0] * from[j];
        for (int i = 1; i <= n; i++)
            for (int j = 0; j <= m; j++) line[j] += b[0][i] * from[(size_t)i * row + (size_t)j];
        double *to = &sum[c / 2][c % 2];
        kn_bernstein_contract(to, line, 1, m + 1, 1, b[1]);
    }
    for (int c = 0; c < 2; c++) out[c] = p->rational ? sum[0][c] / sum[1][0] : sum[0][c];
}

// The points P(q_i) in the direction of the contour. The ends are those of edges; cut: they are not.
static void find_points(double *points, bool cut[2], const cutting *c, const kn_solve_curve *curve)
{
    size_t n = curve->npoints;
    for (size_t k = 0; k < n; k++) {
        double *to = points + 2 * (c->reversed ? n - 1 - k : k);
        bool end = !curve->closed && (k == 0 || k + 1 == n);
        if (end && kn_slice_known_point(to, c->edges, curve->points + 2 * k)) continue;
        if (end) cut[(k > 0) != c->reversed] = true;
        patch_point(to, c->patch, curve->points + 2 * k);
    }
    if (curve->closed) memcpy(points + 2 * n - 2, points, 2 * sizeof *points);
}

// The square of the longest chord's length.
static double longest_chord(const kn_solve_curve *curve)
{
    double most = 0.0;
    for (size_t i = 1; i < curve->npoints; i++) {
        const double *p = curve->points + 2 * i - 2;
        double x = p[2] - p[0], y = p[3] - p[1];
        most = fmax(most, x * x + y * y);
    }
    return most;
}

// Of a closed curve two points stay.
static kn_status add_curve(kn_ctx *ctx, kn_slice_lines *out, level *l, const cutting *c, const kn_solve_curve *curve)
{
    size_t n = curve->npoints;
    bool cut[2] = {false, false};
    kn_mark mark = kn_scratch_mark(ctx);
    double *points = kn_scratch(ctx, 2 * n, sizeof *points), most = 0.0, tol = c->options->tol;
    kn_status status = points ? KN_OK : KN_ENOMEM;
    if (points) find_points(points, cut, c, curve);
    double spent = kn_round_up(c->bounds.first * l->away + c->bounds.second * longest_chord(curve) / 8.0 +
                               c->bounds.value);
    double left = fmax(0.99 * tol - spent, tol / 16.0);
    if (status == KN_OK) status = kn_slice_begin_line(ctx, out, l->plane, c->id);
    if (status == KN_OK) memcpy(out->list[out->nlines - 1].cut, cut, sizeof cut);
    if (status == KN_OK) status = kn_slice_add_point(ctx, out, points[0], points[1]);
    if (status == KN_OK) status = add_thinned(ctx, out, &most, points, 0, curve->closed ? n / 2 : n - 1, left);
    if (status == KN_OK && curve->closed) status = add_thinned(ctx, out, &most, points, n / 2, n - 1, left);
    l->error = fmax(l->error, kn_round_up(spent + most));
    l->doubtful += !(spent + most <= tol);
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status add_clipped(kn_ctx *ctx, kn_slice_lines *out, level *l, const cutting *c, const kn_bezier *f,
                             const kn_solve_curve *curve)
{
    if (!c->region) return add_curve(ctx, out, l, c, curve);
    kn_solve_curve *runs = NULL;
    size_t n = 0;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_slice_clip(ctx, &runs, &n, c->region, curve, f, c->near);
    for (size_t i = 0; status == KN_OK && i < n; i++) status = add_curve(ctx, out, l, c, &runs[i]);
    kn_scratch_release(ctx, mark);
    return status;
}

// f = Z - z W (scratch). *error: of a coefficient, a product and a difference.
static kn_status take_function(kn_ctx *ctx, kn_bezier *f, double *error, const kn_bezier *p, double z)
{
    size_t n = kn_bezier_count(p);
    *f = (kn_bezier){.nvars = 2, .ncomp = 1, .degree = {p->degree[0], p->degree[1]}};
    f->coef = kn_scratch(ctx, n, sizeof *f->coef);
    if (!f->coef) return KN_ENOMEM;
    double most = 0.0;
    for (size_t i = 0; i < n; i++) {
        double plane = z * (p->rational ? p->coef[3 * n + i] : 1.0);
        f->coef[i] = p->coef[2 * n + i] - plane;
        most = fmax(most, fabs(f->coef[i]) + (p->rational ? fabs(plane) : 0.0));
    }
    *error = kn_round_up(kn_gamma_up(1.0) * most) + DBL_MIN;
    return KN_OK;
}

static kn_status cut_plane(kn_ctx *ctx, kn_slice_lines *out, size_t plane, cutting *c)
{
    level l = {.plane = plane};
    double z = kn_slice_height(c->options, plane), distance = 0.0;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_trace_options o = {.tol = c->near, .longest = c->longest};
    kn_bezier f;
    kn_status status = take_function(ctx, &f, &o.error, c->patch, z);
    for (int k = 0; status == KN_OK && k < 4; k++)
        status = kn_slice_cut_edge(ctx, &c->edges[k], &l.doubtful, z, c->patch->rational);
    kn_sign_changes sides[4];
    for (int k = 0; k < 4; k++) sides[k] = c->edges[k].changes;
    o.edges = sides;
    kn_solve_curve *curves = NULL;
    size_t n = 0;
    kn_solve_report report = {0};
    if (status == KN_OK) status = kn_solve_trace(ctx, &curves, &n, &report, &distance, &f, &o);
    l.doubtful += report.possible + report.limited;
    l.away = distance + (c->region ? c->near : 0.0);
    for (size_t i = 0; status == KN_OK && i < n; i++) status = add_clipped(ctx, out, &l, c, &f, &curves[i]);
    kn_free(ctx, curves);
    kn_scratch_release(ctx, mark);
    return status == KN_OK ? kn_slice_add_note(ctx, out, plane, l.doubtful, l.error) : status;
}

// Heights of control points, and that weights are positive.
static kn_status find_range(kn_ctx *ctx, double *lo, double *hi, const kn_bezier *p, const kn_patch_id *id)
{
    size_t n = kn_bezier_count(p);
    *lo = INFINITY, *hi = -INFINITY;
    for (size_t i = 0; i < n; i++) {
        double w = p->rational ? p->coef[3 * n + i] : 1.0, z = p->coef[2 * n + i] / w;
        if (!(w > 0.0) || !isfinite(z))
            return kn_fail(ctx, KN_EUNDEFINED, "slice: surface %d, cell %d,%d: control point %zu has weight %g",
                           id->surface, id->cell[0], id->cell[1], i, w);
        *lo = fmin(*lo, z);
        *hi = fmax(*hi, z);
    }
    return KN_OK;
}

kn_status kn_slice_patch(kn_ctx *ctx, kn_slice_lines *out, const kn_slice_window *window, const kn_patch_id *id,
                         const kn_bezier *p, const kn_trim *trim, bool reversed)
{
    size_t from = 0, to = 0;
    double lo, hi;
    kn_status status = find_range(ctx, &lo, &hi, p, id);
    if (status == KN_OK) kn_slice_planes(window, lo, hi, &from, &to);
    if (from == to) return status;
    cutting c = {.options = &window->options, .id = id, .patch = p, .reversed = reversed};
    kn_outline region = {0};
    status = kn_slice_find_bounds(ctx, &c.bounds, p);
    if (status == KN_OK && !(isfinite(c.bounds.first) && isfinite(c.bounds.second)))
        status = kn_fail(ctx, KN_EUNDEFINED, "slice: surface %d, cell %d,%d is beyond double precision", id->surface,
                         id->cell[0], id->cell[1]);
    c.near = fmin(0.5, c.options->tol / ((trim ? 8.0 : 4.0) * c.bounds.first));
    c.longest = sqrt(2.0 * c.options->tol / c.bounds.second);
    if (status == KN_OK && trim && trim->nloops > 0) {
        c.region = &region;
        status = kn_slice_outline(ctx, &region, trim, c.near);
    }
    for (int k = 0; k < 4; k++) kn_slice_take_edge(&c.edges[k], p, k);
    for (size_t plane = from; status == KN_OK && plane < to; plane++) status = cut_plane(ctx, out, plane, &c);
    for (int k = 0; k < 4; k++) kn_free(ctx, c.edges[k].changes.list);
    kn_outline_clear(ctx, &region);
    return status;
}
