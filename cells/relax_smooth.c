// SPDX-License-Identifier: Apache-2.0
// A smooth map through the corners: bicubic, C2 but where S has a kink, certified to have no fold.
#include "cells/relax.h"
#include "kernel/context.h"

#include "bezier/norm_bound.h"

#include <knurl/fit.h>
#include <knurl/solve.h>
#include <math.h>
#include <string.h>

// Cells that a closed variable goes on for, at each end: the other end counts 0.27^20 of itself at the seam.
enum { WRAP = 20, DEPTH = 12, LINEAR = -1 };

// ---- interpolation ----

// One variable: cubic pieces over runs of lines between kinks, C0 at kinks and C2 elsewhere. A run of m >= 3 cells is
// interpolated at its m + 1 lines and has no knot at the first and last one inside; a shorter one at thirds, the
// values there being those of the polynomial of degree m through its lines. Where such cubics overshoot: the bilinear map's
// values at Greville's sites, knots at all lines, are taken for the control points. They then lie near the corners
// only, but increase with them (Schoenberg).
typedef struct axis {
    int wrap, count;
    double *knots, *site;
    int *first;    // the line where the run of a site begins, and its cells (a short one); 0: the site is a line,
    int *run;      // LINEAR: it lies between that line and the next
    bool *is_knot; // of lines 0 .. n
} axis;

// Line i, which may lie beyond the ends of a closed variable: its place among 0 .. n, and how many periods it is off.
static int wrapped(int *periods, int i, int n)
{
    *periods = i < 0 ? -((n - 1 - i) / n) : i > n ? (i - 1) / n : 0;
    return i - *periods * n;
}

// The sites of a run of lines from .. to, but for the last one.
static void run_sites(axis *a, int from, int to)
{
    int m = to - from, sites = m < 3 ? 3 : m;
    for (int i = 0; i < sites; i++, a->count++) {
        a->site[a->count] = m < 3 ? from + i * m / 3.0 : from + i;
        a->first[a->count] = m < 3 ? from : from + i, a->run[a->count] = m < 3 && i > 0 ? m : 0;
    }
}

static kn_status net_sites(kn_ctx *ctx, axis *a, int nknots)
{
    a->count = nknots - 4;
    kn_status status = kn_fit_greville(ctx, a->site, a->knots, 3, a->count);
    for (int i = 0; status == KN_OK && i < a->count; i++) {
        a->first[i] = (int)floor(a->site[i]);
        a->run[i] = a->site[i] == a->first[i] ? 0 : LINEAR;
    }
    return status;
}

static kn_status axis_init(kn_ctx *ctx, axis *a, const kn_corner_grid *g, int d, bool net)
{
    int n = g->n[d], periods, k = 0;
    const char *held = g->held[d];
    *a = (axis){.wrap = g->closed[d] && held[0] != KN_LINE_KINK ? WRAP : 0};
    size_t room = 3 * ((size_t)n + 2 * WRAP) + 8;
    a->knots = kn_scratch(ctx, 2 * room, sizeof *a->knots);
    a->first = kn_scratch(ctx, 2 * room, sizeof *a->first);
    a->is_knot = kn_scratch(ctx, (size_t)n + 1, sizeof *a->is_knot);
    if (!a->knots || !a->first || !a->is_knot) return KN_ENOMEM;
    a->site = a->knots + room, a->run = a->first + room;
    for (int i = 0; i < 4; i++) a->knots[k++] = -a->wrap;
    for (int from = -a->wrap, to, end = n + a->wrap, skip = net ? 1 : 2; from < end; from = to) {
        for (to = from + 1; to < end && held[wrapped(&periods, to, n)] != KN_LINE_KINK;) to++;
        run_sites(a, from, to);
        for (int i = from + skip; i <= to - skip; i++) a->knots[k++] = i;
        for (int i = 0; i < (to < end ? 3 : 4); i++) a->knots[k++] = to;
        if (to == end) a->site[a->count] = to, a->first[a->count] = to, a->run[a->count++] = 0;
    }
    for (int i = 0; i <= n; i++) a->is_knot[i] = i == 0 || i == n;
    for (int i = 0; i < k; i++)
        if (a->knots[i] >= 0 && a->knots[i] <= n) a->is_knot[(int)a->knots[i]] = true;
    return net ? net_sites(ctx, a, k) : KN_OK;
}

// The lines whose corners make the value at a site, and their weights: one of them, or a short run's.
static int behind(int line[3], double weight[3], const axis *a, int site)
{
    int m = a->run[site];
    line[0] = a->first[site], weight[0] = 1.0;
    if (m == 0) return 1;
    double x = a->site[site] - line[0];
    if (m == LINEAR) m = 1;
    for (int i = 0; i <= m; i++) {
        line[i] = line[0] + i, weight[i] = 1.0;
        for (int j = 0; j <= m; j++)
            if (j != i) weight[i] *= (x - j) / (i - j);
    }
    return m + 1;
}

