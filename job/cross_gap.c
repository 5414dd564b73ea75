// SPDX-License-Identifier: Apache-2.0
// How far T of two knot boxes differ near the line between them, and how far T moves near an end of the domain.
//
// Along the line itself they agree, as far as S, n and the fields are continuous there. So the coefficients of their
// difference, over the strip within delta of the line, are as small as delta^(k+1) for a base that is C^k: no
// derivative is asked for.
#include "bezier/norm_bound.h"
#include "job/cross.h"
#include "kernel/context.h"

#include <math.h>

typedef struct strip {
    double lo[2], hi[2]; // in the coordinates of the place's cell; exact
} strip;

// The largest Euclidean norm of components first .. last - 1, rounded up.
static double largest(const kn_bezier *b, int first, int last)
{
    return kn_round_up(kn_largest_vector(b, first, last - first));
}

// A term over the strip; *wrong: by how much its coefficients may be, relative to the term's largest: where the strip
// lies (a rounding of each side moves values by 2 p of them), the restriction, and later elevation.
static kn_status over_strip(kn_ctx *ctx, kn_bezier *out, double *wrong, const kn_crossing *x, int i, int j, int term,
                            const strip *s)
{
    const kn_bezier *t = &x->plan->pieces.list[x->piece[i][j]].piece.term[term];
    double origin[2], width[2], lo[2], hi[2], grown = 1.0, degree = t->degree[0] + t->degree[1];
    kn_crossing_map(origin, width, x, i, j);
    for (int c = 0; c < 2; c++) {
        lo[c] = (s->lo[c] - origin[c]) / width[c], hi[c] = (s->hi[c] - origin[c]) / width[c];
        double size = fmax(fabs(lo[c]) + fabs(1.0 - lo[c]), fabs(hi[c]) + fabs(1.0 - hi[c]));
        grown *= pow(size, t->degree[c]);
    }
    kn_bezier view = *t;
    view.rational = false;
    *wrong = kn_round_up(kn_gamma_up(5.0 * degree + 4.0 + 8.0 * degree + 2.0 * (degree + 4.0)) * grown * 1.01);
    return kn_bezier_restrict(ctx, out, &view, lo, hi);
}

// What the terms of both sides come to, at heights up to top: sums over terms of top^power times ..
typedef struct sums {
    double difference, weight_difference; // .. how far they differ; of the weights
    double value, weight;                 // .. the size of one of them; the least weight
    double rounding;                      // .. the size of the coefficients that are composed, times their growth
} sums;

// What is compared: T of two boxes over one strip, or of one box over a strip and along its middle.
typedef struct sides {
    int a[2], b[2];
    strip over_a, over_b;
} sides;

static kn_status add_term(kn_ctx *ctx, sums *s, const kn_crossing *x, const sides *of, int term)
{
    const int *a = of->a, *b = of->b;
    const kn_shell_piece *p = &x->plan->pieces.list[x->piece[a[0]][a[1]]].piece;
    const kn_shell_piece *q = &x->plan->pieces.list[x->piece[b[0]][b[1]]].piece;
    kn_bezier left = {0}, right = {0}, d = {0};
    double wrong[2], scale = pow(x->top, p->power[term]) * (1.0 + 0x1p-40);
    bool rational = p->term[0].rational;
    kn_status status = over_strip(ctx, &left, &wrong[0], x, a[0], a[1], term, &of->over_a);
    if (status == KN_OK) status = over_strip(ctx, &right, &wrong[1], x, b[0], b[1], term, &of->over_b);
    if (status == KN_OK) status = kn_bezier_difference(ctx, &d, &left, &right);
    if (status == KN_OK) {
        double off = wrong[0] * largest(&p->term[term], 0, 3) + wrong[1] * largest(&q->term[term], 0, 3);
        double size = fmax(largest(&left, 0, 3), largest(&right, 0, 3));
        s->difference += kn_round_up((largest(&d, 0, 3) + off) * scale);
        s->value += kn_round_up((size + off) * scale);
        s->rounding += kn_round_up(
            fmax(largest(&p->term[term], 0, p->term[term].ncomp), largest(&q->term[term], 0, q->term[term].ncomp)) *
            scale);
    }
    if (status == KN_OK && rational && term == 0) {
        double off = wrong[0] * largest(&p->term[0], 3, 4) + wrong[1] * largest(&q->term[0], 3, 4);
        size_t n = kn_bezier_count(&left), m = kn_bezier_count(&right);
        s->weight_difference = kn_round_up(largest(&d, 3, 4) + off);
        s->weight = INFINITY;
        for (size_t i = 0; i < n; i++) s->weight = fmin(s->weight, left.coef[3 * n + i] - off);
        for (size_t i = 0; i < m; i++) s->weight = fmin(s->weight, right.coef[3 * m + i] - off);
    }
    kn_bezier_clear(ctx, &left);
    kn_bezier_clear(ctx, &right);
    kn_bezier_clear(ctx, &d);
    return status;
}

