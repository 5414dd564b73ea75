// SPDX-License-Identifier: Apache-2.0
// Degree reduction of pieces: exact, near the best, with bounds that hold and are tight; least degrees.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kernel/knots.h"
#include "tests/support/support.h"

static void assert_equal(const kn_bezier *a, const kn_bezier *b)
{
    assert_int_equal(a->nvars, b->nvars);
    assert_int_equal(a->ncomp, b->ncomp);
    assert_true(a->rational == b->rational);
    for (int d = 0; d < a->nvars; d++) assert_int_equal(a->degree[d], b->degree[d]);
    for (size_t i = 0; i < kn_bezier_count(a) * (size_t)a->ncomp; i++) assert_true(a->coef[i] == b->coef[i]);
}

// Coefficients that are multiples of 840 for each variable: up to degree 8 elevation divides by divisors of that, so
// that all is exact; reduction finds the way back, says so, and the degree that was there is the least one.
static void elevation_is_undone(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = test_scale(60); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3), low[3], high[3], least[3];
        kn_bezier a, b = {0};
        double unit = 1, error = -1;
        for (int d = 0; d < nvars; d++) {
            high[d] = test_int(&rng, 0, nvars > 1 ? 5 : 8), low[d] = test_int(&rng, 0, high[d]);
            unit *= 840;
        }
        test_random_bezier(ctx, &a, &rng, nvars, 3, test_int(&rng, 0, 1), low, 99);
        for (size_t i = 0; i < 3 * kn_bezier_count(&a); i++) a.coef[i] *= unit;
        assert_int_equal(kn_bezier_elevate(ctx, &b, &a, high), KN_OK);
        assert_int_equal(kn_bezier_least_degree(ctx, least, &b, 0), KN_OK);
        for (int d = 0; d < nvars; d++) assert_true(least[d] <= low[d]);
        if (nvars == 1) { // the leading coefficient in powers: the m-th difference
            bool full = low[0] == 0;
            for (int c = 0; c < 3 && !full; c++) {
                double sum = 0, binomial = 1;
                for (int i = 0; i <= low[0]; binomial *= (double)(i - low[0]) / (i + 1), i++)
                    sum += binomial * a.coef[c * (low[0] + 1) + i];
                full = sum != 0;
            }
            if (full) assert_int_equal(least[0], low[0]);
        }
        assert_int_equal(kn_bezier_reduce(ctx, &b, &error, &b, low), KN_OK); // in place
        assert_true(error == 0);
        assert_equal(&a, &b);
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &b);
    }
    test_ctx_end(ctx, &memory);
}

// (1 - t)^2 to a line with the same ends: t - t^2 away, 1/4 at most, and no line with these ends is nearer.
static void by_hand(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_bezier a, b = {0};
    double error;
    int least;
    assert_int_equal(kn_bezier_init(ctx, &a, 1, 1, false, (int[]){2}), KN_OK);
    a.coef[0] = 1;
    assert_int_equal(kn_bezier_reduce(ctx, &b, &error, &a, (int[]){1}), KN_OK);
    assert_true(b.coef[0] == 1 && b.coef[1] == 0);
    assert_true(error >= 0.25 && error <= 0.25 * 1.26);
    assert_int_equal(kn_bezier_least_degree(ctx, &least, &a, 0), KN_OK);
    assert_int_equal(least, 2);
    assert_int_equal(kn_bezier_least_degree(ctx, &least, &a, 0.32), KN_OK);
    assert_int_equal(least, 1);
    assert_int_equal(kn_bezier_least_degree(ctx, &least, &a, 1), KN_OK);
    assert_int_equal(least, 0);                                                 // a constant within 1
    assert_int_equal(kn_bezier_reduce(ctx, &b, &error, &a, (int[]){2}), KN_OK); // nothing to do
    assert_true(error == 0);
    assert_equal(&a, &b);
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &b);
    test_ctx_end(ctx, &memory);
}

static double sampled(kn_ctx *ctx, const kn_bezier *a, const kn_bezier *b, test_rng *rng, int n)
{
    double most = 0;
    for (; n > 0; n--) {
        double at[3], x[4], y[4], sum = 0;
        for (int d = 0; d < a->nvars; d++) at[d] = test_uniform(rng, 0, 1);
        assert_int_equal(kn_bezier_eval(ctx, x, a, at), KN_OK);
        assert_int_equal(kn_bezier_eval(ctx, y, b, at), KN_OK);
        for (int c = 0; c < kn_bezier_dim(a); c++) sum += (x[c] - y[c]) * (x[c] - y[c]);
        most = fmax(most, sqrt(sum));
    }
    return most;
}

