// SPDX-License-Identifier: Apache-2.0
// Fuzzes the algebra of splines: a few splines, then calls by bytes whose results are the next operands, in place too.
#include "tests/fuzz/feed.h"

enum { SLOTS = 4, MOST_CALLS = 10, MOST_COEFS = 3000, MOST_DEGREE = 16 };

typedef struct machine {
    feed f;
    kn_spline slot[SLOTS];
} machine;

static size_t size_of(const kn_spline *s)
{
    return s->nvars ? kn_spline_count(s) * (size_t)s->ncomp : 0;
}

// What a call hands out obeys the rules of splines but for numbers that are not finite; results that grow go.
static void settle(machine *m, kn_spline *s)
{
    bool high = false;
    if (s->nvars == 0) return;
    kn_spline same = {0};
    if (kn_spline_init(m->f.ctx, &same, s->nvars, s->ncomp, s->rational, s->degree, s->count,
                       (const double *const *)s->knots, s->coef) != KN_OK)
        abort();
    kn_spline_clear(m->f.ctx, &same);
    for (int d = 0; d < s->nvars; d++) high |= s->degree[d] > MOST_DEGREE;
    if (high || size_of(s) > MOST_COEFS) kn_spline_clear(m->f.ctx, s);
}

static int variable(machine *m, const kn_spline *a)
{
    return feed_wild(&m->f, 0, a->nvars > 0 ? a->nvars - 1 : 0);
}

// Parameters in the domain mostly.
static double *parameters(machine *m, const kn_spline *a, size_t npoints)
{
    size_t n = (size_t)a->nvars;
    double *at = feed_parameters(&m->f, n * npoints);
    for (size_t i = 0; i < n * npoints; i++) {
        double lo, hi;
        kn_spline_domain(a, (int)(i % n), &lo, &hi);
        if (at[i] >= 0.0 && at[i] <= 1.0) at[i] = lo + at[i] * (hi - lo);
    }
    return at;
}

// Values and partials; the values have the bits of a batch.
static kn_status partials(feed *f, double *values, const kn_spline *a, size_t npoints, const double *at, size_t dim)
{
    size_t stride = ((size_t)a->nvars + 1) * dim;
    double *out = feed_room(f, npoints * stride);
    kn_status status = kn_spline_eval_batch_partials(f->ctx, out, a, npoints, at);
    if (status != KN_OK) return status;
    if (kn_spline_eval_batch(f->ctx, values, a, npoints, at) != KN_OK) abort();
    for (size_t i = 0; i < npoints; i++)
        if (!feed_same(out + i * stride, values + i * dim, dim)) abort();
    return KN_OK;
}

static kn_status grid(feed *f, const kn_spline *a, size_t dim)
{
    size_t n[KN_MAX_VARS + 1] = {0}, total = 1;
    const double *axis[KN_MAX_VARS + 1] = {NULL};
    for (int d = 0; d < a->nvars; d++) {
        double *at = feed_parameters(f, n[d] = (size_t)feed_int(f, 0, a->nvars == 1 ? 80 : 9)), lo, hi;
        kn_spline_domain(a, d, &lo, &hi);
        for (size_t i = 0; i < n[d]; i++)
            if (at[i] >= 0.0 && at[i] <= 1.0) at[i] = lo + at[i] * (hi - lo);
        axis[d] = at, total *= n[d];
    }
    return kn_spline_eval_grid(f->ctx, feed_room(f, total * dim), a, n, axis);
}

static kn_status numbers(machine *m, int call, const kn_spline *a)
{
    feed *f = &m->f;
    size_t npoints = feed_points(f), dim = a->nvars ? (size_t)kn_spline_dim(a) : 1;
    const double *at = parameters(m, a, npoints + 1), *hi = parameters(m, a, 1);
    double *room = feed_room(f, dim * (npoints + 1)), *other = feed_room(f, dim);
    switch (call) {
    case 0: return kn_spline_eval(f->ctx, room, a, at);
    case 1: return kn_spline_eval_batch(f->ctx, room, a, npoints, at);
    case 2: return kn_spline_integral(f->ctx, room, a);
    case 3: return kn_spline_box(f->ctx, room, other, a);
    case 4: return kn_spline_box_over(f->ctx, room, other, a, at, hi);
    case 5: return kn_spline_oriented_box(f->ctx, feed_block(f, sizeof(kn_oriented_box)), a);
    case 6: return kn_spline_lipschitz(f->ctx, feed_room(f, (size_t)a->nvars), a);
    case 7: {
        int *degree = feed_block(f, (size_t)a->nvars * sizeof *degree);
        return kn_spline_least_degree(f->ctx, degree, a, feed_number(f));
    }
    case 8: return partials(f, room, a, npoints, at, dim);
    case 9: return grid(f, a, dim);
    default: {
        int order = feed_wild(f, 0, 4), count = kn_derivative_count(a->nvars, order);
        if ((size_t)count * dim > 1 << 13) return KN_OK;
        return kn_spline_derivatives(f->ctx, feed_room(f, (size_t)count * dim), a, at, order);
    }
    }
}

