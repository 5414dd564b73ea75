// SPDX-License-Identifier: Apache-2.0
// Batched evaluation: every level of vectors gives the plain version's bits, and those are right.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kernel/eval.h"
#include "tests/support/support.h"

typedef struct case_ {
    kn_spline s;
    const double *knots[KN_MAX_VARS];
    kn_eval_function f;
} case_;

static void make(kn_ctx *ctx, case_ *c, test_rng *rng, int nvars, int ncomp, bool rational, const int *degree,
                 const int *count)
{
    test_random_spline(ctx, &c->s, rng, nvars, ncomp, rational, degree, count, 9);
    for (size_t i = 0; i < kn_spline_count(&c->s) * (size_t)ncomp; i++) c->s.coef[i] += test_uniform(rng, 0.0, 0.5);
    for (int d = 0; d < nvars; d++) c->knots[d] = c->s.knots[d];
    c->f = (kn_eval_function){nvars, ncomp, rational, c->s.degree, c->s.count, c->knots, c->s.coef};
}

// Inside, at knots, at both ends, beyond, and what is no number.
static double parameter(test_rng *rng, const double *knots, int count, int degree)
{
    double lo = knots ? knots[0] : 0.0, hi = knots ? knots[count] : 1.0;
    switch (test_int(rng, 0, 9)) {
    case 0: return knots ? knots[test_int(rng, 0, count + degree)] : 1.0;
    case 1: return test_uniform(rng, lo - 1.0, hi + 1.0);
    case 2: return test_int(rng, 0, 20) ? hi : NAN;
    case 3: return test_int(rng, 0, 20) ? lo : INFINITY;
    default: return test_uniform(rng, lo, hi);
    }
}

// A NaN's sign and payload are nobody's business.
static void assert_same_bits(const double *a, const double *b, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (!(isnan(a[i]) && isnan(b[i]))) assert_memory_equal(&a[i], &b[i], sizeof *a);
}

static double *numbers(size_t n)
{
    double *x = aligned_alloc(64, (n * sizeof *x + 63) / 64 * 64 + 64);
    assert_non_null(x);
    return x;
}

// Values alone and with partials.
static void check_levels(const kn_eval_function *f, test_rng *rng, size_t npoints)
{
    size_t nvars = (size_t)f->nvars, dim = (size_t)(f->ncomp - f->rational);
    double *memory = numbers(kn_eval_room(f)), *at = numbers(npoints * nvars);
    for (size_t i = 0; i < npoints * nvars; i++)
        at[i] = parameter(rng, f->knots[i % nvars], f->count[i % nvars], f->degree[i % nvars]);
    kn_eval_plan plan;
    kn_eval_prepare(&plan, f, memory);
    for (int partials = 0; partials < 2; partials++) {
        size_t n = npoints * dim * (partials ? 1 + nvars : 1);
        double *a = numbers(n + 1), *b = numbers(n + 1);
        kn_eval_plain(a, f, npoints, at, partials);
        for (kn_eval_level level = KN_EVAL_SSE2; level <= kn_eval_best(); level++) {
            b[n] = 12345.0;
            kn_eval_planned(b, &plan, npoints, at, partials, level);
            assert_same_bits(a, b, n);
            assert_true(b[n] == 12345.0); // nothing behind the last value
        }
        free(a), free(b);
    }
    free(memory), free(at);
}

// The same on a grid of two variables or more.
static void check_grid(const kn_eval_function *f, test_rng *rng, const size_t *n)
{
    double *at[KN_MAX_VARS];
    size_t all = (size_t)(f->ncomp - f->rational);
    for (int d = 0; d < f->nvars; d++) {
        at[d] = numbers(n[d]), all *= n[d];
        for (size_t i = 0; i < n[d]; i++) at[d][i] = parameter(rng, f->knots[d], f->count[d], f->degree[d]);
    }
    double *memory = numbers(kn_eval_grid_room(f, n)), *a = numbers(all + 1), *b = numbers(all + 1);
    kn_eval_grid_plain(a, f, n, (const double *const *)at);
    for (kn_eval_level level = KN_EVAL_SSE2; level <= kn_eval_best(); level++) {
        b[all] = 12345.0;
        kn_eval_grid_planned(b, f, n, (const double *const *)at, memory, level);
        assert_same_bits(a, b, all);
        assert_true(b[all] == 12345.0);
    }
    for (int d = 0; d < f->nvars; d++) free(at[d]);
    free(memory), free(a), free(b);
}