static void gather(double *values, const kn_corner_grid *g, const double *corners, const axis axes[2])
{
    size_t row = (size_t)g->n[1] + 1;
    const double *last = corners + 2 * (kn_corner_count(g) - 1);
    for (int s = 0; s < axes[0].count; s++)
        for (int t = 0; t < axes[1].count; t++, values += 2) {
            int line[2][3], periods[2];
            double weight[2][3];
            int n0 = behind(line[0], weight[0], &axes[0], s), n1 = behind(line[1], weight[1], &axes[1], t);
            values[0] = values[1] = 0.0;
            for (int i = 0; i < n0; i++)
                for (int j = 0; j < n1; j++) {
                    size_t k = (size_t)wrapped(&periods[0], line[0][i], g->n[0]) * row;
                    k += (size_t)wrapped(&periods[1], line[1][j], g->n[1]);
                    for (size_t d = 0; d < 2; d++)
                        values[d] += weight[0][i] * weight[1][j] *
                                     (corners[2 * k + d] + periods[d] * (last[d] - corners[d]));
                }
        }
}

// Every line becomes a knot.
static kn_status all_lines(kn_ctx *ctx, kn_spline *map, const kn_corner_grid *g, const axis axes[2])
{
    kn_status status = KN_OK;
    for (int d = 0; status == KN_OK && d < 2; d++) {
        double *missing = kn_scratch(ctx, (size_t)g->n[d], sizeof *missing);
        int n = 0;
        if (!missing) return KN_ENOMEM;
        for (int i = 1; i < g->n[d]; i++)
            if (!axes[d].is_knot[i]) missing[n++] = i;
        if (n > 0) status = kn_spline_insert_knots(ctx, map, map, d, missing, n);
    }
    return status;
}

// coef, an array for u and one for v: values, point after point, which are control points already along a net, are
// interpolated along the other variable, line by line.
static kn_status by_lines(kn_ctx *ctx, double *coef, const double *values, const axis axes[2], int along)
{
    const axis *a = &axes[along];
    size_t across = (size_t)axes[1 - along].count, n = (size_t)a->count * across;
    size_t step = along == 0 ? across : 1, next = along == 0 ? 1 : (size_t)a->count;
    double *line = kn_scratch(ctx, (size_t)a->count, 2 * sizeof *line);
    kn_spline curve = {0};
    kn_status status = line ? KN_OK : KN_ENOMEM;
    for (size_t k = 0; k < across && status == KN_OK; k++) {
        for (size_t i = 0; i < (size_t)a->count; i++)
            for (size_t c = 0; c < 2; c++) line[2 * i + c] = values[2 * (k * next + i * step) + c];
        status = kn_fit_interpolate(ctx, &curve, 1, 2, (const int[]){3}, &a->count, (const double *const[]){a->knots},
                                    (const double *const[]){a->site}, line);
        for (size_t i = 0; status == KN_OK && i < (size_t)a->count; i++)
            for (size_t c = 0; c < 2; c++) coef[c * n + k * next + i * step] = curve.coef[c * (size_t)a->count + i];
    }
    kn_spline_clear(ctx, &curve);
    return status;
}

static kn_status by_corners(kn_ctx *ctx, kn_spline *map, const kn_corner_grid *g, const double *corners,
                            const bool net[2])
{
    axis a[2];
    for (int d = 0; d < 2; d++) {
        kn_status status = axis_init(ctx, &a[d], g, d, net[d]);
        if (status != KN_OK) return status;
    }
    size_t n = (size_t)a[0].count * (size_t)a[1].count;
    double *values = kn_scratch(ctx, n, 4 * sizeof *values), *coef = values ? values + 2 * n : NULL;
    if (!values) return KN_ENOMEM;
    gather(values, g, corners, a);
    const double *const on[2] = {a[0].knots, a[1].knots}, *const at[2] = {a[0].site, a[1].site};
    const int degree[2] = {3, 3}, count[2] = {a[0].count, a[1].count};
    const double lo[2] = {0.0, 0.0}, hi[2] = {g->n[0], g->n[1]};
    for (size_t k = 0; k < 2 * n; k++) coef[k % 2 * n + k / 2] = values[k];
    kn_spline made = {0};
    kn_status status = KN_OK;
    if (net[0] != net[1]) status = by_lines(ctx, coef, values, a, net[0] ? 1 : 0);
    if (status == KN_OK)
        status = net[0] || net[1] ? kn_spline_init(ctx, &made, 2, 2, false, degree, count, on, coef)
                                  : kn_fit_interpolate(ctx, &made, 2, 2, degree, count, on, at, values);
    if (status == KN_OK) kn_spline_swap(map, &made);
    kn_spline_clear(ctx, &made);
    if (status == KN_OK && (a[0].wrap > 0 || a[1].wrap > 0)) status = kn_spline_restrict(ctx, map, map, lo, hi);
    return status == KN_OK ? all_lines(ctx, map, g, a) : status;
}

