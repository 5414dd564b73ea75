// SPDX-License-Identifier: Apache-2.0
// Values and derivatives at points against the definition.
#include "tests/bezier/reference.h"

#include <float.h>
#include <math.h>

// Quarters as parameters and integers as coefficients: all sums are exact, a quotient is rounded once on each side.
static void values_are_exact(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int n = test_scale(150); n > 0; n--) {
        int nvars = test_int(&rng, 0, 4), degree[4], ncomp = test_int(&rng, 2, 4);
        kn_bezier b;
        ref_random_degrees(&rng, degree, nvars);
        test_random_bezier(ctx, &b, &rng, nvars, ncomp, n % 2 == 0, degree, 9);
        double at[12], got[4], batch[12], expected[4];
        for (int i = 0; i < 3; i++) {
            ref_random_point(&rng, at + i * nvars, nvars);
            if (b.rational) // weights in [1, 9] have no zero in [0,1]
                for (int d = 0; d < nvars; d++) at[i * nvars + d] = test_int(&rng, 0, 4) / 4.0;
        }
        int dim = kn_bezier_dim(&b);
        assert_int_equal(kn_bezier_eval_batch(ctx, batch, &b, 3, at), KN_OK);
        for (int i = 0; i < 3; i++) {
            assert_int_equal(kn_bezier_eval(ctx, got, &b, at + i * nvars), KN_OK);
            ref_value(expected, &b, at + i * nvars);
            for (int c = 0; c < dim; c++) {
                assert_true(got[c] == expected[c]);
                assert_true(batch[i * dim + c] == expected[c]);
            }
        }
        kn_bezier_clear(ctx, &b);
    }
    test_ctx_end(ctx, &memory);
}

// Enough points for the tables of the batched evaluation, in more than one block.
static void many_values_are_exact(void **state)
{
    (void)state;
    enum { POINTS = 700 };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(6);
    for (int nvars = 1; nvars <= 4; nvars++)
        for (int rational = 0; rational < 2; rational++) {
            static double at[4 * POINTS], batch[3 * POINTS];
            double expected[3];
            int degree[4];
            kn_bezier b;
            ref_random_degrees(&rng, degree, nvars);
            test_random_bezier(ctx, &b, &rng, nvars, 3, rational, degree, 9);
            for (int i = 0; i < POINTS * nvars; i++)
                at[i] = test_int(&rng, rational ? 0 : -2, rational ? 4 : 6) / 4.0;
            assert_int_equal(kn_bezier_eval_batch(ctx, batch, &b, POINTS, at), KN_OK);
            int dim = kn_bezier_dim(&b);
            for (int i = 0; i < POINTS; i++) {
                ref_value(expected, &b, at + i * nvars);
                for (int c = 0; c < dim; c++) assert_true(batch[i * dim + c] == expected[c]);
            }
            kn_bezier_clear(ctx, &b);
        }
    test_ctx_end(ctx, &memory);
}

static double gamma_of(int n)
{
    return n * (DBL_EPSILON / 2) / (1 - n * (DBL_EPSILON / 2));
}

// |computed - exact| <= gamma(sum_d (4 n_d + 1)) sum |p_i| B_i, in [0,1]. The reference sums non-negative Bernstein
// polynomials in long double, whose own error is 2^-11 of that; the bound is doubled to cover it with ease.
static void values_keep_their_bound(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    for (int n = test_scale(40); n > 0; n--) {
        int nvars = n % 2 + 1, degree[2] = {test_int(&rng, 0, 56), test_int(&rng, 0, 12)}, index[2], steps = 0;
        double at[2], got = 0.0;
        kn_bezier b;
        test_random_bezier(ctx, &b, &rng, nvars, 1, false, degree, 1000000);
        long double exact = 0.0L, size = 0.0L;
        for (int d = 0; d < nvars; d++) {
            at[d] = test_uniform(&rng, 0.0, 1.0);
            steps += 4 * degree[d] + 1;
        }
        for (size_t i = 0; i < kn_bezier_count(&b); i++) {
            long double w = 1.0L;
            ref_split(index, i, nvars, degree);
            for (int d = 0; d < nvars; d++)
                w *= (long double)ref_binomial(degree[d], index[d]) * powl(at[d], index[d]) *
                     powl(1.0L - at[d], degree[d] - index[d]);
            exact += w * b.coef[i];
            size += w * fabsl(b.coef[i]);
        }
        assert_int_equal(kn_bezier_eval(ctx, &got, &b, at), KN_OK);
        assert_true(fabsl(got - exact) <= 2 * gamma_of(steps) * size);
        kn_bezier_clear(ctx, &b);
    }
    test_ctx_end(ctx, &memory);
}

