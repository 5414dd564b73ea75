// SPDX-License-Identifier: Apache-2.0
// Cell lines against closed forms of arc length.
#include "tests/support/support.h"

#include <knurl/cells.h>
#include <knurl/construct.h>
#include <math.h>
#include <string.h>

static const double k1[] = {0, 0, 1, 1}, k2[] = {0, 0, 0, 1, 1, 1};

// (u^2, scale v, 0).
static void square_root(kn_ctx *ctx, kn_spline *out, double scale)
{
    const double *knots[2] = {k2, k1}, coef[18] = {0, 0, 0, 0, 1, 1, 0, scale, 0, scale, 0, scale};
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, (const int[]){2, 1}, (const int[]){3, 2}, knots, coef),
                     KN_OK);
}

// Lines at lengths in equal steps: u = sqrt(i / n), however small S is; and so the area of cells.
static void equal_steps(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    double *lines = NULL;
    square_root(ctx, &s, 1e-3);
    for (int n = 1; n <= 1000; n = 3 * n + 1) {
        assert_int_equal(kn_cells_even_lines(ctx, &lines, &s, 0, n), KN_OK);
        assert_true(lines[0] == 0 && lines[n] == 1);
        for (int i = 1; i < n; i++) assert_true(fabs(lines[i] - sqrt((double)i / n)) <= 1e-13);
        kn_free(ctx, lines);
        assert_int_equal(kn_cells_even_lines(ctx, &lines, &s, 1, n), KN_OK);
        for (int i = 0; i <= n; i++) assert_true(fabs(lines[i] - (double)i / n) <= 1e-14);
        kn_free(ctx, lines);
    }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static const double origin[3] = {0}, axis[3] = {0, 0, 2};

static void make_cylinder(kn_ctx *ctx, kn_spline *out)
{

    assert_int_equal(kn_construct_cylinder(ctx, out, origin, axis, 1), KN_OK);
}

// Angles along the rational circle of four quarters, by the point itself.
static void circles(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    double *lines = NULL, p[3], q[3];
    const double pi = acos(-1);
    for (int k = 0; k < 2; k++) {
        if (k == 0)
            make_cylinder(ctx, &s);
        else
            assert_int_equal(kn_construct_torus(ctx, &s, origin, axis, 3, 1), KN_OK);
        int spans = kn_spline_spans(&s, 0), n = 7 * spans;
        assert_int_equal(kn_cells_even_lines(ctx, &lines, &s, 0, n), KN_OK);
        for (int i = 0; i < n; i++) {
            assert_int_equal(kn_spline_eval(ctx, p, &s, (const double[]){lines[i], 0.25}), KN_OK);
            assert_int_equal(kn_spline_eval(ctx, q, &s, (const double[]){lines[i + 1], 0.25}), KN_OK);
            double turn = atan2(p[0] * q[1] - p[1] * q[0], p[0] * q[0] + p[1] * q[1]);
            assert_true(fabs(fabs(turn) - 2 * pi / n) <= 2e-12);
        }
        kn_free(ctx, lines);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// Every knot is a line; a span gets cells in proportion to its length, and at least one.
static void shares(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static const double ku[] = {0, 0, 1, 2, 3, 3}; // x = 0, 1, 1.001, 4: uniform in parameter, not in length
    const double *knots[2] = {ku, k1}, coef[24] = {0, 0, 1, 1, 1.001, 1.001, 4, 4, 0, 1, 0, 1, 0, 1, 0, 1};
    kn_spline s = {0};
    double *even = NULL, *uniform = NULL;
    assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, (const int[]){1, 1}, (const int[]){4, 2}, knots, coef),
                     KN_OK);
    assert_int_equal(kn_cells_even_lines(ctx, &even, &s, 0, 9), KN_OK);
    assert_int_equal(kn_cells_uniform_lines(ctx, &uniform, &s, 0, 9), KN_OK);
    // shares of 9: 2.25, 0.002 and 6.75 cells; 2, 1 and 6
    const double expect[10] = {0, 0.5, 1, 2, 2 + 1 / 6.0, 2 + 2 / 6.0, 2.5, 2 + 4 / 6.0, 2 + 5 / 6.0, 3};
    for (int i = 0; i <= 9; i++) {
        assert_true(fabs(even[i] - expect[i]) <= 1e-14);
        assert_true(fabs(uniform[i] - i / 3.0) <= 1e-15);
    }
    assert_true(even[2] == 1 && even[3] == 2 && uniform[3] == 1 && uniform[6] == 2);
    kn_free(ctx, even), kn_free(ctx, uniform);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Two surfaces with one speed 2 u and another 2 (1 - v) against it: the sum has speed 4 u. A third, on [2,4].
static void shared(void **state)
{
    (void)state;
    enum { N = 11 };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s[3] = {{0}};
    double *lines[3] = {NULL}, *again = NULL;
    for (int k = 0; k < 3; k++) square_root(ctx, &s[k], 1 + k);
    assert_int_equal(kn_spline_reverse(ctx, &s[1], &s[1], 0), KN_OK);
    assert_int_equal(kn_spline_permute(ctx, &s[1], &s[1], (const int[]){1, 0}), KN_OK);
    assert_int_equal(kn_spline_reparameterize(ctx, &s[2], &s[2], 0, 2, 4), KN_OK);
    const kn_cells_along along[3] = {{&s[0], 0, false}, {&s[1], 1, true}, {&s[2], 0, false}};
    assert_int_equal(kn_cells_shared_lines(ctx, lines, along, 3, N), KN_OK);
    for (int i = 0; i <= N; i++) {
        assert_true(fabs(lines[0][i] - sqrt((double)i / N)) <= 1e-13);
        assert_true(fabs(lines[1][N - i] - (1 - lines[0][i])) <= 1e-15);
        assert_true(fabs(lines[2][i] - (2 + 2 * lines[0][i])) <= 1e-15);
        if (i > 0) assert_true(lines[1][i] > lines[1][i - 1]);
    }
    for (int k = 0; k < 3; k++) kn_free(ctx, lines[k]);
    // two equal ones: the same bits
    const kn_cells_along same[2] = {{&s[0], 0, false}, {&s[0], 0, false}};
    assert_int_equal(kn_cells_shared_lines(ctx, lines, same, 2, N), KN_OK);
    assert_int_equal(kn_cells_even_lines(ctx, &again, &s[0], 0, N), KN_OK);
    assert_memory_equal(lines[0], lines[1], (N + 1) * sizeof(double));
    assert_true(test_max_difference(lines[0], again, N + 1) <= 1e-15);
    kn_free(ctx, lines[0]), kn_free(ctx, lines[1]), kn_free(ctx, again);
    for (int k = 0; k < 3; k++) kn_spline_clear(ctx, &s[k]);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline cylinder = {0}, flat = {0}, empty = {0};
    double mark, *lines[2] = {&mark, &mark};
    make_cylinder(ctx, &cylinder);
    square_root(ctx, &flat, 1);
    int spans = kn_spline_spans(&cylinder, 0);
    assert_true(spans > 1);
    const kn_cells_along other[2] = {{&cylinder, 0, false}, {&flat, 0, false}};
    const struct {
        const kn_spline *s;
        int var, count;
    } bad[] = {{&cylinder, 0, spans - 1}, {&cylinder, 2, 9}, {&cylinder, -1, 9}, {&flat, 0, 0}, {&empty, 0, 1}};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        assert_int_equal(kn_cells_even_lines(ctx, lines, bad[k].s, bad[k].var, bad[k].count), KN_EDOMAIN);
        kn_ctx_clear_error(ctx);
        assert_int_equal(kn_cells_uniform_lines(ctx, lines, bad[k].s, bad[k].var, bad[k].count), KN_EDOMAIN);
        kn_ctx_clear_error(ctx);
    }
    assert_int_equal(kn_cells_shared_lines(ctx, lines, other, 2, 9), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_cells_shared_lines(ctx, lines, other, 0, 9), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    memset(flat.coef, 0, 18 * sizeof *flat.coef);
    assert_int_equal(kn_cells_even_lines(ctx, lines, &flat, 0, 3), KN_EDOMAIN);
    assert_true(lines[0] == &mark && lines[1] == &mark);
    kn_spline_clear(ctx, &cylinder), kn_spline_clear(ctx, &flat);
    test_ctx_end(ctx, &memory);
}

static kn_status make_lines(kn_ctx *ctx, void *user)
{
    kn_spline s = {0};
    double mark, *lines[2] = {&mark, &mark};
    const double *knots[2] = {k2, k1}, coef[18] = {0, 0, 0, 0, 1, 1, 0, 1, 0, 1, 0, 1};
    kn_status status = kn_spline_init(ctx, &s, 2, 3, false, (const int[]){2, 1}, (const int[]){3, 2}, knots, coef);
    const kn_cells_along along[2] = {{&s, 0, false}, {&s, 0, true}};
    if (status == KN_OK)
        status = user ? kn_cells_uniform_lines(ctx, lines, &s, 0, 3) : kn_cells_shared_lines(ctx, lines, along, 2, 3);
    if (status != KN_OK) assert_true(lines[0] == &mark && lines[1] == &mark);
    for (int k = 0; k < 2; k++)
        if (lines[k] != &mark) kn_free(ctx, lines[k]);
    kn_spline_clear(ctx, &s);
    return status;
}

static void allocation(void **state)
{
    (void)state;
    int yes = 1;
    test_allocation_failures(make_lines, NULL);
    test_allocation_failures(make_lines, &yes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(equal_steps), cmocka_unit_test(circles),
                                       cmocka_unit_test(shares),      cmocka_unit_test(shared),
                                       cmocka_unit_test(failures),    cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("cells/even_lines", tests, NULL, NULL);
}