// Edges onto the edges of the domain, and the two ends of a closed variable alike: what rounding took away.
static void settle_edges(kn_spline *map, const kn_corner_grid *g)
{
    size_t columns = (size_t)map->count[1], rows = (size_t)map->count[0], n = rows * columns;
    const double *last = g->corners + 2 * (kn_corner_count(g) - 1);
    for (size_t d = 0; d < 2; d++) {
        double *own = map->coef + d * n, *other = map->coef + (1 - d) * n;
        size_t stride = d == 0 ? 1 : columns, across = d == 0 ? columns : rows;
        size_t far = d == 0 ? (rows - 1) * columns : columns - 1;
        for (size_t k = 0; k < across; k++) {
            own[k * stride] = g->corners[d], own[k * stride + far] = last[d];
            if (g->closed[d]) other[k * stride + far] = other[k * stride];
        }
        for (size_t k = 0; k < n; k++) own[k] = fmin(fmax(own[k], g->corners[d]), last[d]);
    }
}

// ---- is it without a fold? ----

// t: 5 pieces. f = u_s v_t - u_t v_s of one piece, less what rounding may have added to it.
static kn_status determinant(kn_ctx *ctx, kn_bezier *f, kn_bezier *t, const kn_bezier *piece)
{
    kn_status status = KN_OK;
    double most[4], size = 0.0;
    for (int k = 0; k < 4 && status == KN_OK; k++) { // u_s, u_t, v_s, v_t
        status = kn_bezier_components(ctx, &t[4], piece, k / 2, 1);
        if (status == KN_OK) status = kn_bezier_derivative(ctx, &t[k], &t[4], k % 2);
        if (status != KN_OK) return status;
        most[k] = 0.0;
        for (size_t i = 0; i < kn_bezier_count(&t[k]); i++) most[k] = fmax(most[k], fabs(t[k].coef[i]));
        for (size_t i = 0; i < kn_bezier_count(&t[4]); i++) size = fmax(size, fabs(t[4].coef[i]));
    }
    status = kn_bezier_product(ctx, &t[0], &t[0], &t[3]);
    if (status == KN_OK) status = kn_bezier_product(ctx, &t[1], &t[1], &t[2]);
    if (status == KN_OK) status = kn_bezier_difference(ctx, f, &t[0], &t[1]);
    // pieces: gamma(2 (6 p + 1)) of their size each, p = 3, 6 times that in a derivative; products and the difference
    double moved = 6.0 * kn_gamma_up(40.0) * size, product = most[0] * most[3] + most[1] * most[2];
    double off = kn_gamma_up(64.0) * product + 1.01 * moved * (most[0] + most[1] + most[2] + most[3] + 2.0 * moved);
    for (size_t i = 0; status == KN_OK && i < kn_bezier_count(f); i++) f->coef[i] -= off;
    return status;
}

static kn_status unfolded(kn_ctx *ctx, bool *yes, const kn_spline *map)
{
    kn_bezier *pieces = NULL, t[5] = {{0}}, f = {0};
    size_t n = 0;
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, map);
    *yes = true;
    for (size_t k = 0; status == KN_OK && *yes && k < n; k++) {
        kn_sign sign = KN_SIGN_UNKNOWN;
        status = determinant(ctx, &f, t, &pieces[k]);
        if (status == KN_OK) status = kn_solve_sign(ctx, &sign, &f, NULL, NULL, DEPTH);
        *yes = sign == KN_SIGN_POSITIVE;
    }
    for (size_t k = 0; k < n; k++) kn_bezier_clear(ctx, &pieces[k]);
    kn_free(ctx, pieces);
    for (int k = 0; k < 5; k++) kn_bezier_clear(ctx, &t[k]);
    kn_bezier_clear(ctx, &f);
    return status;
}

kn_status kn_relax_smooth(kn_ctx *ctx, kn_spline *map, const kn_corner_grid *g, const double *start)
{
    // What is tried, in turn: how far corners go from the start, and whether they make control points.
    static const struct {
        double part;
        bool net[2];
    } tries[] = {{1.0, {false, false}}, {1.0, {false, true}}, {1.0, {true, false}}, {1.0, {true, true}},
                 {0.5, {false, false}}, {0.0, {false, true}}, {0.0, {true, false}}, {0.0, {true, true}}};
    size_t n = 2 * kn_corner_count(g);
    kn_mark mark = kn_scratch_mark(ctx);
    double *corners = kn_scratch(ctx, n, sizeof *corners);
    kn_spline s = {0};
    bool fine = false;
    kn_status status = corners ? KN_OK : KN_ENOMEM;
    for (size_t k = 0; k < sizeof tries / sizeof *tries && status == KN_OK && !fine; k++) {
        for (size_t i = 0; i < n; i++)
            corners[i] = tries[k].part == 1.0 ? g->corners[i] : start[i] + tries[k].part * (g->corners[i] - start[i]);
        status = by_corners(ctx, &s, g, corners, tries[k].net);
        if (status == KN_OK) settle_edges(&s, g);
        if (status == KN_OK) status = unfolded(ctx, &fine, &s);
    }
    if (status == KN_OK && !fine)
        status = kn_fail(ctx, KN_EUNDECIDED, "relax: no smooth map without a fold was found for %d x %d cells",
                         g->n[0], g->n[1]);
    if (status == KN_OK) kn_spline_swap(map, &s);
    kn_spline_clear(ctx, &s);
    kn_scratch_release(ctx, mark);
    return status;
}
