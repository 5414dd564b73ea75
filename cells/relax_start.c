// SPDX-License-Identifier: Apache-2.0
// Where the search for corners begins: even lines, some of them held on knots.
#include "cells/fit.h"
#include "cells/internal.h"
#include "cells/relax.h"
#include "kernel/context.h"
#include "kernel/knots.h"

#include <math.h>
#include <string.h>

// The line nearest to x, between lo and hi.
static int nearest(const double *lines, int lo, int hi, double x)
{
    int best = lo;
    for (int i = lo; i <= hi; i++)
        if (fabs(lines[i] - x) < fabs(lines[best] - x)) best = i;
    return best;
}

// Even lines contain all knots, so that there are at least as many as spans: with fewer wanted, every k-th of more.
// The knots in hold[] then replace the nearest of these; lines in between keep their shares.
static kn_status start_lines(kn_ctx *ctx, double *lines, char *held, const kn_spline *surface, int var, int count,
                             const double *hold, int nhold)
{
    int spans = kn_spline_spans(surface, var), every = (spans + count - 1) / count;
    double *fine = NULL;
    kn_status status = kn_cells_even_lines(ctx, &fine, surface, var, every * count);
    if (status != KN_OK) return status;
    for (int i = 0; i <= count; i++) lines[i] = fine[every * i], held[i] = KN_LINE_FREE;
    int first = 0;
    for (int h = 0; h <= nhold; h++) {
        int last = h == nhold ? count : nearest(lines, first + 1, count - (nhold - h), hold[h]);
        double from = fine[every * first], to = fine[every * last], end = h == nhold ? lines[count] : hold[h];
        double start = lines[first];
        for (int i = first + 1; i < last; i++) // a share of [from,to] becomes the same share of [start,end]
            lines[i] = start + (end - start) * ((fine[every * i] - from) / (to - from));
        lines[last] = end;
        if (h < nhold) held[last] = KN_LINE_HELD;
        first = last;
    }
    kn_free(ctx, fine);
    return KN_OK;
}

// Interior knots where S is C1 at most, or all.
static int knots_to_hold(double *hold, const kn_spline *surface, int var, bool all)
{
    int p = surface->degree[var], n = surface->count[var], found = 0;
    const double *t = surface->knots[var];
    for (int i = p + 1; i < n;) {
        int times = 1;
        while (i + times < n && t[i + times] == t[i]) times++;
        if (all || times >= p - 1) hold[found++] = t[i];
        i += times;
    }
    return found;
}

// Where lines have to keep their kinks.
static kn_status find_kinks(kn_ctx *ctx, const kn_corner_grid *g, double *const lines[2])
{
    kn_piece_grid s;
    kn_status status = kn_piece_grid_init(ctx, &s, g->surface);
    for (int d = 0; d < 2; d++) {
        int n = g->n[d], knot = 0;
        for (int i = 0; i <= n && status == KN_OK; i++) {
            if (i > 0 && g->held[d][i] == KN_LINE_FREE) continue;
            bool smooth = true;
            while (i > 0 && s.brk[d][knot] != lines[d][i]) knot++;
            if (i > 0 || g->closed[d]) status = kn_piece_grid_is_c1(ctx, &smooth, &s, d, knot);
            if (!smooth) g->held[d][i] = KN_LINE_KINK;
        }
        g->held[d][n] = g->held[d][0];
    }
    kn_piece_grid_clear(ctx, &s);
    return status;
}

