// SPDX-License-Identifier: Apache-2.0
// The Jacobian of T over one box of the shell's grid.
#include "kernel/context.h"
#include "kernel/knots.h"
#include "trivar/internal.h"

#include <math.h>

void kn_shell_jacobian_piece_clear(kn_ctx *ctx, kn_shell_jacobian_piece *piece)
{
    kn_bezier_clear(ctx, &piece->j);
    kn_bezier_clear(ctx, &piece->denominator);
    *piece = (kn_shell_jacobian_piece){0};
}

void kn_shell_jacobian_grid(const kn_shell *shell, int boxes[3])
{
    for (int v = 0; v < 2; v++) boxes[v] = shell->nboxes[v];
    boxes[2] = shell->volume.coef ? kn_spline_spans(&shell->volume, 2) : 1;
}

// The control points that act on a box: n of them from `first` on in each variable.
typedef struct block {
    size_t first[3], side[3], n;
} block;

static block block_around(const kn_spline *s, const double *at)
{
    block b = {{0}, {1, 1, 1}, 1};
    for (int v = 0; v < s->nvars && v < 3; v++) {
        b.side[v] = (size_t)s->degree[v] + 1;
        b.first[v] = (size_t)(kn_knots_span(s->knots[v], s->degree[v], s->count[v], at[v]) - s->degree[v]);
        b.n *= b.side[v];
    }
    return b;
}

// Point k of the block in the arrays of s.
static size_t point_of(const kn_spline *s, const block *b, size_t k)
{
    size_t index[3] = {k / b->side[2] / b->side[1], k / b->side[2] % b->side[1], k % b->side[2]}, flat = 0;
    for (int v = 0; v < s->nvars; v++) flat = flat * (size_t)s->count[v] + b->first[v] + index[v];
    return flat;
}

// The largest vector and weight among the control points that act on the box around `at`.
static void acting(double *vector, double *weight, const kn_spline *s, const double *at)
{
    size_t count = kn_spline_count(s), dim = (size_t)kn_spline_dim(s);
    block b = block_around(s, at);
    double square = 0.0;
    *weight = 0.0;
    for (size_t k = 0; k < b.n; k++) {
        const double *c = s->coef + point_of(s, &b, k);
        double length = 0.0;
        for (size_t m = 0; m < dim; m++) length += c[m * count] * c[m * count];
        square = length > square ? length : square;
        if (s->rational) *weight = fmax(*weight, c[dim * count]);
    }
    *vector = sqrt(square);
}

// What is the same among them, in n components from `component` on.
static kn_same same_points(const kn_spline *s, const double *at, int component, int n)
{
    size_t count = kn_spline_count(s);
    block b = block_around(s, at);
    unsigned all = (1u << n) - 1u;
    kn_same same = {all, {all, all, all}};
    for (size_t k = 0; k < b.n; k++) {
        size_t inner[3] = {b.side[1] * b.side[2], b.side[2], 1};
        for (int c = 0; c < n; c++) {
            const double *x = s->coef + (size_t)(component + c) * count;
            double here = x[point_of(s, &b, k)];
            if (here != 0.0) same.none &= ~(1u << c);
            for (int v = 0; v < s->nvars; v++)
                if (k / inner[v] % b.side[v] > 0 && x[point_of(s, &b, k - inner[v])] != here)
                    same.alike[v] &= ~(1u << c);
        }
    }
    return same;
}

static void clear_map(kn_ctx *ctx, kn_box_map *map)
{
    for (int k = 0; k < KN_BOX_TERMS; k++) kn_bezier_clear(ctx, &map->term[k]);
    kn_bezier_clear(ctx, &map->weight);
}

// ---- S + w h n + fields ----

// The box in the coordinates of the span of S that holds it.
typedef struct place {
    size_t span;
    double lo[2], hi[2], middle[2]; // the middle in the parameters of T
} place;

static place locate(kn_box_map *map, const kn_shell *s, const double lo[2], const double hi[2])
{
    place p = {0};
    for (int v = 0; v < 2; v++) {
        const double cut[2] = {lo[v], hi[v]}, *knot = s->knot[v];
        int from = kn_interval(knot, s->nknots[v], cut[0]);
        double a = knot[from], width = knot[from + 1] - a;
        p.lo[v] = (cut[0] - a) / width;
        p.hi[v] = cut[1] == knot[from + 1] ? 1.0 : (cut[1] - a) / width;
        p.span = v == 0 ? (size_t)from : p.span * (size_t)(s->nknots[1] - 1) + (size_t)from;
        p.middle[v] = cut[0] + 0.5 * (cut[1] - cut[0]);
        map->width[v] = cut[1] - cut[0];
        map->knot[v] = width;
        map->span[v] = knot[s->nknots[v] - 1] - knot[0];
    }
    return p;
}

