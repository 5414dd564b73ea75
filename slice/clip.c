// SPDX-License-Identifier: Apache-2.0
// Contours of trimmed patches: a polyline in the parameter plane, cut by the loops of a trim.
//
// Where the two cross is found segment by segment; which parts lie inside is asked of the middle of each, so that a
// crossing too many, or one that rounding hid, spoils nothing else. An end is then moved along the trim's segment to
// the zero of f there.
#include "slice/internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- the region ----

enum { MOST_STEPS = 4096 };

// Points of a Bezier curve but its last one, with chords within tol: |c''| h^2 / 8.
static kn_status add_piece(kn_ctx *ctx, kn_outline *out, const kn_bezier *b, double tol)
{
    int p = b->degree[0], steps = 1;
    double bend = 0.0;
    for (int i = 0; i + 2 <= p; i++) {
        const double *x = b->coef + i, *y = b->coef + p + 1 + i;
        bend = fmax(bend, hypot(x[0] - 2.0 * x[1] + x[2], y[0] - 2.0 * y[1] + y[2]));
    }
    if (p > 1) steps = (int)ceil(fmin(fmax(sqrt(1.01 * p * (p - 1) * bend / (8.0 * tol)), 1.0), MOST_STEPS));
    kn_status status = kn_outline_add(ctx, out, (const double[2]){b->coef[0], b->coef[p + 1]});
    for (int k = 1; status == KN_OK && k < steps; k++) {
        double at = (double)k / steps, point[2];
        status = kn_bezier_eval(ctx, point, b, &at);
        if (status == KN_OK) status = kn_outline_add(ctx, out, point);
    }
    return status;
}

kn_status kn_slice_outline(kn_ctx *ctx, kn_outline *out, const kn_trim *trim, double tol)
{
    kn_status status = KN_OK;
    out->loop_end = kn_alloc(ctx, (size_t)trim->nloops, sizeof *out->loop_end);
    if (!out->loop_end) return KN_ENOMEM;
    for (int i = 0, k = 0; status == KN_OK && i < trim->nloops; i++) {
        for (; status == KN_OK && k < trim->loop_end[i]; k++) {
            kn_bezier *pieces = NULL;
            size_t n = 0;
            status = kn_spline_to_bezier(ctx, &pieces, &n, &trim->curves[k]);
            for (size_t b = 0; status == KN_OK && b < n; b++) status = add_piece(ctx, out, &pieces[b], tol);
            for (size_t b = 0; b < n; b++) kn_bezier_clear(ctx, &pieces[b]);
            kn_free(ctx, pieces);
        }
        out->loop_end[out->nloops++] = out->n;
    }
    return status;
}

// ---- crossings ----

typedef struct crossing {
    double where; // segment of the curve, and how far along it
    double at[2];
} crossing;

typedef struct clipping {
    const kn_outline *region;
    const kn_solve_curve *curve;
    const kn_bezier *f;
    double tol;
    crossing *list;
    size_t n;
} clipping;

