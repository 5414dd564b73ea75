// SPDX-License-Identifier: Apache-2.0
// Bytes become numbers, shapes, pieces and splines: small and sensible mostly, absurd now and then. Arrays that a call
// reads or writes are blocks of exactly their size, so that the sanitizer sees one number too many.
#ifndef TESTS_FUZZ_FEED_H
#define TESTS_FUZZ_FEED_H

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <knurl/spline.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { FEED_BLOCKS = 256 };

typedef struct feed {
    const uint8_t *at;
    size_t left;
    kn_ctx *ctx;
    size_t *live;             // blocks that knurl holds
    void *block[FEED_BLOCKS]; // freed by feed_drop
    int nblocks;
} feed;

static inline void *feed_allocate(void *user, size_t bytes)
{
    void *block = malloc(bytes);
    *(size_t *)user += block != NULL;
    return block;
}

static inline void *feed_resize(void *user, void *block, size_t bytes)
{
    (void)user;
    return realloc(block, bytes);
}

static inline void feed_release(void *user, void *block)
{
    *(size_t *)user -= block != NULL;
    free(block);
}

// A one-threaded context that counts.
static inline feed feed_begin(const uint8_t *data, size_t size)
{
    feed f = {.at = data, .left = size, .live = calloc(1, sizeof(size_t))};
    if (!f.live) abort();
    kn_ctx_options options = {.allocator = {feed_allocate, feed_resize, feed_release, f.live}, .threads = 1};
    if (kn_ctx_create(&f.ctx, &options) != KN_OK) abort();
    return f;
}

// Frees the arrays handed out so far.
static inline void feed_drop(feed *f)
{
    while (f->nblocks > 0) free(f->block[--f->nblocks]);
}

// Asserts that nothing is left once the results are cleared and the context is gone.
static inline void feed_end(feed *f)
{
    feed_drop(f);
    kn_ctx_destroy(f->ctx);
    if (*f->live != 0) abort();
    free(f->live);
}

// Any answer will do.
static inline void feed_any(kn_status status)
{
    (void)status;
}

static inline int feed_byte(feed *f)
{
    if (f->left == 0) return 0;
    f->left--;
    return *f->at++;
}

// lo .. hi.
static inline int feed_int(feed *f, int lo, int hi)
{
    return lo + feed_byte(f) % (hi - lo + 1);
}

// lo .. hi, one time in 32 a number that no shape has.
static inline int feed_wild(feed *f, int lo, int hi)
{
    static const int absurd[] = {-1, INT_MIN, INT_MAX, 57, 65, 9, 100000, 1 << 28, -2};
    int b = feed_byte(f);
    return b >= 248 ? absurd[feed_byte(f) % 9] : lo + b % (hi - lo + 1);
}

// lo .. hi, one time in 32 a number too small for any array.
static inline int feed_count(feed *f, int lo, int hi)
{
    static const int absurd[] = {-1, INT_MIN, 0, -3};
    int b = feed_byte(f);
    return b >= 248 ? absurd[b % 4] : lo + b % (hi - lo + 1);
}

// Multiples of 1/16 mostly; one time in 16 something else.
static inline double feed_number(feed *f)
{
    static const double odd[] = {0.0, -0.0, INFINITY, -INFINITY, NAN, 1e308, -1e300, 1e-310, 1e-200, 0.1, 1e17, 1.0};
    int b = feed_byte(f);
    return b >= 240 ? odd[feed_byte(f) % 12] : (b - 120) / 16.0;
}

static inline double feed_finite(feed *f)
{
    double x = feed_number(f);
    return isfinite(x) ? x : 0.5;
}

static inline void *feed_block(feed *f, size_t bytes)
{
    if (f->nblocks == FEED_BLOCKS) abort();
    void *block = calloc(bytes ? bytes : 1, 1);
    if (!block) abort();
    f->block[f->nblocks++] = block;
    return block;
}

static inline double *feed_numbers(feed *f, size_t n)
{
    double *x = feed_block(f, n * sizeof *x);
    for (size_t i = 0; i < n; i++) x[i] = feed_number(f);
    return x;
}

static inline double *feed_room(feed *f, size_t n)
{
    return feed_block(f, n * sizeof(double));
}

// How many points: few mostly, one time in 16 more than the widest vectors and smallest tables need.
static inline size_t feed_points(feed *f)
{
    int b = feed_byte(f);
    return b >= 240 ? 64 + 3 * (size_t)feed_byte(f) : (size_t)b % 21;
}

// The same numbers bit for bit, NaN being one number.
static inline bool feed_same(const double *a, const double *b, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (memcmp(&a[i], &b[i], sizeof *a) != 0 && !(isnan(a[i]) && isnan(b[i]))) return false;
    return true;
}

// Parameters in [0,1] mostly.
static inline double *feed_parameters(feed *f, size_t n)
{
    double *x = feed_block(f, n * sizeof *x);
    for (size_t i = 0; i < n; i++) {
        int b = feed_byte(f);
        x[i] = b < 224 ? b / 223.0 : feed_number(f);
    }
    return x;
}