// The rounding of composing and of the products with w, relative to coefficients in absolute values
// (kn_bezier_compose), which D's reach beyond the box makes larger.
static double composition(const kn_crossing *x, const kn_shell_piece *piece, const int a[2])
{
    double origin[2], width[2], most = 0.0, terms = 1.0;
    for (int v = 0; v < x->d->nvars; v++) terms *= x->d->degree[v] + 1.0;
    kn_crossing_map(origin, width, x, a[0], a[1]);
    for (int t = 0; t < piece->nterms; t++) {
        double grown = 1.0, p = piece->term[t].degree[0] + piece->term[t].degree[1] + piece->power[t];
        for (int c = 0; c < 2; c++) {
            double lo = (x->lo[c] - origin[c]) / width[c], hi = (x->hi[c] - origin[c]) / width[c];
            double size = fmax(fabs(lo) + fabs(1.0 - lo), fabs(hi) + fabs(1.0 - hi));
            grown *= pow(size, piece->term[t].degree[c]);
        }
        double fold = (piece->term[t].degree[0] + 1.0) * (piece->term[t].degree[1] + 1.0);
        most = fmax(most, kn_gamma_up(p * (terms + 9.0) + fold + 8.0) * grown);
    }
    return kn_round_up(most * 1.01);
}

double kn_crossing_rounding(const kn_crossing *x, int i, int j)
{
    const kn_shell_piece *piece = &x->plan->pieces.list[x->piece[i][j]].piece;
    double size = 0.0;
    for (int t = 0; t < piece->nterms; t++)
        size += largest(&piece->term[t], 0, piece->term[t].ncomp) * pow(x->top, piece->power[t]);
    return kn_round_up(composition(x, piece, (const int[2]){i, j}) * size * 1.01);
}

static kn_status compare(kn_ctx *ctx, double *gap, const kn_crossing *x, const sides *of)
{
    const kn_shell_piece *p = &x->plan->pieces.list[x->piece[of->a[0]][of->a[1]]].piece;
    const kn_shell_piece *q = &x->plan->pieces.list[x->piece[of->b[0]][of->b[1]]].piece;
    *gap = INFINITY;
    if (p->nterms != q->nterms || p->term[0].rational != q->term[0].rational) return KN_OK;
    for (int t = 0; t < p->nterms; t++)
        if (p->power[t] != q->power[t]) return KN_OK;
    sums sum = {.weight = 1.0};
    kn_status status = KN_OK;
    for (int t = 0; status == KN_OK && t < p->nterms; t++) status = add_term(ctx, &sum, x, of, t);
    if (status != KN_OK || !(sum.weight > 0.0)) return status;
    double rounding = (composition(x, p, of->a) + composition(x, q, of->b)) * sum.rounding;
    double value = sum.value / sum.weight; // |P/w - Q/v| <= (|P - Q| + |Q/v| |w - v|) / w
    double moved = sum.difference + value * sum.weight_difference + rounding * (1.0 + value);
    *gap = kn_round_up(moved / sum.weight);
    return KN_OK;
}

// Within delta of a line in variable var, between the lines and ends of the other one, in which k counts boxes.
static strip strip_along(const kn_crossing *x, int var, int k, double line, double delta)
{
    strip s;
    int across = 1 - var;
    const double margin = 0x1p-7; // what the other variable's cuts may be off
    double lo = floor(x->lo[across] * 64.0) / 64.0, hi = ceil(x->hi[across] * 64.0) / 64.0;
    s.lo[var] = line - delta, s.hi[var] = line + delta;
    s.lo[across] = k > 0 ? x->line[across][k - 1] - margin : fmax(lo, x->end[across][0] - margin);
    s.hi[across] = k < x->n[across] ? x->line[across][k] + margin : fmin(hi, x->end[across][1] + margin);
    return s;
}

