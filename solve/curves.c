// SPDX-License-Identifier: Apache-2.0
// kn_solve_curves_bezier: the border between f < 0 and f >= 0 in the unit square.
//
// A box is done when one partial derivative, say f_x, keeps its sign in it, rounding included: zeros are then graphs
// x = g(y) over intervals of y that begin and end where f changes its sign on the box's boundary, and in the order of
// y these places say which belong together. |g'| = |f_y / f_x| <= Q by the coefficients, and g'' = -(f_yy + 2 f_xy g'
// + f_xx g'^2) / f_x is bounded by them as well: |g''| <= G, so that a chord of g over a length h deviates by at most
// G h^2 / 8. Each graph gets as many chords as that asks for; where those are too many, or no derivative keeps its
// sign, the box is halved. The places on the new line are found once and handed to both halves, so that what one
// draws the other goes on with.
#include "solve/curves.h"

#include "bezier/norm_bound.h"
#include "kernel/bernstein.h"

#include <float.h>
#include <knurl/solve.h>
#include <math.h>
#include <string.h>

enum { MOST_CHORDS = 16 };                // of a graph in one box: bounds are better in halves, which cost as much
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
    double error, rounding; // of the coefficients: as given, and for each halving
    double shift;           // of points, by rounding
    point *points;
    size_t npoints, room;
    kn_solve_report report;
} tracer;

// What the coefficients over a box are wrong by.
static double margin_of(const tracer *t, const box *b)
{
    return t->error + t->rounding * (b->depth + 1);
}

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

// The places of a box counterclockwise; enters: the curve goes in there (f changes from + to -, run
// counterclockwise).
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

// The root of a monotone function with n + 1 Bernstein coefficients that changes its sign, to some units of rounding:
// secants in which an end that stays counts half (Illinois), and a halving where they do not shrink the interval.
static double monotone_root(const double *c, int n)
{
    double lo = 0.0, hi = 1.0, flo = c[0], fhi = c[n], scaled[KN_MAX_DEGREE + 1], before = 2.0;
    int stays = 0;
    kn_bernstein_scale(scaled, c, n);
    while (hi - lo > 2.0 * DBL_EPSILON) {
        double x = lo + (hi - lo) * (flo / (flo - fhi));
        bool slow = hi - lo > 0.5 * before;
        before = hi - lo;
        if (slow || !(x > lo && x < hi)) x = 0.5 * (lo + hi);
        if (!(x > lo && x < hi)) break;
        double f = kn_bernstein_horner(scaled, n, x);
        if (f == 0.0) return x;
        if ((f < 0.0) == (c[0] < 0.0)) {
            lo = x, flo = f;
            if (stays > 0) fhi *= 0.5;
            stays = 1;
        } else {
            hi = x, fhi = f;
            if (stays < 0) flo *= 0.5;
            stays = -1;
        }
    }
    return c[0] == 0.0 ? 0.0 : c[n] == 0.0 ? 1.0 : 0.5 * (lo + hi);
}

// The point of the graph over variable y at this value of it.
static kn_status graph_point(kn_ctx *ctx, tracer *t, size_t *index, const box *b, int y, double value)
{
    double basis[KN_MAX_DEGREE + 1], line[KN_MAX_DEGREE + 1], at[2];
    int n = t->degree[1 - y], m = t->degree[y];
    size_t row = (size_t)t->degree[1] + 1;
    kn_bernstein_basis(basis, m, (value - b->lo[y]) / (b->hi[y] - b->lo[y]));
    kn_bernstein_contract(line, b->c, y == 0 ? 1 : (size_t)n + 1, m + 1, y == 0 ? row : 1, basis);
    at[y] = value;
    at[1 - y] = b->lo[1 - y] + monotone_root(line, n) * (b->hi[1 - y] - b->lo[1 - y]);
    return add_point(ctx, t, index, at[0], at[1]);
}

// Joins two places of a graph over y by chords; backwards: the curve runs from `to` to `from`.
static kn_status draw_graph(kn_ctx *ctx, tracer *t, const box *b, int y, double longest, size_t from, size_t to,
                            bool backwards)
{
    double a = t->points[from].at[y], z = t->points[to].at[y];
    int n = (int)ceil(fmin(fmax((z - a) / longest, 1.0), MOST_CHORDS));
    kn_status status = KN_OK;
    for (int k = 1; status == KN_OK && k <= n; k++) {
        size_t next = to;
        if (k < n) status = graph_point(ctx, t, &next, b, y, a + (z - a) * k / n);
        if (status == KN_OK) join(t, backwards ? next : from, backwards ? from : next);
        from = next;
    }
    return status;
}

