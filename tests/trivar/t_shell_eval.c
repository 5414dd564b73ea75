// SPDX-License-Identifier: Apache-2.0
// T, its Jacobian matrix and the bounds of its determinant.
#include "tests/support/surfaces.h"

#include <math.h>

static kn_shell *create(kn_ctx *ctx, const kn_spline *s)
{
    kn_shell_options o = {.normal_tol = 1e-4};
    kn_shell *shell = NULL;
    if (kn_shell_create(ctx, &shell, s, &o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return shell;
}

// T, T_u, T_v and n from the splines in long double.
static void direct_shell(long double t[3], long double j[9], const kn_shell *shell, double u, double v, double w)
{
    long double su[3], sv[3], cross[3], n[9];
    direct_surface(t, su, sv, cross, kn_shell_surface(shell), u, v);
    direct_spline(n, kn_shell_normal(shell), u, v);
    for (int c = 0; c < 3; c++) {
        t[c] += w * n[c];
        j[3 * c] = su[c] + w * n[3 + c];
        j[3 * c + 1] = sv[c] + w * n[6 + c];
        j[3 * c + 2] = n[c];
    }
}

static long double determinant(const long double j[9])
{
    return j[0] * (j[4] * j[8] - j[5] * j[7]) - j[1] * (j[3] * j[8] - j[5] * j[6]) +
           j[2] * (j[3] * j[7] - j[4] * j[6]);
}

static void values_and_jacobian(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    for (int k = 0; k < SURFACE_CASES; k++) {
        kn_spline s;
        surface_cases[k].make(ctx, &s);
        kn_shell *shell = create(ctx, &s);
        double lo[2], hi[2];
        for (int v = 0; v < 2; v++) kn_spline_domain(&s, v, &lo[v], &hi[v]);
        for (int i = 0; i < test_scale(100); i++) {
            double at[2] = {test_uniform(&rng, lo[0], hi[0]), test_uniform(&rng, lo[1], hi[1])}, p[3], q[3], j[9];
            double w = test_uniform(&rng, -1, 1);
            long double t[3], d[9];
            assert_int_equal(kn_shell_eval(ctx, p, j, shell, at[0], at[1], w), KN_OK);
            direct_shell(t, d, shell, at[0], at[1], w);
            // 100 roundings of numbers below 10; derivatives of n on spans of 1/16 and degree 5: below 1000
            for (int c = 0; c < 3; c++) assert_true(fabsl(p[c] - t[c]) < 1e-12L);
            for (int c = 0; c < 9; c++) assert_true(fabsl(j[c] - d[c]) < 1e-10L);
            assert_int_equal(kn_shell_eval(ctx, p, NULL, shell, at[0], at[1], 0.0), KN_OK);
            assert_int_equal(kn_spline_eval(ctx, q, &s, at), KN_OK);
            assert_true(test_max_difference(p, q, 3) < 1e-13); // T(u,v,0) = S(u,v)
        }
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// The columns of the Jacobian against central differences: h^2 / 6 of a third derivative, and 1e-15 / h of rounding.
static void jacobian_against_differences(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_torus(ctx, &s);
    kn_shell *shell = create(ctx, &s);
    const double x[3] = {0.3, 2.2, 0.25}, h = 1e-5;
    double j[9], p[3], a[3], b[3];
    assert_int_equal(kn_shell_eval(ctx, p, j, shell, x[0], x[1], x[2]), KN_OK);
    for (int d = 0; d < 3; d++) {
        double y[3] = {x[0], x[1], x[2]}, z[3] = {x[0], x[1], x[2]};
        y[d] -= h, z[d] += h;
        assert_int_equal(kn_shell_eval(ctx, a, NULL, shell, y[0], y[1], y[2]), KN_OK);
        assert_int_equal(kn_shell_eval(ctx, b, NULL, shell, z[0], z[1], z[2]), KN_OK);
        for (int c = 0; c < 3; c++) assert_true(fabs(j[3 * c + d] - (b[c] - a[c]) / (2 * h)) < 1e-7);
    }
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// The derivatives of n may jump at a knot: just before it, or at it.
static double side(double lo, double hi, int twelfth, bool before)
{
    double x = lo + (hi - lo) * twelfth / 12.0;
    return before ? fmax(lo, x - 1e-9) : x;
}

// Every sample inside; and the bounds near: within a tenth of the range of samples.
static void bounds_hold(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(6);
    for (int k = 0; k < SURFACE_CASES; k++) {
        kn_spline s;
        surface_cases[k].make(ctx, &s);
        kn_shell *shell = create(ctx, &s);
        double lo[2], hi[2], least, most;
        long double t[3], d[9], below = INFINITY, above = -INFINITY;
        const double w0 = -0.25, w1 = 0.5;
        for (int v = 0; v < 2; v++) kn_spline_domain(&s, v, &lo[v], &hi[v]);
        assert_int_equal(kn_shell_jacobian_bounds(ctx, &least, &most, shell, w0, w1), KN_OK);
        const int grid = 13 * 13 * 8; // twelfths of the domain, knots among them, from both sides, at both heights
        for (int i = 0; i < grid + test_scale(1000); i++) {
            double u = test_uniform(&rng, lo[0], hi[0]), v = test_uniform(&rng, lo[1], hi[1]);
            double w = test_uniform(&rng, w0, w1);
            if (i < grid) {
                u = side(lo[0], hi[0], i / 8 % 13, i & 1);
                v = side(lo[1], hi[1], i / 8 / 13, i & 2);
                w = i & 4 ? w0 : w1;
            }
            direct_shell(t, d, shell, u, v, w);
            long double det = determinant(d);
            if (!(det >= least && det <= most))
                fail_msg("%s: %Lg outside [%g, %g]", surface_cases[k].name, det, least, most);
            below = fminl(below, det), above = fmaxl(above, det);
        }
        long double slack = 0.1L * (above - below) + 1e-10L;
        if (!(below - least < slack && most - above < slack))
            fail_msg("%s: [%g, %g] but samples in [%Lg, %Lg]", surface_cases[k].name, least, most, below, above);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// Of a plane it is the area of the parallelogram, of a sphere of radius 2 it is J0 (1 + w/2)^2.
static void bounds_of_simple_shapes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    double lo, hi, flat_lo, flat_hi;
    make_plane(ctx, &s);
    kn_shell *shell = create(ctx, &s);
    assert_int_equal(kn_shell_jacobian_bounds(ctx, &lo, &hi, shell, -1, 2), KN_OK);
    assert_true(lo <= 6 && lo > 6 - 1e-10 && hi >= 6 && hi < 6 + 1e-10); // 2 x 3, rounding alone
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);

    make_sphere(ctx, &s);
    shell = create(ctx, &s);
    assert_int_equal(kn_shell_jacobian_bounds(ctx, &flat_lo, &flat_hi, shell, 0, 0), KN_OK);
    assert_true(flat_lo <= 0 && flat_lo > -1e-8); // the poles: zero but for rounding
    assert_int_equal(kn_shell_jacobian_bounds(ctx, &lo, &hi, shell, 2, 2), KN_OK);
    assert_true(hi > 0.9 * 4 * flat_hi && hi < 1.1 * 4 * flat_hi);
    assert_int_equal(kn_shell_jacobian_bounds(ctx, &lo, &hi, shell, -4, -3), KN_OK); // beyond the centre
    assert_true(hi > 0.9 * flat_hi && hi < 1.1 * flat_hi);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Where determinants over- or underflow nothing is known of them, and no sign is claimed.
static void bounds_out_of_range(void **state)
{
    (void)state;
    static const int exponents[] = {520, -480};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (size_t k = 0; k < sizeof exponents / sizeof *exponents; k++) {
        kn_spline s = {0};
        double lo = 1, hi = 0;
        make_wavy(ctx, &s);
        for (size_t i = 0; i < 3 * kn_spline_count(&s); i++) s.coef[i] = ldexp(s.coef[i], exponents[k]);
        kn_shell *shell = create(ctx, &s);
        assert_int_equal(kn_shell_jacobian_bounds(ctx, &lo, &hi, shell, 0, 0), KN_OK);
        assert_true(lo == -INFINITY && hi == INFINITY);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

static void bad_arguments(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_plane(ctx, &s);
    kn_shell *shell = create(ctx, &s);
    double p[3] = {7, 7, 7}, j[9] = {7}, lo = 7, hi = 7;
    assert_int_equal(kn_shell_eval(ctx, p, j, shell, NAN, 0, 0), KN_EDOMAIN);
    assert_int_equal(kn_shell_eval(ctx, p, j, shell, 0, 0, INFINITY), KN_EDOMAIN);
    assert_int_equal(kn_shell_unit_normal(ctx, p, shell, 0, NAN), KN_EDOMAIN);
    assert_int_equal(kn_shell_jacobian_bounds(ctx, &lo, &hi, shell, 1, 0), KN_EDOMAIN);
    assert_int_equal(kn_shell_jacobian_bounds(ctx, &lo, &hi, shell, NAN, 0), KN_EDOMAIN);
    assert_int_equal(kn_shell_jacobian_bounds(ctx, &lo, &hi, shell, 0, INFINITY), KN_EDOMAIN);
    assert_true(p[0] == 7 && p[2] == 7 && j[0] == 7 && lo == 7 && hi == 7);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

typedef struct held {
    kn_shell *shell; // made in another context; only read
} held;

static kn_status evaluate(kn_ctx *ctx, void *user)
{
    const held *h = user;
    double p[3], j[9], lo = 7, hi = 7;
    kn_status status = kn_shell_eval(ctx, p, j, h->shell, 0.5, 0.5, 0.1);
    if (status == KN_OK) status = kn_shell_jacobian_bounds(ctx, &lo, &hi, h->shell, 0.0, 0.1);
    if (status != KN_OK) assert_true(lo == 7 && hi == 7);
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
    assert_int_equal(kn_shell_create(ctx, &h.shell, &s, &o), KN_OK);
    test_allocation_failures(evaluate, &h);
    kn_shell_destroy(ctx, h.shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_and_jacobian),
        cmocka_unit_test(jacobian_against_differences),
        cmocka_unit_test(bounds_hold),
        cmocka_unit_test(bounds_out_of_range),
        cmocka_unit_test(bounds_of_simple_shapes),
        cmocka_unit_test(bad_arguments),
        cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests_name("trivar/shell_eval", tests, NULL, NULL);
}
