// SPDX-License-Identifier: Apache-2.0
// T as one trivariate spline.
#include "tests/support/kinds.h"

#include <math.h>

static void check_volume(kn_ctx *ctx, const kn_shell *shell, const kn_spline *v, const double w[2], test_rng *rng)
{
    for (int i = 0; i < test_scale(20); i++) {
        double p[3];
        long double at[3], t[3];
        for (int d = 0; d < 3; d++) {
            double lo, hi;
            kn_spline_domain(v, d, &lo, &hi);
            if (d == 2) assert_true(lo == w[0] && hi == w[1]);
            at[d] = test_uniform(rng, lo, hi);
        }
        direct_volume(t, v, at);
        assert_int_equal(kn_shell_eval(ctx, p, NULL, shell, (double)at[0], (double)at[1], (double)at[2]), KN_OK);
        for (int c = 0; c < 3; c++)
            assert_true(fabsl(p[c] - t[c]) < 1e-11L); // products, elevation and joins below 1e3 u
    }
}

// All kinds over all surfaces: T in the whole box, and its degrees.
static void equals_the_shell(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(51);
    for (int run = 0; run < 8 * SURFACE_CASES; run++) {
        int bits = run % 8, power = 1 + run % 3;
        kn_spline s = {0}, h = {0}, d = {0}, psi = {0}, v = {0};
        kn_shell *shell = NULL;
        surface_cases[run / 8].make(ctx, &s);
        make_field(ctx, &h, &rng, &s, 2, 1, 1.0, 0.4);
        make_field(ctx, &d, &rng, &s, 1, 3, 0.5, 0.5);
        make_field(ctx, &psi, &rng, &s, 1, 3, 0.0, 0.3);
        kn_shell_options o = {.normal_tol = 1e-2, .attraction_power = power};
        if (bits & 1) o.thickness = &h;
        if (bits & 2) o.direction = &d;
        if (bits & 4) o.attraction = &psi;
        assert_int_equal(kn_shell_create(ctx, &shell, &s, &o), KN_OK);
        const double w[2] = {test_uniform(&rng, -1, 0), test_uniform(&rng, 0.1, 1)};
        if (kn_shell_volume(ctx, &v, shell, w[0], w[1]) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
        assert_int_equal(v.rational, s.rational);
        assert_int_equal(v.degree[2], bits & 4 ? power : 1);
        for (int e = 0; e < 2; e++) {
            // of a direction the shell tells h d
            int n = kn_shell_normal(shell)->degree[e] + (bits & 1 && !(bits & 2) ? h.degree[e] : 0);
            if (bits & 4 && n < psi.degree[e]) n = psi.degree[e];
            if (s.rational) n += s.degree[e];
            assert_int_equal(v.degree[e], n > s.degree[e] ? n : s.degree[e]);
        }
        check_volume(ctx, shell, &v, w, &rng);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &h), kn_spline_clear(ctx, &d);
        kn_spline_clear(ctx, &psi), kn_spline_clear(ctx, &v);
    }
    test_ctx_end(ctx, &memory);
}

// Small integers: S + w d between -1 and 2 is exact, and its first and last layers are S - d and S + 2 d.
static void exact_layers(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double k[4] = {0, 0, 1, 1}, s4[12] = {0, 0, 4, 4, 0, 4, 0, 4, 1, 2, 3, 5};
    const double d4[12] = {1, 2, 3, 4, -1, 0, 2, 5, 7, 8, 9, 6};
    const double *knots[2] = {k, k};
    const int one[2] = {1, 1}, two[2] = {2, 2};
    kn_spline s = {0}, d = {0}, v = {0};
    assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, one, two, knots, s4), KN_OK);
    assert_int_equal(kn_spline_init(ctx, &d, 2, 3, false, one, two, knots, d4), KN_OK);
    kn_shell *shell = NULL;
    assert_int_equal(kn_shell_create(ctx, &shell, &s, &(kn_shell_options){.direction = &d}), KN_OK);
    assert_int_equal(kn_shell_volume(ctx, &v, shell, -1, 2), KN_OK);
    assert_int_equal(v.count[2], 2);
    for (int i = 0; i < 12; i++)
        assert_true(v.coef[2 * i] == s4[i] - d4[i] && v.coef[2 * i + 1] == s4[i] + 2 * d4[i]);
    kn_shell_destroy(ctx, shell);
    // with w^3 psi, psi = d: the coefficients of w^3 on [-1,2] in degree 3 are -1, 2, -4, 8
    const double cube[4] = {-1, 2, -4, 8}, linear[4] = {-1, 0, 1, 2};
    assert_int_equal(kn_shell_create(ctx, &shell, &s,
                                     &(kn_shell_options){.direction = &d, .attraction = &d, .attraction_power = 3}),
                     KN_OK);
    assert_int_equal(kn_shell_volume(ctx, &v, shell, -1, 2), KN_OK);
    for (int i = 0; i < 12; i++)
        for (int j = 0; j < 4; j++) assert_true(v.coef[4 * i + j] == s4[i] + (linear[j] + cube[j]) * d4[i]);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &d), kn_spline_clear(ctx, &v);
    test_ctx_end(ctx, &memory);
}

static kn_status volume_call(kn_ctx *ctx, void *user)
{
    kn_spline v = {0};
    kn_status status = kn_shell_volume(ctx, &v, user, 0, 1);
    assert_true((status == KN_OK) == (v.coef != NULL));
    kn_spline_clear(ctx, &v);
    return status;
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0}, v = {0};
    kn_shell *shell = NULL;
    make_torus(ctx, &s);
    assert_int_equal(kn_shell_create(ctx, &shell, &s, &(kn_shell_options){.normal_tol = 1e-2}), KN_OK);
    assert_int_equal(kn_shell_volume(ctx, &v, shell, 1, 1), KN_EDOMAIN);
    assert_int_equal(kn_shell_volume(ctx, &v, shell, 0, INFINITY), KN_EDOMAIN);
    assert_int_equal(kn_shell_volume(ctx, &v, shell, NAN, 1), KN_EDOMAIN);
    assert_null(v.coef);
    test_allocation_failures(volume_call, shell);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equals_the_shell),
        cmocka_unit_test(exact_layers),
        cmocka_unit_test(failures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
