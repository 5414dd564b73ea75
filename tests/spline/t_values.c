// SPDX-License-Identifier: Apache-2.0
// Values and derivatives of splines against long double.
#include <float.h>
#include <math.h>
#include <string.h>

#include "kernel/knots.h"
#include "kernel/multi_index.h"
#include "tests/spline/oracle.h"
#include "tests/support/support.h"

static void random_shape(test_rng *rng, int nvars, int *degree, int *count)
{
    for (int d = 0; d < nvars; d++) {
        degree[d] = test_int(rng, 0, nvars > 2 ? 3 : 5);
        count[d] = degree[d] + 1 + test_int(rng, 0, nvars > 2 ? 3 : 8);
    }
}

// A parameter: anywhere in the domain, on a knot, at its ends, or a little beyond.
static double random_parameter(test_rng *rng, const kn_spline *s, int d, bool beyond)
{
    double lo, hi;
    kn_spline_domain(s, d, &lo, &hi);
    switch (test_int(rng, 0, beyond ? 4 : 3)) {
    case 0: return s->knots[d][test_int(rng, 0, s->count[d] + s->degree[d])];
    case 4: return test_uniform(rng, lo - 0.5, hi + 0.5);
    default: return test_uniform(rng, lo, hi);
    }
}

// |computed - exact| of N / w where N and w carry errors e_N and e_w: (e_N + |N/w| e_w) / (|w| - e_w), and one
// rounding.
static void compare(const kn_spline *s, const double *at, const double *got)
{
    long double value[KN_MAX_COMPS], size[KN_MAX_COMPS];
    oracle_homogeneous(value, size, s, at, NULL, NULL);
    int dim = kn_spline_dim(s);
    double g = oracle_gamma(oracle_eval_operations(s) + 2);
    for (int c = 0; c < dim; c++) {
        long double exact = value[c], bound = g * size[c];
        if (s->rational) {
            long double w = fabsl(value[dim]), ew = g * size[dim];
            exact /= value[dim];
            bound = (bound + fabsl(exact) * ew) / (w - ew) + DBL_EPSILON * fabsl(exact);
            if (ew >= w) continue; // beyond the domain the weight may vanish
        }
        assert_true(fabsl(got[c] - exact) <= bound + DBL_MIN);
    }
}

