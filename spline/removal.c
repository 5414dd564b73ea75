// SPDX-License-Identifier: Apache-2.0
// Knot removal: exactly where that is possible, then within a tolerance.
//
// Let knot s be the last of m equal ones x inside. Inserting x into the knots t' without it,
//     c_i = a_i d_i + (1 - a_i) d_i-1,  a_i = (x - t'_i) / (t'_i+p - t'_i),  s-p <= i <= s-m,
// and c_i = d_i before, c_i = d_i-1 after. These p - m + 1 equations have p - m unknowns; with d_s-p-1 and d_s-m
// known from their neighbours they are solved from both ends, each side as long as it divides by the larger factor
// (Tiller, Knot-removal algorithms for NURBS curves and surfaces, CAD 24, 1992). They have a solution where sum mu_i
// c_i = 0, mu the numbers, alternating in sign, that are orthogonal to the equations. Otherwise the smallest change
// of c_s-p .. c_s-m that gives them one moves each by the same length |sum mu_i c_i| / sum |mu_i|.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "spline/removal.h"
#include "kernel/context.h"
#include "kernel/exact.h"

// A removal: the last of m equal knots x, the ends of the equations' intervals, and room for what comes out.
typedef struct removal {
    int s, m, degree;
    size_t width;
    double x;
    double lo[KN_MAX_DEGREE + 1], hi[KN_MAX_DEGREE + 1]; // t'_i and t'_i+p of equation i - (s - degree)
    double mu[KN_MAX_DEGREE + 3];                        // from i = s - p - 1 to s - m + 1
    double *sum;                                         // width numbers: sum mu_i c_i / sum |mu_i|
    double *d;                                           // degree + 1 rows: d_s-p-1 .. d_s-m
} removal;

static kn_status make_room(kn_ctx *ctx, removal *r, const kn_rows *g)
{
    r->degree = g->degree;
    r->width = g->lines * (size_t)g->ncomp;
    r->sum = kn_scratch(ctx, r->width, sizeof *r->sum);
    r->d = kn_scratch(ctx, (size_t)(g->degree + 2) * r->width, sizeof *r->d);
    return r->sum && r->d ? KN_OK : KN_ENOMEM;
}

static double *row_of(const kn_rows *g, int i)
{
    return g->row + (size_t)i * g->lines * (size_t)g->ncomp;
}

static void aim(removal *r, const kn_rows *g, int s, int m)
{
    r->s = s, r->m = m, r->x = g->knots[s];
    for (int k = 0; k <= r->degree - m; k++) {
        int i = s - r->degree + k;
        r->lo[k] = g->knots[i], r->hi[k] = g->knots[i + r->degree + 1];
    }
}

// mu, with sum over the equations |mu_i| = 1, and sum mu_i c_i. With m = p + 1 there are two copies of one point, and
// half their difference is what each has to move.
static void weigh(removal *r, const kn_rows *g)
{
    int n = r->degree - r->m + 1, first = r->s - r->degree - 1; // equations
    double total = 0.0;
    r->mu[0] = 1.0;
    for (int k = 0; k < n; k++) {
        double length = r->hi[k] - r->lo[k],
               below = k == 0 ? 1.0 : (r->x - r->lo[k - 1]) / (r->hi[k - 1] - r->lo[k - 1]);
        r->mu[k + 1] = -r->mu[k] * below / ((r->hi[k] - r->x) / length);
        total += fabs(r->mu[k + 1]);
    }
    r->mu[n + 1] = n == 0 ? -1.0 : -r->mu[n] * ((r->x - r->lo[n - 1]) / (r->hi[n - 1] - r->lo[n - 1]));
    if (n == 0) total = 2.0;
    for (size_t q = 0; q < r->width; q++) r->sum[q] = 0.0;
    for (int k = 0; k < n + 2; k++) {
        const double *c = row_of(g, first + k);
        r->mu[k] /= total;
        for (size_t q = 0; q < r->width; q++) r->sum[q] += r->mu[k] * c[q];
    }
}

