// SPDX-License-Identifier: Apache-2.0
// One surface in the place of a grid of patches: their Bezier pieces on common knots, joined as smoothly as they are.
//
// Patches in a column have one width in the parameter, such that derivatives across the seams agree: where cells have
// different widths their ratio is that of the derivatives. What joining changes is bounded by the control points of
// the difference, piece by piece.
#include "io/merge.h"

#include <math.h>
#include <string.h>

#include "bezier/norm_bound.h"
#include "fit/limit.h"
#include "kernel/context.h"

enum { MOST_CONTINUITY = 2 };

typedef struct board {
    const kn_merge_item *items;
    const int *list;
    int n[2]; // columns, rows
    kn_spline *turned;
    double *width[2];  // of columns, rows
    int *spans[2];     // equal ones, of columns, rows
    double *breaks[2]; // of the whole
    int nbreaks[2];
    kn_bezier *pieces;
    size_t npieces;
} board;

// new (i, j) = old (n0 - 1 - j, i), once for each quarter.
kn_status kn_merge_turn(kn_ctx *ctx, kn_spline *turned, const kn_merge_item *item)
{
    kn_status status = kn_spline_copy(ctx, turned, &item->surface);
    for (int k = 0; k < item->turn && status == KN_OK; k++) {
        kn_spline s = {0};
        kn_mark mark = kn_scratch_mark(ctx);
        int degree[2] = {turned->degree[1], turned->degree[0]}, count[2] = {turned->count[1], turned->count[0]};
        size_t n0 = (size_t)turned->count[0], n1 = (size_t)turned->count[1], all = n0 * n1;
        size_t nknots = n0 + (size_t)turned->degree[0] + 1;
        double *coef = kn_scratch(ctx, all * (size_t)turned->ncomp, sizeof *coef);
        double *back = kn_scratch(ctx, nknots, sizeof *back);
        status = coef && back ? KN_OK : KN_ENOMEM;
        for (size_t c = 0; status == KN_OK && c < (size_t)turned->ncomp; c++)
            for (size_t i = 0; i < n1; i++)
                for (size_t j = 0; j < n0; j++)
                    coef[c * all + i * n0 + j] = turned->coef[c * all + (n0 - 1 - j) * n1 + i];
        for (size_t i = 0; status == KN_OK && i < nknots; i++) back[i] = 1.0 - turned->knots[0][nknots - 1 - i];
        if (status == KN_OK)
            status = kn_spline_init(ctx, &s, 2, turned->ncomp, turned->rational, degree, count,
                                    (const double *const[]){turned->knots[1], back}, coef);
        if (status == KN_OK) kn_spline_swap(turned, &s);
        kn_spline_clear(ctx, &s);
        kn_scratch_release(ctx, mark);
    }
    return status;
}

static const kn_spline *at_place(const board *b, int column, int row)
{
    return &b->turned[row * b->n[0] + column];
}

// The lengths of the derivatives across variable v at the ends of s, where the edge is longest in that way.
static double slope(const kn_spline *s, int v, bool at_end)
{
    size_t n0 = (size_t)s->count[0], n1 = (size_t)s->count[1], m = v == 0 ? n1 : n0, step = v == 0 ? 1 : n1;
    size_t over = v == 0 ? n1 : 1, rows = (size_t)s->count[v], first = at_end ? (rows - 1) * over : 0;
    double most = 0.0, span = s->knots[v][s->degree[v] + 1] - s->knots[v][0];
    for (size_t i = 0; i < m; i++) {
        double sum = 0.0;
        for (size_t c = 0; c < 3; c++) {
            const double *x = s->coef + c * n0 * n1 + first + i * step;
            double d = at_end ? x[0] - *(x - over) : x[over] - x[0];
            sum += d * d;
        }
        most = fmax(most, sqrt(sum));
    }
    return most * s->degree[v] / span;
}

