// SPDX-License-Identifier: Apache-2.0
// Regions side by side become one: what two of them have in common, in opposite directions, is no boundary.
//
// A cut has the same points on both sides, bit for bit (trim.h). Only where one side was cut further does it have a
// corner more there: segments are divided at such corners first.
#include "job/border.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double near = 1e-11; // of [0,1]: a corner on a segment

// A segment of a boundary, or a whole curve that is not of degree 1.
typedef struct piece {
    double from[2], to[2];
    const kn_spline *curve; // NULL: a segment
    bool gone, used;
} piece;

typedef struct uniting {
    piece *list;
    size_t n, room;
    piece **order;
} uniting;

static kn_status add(kn_ctx *ctx, uniting *u, const double *from, const double *to, const kn_spline *curve)
{
    if (from[0] == to[0] && from[1] == to[1] && !curve) return KN_OK;
    if (u->n == u->room) {
        size_t room = u->room > 0 ? 2 * u->room : 64;
        piece *list = kn_resize(ctx, u->list, room, sizeof *list);
        if (!list) return KN_ENOMEM;
        u->list = list;
        u->room = room;
    }
    u->list[u->n++] = (piece){{from[0], from[1]}, {to[0], to[1]}, curve, false, false};
    return KN_OK;
}

static kn_status take_curves(kn_ctx *ctx, uniting *u, const kn_job_regions *r)
{
    kn_status status = KN_OK;
    for (int i = 0; i < r->n; i++)
        for (int k = 0; k < r->list[i].ncurves && status == KN_OK; k++) {
            const kn_spline *c = &r->list[i].curves[k];
            int n = c->count[0], step = c->degree[0] == 1 ? 1 : n - 1;
            for (int m = 0; m + step < n && status == KN_OK; m += step) {
                const double from[2] = {c->coef[m], c->coef[n + m]};
                const double to[2] = {c->coef[m + step], c->coef[n + m + step]};
                status = add(ctx, u, from, to, c->degree[0] == 1 ? NULL : c);
            }
        }
    return status;
}

static int compare_points(const double *a, const double *b)
{
    return a[0] != b[0] ? (a[0] > b[0]) - (a[0] < b[0]) : (a[1] > b[1]) - (a[1] < b[1]);
}

// By their lower ends and then their upper ones: opposite segments lie side by side.
static int compare_segments(const void *a, const void *b)
{
    const piece *x = *(piece *const *)a, *y = *(piece *const *)b;
    bool bx = compare_points(x->from, x->to) > 0, by = compare_points(y->from, y->to) > 0;
    int c = compare_points(bx ? x->to : x->from, by ? y->to : y->from);
    if (c == 0) c = compare_points(bx ? x->from : x->to, by ? y->from : y->to);
    return c != 0 ? c : (int)bx - (int)by;
}

static int compare_starts(const void *a, const void *b)
{
    const piece *x = *(piece *const *)a, *y = *(piece *const *)b;
    int c = compare_points(x->from, y->from);
    return c != 0 ? c : (x > y) - (x < y);
}

static size_t sort(uniting *u, int (*compare)(const void *, const void *))
{
    size_t n = 0;
    for (size_t i = 0; i < u->n; i++)
        if (!u->list[i].gone) u->order[n++] = &u->list[i];
    qsort(u->order, n, sizeof(piece *), compare);
    return n;
}

static kn_status cancel(kn_ctx *ctx, uniting *u)
{
    kn_free(ctx, u->order);
    u->order = kn_alloc(ctx, u->n, sizeof(piece *));
    if (!u->order) return KN_ENOMEM;
    size_t n = sort(u, compare_segments);
    for (size_t i = 0; i + 1 < n; i++) {
        piece *a = u->order[i], *b = u->order[i + 1];
        if (a->curve || b->curve || compare_points(a->from, b->to) != 0 || compare_points(a->to, b->from) != 0)
            continue;
        a->gone = b->gone = true;
        i++;
    }
    return KN_OK;
}

// Divides segments that are left at corners of others.
static kn_status divide(kn_ctx *ctx, uniting *u, const kn_job_regions *r)
{
    kn_status status = KN_OK;
    for (int i = 0; i < r->n; i++)
        for (int k = 0; k < r->list[i].ncurves; k++) {
            const kn_spline *c = &r->list[i].curves[k];
            const double p[2] = {c->coef[0], c->coef[c->count[0]]};
            for (size_t m = 0, n = u->n; m < n && status == KN_OK; m++) {
                piece *s = &u->list[m];
                if (s->gone || s->curve) continue;
                double a = s->to[0] - s->from[0], b = s->to[1] - s->from[1], length = hypot(a, b);
                double x = p[0] - s->from[0], y = p[1] - s->from[1], along = (a * x + b * y) / length;
                if (!(along > near && along < length - near) || fabs(a * y - b * x) > near * length) continue;
                const double end[2] = {s->to[0], s->to[1]};
                memcpy(s->to, p, sizeof p);
                status = add(ctx, u, p, end, NULL);
                n = u->n;
            }
        }
    return status;
}

// ---- loops ----

static int side_of(const piece *s)
{
    for (int d = 0; d < 2; d++)
        if (s->from[d] == s->to[d] && (s->from[d] == 0.0 || s->from[d] == 1.0)) return 2 * d + (s->from[d] == 1.0);
    return -1;
}