// What extraction leaves in a piece of a spline, in units of its largest control point, which may exceed the piece.
static double extraction(const kn_spline *s)
{
    int top = 8;
    for (int v = 0; v < s->nvars; v++) top += s->degree[v];
    return kn_gamma(32.0 * top);
}

static kn_status take_surface(kn_ctx *ctx, kn_box_map *map, const kn_shell *s, const place *p)
{
    kn_bezier piece = {0};
    double vector, weight;
    kn_status status = kn_bezier_restrict(ctx, &piece, &s->local_span[p->span], p->lo, p->hi);
    if (status == KN_OK) status = kn_bezier_components(ctx, &map->term[0], &piece, 0, 3);
    if (status == KN_OK && piece.rational) status = kn_bezier_components(ctx, &map->weight, &piece, 3, 1);
    acting(&vector, &weight, &s->local, p->middle);
    map->same[0] = same_points(&s->local, p->middle, 0, 3);
    if (piece.rational) map->weight_same = same_points(&s->local, p->middle, 3, 1);
    map->error[0] = extraction(&s->local) * vector;
    map->weight_error = extraction(&s->local) * weight;
    map->weight_size = piece.rational ? weight : 1.0;
    map->size = s->size, map->slack = s->slack;
    kn_bezier_clear(ctx, &piece);
    return status;
}

// h n: the error of a product, beside those of its factors.
static kn_status take_thickness(kn_ctx *ctx, kn_box_map *map, const kn_shell *s, const place *p)
{
    kn_bezier h = {0}, *n = &map->term[1];
    double size = kn_largest_vector(n, 0, 3), most, none;
    kn_status status = kn_bezier_restrict(ctx, &h, &s->thickness.span[p->span], p->lo, p->hi);
    if (status == KN_OK) status = kn_bezier_product(ctx, n, n, &h);
    acting(&most, &none, &s->thickness.whole, p->middle);
    double error = extraction(&s->thickness.whole) * most;
    if (status == KN_OK) {
        double round = kn_gamma(2.0 * (double)kn_bezier_count(&h) + 64.0) * size * most;
        map->error[1] = 1.001 * (map->error[1] * (most + error) + error * size + round);
        kn_same same = same_points(&s->thickness.whole, p->middle, 0, 1), *own = &map->same[1];
        if (same.none != 0) own->none = 7u;
        for (int v = 0; v < 2; v++) own->alike[v] = same.alike[v] != 0 ? own->alike[v] | own->none : own->none;
    }
    kn_bezier_clear(ctx, &h);
    return status;
}

// n over the box, which lies between two of its knots.
static kn_status take_normal(kn_ctx *ctx, kn_bezier *out, const kn_shell *s, const double lo[2], const double hi[2])
{
    size_t piece = 0;
    double from[2], to[2];
    for (int v = 0; v < 2; v++) {
        int at = kn_interval(s->cut[v], s->ncuts[v], lo[v]);
        double a = s->cut[v][at], b = s->cut[v][at + 1];
        from[v] = (lo[v] - a) / (b - a);
        to[v] = hi[v] == b ? 1.0 : (hi[v] - a) / (b - a);
        piece = v == 0 ? (size_t)at : piece * (size_t)(s->ncuts[1] - 1) + (size_t)at;
    }
    return kn_bezier_restrict(ctx, out, &s->normal_piece[piece], from, to);
}

static kn_status take_terms(kn_ctx *ctx, kn_box_map *map, const kn_shell *s, const double lo[2], const double hi[2])
{
    place p = locate(map, s, lo, hi);
    double vector, weight;
    map->nvars = 2, map->nterms = 1;
    kn_status status = take_surface(ctx, map, s, &p);
    if (status == KN_OK && s->normal.coef) {
        status = take_normal(ctx, &map->term[1], s, lo, hi);
        acting(&vector, &weight, &s->normal, p.middle);
        map->error[1] = extraction(&s->normal) * vector;
        map->same[1] = same_points(&s->normal, p.middle, 0, 3);
        map->power[1] = 1, map->nterms = 2;
        if (status == KN_OK && s->thickness.whole.coef) status = take_thickness(ctx, map, s, &p);
    }
    for (int k = 0; k < s->nfields && status == KN_OK; k++) {
        if (map->nterms == KN_BOX_TERMS)
            return kn_fail(ctx, KN_ELIMIT, "shell: the Jacobian of more than %d terms", (int)KN_BOX_TERMS);
        int t = map->nterms++;
        status = kn_bezier_restrict(ctx, &map->term[t], &s->field[k].span[p.span], p.lo, p.hi);
        acting(&vector, &weight, &s->field[k].whole, p.middle);
        map->error[t] = extraction(&s->field[k].whole) * vector;
        map->same[t] = same_points(&s->field[k].whole, p.middle, 0, 3);
        map->power[t] = s->field[k].power;
    }
    return status;
}