// Zeros as graphs over variable y of a function whose derivative across has one sign: `up` when it is positive.
// Places in the order of y are the beginnings and ends of graphs in turn. *joined is false, and nothing is drawn,
// where they are not (rounding). longest: of a chord, in y.
static kn_status join_graphs(kn_ctx *ctx, tracer *t, bool *joined, const box *b, int y, bool up, double longest)
{
    int low = y == 1 ? BOTTOM : LEFT, high = y == 1 ? TOP : RIGHT, near = y == 1 ? LEFT : BOTTOM;
    const side *a = &b->sides[near], *z = &b->sides[near + 1], *ends[2] = {&b->sides[low], &b->sides[high]};
    size_t n = count_places(b), k = 0, i = 0, j = 0;
    *joined = ends[0]->n <= 1 && ends[1]->n <= 1 && n % 2 == 0;
    if (!*joined) return KN_OK;
    kn_mark mark = kn_scratch_mark(ctx);
    size_t *order = kn_scratch(ctx, n, sizeof *order);
    if (!order) return KN_ENOMEM;
    if (ends[0]->n == 1) order[k++] = ends[0]->list[0].point;
    while (i < a->n || j < z->n) {
        bool first = i < a->n && (j == z->n || by_place(&a->list[i], &z->list[j]) <= 0);
        order[k++] = first ? a->list[i++].point : z->list[j++].point;
    }
    if (ends[1]->n == 1) order[k++] = ends[1]->list[0].point;
    // x to the right, y up, f growing with x: f < 0 to the left of an upward run, so it runs down
    bool backwards = (y == 1) == up;
    kn_status status = KN_OK;
    for (k = 0; status == KN_OK && k < n; k += 2)
        status = draw_graph(ctx, t, b, y, longest, order[k], order[k + 1], backwards);
    kn_scratch_release(ctx, mark);
    return status;
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
    double margin = 2.0 * n * margin_of(t, b);
    range[0] = lo - margin;
    range[1] = hi + margin;
    return range[0] > 0.0 ? 1 : range[1] < 0.0 ? -1 : 0;
}

// The largest |second derivative| over the box, in v and w.
static double second_derivative(const tracer *t, const box *b, int v, int w)
{
    size_t step[2] = {(size_t)t->degree[1] + 1, 1};
    int n[2] = {t->degree[0], t->degree[1]};
    double most = 0.0, factor = v == w ? (double)n[v] * (n[v] - 1) : (double)n[0] * n[1];
    n[v]--, n[w]--;
    for (int i = 0; i <= n[0]; i++)
        for (int j = 0; j <= n[1]; j++) {
            const double *c = b->c + (size_t)i * step[0] + (size_t)j;
            double d = v == w ? c[0] - 2.0 * c[step[v]] + c[2 * step[v]] : c[0] - c[1] - c[step[0]] + c[step[0] + 1];
            most = fmax(most, fabs(d));
        }
    return factor > 0.0 ? factor * (most + 4.0 * margin_of(t, b)) : 0.0;
}

// How long chords of graphs over variable y may be, in y: range of the derivatives, that across of one sign.
static double chord_length(const tracer *t, const box *b, double range[2][2], int y)
{
    int x = 1 - y;
    double least = fmin(fabs(range[x][0]), fabs(range[x][1])), width[2];
    double slope = fmax(fabs(range[y][0]), fabs(range[y][1])) / least;
    double bend = (second_derivative(t, b, y, y) + 2.0 * slope * second_derivative(t, b, x, y) +
                   slope * slope * second_derivative(t, b, x, x)) /
                  least;
    for (int v = 0; v < 2; v++) width[v] = b->hi[v] - b->lo[v];
    double within = bend > 0.0 ? width[y] * sqrt(8.0 * t->tol / (bend * width[x])) : INFINITY;
    return fmin(within, t->longest / hypot(1.0, slope * width[x] / width[y]));
}

