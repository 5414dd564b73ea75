// SPDX-License-Identifier: Apache-2.0
// The unit normal as N m: N the direction over each span, m a spline near 1/|N|, so that the length alone is
// approximated.
//
// At a pole n is the unit normal, whatever m: see flatten_poles.
//
// Each span has its own N, scaled by a power of two and in parameters of its own. Times its span's factor c N becomes
// one field, continuous across a knot line wherever S_u x S_v is, and m interpolates 1/|c N|.
// Source: Elber, Geometric Texture Modeling, IEEE CG&A 25(4), 2005, sidebar "Unit Normal Field Approximation".
#include "kernel/context.h"
#include "spline/internal.h"
#include "trivar/internal.h"

#include <math.h>

// ---- the factors ----

enum { PLACES = 5 }; // in each span along a line

// |N| below interior knot k of variable var over |N| above, at place t of span j of the other variable.
static double step(const kn_shell *s, int var, int k, int j, double t)
{
    int columns = s->nknots[1] - 1, at = var == 0 ? (k - 1) * columns + j : j * columns + k - 1;
    const kn_direction *below = &s->direction[at], *above = &s->direction[at + (var == 0 ? columns : 1)];
    double unit[3], x[2];
    x[1 - var] = t;
    x[var] = 1.0;
    double length = kn_direction_length(unit, &below->n, x);
    x[var] = 0.0;
    return ldexp(length / kn_direction_length(unit, &above->n, x), below->exponent - above->exponent);
}

bool kn_lengths_continue(const kn_shell *shell, int var, int k)
{
    double first = step(shell, var, k, 0, 0.5);
    for (int j = 0; j < (shell->nknots[1 - var] - 1) * PLACES; j++) {
        double here = step(shell, var, k, j / PLACES, (double)(j % PLACES) / (PLACES - 1));
        if (!(fabs(here - first) <= 1e-10 * first)) return false;
    }
    return true;
}

// One for each span of S: the power of two, and the ratios of lengths at all knot lines before it.
static kn_status make_factors(kn_ctx *ctx, double *factor, const kn_shell *s)
{
    size_t columns = (size_t)s->nknots[1] - 1;
    double *line[2] = {kn_scratch(ctx, (size_t)s->nknots[0], sizeof(double)),
                       kn_scratch(ctx, (size_t)s->nknots[1], sizeof(double))};
    if (!line[0] || !line[1]) return KN_ENOMEM;
    for (int v = 0; v < 2; v++) {
        line[v][0] = 1.0;
        for (int k = 1; k + 1 < s->nknots[v]; k++) line[v][k] = line[v][k - 1] * step(s, v, k, 0, 0.5);
    }
    for (size_t i = 0; i < s->ndirections; i++) {
        int exponent = s->direction[i].exponent - s->direction[0].exponent;
        factor[i] = ldexp(line[0][i / columns] * line[1][i % columns], exponent);
    }
    return KN_OK;
}

// ---- N m ----

typedef struct product {
    const kn_grid_axis *axes;
    const kn_direction_box *boxes;
    const double *factor; // one for each span of S
    const kn_bezier *m;   // one for each box
    kn_bezier n;          // one piece of the result
} product;

// The product on each box, all of the highest degree among them.
static kn_status multiply(kn_ctx *ctx, kn_spline *s, product *p)
{
    int across = p->axes[1].ncuts - 1, boxes = (p->axes[0].ncuts - 1) * across;
    kn_status status = KN_OK;
    for (int i = 0; i < boxes && status == KN_OK; i++) {
        const int first[2] = {i / across * (s->degree[0] + 1), i % across * (s->degree[1] + 1)};
        const kn_direction_box *box = &p->boxes[i];
        status = kn_bezier_product(ctx, &p->n, &p->m[i], &box->n);
        if (status == KN_OK) status = kn_bezier_scale(ctx, &p->n, &p->n, p->factor[box->span]);
        if (status == KN_OK) status = kn_bezier_elevate(ctx, &p->n, &p->n, s->degree);
        if (status == KN_OK) kn_spline_put_piece(s, &p->n, first);
    }
    return status;
}