// d = the coefficients without the knot; share 1 takes c_i as moved by sum, share 0 as they are.
static void solve(removal *r, const kn_rows *g, double share)
{
    int n = r->degree - r->m + 1, first = r->s - r->degree - 1, forward = 0;
    size_t width = r->width;
    const double *before = row_of(g, first), *after = row_of(g, first + n + 1);
    for (size_t q = 0; q < width; q++) r->d[q] = before[q];
    if (n == 0) {
        for (size_t q = 0; q < width; q++) r->d[q] -= share * r->sum[q];
        return;
    }
    for (size_t q = 0; q < width; q++) r->d[(size_t)n * width + q] = after[q];
    while (forward < n - 1 && r->x - r->lo[forward] >= r->hi[forward] - r->x) forward++;
    for (int k = 0; k < forward; k++) { // equation k gives d_k+1
        const double *c = row_of(g, first + 1 + k), *known = r->d + (size_t)k * width;
        double *to = r->d + (size_t)(k + 1) * width, move = r->mu[k + 1] > 0.0 ? share : -share;
        double length = r->hi[k] - r->lo[k], up = r->x - r->lo[k], down = r->hi[k] - r->x;
        for (size_t q = 0; q < width; q++) to[q] = (length * (c[q] - move * r->sum[q]) - down * known[q]) / up;
    }
    for (int k = n - 1; k > forward; k--) { // and d_k
        const double *c = row_of(g, first + 1 + k), *known = r->d + (size_t)(k + 1) * width;
        double *to = r->d + (size_t)k * width, move = r->mu[k + 1] > 0.0 ? share : -share;
        double length = r->hi[k] - r->lo[k], up = r->x - r->lo[k], down = r->hi[k] - r->x;
        for (size_t q = 0; q < width; q++) to[q] = (length * (c[q] - move * r->sum[q]) - up * known[q]) / down;
    }
}

// Whether d solves all equations in exact arithmetic.
static bool is_exact(const removal *r, const kn_rows *g)
{
    int n = r->degree - r->m + 1, first = r->s - r->degree - 1;
    const double *before = row_of(g, first), *after = row_of(g, first + n + 1);
    if (n == 0) return memcmp(before, after, r->width * sizeof *before) == 0;
    for (int k = 0; k < n; k++) {
        const double *c = row_of(g, first + 1 + k), *d = r->d + (size_t)k * r->width, *e = d + r->width;
        for (size_t q = 0; q < r->width; q++) {
            const double a[] = {r->hi[k], r->x, r->lo[k]}, b[] = {r->lo[k], r->hi[k], r->x}, v[] = {c[q], d[q], e[q]};
            if (!kn_exact_zero(a, b, v, 3)) return false;
        }
    }
    return true;
}

// ---- many removals in one sweep ----
// From the last knot to the first; what the sweep is done with waits behind a gap, so that a removal moves what lies
// between itself and the gap, and not all that follows.
typedef struct gap {
    double *array;
    size_t width, begin, end, total; // elements of `width` numbers: [begin, end) is free
} gap;

typedef struct sweep {
    kn_rows *g;
    gap knots, rows;
} sweep;

static sweep start_sweep(kn_rows *g)
{
    size_t rows = (size_t)g->count, knots = rows + (size_t)g->degree + 1;
    gap k = {g->knots, 1, knots, knots, knots}, r = {g->row, g->lines * (size_t)g->ncomp, rows, rows, rows};
    return (sweep){g, k, r};
}

static void move(const gap *g, size_t to, size_t from, size_t n)
{
    memmove(g->array + to * g->width, g->array + from * g->width, n * g->width * sizeof *g->array);
}

// The gap begins at `place`, unless it does so before that.
static void lower_gap(gap *g, size_t place)
{
    if (place >= g->begin) return;
    size_t n = g->begin - place;
    move(g, g->end - n, place, n);
    g->begin = place, g->end -= n;
}

static void take_out(gap *g, size_t place)
{
    move(g, place, place + 1, g->begin - place - 1);
    g->begin--;
}

// The removal of some or all copies of a knot, the last of which is s, reads rows up to s and knots up to s + degree,
// and leaves that many before the gap for the next copy.
static void sweep_to(sweep *w, int s)
{
    lower_gap(&w->rows, (size_t)s + 1);
    lower_gap(&w->knots, (size_t)(s + w->g->degree) + 1);
}

static void commit(const removal *r, sweep *w)
{
    int n = r->degree - r->m + 1, first = r->s - r->degree - 1;
    memcpy(row_of(w->g, first), r->d, (size_t)(n + 1) * r->width * sizeof *r->d);
    take_out(&w->rows, (size_t)(first + n + 1));
    take_out(&w->knots, (size_t)r->s);
    w->g->count--;
}

static void end_sweep(sweep *w)
{
    move(&w->rows, w->rows.begin, w->rows.end, w->rows.total - w->rows.end);
    move(&w->knots, w->knots.begin, w->knots.end, w->knots.total - w->knots.end);
}

// The last index and the multiplicity of the interior knots before index s; s = count starts, 0 ends.
static int previous(const kn_rows *g, int s, int *m)
{
    if (--s <= g->degree) return 0;
    *m = 1;
    while (s - *m > g->degree && g->knots[s - *m] == g->knots[s]) ++*m;
    return s;
}

