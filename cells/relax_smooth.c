// SPDX-License-Identifier: Apache-2.0
// A map without kinks through the corners: bicubic, C2, certified to have no fold.
#include "cells/relax.h"
#include "kernel/context.h"

#include "bezier/norm_bound.h"

#include <knurl/fit.h>
#include <knurl/solve.h>
#include <math.h>
#include <string.h>

// Cells that a closed variable goes on for, at each end: the other end counts 0.27^20 of itself at the seam.
enum { WRAP = 20, DEPTH = 12, STEPS = 4 };

// ---- interpolation ----

// Knots of the cubic spline through n + 1 values at 0 .. n without a knot at 1 and n - 1; lower degrees where there
// are too few values. Shifted by -wrap.
static int not_a_knot(double *knots, double *sites, int n, int wrap)
{
    int p = n < 3 ? n : 3, k = 0;
    for (int i = 0; i <= p; i++) knots[k++] = -wrap;
    for (int i = 2; i <= n - 2; i++) knots[k++] = i - wrap;
    for (int i = 0; i <= p; i++) knots[k++] = n - wrap;
    for (int i = 0; i <= n; i++) sites[i] = i - wrap;
    return p;
}

// Corner i of variable d, which goes on beyond the ends of a closed one: its place among the corners, and by how many
// periods it is off.
static int wrapped(int *periods, int i, int n)
{
    *periods = i < 0 ? -((n - 1 - i) / n) : i > n ? (i - 1) / n : 0;
    return i - *periods * n;
}

static void gather(double *values, const kn_corner_grid *g, const double *corners, const int wrap[2])
{
    size_t row = (size_t)g->n[1] + 1, k = 0;
    const double *last = corners + 2 * (kn_corner_count(g) - 1);
    for (int i = -wrap[0]; i <= g->n[0] + wrap[0]; i++)
        for (int j = -wrap[1]; j <= g->n[1] + wrap[1]; j++, k += 2) {
            int periods[2];
            size_t a = (size_t)wrapped(&periods[0], i, g->n[0]), b = (size_t)wrapped(&periods[1], j, g->n[1]);
            for (size_t d = 0; d < 2; d++)
                values[k + d] = corners[2 * (a * row + b) + d] + periods[d] * (last[d] - corners[d]);
        }
}

static kn_status through_corners(kn_ctx *ctx, kn_spline *map, const kn_corner_grid *g, const double *corners)
{
    int wrap[2], degree[2], count[2];
    double *knots[2], *sites[2];
    for (int d = 0; d < 2; d++) {
        wrap[d] = g->closed[d] ? WRAP : 0;
        count[d] = g->n[d] + 2 * wrap[d] + 1;
        knots[d] = kn_scratch(ctx, (size_t)count[d] + 4, sizeof *knots[d]);
        sites[d] = kn_scratch(ctx, (size_t)count[d], sizeof *sites[d]);
        if (!knots[d] || !sites[d]) return KN_ENOMEM;
        degree[d] = not_a_knot(knots[d], sites[d], count[d] - 1, wrap[d]);
    }
    double *values = kn_scratch(ctx, (size_t)count[0] * (size_t)count[1], 2 * sizeof *values);
    if (!values) return KN_ENOMEM;
    gather(values, g, corners, wrap);
    const double *const on[2] = {knots[0], knots[1]}, *const at[2] = {sites[0], sites[1]};
    const double lo[2] = {0.0, 0.0}, hi[2] = {g->n[0], g->n[1]};
    kn_status status = kn_fit_interpolate(ctx, map, 2, 2, degree, count, on, at, values);
    if (status == KN_OK && (wrap[0] > 0 || wrap[1] > 0)) status = kn_spline_restrict(ctx, map, map, lo, hi);
    for (int d = 0; status == KN_OK && d < 2; d++) { // every line becomes a knot
        double missing[2];
        int n = 0;
        for (int i = 1; i < g->n[d]; i++) {
            if (wrap[d] > 0 || (i > 1 && i < g->n[d] - 1)) continue;
            missing[n++] = i;
        }
        if (n > 0) status = kn_spline_insert_knots(ctx, map, map, d, missing, n);
    }
    return status;
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
    size_t n = 2 * kn_corner_count(g);
    kn_mark mark = kn_scratch_mark(ctx);
    double *corners = kn_scratch(ctx, n, sizeof *corners);
    kn_spline s = {0};
    bool fine = false;
    kn_status status = corners ? KN_OK : KN_ENOMEM;
    for (int k = STEPS; k >= 0 && status == KN_OK && !fine; k--) { // back to even lines, as far as it takes
        double part = (double)k / STEPS;
        for (size_t i = 0; i < n; i++)
            corners[i] = g->corners[i] == start[i] ? start[i] : start[i] + part * (g->corners[i] - start[i]);
        status = through_corners(ctx, &s, g, corners);
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