// ---- a volume ----

static double knot_width(const kn_spline *s, int var, double x)
{
    int k = kn_knots_span(s->knots[var], s->degree[var], s->count[var], x);
    return s->knots[var][k + 1] - s->knots[var][k];
}

static kn_status take_volume(kn_ctx *ctx, kn_box_map *map, const kn_shell *s, const double lo[3], const double hi[3])
{
    kn_spline part = {0};
    double vector, weight, middle[3] = {0};
    map->nvars = 3, map->nterms = 1;
    for (int v = 0; v < 3; v++) {
        double a, b;
        kn_spline_domain(&s->volume, v, &a, &b);
        map->width[v] = hi[v] - lo[v];
        middle[v] = lo[v] + 0.5 * (hi[v] - lo[v]);
        map->knot[v] = knot_width(&s->volume, v, middle[v]);
        map->span[v] = b - a;
    }
    kn_status status = kn_spline_restrict(ctx, &part, &s->local, lo, hi);
    kn_bezier piece = {.nvars = 3, .ncomp = part.ncomp, .coef = part.coef};
    for (int v = 0; v < 3; v++) piece.degree[v] = part.degree[v];
    if (status == KN_OK) status = kn_bezier_components(ctx, &map->term[0], &piece, 0, 3);
    if (status == KN_OK && part.rational) status = kn_bezier_components(ctx, &map->weight, &piece, 3, 1);
    acting(&vector, &weight, &s->local, middle);
    map->same[0] = same_points(&s->local, middle, 0, 3);
    if (part.rational) map->weight_same = same_points(&s->local, middle, 3, 1);
    map->error[0] = extraction(&s->local) * vector;
    map->weight_error = extraction(&s->local) * weight;
    map->weight_size = part.rational ? weight : 1.0;
    map->size = s->size, map->slack = s->slack;
    kn_spline_clear(ctx, &part);
    return status;
}

// Knot interval `at` of the volume in w.
static void heights(double *lo, double *hi, const kn_spline *volume, int at)
{
    const double *t = volume->knots[2] + volume->degree[2];
    int n = volume->count[2] - volume->degree[2], seen = -1;
    for (int k = 0; k < n; k++)
        if (t[k] < t[k + 1] && ++seen == at) *lo = t[k], *hi = t[k + 1];
}

kn_status kn_jacobian_box(kn_ctx *ctx, kn_shell_jacobian_piece *out, const kn_shell *shell, double *const breaks[2],
                          const int at[3], bool divided)
{
    kn_box_map map = {0};
    kn_shell_jacobian_piece p = {.lo = {0.0, 0.0, -INFINITY}, .hi = {0.0, 0.0, INFINITY}};
    for (int v = 0; v < 2; v++) {
        p.lo[v] = breaks[v][at[v]];
        p.hi[v] = breaks[v][at[v] + 1];
        p.cell[v] = kn_interval(shell->line[v], shell->nlines[v], p.lo[v]);
    }
    if (shell->volume.coef) heights(&p.lo[2], &p.hi[2], &shell->volume, at[2]);
    kn_status status = shell->volume.coef ? take_volume(ctx, &map, shell, p.lo, p.hi)
                                          : take_terms(ctx, &map, shell, p.lo, p.hi);
    if (status == KN_OK) status = kn_jacobian_of(ctx, &p, &map, divided);
    clear_map(ctx, &map);
    if (status == KN_OK)
        *out = p;
    else
        kn_shell_jacobian_piece_clear(ctx, &p);
    return status;
}

kn_status kn_shell_jacobian_piece_init(kn_ctx *ctx, kn_shell_jacobian_piece *out, const kn_shell *shell,
                                       const int box[3])
{
    int boxes[3];
    kn_shell_jacobian_grid(shell, boxes);
    for (int v = 0; v < 3; v++)
        if (box[v] < 0 || box[v] >= boxes[v])
            return kn_fail(ctx, KN_EDOMAIN, "shell: box %d of %d in variable %d", box[v], boxes[v], v);
    return kn_jacobian_box(ctx, out, shell, shell->box, box, true);
}