// Samples are in doubles: |p| gamma(2 E + 1) off, below 1e-12 of the scale here. Degrees high and low, scales huge and
// tiny, weights; corners stay bit for bit.
static void bounds_hold_and_are_tight(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    enum { ROUNDS = 60 };
    double slack[ROUNDS];
    int n = 0;
    for (int round = 0; round < ROUNDS; round++) {
        int nvars = test_int(&rng, 1, 3), high[3], low[3];
        const double scales[] = {1, 1e120, 1e-120};
        double scale = scales[round % 3], error = -1;
        bool rational = test_int(&rng, 0, 1), real = false;
        for (int d = 0; d < nvars; d++) {
            high[d] = nvars == 1 && round % 5 == 0 ? 40 : test_int(&rng, 1, nvars == 1 ? 12 : nvars == 2 ? 6 : 3);
            low[d] = test_int(&rng, high[d] > 20 ? 10 : 1, high[d]);
            real = real || low[d] < high[d];
        }
        kn_bezier a, b = {0};
        test_random_bezier(ctx, &a, &rng, nvars, 3 + rational, rational, high, 9);
        for (size_t i = 0; i < 3 * kn_bezier_count(&a); i++) a.coef[i] *= scale;
        assert_int_equal(kn_bezier_reduce(ctx, &b, &error, &a, low), KN_OK);
        assert_true(b.coef[0] == a.coef[0]);
        assert_true(b.coef[kn_bezier_count(&b) - 1] == a.coef[kn_bezier_count(&a) - 1]);
        bool bounded = isfinite(error); // a weight of the reduced piece may be negative
        assert_true(bounded || rational);
        if (bounded) {
            double off = sampled(ctx, &a, &b, &rng, 300);
            assert_true(off <= error + 1e-11 * scale);
            if (real && off > 0) slack[n++] = error / off;
        }
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &b);
    }
    qsort(slack, (size_t)n, sizeof *slack, kn_knots_by_value);
    printf("# %d bounds, bound / largest of 300 samples: median %.2f, worst %.1f\n", n, slack[n / 2], slack[n - 1]);
    assert_true(n > ROUNDS / 2 && slack[n / 2] <= 100);
    test_ctx_end(ctx, &memory);
}

// From degree n to n - 1 no polynomial comes nearer than the Chebyshev polynomial lets it: |n-th difference| 2^(1-2n).
static void near_the_best(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    for (int n = 2; n <= 12; n++) {
        kn_bezier a, b = {0};
        double error, difference = 0, binomial = 1;
        test_random_bezier(ctx, &a, &rng, 1, 1, false, &n, 1000);
        for (int i = 0; i <= n; binomial *= -(double)(n - i) / (i + 1), i++) difference += binomial * a.coef[i];
        assert_int_equal(kn_bezier_reduce(ctx, &b, &error, &a, (int[]){n - 1}), KN_OK);
        double best = fabs(difference) * ldexp(1, 1 - 2 * n);
        // the ends that are kept cost a factor cos(pi/2n)^-n <= 2, least squares instead of the maximum and the
        // bound's 1.25 some more
        assert_true(error <= 4 * best + 1e-9);
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &b);
    }
    test_ctx_end(ctx, &memory);
}

