// SPDX-License-Identifier: Apache-2.0
// Fuzzes the algebra of pieces: a few pieces, then calls by bytes whose results are the next operands, in place too.
#include "tests/fuzz/feed.h"

enum { SLOTS = 4, MOST_CALLS = 12, MOST_COEFS = 4096 };

typedef struct machine {
    feed f;
    kn_bezier slot[SLOTS];
} machine;

static size_t size_of(const kn_bezier *b)
{
    return b->coef ? kn_bezier_count(b) * (size_t)b->ncomp : 0;
}

// What a call hands out has a shape that kn_bezier_init accepts, and results that grow too large go.
static void settle(machine *m, kn_bezier *out)
{
    kn_bezier same = {0};
    if (!out->coef) return;
    if (kn_bezier_init(m->f.ctx, &same, out->nvars, out->ncomp, out->rational, out->degree) != KN_OK) abort();
    if (size_of(&same) != size_of(out)) abort();
    kn_bezier_clear(m->f.ctx, &same);
    if (size_of(out) > MOST_COEFS) kn_bezier_clear(m->f.ctx, out);
}

static int *int_array(feed *f, int n, int lo, int hi)
{
    int *x = feed_block(f, (size_t)(n > 0 ? n : 0) * sizeof *x);
    for (int i = 0; i < n; i++) x[i] = feed_wild(f, lo, hi);
    return x;
}

static size_t places(int n)
{
    return n < 0 ? 0 : n > KN_MAX_VARS ? KN_MAX_VARS : (size_t)n;
}

static size_t dimension(const kn_bezier *a)
{
    return a->ncomp < 1 || a->ncomp > KN_MAX_COMPS ? 1 : (size_t)kn_bezier_dim(a);
}

// Values and partials; the values have the bits of a batch.
static kn_status partials(feed *f, double *values, const kn_bezier *a, size_t npoints, const double *at, size_t dim)
{
    size_t stride = (places(a->nvars) + 1) * dim;
    double *out = feed_room(f, npoints * stride);
    kn_status status = kn_bezier_eval_batch_partials(f->ctx, out, a, npoints, at);
    if (status != KN_OK) return status;
    if (kn_bezier_eval_batch(f->ctx, values, a, npoints, at) != KN_OK) abort();
    for (size_t i = 0; i < npoints; i++)
        if (!feed_same(out + i * stride, values + i * dim, dim)) abort();
    return KN_OK;
}

static kn_status grid(feed *f, const kn_bezier *a, size_t dim)
{
    size_t nvars = places(a->nvars), n[KN_MAX_VARS + 1] = {0}, total = 1;
    const double *axis[KN_MAX_VARS + 1] = {NULL};
    for (size_t d = 0; d < nvars; d++) {
        n[d] = (size_t)feed_int(f, 0, nvars == 1 ? 80 : nvars < 4 ? 7 : 2);
        axis[d] = feed_parameters(f, n[d]);
        total *= n[d];
    }
    return kn_bezier_eval_grid(f->ctx, feed_room(f, total * dim), a, n, axis);
}

// Numbers out of a piece.
static kn_status numbers(machine *m, int call, const kn_bezier *a)
{
    feed *f = &m->f;
    size_t nvars = places(a->nvars), npoints = feed_points(f);
    size_t dim = dimension(a);
    const double *at = feed_parameters(f, nvars * (npoints + 1)), *hi = feed_parameters(f, nvars);
    double *room = feed_room(f, dim * (npoints + 1)), *other = feed_room(f, dim);
    switch (call) {
    case 0: return kn_bezier_eval(f->ctx, room, a, at);
    case 1: return kn_bezier_eval_batch(f->ctx, room, a, npoints, at);
    case 2: return kn_bezier_integral(f->ctx, room, a);
    case 3: return kn_bezier_box(f->ctx, room, other, a, NULL, NULL);
    case 4: return kn_bezier_box(f->ctx, room, other, a, at, hi);
    case 5: return kn_bezier_oriented_box(f->ctx, feed_block(f, sizeof(kn_oriented_box)), a);
    case 6: return kn_bezier_least_degree(f->ctx, feed_block(f, nvars * sizeof(int)), a, feed_number(f));
    case 7: return partials(f, room, a, npoints, at, dim);
    case 8: return grid(f, a, dim);
    default: return kn_bezier_lipschitz(f->ctx, feed_room(f, nvars), a);
    }
}

static kn_status derivatives(machine *m, const kn_bezier *a)
{
    feed *f = &m->f;
    size_t nvars = places(a->nvars), dim = dimension(a);
    const double *at = feed_parameters(f, nvars);
    int order = feed_wild(f, 0, 4), count = kn_derivative_count((int)nvars, order), index[KN_MAX_VARS] = {0};
    if ((size_t)count * dim > 1 << 13) return KN_OK;
    kn_status status = kn_bezier_derivatives(f->ctx, feed_room(f, (size_t)count * dim), a, at, order);
    if (nvars > 0) index[nvars - 1] = order;
    if (status == KN_OK && nvars > 0 && kn_derivative_index((int)nvars, index) != count - 1) abort();
    return status;
}

