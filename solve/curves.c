// SPDX-License-Identifier: Apache-2.0
// kn_solve_curves_bezier: the border between f < 0 and f >= 0 in the unit square.
//
// A box is done when one partial derivative, say f_x, keeps its sign in it, rounding included: zeros are then graphs
// x = g(y) over intervals of y that begin and end where f changes its sign on the box's boundary, and in the order of
// y these places say which belong together. g' = -f_y / f_x lies in an interval [m, M] that the coefficients give, so
// that a chord of g over a length h deviates by at most (M - m) h / 4. Where that is too much, or no derivative keeps
// its sign, the box is halved. The places on the new line are found once and handed to both halves, so that what one
// draws the other goes on with.
#include "solve/curves.h"

#include "kernel/bernstein.h"

#include <float.h>
#include <knurl/solve.h>
#include <math.h>
#include <string.h>

enum { LEFT, RIGHT, BOTTOM, TOP, SIDES }; // x = lo, x = hi, y = lo, y = hi
static const size_t max_boxes = 1000000, none = SIZE_MAX;

typedef struct point {
    double at[2];
    size_t next;  // none: not yet, or the end
    bool follows; // another one leads to it
} point;

// A place on a side of a box: a point, and whether f rises there along increasing x or y.
typedef struct place {
    size_t point;
    double at;
    bool rise;
} place;

typedef struct side {
    place *list;
    size_t n;
} side;

typedef struct box {
    double lo[2], hi[2];
    double *c; // of f over it
    side sides[SIDES];
    int depth;
} box;

typedef struct tracer {
    int degree[2];
    size_t count;
    double tol, longest;
    double rounding; // of the coefficients, for each halving
    point *points;
    size_t npoints, room;
    kn_solve_report report;
} tracer;

static kn_status add_point(kn_ctx *ctx, tracer *t, size_t *index, double x, double y)
{
    if (t->npoints == t->room) {
        size_t room = t->room > 0 ? 2 * t->room : 64;
        point *points = kn_resize(ctx, t->points, room, sizeof *points);
        if (!points) return KN_ENOMEM;
        t->points = points;
        t->room = room;
    }
    *index = t->npoints;
    t->points[t->npoints++] = (point){{x, y}, none, false};
    return KN_OK;
}

// The curve enters a box at `from` and leaves it at `to`.
static void join(tracer *t, size_t from, size_t to)
{
    t->points[from].next = to;
    t->points[to].follows = true;
}

// ---- places on a line ----

// Changes of sign along a line on which x[var] runs from from[var] to hi, as places.
static kn_status take_places(kn_ctx *ctx, tracer *t, side *out, const kn_sign_changes *found, const double from[2],
                             int var, double hi)
{
    kn_status status = KN_OK;
    if (found->count > 0) {
        out->list = kn_scratch(ctx, found->count, sizeof *out->list);
        if (!out->list) status = KN_ENOMEM;
    }
    for (size_t i = 0; status == KN_OK && i < found->count; i++) {
        double x[2] = {from[0], from[1]}, s = found->list[i].at;
        x[var] = s <= 0.5 ? from[var] + s * (hi - from[var]) : hi - (1.0 - s) * (hi - from[var]);
        place *p = &out->list[out->n++];
        *p = (place){0, x[var], found->list[i].rise};
        status = add_point(ctx, t, &p->point, x[0], x[1]);
    }
    return status;
}

// The same, of f's coefficients along it.
static kn_status find_places(kn_ctx *ctx, tracer *t, side *out, const double *c, int degree, const double from[2],
                             int var, double hi)
{
    kn_sign_changes found = {0};
    kn_status status = kn_solve_sign_changes(ctx, &found, &t->report.possible, c, degree);
    if (status == KN_OK) status = take_places(ctx, t, out, &found, from, var, hi);
    kn_free(ctx, found.list);
    return status;
}

// Coefficients along a side, gathered.
static int gather(double *to, const tracer *t, const double *c, int which)
{
    size_t row = (size_t)t->degree[1] + 1;
    bool along_y = which == LEFT || which == RIGHT;
    int degree = t->degree[along_y ? 1 : 0];
    size_t start = which == RIGHT ? (size_t)t->degree[0] * row : which == TOP ? row - 1 : 0;
    for (int i = 0; i <= degree; i++) to[i] = c[start + (size_t)i * (along_y ? 1 : row)];
    return degree;
}

// ---- one box ----

// The places of a box counterclockwise; enters: the curve goes in there (f changes from + to -, run counterclockwise).
typedef struct around {
    size_t point;
    bool enters;
} around;

