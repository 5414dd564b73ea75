// SPDX-License-Identifier: Apache-2.0
// Widths, heights and areas of cells, by Gauss's rules on the parts of cells between knots.
#include "cells/internal.h"
#include "kernel/context.h"
#include "kernel/knots.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 1024 }; // points evaluated at a time

// The points of one variable: abscissae, weights (lengths of parts included), and the cell of each.
typedef struct rule {
    int cells, n;
    double *x, *w;
    int *cell;
} rule;

// Over a part that is a fraction of a knot span the integrand differs that much less from a polynomial.
static int points_for(double fraction)
{
    return fraction > 0.6 ? 12 : fraction > 0.3 ? 9 : fraction > 0.15 ? 7 : fraction > 0.06 ? 5 : 4;
}

static void add_part(rule *r, int cell, double lo, double hi, double span)
{
    double x[KN_CELLS_POINTS], w[KN_CELLS_POINTS];
    int m = points_for((hi - lo) / span);
    kn_cells_gauss(x, w, m);
    for (int k = 0; k < m; k++, r->n++) {
        r->x[r->n] = lo + (hi - lo) * x[k];
        r->w[r->n] = (hi - lo) * w[k];
        r->cell[r->n] = cell;
    }
}

// Cells between lines are cut once more at the knots inside them.
static kn_status make_rule(kn_ctx *ctx, rule *r, const kn_spline *surface, int var, const double *lines, int nlines)
{
    int nbreaks, span = 0;
    double *breaks = kn_cells_breaks(ctx, &nbreaks, surface, var);
    if (!breaks) return KN_ENOMEM;
    if (!lines) lines = breaks, nlines = nbreaks;
    size_t most = ((size_t)nlines + (size_t)nbreaks) * KN_CELLS_POINTS;
    *r = (rule){.cells = nlines - 1};
    r->x = kn_scratch(ctx, most, sizeof *r->x);
    r->w = kn_scratch(ctx, most, sizeof *r->w);
    r->cell = kn_scratch(ctx, most, sizeof *r->cell);
    if (!r->x || !r->w || !r->cell) return KN_ENOMEM;
    for (int i = 0; i < nlines - 1; i++) {
        double at = lines[i];
        while (at < lines[i + 1]) {
            while (breaks[span + 1] <= at) span++;
            double end = fmin(lines[i + 1], breaks[span + 1]);
            add_part(r, i, at, end, breaks[span + 1] - breaks[span]);
            at = end;
        }
    }
    return KN_OK;
}

// Room for a block of points and of values with their first partials.
typedef struct block {
    double *at, *value;
} block;

static kn_status make_block(kn_ctx *ctx, block *b)
{
    b->at = kn_scratch(ctx, 2 * BLOCK, sizeof *b->at);
    b->value = kn_scratch(ctx, 9 * BLOCK, sizeof *b->value);
    return b->at && b->value ? KN_OK : KN_ENOMEM;
}

// length[cell] = the length of each cell along var at the other parameter.
static kn_status measure_lengths(kn_ctx *ctx, double *length, const kn_spline *surface, int var, const rule *along,
                                 double other, const block *b)
{
    memset(length, 0, (size_t)along->cells * sizeof *length);
    for (int from = 0; from < along->n; from += BLOCK) {
        int n = along->n - from < BLOCK ? along->n - from : BLOCK;
        for (int k = 0; k < n; k++) {
            b->at[2 * k + var] = along->x[from + k];
            b->at[2 * k + 1 - var] = other;
        }
        kn_status status = kn_spline_eval_batch_partials(ctx, b->value, surface, (size_t)n, b->at);
        if (status != KN_OK) return status;
        for (int k = 0; k < n; k++)
            length[along->cell[from + k]] += along->w[from + k] * kn_cells_norm(b->value + 9 * k + 3 * (1 + var));
    }
    return KN_OK;
}

// The mean of a cell's two sides along var, into value[u][v].
static kn_status measure_sides(kn_ctx *ctx, double *value, const kn_spline *surface, int var, const rule rules[2],
                               const double *lines, const block *b)
{
    size_t along = (size_t)rules[var].cells, across = (size_t)rules[1 - var].cells;
    size_t step = var == 0 ? across : 1, next = var == 0 ? 1 : along;
    double *length = kn_scratch(ctx, along, sizeof *length);
    kn_status status = length ? KN_OK : KN_ENOMEM;
    for (size_t j = 0; status == KN_OK && j <= across; j++) {
        status = measure_lengths(ctx, length, surface, var, &rules[var], lines[j], b);
        for (size_t i = 0; status == KN_OK && i < along; i++) {
            if (j > 0) value[i * step + (j - 1) * next] += 0.5 * length[i];
            if (j < across) value[i * step + j * next] += 0.5 * length[i];
        }
    }
    return status;
}