// At corners the value is the corner coefficient, bit for bit, for any coefficients.
static void corners_interpolate(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    const int degree[2] = {7, 56};
    kn_bezier b;
    assert_int_equal(kn_bezier_init(ctx, &b, 2, 1, false, degree), KN_OK);
    for (size_t i = 0; i < kn_bezier_count(&b); i++) b.coef[i] = test_uniform(&rng, -1.0, 1.0);
    for (int u = 0; u < 2; u++)
        for (int v = 0; v < 2; v++) {
            double at[2] = {u, v}, got = 0.0;
            assert_int_equal(kn_bezier_eval(ctx, &got, &b, at), KN_OK);
            assert_true(got == b.coef[(u ? 7 * 57 : 0) + (v ? 56 : 0)]);
        }
    kn_bezier_clear(ctx, &b);
    test_ctx_end(ctx, &memory);
}

// Every multi-index up to the order, in the documented order, built here by sorting rather than by counting.
static int all_multi_indices(int (*all)[4], int nvars, int order)
{
    int n = 0;
    for (int total = 0; total <= order; total++)
        for (int code = 9999; code >= 0; code--) { // decimal digits: the first variable slowest and highest first
            int a[4] = {code / 1000, code / 100 % 10, code / 10 % 10, code % 10}, sum = 0;
            bool fits = true;
            for (int d = 0; d < 4; d++) {
                sum += a[d];
                fits = fits && (d < nvars || a[d] == 0);
            }
            if (!fits || sum != total) continue;
            for (int d = 0; d < 4; d++) all[n][d] = a[d];
            n++;
        }
    return n;
}

static void multi_indices(void **state)
{
    (void)state;
    static int all[4096][4];
    for (int nvars = 1; nvars <= 4; nvars++) {
        int n = all_multi_indices(all, nvars, 6);
        assert_int_equal(kn_derivative_count(nvars, 6), n);
        for (int i = 0; i < n; i++) assert_int_equal(kn_derivative_index(nvars, all[i]), i);
    }
    assert_int_equal(kn_derivative_count(0, 5), 1);
    assert_int_equal(kn_derivative_count(3, 0), 1);
    assert_int_equal(kn_derivative_count(3, -1), 0);
    assert_int_equal(kn_derivative_count(-1, 3), 0);
    assert_int_equal(kn_derivative_count(1, 2147483646), 2147483647);
    assert_int_equal(kn_derivative_count(1, 2147483647), 0);
    assert_int_equal(kn_derivative_count(8, 2147483647), 0);
    assert_int_equal(kn_derivative_count(2147483647, 2147483647), 0);
}

static void polynomial_derivatives(void **state)
{
    (void)state;
    static int all[4096][4];
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    for (int n = test_scale(40); n > 0; n--) {
        int nvars = test_int(&rng, 1, 4), degree[4], order = test_int(&rng, 0, 4);
        kn_bezier b;
        ref_random_degrees(&rng, degree, nvars);
        test_random_bezier(ctx, &b, &rng, nvars, 2, false, degree, 9);
        double at[4], got[2 * 70];
        ref_random_point(&rng, at, nvars);
        assert_int_equal(kn_bezier_derivatives(ctx, got, &b, at, order), KN_OK);
        int count = all_multi_indices(all, nvars, order);
        for (int i = 0; i < count; i++) {
            long double expected[2];
            ref_partial(expected, &b, at, all[i]);
            for (int c = 0; c < 2; c++) assert_true(got[2 * i + c] == (double)expected[c]);
        }
        kn_bezier_clear(ctx, &b);
    }
    test_ctx_end(ctx, &memory);
}

