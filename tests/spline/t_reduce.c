// SPDX-License-Identifier: Apache-2.0
// Degree reduction of splines: exact, with the continuity kept, with bounds that hold and are tight; least degrees.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kernel/knots.h"
#include "tests/spline/oracle.h"
#include "tests/support/support.h"

// Knots 0 1 2 3 at multiplicity degree - 1 (1 for degrees below 2): all weights of elevation, Bezier pieces and joining
// are dyadic but for divisors 1 .. 8, and coefficients are multiples of 840^2 2^10 for each variable.
static void exact_spline(kn_ctx *ctx, kn_spline *s, test_rng *rng, int nvars, int ncomp, bool rational)
{
    double knots[2][64], coef[1024], unit = 1;
    const double *const k[] = {knots[0], knots[1]};
    int degree[2], count[2];
    for (int d = 0; d < nvars; d++) {
        int p = degree[d] = test_int(rng, 0, nvars > 1 ? 3 : 4), n = 0, times = p < 2 ? 1 : p - 1;
        for (int b = 0; b <= 3; b++)
            for (int i = b == 0 || b == 3 ? p + 1 : times; i > 0; i--) knots[d][n++] = b;
        count[d] = n - p - 1, unit *= 840 * 16;
    }
    for (int i = 0; i < 1024; i++) coef[i] = unit * test_int(rng, 1, 50);
    assert_int_equal(kn_spline_init(ctx, s, nvars, ncomp, rational, degree, count, k, coef), KN_OK);
}

static void assert_equal(const kn_spline *a, const kn_spline *b)
{
    assert_int_equal(a->ncomp, b->ncomp);
    for (int d = 0; d < a->nvars; d++) {
        assert_int_equal(a->degree[d], b->degree[d]);
        assert_int_equal(a->count[d], b->count[d]);
        for (int i = 0; i <= a->count[d] + a->degree[d]; i++) assert_true(a->knots[d][i] == b->knots[d][i]);
    }
    for (size_t i = 0; i < kn_spline_count(a) * (size_t)a->ncomp; i++) assert_true(a->coef[i] == b->coef[i]);
}

static void elevation_is_undone(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = test_scale(40); round > 0; round--) {
        int nvars = test_int(&rng, 1, 2), high[2], least[2];
        kn_spline a, b = {0};
        double error = -1;
        exact_spline(ctx, &a, &rng, nvars, 3, test_int(&rng, 0, 1));
        for (int d = 0; d < nvars; d++) high[d] = a.degree[d] + test_int(&rng, 0, 3);
        assert_int_equal(kn_spline_elevate(ctx, &b, &a, high), KN_OK);
        assert_int_equal(kn_spline_least_degree(ctx, least, &b, 0), KN_OK);
        for (int d = 0; d < nvars; d++) assert_int_equal(least[d], a.degree[d]);
        double scale = 50.0 * pow(840 * 16, nvars);
        assert_int_equal(kn_spline_least_degree(ctx, least, &b, 1e-9 * (a.rational ? 50 : scale)), KN_OK);
        for (int d = 0; d < nvars; d++) assert_int_equal(least[d], a.degree[d]);
        assert_int_equal(kn_spline_reduce(ctx, &b, &error, &b, a.degree), KN_OK); // in place
        assert_true(error >= 0 && error <= 1e-11 * (a.rational ? 50 : scale));    // rounding that did not happen
        assert_equal(&a, &b);
        kn_spline_clear(ctx, &a);
        kn_spline_clear(ctx, &b);
    }
    test_ctx_end(ctx, &memory);
}

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
        int nvars = test_int(&rng, 1, 2), degree[2], count[2], low[2];
        const double scales[] = {1, 1e120, 1e-120};
        double scale = scales[round % 3], error = -1;
        bool rational = test_int(&rng, 0, 1), real = false;
        for (int d = 0; d < nvars; d++) {
            degree[d] = test_int(&rng, 1, 6), count[d] = degree[d] + 1 + test_int(&rng, 0, nvars > 1 ? 4 : 12);
            low[d] = test_int(&rng, 0, degree[d]);
            real = real || low[d] < degree[d];
        }
        kn_spline a, b = {0};
        test_random_spline(ctx, &a, &rng, nvars, 2 + rational, rational, degree, count, 9);
        for (size_t i = 0; i < 2 * kn_spline_count(&a); i++) a.coef[i] *= scale;
        assert_int_equal(kn_spline_reduce(ctx, &b, &error, &a, low), KN_OK);
        for (int d = 0; d < nvars; d++) assert_int_equal(b.degree[d], low[d]);
        if (!rational) assert_int_equal(kn_spline_check(ctx, &b), KN_OK);
        assert_true(isfinite(error) || rational);
        double off = oracle_sampled_distance(&a, &b, &rng, 300);
        assert_true(off <= error);
        if (real && off > 0 && isfinite(error)) slack[n++] = error / off;
        kn_spline_clear(ctx, &a);
        kn_spline_clear(ctx, &b);
    }
    qsort(slack, (size_t)n, sizeof *slack, kn_knots_by_value);
    printf("# %d bounds, bound / largest of 300 samples: median %.2f, worst %.1f\n", n, slack[n / 2], slack[n - 1]);
    assert_true(n > ROUNDS / 2 && slack[n / 2] <= 100);
    test_ctx_end(ctx, &memory);
}

