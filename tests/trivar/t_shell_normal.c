// SPDX-License-Identifier: Apache-2.0
// The fitted normal and its certificate against direct evaluation in long double.
#include "tests/support/surfaces.h"

#include <math.h>
#include <stdio.h>

static kn_shell *create(kn_ctx *ctx, const kn_spline *s, double tol)
{
    kn_shell_options o = kn_shell_defaults();
    o.normal_tol = tol;
    kn_shell *shell = NULL;
    if (kn_shell_create(ctx, &shell, s, &o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return shell;
}

// Never above the bound at any sample, and the bound not above 10 times the worst sample: what is left over is the
// distance of samples from the true maximum. 1e-12 allows for bounds that are rounding alone.
static void check_certificate(const char *name, const kn_shell *shell, double tol, test_rng *rng, int samples)
{
    kn_normal_certificate c = kn_shell_certificate(shell);
    const kn_spline *n = kn_shell_normal(shell);
    double lo[2], hi[2];
    long double length, angle, worst_length = 0, worst_angle = 0;
    for (int v = 0; v < 2; v++) kn_spline_domain(n, v, &lo[v], &hi[v]);
    assert_true(c.certified && c.length_error <= tol && c.angle_error <= tol);
    for (int i = 0; i < samples; i++) {
        double u = test_uniform(rng, lo[0], hi[0]), v = test_uniform(rng, lo[1], hi[1]);
        if (!direct_errors(&length, &angle, shell, u, v)) continue;
        if (!(length <= c.length_error && angle <= c.angle_error))
            fail_msg("%s: at (%.17g, %.17g) length %Lg above %g or angle %Lg above %g", name, u, v, length,
                     c.length_error, angle, c.angle_error);
        worst_length = fmaxl(worst_length, length);
        worst_angle = fmaxl(worst_angle, angle);
    }
    if (!(c.length_error <= 10 * worst_length + 1e-12L && c.angle_error <= 10 * worst_angle + 1e-12L))
        fail_msg("%s: certificate %g, %g but no sample above %Lg, %Lg", name, c.length_error, c.angle_error,
                 worst_length, worst_angle);
}

static void certificates_hold(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int k = 0; k < SURFACE_CASES; k++)
        for (double tol = 1e-5; tol > (test_scale(1) > 1 ? 1e-9 : 1e-6); tol *= 1e-2) {
            kn_spline s;
            surface_cases[k].make(ctx, &s);
            kn_shell *shell = create(ctx, &s, tol);
            check_certificate(surface_cases[k].name, shell, tol, &rng, test_scale(2000));
            kn_shell_destroy(ctx, shell);
            kn_spline_clear(ctx, &s);
        }
    test_ctx_end(ctx, &memory);
}

static void teapot_certificates_hold(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    bool found = true;
    for (int k = 0; k < TEAPOT_PATCHES && found; k += test_scale(1) > 1 ? 1 : 5) {
        kn_spline s;
        char name[32];
        found = make_teapot(ctx, &s, k);
        if (!found) break;
        snprintf(name, sizeof name, "teapot patch %d", k);
        kn_shell *shell = create(ctx, &s, 1e-6);
        check_certificate(name, shell, 1e-6, &rng, test_scale(2000));
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
    if (!found) skip();
}

// A loose tolerance leaves what is asked for: degree 3 at least, the knots of S, C2 where S is C3 or smoother.
static void knots_and_continuity(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int k = 0; k < SURFACE_CASES; k++) {
        kn_spline s;
        surface_cases[k].make(ctx, &s);
        kn_shell *shell = create(ctx, &s, 1e-4);
        const kn_spline *n = kn_shell_normal(shell);
        for (int v = 0; v < 2; v++) {
            int total = n->count[v] + n->degree[v] + 1, p = n->degree[v];
            assert_in_range(p, 3, 5);
            for (int i = p + 1; i < n->count[v]; i++) {
                int times = 0, of_s = 0;
                for (int j = 0; j < total; j++) times += n->knots[v][j] == n->knots[v][i];
                for (int j = 0; j < s.count[v] + s.degree[v] + 1; j++) of_s += s.knots[v][j] == n->knots[v][i];
                int smooth = of_s > 0 ? s.degree[v] - of_s - 1 : p - 1;    // of n
                smooth = smooth < 0 ? 0 : smooth > p - 1 ? p - 1 : smooth; // rational arcs are joined C0
                assert_int_equal(times, p - smooth);
            }
            for (int j = s.degree[v] + 1; j < s.count[v]; j++) {
                bool there = false;
                for (int i = 0; i < total; i++) there = there || n->knots[v][i] == s.knots[v][j];
                assert_true(there);
            }
        }
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// The true normal of a sphere is the point over the radius, up to its sign; at the poles as well.
static void sphere_normal_is_radial(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    make_sphere(ctx, &s);
    kn_shell *shell = create(ctx, &s, 1e-6);
    for (int i = 0; i <= 16; i++)
        for (int j = 0; j <= 16; j++) {
            double at[2] = {0.25 * i, 0.125 * j}, p[3], n[3];
            assert_int_equal(kn_spline_eval(ctx, p, &s, at), KN_OK);
            assert_int_equal(kn_shell_unit_normal(ctx, n, shell, at[0], at[1]), KN_OK);
            // degree (5,5) in coefficients below 8 : a few hundred roundings, amplified by 1/|N| <= 4
            for (int c = 0; c < 3; c++) assert_true(fabs(n[c] - 0.5 * p[c]) < 1e-13);
        }
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// At a pole: finite, of length 1, one vector all along the edge, and continuous towards it.
static void poles_are_quiet(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    bool found = make_teapot(ctx, &s, 20); // the knob of the lid: v = 0 is its top
    if (found) {
        kn_shell *shell = create(ctx, &s, 1e-6);
        double top[3], p[3], before[3];
        assert_int_equal(kn_shell_eval(ctx, top, NULL, shell, 0.0, 0.0, 1.0), KN_OK);
        for (int i = 0; i <= 20; i++) {
            double u = i / 20.0, n[3];
            assert_int_equal(kn_shell_eval(ctx, p, NULL, shell, u, 0.0, 1.0), KN_OK);
            assert_true(test_max_difference(p, top, 3) < 1e-14); // convex combinations of equal numbers near 3
            assert_int_equal(kn_shell_unit_normal(ctx, n, shell, u, 0.0), KN_OK);
            assert_true(fabs(n[0]) < 1e-14 && fabs(n[1]) < 1e-14 && fabs(fabs(n[2]) - 1.0) < 1e-14);
            for (int k = 0; k < 3; k++) before[k] = p[k];
            for (int j = 1; j <= 200; j++) { // steps of a knob of size 0.8 that is 0.7 high
                assert_int_equal(kn_shell_eval(ctx, p, NULL, shell, u, j / 200.0, 1.0), KN_OK);
                assert_true(test_max_difference(p, before, 3) < 0.2);
                for (int k = 0; k < 3; k++) before[k] = p[k];
            }
        }
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
    if (!found) skip();
}

// Patches 0 and 1 share the edge u = 1 / u = 0 and their normals there, and by symmetry their knots along it.
static void shared_edges_get_the_same_normals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline a, b;
    bool found = make_teapot(ctx, &a, 4) && make_teapot(ctx, &b, 5);
    if (found) {
        kn_shell *sa = create(ctx, &a, 1e-6), *sb = create(ctx, &b, 1e-6);
        const kn_spline *na = kn_shell_normal(sa), *nb = kn_shell_normal(sb);
        assert_int_equal(na->count[1], nb->count[1]);
        size_t count_a = kn_spline_count(na), count_b = kn_spline_count(nb), row = (size_t)na->count[1];
        for (size_t c = 0; c < 3; c++)
            for (size_t j = 0; j < row; j++) { // 64 ulps: evaluation of degree 5 and a solve of condition below 20
                double x = na->coef[c * count_a + count_a - row + j], y = nb->coef[c * count_b + j];
                assert_true(fabs(x - y) <= 64 * 0x1p-52);
            }
        kn_shell_destroy(ctx, sa);
        kn_shell_destroy(ctx, sb);
        kn_spline_clear(ctx, &a);
        kn_spline_clear(ctx, &b);
    }
    test_ctx_end(ctx, &memory);
    if (!found) skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(certificates_hold),    cmocka_unit_test(teapot_certificates_hold),
        cmocka_unit_test(knots_and_continuity), cmocka_unit_test(sphere_normal_is_radial),
        cmocka_unit_test(poles_are_quiet),      cmocka_unit_test(shared_edges_get_the_same_normals),
    };
    return cmocka_run_group_tests_name("trivar/shell_normal", tests, NULL, NULL);
}
