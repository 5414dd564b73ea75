// SPDX-License-Identifier: Apache-2.0
// Batched evaluation: the tables of a function.
#include "kernel/eval_block.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "kernel/binomial.h"
#include "kernel/knots.h"

enum { MAX_BUCKETS = 4096, MOST_SPLIT = 1 << 17 }; // MOST_SPLIT: numbers, half of a second-level cache

// Takes blocks from memory one after the other, or only counts when there is none.
typedef struct store {
    double *memory;
    size_t used;
} store;

static void *take(store *s, size_t n)
{
    double *block = s->memory ? s->memory + s->used : NULL;
    s->used += kn_eval_aligned(n);
    return block;
}

static int whole_vectors(int n)
{
    return (n + KN_EVAL_VECTOR - 1) / KN_EVAL_VECTOR * KN_EVAL_VECTOR;
}

// Components in whole vectors of any level.
static int packed_width(int ncomp)
{
    return ncomp <= KN_EVAL_VECTOR ? KN_EVAL_VECTOR : (int)kn_eval_aligned((size_t)ncomp);
}

static int spans_of(const kn_eval_function *f, int d)
{
    return f->knots[d] ? kn_knots_spans(f->knots[d], f->degree[d], f->count[d]) : 1;
}

// Numbers of the last variable's Bezier coefficients for all the others'.
static double split_size(const kn_eval_function *f)
{
    int last = f->nvars - 1;
    double n = packed_width(f->ncomp);
    for (int d = 0; d < last; d++) n *= f->count[d];
    return n * spans_of(f, last) * (f->degree[last] + 1);
}

bool kn_eval_splits(const kn_eval_function *f)
{
    return f->knots[f->nvars - 1] && split_size(f) <= MOST_SPLIT;
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
    return (size_t)spans + (n < KN_EVAL_FEW ? KN_EVAL_FEW : n);
}

bool kn_eval_wants_plan(const kn_eval_function *f, size_t npoints)
{
    double coefs = f->ncomp, tables = 0.0, point = 0.0; // work, in multiply-adds
    for (int d = 0; d < f->nvars; d++) {
        double cube = pow(f->degree[d] + 1, 3);
        coefs *= f->count[d];
        if (f->knots[d]) tables += spans_of(f, d) * cube, point += cube;
    }
    if (kn_eval_splits(f)) coefs = split_size(f) * (f->degree[f->nvars - 1] + 1);
    return (double)npoints * (point + f->ncomp) > coefs + tables;
}

size_t kn_eval_lay_axis(kn_eval_axis *a, const kn_eval_function *f, int d, bool bezier, size_t stride, double *memory)
{
    store s = {memory, 0};
    int p = f->degree[d];
    size_t order = (size_t)p + 1;
    *a = (kn_eval_axis){.degree = p, .width = whole_vectors(p + 1), .spans = spans_of(f, d), .stride = stride};
    size_t spans = (size_t)a->spans, width = (size_t)a->width;
    a->buckets = buckets_of(a->spans);
    a->left = take(&s, search_room(a->spans));
    a->inverse = take(&s, search_room(a->spans));
    a->first = take(&s, spans); // a size_t is no larger than a number
    a->start = take(&s, (size_t)a->buckets);
    a->binomial = take(&s, order);
    a->low = take(&s, order);
    a->b = take(&s, order * KN_EVAL_BLOCK);
    a->g = take(&s, order * KN_EVAL_BLOCK);
    if (!bezier && f->knots[d]) {
        a->extract = take(&s, spans * order * width);
        a->basis = take(&s, KN_EVAL_BLOCK * width);
        a->slope = take(&s, KN_EVAL_BLOCK * width);
    }
    return s.used;
}

// Row r of the extraction matrix of knot interval s.
static void extraction(double *row, const double *knots, int p, int s, int r)
{
    double args[KN_MAX_DEGREE + 1];
    for (int k = 0; k < p; k++) args[k] = k < p - r ? knots[s] : knots[s + 1];
    kn_knots_blossom(row, knots, p, s, args);
}

// Spans, then left ends that are NaN; extract from the blossoms of each span.
static void fill_spans(kn_eval_axis *a, const double *knots, int count)
{
    int p = a->degree;
    size_t room = search_room(a->spans), size = (size_t)(p + 1) * (size_t)a->width;
    for (size_t i = 0; i < room; i++) a->left[i] = a->inverse[i] = NAN;
    a->left[0] = 0.0, a->inverse[0] = 1.0, a->first[0] = 0, a->even = 0;
    if (!knots) return;
    if (a->extract) memset(a->extract, 0, (size_t)a->spans * size * sizeof *a->extract);
    for (int s = kn_knots_next_span(knots, p, count, -1), i = 0; s < count;
         s = kn_knots_next_span(knots, p, count, s), i++) {
        a->left[i] = knots[s];
        a->inverse[i] = 1.0 / (knots[s + 1] - knots[s]);
        a->first[i] = a->stride * (size_t)(a->extract ? s - p : i * (p + 1));
        for (int r = 0; r <= p && a->extract; r++)
            extraction(a->extract + (size_t)i * size + (size_t)r * (size_t)a->width, knots, p, s, r);
    }
}