static bool keeps_sign(const tracer *t, const box *b)
{
    double margin = margin_of(t, b);
    bool positive = true, negative = true;
    for (size_t i = 0; i < t->count; i++) {
        positive = positive && b->c[i] > margin;
        negative = negative && b->c[i] < -margin;
    }
    return positive || negative;
}

// By how much points of graphs are off: values at them are known to the margin and the rounding of a value, and the
// derivative across is at least `least`; places have some roundings of numbers up to 1 for each halving.
static void note_shift(tracer *t, const box *b, double least, double width)
{
    double value = margin_of(t, b) + 2.0 * t->rounding;
    t->shift = fmax(t->shift, kn_round_up(value / least * width + 4.0 * (b->depth + 1) * DBL_EPSILON));
}

// Whether the box is done. *split: the variable to halve otherwise.
static kn_status finish(kn_ctx *ctx, tracer *t, const box *b, bool *done, int *split)
{
    double range[2][2], width[2] = {b->hi[0] - b->lo[0], b->hi[1] - b->lo[1]}, least = 1.0 / MOST_CHORDS;
    int sign[2];
    size_t n = count_places(b);
    *split = width[0] >= width[1] ? 0 : 1;
    *done = n == 0 && keeps_sign(t, b);
    if (*done) return KN_OK;
    for (int v = 0; v < 2; v++) sign[v] = derivative_sign(range[v], t, b, v);
    *done = n == 0 && (sign[0] != 0 || sign[1] != 0);
    if (*done) return KN_OK;
    int across = sign[0] == 0 ? 1 : 0; // the variable across graphs: of two the one in which f is steeper
    if (sign[0] != 0 && sign[1] != 0 &&
        fmin(fabs(range[1][0]), fabs(range[1][1])) > fmin(fabs(range[0][0]), fabs(range[0][1])))
        across = 1;
    double length = sign[across] != 0 ? chord_length(t, b, range, 1 - across) : 0.0;
    bool longish = width[1 - across] * 32.0 > width[across]; // graphs over a variable get finer with it
    if (sign[across] != 0 && longish) *split = 1 - across;
    if (length >= least * width[1 - across]) {
        kn_status status = join_graphs(ctx, t, done, b, 1 - across, sign[across] > 0, length);
        if (*done) note_shift(t, b, fmin(fabs(range[across][0]), fabs(range[across][1])), width[across]);
        if (status != KN_OK || *done) return status;
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
    double distance;
    return kn_solve_trace(ctx, curves, n, report, &distance, f, &(kn_trace_options){tol, INFINITY, 0.0, NULL});
}

kn_status kn_solve_trace(kn_ctx *ctx, kn_solve_curve **curves, size_t *n, kn_solve_report *report, double *distance,
                         const kn_bezier *f, const kn_trace_options *o)
{
    kn_status status = check(ctx, f, o->tol);
    if (status != KN_OK) return status;
    tracer t = {.degree = {f->degree[0], f->degree[1]}, .count = kn_bezier_count(f)};
    t.tol = o->tol, t.longest = o->longest, t.error = o->error;
    box all = {.hi = {1.0, 1.0}, .c = f->coef};
    double largest = 0.0, line[KN_MAX_DEGREE + 1];
    for (size_t i = 0; i < t.count; i++) largest = fmax(largest, fabs(f->coef[i]));
    t.rounding = 4.0 * (f->degree[0] + f->degree[1] + 1) * DBL_EPSILON * largest;
    kn_mark mark = kn_scratch_mark(ctx);
    for (int k = 0; status == KN_OK && k < SIDES; k++) {
        const double from[2] = {k == RIGHT, k == TOP};
        int degree = gather(line, &t, f->coef, k), along = k == LEFT || k == RIGHT;
        status = o->edges ? take_places(ctx, &t, &all.sides[k], &o->edges[k], from, along, 1.0)
                          : find_places(ctx, &t, &all.sides[k], line, degree, from, along, 1.0);
    }
    if (status == KN_OK) status = trace(ctx, &t, &all);
    if (status == KN_OK) status = collect(ctx, &t, curves, n);
    if (status == KN_OK && report) *report = t.report;
    if (status == KN_OK) *distance = kn_round_up(o->tol + t.shift);
    kn_scratch_release(ctx, mark);
    kn_free(ctx, t.points);
    return status;
}