static void levels_agree(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = test_scale(60); round > 0; round--) {
        int nvars = test_int(&rng, 1, 4), degree[4], count[4];
        bool rational = test_int(&rng, 0, 1);
        for (int d = 0; d < nvars; d++) {
            degree[d] = nvars < 4 && round % 3 == 0 ? 3 : test_int(&rng, 0, nvars > 3 ? 2 : nvars > 2 ? 3 : 9);
            count[d] = degree[d] + 1 + test_int(&rng, 0, nvars > 2 ? 4 : 20);
        }
        case_ c;
        make(ctx, &c, &rng, nvars, test_int(&rng, 1 + rational, 10), rational, degree, count);
        check_levels(&c.f, &rng, (size_t)test_int(&rng, 1, nvars > 2 ? 70 : 150));
        size_t n[4];
        for (int d = 0; d < nvars; d++) n[d] = (size_t)test_int(&rng, 1, nvars > 2 ? 4 : 30);
        if (nvars > 1) check_grid(&c.f, &rng, n);
        kn_spline_clear(ctx, &c.s);
    }
    test_ctx_end(ctx, &memory);
}

static void levels_agree_on_bezier(void **state)
{
    (void)state;
    test_rng rng = test_random(2);
    const double *none[3] = {NULL};
    for (int round = test_scale(20); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3), degree[3], count[3], ncomp = test_int(&rng, 1, 5), n = ncomp;
        for (int d = 0; d < nvars; d++) {
            degree[d] = round % 3 == 0 ? 3 : test_int(&rng, 0, nvars > 2 ? 4 : 12);
            n *= count[d] = degree[d] + 1;
        }
        double *coef = malloc((size_t)n * sizeof *coef);
        assert_non_null(coef);
        for (int i = 0; i < n; i++) coef[i] = test_uniform(&rng, -1, 1);
        kn_eval_function f = {nvars, ncomp, false, degree, count, none, coef};
        check_levels(&f, &rng, 70);
        if (nvars > 1) check_grid(&f, &rng, (size_t[]){3, nvars > 2 ? 4 : 300, 5}); // 300: in two blocks
        free(coef);
    }
}

// Whole vectors are stored: batches that end anywhere in a block, and results of any width, have nothing behind them.
static void no_room(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    for (int nvars = 1; nvars <= 2; nvars++)
        for (int ncomp = 1; ncomp <= 4; ncomp++) {
            case_ c;
            make(ctx, &c, &rng, nvars, ncomp, false, (int[]){3, 3}, (int[]){6, 5});
            for (size_t n = 1; n < 6; n++) check_levels(&c.f, &rng, n);
            for (size_t n = 62; n < 70; n++) check_levels(&c.f, &rng, n);
            for (size_t n = 127; n < 132; n++) check_levels(&c.f, &rng, n);
            kn_spline_clear(ctx, &c.s);
        }
    test_ctx_end(ctx, &memory);
}

// Knots whose spacing grows by powers of ten, and two clusters: the search in one bucket has to take many steps.
static void uneven_knots(void **state)
{
    (void)state;
    test_rng rng = test_random(3);
    double k[206], coef[204];
    for (int kind = 0; kind < 3; kind++) {
        int n = 204;
        for (int i = 0; i < 206; i++) {
            double x = i < 2 ? 0 : i > 203 ? 203 : i - 1;
            k[i] = kind == 0 ? x : kind == 1 ? pow(1.2, x) - 1 : x < 100 ? x * 1e-9 : x - 99;
        }
        k[0] = k[1], k[205] = k[204];
        for (int i = 0; i < n; i++) coef[i] = test_uniform(&rng, -1, 1);
        const double *knots[1] = {k};
        int degree = 1;
        kn_eval_function f = {1, 1, false, &degree, &n, knots, coef};
        check_levels(&f, &rng, 500);
        double *memory = aligned_alloc(64, (kn_eval_room(&f) * sizeof *memory + 63) / 64 * 64), value;
        assert_non_null(memory);
        kn_eval_plan plan;
        kn_eval_prepare(&plan, &f, memory);
        for (int i = 1; i < 205; i++) { // interpolation at the knots, and just below them
            kn_eval_planned(&value, &plan, 1, &k[i], false, kn_eval_best());
            assert_true(value == coef[i - 1]);
            double below = nextafter(k[i], -INFINITY), exact;
            kn_eval_planned(&value, &plan, 1, &below, false, kn_eval_best());
            kn_eval_plain(&exact, &f, 1, &below, false);
            assert_true(value == exact);
        }
        free(memory);
    }
}

