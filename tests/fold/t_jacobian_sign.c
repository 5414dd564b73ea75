// SPDX-License-Identifier: Apache-2.0
// The certified sign of the Jacobian over boxes: closed forms, samples, witnesses.
#include "tests/support/kinds.h"

#include <knurl/construct.h>
#include <knurl/fold.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

static kn_shell *create(kn_ctx *ctx, const kn_spline *s, const kn_shell_options *o)
{
    kn_shell *shell = NULL;
    if (kn_shell_create(ctx, &shell, s, o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return shell;
}

static kn_fold_sign sign_of(kn_ctx *ctx, const kn_shell *shell, double u0, double u1, double v0, double v1, double w0,
                            double w1)
{
    const double lo[3] = {u0, v0, w0}, hi[3] = {u1, v1, w1};
    kn_fold_sign sign;
    if (kn_fold_jacobian_sign(ctx, &sign, shell, lo, hi) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return sign;
}

static kn_fold_sign over_heights(kn_ctx *ctx, const kn_shell *shell, double w0, double w1)
{
    double lo[2], hi[2];
    for (int v = 0; v < 2; v++) kn_spline_domain(kn_shell_surface(shell), v, &lo[v], &hi[v]);
    return sign_of(ctx, shell, lo[0], hi[0], lo[1], hi[1], w0, w1);
}

static long double determinant(const long double j[9])
{
    return j[0] * (j[4] * j[8] - j[5] * j[7]) - j[1] * (j[3] * j[8] - j[5] * j[6]) +
           j[2] * (j[3] * j[7] - j[4] * j[6]);
}

// ---- closed forms ----

// J / J0 = (1 + w / 0.8) (1 + w cos / (3 + 0.8 cos)), cos that of the tube's angle.
static void torus(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double center[3] = {0, 0, 0}, axis[3] = {0, 0, 1};
    kn_spline s = {0};
    assert_int_equal(kn_construct_torus(ctx, &s, center, axis, 3.0, 0.8), KN_OK);
    kn_shell_options o = {.normal_tol = 1e-4};
    kn_shell *shell = create(ctx, &s, &o);
    assert_int_equal(over_heights(ctx, shell, -0.79, 2.19).verdict, KN_FOLD_POSITIVE);
    assert_int_equal(over_heights(ctx, shell, 0.0, 2.21).verdict, KN_FOLD_MIXED);
    assert_int_equal(over_heights(ctx, shell, -0.81, 0.0).verdict, KN_FOLD_MIXED);
    assert_int_equal(over_heights(ctx, shell, -2.0, -0.81).verdict, KN_FOLD_NEGATIVE);
    assert_int_equal(over_heights(ctx, shell, -100.0, 100.0).verdict, KN_FOLD_MIXED);
    // The outer half (v in [0, 1/4]) never folds above; the inner half does, at 2.2 around v = 1/2.
    assert_int_equal(sign_of(ctx, shell, 0, 1, 0.0, 0.25, 0.0, 50.0).verdict, KN_FOLD_POSITIVE);
    kn_fold_sign sign = sign_of(ctx, shell, 0.1, 0.3, 0.45, 0.55, 0.0, 2.3);
    assert_int_equal(sign.verdict, KN_FOLD_MIXED);
    assert_true(sign.value < 0.0 && fabs(sign.where[1] - 0.5) <= 0.05 && sign.where[2] > 2.2);
    assert_true(sign.where[0] >= 0.1 && sign.where[0] <= 0.3 && sign.lo <= sign.value);
    assert_int_equal(sign_of(ctx, shell, 0.1, 0.3, 0.45, 0.55, 2.4, 2.5).verdict, KN_FOLD_NEGATIVE);
    // A point, and boxes that reach beyond the domain.
    assert_int_equal(sign_of(ctx, shell, 0.5, 0.5, 0.5, 0.5, 2.0, 2.0).verdict, KN_FOLD_POSITIVE);
    assert_int_equal(sign_of(ctx, shell, 0.5, 0.5, 0.5, 0.5, 2.3, 2.3).verdict, KN_FOLD_NEGATIVE);
    assert_int_equal(sign_of(ctx, shell, -1.0, 0.5, 0.5, 7.0, 0.0, 1.0).verdict, KN_FOLD_POSITIVE);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Poles do not hide the sign; beyond its centre a sphere is turned inside out twice: positive again.
static void sphere(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double center[3] = {5, 6, 7};
    kn_spline s = {0};
    assert_int_equal(kn_construct_sphere(ctx, &s, center, 2.0), KN_OK);
    kn_shell_options o = {.normal_tol = 1e-5};
    kn_shell *shell = create(ctx, &s, &o);
    kn_fold_sign sign = over_heights(ctx, shell, -1.9, 10.0);
    assert_int_equal(sign.verdict, KN_FOLD_POSITIVE);
    assert_true(sign.lo <= 0.0 && sign.lo > -1e-6 && sign.value >= 0.0); // 0 at the poles
    assert_int_equal(over_heights(ctx, shell, -4.0, -2.1).verdict, KN_FOLD_POSITIVE);
    // Across the centre J touches 0, up to what the fit makes of it: no certificate.
    kn_fold_verdict verdict = over_heights(ctx, shell, -3.0, 0.0).verdict;
    assert_true(verdict == KN_FOLD_UNDECIDED || verdict == KN_FOLD_MIXED);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// A cone's apex: J is 0 at w = 0 alone; above it is positive, below it folds at once.
static void apex(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double base[3] = {0, 0, 0}, axis[3] = {0, 0, 1};
    kn_spline s = {0};
    assert_int_equal(kn_construct_cone(ctx, &s, base, axis, 1.0, 0.0), KN_OK);
    kn_shell_options o = {.normal_tol = 1e-5};
    kn_shell *shell = create(ctx, &s, &o);
    assert_int_equal(over_heights(ctx, shell, 0.0, 2.0).verdict, KN_FOLD_POSITIVE);
    assert_int_equal(over_heights(ctx, shell, 1.0, 2.0).verdict, KN_FOLD_POSITIVE);
    assert_int_equal(over_heights(ctx, shell, -0.01, 1.0).verdict, KN_FOLD_MIXED);
    // Away from the apex there is room below: 0.5 from it the radius of curvature is 0.5 sqrt 2 / 2 tan 45.
    assert_int_equal(sign_of(ctx, shell, 0.0, 1.0, 0.0, 0.5, -0.5, 1.0).verdict, KN_FOLD_POSITIVE);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void teapot(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_shell_options o = {.normal_tol = 1e-3};
    for (int k = 0; k < TEAPOT_PATCHES; k++) {
        kn_spline s;
        if (!make_teapot(ctx, &s, k)) skip();
        kn_shell *shell = create(ctx, &s, &o);
        assert_int_equal(over_heights(ctx, shell, -0.002, 0.015).verdict, KN_FOLD_POSITIVE);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// ---- samples ----

// Random boxes: no sample contradicts a verdict, bounds hold, witnesses are what they say, and most are decided.
static void random_boxes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(60);
    int count[4] = {0};
    for (int k = 0; k < test_scale(24); k++) {
        kn_spline s, h, psi;
        surface_cases[k % SURFACE_CASES].make(ctx, &s);
        make_field(ctx, &h, &rng, &s, 1, 1, 1.0, 0.2);
        make_field(ctx, &psi, &rng, &s, 1, 3, 0.0, 0.1);
        kn_shell_options o = {.normal_tol = 1e-3};
        if (k % 2) o.thickness = &h;
        if (k % 3 == 2) o.attraction = &psi;
        kn_shell *shell = create(ctx, &s, &o);
        for (int i = 0; i < 4; i++) {
            double lo[3], hi[3];
            for (int v = 0; v < 2; v++) {
                double a, b;
                kn_spline_domain(&s, v, &a, &b);
                lo[v] = test_uniform(&rng, a, b - 0.1 * (b - a));
                hi[v] = fmin(b, lo[v] + test_uniform(&rng, 0.05, 0.5) * (b - a));
            }
            lo[2] = test_uniform(&rng, -1.5, 1.0), hi[2] = lo[2] + test_uniform(&rng, 0.0, 0.7);
            kn_fold_sign sign;
            assert_int_equal(kn_fold_jacobian_sign(ctx, &sign, shell, lo, hi), KN_OK);
            count[sign.verdict]++;
            for (int n = 0; n < 40; n++) {
                double at[3];
                long double t[3], j[9];
                for (int v = 0; v < 3; v++)
                    at[v] = n < 8 ? (n >> v & 1 ? hi[v] : lo[v]) : test_uniform(&rng, lo[v], hi[v]);
                direct_kind(t, j, shell, &o, at[0], at[1], at[2]);
                long double det = determinant(j), slack = 1e-9L; // at corners of boxes, where n may jump, and poles
                if (n < 8) continue;
                assert_true(det >= sign.lo && det <= sign.hi);
                if (sign.verdict == KN_FOLD_POSITIVE) assert_true(det > -slack);
                if (sign.verdict == KN_FOLD_NEGATIVE) assert_true(det < slack);
            }
            assert_true(sign.lo <= sign.value && sign.value <= sign.hi);
            if (sign.verdict == KN_FOLD_MIXED) {
                assert_true(sign.value < 0.0);
                for (int v = 0; v < 3; v++) assert_true(sign.where[v] >= lo[v] && sign.where[v] <= hi[v]);
            }
        }
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &h);
        kn_spline_clear(ctx, &psi);
    }
    assert_true(count[KN_FOLD_POSITIVE] > 0 && count[KN_FOLD_NEGATIVE] > 0 && count[KN_FOLD_MIXED] > 0);
    assert_true(count[KN_FOLD_UNDECIDED] <= test_scale(1));
    test_ctx_end(ctx, &memory);
}

// A unit square with psi = (u - 1/2, 0, 0) w^k: det = 1 + w^k, over all heights up to 1000, from 1 up to 1e36.
static void great_heights(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double k[4] = {0, 0, 1, 1}, plane[12] = {0, 0, 1, 1, 0, 1, 0, 1}, field[12] = {-0.5, -0.5, 0.5, 0.5};
    const double *knots[2] = {k, k};
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    for (int power = 1; power <= 12; power++) {
        kn_spline s = {0}, psi = {0};
        assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, degree, count, knots, plane), KN_OK);
        assert_int_equal(kn_spline_init(ctx, &psi, 2, 3, false, degree, count, knots, field), KN_OK);
        kn_shell_options o = {.attraction = &psi, .attraction_power = power};
        kn_shell *shell = create(ctx, &s, &o);
        kn_fold_sign sign = over_heights(ctx, shell, 0.0, 1000.0);
        assert_int_equal(sign.verdict, KN_FOLD_POSITIVE);
        assert_true(fabs(sign.value - 1.0) < 1e-12 && sign.hi >= pow(1000.0, power) * (1.0 - 1e-12));
        // Below: for odd powers det has a zero at -1, and all is decided on its far side.
        assert_int_equal(over_heights(ctx, shell, -1000.0, -1.01).verdict,
                         power % 2 ? KN_FOLD_NEGATIVE : KN_FOLD_POSITIVE);
        assert_int_equal(over_heights(ctx, shell, -1.5, 1000.0).verdict,
                         power % 2 ? KN_FOLD_MIXED : KN_FOLD_POSITIVE);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &psi);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// Volumes: (u, v, w - w^2 / 2) has det 1 - w; in several spans of w.
static void volume(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double k[4] = {0, 0, 1, 1}, kw[6] = {0, 0, 0, 2, 2, 2}, height[3] = {0, 1, 0}, more[2] = {0.5, 1.5};
    const double *knots[3] = {k, k, kw};
    const int degree[3] = {1, 1, 2}, count[3] = {2, 2, 3};
    double coef[36];
    for (int i = 0; i < 12; i++) coef[i] = i / 6, coef[12 + i] = i / 3 % 2, coef[24 + i] = height[i % 3];
    for (int round = 0; round < 2; round++) {
        kn_spline s = {0};
        kn_shell *shell = NULL;
        assert_int_equal(kn_spline_init(ctx, &s, 3, 3, false, degree, count, knots, coef), KN_OK);
        if (round == 1) assert_int_equal(kn_spline_insert_knots(ctx, &s, &s, 2, more, 2), KN_OK);
        assert_int_equal(kn_shell_from_volume(ctx, &shell, &s, NULL), KN_OK);
        kn_fold_sign sign = over_heights(ctx, shell, 0.0, 0.99);
        assert_int_equal(sign.verdict, KN_FOLD_POSITIVE);
        assert_true(sign.lo > 0.0 && sign.lo <= 0.01 && sign.hi >= 1.0 && sign.hi < 1.05);
        assert_int_equal(over_heights(ctx, shell, 1.01, 2.0).verdict, KN_FOLD_NEGATIVE);
        assert_int_equal(over_heights(ctx, shell, 0.5, 1.7).verdict, KN_FOLD_MIXED);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// ---- failures ----

static void bad_arguments(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_plane(ctx, &s);
    kn_shell *shell = create(ctx, &s, NULL);
    kn_fold_sign sign = {.value = 7};
    static const double boxes[5][6] = {{0, 0, 1, 1, 1, 0},
                                       {0.5, 0, 0, 0.4, 1, 1},
                                       {0, 2, 0, 1, 3, 1},
                                       {0, 0, NAN, 1, 1, 1},
                                       {0, 0, 0, 1, 1, INFINITY}};
    for (int k = 0; k < 5; k++) {
        assert_int_equal(kn_fold_jacobian_sign(ctx, &sign, shell, boxes[k], boxes[k] + 3), KN_EDOMAIN);
        assert_true(sign.value == 7);
    }
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

typedef struct held {
    kn_shell *shell;
} held;

static kn_status compute(kn_ctx *ctx, void *user)
{
    const held *h = user;
    const double lo[3] = {0.1, 0.1, 0.0}, hi[3] = {0.4, 0.4, 0.1};
    kn_fold_sign sign = {.value = 7};
    kn_status status = kn_fold_jacobian_sign(ctx, &sign, h->shell, lo, hi);
    if (status != KN_OK) assert_true(sign.value == 7);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    held h = {0};
    make_cylinder(ctx, &s);
    kn_shell_options o = {.normal_tol = 0.05};
    h.shell = create(ctx, &s, &o);
    test_allocation_failures(compute, &h);
    kn_shell_destroy(ctx, h.shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(torus),  cmocka_unit_test(sphere),        cmocka_unit_test(apex),
        cmocka_unit_test(teapot), cmocka_unit_test(random_boxes),  cmocka_unit_test(great_heights),
        cmocka_unit_test(volume), cmocka_unit_test(bad_arguments), cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests_name("fold/jacobian_sign", tests, NULL, NULL);
}