// f = g w / w with polynomial g and w: the derivatives of f are those of g. The coefficients of g w and of w at the
// common degree are made integers by a factor m; at the origin w = m, and every quotient there is an integer.
static void rational_derivatives(void **state)
{
    (void)state;
    static int all[4096][4];
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    for (int n = test_scale(40); n > 0; n--) {
        int nvars = test_int(&rng, 1, 3), ng[4], nw[4], sum[4];
        kn_bezier g, w, gw = {0}, f;
        for (int d = 0; d < nvars; d++) {
            ng[d] = test_int(&rng, 0, 3);
            nw[d] = test_int(&rng, 0, 2);
            sum[d] = ng[d] + nw[d];
        }
        test_random_bezier(ctx, &g, &rng, nvars, 2, false, ng, 9);
        test_random_bezier(ctx, &w, &rng, nvars, 1, false, nw, 3);
        w.coef[0] = 1.0; // the value at the origin, where the test looks
        assert_int_equal(kn_bezier_scale(ctx, &g, &g, ref_multiple(nvars, sum)), KN_OK);
        assert_int_equal(kn_bezier_product(ctx, &gw, &g, &w), KN_OK);
        assert_int_equal(kn_bezier_init(ctx, &f, nvars, 3, true, sum), KN_OK);
        size_t count = kn_bezier_count(&gw);
        double m = ref_multiple(nvars, sum);
        for (size_t i = 0; i < 2 * count; i++) f.coef[i] = m * gw.coef[i];
        kn_bezier we = {0};
        assert_int_equal(kn_bezier_scale(ctx, &w, &w, m), KN_OK);
        assert_int_equal(kn_bezier_elevate(ctx, &we, &w, sum), KN_OK);
        for (size_t i = 0; i < count; i++) f.coef[2 * count + i] = we.coef[i];
        double at[3] = {0.0, 0.0, 0.0}, got[2 * 20];
        assert_int_equal(kn_bezier_derivatives(ctx, got, &f, at, 3), KN_OK);
        int indices = all_multi_indices(all, nvars, 3);
        for (int i = 0; i < indices; i++) {
            long double expected[2];
            ref_partial(expected, &g, at, all[i]);
            for (int c = 0; c < 2; c++) assert_true(got[2 * i + c] == (double)expected[c]);
        }
        kn_bezier_clear(ctx, &g);
        kn_bezier_clear(ctx, &w);
        kn_bezier_clear(ctx, &we);
        kn_bezier_clear(ctx, &gw);
        kn_bezier_clear(ctx, &f);
    }
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int degree[1] = {1};
    kn_bezier b, empty = {0};
    double at = 0.0, out[3] = {5.0, 6.0, 7.0};
    assert_int_equal(kn_bezier_init(ctx, &b, 1, 2, true, degree), KN_OK); // all zero: so is the weight
    assert_int_equal(kn_bezier_eval(ctx, out, &b, &at), KN_EUNDEFINED);
    assert_int_equal(kn_bezier_derivatives(ctx, out, &b, &at, 1), KN_EUNDEFINED);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_bezier_eval(ctx, out, &empty, &at), KN_EDOMAIN);
    assert_int_equal(kn_bezier_eval_batch(ctx, out, &empty, 1, &at), KN_EDOMAIN);
    assert_int_equal(kn_bezier_derivatives(ctx, out, &empty, &at, 1), KN_EDOMAIN);
    assert_int_equal(kn_bezier_derivatives(ctx, out, &b, &at, -1), KN_EDOMAIN);
    assert_int_equal(kn_ctx_error(ctx), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_bezier_derivatives(ctx, out, &b, &at, KN_MAX_DEGREE + 1), KN_ELIMIT);
    assert_int_equal(kn_bezier_derivatives(ctx, out, &b, &at, 2147483647), KN_ELIMIT);
    assert_true(out[0] == 5.0 && out[1] == 6.0 && out[2] == 7.0);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_bezier_eval_batch(ctx, out, &b, 1, &at), KN_OK); // one point of many: it tells, and goes on
    assert_true(!isfinite(out[0]));
    assert_int_equal(kn_bezier_eval_batch(ctx, NULL, &b, 0, NULL), KN_OK); // no points: nothing to do
    kn_bezier_clear(ctx, &b);
    test_ctx_end(ctx, &memory);
}

static void not_a_number(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int degree[1] = {2};
    kn_bezier b;
    double at = NAN, out = 0.0;
    assert_int_equal(kn_bezier_init(ctx, &b, 1, 1, false, degree), KN_OK);
    assert_int_equal(kn_bezier_eval(ctx, &out, &b, &at), KN_OK);
    assert_true(isnan(out));
    b.coef[1] = NAN;
    at = 0.5;
    assert_int_equal(kn_bezier_eval(ctx, &out, &b, &at), KN_OK);
    assert_true(isnan(out));
    kn_bezier_clear(ctx, &b);
    test_ctx_end(ctx, &memory);
}

static kn_status call_all(kn_ctx *ctx, void *user)
{
    const int degree[2] = {2, 3};
    static double at[2 * 100], out[2 * 100];
    for (int i = 0; i < 200; i++) at[i] = i / 200.0;
    out[0] = 3.0;
    kn_bezier b = {0};
    kn_status status = kn_bezier_init(ctx, &b, 2, 3, true, degree);
    for (size_t i = 0; status == KN_OK && i < 36; i++) b.coef[i] = 1.0;
    if (status == KN_OK && *(const int *)user == 0) status = kn_bezier_eval(ctx, out, &b, at);
    if (status == KN_OK && *(const int *)user == 1) status = kn_bezier_eval_batch(ctx, out, &b, 100, at);
    if (status == KN_OK && *(const int *)user == 2) status = kn_bezier_derivatives(ctx, out, &b, at, 2);
    assert_true(out[0] == (status == KN_OK ? 1.0 : 3.0));
    kn_bezier_clear(ctx, &b);
    return status;
}

static void out_of_memory(void **state)
{
    (void)state;
    for (int which = 0; which < 3; which++) test_allocation_failures(call_all, &which);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(values_are_exact),
                                       cmocka_unit_test(many_values_are_exact),
                                       cmocka_unit_test(values_keep_their_bound),
                                       cmocka_unit_test(corners_interpolate),
                                       cmocka_unit_test(multi_indices),
                                       cmocka_unit_test(polynomial_derivatives),
                                       cmocka_unit_test(rational_derivatives),
                                       cmocka_unit_test(failures),
                                       cmocka_unit_test(not_a_number),
                                       cmocka_unit_test(out_of_memory)};
    return cmocka_run_group_tests_name("bezier/eval", tests, NULL, NULL);
}
