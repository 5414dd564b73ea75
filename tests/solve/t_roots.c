// SPDX-License-Identifier: Apache-2.0
// Roots of splines of one variable: on knots, at the ends, exact ones, none, too many; failures.
#include "tests/support/support.h"

#include <knurl/solve.h>

#include <math.h>

// (x - 1/4)(x - 3/4)^2 with knots through the roots, and through their neighbours.
static void on_knots(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double p[4] = {-9.0 / 64, 15.0 / 16, -7.0 / 4, 1.0}; // powers
    double c[4] = {p[0], p[0] + p[1] / 3, p[0] + 2 * p[1] / 3 + p[2] / 3, p[0] + p[1] + p[2] + p[3]};
    kn_bezier f = {.nvars = 1, .ncomp = 1, .degree = {3}, .coef = c};
    const double knots[5] = {0.25, 0.1, 0.75, 0.75, 0.3};
    for (int n = 0; n <= 5; n++) {
        kn_spline s = {0};
        kn_root *roots = NULL;
        kn_solve_report report;
        size_t count = 0;
        assert_int_equal(kn_spline_of_bezier(ctx, &s, &f), KN_OK);
        if (n > 0) assert_int_equal(kn_spline_insert_knots(ctx, &s, &s, 0, knots, n), KN_OK);
        assert_int_equal(kn_solve_roots(ctx, &roots, &count, &report, &s, NULL), KN_OK);
        assert_true(count >= 1 && count <= 3);
        assert_int_equal(roots[0].kind, KN_ROOT_UNIQUE);
        assert_true(roots[0].lo[0] <= 0.25 && 0.25 <= roots[0].hi[0] && fabs(roots[0].at[0] - 0.25) < 1e-14);
        for (size_t i = 1; i < count; i++) assert_true(fabs(roots[i].at[0] - 0.75) < 1e-6); // a double root, rounded
        kn_free(ctx, roots);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

static void special(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double knots[6] = {2.0, 2.0, 3.0, 4.0, 4.0, 0.0}, c[3] = {0.0, 1.0, 0.0};
    kn_spline s = {.nvars = 1, .ncomp = 1, .degree = {1}, .count = {3}, .knots = {knots}, .coef = c};
    kn_root *roots = NULL;
    kn_solve_report report;
    size_t n = 0;
    assert_int_equal(kn_solve_roots(ctx, &roots, &n, &report, &s, NULL), KN_OK); // both ends, exactly
    assert_int_equal(n, 2);
    assert_true(roots[0].lo[0] == 2.0 && roots[0].hi[0] == 2.0 && roots[0].least == 1 && roots[0].most == 1);
    assert_true(roots[1].lo[0] == 4.0 && roots[1].hi[0] == 4.0 && roots[1].at_edge);
    kn_free(ctx, roots);
    c[0] = -1.0, c[1] = 0.0, c[2] = 1.0; // on the knot, exactly, once
    assert_int_equal(kn_solve_roots(ctx, &roots, &n, &report, &s, NULL), KN_OK);
    assert_int_equal(n, 1);
    assert_true(roots[0].lo[0] == 3.0 && roots[0].hi[0] == 3.0 && roots[0].kind == KN_ROOT_UNIQUE);
    kn_free(ctx, roots);
    c[0] = 0.0, c[2] = 1.0; // zero on a whole piece
    assert_int_equal(kn_solve_roots(ctx, &roots, &n, &report, &s, NULL), KN_OK);
    assert_true(report.curve_like && n == 1 && roots[0].kind == KN_ROOT_POSSIBLE);
    assert_true(roots[0].lo[0] == 2.0 && roots[0].hi[0] == 3.0);
    kn_free(ctx, roots);
    c[0] = c[1] = c[2] = 1.0; // none
    assert_int_equal(kn_solve_roots(ctx, &roots, &n, &report, &s, NULL), KN_OK);
    assert_int_equal(n, 0);
    kn_free(ctx, roots);
    double weights[6] = {-1.0, 1.0, -2.0, 1.0, 0.5, 2.0}; // rational: those of the numerator
    kn_spline r = {
        .nvars = 1, .ncomp = 2, .rational = true, .degree = {1}, .count = {3}, .knots = {knots}, .coef = weights};
    assert_int_equal(kn_solve_roots(ctx, &roots, &n, NULL, &r, NULL), KN_OK);
    assert_int_equal(n, 2);
    assert_true(fabs(roots[0].at[0] - 2.5) < 1e-15 && fabs(roots[1].at[0] - 10.0 / 3.0) < 1e-15);
    kn_free(ctx, roots);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double c[4] = {-1.0, 1.0, 1.0, 1.0};
    kn_bezier wide = {.nvars = 2, .ncomp = 1, .degree = {1, 1}, .coef = c},
              tall = {.nvars = 1, .ncomp = 2, .degree = {1}, .coef = c};
    kn_spline s = {0}, empty = {0};
    kn_root mine, *roots = &mine;
    size_t n = 5;
    assert_int_equal(kn_solve_roots(ctx, &roots, &n, NULL, &empty, NULL), KN_EDOMAIN);
    assert_int_equal(kn_spline_of_bezier(ctx, &s, &wide), KN_OK);
    assert_int_equal(kn_solve_roots(ctx, &roots, &n, NULL, &s, NULL), KN_EDOMAIN);
    assert_int_equal(kn_spline_of_bezier(ctx, &s, &tall), KN_OK);
    assert_int_equal(kn_solve_roots(ctx, &roots, &n, NULL, &s, NULL), KN_EDOMAIN);
    tall.ncomp = 1;
    assert_int_equal(kn_spline_of_bezier(ctx, &s, &tall), KN_OK);
    const kn_solve_options bad = {.max_depth = -1};
    assert_int_equal(kn_solve_roots(ctx, &roots, &n, NULL, &s, &bad), KN_EDOMAIN);
    s.coef[0] = NAN;
    assert_int_equal(kn_solve_roots(ctx, &roots, &n, NULL, &s, NULL), KN_EDOMAIN);
    assert_ptr_equal(roots, &mine);
    assert_int_equal(n, 5);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static kn_status three_roots(kn_ctx *ctx, void *user)
{
    double knots[8] = {0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0}, c[4] = {-1.0, 4.0, -4.0, 1.0};
    kn_spline s = {.nvars = 1, .ncomp = 1, .degree = {3}, .count = {4}, .knots = {knots}, .coef = c};
    kn_root *roots = user;
    size_t n = 0;
    kn_status status = kn_solve_roots(ctx, &roots, &n, NULL, &s, NULL);
    if (status != KN_OK) assert_ptr_equal(roots, user);
    if (status == KN_OK) assert_int_equal(n, 3);
    if (status == KN_OK) kn_free(ctx, roots);
    return status;
}

static void allocation(void **state)
{
    (void)state;
    kn_root mine;
    test_allocation_failures(three_roots, &mine);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(on_knots), cmocka_unit_test(special),
                                       cmocka_unit_test(failures), cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("solve/roots", tests, NULL, NULL);
}