static kn_status measure_areas(kn_ctx *ctx, double *value, const kn_spline *surface, const rule rules[2],
                               const block *b)
{
    for (int i = 0; i < rules[0].n; i++) {
        double *row = value + (size_t)rules[0].cell[i] * (size_t)rules[1].cells;
        for (int from = 0; from < rules[1].n; from += BLOCK) {
            int n = rules[1].n - from < BLOCK ? rules[1].n - from : BLOCK;
            for (int k = 0; k < n; k++) b->at[2 * k] = rules[0].x[i], b->at[2 * k + 1] = rules[1].x[from + k];
            kn_status status = kn_spline_eval_batch_partials(ctx, b->value, surface, (size_t)n, b->at);
            if (status != KN_OK) return status;
            for (int k = 0; k < n; k++)
                row[rules[1].cell[from + k]] += rules[0].w[i] * rules[1].w[from + k] *
                                                kn_cells_area(b->value + 9 * k + 3, b->value + 9 * k + 6);
        }
    }
    return KN_OK;
}

static kn_status summarise(kn_ctx *ctx, kn_cells_range *out, const double *value, size_t n)
{
    kn_cells_range r = {.min = INFINITY, .max = 0.0};
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(value[i])) return kn_fail(ctx, KN_EDOMAIN, "cells: a cell of size %g", value[i]);
        r.min = fmin(r.min, value[i]);
        r.max = fmax(r.max, value[i]);
        r.mean += value[i] / (double)n;
    }
    for (size_t i = 0; i < n; i++) {
        double bin = r.mean > 0.0 ? value[i] / r.mean / 3.0 * KN_CELLS_BINS : 0.0;
        r.histogram[bin < KN_CELLS_BINS - 1 ? (int)bin : KN_CELLS_BINS - 1]++;
    }
    *out = r;
    return KN_OK;
}

static kn_status check_grid(kn_ctx *ctx, const kn_cells_grid *g, size_t *cells)
{
    size_t n = 1;
    kn_status status = kn_cells_expect(ctx, "cells", g->surface);
    for (int d = 0; status == KN_OK && d < 2; d++) {
        if (g->lines[d])
            status = kn_cells_expect_lines(ctx, "cells", g->surface, d, g->lines[d], g->nlines[d], false);
        n *= g->lines[d] ? (size_t)(g->nlines[d] - 1) : (size_t)kn_spline_spans(g->surface, d);
    }
    *cells += n;
    return status;
}

// what: 0 widths, 1 heights, 2 areas of one surface's cells.
static kn_status measure_grid(kn_ctx *ctx, double *value, int what, const kn_cells_grid *g)
{
    rule rules[2] = {{0}};
    block b = {0};
    int nbreaks;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = make_block(ctx, &b);
    for (int d = 0; status == KN_OK && d < 2; d++)
        status = make_rule(ctx, &rules[d], g->surface, d, g->lines[d], g->nlines[d]);
    if (status == KN_OK && what == 2) status = measure_areas(ctx, value, g->surface, rules, &b);
    if (status == KN_OK && what < 2) {
        const double *lines = g->lines[1 - what];
        if (!lines) lines = kn_cells_breaks(ctx, &nbreaks, g->surface, 1 - what);
        status = lines ? measure_sides(ctx, value, g->surface, what, rules, lines, &b) : KN_ENOMEM;
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_cells_measure_all(kn_ctx *ctx, kn_cells_spread *out, const kn_cells_grid *grids, int ngrids)
{
    size_t total = 0;
    kn_cells_spread s = {0};
    kn_status status = ngrids > 0 ? KN_OK : kn_fail(ctx, KN_EDOMAIN, "cells: %d surfaces", ngrids);
    for (int g = 0; status == KN_OK && g < ngrids; g++) status = check_grid(ctx, &grids[g], &total);
    if (status != KN_OK) return status;
    kn_cells_range *const ranges[3] = {&s.width, &s.height, &s.area};
    s.cells = total;
    for (int what = 0; status == KN_OK && what < 3; what++) {
        size_t first = 0, cells;
        double *value = kn_alloc_zero(ctx, total, sizeof *value);
        if (!value) return KN_ENOMEM;
        for (int g = 0; status == KN_OK && g < ngrids; g++, first += cells) {
            cells = 0;
            status = check_grid(ctx, &grids[g], &cells);
            if (status == KN_OK) status = measure_grid(ctx, value + first, what, &grids[g]);
            if (status == KN_OK) status = kn_progress(ctx, "cells", (what + (g + 1.0) / ngrids) / 3.0);
        }
        if (status == KN_OK) status = summarise(ctx, ranges[what], value, total);
        kn_free(ctx, value);
    }
    if (status == KN_OK) *out = s;
    return status;
}

kn_status kn_cells_measure(kn_ctx *ctx, kn_cells_spread *out, const kn_spline *surface, const double *const lines[2],
                           const int nlines[2])
{
    kn_cells_grid g = {.surface = surface};
    for (int d = 0; lines && d < 2; d++) g.lines[d] = lines[d], g.nlines[d] = nlines && lines[d] ? nlines[d] : 0;
    return kn_cells_measure_all(ctx, out, &g, 1);
}