static size_t walk(around *ring, const box *b)
{
    static const int order[SIDES] = {BOTTOM, RIGHT, TOP, LEFT};
    size_t n = 0;
    for (int k = 0; k < SIDES; k++) {
        const side *s = &b->sides[order[k]];
        bool backwards = order[k] == TOP || order[k] == LEFT;
        for (size_t i = 0; i < s->n; i++) {
            const place *p = &s->list[backwards ? s->n - 1 - i : i];
            ring[n++] = (around){p->point, p->rise == backwards};
        }
    }
    return n;
}

static size_t count_places(const box *b)
{
    size_t n = 0;
    for (int k = 0; k < SIDES; k++) n += b->sides[k].n;
    return n;
}

// Joins each way in with the place before it, counterclockwise: f >= 0 on the boundary between them.
static kn_status join_neighbours(kn_ctx *ctx, tracer *t, const box *b, size_t n)
{
    kn_mark mark = kn_scratch_mark(ctx);
    around *ring = kn_scratch(ctx, n, sizeof *ring);
    if (!ring) return KN_ENOMEM;
    (void)walk(ring, b);
    for (size_t i = 0; i < n; i++) {
        const around *before = &ring[(i + n - 1) % n];
        if (ring[i].enters && !before->enters) join(t, ring[i].point, before->point);
    }
    kn_scratch_release(ctx, mark);
    return KN_OK;
}

static int by_place(const place *a, const place *b)
{
    return (a->at > b->at) - (a->at < b->at);
}

// Zeros as graphs over variable y (var 1; or 0) of a function whose derivative across has one sign: `up` when it is
// positive. Places in the order of y are the beginnings and ends of graphs in turn. False: they are not (rounding).
static bool join_graphs(tracer *t, const box *b, int y, bool up)
{
    int low = y == 1 ? BOTTOM : LEFT, high = y == 1 ? TOP : RIGHT, near = y == 1 ? LEFT : BOTTOM;
    const side *a = &b->sides[near], *z = &b->sides[near + 1];
    if (b->sides[low].n > 1 || b->sides[high].n > 1 || count_places(b) % 2 != 0) return false;
    size_t open = b->sides[low].n == 1 ? b->sides[low].list[0].point : none, i = 0, j = 0;
    while (i < a->n || j < z->n || b->sides[high].n == 1) {
        const place *p = NULL;
        if (i < a->n && (j == z->n || by_place(&a->list[i], &z->list[j]) <= 0))
            p = &a->list[i++];
        else if (j < z->n)
            p = &z->list[j++];
        size_t here = p ? p->point : b->sides[high].list[0].point;
        if (open == none) {
            if (!p) return false;
            open = here;
        } else {
            // x to the right, y up, f growing with x: f < 0 to the left of an upward run, so it runs down
            bool downwards = (y == 1) == up;
            join(t, downwards ? here : open, downwards ? open : here);
            open = none;
        }
        if (!p) break;
    }
    return open == none;
}

// The least and largest coefficient of the derivative in variable v, and the margin taken off: 1 positive, -1
// negative, 0 neither.
static int derivative_sign(double range[2], const tracer *t, const box *b, int v)
{
    size_t row = (size_t)t->degree[1] + 1, step = v == 0 ? row : 1;
    int n = t->degree[v], m = t->degree[1 - v];
    double lo = INFINITY, hi = -INFINITY;
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= m; j++) {
            size_t at = v == 0 ? (size_t)i * row + (size_t)j : (size_t)j * row + (size_t)i;
            double d = n * (b->c[at + step] - b->c[at]);
            lo = fmin(lo, d);
            hi = fmax(hi, d);
        }
    if (n == 0) lo = hi = 0.0;
    double margin = 2.0 * n * t->rounding * (b->depth + 1);
    range[0] = lo - margin;
    range[1] = hi + margin;
    return range[0] > 0.0 ? 1 : range[1] < 0.0 ? -1 : 0;
}

// (M - m) / 4 of the slope -a / d over the box, d of one sign.
static double deviation(const double a[2], const double d[2])
{
    double q[4] = {a[0] / d[0], a[0] / d[1], a[1] / d[0], a[1] / d[1]}, lo = q[0], hi = q[0];
    for (int i = 1; i < 4; i++) {
        lo = fmin(lo, q[i]);
        hi = fmax(hi, q[i]);
    }
    return (hi - lo) / 4.0;
}

static bool keeps_sign(const tracer *t, const box *b)
{
    double margin = t->rounding * (b->depth + 1);
    bool positive = true, negative = true;
    for (size_t i = 0; i < t->count; i++) {
        positive = positive && b->c[i] > margin;
        negative = negative && b->c[i] < -margin;
    }
    return positive || negative;
}