// A smooth cubic as a quadratic: C2 knots stay simple, so that it is C1; ends stay; finer knots bring it nearer with
// the third power of the spacing.
static void continuity_stays(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double errors[2];
    for (int fine = 0; fine < 2; fine++) {
        int spans = fine ? 40 : 20, n = 0, count = spans + 3, degree = 3;
        double knots[64], coef[64];
        for (int i = 0; i < spans + 7; i++) knots[n++] = 6.0 * (i < 4 ? 0 : i > spans + 3 ? spans : i - 3) / spans;
        for (int i = 0; i < count; i++) coef[i] = sin((knots[i + 1] + knots[i + 2] + knots[i + 3]) / 3);
        kn_spline s, t = {0};
        assert_int_equal(kn_spline_init(ctx, &s, 1, 1, false, &degree, &count, (const double *const[]){knots}, coef),
                         KN_OK);
        assert_int_equal(kn_spline_reduce(ctx, &t, &errors[fine], &s, (int[]){2}), KN_OK);
        assert_int_equal(t.count[0], spans + 2);
        assert_true(t.coef[0] == coef[0] && t.coef[spans + 1] == coef[count - 1]);
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &t);
    }
    printf("# cubic as quadratic: %.2g at 20 spans, %.2g at 40\n", errors[0], errors[1]);
    assert_true(errors[0] < 1e-3 && errors[1] < errors[0] / 5);
    test_ctx_end(ctx, &memory);
}

static void refusals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s, out = {0}, empty = {0};
    double error = 7;
    int degree = 9;
    const double k[] = {0, 0, 0, 1, 2, 2, 2};
    assert_int_equal(kn_spline_init(ctx, &s, 1, 2, true, (int[]){2}, (int[]){4}, (const double *const[]){k},
                                    (double[]){1, 2, 3, 5, 1, 0, 1, 1}),
                     KN_OK);
    assert_int_equal(kn_spline_reduce(ctx, &out, &error, &s, (int[]){3}), KN_EDOMAIN);
    assert_int_equal(kn_spline_reduce(ctx, &out, &error, &s, (int[]){-1}), KN_EDOMAIN);
    assert_int_equal(kn_spline_reduce(ctx, &out, &error, &empty, (int[]){0}), KN_EDOMAIN);
    assert_int_equal(kn_spline_least_degree(ctx, &degree, &s, -1), KN_EDOMAIN);
    assert_int_equal(kn_spline_least_degree(ctx, &degree, &s, NAN), KN_EDOMAIN);
    assert_int_equal(kn_spline_least_degree(ctx, &degree, &empty, 0), KN_EDOMAIN);
    assert_true(error == 7 && degree == 9 && out.nvars == 0);
    assert_int_equal(kn_spline_reduce(ctx, &out, &error, &s, (int[]){1}), KN_OK);
    assert_true(isinf(error)); // a weight 0: no bound
    assert_int_equal(kn_spline_reduce(ctx, &out, &error, &s, (int[]){2}), KN_OK);
    assert_true(error == 0); // nothing changed
    assert_equal(&out, &s);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

static kn_status in_little_memory(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_spline a = {0}, out = {0};
    double error = 7, coef[45];
    int least[2] = {9, 9};
    const double u[] = {0, 0, 0, 0, 1, 2, 2, 2, 2}, v[] = {0, 0, 0, 1, 1, 1};
    for (int i = 0; i < 45; i++) coef[i] = 1 + i * i % 7;
    kn_status status = kn_spline_init(ctx, &a, 2, 3, true, (int[]){3, 2}, (int[]){5, 3},
                                      (const double *const[]){u, v}, coef);
    for (int in_place = 0; in_place < 2 && status == KN_OK; in_place++) {
        kn_spline *to = in_place ? &a : &out, before = *to;
        status = kn_spline_reduce(ctx, to, &error, &a, (int[]){2, 1});
        if (status != KN_OK) assert_memory_equal(&before, to, sizeof before);
        if (status != KN_OK && !in_place) assert_true(error == 7);
    }
    if (status == KN_OK) {
        status = kn_spline_least_degree(ctx, least, &out, 1);
        if (status != KN_OK) assert_true(least[0] == 9 && least[1] == 9);
    }
    kn_spline_clear(ctx, &a);
    kn_spline_clear(ctx, &out);
    return status;
}

static void little_memory(void **state)
{
    (void)state;
    test_allocation_failures(in_little_memory, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elevation_is_undone), cmocka_unit_test(bounds_hold_and_are_tight),
        cmocka_unit_test(continuity_stays),    cmocka_unit_test(refusals),
        cmocka_unit_test(little_memory),
    };
    return cmocka_run_group_tests_name("spline/reduce", tests, NULL, NULL);
}
