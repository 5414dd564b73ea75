// SPDX-License-Identifier: Apache-2.0
// The search for places without a normal: what it finds, that its work is limited, and what is said then.
#include "tests/support/surfaces.h"

#include "trivar/internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

// n = (x - a, y - b, height), bilinear: it vanishes at (a,b) alone, and only for height 0.
static void make_direction(kn_ctx *ctx, kn_direction *d, double a, double b, double height)
{
    const int degree[2] = {1, 1};
    *d = (kn_direction){.error = 1e-15};
    assert_int_equal(kn_bezier_init(ctx, &d->n, 2, 3, false, degree), KN_OK);
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++) {
            d->n.coef[2 * i + j] = i - a;
            d->n.coef[4 + 2 * i + j] = j - b;
            d->n.coef[8 + 2 * i + j] = height;
        }
}

static void answers(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(6);
    for (int k = 0; k < 200; k++) {
        double a = test_uniform(&rng, 0, 1), b = test_uniform(&rng, 0, 1), at[2], work = KN_REGULAR_WORK;
        double height = k % 2 ? 0.0 : pow(10.0, test_uniform(&rng, -9, 0));
        kn_direction d;
        kn_regularity answer;
        make_direction(ctx, &d, a, b, height);
        assert_int_equal(kn_direction_regular(ctx, &answer, at, &d, &work), KN_OK);
        assert_int_equal(answer, k % 2 ? KN_SINGULAR : KN_REGULAR);
        if (k % 2) assert_true(fabs(at[0] - a) < 1e-6 && fabs(at[1] - b) < 1e-6); // 26 halvings each way
        kn_direction_clear(ctx, &d);
    }
    test_ctx_end(ctx, &memory);
}

// Without work beyond the free halvings it is undecided near the zero; more work decides, and is taken off.
static void work_is_limited(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_direction d;
    kn_regularity answer;
    double at[2], none = -1.0, all = KN_REGULAR_WORK;
    make_direction(ctx, &d, 0.3, 0.7, 0.0);
    assert_int_equal(kn_direction_regular(ctx, &answer, at, &d, &none), KN_OK);
    assert_int_equal(answer, KN_UNDECIDED);
    assert_true(none == -1.0 && at[0] >= 0.0 && at[0] <= 1.0 && at[1] >= 0.0 && at[1] <= 1.0);
    assert_int_equal(kn_direction_regular(ctx, &answer, at, &d, &all), KN_OK);
    assert_int_equal(answer, KN_SINGULAR);
    assert_true(all < KN_REGULAR_WORK && all > 0.99 * KN_REGULAR_WORK);
    kn_direction_clear(ctx, &d);

    kn_spline s;
    kn_shell *shell = NULL;
    make_plane(ctx, &s);
    assert_int_equal(kn_shell_create(ctx, &shell, &s, NULL), KN_OK);
    assert_int_equal(kn_fail_normal(ctx, shell, (const double[2]){0.5, 0.25}, false), KN_EUNDECIDED);
    assert_string_equal(kn_ctx_message(ctx),
                        "shell: could not decide whether the surface has a normal everywhere near "
                        "(0.5, 0.25), the point (1, 0.75, 1)");
    kn_ctx_clear_error(ctx);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// One patch of random control points around a grid.
static void make_wild(kn_ctx *ctx, kn_spline *out, test_rng *rng, int p, bool rational, double amplitude)
{
    double knots[2 * 26], coef[4 * 26 * 26];
    const double *both[2] = {knots, knots};
    int n = (p + 1) * (p + 1);
    for (int i = 0; i <= p; i++) knots[i] = 0, knots[p + 1 + i] = 1;
    for (int i = 0; i < n; i++) {
        double w = rational ? test_uniform(rng, 0.2, 3) : 1.0;
        coef[i] = w * ((double)(i / (p + 1)) / p + amplitude * test_uniform(rng, -1, 1));
        coef[n + i] = w * ((double)(i % (p + 1)) / p + amplitude * test_uniform(rng, -1, 1));
        coef[2 * n + i] = w * amplitude * test_uniform(rng, -1, 1);
        coef[3 * n + i] = w;
    }
    assert_int_equal(kn_spline_init(ctx, out, 2, rational ? 4 : 3, rational, (const int[2]){p, p},
                                    (const int[2]){p + 1, p + 1}, both, coef),
                     KN_OK);
}

// Whatever high degrees do, there is an answer; where it is "no normal", S_u and S_v are parallel there.
static void wild_surfaces(void **state)
{
    (void)state;
    static const int degree[] = {3, 8, 12, 18, 25};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(7);
    int found = 0;
    for (int k = 0; k < 20; k++) {
        int p = degree[k / 4];
        bool rational = k % 2 == 1 && p <= 12;
        kn_spline s;
        kn_shell *shell = NULL;
        kn_shell_options o = {.normal_tol = 0.4, .max_spans = 2};
        make_wild(ctx, &s, &rng, p, rational, k % 4 < 2 ? 0.06 : 1.0);
        kn_status status = kn_shell_create(ctx, &shell, &s, &o);
        assert_true(status == KN_OK || status == KN_EUNDEFINED || status == KN_EUNDECIDED);
        double u, v;
        const char *message = strstr(kn_ctx_message(ctx), "no normal at");
        if (p <= 12 && status == KN_EUNDEFINED && sscanf(message, "no normal at (%lf, %lf)", &u, &v) == 2) {
            long double x[3], su[3], sv[3], cross[3], cc = 0, uu = 0, vv = 0;
            direct_surface(x, su, sv, cross, &s, u, v);
            for (int c = 0; c < 3; c++) cc += cross[c] * cross[c], uu += su[c] * su[c], vv += sv[c] * sv[c];
            assert_true(cc <= 1e-6L * uu * vv); // six digits of (u,v)
            found++;
        }
        kn_ctx_clear_error(ctx);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    assert_true(found >= 2);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(answers),
        cmocka_unit_test(work_is_limited),
        cmocka_unit_test(wild_surfaces),
    };
    return cmocka_run_group_tests_name("trivar/regular", tests, NULL, NULL);
}