// Whether the box is done. *split: the variable to halve otherwise.
static kn_status finish(kn_ctx *ctx, tracer *t, const box *b, bool *done, int *split)
{
    double range[2][2], width[2] = {b->hi[0] - b->lo[0], b->hi[1] - b->lo[1]};
    int sign[2];
    size_t n = count_places(b);
    *split = width[0] >= width[1] ? 0 : 1;
    *done = n == 0 && keeps_sign(t, b);
    if (*done) return KN_OK;
    bool short_enough = fmax(width[0], width[1]) <= t->longest;
    for (int v = 0; v < 2; v++) sign[v] = derivative_sign(range[v], t, b, v);
    double best = INFINITY;
    for (int v = 0; v < 2; v++) {
        if (sign[v] == 0) continue;
        double off = deviation(range[1 - v], range[v]) * width[v];
        bool longish = width[1 - v] * 32.0 > width[v]; // graphs over a variable get finer with it
        if (off < best && longish && off > t->tol) *split = 1 - v;
        best = fmin(best, off);
        *done = n == 0 || (off <= t->tol && short_enough && join_graphs(t, b, 1 - v, sign[v] > 0));
        if (*done) return KN_OK;
    }
    bool small = fmax(width[0], width[1]) <= t->tol / 2.0 || t->report.boxes > max_boxes;
    if (!small) return KN_OK;
    *done = true;
    if (n == 0) return KN_OK;
    t->report.possible++;
    return join_neighbours(ctx, t, b, n);
}

// ---- halving ----

// The places of a side below and above `at`; it keeps their order.
static void share(side *below, side *above, const side *s, double at)
{
    *below = (side){s->list, 0};
    while (below->n < s->n && s->list[below->n].at < at) below->n++;
    *above = (side){s->list ? s->list + below->n : NULL, s->n - below->n};
}

// A number inside that is no place of either side.
static double choose_cut(const box *b, int v)
{
    static const double tries[] = {0.5, 0.46875, 0.53125, 0.4375, 0.5625};
    const side *across[2] = {&b->sides[v == 0 ? BOTTOM : LEFT], &b->sides[v == 0 ? TOP : RIGHT]};
    double width = b->hi[v] - b->lo[v], at = 0.5;
    for (size_t k = 0; k < sizeof tries / sizeof *tries; k++) {
        bool free = true;
        at = tries[k];
        for (int s = 0; s < 2; s++)
            for (size_t i = 0; i < across[s]->n; i++)
                free = free && fabs(across[s]->list[i].at - (b->lo[v] + at * width)) > 1e-6 * width;
        if (free) break;
    }
    return at;
}

static kn_status trace(kn_ctx *ctx, tracer *t, const box *b);