// Highest degrees by the number of variables, so that pieces stay small.
static inline int feed_degree(feed *f, int nvars)
{
    static const int most[] = {0, 9, 4, 2, 1};
    int b = feed_byte(f);
    return nvars == 1 && b == 255 ? KN_MAX_DEGREE : b % (most[nvars < 4 ? nvars : 4] + 1);
}

static inline void feed_coefficients(feed *f, double *coef, size_t count, int ncomp, bool rational)
{
    size_t n = count * (size_t)(ncomp - rational);
    bool tame = feed_byte(f) % 2; // finite, positive weights
    for (size_t i = 0; i < n; i++) coef[i] = tame ? feed_finite(f) : feed_number(f);
    for (size_t i = n; rational && i < n + count; i++) coef[i] = tame ? 0.25 + feed_byte(f) / 64.0 : feed_number(f);
}

// *out is overwritten; empty where the shape was absurd.
static inline void feed_bezier(feed *f, kn_bezier *out, int nvars)
{
    *out = (kn_bezier){0};
    int degree[KN_MAX_VARS + 1] = {0}, ncomp = feed_wild(f, 1, 4);
    bool rational = feed_byte(f) % 3 == 0;
    if (feed_byte(f) >= 250) nvars = feed_wild(f, 0, 4);
    for (int d = 0; d < nvars && d < KN_MAX_VARS; d++)
        degree[d] = feed_byte(f) >= 252 ? feed_wild(f, 0, 2) : feed_degree(f, nvars);
    if (nvars > 3 && ncomp > 4) return; // nothing large
    if (kn_bezier_init(f->ctx, out, nvars, ncomp, rational, degree) != KN_OK) return;
    if (kn_bezier_count(out) * (size_t)ncomp > 4096)
        kn_bezier_clear(f->ctx, out);
    else
        feed_coefficients(f, out->coef, kn_bezier_count(out), ncomp, rational);
}

// A shape that nothing may accept, over the same coefficients.
static inline kn_bezier feed_broken(feed *f, const kn_bezier *a)
{
    kn_bezier b = *a;
    switch (feed_byte(f) % 5) {
    case 0: b.nvars = feed_byte(f) % 2 ? -1 : KN_MAX_VARS + 1; break;
    case 1: b.ncomp = feed_byte(f) % 2 ? 0 : KN_MAX_COMPS + 1; break;
    case 2: b.coef = NULL; break;
    case 3: b.nvars = b.nvars < 1 ? 1 : b.nvars, b.degree[0] = KN_MAX_DEGREE + 1; break;
    default: b.nvars = b.nvars < 1 ? 1 : b.nvars, b.degree[b.nvars - 1] = -1; break;
    }
    return b;
}

// n + p + 1 knots of a clamped vector over [lo,hi]; one time in 16 something broken.
static inline double *feed_knots(feed *f, int degree, int count, double lo, double hi)
{
    size_t n = (size_t)count + (size_t)degree + 1;
    double *knots = feed_block(f, n * sizeof *knots), at = lo;
    int interior = count - degree - 1, grid = interior + 2;
    for (size_t i = 0; i < n; i++) {
        if (i > (size_t)degree && i < (size_t)count && feed_byte(f) % 3) at += (hi - lo) / grid;
        knots[i] = i <= (size_t)degree ? lo : i < (size_t)count ? at : hi;
    }
    if (feed_byte(f) >= 240) knots[(size_t)feed_byte(f) % n] = feed_number(f);
    return knots;
}

// Domains are [0,1] or one time in four [-1,2], in each variable.
static inline void feed_spline(feed *f, kn_spline *out, int nvars)
{
    *out = (kn_spline){0};
    int degree[KN_MAX_VARS + 1] = {0}, count[KN_MAX_VARS + 1] = {0}, ncomp = feed_wild(f, 1, 4);
    const double *knots[KN_MAX_VARS + 1] = {NULL};
    bool rational = feed_byte(f) % 3 == 0;
    size_t total = 1;
    if (ncomp < 1 || ncomp > 4) {
        kn_status status = kn_spline_init(f->ctx, out, nvars, ncomp, rational, degree, count, knots, NULL);
        if (status == KN_OK) kn_spline_clear(f->ctx, out);
        return;
    }
    for (int d = 0; d < nvars; d++) {
        double wide = feed_byte(f) % 4 == 0 ? 1.0 : 0.0;
        degree[d] = feed_degree(f, nvars);
        count[d] = degree[d] + 1 + feed_byte(f) % (nvars > 1 ? 3 : 8);
        knots[d] = feed_knots(f, degree[d], count[d], -wide, 1.0 + wide);
        total *= (size_t)count[d];
    }
    if (total * (size_t)ncomp > 2048) return;
    double *coef = feed_block(f, total * (size_t)ncomp * sizeof *coef);
    if (ncomp > rational) feed_coefficients(f, coef, total, ncomp, rational);
    if (kn_spline_init(f->ctx, out, nvars, ncomp, rational, degree, count, knots, coef) != KN_OK) return;
    if (kn_spline_check(f->ctx, out) != KN_OK) kn_spline_clear(f->ctx, out); // operands are splines that it accepts
}

#endif