static int *int_array(feed *f, int n, int lo, int hi)
{
    int *x = feed_block(f, (size_t)n * sizeof *x);
    for (int i = 0; i < n; i++) x[i] = feed_wild(f, lo, hi);
    return x;
}

// Maps of values, and of variables.
static kn_status unary(machine *m, int call, kn_spline *out, const kn_spline *a)
{
    feed *f = &m->f;
    int n = a->nvars, var = variable(m, a);
    switch (call) {
    case 0: return kn_spline_copy(f->ctx, out, a);
    case 1: return kn_spline_derivative(f->ctx, out, a, var);
    case 2: return kn_spline_antiderivative(f->ctx, out, a, var);
    case 3: return kn_spline_gradient(f->ctx, out, a);
    case 4: return kn_spline_divergence(f->ctx, out, a);
    case 5: return kn_spline_reverse(f->ctx, out, a, var);
    case 6: return kn_spline_permute(f->ctx, out, a, int_array(f, n, 0, n > 0 ? n - 1 : 0));
    case 7: return kn_spline_components(f->ctx, out, a, feed_wild(f, 0, 2), feed_wild(f, 1, 3));
    case 10: return kn_spline_scale(f->ctx, out, a, feed_number(f));
    case 8: return kn_spline_reparameterize(f->ctx, out, a, var, feed_number(f), feed_number(f));
    case 9: {
        int dim = feed_wild(f, 1, 4);
        size_t rows = dim < 1 || dim > KN_MAX_COMPS ? 0 : (size_t)dim, columns = n ? (size_t)a->ncomp : 1;
        const double *matrix = feed_numbers(f, rows * columns);
        return kn_spline_affine(f->ctx, out, a, dim, matrix, feed_byte(f) % 2 ? feed_numbers(f, rows) : NULL);
    }
    case 12: return kn_spline_isoparametric(f->ctx, out, a, var, n ? parameters(m, a, 1)[n - 1] : feed_number(f));
    case 11: {
        int *degree = int_array(f, n, 0, 5);
        double error;
        for (int d = 0; d < n && feed_byte(f) % 8; d++)
            if (degree[d] > a->degree[d]) degree[d] = a->degree[d];
        return kn_spline_reduce(f->ctx, out, feed_byte(f) % 2 ? &error : NULL, a, degree);
    }
    default: {
        int *degree = int_array(f, n, 0, 5);
        for (int d = 0; d < n; d++)
            if (feed_byte(f) % 8) degree[d] = a->degree[d] + feed_int(f, 0, 2);
        return kn_spline_elevate(f->ctx, out, a, degree);
    }
    }
}

static kn_status refine(machine *m, kn_spline *out, const kn_spline *a)
{
    int n[KN_MAX_VARS] = {0};
    const double *knots[KN_MAX_VARS] = {NULL};
    for (int d = 0; d < a->nvars; d++) {
        n[d] = feed_wild(&m->f, 0, 4);
        if (n[d] > 4) n[d] = 4;
        double *new = feed_numbers(&m->f, n[d] > 0 ? (size_t)n[d] : 0), lo, hi;
        kn_spline_domain(a, d, &lo, &hi);
        for (int i = 0; i < n[d]; i++)
            if (feed_byte(&m->f) % 8) new[i] = lo + (hi - lo) * feed_byte(&m->f) / 255.0;
        knots[d] = new;
    }
    return kn_spline_refine(m->f.ctx, out, a, n, knots);
}

// Knots, parts of the domain.
static kn_status knots(machine *m, int call, kn_spline *out, const kn_spline *a)
{
    feed *f = &m->f;
    int var = variable(m, a), n = feed_wild(f, 0, 5);
    size_t length = n < 0 || n > 5 ? 5 : (size_t)n;
    double *at = parameters(m, a, 6), error = 0.0;
    if (n > 5) n = 5;
    switch (call) {
    case 0: {
        double *new = feed_room(f, length);
        for (size_t i = 0; i < length && a->nvars > 0; i++) new[i] = at[i % (size_t)(6 * a->nvars)];
        return kn_spline_insert_knots(f->ctx, out, a, var, new, n);
    }
    case 1: return kn_spline_restrict(f->ctx, out, a, at, parameters(m, a, 1));
    case 2: return kn_spline_remove_knots(f->ctx, out, &error, a, var, feed_number(f));
    case 3: return refine(m, out, a);
    default:
        return kn_spline_subdivide(f->ctx, out, &m->slot[feed_int(f, 0, SLOTS - 1)], a, var,
                                   a->nvars ? at[0] : feed_number(f));
    }
}

