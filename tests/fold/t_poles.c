// SPDX-License-Identifier: Apache-2.0
// Around a pole a normal of exact direction does as well as a fitted one: J keeps its sign, heights agree, T does not
// meet itself, and places on the axis of the pole are found, one and certified.
#include "tests/support/surfaces.h"

#include <knurl/fold.h>

#include <math.h>

static kn_shell *create(kn_ctx *ctx, const kn_spline *s, kn_normal_method method)
{
    kn_shell *shell = NULL;
    kn_shell_options o = {.normal = method, .normal_tol = 1e-3};
    if (kn_shell_create(ctx, &shell, s, &o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return shell;
}

static double smaller(double a, double b)
{
    return a < b ? a : b;
}

// Both heights are within 1 % below one truth, and n's derivatives, 1e-3 over spans of 1/8 or so, move that by 1 % more.
static void expect_alike(double a, double b)
{
    if (!(fabs(smaller(a, 50.0) - smaller(b, 50.0)) <= 0.02 * smaller(smaller(a, b), 50.0)))
        fail_msg("heights %g and %g", a, b);
}

// w: heights for which the shell of exact direction is sound.
static void expect_sound(kn_ctx *ctx, const kn_spline *s, const double w[2])
{
    kn_fold_heights h[2];
    kn_fold_sign sign;
    kn_fold_intersection met;
    double lo[3] = {0.0, 0.0, w[0]}, hi[3] = {0.0, 0.0, w[1]};
    for (int v = 0; v < 2; v++) kn_spline_domain(s, v, &lo[v], &hi[v]);
    for (int m = 0; m < 2; m++) {
        kn_shell *shell = create(ctx, s, m == 0 ? KN_NORMAL_FITTED : KN_NORMAL_EXACT_DIRECTION);
        const kn_shell *const list[1] = {shell};
        const kn_fold_options o = {.work = 60000};
        assert_int_equal(kn_fold_safe_heights(ctx, NULL, &h[m], shell), KN_OK);
        assert_int_equal(kn_fold_jacobian_sign(ctx, &sign, shell, lo, hi), KN_OK);
        assert_int_equal(sign.verdict, KN_FOLD_POSITIVE);
        if (m == 1) {
            assert_int_equal(kn_fold_self_intersection(ctx, &met, list, 1, NULL, 0, w, &o), KN_OK);
            assert_int_equal(met.verdict, KN_FOLD_NONE);
        }
        kn_shell_destroy(ctx, shell);
    }
    expect_alike(h[0].above, h[1].above);
    expect_alike(h[0].below, h[1].below);
}

static void dome(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_dome(ctx, &s);
    expect_sound(ctx, &s, (const double[2]){-0.2, 0.2});
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void sphere(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_sphere(ctx, &s);
    expect_sound(ctx, &s, (const double[2]){-0.05, 0.05});
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// A quarter of the lid (poles at the knob) and of the bottom.
static void teapot(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int patch[2] = {20, 28};
    for (int k = 0; k < 2; k++) {
        kn_spline s;
        if (!make_teapot(ctx, &s, patch[k])) skip();
        expect_sound(ctx, &s, (const double[2]){-0.01, 0.01});
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// The point at height w over the pole (0,0,z) with normal (0,0,up).
static void expect_on_axis(kn_ctx *ctx, const kn_shell_inverse *inverse, double z, double up, double w, double v)
{
    const double p[3] = {0.0, 0.0, z + up * w};
    kn_support *found = NULL;
    kn_side side;
    size_t n = 0;
    bool complete = false;
    if (kn_shell_support(ctx, &found, &n, &complete, inverse, p) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    assert_true(complete && n == 1 && found[0].certified);
    assert_true(fabs(found[0].uvw[2] - w) <=
                found[0].error[2] + 1e-12); // n is the unit normal there, but for rounding
    assert_true(fabs(found[0].uvw[1] - v) <= found[0].error[1] + 1e-12);
    kn_free(ctx, found);
    assert_int_equal(kn_shell_side(ctx, &side, inverse, p), KN_OK);
    assert_int_equal(side, w > 0.0 ? KN_SIDE_ABOVE : w < 0.0 ? KN_SIDE_BELOW : KN_SIDE_ON);
}

static void axis(void **state)
{
    (void)state;
    static const double heights[5] = {-0.3, -1e-3, 0.0, 0.05, 0.4};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int k = 0; k < 2; k++) {
        kn_spline s;
        kn_shell_inverse *inverse = NULL;
        double lo, hi;
        if (k == 0)
            make_dome(ctx, &s);
        else
            make_sphere(ctx, &s);
        kn_spline_domain(&s, 1, &lo, &hi);
        kn_shell *shell = create(ctx, &s, KN_NORMAL_EXACT_DIRECTION);
        assert_int_equal(kn_shell_inverse_create(ctx, &inverse, shell, -0.5, 0.5), KN_OK);
        for (int i = 0; i < 5; i++) {
            expect_on_axis(ctx, inverse, k == 0 ? 0.0 : -2.0, -1.0, heights[i], lo);
            if (k == 1) expect_on_axis(ctx, inverse, 2.0, 1.0, heights[i], hi);
        }
        kn_shell_inverse_destroy(ctx, inverse);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dome),
        cmocka_unit_test(sphere),
        cmocka_unit_test(teapot),
        cmocka_unit_test(axis),
    };
    return cmocka_run_group_tests_name("fold/poles", tests, NULL, NULL);
}
