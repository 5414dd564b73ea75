// SPDX-License-Identifier: Apache-2.0
// Making, copying, checking and measuring splines.
#include <math.h>
#include <string.h>

#include "tests/support/support.h"

// A biquadratic-by-linear surface of two components with small integers.
static const int degree[2] = {2, 1}, count[2] = {4, 3};
static const double knots_u[] = {0, 0, 0, 1, 2, 2, 2}, knots_v[] = {-1, -1, 0, 3, 3};
static const double *const knots[2] = {knots_u, knots_v};

static kn_spline make(kn_ctx *ctx, bool rational)
{
    double coef[24];
    for (int i = 0; i < 24; i++) coef[i] = i < 12 ? i - 5 : 1 + i % 2;
    kn_spline s = {0};
    assert_int_equal(kn_spline_init(ctx, &s, 2, 2, rational, degree, count, knots, coef), KN_OK);
    return s;
}

static void sizes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = make(ctx, true), empty = {0};
    double lo, hi;
    assert_int_equal(kn_spline_count(&s), 12);
    assert_int_equal(kn_spline_count(&empty), 0);
    assert_int_equal(kn_spline_dim(&s), 1);
    assert_int_equal(kn_spline_spans(&s, 0), 2);
    assert_int_equal(kn_spline_spans(&s, 1), 2);
    kn_spline_domain(&s, 1, &lo, &hi);
    assert_true(lo == -1 && hi == 3);
    assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
    assert_int_equal(kn_spline_check(ctx, &empty), KN_OK);
    kn_spline_clear(ctx, &empty);
    kn_spline_clear(ctx, &s);
    assert_null(s.coef);
    test_ctx_end(ctx, &memory);
}

static void copies_and_swaps(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = make(ctx, false), t = {0}, empty = {0};
    assert_int_equal(kn_spline_copy(ctx, &t, &s), KN_OK);
    assert_ptr_not_equal(t.coef, s.coef);
    assert_memory_equal(t.coef, s.coef, 24 * sizeof *t.coef);
    assert_memory_equal(t.knots[1], knots_v, sizeof knots_v);
    assert_int_equal(kn_spline_copy(ctx, &t, &t), KN_OK); // onto itself
    assert_memory_equal(t.coef, s.coef, 24 * sizeof *t.coef);
    kn_spline_swap(&t, &empty);
    assert_int_equal(t.nvars, 0);
    assert_int_equal(empty.count[0], 4);
    assert_int_equal(kn_spline_copy(ctx, &empty, &t), KN_OK); // of an empty one
    assert_int_equal(empty.nvars, 0);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &t);
    kn_spline_clear(ctx, &empty);
    test_ctx_end(ctx, &memory);
}

static void zeros_by_default(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, degree, count, knots, NULL), KN_OK);
    for (int i = 0; i < 36; i++) assert_true(s.coef[i] == 0.0);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Fails with status and a message that contains word, and leaves *out alone.
static void refuse(kn_ctx *ctx, kn_status expected, const char *word, int nvars, int ncomp, bool rational, int p,
                   int n, const double *k)
{
    int ps[KN_MAX_VARS + 1], ns[KN_MAX_VARS + 1];
    const double *ks[KN_MAX_VARS + 1];
    for (int d = 0; d <= KN_MAX_VARS; d++) ps[d] = p, ns[d] = n, ks[d] = k;
    kn_spline out = {.nvars = -7};
    assert_int_equal(kn_spline_init(ctx, &out, nvars, ncomp, rational, ps, ns, ks, NULL), expected);
    assert_int_equal(out.nvars, -7);
    assert_int_equal(kn_ctx_error(ctx), expected);
    assert_non_null(strstr(kn_ctx_message(ctx), word));
    kn_ctx_clear_error(ctx);
}

