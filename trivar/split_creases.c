// SPDX-License-Identifier: Apache-2.0
// The pieces of a surface between its creases.
//
// Along a knot line at which S is only C0 the normals of both sides have the directions a(t) and b(t), polynomials.
// Their angle is at most `angle` where a.b > 0 and |a x b| <= tan(angle) a.b, and so wherever that holds for the
// coefficients: |a x b| <= max |coefficient of a x b|, a.b >= min coefficient of a.b.
#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "kernel/knots.h"
#include "trivar/internal.h"

#include <math.h>
#include <string.h>

enum { DEPTH = 12 };

// a x b and a.b, four components, over a part of the line.
typedef struct line_search {
    size_t count;
    int degree;
    double limit, error, *stack; // 2 DEPTH + 1 places of 4 count numbers
} line_search;

// Whether the coefficients tell that the angle stays within the limit.
static bool small(const line_search *l, const double *c)
{
    double most = 0.0, least = INFINITY;
    for (size_t i = 0; i < l->count; i++) {
        double x = c[i], y = c[l->count + i], z = c[2 * l->count + i];
        most = fmax(most, sqrt(x * x + y * y + z * z));
        least = fmin(least, c[3 * l->count + i]);
    }
    most = most * (1.0 + 0x1p-50) + l->error, least -= l->error;
    return least > 0.0 && most <= l->limit * least * (1.0 - 0x1p-50); // false for NaN
}

// At the first end: whether the angle is larger there. It need not be certain, for doubt counts as a crease.
static bool large(const line_search *l, const double *c)
{
    double x = c[0], y = c[l->count], z = c[2 * l->count];
    return !(sqrt(x * x + y * y + z * z) <= l->limit * c[3 * l->count]);
}

static bool within(const line_search *l, int depth)
{
    double *now = l->stack + (size_t)(depth == 0 ? 0 : 2 * depth - 1) * 4 * l->count;
    if (small(l, now)) return true;
    if (depth == DEPTH || large(l, now)) return false;
    double *next = l->stack + (size_t)(2 * depth + 1) * 4 * l->count;
    size_t size = 4 * l->count;
    kn_bernstein_split(next, next + size, now, 4, l->degree, 1, 0.5);
    if (!within(l, depth + 1)) return false;
    memcpy(next, next + size, size * sizeof *next);
    return within(l, depth + 1);
}

// ---- one line between two spans ----

// The direction along one edge, a curve.
static kn_status edge_of(kn_ctx *ctx, kn_bezier *out, const kn_direction *d, int var, bool at_end)
{
    size_t rows = (size_t)d->n.degree[0] + 1, columns = (size_t)d->n.degree[1] + 1, n = var == 0 ? columns : rows;
    size_t start = !at_end ? 0 : var == 0 ? (rows - 1) * columns : columns - 1, step = var == 0 ? 1 : columns;
    kn_status status = kn_bezier_init(ctx, out, 1, 3, false, &d->n.degree[1 - var]);
    for (size_t i = 0; status == KN_OK && i < 3 * n; i++)
        out->coef[i] = d->n.coef[i / n * rows * columns + start + i % n * step];
    return status;
}

static kn_status edges_within(kn_ctx *ctx, bool *yes, const kn_bezier *a, double ea, const kn_bezier *b, double eb,
                              double limit)
{
    kn_bezier cross = {0}, dot = {0};
    kn_status status = kn_bezier_cross(ctx, &cross, a, b);
    if (status == KN_OK) status = kn_bezier_dot(ctx, &dot, a, b);
    kn_mark mark = kn_scratch_mark(ctx);
    if (status == KN_OK) {
        line_search l = {.count = kn_bezier_count(&dot), .degree = dot.degree[0], .limit = limit};
        double size = kn_largest_vector(a, 0, 3), other = kn_largest_vector(b, 0, 3);
        // the products' rounding, that of DEPTH halvings, and the edges' own errors
        l.error = kn_gamma(12.0 * (double)l.count + 4.0 * l.degree * DEPTH + 32.0) * size * other + ea * other +
                  eb * size + ea * eb;
        l.error *= 4.0; // six products for each component of a x b
        l.stack = kn_scratch(ctx, (2 * DEPTH + 1) * 4 * l.count, sizeof *l.stack);
        status = l.stack ? KN_OK : KN_ENOMEM;
        if (l.stack) {
            memcpy(l.stack, cross.coef, 3 * l.count * sizeof *l.stack);
            memcpy(l.stack + 3 * l.count, dot.coef, l.count * sizeof *l.stack);
            *yes = within(&l, 0);
        }
    }
    kn_scratch_release(ctx, mark);
    kn_bezier_clear(ctx, &cross);
    kn_bezier_clear(ctx, &dot);
    return status;
}

