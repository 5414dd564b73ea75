// SPDX-License-Identifier: Apache-2.0
// A certified bound of |F - S(map)|, F the fit, cell by cell.
//
// Where the image of a box lies in one knot box of S = P/W, e = P(map) - F W(map) is a polynomial, composed exactly,
// and |F - S(map)| = |e| / W(map) <= (bound of |e| by its coefficients) / (least coefficient of W(map)). Where it
// meets several knot boxes, each of their polynomials is continued over the whole box: every point has its image in
// one of them, so that the largest of the bounds holds. Boxes are quartered until that is little more than the rest.
#include "cells/fit.h"
#include "cells/internal.h"

#include "bezier/norm_bound.h"
#include "kernel/context.h"

#include <knurl/compose.h>
#include <math.h>

enum { DEPTH = 6, BOXES_PER_CELL = 64, NEIGHBOURS = 3 };
enum { MAP, INNER, OUTER, FIT, TOP, WEIGHT, ERROR, NTEMP };

typedef struct bounding {
    const kn_piece_grid *surface, *map, *fit;
    bool rational;
    double top, weight, reach; // the largest coefficient vector and weight of S, and vector of the fit
    double middle[2];          // the largest coefficient of the map's components
    double narrow[2];          // the least knot span of S
    double sampled, bound, least;
    size_t boxes; // that may still be looked at
    kn_bezier temp[NTEMP];
} bounding;

// The largest vector of components first .. last - 1 among all coefficients.
static double largest(const kn_piece_grid *g, int first, int last)
{
    double most = 0.0;
    for (size_t i = 0; i < g->npieces; i++) {
        size_t n = kn_bezier_count(&g->piece[i]);
        for (size_t k = 0; k < n; k++) {
            double square = 0.0;
            for (int c = first; c < last; c++) square += pow(g->piece[i].coef[(size_t)c * n + k], 2);
            most = fmax(most, kn_round_up(sqrt(square)));
        }
    }
    return most;
}

static void range_of(double *lo, double *hi, const kn_bezier *b, int component)
{
    size_t n = kn_bezier_count(b);
    const double *c = b->coef + (size_t)component * n;
    *lo = *hi = c[0];
    for (size_t k = 1; k < n; k++) *lo = fmin(*lo, c[k]), *hi = fmax(*hi, c[k]);
}

// The spans first .. last of breaks that [lo,hi] meets by more than *beyond, which is what it reaches at most into
// others (or out of the domain).
static void spans_met(int *first, int *last, double *beyond, const double *breaks, int spans, double lo, double hi)
{
    double slack = 0x1p-44 * fmax(fabs(breaks[0]), fabs(breaks[spans]));
    *first = 0, *last = spans - 1;
    while (*first < spans - 1 && breaks[*first + 1] <= lo + slack) ++*first;
    while (*last > *first && breaks[*last] >= hi - slack) --*last;
    *beyond = fmax(fmax(breaks[*first] - lo, hi - breaks[*last + 1]), 0.0);
}

// INNER = MAP in the coordinates of one knot box of S; growth: the largest sum over the Bernstein polynomials of S in
// absolute value there; off: how far INNER is from what it stands for, in each variable.
static kn_status into_knot_box(kn_ctx *ctx, bounding *b, const int span[2], double *growth, double off[2])
{
    kn_bezier *t = b->temp;
    const int degree = t[MAP].degree[0] > t[MAP].degree[1] ? t[MAP].degree[0] : t[MAP].degree[1];
    kn_status status = kn_bezier_copy(ctx, &t[INNER], &t[MAP]);
    if (status != KN_OK) return status;
    size_t n = kn_bezier_count(&t[INNER]);
    const kn_bezier *outer = &b->surface->piece[span[0] * b->surface->n[1] + span[1]];
    *growth = 1.0;
    for (int d = 0; d < 2; d++) {
        double lo = b->surface->brk[d][span[d]], hi = b->surface->brk[d][span[d] + 1], most = 1.0;
        for (size_t k = (size_t)d * n; k < (size_t)(d + 1) * n; k++) {
            double x = (t[INNER].coef[k] - lo) / (hi - lo);
            t[INNER].coef[k] = x;
            most = fmax(most, fabs(x) + fabs(1.0 - x));
        }
        // to pieces: gamma(6 m + 1) a variable; restriction gamma(5 m + 2); here three roundings
        off[d] = kn_gamma_up(22.0 * degree + 16.0) * (b->middle[d] + fmax(fabs(lo), fabs(hi))) / (hi - lo);
        *growth *= pow(kn_round_up(most + off[d]), outer->degree[d]);
    }
    return KN_OK;
}