static void remove_exactly(removal *r, kn_rows *g, double only)
{
    int m = 0;
    sweep w = start_sweep(g);
    for (int s = previous(g, g->count, &m); s > 0; s = previous(g, s - m + 1, &m)) {
        if (!isnan(only) && g->knots[s] != only) continue;
        sweep_to(&w, s);
        for (; m > 0; m--, s--) {
            aim(r, g, s, m);
            for (int k = 0; k < r->degree + 3; k++) r->mu[k] = 0.0;
            solve(r, g, 0.0);
            if (!is_exact(r, g)) break;
            commit(r, &w);
        }
    }
    end_sweep(&w);
}

typedef struct candidate {
    double change; // what its removal adds to the error nearby
    int s, m;
} candidate;

static int by_change(const void *a, const void *b)
{
    const candidate *x = a, *y = b;
    if (x->change != y->change) return x->change < y->change ? -1 : 1;
    return (x->s > y->s) - (x->s < y->s);
}

// About what moving c_i .. by `sum` changes in values, and what rounding will hide: a prediction, which
// kn_rows_distance has to confirm.
static double change_of(const removal *r, const kn_rows *g)
{
    double most = 0.0, rounding = (6 * g->degree + 8) * 0x1p-53;
    int dim = g->ncomp - g->rational;
    for (size_t l = 0; l < g->lines; l++) {
        const double *x = r->sum + l * (size_t)g->ncomp;
        double length = 0.0, w = g->rational ? INFINITY : 1.0, large = 0.0; // large: the largest coordinate nearby
        for (int k = r->s - r->degree - 1; k <= r->s - r->m + 1; k++) {
            const double *c = row_of(g, k) + l * (size_t)g->ncomp;
            double own = g->rational ? c[dim] : 1.0;
            for (int q = 0; q < dim; q++) large = fmax(large, fabs(c[q]) / own);
            w = fmin(w, own);
        }
        for (int q = 0; q < dim; q++) length = hypot(length, x[q]);
        if (g->rational) length = (length + fabs(x[dim]) * large) / w;
        length += rounding * large;
        if (length > most || isnan(length)) most = length;
    }
    return most;
}

// The largest error so far where B-splines s-p .. s-m of g are not zero.
static double error_near(const kn_rows *f, const double *local, const kn_rows *g, int s, int m)
{
    bool jump = m > g->degree; // then those of both sides
    double lo = g->knots[s - g->degree - jump], hi = g->knots[jump ? s + 1 : s - m + g->degree + 1], most = 0.0;
    int from = 0, end = f->count;
    while (from < end) { // the first with t_i+p+1 > lo
        int mid = (from + end) / 2;
        if (f->knots[mid + f->degree + 1] > lo)
            end = mid;
        else
            from = mid + 1;
    }
    for (int i = from; i < f->count && f->knots[i] < hi; i++) most = fmax(most, local[i]);
    return most;
}

typedef struct greedy {
    const kn_rows *f;
    kn_rows *g, spare; // spare: what g was
    removal r;
    double tolerance, only, bound;
    double *local, *fresh; // the errors so far, and room for the next ones
    bool *busy;            // g's coefficients that a removal of this round uses
    bool *kept;            // by place in f's knots: tried alone in vain
    candidate *list;
} greedy;

static kn_status make_greedy(kn_ctx *ctx, greedy *w, const kn_rows *f, kn_rows *g)
{
    size_t n = (size_t)f->count + (size_t)f->degree + 1, all = (size_t)f->count * f->lines * (size_t)f->ncomp;
    w->f = f, w->g = g, w->spare = *g;
    w->spare.knots = kn_scratch(ctx, n, sizeof(double));
    w->spare.row = kn_scratch(ctx, all, sizeof(double));
    w->local = kn_scratch(ctx, n, sizeof(double));
    w->fresh = kn_scratch(ctx, n, sizeof(double));
    w->busy = kn_scratch(ctx, n, sizeof(bool));
    w->kept = kn_scratch(ctx, n, sizeof(bool));
    w->list = kn_scratch(ctx, n, sizeof(candidate));
    if (!w->spare.knots || !w->spare.row || !w->local || !w->fresh || !w->busy || !w->kept || !w->list)
        return KN_ENOMEM;
    for (size_t i = 0; i < n; i++) w->local[i] = 0.0, w->kept[i] = false;
    return make_room(ctx, &w->r, g);
}

static bool *kept_flag(const greedy *w, double x)
{
    int from = 0, end = w->f->count + w->f->degree;
    while (from < end) {
        int mid = (from + end) / 2;
        if (w->f->knots[mid] >= x)
            end = mid;
        else
            from = mid + 1;
    }
    return &w->kept[from];
}