// The spans of S, and how large its control points are.
typedef struct spans {
    kn_bezier *piece;
    size_t n;
    int columns;
    double acting[2], slack;
} spans;

static kn_status smooth_between(kn_ctx *ctx, bool *yes, const spans *s, size_t below, size_t above, int var,
                                double limit)
{
    kn_direction d[2] = {{.error = 0}, {.error = 0}};
    kn_bezier edge[2] = {{0}, {0}};
    const size_t at[2] = {below, above};
    bool zero = false, none = false;
    kn_status status = KN_OK;
    for (int k = 0; k < 2 && status == KN_OK && !none; k++) {
        status = kn_direction_init(ctx, &d[k], &zero, &s->piece[at[k]], s->acting, s->slack);
        none = zero;
        if (status == KN_OK && !none) status = edge_of(ctx, &edge[k], &d[k], var, k == 0);
    }
    *yes = false;
    if (status == KN_OK && !none) status = edges_within(ctx, yes, &edge[0], d[0].error, &edge[1], d[1].error, limit);
    for (int k = 0; k < 2; k++) {
        kn_direction_clear(ctx, &d[k]);
        kn_bezier_clear(ctx, &edge[k]);
    }
    return status;
}

// ---- all lines ----

// Whether the two sides of a break that has degree + 1 knots have the same control points there.
static bool joined(const kn_spline *s, int var, double knot)
{
    int at = kn_knots_span(s->knots[var], s->degree[var], s->count[var], knot) - s->degree[var];
    size_t count = kn_spline_count(s), inner = var == 0 ? (size_t)s->count[1] : 1, other = (size_t)s->count[1 - var];
    size_t across = var == 0 ? 1 : (size_t)s->count[1];
    for (size_t i = 0; i < other * (size_t)s->ncomp; i++) {
        const double *c = s->coef + i / other * count + i % other * across + (size_t)at * inner;
        if (c[0] != *(c - inner)) return false;
    }
    return true;
}

static kn_status is_crease(kn_ctx *ctx, bool *crease, const spans *s, int var, int k, double limit)
{
    int along = var == 0 ? s->columns : (int)(s->n / (size_t)s->columns);
    kn_status status = KN_OK;
    *crease = false;
    for (int j = 0; j < along && status == KN_OK && !*crease; j++) {
        int below = var == 0 ? (k - 1) * s->columns + j : j * s->columns + k - 1;
        int above = below + (var == 0 ? s->columns : 1);
        bool smooth = false;
        status = smooth_between(ctx, &smooth, s, (size_t)below, (size_t)above, var, limit);
        *crease = !smooth;
    }
    return status;
}

