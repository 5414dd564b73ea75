// SPDX-License-Identifier: Apache-2.0
// Closest points: branch and bound, the box with the least lower bound first.
#include "solve/cells.h"
#include "solve/distance.h"

#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "kernel/knots.h"

#include <stdlib.h>
#include <string.h>

static const size_t NOT_YET = (size_t)-1; // the Bezier piece of a box of spans that is not made yet

// A box of the parameters of a cell. A whole cell is a box of spans until it is first looked at.
typedef struct box {
    double bound;
    size_t cell;
    int depth, span[KN_CLOSEST_VARS];
    double lo[KN_CLOSEST_VARS], hi[KN_CLOSEST_VARS];
} box;

typedef struct candidate {
    double at[KN_CLOSEST_VARS], from[KN_MAX_VARS], distance; // from: the vector from the point
} candidate;

typedef struct hunt {
    const kn_spline *s; // moved: the point is the origin
    kn_cells cells;
    kn_distance distance;
    kn_solve_options options;
    double *coef, *error, *work, *moved_error, *matrix[KN_CLOSEST_VARS], gap, best, lower;
    size_t rhythm; // boxes between two reports of progress
    box *heap;
    size_t nheap, room;
    candidate *list;
    size_t nlist, list_room;
    kn_solve_report report;
} hunt;

// ---- a heap of boxes ----
static bool before(const box *a, const box *b)
{
    if (a->bound != b->bound) return a->bound < b->bound;
    return a->depth < b->depth;
}