static void refusals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_bezier a, out = {0}, empty = {0};
    double error = 7;
    int degree = 9;
    assert_int_equal(kn_bezier_init(ctx, &a, 1, 2, true, (int[]){2}), KN_OK);
    assert_int_equal(kn_bezier_reduce(ctx, &out, &error, &a, (int[]){3}), KN_EDOMAIN);
    assert_int_equal(kn_bezier_reduce(ctx, &out, &error, &a, (int[]){-1}), KN_EDOMAIN);
    assert_int_equal(kn_bezier_reduce(ctx, &out, &error, &empty, (int[]){0}), KN_EDOMAIN);
    assert_int_equal(kn_bezier_least_degree(ctx, &degree, &a, -1), KN_EDOMAIN);
    assert_int_equal(kn_bezier_least_degree(ctx, &degree, &a, NAN), KN_EDOMAIN);
    assert_int_equal(kn_bezier_least_degree(ctx, &degree, &empty, 0), KN_EDOMAIN);
    assert_true(error == 7 && degree == 9 && !out.coef);
    a.coef[0] = 1, a.coef[3] = 1, a.coef[5] = 1; // a weight 0: no bound
    assert_int_equal(kn_bezier_reduce(ctx, &out, &error, &a, (int[]){1}), KN_OK);
    assert_true(isinf(error));
    assert_int_equal(kn_bezier_least_degree(ctx, &degree, &a, 1e300), KN_OK);
    assert_int_equal(degree, 2);
    a.coef[4] = 1, a.coef[1] = NAN; // nor one for what is no number
    assert_int_equal(kn_bezier_reduce(ctx, &out, &error, &a, (int[]){1}), KN_OK);
    assert_true(isinf(error));
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &out);
    // a constant of no variables has no degrees
    assert_int_equal(kn_bezier_init(ctx, &a, 0, 1, false, NULL), KN_OK);
    assert_int_equal(kn_bezier_reduce(ctx, &out, &error, &a, NULL), KN_OK);
    assert_true(error == 0);
    assert_int_equal(kn_bezier_least_degree(ctx, NULL, &a, 1), KN_OK);
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

// Degrees up to the limit, where least squares are at their worst: the bound still holds, and stays near the data.
static void highest_degree(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    for (int m = 55; m > 5; m -= 7) {
        kn_bezier a, b = {0};
        double error;
        test_random_bezier(ctx, &a, &rng, 1, 2, false, (int[]){KN_MAX_DEGREE}, 9);
        assert_int_equal(kn_bezier_reduce(ctx, &b, &error, &a, &m), KN_OK);
        // in all 56 degrees the function of random coefficients is smooth: 20 is beyond all values
        assert_true(sampled(ctx, &a, &b, &rng, 200) <= error + 1e-11 && error < 20);
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &b);
    }
    test_ctx_end(ctx, &memory);
}

static kn_status in_little_memory(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_bezier a, out = {0};
    double error = 7;
    int least[2] = {9, 9};
    kn_status status = kn_bezier_init(ctx, &a, 2, 3, true, (int[]){4, 3});
    if (status != KN_OK) return status;
    for (size_t i = 0; i < 60; i++) a.coef[i] = 1 + (double)(i * i % 7);
    for (int in_place = 0; in_place < 2 && status == KN_OK; in_place++) {
        kn_bezier *to = in_place ? &a : &out, before = *to;
        status = kn_bezier_reduce(ctx, to, &error, &a, (int[]){2, 2});
        if (status != KN_OK) assert_memory_equal(&before, to, sizeof before);
        if (status != KN_OK && !in_place) assert_true(error == 7);
    }
    if (status == KN_OK) {
        status = kn_bezier_least_degree(ctx, least, &out, 1);
        if (status != KN_OK) assert_true(least[0] == 9 && least[1] == 9);
    }
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &out);
    return status;
}

static void little_memory(void **state)
{
    (void)state;
    test_allocation_failures(in_little_memory, NULL);
}

// x^2 times the smallest number, whose half is rounded to 0: the distance from the line is not. A number that is none
// has a distance where something is left out, and none where nothing is.
static void ends_of_the_range(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_bezier a, low = {0};
    double error = -1;
    assert_int_equal(kn_bezier_init(ctx, &a, 1, 1, false, (int[]){2}), KN_OK);
    a.coef[2] = 0x1p-1074;
    assert_int_equal(kn_bezier_reduce(ctx, &low, &error, &a, (int[]){1}), KN_OK);
    assert_true(error > 0 && error < 0x1p-1050);
    a.coef[2] = NAN;
    assert_int_equal(kn_bezier_reduce(ctx, &low, &error, &a, (int[]){1}), KN_OK);
    assert_true(isinf(error));
    assert_int_equal(kn_bezier_reduce(ctx, &low, &error, &a, (int[]){2}), KN_OK);
    assert_true(error == 0);
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &low);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ends_of_the_range), cmocka_unit_test(elevation_is_undone),
        cmocka_unit_test(by_hand),           cmocka_unit_test(bounds_hold_and_are_tight),
        cmocka_unit_test(near_the_best),     cmocka_unit_test(refusals),
        cmocka_unit_test(highest_degree),    cmocka_unit_test(little_memory),
    };
    return cmocka_run_group_tests_name("bezier/reduce", tests, NULL, NULL);
}
