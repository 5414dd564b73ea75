// SPDX-License-Identifier: Apache-2.0
// Batches with partials and grids of Bezier pieces; their bits are tested in tests/kernel/t_eval, their bounds in
// tests/oracle.
#include <math.h>
#include <string.h>

#include "tests/support/support.h"

// u v + 2 v, exact; constants; empty ones.
static void exact(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static double at[2 * 100], out[3 * 100], grid[9];
    kn_bezier b, empty = {0}, constant;
    assert_int_equal(kn_bezier_init(ctx, &b, 2, 1, false, (int[]){1, 1}), KN_OK);
    memcpy(b.coef, (double[]){0, 2, 0, 3}, 32);
    for (int i = 0; i < 100; i++) at[2 * i] = (i % 10) / 4.0, at[2 * i + 1] = (double)(i / 10) / 8.0;
    assert_int_equal(kn_bezier_eval_batch_partials(ctx, out, &b, 100, at), KN_OK);
    for (int i = 0; i < 100; i++) {
        double u = at[2 * i], v = at[2 * i + 1];
        assert_true(out[3 * i] == u * v + 2 * v && out[3 * i + 1] == v && out[3 * i + 2] == u + 2);
    }
    const double axis[] = {0, 0.5, 1};
    const double *const axes[] = {axis, axis};
    assert_int_equal(kn_bezier_eval_grid(ctx, grid, &b, (size_t[]){3, 3}, axes), KN_OK);
    for (int i = 0; i < 9; i++) assert_true(grid[i] == axis[i / 3] * axis[i % 3] + 2 * axis[i % 3]);
    assert_int_equal(kn_bezier_init(ctx, &constant, 0, 1, false, NULL), KN_OK);
    constant.coef[0] = 5;
    assert_int_equal(kn_bezier_eval_batch_partials(ctx, out, &constant, 2, at), KN_OK);
    assert_int_equal(kn_bezier_eval_grid(ctx, grid, &constant, NULL, NULL), KN_OK);
    assert_true(out[0] == 5 && out[1] == 5 && grid[0] == 5);
    assert_int_equal(kn_bezier_eval_batch_partials(ctx, out, &empty, 1, at), KN_EDOMAIN);
    assert_int_equal(kn_bezier_eval_grid(ctx, out, &empty, (size_t[]){1, 1}, axes), KN_EDOMAIN);
    kn_bezier_clear(ctx, &b);
    kn_bezier_clear(ctx, &constant);
    test_ctx_end(ctx, &memory);
}

// Where the weight 1 - 2 u is zero nothing is finite, and nothing else is touched: 1 / (1 - 2 u).
static void zero_weight(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static double at[90], out[2 * 90];
    kn_bezier b;
    assert_int_equal(kn_bezier_init(ctx, &b, 1, 2, true, (int[]){1}), KN_OK);
    memcpy(b.coef, (double[]){1, 1, 1, -1}, 32);
    for (int i = 0; i < 90; i++) at[i] = (i % 5) / 4.0;
    for (int n = 5; n <= 90; n += 85) {
        assert_int_equal(kn_bezier_eval_batch_partials(ctx, out, &b, (size_t)n, at), KN_OK);
        for (int i = 0; i < n; i++) {
            double w = 1 - 2 * at[i];
            assert_true(!isfinite(out[2 * i]) == (w == 0) && !isfinite(out[2 * i + 1]) == (w == 0));
            if (w != 0) assert_true(out[2 * i] == 1 / w && out[2 * i + 1] == 2 / (w * w));
        }
    }
    kn_bezier_clear(ctx, &b);
    test_ctx_end(ctx, &memory);
}

static kn_status call(kn_ctx *ctx, void *user)
{
    static double at[400], out[600];
    const double *const axes[] = {at, at};
    int which = *(const int *)user;
    kn_bezier b = {0};
    out[0] = 7;
    kn_status status = kn_bezier_init(ctx, &b, 2, 1, false, (int[]){1, 1});
    if (status == KN_OK) memcpy(b.coef, (double[]){1, 1, 1, 1}, 32);
    if (status == KN_OK && which == 0) status = kn_bezier_eval_batch(ctx, out, &b, 200, at);
    if (status == KN_OK && which == 1) status = kn_bezier_eval_batch_partials(ctx, out, &b, 200, at);
    if (status == KN_OK && which == 2) status = kn_bezier_eval_grid(ctx, out, &b, (size_t[]){9, 9}, axes);
    assert_true(out[0] == (status == KN_OK ? 1 : 7));
    kn_bezier_clear(ctx, &b);
    return status;
}

static void memory_failures(void **state)
{
    (void)state;
    for (int which = 0; which < 3; which++) test_allocation_failures(call, &which);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(exact), cmocka_unit_test(zero_weight),
                                       cmocka_unit_test(memory_failures)};
    return cmocka_run_group_tests_name("bezier/batches", tests, NULL, NULL);
}
