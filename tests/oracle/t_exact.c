// SPDX-License-Identifier: Apache-2.0
// The oracle itself: small cases by hand, and identities that tie its functions to each other.
#include "tests/oracle/exact.h"

#include <flint/flint.h>

static void assert_numbers(const exact *a, const char *const *expected)
{
    fmpq_t x;
    fmpq_init(x);
    size_t n = exact_count(a);
    for (size_t i = 0; i < n; i++) {
        exact_get(x, a, i);
        char *text = fmpq_get_str(NULL, 10, x);
        assert_string_equal(text, expected[i]);
        flint_free(text);
    }
    fmpq_clear(x);
}

static void assert_equal(const exact *a, const exact *b)
{
    exact d = exact_new();
    exact_sub(&d, a, b);
    size_t n = exact_count(&d);
    for (size_t i = 0; i < n; i++) assert_true(fmpz_is_zero(d.num + i));
    exact_free(&d);
}

static void small_cases(void **state)
{
    (void)state;
    const int two = 2, three = 3;
    const double bernstein[] = {1, 3, 0.5}, power[] = {1, 4, -4.5};
    exact a = exact_new(), b = exact_new();
    exact_of_array(&a, 1, &two, bernstein, false);
    exact_power(&a); // 1 (1-t)^2 + 6 t (1-t) + t^2/2 = 1 + 4 t - 9/2 t^2
    exact_of_array(&b, 1, &two, power, false);
    assert_equal(&a, &b);
    exact_bernstein(&b, &a, &three);
    assert_numbers(&b, (const char *const[]){"1", "7/3", "13/6", "1/2"});
    exact_mul(&b, &a, &a);
    assert_numbers(&b, (const char *const[]){"1", "8", "7", "-36", "81/4"});
    exact_derivative(&b, &a, 0);
    assert_numbers(&b, (const char *const[]){"4", "-9"});
    exact_antiderivative(&b, &b, 0);
    assert_numbers(&b, (const char *const[]){"0", "4", "-9/2"});
    exact_substitute(&b, &a, 0, 0.5, -0.25); // 1 + 4 s - 9/2 s^2, s = 1/2 - 3/4 t
    assert_numbers(&b, (const char *const[]){"15/8", "3/8", "-81/32"});
    exact_compose(&b, &a, &a, NULL); // 1 + 4 a - 9/2 a^2
    assert_numbers(&b, (const char *const[]){"1/2", "-20", "-99/2", "162", "-729/8"});
    exact_free(&a), exact_free(&b);
}

// Values of products, of substitutions, of compositions at random points.
static void identities(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    exact a = exact_new(), b = exact_new(), c = exact_new(), inner[3] = {exact_new(), exact_new(), exact_new()};
    fmpq_t x, y, z;
    fmpq_init(x), fmpq_init(y), fmpq_init(z);
    for (int round = test_scale(6); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3), degree[3], raised[3];
        kn_bezier f, g;
        double at[3], lo = test_uniform(&rng, -1, 1), hi = test_uniform(&rng, -1, 1);
        for (int d = 0; d < 3; d++) at[d] = test_uniform(&rng, -1, 2), degree[d] = test_int(&rng, 0, 4);
        for (int d = 0; d < 3; d++) raised[d] = degree[d] + test_int(&rng, 0, 3);
        exact_random_bezier(ctx, &f, &rng, nvars, 1, false, degree, EXACT_UNIFORM);
        exact_random_bezier(ctx, &g, &rng, nvars, 1, false, raised, EXACT_SCALES);
        exact_of_bezier(&a, &f, 0, false);
        exact_of_bezier(&b, &g, 0, false);
        exact_value(x, &a, at);
        exact_value(y, &b, at);
        fmpq_mul(x, x, y);
        exact_mul(&c, &a, &b);
        exact_value(y, &c, at);
        assert_true(fmpq_equal(x, y));

        exact_bernstein(&c, &a, raised);
        exact_power(&c);
        assert_equal(&a, &c);

        exact_substitute(&c, &b, 0, lo, hi);
        exact matrix = exact_new();
        exact_restriction_matrix(&matrix, raised[0], lo, hi);
        exact_bernstein(&b, &b, raised);
        exact_map(&b, &b, 0, &matrix);
        exact_power(&b);
        assert_equal(&b, &c);
        exact_free(&matrix);

        for (int d = 0; d < nvars; d++) exact_copy(&inner[d], &a); // f(f, f, f) along the diagonal
        exact_compose(&c, &a, inner, NULL);
        for (int d = 0; d < 3; d++) at[d] = test_int(&rng, -2, 2) / 4.0;
        exact_value(x, &c, at);
        exact_value(y, &a, at);
        exact fixed = exact_new(), value = exact_new();
        exact_constant(&value, nvars, 1.0);
        exact_scale(&value, &value, y);
        for (int d = 0; d < nvars; d++) exact_copy(&inner[d], &value);
        exact_compose(&fixed, &a, inner, NULL);
        exact_get(z, &fixed, 0);
        assert_true(fmpq_equal(x, z));
        exact_free(&fixed), exact_free(&value);
        kn_bezier_clear(ctx, &f);
        kn_bezier_clear(ctx, &g);
    }
    fmpq_clear(x), fmpq_clear(y), fmpq_clear(z);
    exact_free(&a), exact_free(&b), exact_free(&c);
    for (int d = 0; d < 3; d++) exact_free(&inner[d]);
    test_ctx_end(ctx, &memory);
}

static void same_spline(exact *out, const double *at, void *user)
{
    exact_of_spline(out, user, 0, at, false);
}

// The coefficients of a spline's own pieces on its own knots are its coefficients.
static void spline_coefficients(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    exact a = exact_new(), b = exact_new();
    for (int round = test_scale(10); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3), degree[3], count[3], shape[3];
        for (int d = 0; d < 3; d++) degree[d] = test_int(&rng, 0, nvars > 2 ? 2 : 5);
        for (int d = 0; d < 3; d++) count[d] = degree[d] + 1 + test_int(&rng, 0, 3), shape[d] = count[d] - 1;
        kn_spline s;
        exact_random_spline(ctx, &s, &rng, nvars, 1, false, degree, count, EXACT_SCALES);
        exact_spline_coefs(&a, &s, same_spline, &s);
        exact_of_array(&b, nvars, shape, s.coef, false);
        assert_equal(&a, &b);
        kn_spline_clear(ctx, &s);
    }
    exact_free(&a), exact_free(&b);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(small_cases), cmocka_unit_test(identities),
                                       cmocka_unit_test(spline_coefficients)};
    int failed = cmocka_run_group_tests_name("oracle/exact", tests, NULL, NULL);
    flint_cleanup();
    return failed;
}
