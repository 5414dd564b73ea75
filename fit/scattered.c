// SPDX-License-Identifier: Apache-2.0
// Least squares of scattered data: one banded system, whose rows are the points, sorted by their first free
// control point.
#include <math.h>
#include <stdlib.h>

#include "fit/internal.h"
#include "kernel/banded.h"
#include "kernel/context.h"
#include "spline/internal.h"

static const char call[] = "fit_scattered";

typedef struct row_place {
    size_t first, point;
} row_place;

typedef struct problem {
    const kn_spline *s;
    size_t npoints;
    const double *at, *values, *weights;
    int first[KN_MAX_VARS], nfree[KN_MAX_VARS];
    size_t stride[KN_MAX_VARS]; // of free control points
    int columns, width;
    row_place *order;
    double *r, *x, *row, *turn;
    double *basis[KN_MAX_VARS]; // of one point
} problem;

static int by_place(const void *a, const void *b)
{
    const row_place *x = a, *y = b;
    if (x->first != y->first) return x->first < y->first ? -1 : 1;
    return x->point < y->point ? -1 : x->point > y->point;
}

// The first free control point in variable d that a point with span s may act on, in free numbers.
static int start_of(const problem *w, int d, int span)
{
    int at = span - w->s->degree[d] - w->first[d], last = w->nfree[d] - 1;
    return at < 0 ? 0 : at > last ? last : at;
}

static int span_of(const problem *w, int d, size_t point)
{
    const kn_spline *s = w->s;
    return kn_knots_span(s->knots[d], s->degree[d], s->count[d], w->at[point * (size_t)s->nvars + (size_t)d]);
}

static kn_status sort_points(kn_ctx *ctx, problem *w)
{
    const kn_spline *s = w->s;
    for (size_t i = 0; i < w->npoints; i++) {
        w->order[i] = (row_place){0, i};
        for (int d = 0; d < s->nvars; d++) {
            double x = w->at[i * (size_t)s->nvars + (size_t)d], lo, hi;
            kn_spline_domain(s, d, &lo, &hi);
            if (!(x >= lo && x <= hi))
                return kn_fail(ctx, KN_EDOMAIN, "%s: point %zu: %g is not in [%g, %g]", call, i, x, lo, hi);
            w->order[i].first += (size_t)start_of(w, d, span_of(w, d, i)) * w->stride[d];
        }
        if (w->weights && !(w->weights[i] > 0.0 && isfinite(w->weights[i])))
            return kn_fail(ctx, KN_EDOMAIN, "%s: point %zu: weight %g", call, i, w->weights[i]);
    }
    qsort(w->order, w->npoints, sizeof *w->order, by_place);
    return KN_OK;
}

static kn_status prepare(kn_ctx *ctx, problem *w, const kn_fit_fixed *fixed)
{
    const kn_spline *s = w->s;
    kn_status status = kn_fit_check_fixed(ctx, call, s->nvars, s->count, fixed);
    if (status != KN_OK) return status;
    size_t columns = 1, width = 1, basis = 0;
    for (int d = s->nvars - 1; d >= 0; d--) {
        w->first[d] = fixed ? fixed->first[d] : 0;
        w->nfree[d] = s->count[d] - w->first[d] - (fixed ? fixed->last[d] : 0);
        w->stride[d] = columns;
        width += (size_t)(s->degree[d] < w->nfree[d] - 1 ? s->degree[d] : w->nfree[d] - 1) * columns;
        columns *= (size_t)w->nfree[d];
        basis += (size_t)s->degree[d] + 1;
    }
    if (columns > KN_MAX_COEFS / width || w->npoints > KN_MAX_COEFS)
        return kn_fail(ctx, KN_ELIMIT, "%s: %zu points, %zu coefficients in a band of %zu", call, w->npoints, columns,
                       width);
    w->columns = (int)columns, w->width = (int)width;
    w->order = kn_scratch(ctx, w->npoints, sizeof *w->order);
    w->r = kn_scratch(ctx, columns * width, sizeof *w->r);
    w->x = kn_scratch(ctx, columns * (size_t)s->ncomp, sizeof *w->x);
    w->row = kn_scratch(ctx, 3 * width, sizeof *w->row);
    w->basis[0] = kn_scratch(ctx, basis, sizeof *w->basis[0]);
    if (!w->order || !w->r || !w->x || !w->row || !w->basis[0]) return KN_ENOMEM;
    w->turn = w->row + width;
    for (int d = 1; d < s->nvars; d++) w->basis[d] = w->basis[d - 1] + s->degree[d - 1] + 1;
    for (size_t i = 0; i < columns * width; i++) w->r[i] = 0.0;
    for (size_t i = 0; i < columns * (size_t)s->ncomp; i++) w->x[i] = 0.0;
    return sort_points(ctx, w);
}

