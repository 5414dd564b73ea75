// SPDX-License-Identifier: Apache-2.0
// Batched evaluation: the tables of a function.
#include "kernel/eval_block.h"

#include <math.h>
#include <string.h>

#include "kernel/binomial.h"
#include "kernel/knots.h"

enum { MAX_BUCKETS = 4096, ALIGN = 8 }; // ALIGN: numbers in 64 bytes

static size_t aligned(size_t n)
{
    return (n + ALIGN - 1) / ALIGN * ALIGN;
}

static int whole_vectors(int n)
{
    return (n + KN_EVAL_VECTOR - 1) / KN_EVAL_VECTOR * KN_EVAL_VECTOR;
}

static int spans_of(const kn_eval_function *f, int d)
{
    return f->knots[d] ? kn_knots_spans(f->knots[d], f->degree[d], f->count[d]) : 1;
}

static int buckets_of(int spans)
{
    return spans == 1 ? 1 : spans < MAX_BUCKETS / 4 ? 4 * spans : MAX_BUCKETS;
}

// Spans are found by halving from start[bucket]: up to 2^steps entries beyond the last one are NaN, which no t
// reaches. steps <= 30.
static size_t search_room(int spans)
{
    size_t n = 1;
    while (n <= (size_t)spans) n *= 2;
    return aligned((size_t)spans + n);
}

bool kn_eval_wants_plan(const kn_eval_function *f, size_t npoints)
{
    if (f->nvars > KN_EVAL_MAX_VARS) return false;
    double coefs = f->ncomp, tables = 0.0, point = 0.0; // work, in multiply-adds
    for (int d = 0; d < f->nvars; d++) {
        double cube = pow(f->degree[d] + 1, 3);
        coefs *= f->count[d];
        if (f->knots[d]) tables += spans_of(f, d) * cube, point += cube;
    }
    return (double)npoints * (point + f->ncomp) > coefs + tables;
}

size_t kn_eval_room(const kn_eval_function *f)
{
    size_t n = (size_t)whole_vectors(f->ncomp), most = 0;
    for (int d = 0; d < f->nvars; d++) n *= (size_t)f->count[d];
    n = aligned(n) + KN_EVAL_BLOCK; // coefficients, x
    for (int d = 0; d < f->nvars; d++) {
        size_t order = (size_t)f->degree[d] + 1, width = (size_t)whole_vectors(f->degree[d] + 1);
        int k = spans_of(f, d);
        n += aligned((size_t)k * order * width) + search_room(k) +
             aligned((size_t)k) * 2;                                                  // extract, left, inverse, first
        n += aligned((size_t)buckets_of(k)) + aligned(order) + KN_EVAL_BLOCK * width; // start, binomial, basis
        if (order > most) most = order;
    }
    return n + most * KN_EVAL_BLOCK;
}

static double *take(double **memory, size_t n)
{
    double *block = *memory;
    *memory += aligned(n);
    return block;
}

// left[i], i < spans, then NaN; extract from the blossoms of each span.
static void make_spans(kn_eval_axis *a, const double *knots, int count, double **memory)
{
    int p = a->degree;
    size_t room = search_room(a->spans), size = (size_t)(p + 1) * (size_t)a->width;
    double *left = take(memory, room), *inverse = take(memory, (size_t)a->spans);
    double *extract = knots ? take(memory, (size_t)a->spans * size) : NULL, args[KN_MAX_DEGREE + 1];
    size_t *first = (size_t *)(void *)take(memory, (size_t)a->spans);
    a->left = left, a->inverse = inverse, a->extract = extract, a->first = first;
    for (size_t i = 0; i < room; i++) left[i] = NAN;
    left[0] = 0.0, inverse[0] = 1.0, first[0] = 0;
    if (!knots) return;
    memset(extract, 0, (size_t)a->spans * size * sizeof *extract);
    for (int s = kn_knots_next_span(knots, p, count, -1), i = 0; s < count;
         s = kn_knots_next_span(knots, p, count, s), i++) {
        left[i] = knots[s];
        inverse[i] = 1.0 / (knots[s + 1] - knots[s]);
        first[i] = (size_t)(s - p) * a->stride;
        for (int r = 0; r <= p; r++) {
            for (int k = 0; k < p; k++) args[k] = k < p - r ? knots[s] : knots[s + 1];
            kn_knots_blossom(extract + (size_t)i * size + (size_t)r * (size_t)a->width, knots, p, s, args);
        }
    }
}

// The bucket of t grows with t, so a point in bucket b lies right of every break in a lower bucket, and left of every
// break in a higher one.
static void make_buckets(kn_eval_axis *a, double **memory)
{
    int *start = (int *)(void *)take(memory, (size_t)a->buckets), below = 0, upto = 0, range = 0;
    a->start = start;
    for (int b = 0; b < a->buckets; b++) {
        while (below + 1 < a->spans && kn_eval_bucket(a, a->left[below + 1]) < b) below++;
        while (upto + 1 < a->spans && kn_eval_bucket(a, a->left[upto + 1]) <= b) upto++;
        start[b] = below;
        if (upto - below > range) range = upto - below;
    }
    for (a->steps = 0; range > 0; range /= 2) a->steps++;
}

static void make_axis(kn_eval_axis *a, const kn_eval_function *f, int d, size_t stride, double **memory)
{
    const double *knots = f->knots[d];
    int p = f->degree[d];
    *a = (kn_eval_axis){.degree = p, .width = whole_vectors(p + 1), .spans = spans_of(f, d), .stride = stride};
    a->buckets = buckets_of(a->spans);
    a->lo = knots ? knots[0] : 0.0, a->end = knots ? knots[f->count[d]] : 1.0;
    a->scale = a->buckets / (a->end - a->lo);
    make_spans(a, knots, f->count[d], memory);
    make_buckets(a, memory);
    double *binomial = take(memory, (size_t)p + 1);
    kn_binomial_row(binomial, p);
    a->binomial = binomial;
    a->basis = take(memory, (size_t)KN_EVAL_BLOCK * (size_t)a->width);
}

void kn_eval_prepare(kn_eval_plan *plan, const kn_eval_function *f, double *memory)
{
    *plan = (kn_eval_plan){.nvars = f->nvars, .ncomp = f->ncomp, .rational = f->rational};
    size_t n = 1, width = (size_t)whole_vectors(f->ncomp), order = 0;
    plan->width = (int)width;
    for (int d = f->nvars - 1; d >= 0; d--) {
        make_axis(&plan->axis[d], f, d, n * width, &memory);
        n *= (size_t)f->count[d];
        if ((size_t)f->degree[d] + 1 > order) order = (size_t)f->degree[d] + 1;
    }
    plan->bernstein = take(&memory, order * KN_EVAL_BLOCK);
    plan->x = take(&memory, KN_EVAL_BLOCK);
    double *packed = take(&memory, n * width);
    plan->packed = packed;
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < width; c++) packed[i * width + c] = c < (size_t)f->ncomp ? f->coef[c * n + i] : 0.0;
}