static kn_status halve(kn_ctx *ctx, tracer *t, const box *b, int v)
{
    double s = choose_cut(b, v), at = b->lo[v] + s * (b->hi[v] - b->lo[v]), line[KN_MAX_DEGREE + 1];
    box half[2] = {*b, *b};
    int across[2] = {v == 0 ? BOTTOM : LEFT, v == 0 ? TOP : RIGHT}, cut = v == 0 ? RIGHT : TOP;
    size_t row = (size_t)t->degree[1] + 1;
    kn_mark mark = kn_scratch_mark(ctx);
    for (int k = 0; k < 2; k++) {
        half[k].depth = b->depth + 1;
        half[k].c = kn_scratch(ctx, t->count, sizeof *half[k].c);
        if (!half[k].c) return KN_ENOMEM;
    }
    kn_bernstein_split(half[0].c, half[1].c, b->c, v == 0 ? 1 : (size_t)t->degree[0] + 1, t->degree[v],
                       v == 0 ? row : 1, s);
    half[0].hi[v] = half[1].lo[v] = at;
    for (int k = 0; k < 2; k++) share(&half[0].sides[across[k]], &half[1].sides[across[k]], &b->sides[across[k]], at);
    side places = {0};
    double from[2] = {b->lo[0], b->lo[1]};
    from[v] = at;
    int degree = gather(line, t, half[0].c, cut);
    kn_status status = find_places(ctx, t, &places, line, degree, from, 1 - v, b->hi[1 - v]);
    half[0].sides[cut] = half[1].sides[cut - 1] = places;
    for (int k = 0; status == KN_OK && k < 2; k++) status = trace(ctx, t, &half[k]);
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status trace(kn_ctx *ctx, tracer *t, const box *b)
{
    bool done;
    int split;
    t->report.boxes++;
    if (t->report.boxes > max_boxes) t->report.limited = true;
    kn_status status = finish(ctx, t, b, &done, &split);
    if (status == KN_OK && t->report.boxes % 1024 == 0) status = kn_progress(ctx, "curves", 0.0);
    return status != KN_OK || done ? status : halve(ctx, t, b, split);
}

// ---- curves from points ----

// The points from `start` on; out NULL: only counted.
static size_t run(double *out, tracer *t, size_t start, bool closed)
{
    size_t n = 0, at = start;
    do {
        if (out) memcpy(out + 2 * n, t->points[at].at, 2 * sizeof *out);
        n++;
        at = t->points[at].next;
    } while (at != none && at != start);
    if (closed && out) memcpy(out + 2 * n, t->points[start].at, 2 * sizeof *out);
    return n + closed;
}

typedef struct start {
    size_t point, npoints;
    bool closed;
} start;

// Open curves first, then closed ones, each in the order of their first points. list NULL: counted.
static size_t find_starts(start *list, tracer *t, bool *taken)
{
    size_t n = 0;
    memset(taken, 0, t->npoints * sizeof *taken);
    for (int closed = 0; closed < 2; closed++)
        for (size_t i = 0; i < t->npoints; i++) {
            if (taken[i] || t->points[i].next == none || (!closed && t->points[i].follows)) continue;
            if (list) list[n] = (start){i, run(NULL, t, i, closed), closed};
            n++;
            for (size_t at = i; at != none && !taken[at]; at = t->points[at].next) taken[at] = true;
        }
    return n;
}

static kn_status collect(kn_ctx *ctx, tracer *t, kn_solve_curve **curves, size_t *n)
{
    kn_mark mark = kn_scratch_mark(ctx);
    bool *taken = kn_scratch(ctx, t->npoints, sizeof *taken);
    size_t count = taken ? find_starts(NULL, t, taken) : 0, points = 0;
    start *starts = kn_scratch(ctx, count, sizeof *starts);
    if (!taken || !starts) return KN_ENOMEM;
    (void)find_starts(starts, t, taken);
    for (size_t i = 0; i < count; i++) points += starts[i].npoints;
    size_t head = count * sizeof(kn_solve_curve);
    kn_solve_curve *list = kn_alloc(ctx, head + points * 2 * sizeof(double), 1);
    if (list) {
        double *to = (double *)(void *)((char *)list + head);
        for (size_t i = 0; i < count; i++) {
            list[i] = (kn_solve_curve){to, starts[i].npoints, starts[i].closed};
            to += 2 * run(to, t, starts[i].point, starts[i].closed);
        }
        *curves = list;
        *n = count;
    }
    kn_scratch_release(ctx, mark);
    return list ? KN_OK : KN_ENOMEM;
}

static kn_status check(kn_ctx *ctx, const kn_bezier *f, double tol)
{
    if (f->nvars != 2 || f->ncomp != 1 || f->rational)
        return kn_fail(ctx, KN_EDOMAIN, "curves: the function has %d variables and %d components%s", f->nvars,
                       f->ncomp, f->rational ? ", rational" : "");
    if (!(tol > 0.0 && tol <= 0.5)) return kn_fail(ctx, KN_EDOMAIN, "curves: tolerance %g", tol);
    size_t n = kn_bezier_count(f);
    for (size_t i = 0; i < n; i++)
        if (!isfinite(f->coef[i])) return kn_fail(ctx, KN_EDOMAIN, "curves: coefficient %zu is not finite", i);
    return KN_OK;
}

kn_status kn_solve_curves_bezier(kn_ctx *ctx, kn_solve_curve **curves, size_t *n, kn_solve_report *report,
                                 const kn_bezier *f, double tol)
{
    return kn_solve_trace(ctx, curves, n, report, f, tol, INFINITY, NULL);
}

kn_status kn_solve_trace(kn_ctx *ctx, kn_solve_curve **curves, size_t *n, kn_solve_report *report, const kn_bezier *f,
                         double tol, double longest, const kn_sign_changes *edges)
{
    kn_status status = check(ctx, f, tol);
    if (status != KN_OK) return status;
    tracer t = {.degree = {f->degree[0], f->degree[1]}, .count = kn_bezier_count(f), .tol = tol, .longest = longest};
    box all = {.hi = {1.0, 1.0}, .c = f->coef};
    double largest = 0.0, line[KN_MAX_DEGREE + 1];
    for (size_t i = 0; i < t.count; i++) largest = fmax(largest, fabs(f->coef[i]));
    t.rounding = 4.0 * (f->degree[0] + f->degree[1] + 1) * DBL_EPSILON * largest;
    kn_mark mark = kn_scratch_mark(ctx);
    for (int k = 0; status == KN_OK && k < SIDES; k++) {
        const double from[2] = {k == RIGHT, k == TOP};
        int degree = gather(line, &t, f->coef, k), along = k == LEFT || k == RIGHT;
        status = edges ? take_places(ctx, &t, &all.sides[k], &edges[k], from, along, 1.0)
                       : find_places(ctx, &t, &all.sides[k], line, degree, from, along, 1.0);
    }
    if (status == KN_OK) status = trace(ctx, &t, &all);
    if (status == KN_OK) status = collect(ctx, &t, curves, n);
    if (status == KN_OK && report) *report = t.report;
    kn_scratch_release(ctx, mark);
    kn_free(ctx, t.points);
    return status;
}