// Calls visit for each control point that acts at a point, with its B-spline's value and its place among all and
// among the free ones (SIZE_MAX: given).
typedef void (*visitor)(void *user, double value, size_t at, size_t place);
static void each_acting(const problem *w, size_t point, visitor visit, void *user)
{
    const kn_spline *s = w->s;
    int k[KN_MAX_VARS] = {0}, from[KN_MAX_VARS];
    for (int d = 0; d < s->nvars; d++) {
        int span = span_of(w, d, point);
        from[d] = span - s->degree[d];
        kn_knots_basis(w->basis[d], s->knots[d], s->degree[d], span, w->at[point * (size_t)s->nvars + (size_t)d], 0);
    }
    for (int d = 0; d >= 0;) {
        double value = 1.0;
        size_t at = 0, place = 0;
        for (int e = 0; e < s->nvars; e++) {
            int i = from[e] + k[e], j = i - w->first[e];
            value *= w->basis[e][k[e]];
            at = at * (size_t)s->count[e] + (size_t)i;
            place = place == SIZE_MAX || j < 0 || j >= w->nfree[e] ? SIZE_MAX : place + (size_t)j * w->stride[e];
        }
        visit(user, value, at, place);
        for (d = s->nvars - 1; d >= 0 && ++k[d] > s->degree[d]; d--) k[d] = 0;
    }
}

typedef struct equation {
    const problem *w;
    size_t first;
    double weight, *y; // y: the value less what given control points contribute, times the weight
} equation;

static void add_term(void *user, double value, size_t at, size_t place)
{
    equation *e = user;
    const kn_spline *s = e->w->s;
    size_t n = kn_spline_count(s);
    if (place != SIZE_MAX)
        e->w->row[place - e->first] = e->weight * value;
    else
        for (size_t c = 0; c < (size_t)s->ncomp; c++) e->y[c] -= e->weight * value * s->coef[c * n + at];
}

static void eliminate(const problem *w)
{
    int dim = w->s->ncomp;
    double y[KN_MAX_COMPS];
    for (size_t i = 0; i < w->npoints; i++) {
        size_t point = w->order[i].point;
        equation e = {w, w->order[i].first, w->weights ? w->weights[point] : 1.0, y};
        for (int c = 0; c < dim; c++) y[c] = e.weight * w->values[point * (size_t)dim + (size_t)c];
        for (int k = 0; k < w->width; k++) w->row[k] = 0.0;
        each_acting(w, point, add_term, &e);
        kn_banded_turn_row(w->r, w->columns, w->width, w->row, (int)e.first, w->turn);
        kn_banded_turn_data(w->x, w->columns, w->width, y, (int)e.first, w->turn, (size_t)dim);
    }
}