// What the mean cell measures along both variables, with the area that all cells have together.
static kn_status wanted_size(kn_ctx *ctx, kn_corner_grid *g)
{
    size_t n = kn_corner_count(g), row = (size_t)g->n[1] + 1;
    double *p = kn_scratch(ctx, n, 3 * sizeof *p), width = 0.0, height = 0.0, area = 0.0;
    if (!p) return KN_ENOMEM;
    kn_status status = kn_spline_eval_batch(ctx, p, g->surface, n, g->corners);
    if (status != KN_OK) return status;
    for (size_t i = 0; i < (size_t)g->n[0]; i++)
        for (size_t j = 0; j < (size_t)g->n[1]; j++) {
            const double *a = p + 3 * (i * row + j), *b = a + 3 * row, *c = a + 3, *d = b + 3;
            double u[3], v[3];
            for (int k = 0; k < 3; k++) {
                u[k] = 0.5 * (b[k] + d[k] - a[k] - c[k]);
                v[k] = 0.5 * (c[k] + d[k] - a[k] - b[k]);
            }
            double x = u[1] * v[2] - u[2] * v[1], y = u[2] * v[0] - u[0] * v[2], z = u[0] * v[1] - u[1] * v[0];
            width += sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
            height += sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            area += sqrt(x * x + y * y + z * z);
        }
    double scale = sqrt(area / width / height), cells = (double)g->n[0] * g->n[1];
    g->size[0] = width / cells * (scale * sqrt(cells)), g->size[1] = height / cells * (scale * sqrt(cells));
    if (!(g->size[0] > 0.0) || !(g->size[1] > 0.0) || isinf(g->size[0]) || isinf(g->size[1]))
        return kn_fail(ctx, KN_EDOMAIN, "relax: cells of mean size %g x %g", g->size[0], g->size[1]);
    return KN_OK;
}

// Lines that were given: all of hold[] are among them.
static kn_status given_lines(kn_ctx *ctx, char *held, const double *lines, int var, int count, const double *hold,
                             int nhold)
{
    int h = 0;
    for (int i = 0; i <= count; i++) {
        held[i] = h < nhold && lines[i] == hold[h] ? KN_LINE_HELD : KN_LINE_FREE;
        h += held[i] == KN_LINE_HELD;
    }
    if (h == nhold) return KN_OK;
    return kn_fail(ctx, KN_EDOMAIN, "relax: the knot %g in variable %d is not among the lines", hold[h], var);
}

kn_status kn_relax_start(kn_ctx *ctx, kn_corner_grid *g, const double *const given[2], bool all_knots)
{
    double *lines[2];
    size_t row = (size_t)g->n[1] + 1;
    g->corners = kn_scratch(ctx, kn_corner_count(g), 2 * sizeof *g->corners);
    if (!g->corners) return KN_ENOMEM;
    for (int d = 0; d < 2; d++) {
        lines[d] = kn_scratch(ctx, (size_t)g->n[d] + 1, sizeof *lines[d]);
        g->held[d] = kn_scratch(ctx, (size_t)g->n[d] + 1, 1);
        double *hold = kn_scratch(ctx, (size_t)g->surface->count[d], sizeof *hold);
        if (!lines[d] || !g->held[d] || !hold) return KN_ENOMEM;
        int nhold = knots_to_hold(hold, g->surface, d, all_knots);
        if (nhold >= g->n[d])
            return kn_fail(ctx, KN_EDOMAIN, "relax: %d cells in variable %d, and %d knots that lines have to keep",
                           g->n[d], d, nhold);
        if (given[d]) memcpy(lines[d], given[d], ((size_t)g->n[d] + 1) * sizeof *lines[d]);
        kn_status status = given[d] ? given_lines(ctx, g->held[d], lines[d], d, g->n[d], hold, nhold)
                                    : start_lines(ctx, lines[d], g->held[d], g->surface, d, g->n[d], hold, nhold);
        if (status != KN_OK) return status;
    }
    for (int i = 0; i <= g->n[0]; i++)
        for (int j = 0; j <= g->n[1]; j++) {
            double *to = g->corners + 2 * ((size_t)i * row + (size_t)j);
            to[0] = lines[0][i], to[1] = lines[1][j];
        }
    kn_status status = find_kinks(ctx, g, lines);
    return status == KN_OK ? wanted_size(ctx, g) : status;
}