static void values(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = test_scale(60); round > 0; round--) {
        int nvars = test_int(&rng, 1, 4), degree[4], count[4], ncomp = test_int(&rng, 2, 4);
        random_shape(&rng, nvars, degree, count);
        kn_spline s;
        test_random_spline(ctx, &s, &rng, nvars, ncomp, test_int(&rng, 0, 1), degree, count, 9);
        for (int i = 0; i < 10; i++) {
            double at[4], out[4];
            for (int d = 0; d < nvars; d++) at[d] = random_parameter(&rng, &s, d, true);
            kn_status status = kn_spline_eval(ctx, out, &s, at);
            if (status == KN_EUNDEFINED) continue; // beyond the domain a weight may be zero
            assert_int_equal(status, KN_OK);
            compare(&s, at, out);
        }
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

static void many_variables(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    int degree[8] = {1, 2, 0, 1, 1, 2, 1, 0}, count[8] = {2, 3, 2, 3, 2, 3, 2, 1};
    double at[8], out[2];
    kn_spline s;
    test_random_spline(ctx, &s, &rng, 8, 2, false, degree, count, 9);
    for (int d = 0; d < 8; d++) at[d] = random_parameter(&rng, &s, d, false);
    assert_int_equal(kn_spline_eval(ctx, out, &s, at), KN_OK);
    compare(&s, at, out);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// f(u,v) = u^2 v over [0,2]x[0,1], knot at u = 1: exact values at dyadic points, also far outside.
static void exact_values(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double ku[] = {0, 0, 0, 1, 2, 2, 2}, kv[] = {0, 0, 1, 1};
    const double *const knots[] = {ku, kv};
    const double coef[] = {0, 0, 0, 0, 0, 2, 0, 4}; // blossom u1 u2 of u^2 at (0,0) (0,1) (1,2) (2,2), times v
    kn_spline s;
    assert_int_equal(kn_spline_init(ctx, &s, 2, 1, false, (int[]){2, 1}, (int[]){4, 2}, knots, coef), KN_OK);
    const double us[] = {-4, -1, 0, 0.25, 1, 1.5, 2, 3, 8};
    for (size_t i = 0; i < sizeof us / sizeof *us; i++)
        for (double v = -2; v <= 3; v += 0.5) {
            double at[2] = {us[i], v}, d[6];
            assert_int_equal(kn_spline_derivatives(ctx, d, &s, at, 2), KN_OK);
            double u = us[i], expected[6] = {u * u * v, 2 * u * v, u * u, 2 * v, 2 * u, 0};
            for (int k = 0; k < 6; k++) assert_true(d[k] == expected[k]);
            assert_int_equal(kn_spline_eval(ctx, d, &s, at), KN_OK);
            assert_true(d[0] == expected[0]);
        }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Derivatives of the homogeneous components. A difference adds 3 roundings per level to the 6 of a value's level.
static void polynomial_derivatives(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    for (int round = test_scale(30); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3), degree[3], count[3], order = test_int(&rng, 0, 4), a[3] = {0};
        random_shape(&rng, nvars, degree, count);
        kn_spline s;
        double at[3], out[35 * 2];
        test_random_spline(ctx, &s, &rng, nvars, 2, false, degree, count, 9);
        for (int d = 0; d < nvars; d++) at[d] = random_parameter(&rng, &s, d, true);
        assert_int_equal(kn_spline_derivatives(ctx, out, &s, at, order), KN_OK);
        int n = kn_derivative_count(nvars, order);
        for (int i = 0; i < n; i++) {
            long double value[2], size[2];
            oracle_homogeneous(value, size, &s, at, a, NULL);
            for (int c = 0; c < 2; c++)
                assert_true(fabsl(out[i * 2 + c] - value[c]) <=
                            oracle_gamma(2 * oracle_eval_operations(&s)) * size[c]);
            assert_int_equal(kn_derivative_index(nvars, a), i);
            assert_int_equal(kn_multi_index_place(nvars, a), i);
            kn_multi_index_next(nvars, a);
        }
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// The quarter circle (1 - t^2, 2t) / (1 + t^2): derivatives known in closed form; all operations on small numbers.
static void rational_derivatives(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double k[] = {0, 0, 0, 1, 1, 1}, coef[] = {1, 1, 0, 0, 1, 2, 1, 1, 2};
    const double *const knots[] = {k};
    kn_spline s;
    assert_int_equal(kn_spline_init(ctx, &s, 1, 3, true, (int[]){2}, (int[]){3}, knots, coef), KN_OK);
    for (int i = -4; i <= 12; i++) {
        double t = i / 8.0, out[6];
        assert_int_equal(kn_spline_derivatives(ctx, out, &s, &t, 2), KN_OK);
        long double w = 1 + (long double)t * t;
        long double expected[6] = {(1 - (long double)t * t) / w,
                                   2 * (long double)t / w,
                                   -4 * (long double)t / (w * w),
                                   2 * (1 - (long double)t * t) / (w * w),
                                   (12 * (long double)t * t - 4) / (w * w * w),
                                   (4 * (long double)t * t - 12) * t / (w * w * w)};
        // three quotients of numbers below 12 in turn, each multiplying the last one's error by at most |w'|, |w''|
        // <= 4
        for (int c = 0; c < 6; c++) assert_true(fabsl(out[c] - expected[c]) <= 64 * oracle_gamma(32));
    }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Mixed derivatives of a rational surface solve Leibniz' rule: sum C(a,b) w_b f_{a-b} = N_a.
static void rational_derivatives_obey_leibniz(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    const int degree[2] = {3, 2}, count[2] = {6, 4};
    static const int index[6][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}};
    kn_spline s;
    test_random_spline(ctx, &s, &rng, 2, 2, true, degree, count, 5);
    double at[2], f[6];
    for (int d = 0; d < 2; d++) at[d] = random_parameter(&rng, &s, d, false);
    assert_int_equal(kn_spline_derivatives(ctx, f, &s, at, 2), KN_OK);
    long double h[6][2], size[6][2];
    for (int i = 0; i < 6; i++) oracle_homogeneous(h[i], size[i], &s, at, index[i], NULL);
    const long double sums[6] = {
        h[0][1] * f[0],
        h[0][1] * f[1] + h[1][1] * f[0],
        h[0][1] * f[2] + h[2][1] * f[0],
        h[0][1] * f[3] + 2 * h[1][1] * f[1] + h[3][1] * f[0],
        h[0][1] * f[4] + h[1][1] * f[2] + h[2][1] * f[1] + h[4][1] * f[0],
        h[0][1] * f[5] + 2 * h[2][1] * f[2] + h[5][1] * f[0],
    };
    long double all = 0, largest = 1;
    for (int i = 0; i < 6; i++) all += size[i][0] + size[i][1], largest = fmaxl(largest, fabs(f[i]));
    // each sum has at most 4 terms below all * largest, each computed with at most 2 * operations + 4 roundings
    for (int i = 0; i < 6; i++)
        assert_true(fabsl(sums[i] - h[i][0]) <= oracle_gamma(2 * oracle_eval_operations(&s) + 4) * 4 * all * largest);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Parameters near the largest double: scaled by a power of two, all quotients and so all bits stay.
static void huge_knots(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(9);
    for (int round = 0; round < 40; round++) {
        double knots[2][7] = {{0, 0, 0.25, 0.5, 0.75, 1, 1}}, coef[5], at[2][24], value[2][24], batch[2][24];
        if (round % 2) knots[0][2] = 0.125;
        for (int i = 0; i < 7; i++) knots[1][i] = 0x1p1023 * knots[0][i];
        for (int i = 0; i < 5; i++) coef[i] = test_int(&rng, -9, 9);
        for (int i = 0; i < 24; i++) at[0][i] = test_uniform(&rng, knots[0][0], 1.0), at[1][i] = 0x1p1023 * at[0][i];
        for (int k = 0; k < 2; k++) {
            double *vectors[1] = {knots[k]};
            kn_spline s = {0};
            assert_int_equal(
                kn_spline_init(ctx, &s, 1, 1, false, (int[]){1}, (int[]){5}, (const double *const *)vectors, coef),
                KN_OK);
            for (int i = 0; i < 24; i++) assert_int_equal(kn_spline_eval(ctx, &value[k][i], &s, &at[k][i]), KN_OK);
            assert_int_equal(kn_spline_eval_batch(ctx, batch[k], &s, 24, at[k]), KN_OK);
            kn_spline_clear(ctx, &s);
        }
        assert_memory_equal(value[0], value[1], sizeof value[0]);
        assert_memory_equal(batch[0], batch[1], sizeof batch[0]);
    }
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double k[] = {0, 0, 1, 1}, coef[] = {1, 2, 1, -1}; // the weight 1 - 2t vanishes at 1/2
    const double *const knots[] = {k};
    kn_spline s, empty = {0};
    double at = 0.5, out[2] = {7, 7};
    assert_int_equal(kn_spline_init(ctx, &s, 1, 2, true, (int[]){1}, (int[]){2}, knots, coef), KN_OK);
    assert_int_equal(kn_spline_eval(ctx, out, &s, &at), KN_EUNDEFINED);
    assert_int_equal(kn_spline_derivatives(ctx, out, &s, &at, 1), KN_EUNDEFINED);
    assert_int_equal(kn_spline_derivatives(ctx, out, &s, &at, -1), KN_EDOMAIN);
    assert_int_equal(kn_spline_derivatives(ctx, out, &s, &at, KN_MAX_DEGREE + 1), KN_ELIMIT);
    assert_int_equal(kn_spline_eval(ctx, out, &empty, &at), KN_EDOMAIN);
    assert_int_equal(kn_spline_derivatives(ctx, out, &empty, &at, 0), KN_EDOMAIN);
    assert_true(out[0] == 7 && out[1] == 7);
    s.rational = false; // not finite in, not finite out; no crash
    at = NAN;
    assert_int_equal(kn_spline_eval(ctx, out, &s, &at), KN_OK);
    assert_true(isnan(out[0]));
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static kn_status derive(kn_ctx *ctx, void *user)
{
    (void)user;
    const double k[] = {0, 0, 1, 1}, coef[] = {1, 2, 1, 1};
    const double *const knots[] = {k};
    kn_spline s = {0};
    double at = 0.5, out[2] = {7, 7};
    kn_status status = kn_spline_init(ctx, &s, 1, 2, true, (int[]){1}, (int[]){2}, knots, coef);
    if (status == KN_OK) status = kn_spline_derivatives(ctx, out, &s, &at, 1);
    if (status != KN_OK) assert_true(out[0] == 7 && out[1] == 7);
    kn_spline_clear(ctx, &s);
    return status;
}

static void memory_failures(void **state)
{
    (void)state;
    test_allocation_failures(derive, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values),
        cmocka_unit_test(many_variables),
        cmocka_unit_test(exact_values),
        cmocka_unit_test(polynomial_derivatives),
        cmocka_unit_test(rational_derivatives),
        cmocka_unit_test(rational_derivatives_obey_leibniz),
        cmocka_unit_test(huge_knots),
        cmocka_unit_test(failures),
        cmocka_unit_test(memory_failures),
    };
    return cmocka_run_group_tests_name("spline/values", tests, NULL, NULL);
}
