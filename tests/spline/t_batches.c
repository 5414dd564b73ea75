// SPDX-License-Identifier: Apache-2.0
// Batches with partials, grids and isoparametric splines.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/support.h"

enum { MOST = 4000 };

// u^2 v over [0,2] x [0,1] with a knot: dyadic parameters give exact values and partials, also outside.
static void exact(void **state)
{
    (void)state;
    enum { NU = 41, NV = 13 };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double ku[] = {0, 0, 0, 1, 2, 2, 2}, kv[] = {0, 0, 1, 1}, coef[] = {0, 0, 0, 0, 0, 2, 0, 4};
    const double *const knots[] = {ku, kv};
    static double at[2 * NU * NV], out[3 * NU * NV], grid[NU * NV], us[NU], vs[NV];
    const double *const axes[] = {us, vs};
    const size_t n[] = {NU, NV};
    kn_spline s;
    assert_int_equal(kn_spline_init(ctx, &s, 2, 1, false, (int[]){2, 1}, (int[]){4, 2}, knots, coef), KN_OK);
    for (int i = 0; i < NU; i++) us[i] = (i - 10) / 8.0;
    for (int j = 0; j < NV; j++) vs[j] = j / 4.0;
    for (int i = 0; i < NU * NV; i++) at[2 * i] = us[i / NV], at[2 * i + 1] = vs[i % NV];
    assert_int_equal(kn_spline_eval_batch_partials(ctx, out, &s, NU * NV, at), KN_OK);
    assert_int_equal(kn_spline_eval_grid(ctx, grid, &s, n, axes), KN_OK);
    for (int i = 0; i < NU * NV; i++) {
        double u = at[2 * i], v = at[2 * i + 1];
        assert_true(out[3 * i] == u * u * v && out[3 * i + 1] == 2 * u * v && out[3 * i + 2] == u * u);
        assert_true(grid[i] == u * u * v);
    }
    kn_spline c = {0};
    assert_int_equal(kn_spline_isoparametric(ctx, &c, &s, 0, 0.5), KN_OK); // v / 4
    assert_true(c.nvars == 1 && c.count[0] == 2 && c.coef[0] == 0 && c.coef[1] == 0.25);
    size_t before = kn_ctx_counters(ctx).allocations;                    // c has the right size by now
    assert_int_equal(kn_spline_isoparametric(ctx, &c, &s, 0, 2), KN_OK); // the end: bit for bit
    assert_int_equal(kn_ctx_counters(ctx).allocations, before);
    assert_true(c.coef[0] == 0 && c.coef[1] == 4);
    assert_int_equal(kn_spline_isoparametric(ctx, &s, &s, 1, 1), KN_OK); // in place: u^2
    assert_true(s.nvars == 1 && s.count[0] == 4 && memcmp(s.coef, (double[]){0, 0, 2, 4}, 32) == 0);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &c);
    test_ctx_end(ctx, &memory);
}

