// SPDX-License-Identifier: Apache-2.0
// Trivariate splines as shells.
#include "tests/support/kinds.h"

#include <math.h>
#include <string.h>

static kn_shell *create(kn_ctx *ctx, const kn_spline *v)
{
    kn_shell *shell = NULL;
    if (kn_shell_from_volume(ctx, &shell, v, NULL) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return shell;
}

// T is the volume, heights counted from its lower end; the Jacobian against central differences (h^2 times a third
// derivative below 1e3, and 1e-15 / h of rounding); and kn_shell_volume gives it back.
static void is_the_volume(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(61);
    for (int which = 0; which < VOLUME_CASES; which++) {
        kn_spline v = {0}, part = {0};
        make_volume(ctx, &v, which);
        kn_shell *shell = create(ctx, &v);
        double w[2], lo[3], hi[3];
        for (int d = 0; d < 3; d++) kn_spline_domain(&v, d, &lo[d], &hi[d]);
        kn_shell_heights(shell, w);
        assert_true(w[0] == 0.0 && w[1] == hi[2] - lo[2]);
        assert_true(kn_shell_normal(shell)->coef == NULL && kn_shell_certificate(shell).certified);
        assert_int_equal(kn_shell_volume(ctx, &part, shell, 0.25 * w[1], 0.5 * w[1]), KN_OK);
        for (int i = 0; i < test_scale(50); i++) {
            double at[3], p[3], j[9], a[3], b[3];
            const double h = 1e-5;
            for (int d = 0; d < 3; d++) at[d] = test_uniform(&rng, lo[d], hi[d]);
            long double t[3];
            direct_volume(t, &v, (const long double[3]){at[0], at[1], at[2]});
            assert_int_equal(kn_shell_eval(ctx, p, j, shell, at[0], at[1], at[2] - lo[2]), KN_OK);
            for (int c = 0; c < 3; c++) assert_true(fabsl(p[c] - t[c]) < 1e-13L);
            for (int d = 0; d < 3; d++) {
                double y[3] = {at[0], at[1], at[2] - lo[2]}, z[3] = {at[0], at[1], at[2] - lo[2]};
                y[d] -= h, z[d] += h;
                assert_int_equal(kn_shell_eval(ctx, a, NULL, shell, y[0], y[1], y[2]), KN_OK);
                assert_int_equal(kn_shell_eval(ctx, b, NULL, shell, z[0], z[1], z[2]), KN_OK);
                // a knot of S between y and z: second derivatives jump there, below 100
                for (int c = 0; c < 3; c++) assert_true(fabs(j[3 * c + d] - (b[c] - a[c]) / (2 * h)) < 1e-3);
            }
            at[2] = test_uniform(&rng, 0.25 * w[1], 0.5 * w[1]);
            direct_volume(t, &part, (const long double[3]){at[0], at[1], at[2]});
            assert_int_equal(kn_shell_eval(ctx, p, NULL, shell, at[0], at[1], at[2]), KN_OK);
            for (int c = 0; c < 3; c++) assert_true(fabsl(p[c] - t[c]) < 1e-13L);
        }
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &v), kn_spline_clear(ctx, &part);
    }
    test_ctx_end(ctx, &memory);
}

static void check_piece(kn_ctx *ctx, const kn_shell *shell, const kn_shell_piece *p, const double lo[2],
                        const double hi[2], test_rng *rng)
{
    double top[2];
    kn_shell_heights(shell, top);
    for (int m = 0; m < 5; m++) {
        long double x[2] = {test_uniform(rng, 0, 1), test_uniform(rng, 0, 1)}, sum[4] = {0}, value[4];
        double w = test_uniform(rng, 0, top[1]), at[2], q[3];
        for (int v = 0; v < 2; v++) at[v] = (double)(lo[v] + x[v] * (hi[v] - lo[v]));
        for (int k = 0; k < p->nterms; k++) {
            assert_int_equal(p->power[k], k);
            direct_piece(value, &p->term[k], x);
            for (int c = 0; c < p->term[k].ncomp; c++) sum[c] += powl(w, k) * value[c];
        }
        assert_int_equal(kn_shell_eval(ctx, q, NULL, shell, at[0], at[1], w), KN_OK);
        for (int c = 0; c < 3; c++) {
            long double t = p->term[0].rational ? sum[c] / sum[3] : sum[c];
            assert_true(fabsl(t - q[c]) <
                        1e-11L); // C(3,k) 2^k of numbers below 10, at's rounding times slopes below 100
        }
    }
}

// The pieces of the first cell, whole and beyond the domain, in powers of w.
static void pieces(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(62);
    for (int which = 0; which < VOLUME_CASES; which++) {
        kn_spline v = {0};
        make_volume(ctx, &v, which);
        kn_shell *shell = create(ctx, &v);
        for (int k = 0; k < 2; k++) {
            kn_shell_piece p = {0};
            bool fits = false;
            double lo[2] = {k == 0 ? 0 : -0.25, k == 0 ? 0 : 0.125}, hi[2] = {1, 1}, from[2], to[2];
            kn_status status = kn_shell_piece_init(ctx, &p, &fits, shell, (const int[2]){0, 0}, lo, hi, 9);
            if (which == VOLUME_OF_SPANS) {
                assert_int_equal(status, KN_EDOMAIN);
                assert_non_null(strstr(kn_ctx_message(ctx), "knots in w"));
                continue;
            }
            assert_int_equal(status, KN_OK);
            assert_true(fits && p.exact && p.deviation == 0.0);
            assert_int_equal(p.nterms, v.degree[2] + 1);
            for (int d = 0; d < 2; d++) {
                double a = v.knots[d][v.degree[d]], b = v.knots[d][v.degree[d] + 1]; // simple knots
                from[d] = a + lo[d] * (b - a), to[d] = a + hi[d] * (b - a);
            }
            check_piece(ctx, shell, &p, from, to, &rng);
            kn_shell_piece_clear(ctx, &p);
        }
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &v);
    }
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0}, v = {0};
    kn_shell *shell = NULL;
    make_plane(ctx, &s);
    assert_int_equal(kn_shell_from_volume(ctx, &shell, &s, NULL), KN_EDOMAIN);
    make_volume(ctx, &v, 0);
    double lines[2] = {0, 0.5};
    kn_shell_options o = {.lines = {lines, NULL}, .nlines = {2, 0}};
    assert_int_equal(kn_shell_from_volume(ctx, &shell, &v, &o), KN_EDOMAIN);
    assert_int_equal(kn_shell_from_volume(ctx, &shell, &v, &(kn_shell_options){.max_spans = -1}), KN_EDOMAIN);
    int degree[3] = {v.degree[0], v.degree[1], KN_SHELL_TERMS};
    assert_int_equal(kn_spline_elevate(ctx, &v, &v, degree), KN_OK);
    assert_int_equal(kn_shell_from_volume(ctx, &shell, &v, NULL), KN_ELIMIT);
    assert_null(shell);
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &v);
    test_ctx_end(ctx, &memory);
}

static kn_status volume_call(kn_ctx *ctx, void *user)
{
    kn_shell *shell = NULL;
    kn_status status = kn_shell_from_volume(ctx, &shell, user, NULL);
    assert_true((status == KN_OK) == (shell != NULL));
    kn_shell_destroy(ctx, shell);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int which = 3; which < 5; which++) { // rational, and with knots in w
        kn_spline v = {0};
        make_volume(ctx, &v, which);
        test_allocation_failures(volume_call, &v);
        kn_spline_clear(ctx, &v);
    }
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(is_the_volume),
        cmocka_unit_test(pieces),
        cmocka_unit_test(failures),
        cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