static double side_of(const double *a, const double *b, const double *p)
{
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

static bool apart(const double *p, const double *q, const double *a, const double *b)
{
    for (int c = 0; c < 2; c++)
        if (fmax(p[c], q[c]) < fmin(a[c], b[c]) || fmax(a[c], b[c]) < fmin(p[c], q[c])) return true;
    return false;
}

static bool runs_down(const double *a, const double *b)
{
    return a[0] > b[0] || (a[0] == b[0] && a[1] > b[1]);
}

static void point_between(double out[2], const double *a, const double *b, double s)
{
    for (int c = 0; c < 2; c++) out[c] = s <= 0.5 ? a[c] + s * (b[c] - a[c]) : b[c] - (1.0 - s) * (b[c] - a[c]);
}

static kn_status value(kn_ctx *ctx, double *out, const kn_bezier *f, const double *a, const double *b, double s)
{
    double at[2];
    point_between(at, a, b, s);
    return kn_bezier_eval(ctx, out, f, at);
}

// A part of [0,1] around s at whose ends f along a b has different signs; *found: there is one, about tol wide.
static kn_status bracket(kn_ctx *ctx, bool *found, double end[2], double value_at[2], const clipping *c,
                         const double *a, const double *b, double s)
{
    double width = c->tol / hypot(b[0] - a[0], b[1] - a[1]);
    kn_status status = KN_OK;
    *found = false;
    for (int k = 0; status == KN_OK && !*found && k < 7; k++, width *= 2.0) {
        end[0] = fmax(s - width, 0.0), end[1] = fmin(s + width, 1.0);
        for (int e = 0; status == KN_OK && e < 2; e++) status = value(ctx, &value_at[e], c->f, a, b, end[e]);
        *found = status == KN_OK && (value_at[0] < 0.0) != (value_at[1] < 0.0);
    }
    return status;
}

// Moves a crossing along a b to the zero of f there (Illinois), unless that is farther than tol from the curve's p q.
static kn_status refine(kn_ctx *ctx, double at[2], const clipping *c, const double *a, const double *b,
                        const double *p, const double *q, double s)
{
    bool found;
    double end[2], f[2], x;
    kn_status status = bracket(ctx, &found, end, f, c, a, b, s);
    for (int step = 0, stays = -1; status == KN_OK && found && step < 60 && end[1] - end[0] > 0x1p-51; step++) {
        double middle = end[0] + (end[1] - end[0]) * (step % 4 == 3 ? 0.5 : f[0] / (f[0] - f[1]));
        if (!(middle > end[0] && middle < end[1])) break;
        status = value(ctx, &x, c->f, a, b, middle);
        if (status != KN_OK) break;
        int e = (x < 0.0) == (f[0] < 0.0) ? 0 : 1;
        end[e] = middle, f[e] = x;
        if (stays == e) f[1 - e] *= 0.5;
        stays = e;
    }
    if (status != KN_OK || !found) return status;
    double zero[2], d[2] = {q[0] - p[0], q[1] - p[1]}, l = d[0] * d[0] + d[1] * d[1];
    point_between(zero, a, b, fabs(f[0]) < fabs(f[1]) ? end[0] : end[1]);
    double t = l > 0.0 ? fmin(fmax(((zero[0] - p[0]) * d[0] + (zero[1] - p[1]) * d[1]) / l, 0.0), 1.0) : 0.0;
    if (hypot(zero[0] - p[0] - t * d[0], zero[1] - p[1] - t * d[1]) <= 0.99 * c->tol) memcpy(at, zero, sizeof zero);
    return KN_OK;
}

// Crossings of segment i with the boundary, but for its parts on sides of the square; list NULL: counted.
static kn_status cross_segment(kn_ctx *ctx, clipping *c, size_t i)
{
    const kn_outline *o = c->region;
    const double *p = c->curve->points + 2 * i, *q = p + 2;
    kn_status status = KN_OK;
    for (int l = 0, first = 0; l < o->nloops; first = o->loop_end[l++])
        for (int k = first; status == KN_OK && k < o->loop_end[l]; k++) {
            const double *a = o->at[k], *b = o->at[k + 1 < o->loop_end[l] ? k + 1 : first];
            if (runs_down(a, b)) { // the other side of the trim has it backwards
                const double *swap = a;
                a = b, b = swap;
            }
            bool side = false;
            for (int v = 0; v < 2; v++) side = side || (a[v] == b[v] && (a[v] == 0.0 || a[v] == 1.0));
            if (side || apart(p, q, a, b)) continue;
            double ap = side_of(a, b, p), aq = side_of(a, b, q), pa = side_of(p, q, a), pb = side_of(p, q, b);
            if ((ap < 0.0) == (aq < 0.0) || (pa < 0.0) == (pb < 0.0)) continue;
            if (c->list) {
                crossing *x = &c->list[c->n];
                x->where = (double)i + fmin(fmax(ap / (ap - aq), 0.0), 1.0);
                point_between(x->at, a, b, fmin(fmax(pa / (pa - pb), 0.0), 1.0));
                status = refine(ctx, x->at, c, a, b, p, q, fmin(fmax(pa / (pa - pb), 0.0), 1.0));
            }
            c->n++;
        }
    return status;
}

static int by_where(const void *a, const void *b)
{
    const crossing *x = a, *y = b;
    return (x->where > y->where) - (x->where < y->where);
}

static kn_status find_crossings(kn_ctx *ctx, clipping *c)
{
    kn_status status = KN_OK;
    for (int pass = 0; status == KN_OK && pass < 2; pass++) {
        if (pass == 1 && c->n == 0) break;
        if (pass == 1) {
            c->list = kn_scratch(ctx, c->n, sizeof *c->list);
            if (!c->list) return KN_ENOMEM;
            c->n = 0;
        }
        for (size_t i = 0; status == KN_OK && i + 1 < c->curve->npoints; i++) status = cross_segment(ctx, c, i);
    }
    if (status == KN_OK && c->n > 1) qsort(c->list, c->n, sizeof *c->list, by_where);
    return status;
}

// ---- parts ----

// The part from crossing `from` to the next one; before the first and after the last of an open curve there are parts
// too, and of a closed one the last goes on to the first.
static size_t take_part(double *out, const clipping *c, size_t part)
{
    size_t n = c->curve->npoints, count = 0, wrap = n - 1;
    bool closed = c->curve->closed;
    const crossing *from = closed ? &c->list[part] : part > 0 ? &c->list[part - 1] : NULL;
    const crossing *to = closed ? &c->list[(part + 1) % c->n] : part < c->n ? &c->list[part] : NULL;
    size_t first = from ? (size_t)floor(from->where) + 1 : 0, end = to ? (size_t)floor(to->where) + 1 : n;
    if (closed && part + 1 == c->n) end += wrap;
    if (from) memcpy(out, from->at, sizeof from->at), count++;
    for (size_t i = first; i < end; i++, count++) {
        size_t at = closed ? i % wrap : i;
        memcpy(out + 2 * count, c->curve->points + 2 * at, 2 * sizeof *out);
    }
    if (to) memcpy(out + 2 * count, to->at, sizeof to->at), count++;
    return count;
}

// Asked in the middle of its longest segment.
static bool is_inside(const kn_outline *region, const double *points, size_t n)
{
    double most = -1.0, middle[2] = {points[0], points[1]};
    for (size_t i = 0; i + 1 < n; i++) {
        const double *p = points + 2 * i;
        double length = hypot(p[2] - p[0], p[3] - p[1]);
        if (!(length > most)) continue;
        most = length;
        middle[0] = 0.5 * (p[0] + p[2]), middle[1] = 0.5 * (p[1] + p[3]);
    }
    return kn_outline_contains(region, middle[0], middle[1]);
}

kn_status kn_slice_clip(kn_ctx *ctx, kn_solve_curve **runs, size_t *n, const kn_outline *region,
                        const kn_solve_curve *curve, const kn_bezier *f, double tol)
{
    clipping c = {.region = region, .curve = curve, .f = f, .tol = tol};
    kn_status status = find_crossings(ctx, &c);
    if (status != KN_OK) return status;
    bool whole = c.n == 0;
    size_t parts = whole ? 1 : curve->closed ? c.n : c.n + 1;
    double *points = kn_scratch(ctx, 2 * (2 * curve->npoints + 2 * c.n + 2), sizeof *points);
    kn_solve_curve *list = kn_scratch(ctx, parts, sizeof *list);
    if (!points || !list) return KN_ENOMEM;
    *n = 0;
    *runs = list;
    if (whole) {
        list[0] = *curve;
        *n = is_inside(region, curve->points, curve->npoints);
        return KN_OK;
    }
    for (size_t k = 0; k < parts; k++) {
        size_t count = take_part(points, &c, k);
        if (count < 2 || !is_inside(region, points, count)) continue;
        list[(*n)++] = (kn_solve_curve){points, count, false};
        points += 2 * count;
    }
    return KN_OK;
}