// Partials against kn_spline_derivatives, grids against batches: each side within the header's bound for a partial,
// which is larger than that for a value and than that of kn_spline_derivatives. p <= 3 and h >= 1; coefficients are
// at most 9, weights in [1, 9], so that |P| <= 9 and q <= 9.
static void against_others(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    static double at[4 * 150], out[5 * 3 * 150], values[3 * MOST], batch[3 * MOST], points[4 * MOST];
    for (int round = test_scale(30); round > 0; round--) {
        int nvars = test_int(&rng, 1, 4), degree[4], count[4], steps = 0;
        bool rational = round % 2;
        for (int d = 0; d < nvars; d++) {
            degree[d] = test_int(&rng, 0, 3), count[d] = degree[d] + 1 + test_int(&rng, 0, nvars > 2 ? 2 : 8);
            steps += 17 * degree[d] + 3;
        }
        kn_spline s;
        test_random_spline(ctx, &s, &rng, nvars, 3, rational, degree, count, 9);
        size_t dim = (size_t)kn_spline_dim(&s), each = dim * (1 + (size_t)nvars);
        for (int i = 0; i < 150 * nvars; i++) at[i] = test_uniform(&rng, 0, s.knots[i % nvars][count[i % nvars]]);
        assert_int_equal(kn_spline_eval_batch_partials(ctx, out, &s, 150, at), KN_OK);
        double bound = rational ? 12 * (steps + 4) * 9 * 9 : steps; // q^2
        double tolerance = 2 * bound * 0x1.01p-53 * (2 * 3) * 9;    // of both; 2 p / h, |P|
        for (int i = 0; i < 150; i++) {
            double d[15];
            assert_int_equal(kn_spline_derivatives(ctx, d, &s, at + i * nvars, 1), KN_OK);
            assert_true(test_max_difference(d, out + (size_t)i * each, each) <= tolerance);
        }
        size_t n[4], all = 1;
        double axes[4][20];
        const double *const parameters[] = {axes[0], axes[1], axes[2], axes[3]};
        for (int d = 0; d < nvars; d++) {
            all *= n[d] = (size_t)test_int(&rng, 1, nvars > 3 ? 6 : 10);
            for (size_t i = 0; i < n[d]; i++) axes[d][i] = test_uniform(&rng, 0, s.knots[d][count[d]]);
        }
        for (size_t i = 0; i < all; i++)
            for (size_t rest = i, d = (size_t)nvars; d-- > 0; rest /= n[d])
                points[i * (size_t)nvars + d] = axes[d][rest % n[d]];
        assert_int_equal(kn_spline_eval_grid(ctx, values, &s, n, parameters), KN_OK);
        assert_int_equal(kn_spline_eval_batch(ctx, batch, &s, all, points), KN_OK);
        assert_true(test_max_difference(values, batch, all * dim) <= tolerance);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// Where the weight (1 - u) - u is zero, at u = 1/2, nothing is finite, and nothing else is touched.
static void zero_weight(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double k[] = {0, 0, 1, 1}, coef[] = {1, 1, 1, 1, 1, 1, -1, -1};
    const double *const knots[] = {k, k}, axis[] = {0.25, 0.5, 0.75}, *const axes[] = {axis, axis};
    static double at[2 * 90], out[3 * 90], grid[9];
    kn_spline s;
    assert_int_equal(kn_spline_init(ctx, &s, 2, 2, true, (int[]){1, 1}, (int[]){2, 2}, knots, coef), KN_OK);
    for (int i = 0; i < 90; i++) at[2 * i] = axis[i % 3], at[2 * i + 1] = axis[i / 30];
    for (int n = 1; n <= 90; n += 89) { // without tables, and with them
        assert_int_equal(kn_spline_eval_batch_partials(ctx, out, &s, (size_t)n, at), KN_OK);
        for (int i = 0; i < n; i++) { // 1 / (1 - 2 u), 2 / (1 - 2 u)^2
            double u = at[2 * i], w = 1 - 2 * u;
            bool finite = u != 0.5;
            for (int m = 0; m < 3; m++) assert_true(!finite == !isfinite(out[3 * i + m]));
            if (finite) assert_true(out[3 * i] == 1 / w && out[3 * i + 1] == 2 / (w * w) && out[3 * i + 2] == 0);
        }
    }
    assert_int_equal(kn_spline_eval_grid(ctx, grid, &s, (size_t[]){3, 3}, axes), KN_OK);
    for (int i = 0; i < 9; i++) {
        bool finite = i / 3 != 1;
        assert_true(!finite == !isfinite(grid[i]));
        if (finite) assert_true(grid[i] == (i < 3 ? 2 : -2));
    }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Rational and in three variables: linear on unit spans, integers and dyadic parameters, so that everything but the
// last division is exact on both sides.
static void isoparametric(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    const double k[] = {0, 0, 1, 2, 2};
    const double *const knots[] = {k, k, k};
    for (int round = test_scale(24); round > 0; round--) {
        bool rational = round % 2;
        int nvars = 2 + round % 4 / 2, n = nvars == 2 ? 9 : 27;
        double coef[3 * 27], at[3], rest[3], a[3], b[3];
        for (int i = 0; i < 3 * n; i++) coef[i] = test_int(&rng, rational && i >= 2 * n ? 1 : -9, 9);
        kn_spline s, c = {0};
        assert_int_equal(kn_spline_init(ctx, &s, nvars, 3, rational, (int[]){1, 1, 1}, (int[]){3, 3, 3}, knots, coef),
                         KN_OK);
        for (int var = 0; var < nvars; var++)
            for (int i = 0; i < 10; i++) {
                int m = 0;
                for (int d = 0; d < nvars; d++) {
                    at[d] = test_int(&rng, 0, 16) / 8.0;
                    if (d != var) rest[m++] = at[d];
                }
                assert_int_equal(kn_spline_isoparametric(ctx, &c, &s, var, at[var]), KN_OK);
                assert_true(c.nvars == nvars - 1 && c.ncomp == 3 && c.rational == rational);
                assert_int_equal(kn_spline_eval(ctx, a, &s, at), KN_OK);
                assert_int_equal(kn_spline_eval(ctx, b, &c, rest), KN_OK);
                for (int comp = 0; comp < kn_spline_dim(&s); comp++) assert_true(a[comp] == b[comp]);
            }
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &c);
    }
    test_ctx_end(ctx, &memory);
}

static void failures_and_steady_state(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    static double at[2 * 300], out[9 * 300];
    const double *const axes[] = {at, at};
    kn_spline s, empty = {0}, c = {0};
    test_random_spline(ctx, &s, &rng, 2, 3, false, (int[]){3, 3}, (int[]){8, 8}, 9);
    for (int i = 0; i < 600; i++) at[i] = test_uniform(&rng, 0, 3);
    size_t calls = 0;
    for (int round = 0; round < 3; round++) {
        if (round == 1) calls = kn_ctx_counters(ctx).allocations;
        assert_int_equal(kn_spline_eval_batch(ctx, out, &s, 300, at), KN_OK);
        assert_int_equal(kn_spline_eval_batch_partials(ctx, out, &s, 300, at), KN_OK);
        assert_int_equal(kn_spline_eval_grid(ctx, out, &s, (size_t[]){20, 40}, axes), KN_OK);
        assert_int_equal(kn_spline_eval(ctx, out, &s, at), KN_OK);
    }
    assert_true(kn_ctx_counters(ctx).allocations == calls);
    assert_int_equal(kn_spline_eval_grid(ctx, NULL, &s, (size_t[]){20, 0}, axes), KN_OK); // an empty grid
    assert_int_equal(kn_spline_eval_batch_partials(ctx, out, &empty, 1, at), KN_EDOMAIN);
    assert_int_equal(kn_spline_eval_grid(ctx, out, &empty, (size_t[]){1, 1}, axes), KN_EDOMAIN);
    assert_int_equal(kn_spline_isoparametric(ctx, &c, &s, 2, 0), KN_EDOMAIN);
    assert_int_equal(kn_spline_isoparametric(ctx, &c, &s, 0, 1.5), KN_OK);
    assert_int_equal(kn_spline_isoparametric(ctx, &c, &c, 0, 1.5), KN_EDOMAIN); // a curve: c is as it was
    assert_true(c.nvars == 1 && c.count[0] == 8);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &c);
    test_ctx_end(ctx, &memory);
}

static kn_status call(kn_ctx *ctx, void *user)
{
    const double k[] = {0, 0, 1, 1}, coef[] = {1, 1, 1, 1};
    const double *const knots[] = {k, k};
    static double at[400], out[600];
    const double *const axes[] = {at, at};
    int which = *(const int *)user;
    kn_spline s = {0}, c = {0};
    out[0] = 7;
    kn_status status = kn_spline_init(ctx, &s, 2, 1, false, (int[]){1, 1}, (int[]){2, 2}, knots, coef);
    if (status == KN_OK && which == 0) status = kn_spline_eval_batch_partials(ctx, out, &s, 200, at);
    if (status == KN_OK && which == 1) status = kn_spline_eval_grid(ctx, out, &s, (size_t[]){9, 9}, axes);
    if (status == KN_OK && which == 2) status = kn_spline_isoparametric(ctx, &c, &s, 0, 0.5);
    if (which < 2) assert_true(out[0] == (status == KN_OK ? 1 : 7));
    if (which == 2 && status != KN_OK) assert_true(c.nvars == 0 && !c.coef);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &c);
    return status;
}

static void memory_failures(void **state)
{
    (void)state;
    for (int which = 0; which < 3; which++) test_allocation_failures(call, &which);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(exact),
                                       cmocka_unit_test(against_others),
                                       cmocka_unit_test(zero_weight),
                                       cmocka_unit_test(isoparametric),
                                       cmocka_unit_test(failures_and_steady_state),
                                       cmocka_unit_test(memory_failures)};
    return cmocka_run_group_tests_name("spline/batches", tests, NULL, NULL);
}