static bool too_large(const kn_spline *a, const kn_spline *b)
{
    return size_of(a) * size_of(b) > 1 << 14;
}

static kn_status binary(machine *m, int call, kn_spline *out, const kn_spline *a, const kn_spline *b)
{
    feed *f = &m->f;
    double error = 0.0;
    if (too_large(a, b)) return KN_OK;
    switch (call) {
    case 0: return kn_spline_sum(f->ctx, out, a, b);
    case 1: return kn_spline_product(f->ctx, out, a, b);
    case 2: return kn_spline_dot(f->ctx, out, a, b);
    case 3: return kn_spline_cross(f->ctx, out, a, b);
    case 5: return kn_spline_difference(f->ctx, out, a, b);
    case 6: {
        const kn_spline *c = &m->slot[feed_int(f, 0, SLOTS - 1)];
        if (too_large(a, c) || size_of(a) * size_of(b) * size_of(c) > 1 << 16) return KN_OK;
        return kn_spline_determinant(f->ctx, out, a, b, c);
    }
    case 4: return kn_spline_merge(f->ctx, out, &error, a, b, variable(m, a), feed_number(f));
    default: return kn_spline_make_compatible(f->ctx, m->slot, feed_count(f, 0, SLOTS));
    }
}

// Pieces and back, with the breaks of the spline and continuities by bytes.
static kn_status pieces(machine *m, kn_spline *out, const kn_spline *a)
{
    feed *f = &m->f;
    kn_bezier *piece = NULL;
    size_t n = 0;
    kn_status status = kn_spline_to_bezier(f->ctx, &piece, &n, a);
    if (status != KN_OK) return status;
    int nbreaks[KN_MAX_VARS], continuity[KN_MAX_VARS];
    const double *breaks[KN_MAX_VARS];
    for (int d = 0; d < a->nvars; d++) {
        nbreaks[d] = kn_spline_spans(a, d) + 1;
        double *b = feed_room(f, (size_t)nbreaks[d]);
        for (int i = 0; i < nbreaks[d]; i++) b[i] = feed_byte(f) < 250 ? i : feed_number(f);
        breaks[d] = b;
        continuity[d] = feed_wild(f, -1, a->degree[d] > 0 ? a->degree[d] - 1 : -1);
    }
    status = kn_spline_from_bezier(f->ctx, out, piece, nbreaks, breaks, continuity);
    if (status == KN_OK && feed_byte(f) % 4 == 0) status = kn_spline_of_bezier(f->ctx, out, &piece[0]);
    for (size_t i = 0; i < n; i++) kn_bezier_clear(f->ctx, &piece[i]);
    kn_free(f->ctx, piece);
    return status;
}

enum { NUMBERS = 11, UNARY = 14, KNOTS = 5, BINARY = 8 };

static void call(machine *m)
{
    feed *f = &m->f;
    int which = feed_byte(f) % (NUMBERS + UNARY + KNOTS + BINARY + 1), place = feed_int(f, 0, SLOTS - 1);
    kn_spline *out = &m->slot[place];
    const kn_spline *a = &m->slot[feed_int(f, 0, SLOTS - 1)], *b = &m->slot[feed_int(f, 0, SLOTS - 1)];
    kn_status status;
    if (which < NUMBERS)
        status = numbers(m, which, a);
    else if ((which -= NUMBERS) < UNARY)
        status = unary(m, which, out, a);
    else if ((which -= UNARY) < KNOTS)
        status = knots(m, which, out, a);
    else if ((which -= KNOTS) < BINARY)
        status = binary(m, which, out, a, b);
    else
        status = pieces(m, out, a);
    if ((status == KN_OK) != (kn_ctx_error(f->ctx) == KN_OK)) abort(); // a failure is recorded
    kn_ctx_clear_error(f->ctx);
    feed_drop(f);
    for (int i = 0; i < SLOTS; i++) settle(m, &m->slot[i]);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    machine m = {.f = feed_begin(data, size)};
    int nvars = feed_int(&m.f, 1, 3);
    for (int i = 0; i < SLOTS; i++) feed_spline(&m.f, &m.slot[i], feed_byte(&m.f) < 240 ? nvars : 1);
    feed_drop(&m.f);
    kn_ctx_clear_error(m.f.ctx);
    for (int i = 0; i < MOST_CALLS && m.f.left > 0; i++) call(&m);
    kn_spline_swap(&m.slot[0], &m.slot[1]);
    for (int i = 0; i < SLOTS; i++) kn_spline_clear(m.f.ctx, &m.slot[i]);
    feed_end(&m.f);
    return 0;
}