// *rounding = what the coefficients of ERROR may be wrong by; *weight_off: of WEIGHT's. beyond: how far images may
// lie in other knot boxes, whose polynomials meet this one at the knot, in units of the narrowest.
static void roundings(double *rounding, double *weight_off, const bounding *b, const kn_bezier *outer, double growth,
                      const double off[2], const double beyond[2])
{
    const kn_bezier *t = b->temp;
    double p = outer->degree[0] + outer->degree[1];
    double terms = (t[INNER].degree[0] + 1.0) * (t[INNER].degree[1] + 1.0);
    double fold = (outer->degree[0] + 1.0) * (outer->degree[1] + 1.0);
    double compose = p * (terms + 5.0) + fold + 5.0 + 6.0 * p + 2.0; // and S to its pieces
    double fit = (double)kn_bezier_count(&t[FIT]), q = t[FIT].degree[0] + t[FIT].degree[1];
    double shift = 0.0; // a value moves by 2 p max |c| for a unit of a parameter, and twice that where pieces change
    for (int d = 0; d < 2; d++) shift += 2.0 * outer->degree[d] * (off[d] + 2.0 * beyond[d]);
    double relative = kn_round_up(kn_gamma_up(compose) + 2.0 * shift) * growth;
    double own = kn_gamma_up(11.0 * q + 6.0); // the fit to its pieces, and restricted
    double after = kn_gamma_up(2.0 * fit + 64.0);
    double top = b->top * growth, product = b->rational ? b->reach * b->weight * growth : b->reach;
    *weight_off = b->rational ? relative * b->weight : 0.0;
    *rounding = kn_round_up(relative * b->top + (b->rational ? b->reach * *weight_off : 0.0) +
                            (own + after) * product * 1.01 + after * top);
}

// *bound rises to the bound over the box whose MAP and FIT are in b->temp, with the polynomial of this knot box.
static kn_status bound_with(kn_ctx *ctx, bounding *b, const int span[2], const double reach[2], double *bound,
                            double *least)
{
    kn_bezier *t = b->temp;
    const kn_bezier *outer = &b->surface->piece[span[0] * b->surface->n[1] + span[1]];
    double growth, off[2], rounding, weight_off, lo = 1.0, hi, beyond[2];
    kn_status status = into_knot_box(ctx, b, span, &growth, off);
    if (status == KN_OK) status = kn_bezier_compose(ctx, &t[OUTER], outer, &t[INNER]);
    int dim = outer->ncomp - outer->rational;
    if (status == KN_OK) status = kn_bezier_components(ctx, &t[TOP], &t[OUTER], 0, dim);
    for (int d = 0; status == KN_OK && d < 2; d++) {
        double width = b->surface->brk[d][span[d] + 1] - b->surface->brk[d][span[d]];
        beyond[d] = (reach[d] + off[d] * width) / b->narrow[d];
    }
    if (status != KN_OK) return status;
    roundings(&rounding, &weight_off, b, outer, growth, off, beyond);
    if (b->rational) {
        if (status == KN_OK) status = kn_bezier_components(ctx, &t[WEIGHT], &t[OUTER], dim, 1);
        if (status == KN_OK) range_of(&lo, &hi, &t[WEIGHT], 0);
        lo = (lo - weight_off) * (1.0 - 0x1p-46);
        if (status == KN_OK) status = kn_bezier_product(ctx, &t[ERROR], &t[WEIGHT], &t[FIT]);
        if (status == KN_OK) status = kn_bezier_difference(ctx, &t[ERROR], &t[TOP], &t[ERROR]);
    } else if (status == KN_OK) {
        status = kn_bezier_difference(ctx, &t[ERROR], &t[TOP], &t[FIT]);
    }
    if (status != KN_OK) return status;
    if (!(lo > 0.0) || !isfinite(rounding)) {
        *bound = INFINITY;
        return KN_OK;
    }
    if (b->rational) status = kn_bezier_scale(ctx, &t[ERROR], &t[ERROR], 1.0 / lo);
    double found = 0.0, seen = *least;
    if (status == KN_OK) status = kn_bezier_norm_bound(ctx, &found, &seen, &t[ERROR], -1.0);
    *least = seen;
    *bound = fmax(*bound, kn_round_up(found + rounding / lo));
    return status;
}