// The removals whose predicted error is allowed and that do not meet each other, the cheapest first.
static int choose(greedy *w)
{
    kn_rows *g = w->g;
    int n = 0, m = 0, chosen = 0;
    for (int s = previous(g, g->count, &m); s > 0; s = previous(g, s - m + 1, &m)) {
        if ((!isnan(w->only) && g->knots[s] != w->only) || *kept_flag(w, g->knots[s])) continue;
        aim(&w->r, g, s, m);
        weigh(&w->r, g);
        double change = change_of(&w->r, g);
        if (error_near(w->f, w->local, g, s, m) + change <= w->tolerance) w->list[n++] = (candidate){change, s, m};
    }
    qsort(w->list, (size_t)n, sizeof *w->list, by_change);
    memset(w->busy, 0, (size_t)(g->count + g->degree + 1) * sizeof *w->busy);
    for (int k = 0; k < n; k++) {
        candidate c = w->list[k];
        int from = c.s - g->degree - 1, end = c.s - c.m + g->degree + 1;
        bool free = true;
        if (end > g->count + g->degree) end = g->count + g->degree;
        for (int i = from; i <= end && free; i++) free = !w->busy[i];
        if (!free) continue;
        memset(w->busy + from, 1, (size_t)(end - from + 1) * sizeof *w->busy);
        w->list[chosen++] = c;
    }
    return chosen;
}

static int by_place_down(const void *a, const void *b)
{
    const candidate *x = a, *y = b;
    return (x->s < y->s) - (x->s > y->s);
}

static void copy_rows(kn_rows *to, const kn_rows *from)
{
    memcpy(to->knots, from->knots, (size_t)(from->count + from->degree + 1) * sizeof *to->knots);
    memcpy(to->row, from->row, (size_t)from->count * from->lines * (size_t)from->ncomp * sizeof *to->row);
    to->count = from->count;
}

// Removes the n cheapest, all at once, and asks for the distance; what passes the tolerance is undone and half as
// many are tried. One that fails alone is kept for good.
static kn_status attempt(kn_ctx *ctx, greedy *w, int n)
{
    copy_rows(&w->spare, w->g);
    for (; n > 0; n /= 2) {
        double bound, x = w->g->knots[w->list[0].s];
        qsort(w->list, (size_t)n, sizeof *w->list, by_place_down); // so that the places of the others stay
        sweep all = start_sweep(w->g);
        for (int k = 0; k < n; k++) {
            sweep_to(&all, w->list[k].s);
            aim(&w->r, w->g, w->list[k].s, w->list[k].m);
            weigh(&w->r, w->g);
            solve(&w->r, w->g, 1.0);
            commit(&w->r, &all);
        }
        end_sweep(&all);
        kn_status status = kn_rows_distance(ctx, &bound, w->fresh, w->f, w->g);
        if (status != KN_OK) return status;
        if (bound <= w->tolerance) {
            double *old = w->local;
            w->local = w->fresh, w->fresh = old, w->bound = bound;
            return KN_OK;
        }
        copy_rows(w->g, &w->spare);
        qsort(w->list, (size_t)n, sizeof *w->list, by_change);
        if (n == 1) *kept_flag(w, x) = true;
    }
    return KN_OK;
}

static kn_status remove_within(kn_ctx *ctx, const char *call, kn_rows *g, double *error, double tolerance,
                               double only)
{
    size_t n = (size_t)g->count * g->lines;
    for (size_t i = 0; i < n && g->rational; i++)
        if (!(g->row[(i + 1) * (size_t)g->ncomp - 1] > 0.0))
            return kn_fail(ctx, KN_EDOMAIN, "%s: weight %g", call, g->row[(i + 1) * (size_t)g->ncomp - 1]);
    kn_rows f = *g;
    greedy w = {.tolerance = tolerance, .only = only};
    f.knots = kn_scratch(ctx, (size_t)(g->count + g->degree + 1), sizeof *f.knots);
    f.row = kn_scratch(ctx, n * (size_t)g->ncomp, sizeof *f.row);
    kn_status status = f.knots && f.row ? make_greedy(ctx, &w, &f, g) : KN_ENOMEM;
    if (status != KN_OK) return status;
    copy_rows(&f, g);
    for (int some = choose(&w); some > 0 && status == KN_OK; some = choose(&w)) status = attempt(ctx, &w, some);
    *error = w.bound;
    return status;
}

kn_status kn_rows_remove(kn_ctx *ctx, const char *call, kn_rows *rows, double *error, double tolerance, double only)
{
    removal r = {.s = 0};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = make_room(ctx, &r, rows);
    if (status == KN_OK) {
        memset(r.sum, 0, r.width * sizeof *r.sum);
        remove_exactly(&r, rows, only);
        *error = 0.0;
        if (tolerance > 0.0) status = remove_within(ctx, call, rows, error, tolerance, only);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