// A piece not yet used that begins where another ends; NULL: there is none.
static piece *find_next(const uniting *u, size_t n, const double at[2])
{
    size_t lo = 0, hi = n;
    while (lo < hi) {
        size_t middle = (lo + hi) / 2;
        if (compare_points(u->order[middle]->from, at) < 0)
            lo = middle + 1;
        else
            hi = middle;
    }
    for (; lo < n && compare_points(u->order[lo]->from, at) == 0; lo++)
        if (!u->order[lo]->used) return u->order[lo];
    return NULL;
}

static kn_status add_curve(kn_ctx *ctx, kn_trim *trim, const kn_spline *curve, const double *points, size_t n)
{
    kn_spline *curves = kn_resize(ctx, trim->curves, (size_t)trim->ncurves + 1, sizeof *curves);
    if (!curves) return KN_ENOMEM;
    trim->curves = curves;
    kn_spline *to = &curves[trim->ncurves++];
    *to = (kn_spline){0};
    if (curve) return kn_spline_copy(ctx, to, curve);
    const int degree = 1, count = (int)n;
    kn_mark mark = kn_scratch_mark(ctx);
    double *knots = kn_scratch(ctx, n + 2, sizeof *knots);
    kn_status status = knots ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < n; i++) knots[i + 1] = (double)i;
    if (status == KN_OK) {
        knots[0] = 0.0, knots[n + 1] = (double)(n - 1);
        status = kn_spline_init(ctx, to, 1, 2, false, &degree, &count, (const double *const[]){knots}, NULL);
    }
    for (size_t i = 0; status == KN_OK && i < n; i++)
        for (size_t d = 0; d < 2; d++) to->coef[d * n + i] = points[2 * i + d];
    kn_scratch_release(ctx, mark);
    return status;
}

// loop[0 .. n - 1] as curves: those that are whole, sides of the square, and polylines between them.
static kn_status add_loop(kn_ctx *ctx, kn_trim *trim, piece *const *loop, size_t n)
{
    size_t start = 0;
    for (size_t i = 0; i < n; i++) // where two curves meet
        if (loop[i]->curve || side_of(loop[i]) != side_of(loop[(i + n - 1) % n])) start = i;
    kn_mark mark = kn_scratch_mark(ctx);
    double *points = kn_scratch(ctx, n + 1, 2 * sizeof *points);
    kn_status status = points ? KN_OK : KN_ENOMEM;
    for (size_t i = 0, count; status == KN_OK && i < n; i += count) {
        const piece *first = loop[(start + i) % n];
        size_t m = 0;
        memcpy(points, first->from, sizeof first->from), m = 1;
        for (count = 0; i + count < n; count++) {
            const piece *next = loop[(start + i + count) % n];
            if (count > 0 && (next->curve || first->curve || side_of(next) != side_of(first))) break;
            memcpy(points + 2 * m++, next->to, sizeof next->to);
        }
        if (side_of(first) >= 0 && !first->curve) { // straight
            memcpy(points + 2, points + 2 * (m - 1), 2 * sizeof *points);
            m = 2;
        }
        status = add_curve(ctx, trim, first->curve, points, m);
    }
    kn_scratch_release(ctx, mark);
    if (status != KN_OK) return status;
    int *ends = kn_resize(ctx, trim->loop_end, (size_t)trim->nloops + 1, sizeof *ends);
    if (!ends) return KN_ENOMEM;
    trim->loop_end = ends;
    ends[trim->nloops++] = trim->ncurves;
    return KN_OK;
}

// *whole: all that is left closes.
static kn_status link(kn_ctx *ctx, kn_trim *out, bool *whole, uniting *u)
{
    size_t n = sort(u, compare_starts);
    kn_mark mark = kn_scratch_mark(ctx);
    piece **loop = kn_scratch(ctx, n + 1, sizeof(piece *));
    kn_status status = loop ? KN_OK : KN_ENOMEM;
    *whole = true;
    for (size_t i = 0; status == KN_OK && *whole && i < n; i++) {
        size_t length = 0;
        if (u->order[i]->used) continue;
        for (piece *at = u->order[i]; at; at = find_next(u, n, at->to)) {
            at->used = true;
            loop[length++] = at;
            if (compare_points(at->to, u->order[i]->from) == 0) break;
        }
        *whole = compare_points(loop[length - 1]->to, loop[0]->from) == 0;
        if (*whole) status = add_loop(ctx, out, loop, length);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_job_unite_regions(kn_ctx *ctx, kn_job_regions *r)
{
    uniting u = {0};
    kn_trim all = {0};
    bool whole = false;
    if (r->n < 2) return KN_OK;
    kn_status status = take_curves(ctx, &u, r);
    if (status == KN_OK) status = cancel(ctx, &u);
    if (status == KN_OK) status = divide(ctx, &u, r);
    if (status == KN_OK) status = cancel(ctx, &u);
    if (status == KN_OK) status = link(ctx, &all, &whole, &u);
    if (status == KN_OK && whole && kn_trim_check(ctx, &all) != KN_OK) {
        status = kn_ctx_error(ctx) == KN_ENOMEM ? KN_ENOMEM : KN_OK;
        if (status == KN_OK) kn_ctx_clear_error(ctx);
        whole = false;
    }
    if (status == KN_OK && whole) {
        for (int i = 0; i < r->n; i++) kn_trim_clear(ctx, &r->list[i]);
        r->list[0] = all;
        r->n = 1;
        all = (kn_trim){0};
    }
    kn_trim_clear(ctx, &all);
    kn_free(ctx, u.order);
    kn_free(ctx, u.list);
    return status;
}