static void init_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double good[] = {0, 0, 0, 1, 2, 2, 2};
    refuse(ctx, KN_EDOMAIN, "nvars 0", 0, 1, false, 2, 4, good);
    refuse(ctx, KN_ELIMIT, "nvars 9", 9, 1, false, 2, 4, good);
    refuse(ctx, KN_EDOMAIN, "ncomp 0", 1, 0, false, 2, 4, good);
    refuse(ctx, KN_EDOMAIN, "rational", 1, 1, true, 2, 4, good);
    refuse(ctx, KN_ELIMIT, "ncomp 65", 1, 65, false, 2, 4, good);
    refuse(ctx, KN_EDOMAIN, "degree -1", 1, 1, false, -1, 4, good);
    refuse(ctx, KN_EDOMAIN, "count 2", 1, 1, false, 2, 2, good);
    refuse(ctx, KN_ELIMIT, "degree 57", 1, 1, false, 57, 58, good);
    refuse(ctx, KN_ELIMIT, "coefficients", 1, 1, false, 2, 1 << 29, good);
    refuse(ctx, KN_ELIMIT, "coefficients", 4, 1, false, 2, 1 << 10, good);
    refuse(ctx, KN_EDOMAIN, "decrease", 1, 1, false, 1, 4, (double[]){0, 0, 2, 1, 3, 3});
    refuse(ctx, KN_EDOMAIN, "clamped", 1, 1, false, 1, 3, (double[]){0, 1, 2, 3, 3});
    refuse(ctx, KN_EDOMAIN, "clamped", 1, 1, false, 1, 3, (double[]){0, 0, 2, 3, 4});
    refuse(ctx, KN_EDOMAIN, "empty", 1, 1, false, 1, 2, (double[]){1, 1, 1, 1});
    refuse(ctx, KN_EDOMAIN, "degree + 1 times", 1, 1, false, 1, 5, (double[]){0, 0, 1, 1, 1, 2, 2});
    refuse(ctx, KN_EDOMAIN, "degree + 1 times", 1, 1, false, 1, 3, (double[]){0, 0, 0, 2, 2});
    refuse(ctx, KN_EDOMAIN, "finite", 1, 1, false, 1, 3, (double[]){0, 0, NAN, 2, 2});
    refuse(ctx, KN_EDOMAIN, "finite", 1, 1, false, 1, 2, (double[]){0, 0, INFINITY, INFINITY});
    refuse(ctx, KN_EDOMAIN, "finite", 1, 1, false, 1, 2, (double[]){-1.7e308, -1.7e308, 1.7e308, 1.7e308});
    test_ctx_end(ctx, &memory);
}

static void a_jump_is_legal(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double jump[] = {0, 0, 1, 1, 2, 2}, coef[] = {1, 2, 5, 7};
    const double *const ks[] = {jump};
    kn_spline s;
    double y;
    assert_int_equal(kn_spline_init(ctx, &s, 1, 1, false, (int[]){1}, (int[]){4}, ks, coef), KN_OK);
    assert_int_equal(kn_spline_eval(ctx, &y, &s, (double[]){1.0}), KN_OK);
    assert_true(y == 5); // the right-hand piece
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void check_finds(kn_ctx *ctx, const kn_spline *s, const char *word)
{
    assert_int_equal(kn_spline_check(ctx, s), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), word));
    kn_ctx_clear_error(ctx);
}

static void check_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = make(ctx, true);
    s.coef[3] = NAN;
    check_finds(ctx, &s, "control point 3: component 0");
    s.coef[3] = -INFINITY;
    check_finds(ctx, &s, "inf");
    s.coef[3] = 0;
    s.coef[14] = 0;
    check_finds(ctx, &s, "control point 2: weight 0");
    s.coef[14] = -1;
    check_finds(ctx, &s, "weight -1");
    s.coef[14] = 1;
    s.knots[1][2] = 4;
    check_finds(ctx, &s, "variable 1: knots decrease");
    s.knots[1][2] = 0;
    assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
    double *coef = s.coef;
    s.coef = NULL;
    check_finds(ctx, &s, "no coefficients");
    s.coef = coef;
    s.degree[0] = 57;
    s.count[0] = 60;
    assert_int_equal(kn_spline_check(ctx, &s), KN_ELIMIT);
    s.degree[0] = 2;
    s.count[0] = 4;
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void boxes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = make(ctx, false), empty = {0};
    double lo[2], hi[2];
    assert_int_equal(kn_spline_box(ctx, lo, hi, &s), KN_OK);
    assert_true(lo[0] == -5 && hi[0] == 6 && lo[1] == 1 && hi[1] == 2);
    s.rational = true; // weights 1, 2, 1, 2, ...: -5/1 .. 6/2 and 5/1
    assert_int_equal(kn_spline_box(ctx, lo, hi, &s), KN_OK);
    assert_true(lo[0] == -5 && hi[0] == 5);
    s.coef[12] = 0;
    assert_int_equal(kn_spline_box(ctx, lo, hi, &s), KN_EDOMAIN);
    assert_true(lo[0] == -5 && hi[0] == 5);
    assert_int_equal(kn_spline_box(ctx, lo, hi, &empty), KN_EDOMAIN);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes),         cmocka_unit_test(copies_and_swaps), cmocka_unit_test(zeros_by_default),
        cmocka_unit_test(init_failures), cmocka_unit_test(a_jump_is_legal),  cmocka_unit_test(check_failures),
        cmocka_unit_test(boxes),
    };
    return cmocka_run_group_tests_name("spline/life", tests, NULL, NULL);
}