static kn_status push(kn_ctx *ctx, hunt *h, const box *b)
{
    if (h->nheap == h->room) {
        size_t room = 2 * h->room + 64;
        box *more = h->heap ? kn_resize(ctx, h->heap, room, sizeof *more) : kn_alloc(ctx, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        h->heap = more;
        h->room = room;
    }
    size_t i = h->nheap++;
    for (; i > 0 && before(b, &h->heap[(i - 1) / 2]); i = (i - 1) / 2) h->heap[i] = h->heap[(i - 1) / 2];
    h->heap[i] = *b;
    return KN_OK;
}

static box pop(hunt *h)
{
    box top = h->heap[0], last = h->heap[--h->nheap];
    size_t i = 0;
    for (size_t child; (child = 2 * i + 1) < h->nheap; i = child) {
        if (child + 1 < h->nheap && before(&h->heap[child + 1], &h->heap[child])) child++;
        if (!before(&h->heap[child], &last)) break;
        h->heap[i] = h->heap[child];
    }
    h->heap[i] = last;
    return top;
}

// ---- candidates ----
static kn_status add_candidate(kn_ctx *ctx, hunt *h, const candidate *c)
{
    if (c->distance < h->best) h->best = c->distance;
    if (!(c->distance <= h->best + 2.0 * h->gap)) return KN_OK;
    if (h->nlist == h->list_room) {
        size_t room = 2 * h->list_room + 16;
        candidate *more = h->list ? kn_resize(ctx, h->list, room, sizeof *more) : kn_alloc(ctx, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        h->list = more;
        h->list_room = room;
    }
    h->list[h->nlist++] = *c;
    return KN_OK;
}

// The distance at the parameters x of a cell.
static candidate measure(hunt *h, size_t cell, const double *x)
{
    int n = h->s->nvars, dim = h->distance.dim;
    const double *ends = h->cells.box + cell * 2 * (size_t)n;
    double value[KN_MAX_COMPS], error[KN_MAX_COMPS], sum = 0.0;
    candidate c = {.distance = 0.0};
    kn_cell_value(&h->cells, cell, x, value, error, h->work);
    for (int i = 0; i < dim; i++) {
        double v = c.from[i] = value[i] / (h->distance.rational ? value[dim] : 1.0);
        sum += v * v;
    }
    c.distance = sqrt(sum);
    for (int d = 0; d < n; d++) {
        double at = x[d] == 1.0 ? ends[n + d] : ends[d] + x[d] * (ends[n + d] - ends[d]);
        c.at[d] = fmin(fmax(at, ends[d]), ends[n + d]);
    }
    return c;
}

// About the distance at the point x of the box that is loaded.
static double glance(hunt *h, const double *x)
{
    const kn_net *net = &h->cells.net;
    size_t count = (size_t)net->ncomp * net->count;
    double basis[KN_MAX_DEGREE + 1], sum = 0.0;
    const double *from = h->coef;
    for (int d = net->nvars - 1; d >= 0; d--) {
        count /= (size_t)(net->degree[d] + 1);
        kn_bernstein_basis(basis, net->degree[d], x[d]);
        kn_bernstein_contract(h->work, from, count, net->degree[d] + 1, 1, basis);
        from = h->work;
    }
    for (int c = 0; c < h->distance.dim; c++) sum += from[c] * from[c];
    return sqrt(sum) / (h->distance.rational ? from[h->distance.dim] : 1.0);
}

// ---- cells ----
// The distance from the origin to the box around the control points of a box of spans: convex combinations of P / w.
static double hull_distance(const hunt *h, const int *span)
{
    const kn_spline *s = h->s;
    int dim = h->distance.dim;
    size_t n = kn_bernstein_count(s->nvars, s->degree);
    double *x = h->work, *w = h->work + n, sum = 0.0;
    if (s->rational) kn_window(w, s, dim, span);
    for (int c = 0; c < dim; c++) {
        kn_window(x, s, c, span);
        double lo = INFINITY, hi = -INFINITY, least_w = 1.0;
        for (size_t i = 0; i < n; i++) {
            double v = s->rational ? x[i] / w[i] : x[i];
            if (s->rational) least_w = i == 0 || w[i] < least_w ? w[i] : least_w;
            lo = v < lo ? v : lo;
            hi = v > hi ? v : hi;
        }
        double gap = fmax(fmax(lo, -hi), 0.0) * (1.0 - 0x1p-50) - h->moved_error[c] / least_w * 1.001;
        if (gap > 0.0) sum += gap * gap;
    }
    return sqrt(sum) * (1.0 - 0x1p-48);
}

static kn_status extract(kn_ctx *ctx, hunt *h, box *b)
{
    const kn_spline *s = h->s;
    int n = s->nvars;
    double *coef, *error, *ends;
    const double *matrix[KN_CLOSEST_VARS];
    kn_status status = kn_cells_add(ctx, &h->cells, &coef, &error, &ends);
    if (status != KN_OK) return status;
    b->cell = h->cells.count - 1;
    for (int d = 0; d < n; d++) {
        ends[d] = s->knots[d][b->span[d]];
        ends[n + d] = s->knots[d][b->span[d] + 1];
        kn_extraction(h->matrix[d], s->knots[d], s->degree[d], b->span[d], ends[d], ends[n + d]);
        matrix[d] = h->matrix[d];
        b->lo[d] = 0.0, b->hi[d] = 1.0;
    }
    for (int c = 0; c < s->ncomp; c++, coef += h->cells.net.count) {
        kn_window(coef, s, c, b->span);
        error[c] = h->moved_error[c];
        kn_extract(coef, &error[c], s->degree, n, matrix, h->work);
    }
    return KN_OK;
}

// Bounds the box again, better; finds a candidate in it, and divides it unless it cannot hold anything nearer.
static kn_status examine(kn_ctx *ctx, hunt *h, box *b)
{
    int n = h->s->nvars;
    size_t size = (size_t)h->cells.net.ncomp * h->cells.net.count;
    double at[KN_CLOSEST_VARS];
    kn_status status = KN_OK;
    if (b->cell == NOT_YET) status = extract(ctx, h, b);
    if (status != KN_OK) return status;
    for (int c = 0; c < h->cells.net.ncomp; c++)
        h->error[c] = h->cells.error[b->cell * (size_t)h->cells.net.ncomp + (size_t)c];
    kn_net_restrict(h->coef, h->error, &h->cells.net, h->cells.coef + b->cell * size, b->lo, b->hi, h->work);
    double bound = kn_distance_bound(&h->distance, h->coef, h->error, h->best, at);
    if (glance(h, at) <= h->best + 3.0 * h->gap) { // to be measured in earnest
        for (int d = 0; d < n; d++) at[d] = at[d] == 1.0 ? b->hi[d] : b->lo[d] + at[d] * (b->hi[d] - b->lo[d]);
        candidate c = measure(h, b->cell, at);
        status = add_candidate(ctx, h, &c);
    }
    b->bound = fmax(b->bound, bound);
    if (status != KN_OK || b->bound >= h->best - h->gap) {
        h->lower = fmin(h->lower, b->bound);
        return status;
    }
    int var = kn_net_steepest(&h->cells.net, h->coef, h->error);
    double mid = var < 0 ? 0.0 : b->lo[var] + 0.5 * (b->hi[var] - b->lo[var]);
    if (var < 0 || ++b->depth > h->options.max_depth || !(mid > b->lo[var] && mid < b->hi[var])) {
        h->report.limited = true;
        h->lower = fmin(h->lower, b->bound);
        return KN_OK;
    }
    box other = *b;
    b->hi[var] = other.lo[var] = mid;
    status = push(ctx, h, b);
    return status == KN_OK ? push(ctx, h, &other) : status;
}

// ---- the whole ----
static kn_status all_cells(kn_ctx *ctx, hunt *h)
{
    const kn_spline *s = h->s;
    kn_status status = KN_OK;
    box b = {.cell = NOT_YET};
    for (int d = 0; d < s->nvars; d++) b.span[d] = kn_knots_next_span(s->knots[d], s->degree[d], s->count[d], -1);
    while (status == KN_OK) {
        b.bound = hull_distance(h, b.span);
        status = push(ctx, h, &b);
        int d = s->nvars - 1;
        for (; d >= 0; d--) {
            b.span[d] = kn_knots_next_span(s->knots[d], s->degree[d], s->count[d], b.span[d]);
            if (b.span[d] < s->count[d]) break;
            b.span[d] = kn_knots_next_span(s->knots[d], s->degree[d], s->count[d], -1);
        }
        if (d < 0) break;
    }
    return status;
}

static kn_status search(kn_ctx *ctx, hunt *h)
{
    kn_status status = all_cells(ctx, h);
    while (h->nheap > 0 && status == KN_OK) {
        box b = pop(h);
        if (b.bound >= h->best - h->gap || h->report.boxes >= h->options.max_boxes) {
            h->report.limited = h->report.limited || b.bound < h->best - h->gap;
            h->lower = fmin(h->lower, b.bound); // the least of all that are left
            if (!(b.bound <= h->best + h->gap)) break;
            if (h->report.boxes >= h->options.max_boxes) break;
        }
        if (++h->report.boxes % h->rhythm == 0) status = kn_progress(ctx, "closest point", 0.0);
        if (status == KN_OK) status = examine(ctx, h, &b);
    }
    h->lower = fmin(h->lower, h->best);
    return status;
}

static int by_distance(const void *a, const void *b)
{
    const candidate *x = a, *y = b;
    if (x->distance != y->distance) return x->distance < y->distance ? -1 : 1;
    for (int d = 0; d < KN_CLOSEST_VARS; d++)
        if (x->at[d] != y->at[d]) return x->at[d] < y->at[d] ? -1 : 1;
    return 0;
}

// Candidates that are near the best and apart from one another: parameters that differ by 1e-6 of the domain, where
// the square of the distance changes by about 1e-12.
static kn_status answer(kn_ctx *ctx, hunt *h, const kn_spline *s, const double *point, kn_closest **closest,
                        size_t *count)
{
    size_t n = 0;
    if (h->nlist == 0) return kn_fail(ctx, KN_EUNDECIDED, "closest: weights underflow");
    qsort(h->list, h->nlist, sizeof *h->list, by_distance);
    for (size_t i = 0; i < h->nlist && h->list[i].distance <= h->best + 2.0 * h->gap; i++) {
        bool known = false;
        for (size_t j = 0; j < n && !known; j++) {
            known = true;
            for (int d = 0; d < s->nvars; d++) {
                double lo, hi;
                kn_spline_domain(s, d, &lo, &hi);
                known = known && fabs(h->list[i].at[d] - h->list[j].at[d]) <= 1e-6 * (hi - lo);
            }
        }
        if (!known) h->list[n++] = h->list[i];
    }
    kn_closest *out = kn_alloc_zero(ctx, n, sizeof *out);
    kn_status status = out ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; i < n && status == KN_OK; i++) {
        for (int d = 0; d < s->nvars; d++) out[i].at[d] = h->list[i].at[d];
        out[i].distance = h->list[i].distance;
        status = kn_spline_eval(ctx, out[i].point, s, out[i].at);
        double sum = 0.0;
        for (int c = 0; c < h->distance.dim; c++) sum += (out[i].point[c] - point[c]) * (out[i].point[c] - point[c]);
        for (int c = 0; c < h->distance.dim && !(fabs(sqrt(sum) - out[i].distance) <= h->gap); c++)
            out[i].point[c] = point[c] + h->list[i].from[c]; // at a jump, the other side
    }
    if (status == KN_OK) {
        *closest = out;
        *count = n;
    } else {
        kn_free(ctx, out);
    }
    return status;
}

// N = P - q w: one rounding, and one of q w where w is not 1. The scale: the largest |N / w|.
static kn_status move(kn_ctx *ctx, hunt *h, kn_spline *moved, const kn_spline *s, const double *q)
{
    size_t n = kn_spline_count(s);
    int dim = kn_spline_dim(s);
    const double *w = s->rational ? s->coef + (size_t)dim * n : NULL;
    double scale = 0.0, largest = 0.0;
    *moved = *s;
    moved->coef = kn_scratch(ctx, (size_t)s->ncomp * n, sizeof *moved->coef);
    h->moved_error = kn_scratch(ctx, (size_t)s->ncomp, sizeof *h->moved_error);
    if (!moved->coef || !h->moved_error) return KN_ENOMEM;
    for (int c = 0; c < s->ncomp; c++) {
        h->moved_error[c] = 0.0;
        for (size_t i = 0; i < n; i++) {
            double p = s->coef[(size_t)c * n + i], wi = w ? w[i] : 1.0, shift = c < dim ? q[c] * wi : 0.0;
            moved->coef[(size_t)c * n + i] = p - shift;
            double error = c < dim ? kn_rounding(1.0) * (fabs(p - shift) + (w ? fabs(shift) : 0.0)) : 0.0;
            h->moved_error[c] = fmax(h->moved_error[c], error);
            if (c < dim) scale = fmax(scale, fabs(p - shift) / wi);
            largest = fmax(largest, fmax(fabs(p - shift), w ? wi : 0.0));
        }
    }
    largest = fmax(largest, scale);
    if (!isfinite(8.0 * dim * largest * largest)) return kn_fail(ctx, KN_EUNDECIDED, "closest: squares overflow");
    h->gap = h->options.residual * scale;
    h->s = moved;
    return KN_OK;
}

static kn_status prepare(kn_ctx *ctx, hunt *h)
{
    kn_net net = kn_net_make(h->s->nvars, h->s->ncomp, h->s->degree);
    size_t size = (size_t)net.ncomp * net.count, room = 4 * net.count > size ? 4 * net.count : size;
    h->cells.net = net;
    h->best = INFINITY;
    h->lower = INFINITY;
    h->coef = kn_scratch(ctx, size, sizeof *h->coef);
    h->work = kn_scratch(ctx, room, sizeof *h->work);
    h->error = kn_scratch(ctx, (size_t)net.ncomp, sizeof *h->error);
    h->rhythm = kn_net_rhythm((size_t)net.ncomp * net.count << net.nvars); // squares have twice the degrees
    for (int d = 0; d < net.nvars; d++) {
        size_t m = (size_t)net.degree[d] + 1;
        h->matrix[d] = kn_scratch(ctx, m * m, sizeof *h->matrix[d]);
        if (!h->matrix[d]) return KN_ENOMEM;
    }
    if (!h->coef || !h->work || !h->error) return KN_ENOMEM;
    return kn_distance_init(ctx, &h->distance, &net, h->s->rational);
}

static kn_status check(kn_ctx *ctx, const kn_spline *s, const double *point)
{
    kn_status status = kn_spline_check(ctx, s);
    if (status != KN_OK) return status;
    int dim = kn_spline_dim(s);
    if (s->nvars < 1 || s->nvars > KN_CLOSEST_VARS || dim > KN_MAX_VARS)
        return kn_fail(ctx, KN_EDOMAIN, "closest: %d variables, dimension %d", s->nvars, dim);
    for (int d = 0; d < s->nvars; d++)
        if (2 * s->degree[d] > KN_MAX_DEGREE) return kn_fail(ctx, KN_ELIMIT, "closest: degree %d", s->degree[d]);
    for (int c = 0; c < dim; c++)
        if (!isfinite(point[c])) return kn_fail(ctx, KN_EDOMAIN, "closest: coordinate %d is %g", c, point[c]);
    return KN_OK;
}

kn_status kn_solve_closest(kn_ctx *ctx, kn_closest **closest, size_t *n, double *lower, kn_solve_report *report,
                           const kn_spline *s, const double *point, const kn_solve_options *options)
{
    hunt h = {0};
    kn_spline moved;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = check(ctx, s, point);
    if (status == KN_OK) status = kn_solve_settle(ctx, &h.options, options);
    if (status == KN_OK) status = move(ctx, &h, &moved, s, point);
    if (status == KN_OK) status = prepare(ctx, &h);
    if (status == KN_OK) status = search(ctx, &h);
    if (status == KN_OK) status = answer(ctx, &h, s, point, closest, n);
    if (status == KN_OK && lower) *lower = h.lower;
    if (status == KN_OK && report) *report = h.report;
    kn_cells_clear(ctx, &h.cells);
    kn_free(ctx, h.heap);
    kn_free(ctx, h.list);
    kn_scratch_release(ctx, mark);
    return status;
}
