// SPDX-License-Identifier: Apache-2.0
// Knots for sites, sites for knots, parameters for points.
#include <math.h>
#include <string.h>

#include "tests/fit/check.h"

static void greville(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double sites[8];
    const double knots[] = {0, 0, 0, 1, 2, 4, 4, 4}, expected[] = {0, 0.5, 1.5, 3, 4};
    assert_int_equal(kn_fit_greville(ctx, sites, knots, 2, 5), KN_OK);
    for (int i = 0; i < 5; i++) assert_true(sites[i] == expected[i]);
    const double flat[] = {0, 1, 4};
    assert_int_equal(kn_fit_greville(ctx, sites, flat, 0, 2), KN_OK);
    assert_true(sites[0] == 0.5 && sites[1] == 2.5);
    // Equal knots give themselves, though 0.1 + 0.1 + 0.1 is not 3 * 0.1 / 3 in every order.
    const double tenths[] = {0.1, 0.1, 0.1, 0.1, 0.3, 0.3, 0.3, 0.7, 0.7, 0.7, 0.7};
    assert_int_equal(kn_fit_greville(ctx, sites, tenths, 3, 7), KN_OK);
    assert_true(sites[0] == 0.1 && sites[3] == 0.3 && sites[6] == 0.7);
    // The identity has the Greville sites as coefficients.
    test_rng rng = test_random(1);
    for (int round = test_scale(20); round > 0; round--) {
        int degree = test_int(&rng, 1, 6), count = degree + 1 + test_int(&rng, 0, 8);
        kn_spline s;
        double value, size;
        test_random_spline(ctx, &s, &rng, 1, 1, false, &degree, &count, 1);
        assert_int_equal(kn_fit_greville(ctx, s.coef, s.knots[0], degree, count), KN_OK);
        for (int i = 0; i < 20; i++) {
            double at = test_uniform(&rng, 0, s.knots[0][count]);
            assert_int_equal(kn_spline_eval(ctx, &value, &s, &at), KN_OK);
            size = check_size(ctx, &s, &at);
            assert_true(fabs(value - at) <= check_gamma(check_eval_operations(&s) + degree + 3) * size);
        }
        kn_spline_clear(ctx, &s);
    }
    assert_int_equal(kn_fit_greville(ctx, sites, knots, 2, 2), KN_EDOMAIN);
    assert_int_equal(kn_fit_greville(ctx, sites, knots + 1, 2, 4), KN_EDOMAIN);
    assert_int_equal(kn_fit_greville(ctx, sites, knots, KN_MAX_DEGREE + 1, 99), KN_ELIMIT);
    test_ctx_end(ctx, &memory);
}

static void uniform_knots(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double knots[10];
    const double expected[] = {-2, -2, -2, 0, 2, 4, 6, 6, 6};
    assert_int_equal(kn_fit_uniform_knots(ctx, knots, 2, 6, -2, 6), KN_OK);
    assert_memory_equal(knots, expected, sizeof expected);
    knots[0] = 77;
    assert_int_equal(kn_fit_uniform_knots(ctx, knots, 2, 6, 1, 1), KN_EDOMAIN);
    assert_int_equal(kn_fit_uniform_knots(ctx, knots, 2, 6, 0, INFINITY), KN_EDOMAIN);
    assert_int_equal(kn_fit_uniform_knots(ctx, knots, 2, 6, 1, 1 + 0x1p-52), KN_EDOMAIN);
    assert_int_equal(kn_fit_uniform_knots(ctx, knots, 2, 2, 0, 1), KN_EDOMAIN);
    assert_int_equal(kn_fit_uniform_knots(ctx, knots, KN_MAX_DEGREE + 1, 99, 0, 1), KN_ELIMIT);
    assert_true(knots[0] == 77);
    test_ctx_end(ctx, &memory);
}