// line[v]: the ends of the domain and the creases between them, n[v] of them.
static kn_status find_lines(kn_ctx *ctx, double *const line[2], int n[2], const kn_spline *s, double slack,
                            double limit)
{
    spans all = {.columns = kn_spline_spans(s, 1), .slack = slack};
    size_t count = kn_spline_count(s);
    for (size_t i = 0; i < count; i++) {
        all.acting[0] = fmax(all.acting[0], hypot(hypot(s->coef[i], s->coef[count + i]), s->coef[2 * count + i]));
        if (s->rational) all.acting[1] = fmax(all.acting[1], s->coef[3 * count + i]);
    }
    kn_status status = kn_spline_to_bezier(ctx, &all.piece, &all.n, s);
    kn_mark mark = kn_scratch_mark(ctx);
    for (int v = 0; v < 2 && status == KN_OK; v++) {
        int breaks = kn_spline_spans(s, v) + 1;
        double *at = kn_scratch(ctx, (size_t)breaks, sizeof *at);
        int *times = kn_scratch(ctx, (size_t)breaks, sizeof *times);
        if (!at || !times) status = KN_ENOMEM;
        if (status == KN_OK) kn_knots_breaks(at, times, s->knots[v], s->degree[v], s->count[v]);
        n[v] = 0;
        for (int k = 0; k < breaks && status == KN_OK; k++) {
            bool crease = k == 0 || k == breaks - 1;
            if (!crease && times[k] > s->degree[v]) crease = !joined(s, v, at[k]);
            if (!crease && times[k] >= s->degree[v]) status = is_crease(ctx, &crease, &all, v, k, limit);
            if (crease) line[v][n[v]++] = at[k];
            if (status == KN_OK) status = kn_progress(ctx, "creases", (v + (double)k / breaks) / 2.0);
        }
    }
    kn_scratch_release(ctx, mark);
    for (size_t i = 0; i < all.n; i++) kn_bezier_clear(ctx, &all.piece[i]);
    kn_free(ctx, all.piece);
    return status;
}

static kn_status cut(kn_ctx *ctx, kn_spline **out, const kn_spline *s, double *const line[2], const int n[2])
{
    size_t rows = (size_t)n[0] - 1, columns = (size_t)n[1] - 1;
    kn_spline *piece = kn_alloc_zero(ctx, rows * columns, sizeof *piece);
    kn_status status = piece ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; i < rows * columns && status == KN_OK; i++) {
        const double lo[2] = {line[0][i / columns], line[1][i % columns]};
        const double hi[2] = {line[0][i / columns + 1], line[1][i % columns + 1]};
        status = rows * columns == 1 ? kn_spline_copy(ctx, &piece[i], s)
                                     : kn_spline_restrict(ctx, &piece[i], s, lo, hi);
    }
    if (status == KN_OK) {
        *out = piece;
        return KN_OK;
    }
    for (size_t i = 0; piece && i < rows * columns; i++) kn_spline_clear(ctx, &piece[i]);
    kn_free(ctx, piece);
    return status;
}

kn_status kn_shell_split_creases(kn_ctx *ctx, kn_spline **pieces, int counts[2], const kn_spline *surface,
                                 double angle)
{
    const double most = 1.57; // below a right angle, where the tangent ends
    kn_status status = kn_spline_check(ctx, surface);
    if (status != KN_OK) return status;
    if (surface->nvars != 2 || kn_spline_dim(surface) != 3 || surface->degree[0] < 1 || surface->degree[1] < 1)
        return kn_fail(ctx, KN_EDOMAIN, "creases: %d variables and %d components, not a surface in space",
                       surface->nvars, kn_spline_dim(surface));
    if (!(angle >= 0.0 && angle <= most)) return kn_fail(ctx, KN_EDOMAIN, "creases: an angle of %g", angle);
    int n[2];
    kn_mark mark = kn_scratch_mark(ctx);
    double *line[2];
    for (int v = 0; v < 2; v++) line[v] = kn_scratch(ctx, (size_t)kn_spline_spans(surface, v) + 1, sizeof *line[v]);
    kn_spline local = {0};
    status = line[0] && line[1] ? kn_spline_to_origin(ctx, &local, surface) : KN_ENOMEM;
    if (status == KN_OK) status = find_lines(ctx, line, n, &local, kn_extent_of(surface).slack, tan(angle));
    kn_spline_clear(ctx, &local);
    if (status == KN_OK) status = cut(ctx, pieces, surface, line, n);
    for (int v = 0; v < 2 && status == KN_OK; v++) counts[v] = n[v] - 1;
    kn_scratch_release(ctx, mark);
    return status;
}