kn_status kn_crossing_gap(kn_ctx *ctx, double *gap, const kn_crossing *x, int var, int i, int j, double delta)
{
    strip s = strip_along(x, var, var == 0 ? j : i, x->line[var][var == 0 ? i : j], delta);
    return compare(ctx, gap, x, &(sides){{i, j}, {i + (var == 0), j + (var == 1)}, s, s});
}

kn_status kn_crossing_shift(kn_ctx *ctx, double *gap, const kn_crossing *x, int var, int at, int i, int j,
                            double delta)
{
    strip s = strip_along(x, var, var == 0 ? j : i, x->end[var][at], delta), line = s;
    line.lo[var] = line.hi[var] = x->end[var][at];
    return compare(ctx, gap, x, &(sides){{i, j}, {i, j}, s, line});
}

// ---- how fast T moves ----

// |N / W|' <= (|N'| + |N / W| |W'|) / W, with N taken from a point near the surface so that the quotient is no larger
// than the piece. N = the sum of the terms times w^k.
kn_status kn_crossing_speed(kn_ctx *ctx, double *speed, const kn_crossing *x, int i, int j)
{
    const kn_shell_piece *piece = &x->plan->pieces.list[x->piece[i][j]].piece;
    double rise[2] = {0.0, 0.0}, bend[2] = {0.0, 0.0}, size = 0.0, weight = 1.0, center[3] = {0.0, 0.0, 0.0};
    strip box;
    kn_status status = KN_OK;
    for (int c = 0; c < 2; c++) {
        double least = fmax((x->hi[c] - x->lo[c]) / 64.0, 0x1p-20); // a flat side is no box
        box.lo[c] = x->lo[c] - least, box.hi[c] = x->hi[c] + least;
    }
    for (int t = 0; status == KN_OK && t < piece->nterms; t++) {
        kn_bezier part = {0}, own = {0};
        double wrong, moved[2], scale = pow(x->top, piece->power[t]) * (1.0 + 0x1p-40);
        status = over_strip(ctx, &part, &wrong, x, i, j, t, &box);
        size_t n = status == KN_OK ? kn_bezier_count(&part) : 0;
        if (status == KN_OK && t == 0 && piece->term[0].rational) {
            double off = wrong * largest(&piece->term[0], 3, 4);
            weight = INFINITY;
            for (size_t k = 0; k < n; k++) weight = fmin(weight, part.coef[3 * n + k] - off);
            for (size_t c = 0; c < 3; c++) center[c] = part.coef[c * n] / part.coef[3 * n];
            for (size_t k = 0; k < 3 * n; k++) part.coef[k] -= center[k / n] * part.coef[3 * n + k % n];
            status = kn_bezier_components(ctx, &own, &part, 3, 1);
            if (status == KN_OK) status = kn_bezier_lipschitz(ctx, bend, &own);
        }
        if (status == KN_OK) status = kn_bezier_components(ctx, &own, &part, 0, 3);
        if (status == KN_OK) status = kn_bezier_lipschitz(ctx, moved, &own);
        double slack = status == KN_OK ? 4.0 * wrong * largest(&piece->term[t], 0, piece->term[t].ncomp) : 0.0;
        for (int c = 0; status == KN_OK && c < 2; c++)
            rise[c] += (moved[c] + 2.0 * (piece->term[t].degree[c] + 1.0) * slack) * scale;
        if (status == KN_OK) size += (largest(&own, 0, 3) + slack) * scale;
        kn_bezier_clear(ctx, &part);
        kn_bezier_clear(ctx, &own);
    }
    *speed = INFINITY;
    if (status != KN_OK || !(weight > 0.0)) return status;
    double both = 0.0;
    for (int c = 0; c < 2; c++)
        both += pow((rise[c] + size / weight * bend[c]) / weight / (box.hi[c] - box.lo[c]), 2.0);
    *speed = kn_round_up(sqrt(both) * (1.0 + 1e-12));
    return KN_OK;
}