// Fits through sites on their averaged knots are defined: Schoenberg and Whitney, checked by the fits themselves.
static void averaged_knots(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double knots[64], sites[64], values[64];
    const double *k = knots, *x = sites;
    const double few[] = {0, 5, 9, 14, 15}, expected[] = {0, 0, 0, 0, 28.0 / 3, 15, 15, 15, 15};
    assert_int_equal(kn_fit_averaged_knots(ctx, knots, 3, 5, 5, few), KN_OK); // (5 + 9 + 14) / 3
    for (int i = 0; i < 9; i++) assert_true(fabs(knots[i] - expected[i]) <= 15 * 0x1p-52);
    const double many[] = {0, 1, 2, 3, 4, 5, 6, 7}, spread[] = {0, 0, 1 + 2.0 / 3, 4 + 1.0 / 3, 7, 7};
    assert_int_equal(kn_fit_averaged_knots(ctx, knots, 1, 4, 8, many), KN_OK); // steps of 8/3 sites: 2 2/3, 5 1/3
    for (int i = 0; i < 6; i++) assert_true(fabs(knots[i] - spread[i]) <= 7 * 0x1p-51);
    test_rng rng = test_random(2);
    kn_spline s = {0};
    for (int round = test_scale(60); round > 0; round--) {
        int degree = test_int(&rng, 0, 7), count = degree + 2 + test_int(&rng, 0, 20);
        int nsites = count + (round % 2 ? test_int(&rng, 1, 20) : 0);
        for (int i = 0; i < nsites; i++) {
            sites[i] = (i > 0 ? sites[i - 1] : 0.0) + exp(test_uniform(&rng, -6, 2));
            values[i] = test_int(&rng, -9, 9);
        }
        assert_int_equal(kn_fit_averaged_knots(ctx, knots, degree, count, nsites, sites), KN_OK);
        assert_true(knots[0] == sites[0] && knots[count] == sites[nsites - 1]);
        kn_status status = nsites == count ? kn_fit_interpolate(ctx, &s, 1, 1, &degree, &count, &k, &x, values)
                                           : kn_fit_least_squares(ctx, &s, NULL, 1, 1, &degree, &count, &k, &nsites,
                                                                  &x, values, NULL);
        assert_int_equal(status, KN_OK);
    }
    knots[0] = 77;
    sites[3] = sites[2];
    assert_int_equal(kn_fit_averaged_knots(ctx, knots, 3, 5, 5, sites), KN_EDOMAIN);
    assert_int_equal(kn_fit_averaged_knots(ctx, knots, 3, 5, 4, many), KN_EDOMAIN);
    assert_int_equal(kn_fit_averaged_knots(ctx, knots, 3, 3, 5, many), KN_EDOMAIN);
    assert_int_equal(kn_fit_averaged_knots(ctx, knots, KN_MAX_DEGREE + 1, 60, 64, many), KN_ELIMIT);
    sites[3] = INFINITY;
    assert_int_equal(kn_fit_averaged_knots(ctx, knots, 1, 3, 4, sites), KN_EDOMAIN);
    assert_true(knots[0] == 77);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void parameters(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double sites[8];
    // Chords 5, 20, 75 of 100; their roots; equal steps.
    const double points[] = {0, 0, 3, 4, 15, 20, 60, 80}, chord[] = {0, 0.05, 0.25, 1};
    assert_int_equal(kn_fit_parameters(ctx, sites, 1, 2, (int[]){4}, points, 0, 1.0), KN_OK);
    for (int i = 0; i < 4; i++) assert_true(fabs(sites[i] - chord[i]) <= 0x1p-50);
    const double squares[] = {0, 1, 5, 14}; // chords 1, 4, 9
    assert_int_equal(kn_fit_parameters(ctx, sites, 1, 1, (int[]){4}, squares, 0, 0.5), KN_OK);
    assert_true(sites[0] == 0.0 && sites[3] == 1.0);
    assert_true(fabs(sites[1] - 1.0 / 6) <= 0x1p-50 && fabs(sites[2] - 0.5) <= 0x1p-50);
    assert_int_equal(kn_fit_parameters(ctx, sites, 1, 1, (int[]){4}, squares, 0, 0.0), KN_OK);
    for (int i = 0; i < 4; i++) assert_true(fabs(sites[i] - i / 3.0) <= 0x1p-50);
    // A grid of 3 x 2 points; along the first variable chords 1, 3 and 2, 2, hence means 3/8, 5/8.
    const double grid[] = {0, 10, 1, 12, 4, 14}, across[] = {0, 0.375, 1};
    assert_int_equal(kn_fit_parameters(ctx, sites, 2, 1, (int[]){3, 2}, grid, 0, 1.0), KN_OK);
    for (int i = 0; i < 3; i++) assert_true(sites[i] == across[i]);
    assert_int_equal(kn_fit_parameters(ctx, sites, 2, 1, (int[]){3, 2}, grid, 1, 1.0), KN_OK);
    assert_true(sites[0] == 0.0 && sites[1] == 1.0);
    // A pole: one line has no length, the other decides.
    const double pole[] = {5, 0, 5, 1, 5, 4};
    assert_int_equal(kn_fit_parameters(ctx, sites, 2, 1, (int[]){3, 2}, pole, 0, 1.0), KN_OK);
    assert_true(sites[1] == 0.25);
    sites[0] = 77;
    const double same[] = {1, 1, 1}, twice[] = {1, 2, 2, 3};
    assert_int_equal(kn_fit_parameters(ctx, sites, 1, 1, (int[]){3}, same, 0, 1.0), KN_EUNDEFINED);
    assert_int_equal(kn_fit_parameters(ctx, sites, 1, 1, (int[]){4}, twice, 0, 1.0), KN_EUNDEFINED);
    assert_int_equal(kn_fit_parameters(ctx, sites, 1, 1, (int[]){1}, same, 0, 1.0), KN_EDOMAIN);
    assert_int_equal(kn_fit_parameters(ctx, sites, 1, 1, (int[]){3}, same, 1, 1.0), KN_EDOMAIN);
    assert_int_equal(kn_fit_parameters(ctx, sites, 1, 1, (int[]){3}, same, 0, -1.0), KN_EDOMAIN);
    assert_int_equal(kn_fit_parameters(ctx, sites, 0, 1, (int[]){3}, same, 0, 1.0), KN_EDOMAIN);
    assert_int_equal(kn_fit_parameters(ctx, sites, 1, 0, (int[]){3}, same, 0, 1.0), KN_EDOMAIN);
    assert_true(sites[0] == 77);
    test_ctx_end(ctx, &memory);
}

static kn_status knots_once(kn_ctx *ctx, void *user)
{
    const double sites[] = {0, 1, 3, 4};
    double *knots = user;
    knots[0] = 77;
    kn_status status = kn_fit_averaged_knots(ctx, knots, 2, 4, 4, sites);
    if (status != KN_OK) assert_true(knots[0] == 77);
    return status;
}

static kn_status parameters_once(kn_ctx *ctx, void *user)
{
    const double points[] = {0, 1, 3, 4};
    double *sites = user;
    sites[0] = 77;
    kn_status status = kn_fit_parameters(ctx, sites, 1, 1, (int[]){4}, points, 0, 1.0);
    if (status != KN_OK) assert_true(sites[0] == 77);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    double numbers[8];
    test_allocation_failures(knots_once, numbers);
    test_allocation_failures(parameters_once, numbers);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(greville), cmocka_unit_test(uniform_knots),
                                       cmocka_unit_test(averaged_knots), cmocka_unit_test(parameters),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("fit/sites", tests, NULL, NULL);
}