// The bound over the box [lo,hi] of cell (i,j), each polynomial that occurs in it; *several: more than one did.
static kn_status bound_box(kn_ctx *ctx, bounding *b, size_t cell, const double lo[2], const double hi[2],
                           double *bound, double *least, bool *several)
{
    kn_bezier *t = b->temp;
    int first[2], last[2];
    double beyond[2];
    kn_status status = kn_bezier_restrict(ctx, &t[MAP], &b->map->piece[cell], lo, hi);
    if (status == KN_OK) status = kn_bezier_restrict(ctx, &t[FIT], &b->fit->piece[cell], lo, hi);
    if (status != KN_OK) return status;
    for (int d = 0; d < 2; d++) {
        double least_at, most_at;
        range_of(&least_at, &most_at, &t[MAP], d);
        spans_met(&first[d], &last[d], &beyond[d], b->surface->brk[d], b->surface->n[d], least_at, most_at);
    }
    *several = first[0] < last[0] || first[1] < last[1];
    if (last[0] - first[0] >= NEIGHBOURS || last[1] - first[1] >= NEIGHBOURS) {
        *bound = INFINITY;
        return KN_OK;
    }
    for (int i = first[0]; i <= last[0]; i++)
        for (int j = first[1]; j <= last[1] && status == KN_OK; j++)
            status = bound_with(ctx, b, (int[2]){i, j}, beyond, bound, least);
    return status;
}

static kn_status bound_cell(kn_ctx *ctx, bounding *b, size_t cell, const double lo[2], const double hi[2], int depth)
{
    double bound = 0.0, least = b->least;
    bool several = false;
    kn_status status = bound_box(ctx, b, cell, lo, hi, &bound, &least, &several);
    if (status != KN_OK) return status;
    b->boxes -= b->boxes > 0;
    if (!(bound > fmax(b->bound, 1.5 * b->least)) || depth == DEPTH || b->boxes == 0 ||
        (!several && isfinite(bound))) {
        b->bound = fmax(b->bound, bound);
        if (!several) b->least = fmax(b->least, least);
        return KN_OK;
    }
    for (int k = 0; k < 4 && status == KN_OK; k++) {
        double from[2], to[2];
        for (int d = 0; d < 2; d++) {
            double middle = 0.5 * (lo[d] + hi[d]);
            bool upper = d == 0 ? k / 2 == 1 : k % 2 == 1;
            from[d] = upper ? middle : lo[d], to[d] = upper ? hi[d] : middle;
        }
        status = bound_cell(ctx, b, cell, from, to, depth + 1);
    }
    return status;
}

kn_status kn_cells_fit_bound(kn_ctx *ctx, double *bound, const kn_spline *fit, const kn_piece_grid *surface,
                             const kn_piece_grid *map, double sampled)
{
    kn_piece_grid pieces;
    const double zero[2] = {0.0, 0.0}, one[2] = {1.0, 1.0};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_piece_grid_init(ctx, &pieces, fit);
    bounding b = {.surface = surface, .map = map, .fit = &pieces, .least = sampled};
    if (status == KN_OK) {
        b.rational = surface->piece[0].rational;
        int dim = kn_bezier_dim(&surface->piece[0]);
        b.top = largest(surface, 0, dim), b.weight = b.rational ? largest(surface, dim, dim + 1) : 1.0;
        b.reach = largest(&pieces, 0, dim);
        for (int d = 0; d < 2; d++) {
            b.middle[d] = largest(map, d, d + 1), b.narrow[d] = INFINITY;
            for (int i = 0; i < surface->n[d]; i++)
                b.narrow[d] = fmin(b.narrow[d], surface->brk[d][i + 1] - surface->brk[d][i]);
        }
        b.boxes = BOXES_PER_CELL * map->npieces;
    }
    for (size_t k = 0; status == KN_OK && k < map->npieces; k++) {
        status = bound_cell(ctx, &b, k, zero, one, 0);
        if (status == KN_OK && k % 16 == 0) status = kn_progress(ctx, "fit", (double)k / (double)map->npieces);
    }
    for (int k = 0; k < NTEMP; k++) kn_bezier_clear(ctx, &b.temp[k]);
    kn_piece_grid_clear(ctx, &pieces);
    kn_scratch_release(ctx, mark);
    if (status == KN_OK) *bound = b.bound;
    return status;
}