// The bucket of t grows with t, so a point in bucket b lies right of every break in a lower bucket, and left of every
// break in a higher one.
static void fill_buckets(kn_eval_axis *a)
{
    int below = 0, upto = 0, range = 0;
    for (int b = 0; b < a->buckets; b++) {
        while (below + 1 < a->spans && kn_eval_bucket(a, a->left[below + 1]) < b) below++;
        while (upto + 1 < a->spans && kn_eval_bucket(a, a->left[upto + 1]) <= b) upto++;
        a->start[b] = below;
        if (upto - below > range) range = upto - below;
    }
    for (a->steps = 0; range > 0; range /= 2) a->steps++;
}

// Equal spans, and coefficients that are as regular.
static void find_step(kn_eval_axis *a)
{
    double step = a->spans > 1 ? a->left[1] - a->lo : a->end - a->lo;
    bool equal = a->spans == 1 || a->even > 0;
    for (int i = 0; i < a->spans; i++)
        if (a->lo + i * step != a->left[i] || a->inverse[i] != a->inverse[0]) equal = false;
    a->step = equal ? step : 0.0;
}

void kn_eval_fill_axis(kn_eval_axis *a, const kn_eval_function *f, int d)
{
    const double *knots = f->knots[d];
    a->lo = knots ? knots[0] : 0.0, a->end = knots ? knots[f->count[d]] : 1.0;
    a->scale = a->buckets / (a->end - a->lo);
    fill_spans(a, knots, f->count[d]);
    fill_buckets(a);
    a->even = a->spans > 1 && a->first[1] <= UINT32_MAX ? a->first[1] : 0;
    for (int i = 0; i < a->spans; i++)
        if (a->first[i] != (size_t)i * a->even) a->even = 0;
    find_step(a);
    kn_binomial_row(a->binomial, a->degree);
    if (a->degree > 0) kn_binomial_row(a->low, a->degree - 1);
}

static size_t lay_plan(kn_eval_plan *plan, const kn_eval_function *f, double *memory)
{
    *plan = (kn_eval_plan){.nvars = f->nvars, .ncomp = f->ncomp, .rational = f->rational};
    bool split = kn_eval_splits(f);
    size_t n = (size_t)(plan->width = packed_width(f->ncomp)), used = 0;
    for (int d = f->nvars - 1; d >= 0; d--) {
        bool bezier = split && d == f->nvars - 1;
        kn_eval_axis *a = &plan->axis[d];
        used += kn_eval_lay_axis(a, f, d, bezier, n, memory ? memory + used : NULL);
        n *= bezier ? (size_t)a->spans * (size_t)(a->degree + 1) : (size_t)f->count[d];
    }
    plan->packed = memory ? memory + used : NULL;
    return used + kn_eval_aligned(n) + 8; // the last vector may be half a pair
}

size_t kn_eval_room(const kn_eval_function *f)
{
    kn_eval_plan plan;
    return lay_plan(&plan, f, NULL);
}

// The lane of component c: a weight of narrow points is in the last one.
static size_t lane(const kn_eval_function *f, int c)
{
    return f->rational && f->ncomp <= KN_EVAL_VECTOR && c == f->ncomp - 1 ? KN_EVAL_VECTOR - 1 : (size_t)c;
}

// As they are.
static void pack(double *packed, const kn_eval_function *f, size_t n, size_t width)
{
    for (int c = 0; c < f->ncomp; c++)
        for (size_t i = 0; i < n; i++) packed[i * width + lane(f, c)] = f->coef[(size_t)c * n + i];
}

// The last variable in Bezier form, span after span.
static void pack_split(double *packed, const kn_eval_function *f, size_t n, size_t width)
{
    int last = f->nvars - 1, p = f->degree[last], count = f->count[last];
    const double *knots = f->knots[last];
    size_t order = (size_t)p + 1, lines = n / (size_t)count, row = (size_t)spans_of(f, last) * order * width;
    for (int s = kn_knots_next_span(knots, p, count, -1); s < count; s = kn_knots_next_span(knots, p, count, s))
        for (int r = 0; r <= p; r++, packed += width) {
            double e[KN_MAX_DEGREE + 1];
            extraction(e, knots, p, s, r);
            for (int c = 0; c < f->ncomp; c++)
                for (size_t i = 0; i < lines; i++) {
                    const double *from = f->coef + (size_t)c * n + i * (size_t)count + (size_t)(s - p);
                    double sum = e[0] * from[0];
                    for (int k = 1; k <= p; k++) sum += e[k] * from[k];
                    packed[i * row + lane(f, c)] = sum;
                }
        }
}

void kn_eval_prepare(kn_eval_plan *plan, const kn_eval_function *f, double *memory)
{
    size_t n = 1, width, room = lay_plan(plan, f, memory);
    for (int d = 0; d < f->nvars; d++) {
        kn_eval_fill_axis(&plan->axis[d], f, d);
        n *= (size_t)f->count[d];
    }
    width = (size_t)plan->width;
    for (double *x = plan->packed; x < memory + room; x++) *x = 0.0; // lanes and vectors that belong to no component
    if (kn_eval_splits(f))
        pack_split(plan->packed, f, n, width);
    else
        pack(plan->packed, f, n, width);
}