// Widths from the first row and column; the sum is 1.
static kn_status measure(kn_ctx *ctx, board *b)
{
    for (int v = 0; v < 2; v++) {
        b->width[v] = kn_scratch(ctx, (size_t)b->n[v], sizeof *b->width[v]);
        b->spans[v] = kn_scratch(ctx, (size_t)b->n[v], sizeof *b->spans[v]);
        if (!b->width[v] || !b->spans[v]) return KN_ENOMEM;
        double sum = 1.0;
        b->width[v][0] = 1.0;
        for (int i = 1; i < b->n[v]; i++) {
            const kn_spline *one = v == 0 ? at_place(b, i - 1, 0) : at_place(b, 0, i - 1);
            const kn_spline *two = v == 0 ? at_place(b, i, 0) : at_place(b, 0, i);
            double a = slope(one, v, true), c = slope(two, v, false), ratio = a > 0.0 && c > 0.0 ? c / a : 1.0;
            if (fabs(ratio - 1.0) < 1e-6) ratio = 1.0;
            b->width[v][i] = b->width[v][i - 1] * ratio;
            sum += b->width[v][i];
        }
        int at = 0, total = 1;
        for (int i = 0; i < b->n[v]; i++) {
            b->width[v][i] /= sum;
            b->spans[v][i] = 1;
            for (int k = 0; k < b->n[1 - v]; k++) {
                int spans = kn_spline_spans(v == 0 ? at_place(b, i, k) : at_place(b, k, i), v);
                if (spans > b->spans[v][i]) b->spans[v][i] = spans;
            }
            total += b->spans[v][i];
        }
        b->breaks[v] = kn_scratch(ctx, (size_t)total, sizeof *b->breaks[v]);
        if (!b->breaks[v]) return KN_ENOMEM;
        double from = 0.0;
        for (int i = 0; i < b->n[v]; from += b->width[v][i++])
            for (int k = 0; k < b->spans[v][i]; k++) b->breaks[v][at++] = from + b->width[v][i] * k / b->spans[v][i];
        b->breaks[v][at++] = 1.0;
        b->nbreaks[v] = at;
    }
    return KN_OK;
}

// All pieces of one patch, on as many equal spans as its column and row have, to their places.
static kn_status put_pieces(kn_ctx *ctx, board *b, int column, int row)
{
    kn_spline s = {0};
    kn_bezier *pieces = NULL;
    size_t n = 0;
    const int place[2] = {column, row};
    int first[2] = {0, 0};
    kn_status status = kn_spline_copy(ctx, &s, at_place(b, column, row));
    for (int v = 0; v < 2 && status == KN_OK; v++) {
        int spans = b->spans[v][place[v]];
        for (int i = 0; i < place[v]; i++) first[v] += b->spans[v][i];
        for (int k = 1; k < spans && status == KN_OK; k++) {
            double knot = (double)k / spans;
            bool there = false;
            for (int i = 0; i < s.count[v] + s.degree[v] + 1; i++) there = there || s.knots[v][i] == knot;
            if (!there) status = kn_spline_insert_knots(ctx, &s, &s, v, &knot, 1);
        }
    }
    if (status == KN_OK) status = kn_spline_to_bezier(ctx, &pieces, &n, &s);
    size_t rows = (size_t)b->spans[1][row], all = (size_t)b->nbreaks[1] - 1;
    for (size_t i = 0; i < n; i++) {
        size_t x = (size_t)first[0] + i / rows, y = (size_t)first[1] + i % rows;
        kn_bezier_clear(ctx, &b->pieces[x * all + y]);
        b->pieces[x * all + y] = pieces[i];
    }
    kn_free(ctx, pieces);
    kn_spline_clear(ctx, &s);
    return status;
}

// ---- what joining changes ----