// Of a curve the condition of Schoenberg and Whitney decides; otherwise a diagonal element of the size of its own
// rounding error, rows and columns counted, tells that the points leave the control point open.
static kn_status check_rank(kn_ctx *ctx, const problem *w)
{
    double largest = 0.0;
    for (size_t i = 0; i < (size_t)w->columns * (size_t)w->width; i++) largest = fmax(largest, fabs(w->r[i]));
    double least = w->s->nvars == 1 ? 0.0 : 0x1p-52 * ((double)w->npoints + w->columns) * largest;
    for (int i = 0; i < w->columns; i++) {
        double r = fabs(w->r[(size_t)i * (size_t)w->width]);
        if (r > least && isfinite(r)) continue;
        return kn_fail(ctx, w->s->nvars == 1 ? KN_EUNDECIDED : KN_EUNDEFINED,
                       "%s: the points do not determine free control point %d", call, i);
    }
    return KN_OK;
}

static kn_status check_curve(kn_ctx *ctx, const problem *w)
{
    const kn_spline *s = w->s;
    kn_fit_axis axis = {0, s->degree[0], s->count[0], s->knots[0], (int)w->npoints, NULL};
    double *sites = kn_scratch(ctx, w->npoints, sizeof *sites);
    if (!sites) return KN_ENOMEM;
    for (size_t i = 0; i < w->npoints; i++) sites[i] = w->at[i];
    qsort(sites, w->npoints, sizeof *sites, kn_knots_by_value);
    axis.sites = sites;
    return kn_fit_suits(ctx, call, &axis, w->first[0], w->first[0] + w->nfree[0]);
}

typedef struct sum {
    const kn_spline *s;
    double *value;
} sum;

static void add_value(void *user, double value, size_t at, size_t place)
{
    const sum *to = user;
    size_t n = kn_spline_count(to->s);
    (void)place;
    for (size_t c = 0; c < (size_t)to->s->ncomp; c++) to->value[c] += value * to->s->coef[c * n + at];
}

static double largest_distance(const problem *w)
{
    double largest = 0.0, value[KN_MAX_COMPS];
    int dim = w->s->ncomp;
    for (size_t i = 0; i < w->npoints; i++) {
        double square = 0.0;
        for (int c = 0; c < dim; c++) value[c] = 0.0;
        each_acting(w, i, add_value, &(sum){w->s, value});
        for (int c = 0; c < dim; c++) {
            double off = value[c] - w->values[i * (size_t)dim + (size_t)c];
            square += off * off;
        }
        if (!(square <= largest)) largest = square; // NaN stays
    }
    return sqrt(largest);
}

static kn_status fit(kn_ctx *ctx, problem *w, kn_spline *s, double *residual, const kn_fit_fixed *fixed)
{
    kn_status status = prepare(ctx, w, fixed);
    if (status == KN_OK && s->nvars == 1) status = check_curve(ctx, w);
    if (status != KN_OK) return status;
    kn_fit_put_fixed(s->coef, s->nvars, s->ncomp, s->count, fixed);
    eliminate(w);
    status = check_rank(ctx, w);
    if (status != KN_OK) return status;
    kn_banded_back(w->r, w->columns, w->width, w->x, (size_t)s->ncomp);
    double *free = kn_scratch(ctx, (size_t)w->columns * (size_t)s->ncomp, sizeof *free);
    if (!free) return KN_ENOMEM;
    kn_fit_by_component(free, w->x, (size_t)w->columns, s->ncomp);
    kn_fit_put_free(s->coef, free, s->nvars, s->ncomp, s->count, fixed);
    *residual = largest_distance(w);
    return KN_OK;
}

kn_status kn_fit_scattered(kn_ctx *ctx, kn_spline *out, double *residual, int nvars, int dim, const int *degree,
                           const int *count, const double *const *knots, size_t npoints, const double *at,
                           const double *values, const double *weights, const kn_fit_fixed *fixed)
{
    kn_spline s;
    double found;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_fit_start(ctx, call, &s, nvars, dim, degree, count, knots);
    problem w = {.s = &s, .npoints = npoints, .at = at, .values = values, .weights = weights};
    if (status == KN_OK) status = fit(ctx, &w, &s, &found, fixed);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    if (status == KN_OK && residual) *residual = found;
    kn_scratch_release(ctx, mark);
    return status;
}