// A piece out of one.
static kn_status unary(machine *m, int call, kn_bezier *out, const kn_bezier *a)
{
    feed *f = &m->f;
    int n = (int)places(a->nvars), var = feed_wild(f, 0, n > 0 ? n - 1 : 0), order = 0;
    switch (call) {
    case 0: return kn_bezier_copy(f->ctx, out, a);
    case 1: return kn_bezier_scale(f->ctx, out, a, feed_number(f));
    case 2: return kn_bezier_derivative(f->ctx, out, a, var);
    case 3: return kn_bezier_antiderivative(f->ctx, out, a, var);
    case 4: return kn_bezier_gradient(f->ctx, out, a);
    case 5: return kn_bezier_divergence(f->ctx, out, a);
    case 6: return kn_bezier_reverse(f->ctx, out, a, var);
    case 7: return kn_bezier_permute(f->ctx, out, a, int_array(f, n, 0, n > 0 ? n - 1 : 0));
    case 8: return kn_bezier_components(f->ctx, out, a, feed_wild(f, 0, 2), feed_wild(f, 1, 3));
    case 9: return kn_bezier_divide_edge(f->ctx, out, &order, a, var, feed_byte(f) % 2);
    case 10: {
        const double *lo = feed_parameters(f, (size_t)n), *hi = feed_parameters(f, (size_t)n);
        return kn_bezier_restrict(f->ctx, out, a, lo, hi);
    }
    case 11: {
        int dim = feed_wild(f, 1, 4), columns = a->ncomp > 0 && a->ncomp <= KN_MAX_COMPS ? a->ncomp : 1;
        size_t rows = dim < 1 || dim > KN_MAX_COMPS ? 0 : (size_t)dim;
        const double *matrix = feed_numbers(f, rows * (size_t)columns);
        return kn_bezier_affine(f->ctx, out, a, dim, matrix, feed_byte(f) % 2 ? feed_numbers(f, rows) : NULL);
    }
    case 12: {
        int *degree = int_array(f, n, 0, 5);
        double error;
        for (int d = 0; d < n && feed_byte(f) % 8; d++)
            if (degree[d] > a->degree[d]) degree[d] = a->degree[d];
        return kn_bezier_reduce(f->ctx, out, feed_byte(f) % 2 ? &error : NULL, a, degree);
    }
    default: {
        int *degree = int_array(f, n, 0, 5);
        for (int d = 0; d < n; d++)
            if (feed_byte(f) % 4) degree[d] = a->degree[d] + feed_int(f, 0, 3);
        return kn_bezier_elevate(f->ctx, out, a, degree);
    }
    }
}

// A piece out of two.
static kn_status binary(machine *m, int call, kn_bezier *out, const kn_bezier *a, const kn_bezier *b)
{
    feed *f = &m->f;
    if (size_of(a) * size_of(b) > 1 << 20) return KN_OK;
    switch (call) {
    case 0: return kn_bezier_sum(f->ctx, out, a, b);
    case 1: return kn_bezier_difference(f->ctx, out, a, b);
    case 2: return kn_bezier_product(f->ctx, out, a, b);
    case 3: return kn_bezier_dot(f->ctx, out, a, b);
    case 4: return kn_bezier_cross(f->ctx, out, a, b);
    case 5: {
        const kn_bezier *c = &m->slot[feed_int(f, 0, SLOTS - 1)];
        if (size_of(a) * size_of(b) * size_of(c) > 1 << 20) return KN_OK;
        return kn_bezier_determinant(f->ctx, out, a, b, c);
    }
    default: {
        int n = (int)places(a->nvars);
        kn_bezier *other = &m->slot[feed_int(f, 0, SLOTS - 1)];
        return kn_bezier_subdivide(f->ctx, out, other, a, feed_wild(f, 0, n > 0 ? n - 1 : 0), feed_number(f));
    }
    }
}

enum { NUMBERS = 10, UNARY = 14, BINARY = 7 };

static void call(machine *m)
{
    feed *f = &m->f;
    int which = feed_byte(f) % (NUMBERS + 1 + UNARY + 2 * BINARY), place = feed_int(f, 0, SLOTS - 1);
    kn_bezier *out = &m->slot[place];
    const kn_bezier *a = &m->slot[feed_int(f, 0, SLOTS - 1)], *b = &m->slot[feed_int(f, 0, SLOTS - 1)];
    bool is_broken = feed_byte(f) >= 244;
    kn_bezier broken = is_broken ? feed_broken(f, a) : *a;
    if (is_broken) a = &broken;
    kn_status status;
    if (which < NUMBERS)
        status = numbers(m, which, a);
    else if ((which -= NUMBERS) < 1)
        status = derivatives(m, a);
    else if ((which -= 1) < UNARY)
        status = unary(m, which, out, a);
    else
        status = binary(m, (which - UNARY) % BINARY, out, a, b);
    if ((status == KN_OK) != (kn_ctx_error(f->ctx) == KN_OK)) abort(); // a failure is recorded
    kn_ctx_clear_error(f->ctx);
    feed_drop(f);
    for (int i = 0; i < SLOTS; i++) settle(m, &m->slot[i]);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    machine m = {.f = feed_begin(data, size)};
    int nvars = feed_int(&m.f, 0, 3);
    for (int i = 0; i < SLOTS; i++) feed_bezier(&m.f, &m.slot[i], nvars);
    kn_ctx_clear_error(m.f.ctx);
    for (int i = 0; i < MOST_CALLS && m.f.left > 0; i++) call(&m);
    kn_bezier_swap(&m.slot[0], &m.slot[1]);
    if (m.slot[0].coef && kn_bezier_dim(&m.slot[0]) + m.slot[0].rational != m.slot[0].ncomp) abort();
    for (int i = 0; i < SLOTS; i++) kn_bezier_clear(m.f.ctx, &m.slot[i]);
    feed_end(&m.f);
    return 0;
}