// turn becomes that of itself and of the normals along the edge of piece q, from b's p, where variable var ends.
static kn_status turn_at(kn_ctx *ctx, kn_limit_turn *turn, const kn_bezier *p, const kn_bezier *q, int var,
                         bool at_end, double error, double rounding)
{
    int d = p->degree[1 - var];
    const size_t n[2] = {(size_t)p->degree[0] + 1, (size_t)p->degree[1] + 1};
    double *exact[2], *fit[2];
    if (d == 0 || p->degree[var] == 0) return KN_OK;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_limit_rows_at(ctx, exact, p->coef, (size_t)p->ncomp, n, var, at_end, p->degree[var]);
    if (status == KN_OK)
        status = kn_limit_rows_at(ctx, fit, q->coef, (size_t)p->ncomp, n, var, at_end, p->degree[var]);
    if (status == KN_OK) {
        const kn_limit_rows rows = {.ncomp = p->ncomp,
                                    .rational = p->rational,
                                    .along = {d, d, 0},
                                    .exact = {exact[0], exact[1]},
                                    .fit = {fit[0], fit[1]},
                                    .error = error,
                                    .rounding = {4.0 * d * rounding, 4.0 * p->degree[var] * rounding}};
        status = kn_limit_turn_of(ctx, turn, &rows);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// Along the outer edges; pieces: the merged surface's. rounding: of their control points, and of the board's.
static kn_status outer_turns(kn_ctx *ctx, kn_merged *out, const board *b, const kn_bezier *pieces, double rounding,
                             double goal)
{
    const size_t n[2] = {(size_t)b->nbreaks[0] - 1, (size_t)b->nbreaks[1] - 1};
    kn_status status = KN_OK;
    out->angle = 0.0, out->unknown_angles = out->singular_angles = 0;
    for (int e = 0; e < 4 && status == KN_OK; e++) {
        int var = e / 2, along = 1 - var;
        kn_limit_turn turn = {.goal = goal};
        for (size_t i = 0; i < n[along] && status == KN_OK; i++) {
            size_t at[2];
            at[var] = e % 2 ? n[var] - 1 : 0, at[along] = i;
            size_t k = at[0] * n[1] + at[1];
            status = turn_at(ctx, &turn, &b->pieces[k], &pieces[k], var, e % 2, out->error, rounding);
        }
        out->unknown_angles += turn.unknown;
        out->singular_angles += turn.singular && !turn.unknown;
        if (!turn.unknown) out->angle = fmax(out->angle, turn.angle);
    }
    return status;
}

// The largest distance of the pieces of s from the board's: of control points, which is no less than that of points.
// And how far normals turn, where that is no more than the limits' tolerance.
static kn_status compare(kn_ctx *ctx, kn_merged *out, const board *b, const kn_spline *s,
                         const kn_merge_options *limits)
{
    kn_bezier *pieces = NULL;
    size_t n = 0;
    double most = 0.0, large = 0.0, weight = INFINITY, dw = 0.0, most_w = 1.0;
    out->error = INFINITY;
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, s);
    for (size_t i = 0; status == KN_OK && n == b->npieces && i < n; i++) {
        const kn_bezier *p = &pieces[i], *q = &b->pieces[i];
        size_t m = kn_bezier_count(p);
        for (size_t k = 0; k < m; k++) {
            double d[3], x[3], w = p->rational ? q->coef[3 * m + k] : 1.0;
            for (size_t c = 0; c < 3; c++) d[c] = p->coef[c * m + k] - q->coef[c * m + k], x[c] = q->coef[c * m + k];
            most = fmax(most, hypot(hypot(d[0], d[1]), d[2]));
            large = fmax(large, hypot(hypot(x[0], x[1]), x[2]) / w);
            most_w = fmax(most_w, w);
            weight = fmin(weight, p->rational ? fmin(w, p->coef[3 * m + k]) : 1.0);
            dw = fmax(dw, p->rational ? fabs(p->coef[3 * m + k] - w) : 0.0);
        }
    }
    // Extraction from s and from the patches: less than 40 roundings for each degree of numbers up to the largest.
    double rounding = kn_gamma_up(40.0 * (s->degree[0] + s->degree[1] + 2)) * large *
                      (s->rational ? 2.0 / weight : 1.0);
    if (status == KN_OK && n == b->npieces && weight > 0.0)
        out->error = kn_round_up((most + dw * large) / weight) + rounding;
    // Homogeneous control points are at most max(1, w) times as wrong.
    if (status == KN_OK && out->error <= limits->tolerance && s->ncomp == 3 + s->rational)
        status = outer_turns(ctx, out, b, pieces, rounding * fmax(1.0, most_w), limits->angle);
    for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    return status;
}

// As smooth as may be without moving anything by more than the tolerance; C1 at least.
static kn_status join(kn_ctx *ctx, kn_merged *out, bool *good, const board *b, const kn_merge_options *limits)
{
    static const int tries[4][2] = {{2, 2}, {2, 1}, {1, 2}, {1, 1}};
    kn_status status = KN_OK;
    *good = false;
    for (int k = 0; k < 4 && !*good && status == KN_OK; k++) {
        kn_spline s = {0};
        const kn_bezier *p = &b->pieces[0];
        int c[2];
        for (int v = 0; v < 2; v++) {
            c[v] = tries[k][v] < p->degree[v] ? tries[k][v] : p->degree[v] - 1;
            if (b->nbreaks[v] == 2) c[v] = p->degree[v] > 0 ? 0 : -1; // no seam there
        }
        status = kn_spline_from_bezier(ctx, &s, b->pieces, b->nbreaks, (const double *const *)b->breaks, c);
        if (status == KN_OK) status = compare(ctx, out, b, &s, limits);
        *good = status == KN_OK && out->error <= limits->tolerance;
        if (limits->angle > 0.0 && !(out->angle <= limits->angle)) *good = false;
        if (*good) {
            kn_spline_swap(&out->surface, &s);
            for (int v = 0; v < 2; v++) out->continuity[v] = c[v];
        }
        kn_spline_clear(ctx, &s);
    }
    return status;
}

// ---- edges ----

// The edges of items along one side of the grid, one after the other, each over an equal part of [0,1]: the same for
// whatever lies at its other side.
static kn_status chain(kn_ctx *ctx, kn_spline *out, const board *b, int side)
{
    int along = side % 2, n = b->n[along]; // sides 0 and 2 run along columns
    size_t points = 1, at = 0, knot = 0;
    kn_spline *edge = kn_alloc_zero(ctx, (size_t)n, sizeof *edge);
    kn_status status = edge ? KN_OK : KN_ENOMEM;
    for (int i = 0; i < n && status == KN_OK; i++) {
        int column = along == 0 ? i : side == 1 ? b->n[0] - 1 : 0, row = along == 1 ? i : side == 2 ? b->n[1] - 1 : 0;
        const kn_merge_item *item = &b->items[b->list[row * b->n[0] + column]];
        static const int edge_of[4] = {2, 1, 3, 0};
        int own = (side + item->turn) % 4;
        status = kn_spline_copy(ctx, &edge[i], &item->edge[edge_of[own]]);
        // Counterclockwise sides 0 and 1 of grid and patch run upwards, 2 and 3 downwards.
        if (status == KN_OK && (own < 2) != (side < 2)) status = kn_spline_reverse(ctx, &edge[i], &edge[i], 0);
        points += status == KN_OK ? (size_t)edge[i].count[0] - 1 : 0;
    }
    kn_mark mark = kn_scratch_mark(ctx);
    size_t p = status == KN_OK ? (size_t)edge[0].degree[0] : 0, ncomp = status == KN_OK ? (size_t)edge[0].ncomp : 0;
    double *coef = kn_scratch(ctx, points * ncomp + 1, sizeof *coef);
    double *knots = kn_scratch(ctx, points + p + 1, sizeof *knots);
    if (status == KN_OK && !(coef && knots)) status = KN_ENOMEM;
    for (int i = 0; i < n && status == KN_OK; i++) {
        size_t m = (size_t)edge[i].count[0];
        if ((size_t)edge[i].degree[0] != p) status = KN_EUNDEFINED; // not of one degree
        for (size_t c = 0; c < ncomp && status == KN_OK; c++)
            memcpy(coef + c * points + at, edge[i].coef + c * m, m * sizeof *coef);
        for (size_t k = i == 0 ? 0 : p + 1; k < m + p + (i == n - 1) && status == KN_OK; k++)
            knots[knot++] = (i + edge[i].knots[0][k]) / n;
        at += m - 1;
    }
    int degree = (int)p, count = (int)points;
    if (status == KN_OK)
        status = kn_spline_init(ctx, out, 1, (int)ncomp, edge[0].rational, &degree, &count,
                                (const double *const[]){knots}, coef);
    kn_scratch_release(ctx, mark);
    for (int i = 0; i < n && edge; i++) kn_spline_clear(ctx, &edge[i]);
    kn_free(ctx, edge);
    return status;
}

static void clear(kn_ctx *ctx, board *b)
{
    for (size_t i = 0; b->pieces && i < b->npieces; i++) kn_bezier_clear(ctx, &b->pieces[i]);
    for (int i = 0; b->turned && i < b->n[0] * b->n[1]; i++) kn_spline_clear(ctx, &b->turned[i]);
    kn_free(ctx, b->pieces), kn_free(ctx, b->turned);
}

kn_status kn_merge_surface(kn_ctx *ctx, kn_merged *out, bool *good, const kn_merge_item *items, const int *list,
                           int columns, int rows, const kn_merge_options *limits)
{
    board b = {.items = items, .list = list, .n = {columns, rows}};
    kn_merged m = {.columns = columns, .rows = rows};
    kn_mark mark = kn_scratch_mark(ctx);
    *good = false;
    b.turned = kn_alloc_zero(ctx, (size_t)(columns * rows), sizeof *b.turned);
    kn_status status = b.turned ? KN_OK : KN_ENOMEM;
    for (int i = 0; i < columns * rows && status == KN_OK; i++)
        status = kn_merge_turn(ctx, &b.turned[i], &items[list[i]]);
    if (status == KN_OK) status = measure(ctx, &b);
    if (status == KN_OK) {
        b.npieces = (size_t)(b.nbreaks[0] - 1) * (size_t)(b.nbreaks[1] - 1);
        b.pieces = kn_alloc_zero(ctx, b.npieces, sizeof *b.pieces);
        status = b.pieces ? KN_OK : KN_ENOMEM;
    }
    for (int i = 0; i < columns * rows && status == KN_OK; i++)
        status = put_pieces(ctx, &b, i % columns, i / columns);
    if (status == KN_OK) status = join(ctx, &m, good, &b, limits);
    static const int side_of[4] = {3, 1, 0, 2}; // of kn_patch.edge
    for (int e = 0; e < 4 && status == KN_OK && *good; e++) status = chain(ctx, &m.edge[e], &b, side_of[e]);
    if (status == KN_EUNDEFINED) *good = false, status = KN_OK;
    if (status == KN_OK && *good) {
        *out = m;
        m = (kn_merged){.columns = 0};
    }
    kn_spline_clear(ctx, &m.surface);
    for (int e = 0; e < 4; e++) kn_spline_clear(ctx, &m.edge[e]);
    clear(ctx, &b);
    kn_scratch_release(ctx, mark);
    return status;
}