// The plain version against kn_spline_eval, which goes another way (Cox and de Boor at the point itself) and is
// tested against long double.
static void plain_is_right(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    for (int round = test_scale(40); round > 0; round--) {
        int nvars = test_int(&rng, 1, 4), degree[4], count[4], work = 0;
        for (int d = 0; d < nvars; d++) {
            degree[d] = test_int(&rng, 0, nvars > 2 ? 3 : 6);
            count[d] = degree[d] + 1 + test_int(&rng, 0, 5);
            work += 17 * degree[d] + 3 + 6 * degree[d] + 1;
        }
        case_ c;
        make(ctx, &c, &rng, nvars, 2, false, degree, count);
        for (int i = 0; i < 10; i++) {
            double at[4], a[2], b[2];
            for (int d = 0; d < nvars; d++) at[d] = test_uniform(&rng, c.knots[d][0], c.knots[d][count[d]]);
            kn_eval_plain(a, &c.f, 1, at, false);
            assert_int_equal(kn_spline_eval(ctx, b, &c.s, at), KN_OK);
            // gamma(17 p + 3) max|c| and gamma(6 p + 1) max|c| a variable; coefficients are below 10
            for (int k = 0; k < 2; k++) assert_true(fabs(a[k] - b[k]) <= work * 0x1.01p-53 * 10);
        }
        kn_spline_clear(ctx, &c.s);
    }
    test_ctx_end(ctx, &memory);
}

// u^2 v with a knot: exact at dyadic points; both public calls; large and small batches, also cut in two.
static void exact_values(void **state)
{
    (void)state;
    enum { POINTS = 300 };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double ku[] = {0, 0, 0, 1, 2, 2, 2}, kv[] = {0, 0, 1, 1}, coef[] = {0, 0, 0, 0, 0, 2, 0, 4};
    const double *const knots[] = {ku, kv};
    static double at[2 * POINTS], out[POINTS], parts[POINTS];
    kn_spline s, empty = {0};
    assert_int_equal(kn_spline_init(ctx, &s, 2, 1, false, (int[]){2, 1}, (int[]){4, 2}, knots, coef), KN_OK);
    for (int i = 0; i < POINTS; i++) at[2 * i] = (i % 41 - 10) / 8.0, at[2 * i + 1] = (i % 13) / 4.0;
    assert_int_equal(kn_spline_eval_batch(ctx, out, &s, POINTS, at), KN_OK);
    for (int i = 0; i < POINTS; i++) assert_true(out[i] == at[2 * i] * at[2 * i] * at[2 * i + 1]);
    assert_int_equal(kn_spline_eval_batch(ctx, parts, &s, 2, at), KN_OK);
    assert_int_equal(kn_spline_eval_batch(ctx, parts + 2, &s, POINTS - 2, at + 4), KN_OK);
    assert_memory_equal(out, parts, sizeof out);
    assert_int_equal(kn_spline_eval_batch(ctx, NULL, &s, 0, NULL), KN_OK);
    assert_int_equal(kn_spline_eval_batch(ctx, out, &empty, 1, at), KN_EDOMAIN);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void levels_have_names(void **state)
{
    (void)state;
    for (kn_eval_level level = KN_EVAL_PLAIN; level < KN_EVAL_LEVELS; level++)
        assert_true(strlen(kn_eval_level_name(level)) > 2);
    assert_true(kn_eval_best() >= KN_EVAL_SSE2 && kn_eval_best() < KN_EVAL_LEVELS);
}

static kn_status batch(kn_ctx *ctx, void *user)
{
    (void)user;
    enum { POINTS = 200 };
    const double k[] = {0, 0, 1, 1}, coef[] = {1, 2};
    const double *const knots[] = {k};
    static double at[POINTS], out[POINTS];
    kn_spline s = {0};
    out[0] = out[POINTS - 1] = 7;
    kn_status status = kn_spline_init(ctx, &s, 1, 1, false, (int[]){1}, (int[]){2}, knots, coef);
    if (status == KN_OK) status = kn_spline_eval_batch(ctx, out, &s, POINTS, at);
    assert_true(out[0] == (status == KN_OK ? 1 : 7) && out[POINTS - 1] == out[0]);
    kn_spline_clear(ctx, &s);
    return status;
}

static void memory_failures(void **state)
{
    (void)state;
    test_allocation_failures(batch, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(levels_agree), cmocka_unit_test(levels_agree_on_bezier),
        cmocka_unit_test(uneven_knots), cmocka_unit_test(plain_is_right),
        cmocka_unit_test(exact_values), cmocka_unit_test(levels_have_names),
        cmocka_unit_test(no_room),      cmocka_unit_test(memory_failures),
    };
    return cmocka_run_group_tests_name("kernel/eval", tests, NULL, NULL);
}