// N is smooth inside spans of S; at their borders m was made as smooth as N.
static kn_status make_grid(kn_ctx *ctx, kn_grid *grid, const kn_spline *s, const kn_grid_axis axes[2])
{
    for (int v = 0; v < 2; v++) {
        const kn_grid_axis *g = &axes[v];
        size_t n = (size_t)g->ncuts;
        grid->nbreaks[v] = g->ncuts;
        grid->breaks[v] = g->cut;
        grid->times[v] = kn_scratch(ctx, n, sizeof(int));
        if (!grid->times[v]) return KN_ENOMEM;
        for (int i = 0; i < g->ncuts; i++) grid->times[v][i] = kn_grid_continuity(g, i);
        kn_grid_multiplicities(grid, v, s->degree[v]);
    }
    return KN_OK;
}

// ---- poles ----

// N is q(t) times one unit vector along a pole, and q m not constant whatever the polynomial m: the row of
// coefficients there becomes that vector, so that a point of S stays one fibre of T, as in fit.c. n moves by what its
// length is off at the pole, times the basis function of the row, which ends with the next line.
static void flatten_poles(kn_spline *n, const kn_shell *shell)
{
    size_t count = kn_spline_count(n), columns = (size_t)shell->nknots[1] - 1;
    bool done[2] = {false}; // the edges across variable 0
    for (int e = 0; e < 4; e++) {
        int var = e / 2, end = e % 2;
        if (kn_edge_of(shell, var, end).kind != KN_EDGE_POLE) continue;
        kn_row row = kn_edge_row(n->count, var, end);
        size_t last = end ? (size_t)shell->nknots[var] - 2 : 0;
        double unit[3], corner[2] = {0.0, 0.0};
        corner[var] = end;
        (void)kn_direction_unit(unit, &shell->direction[last * (var == 0 ? columns : 1)].n, corner);
        for (int k = 0; k < 2 && var == 1; k++) { // two poles that meet share a corner
            const double *c = n->coef + row.first + (k == 0 ? 0 : (row.count - 1) * row.step);
            for (size_t m = 0; m < 3 && done[k]; m++) unit[m] = c[m * count];
        }
        for (size_t i = 0; i < 3 * row.count; i++)
            n->coef[i / row.count * count + row.first + i % row.count * row.step] = unit[i / row.count];
        if (var == 0) done[end] = true;
    }
}

static kn_status assemble(kn_ctx *ctx, kn_spline *out, product *p)
{
    static const char call[] = "shell";
    kn_spline s = {.nvars = 2, .ncomp = 3};
    kn_grid grid;
    for (int i = 0; i < (p->axes[0].ncuts - 1) * (p->axes[1].ncuts - 1); i++)
        for (int v = 0; v < 2; v++) {
            int degree = p->boxes[i].n.degree[v] + p->m[i].degree[v];
            if (degree > s.degree[v]) s.degree[v] = degree;
        }
    kn_status status = make_grid(ctx, &grid, &s, p->axes);
    if (status == KN_OK) status = kn_spline_pieces_in_scratch(ctx, call, &s, &grid);
    if (status == KN_OK) status = multiply(ctx, &s, p);
    if (status == KN_OK) status = kn_spline_join_on_grid(ctx, &s, &grid);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    return status;
}

kn_status kn_fit_exact_direction(kn_ctx *ctx, kn_spline *out, const kn_shell *shell, const kn_grid_axis axes[2],
                                 const kn_direction_box *boxes)
{
    kn_spline m = {0};
    kn_bezier *pieces = NULL;
    size_t npieces = 0;
    kn_mark mark = kn_scratch_mark(ctx);
    double *factor = kn_scratch(ctx, shell->ndirections, sizeof *factor);
    product p = {.axes = axes, .boxes = boxes, .factor = factor};
    kn_status status = factor ? make_factors(ctx, factor, shell) : KN_ENOMEM;
    if (status == KN_OK) status = kn_fit_reciprocal(ctx, &m, shell, axes, factor);
    if (status == KN_OK) status = kn_spline_to_bezier(ctx, &pieces, &npieces, &m);
    p.m = pieces;
    if (status == KN_OK) status = assemble(ctx, out, &p);
    if (status == KN_OK) flatten_poles(out, shell);
    kn_scratch_release(ctx, mark);
    kn_bezier_clear(ctx, &p.n);
    for (size_t i = 0; i < npieces; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    kn_spline_clear(ctx, &m);
    return status;
}
