// SPDX-License-Identifier: Apache-2.0
// Above, below, on, both or neither: closed forms.
#include "tests/support/surfaces.h"

#include <math.h>

static kn_shell_inverse *inverse_of(kn_ctx *ctx, void (*surface)(kn_ctx *, kn_spline *), double w0, double w1)
{
    kn_spline s;
    kn_shell *shell = NULL;
    kn_shell_inverse *inverse = NULL;
    surface(ctx, &s);
    assert_int_equal(kn_shell_create(ctx, &shell, &s, NULL), KN_OK);
    assert_int_equal(kn_shell_inverse_create(ctx, &inverse, shell, w0, w1), KN_OK);
    kn_shell_destroy(ctx, shell); // the inverse keeps what it needs
    kn_spline_clear(ctx, &s);
    return inverse;
}

static kn_side side(kn_ctx *ctx, const kn_shell_inverse *inverse, double x, double y, double z)
{
    const double p[3] = {x, y, z};
    kn_side out = KN_SIDE_UNDECIDED;
    if (kn_shell_side(ctx, &out, inverse, p) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return out;
}

static void plane(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_shell_inverse *inverse = inverse_of(ctx, make_plane, -1.0, 1.0); // [0,2] x [0,3] at z = 1, normal upwards
    assert_int_equal(side(ctx, inverse, 0.5, 1.0, 1.5), KN_SIDE_ABOVE);
    assert_int_equal(side(ctx, inverse, 0.5, 1.0, 0.5), KN_SIDE_BELOW);
    assert_int_equal(side(ctx, inverse, 0.5, 1.0, 1.0), KN_SIDE_ON);
    assert_int_equal(side(ctx, inverse, 0.0, 3.0, 1.0), KN_SIDE_ON);    // a corner
    assert_int_equal(side(ctx, inverse, 2.0, 1.0, 2.0), KN_SIDE_ABOVE); // the edge of the domain and of the heights
    assert_int_equal(side(ctx, inverse, 0.5, 1.0, 2.001), KN_SIDE_NONE);
    assert_int_equal(side(ctx, inverse, 2.001, 1.0, 1.0), KN_SIDE_NONE);
    assert_int_equal(side(ctx, inverse, 0.5, 1.0, 1.0 + 1e-9), KN_SIDE_ABOVE);
    assert_int_equal(side(ctx, inverse, 0.5, 1.0, 1.0 - 1e-9), KN_SIDE_BELOW);
    kn_shell_inverse_destroy(ctx, inverse);
    test_ctx_end(ctx, &memory);
}

static void sphere(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(51);
    kn_shell_inverse *inverse = inverse_of(ctx, make_sphere, -1.0, 1.0);
    for (int i = 0; i < test_scale(50); i++) {
        double x[3] = {test_uniform(&rng, -1, 1), test_uniform(&rng, -1, 1), test_uniform(&rng, -1, 1)};
        double r = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
        if (!(r > 0.1)) continue;
        double to[5] = {0.9, 1.5, 2.5, 3.1, 1.999};
        kn_side want[5] = {KN_SIDE_NONE, KN_SIDE_BELOW, KN_SIDE_ABOVE, KN_SIDE_NONE, KN_SIDE_BELOW};
        for (int k = 0; k < 5; k++) {
            double f = to[k] / r;
            assert_int_equal(side(ctx, inverse, f * x[0], f * x[1], f * x[2]), want[k]);
        }
    }
    assert_int_equal(side(ctx, inverse, 0.0, 0.0, 2.0), KN_SIDE_ON); // the poles
    assert_int_equal(side(ctx, inverse, 0.0, 0.0, -2.5), KN_SIDE_ABOVE);
    assert_int_equal(side(ctx, inverse, 0.0, 0.0, -1.5), KN_SIDE_BELOW);
    assert_int_equal(side(ctx, inverse, 2.0, 0.0, 0.0), KN_SIDE_ON); // the seam
    kn_shell_inverse_destroy(ctx, inverse);
    test_ctx_end(ctx, &memory);
}

// Inside a torus' hole the two sides of the ring are both beneath a point; deep in the tube both above and below.
static void torus(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_shell_inverse *inverse = inverse_of(ctx, make_torus, -1.5, 5.4);
    assert_int_equal(side(ctx, inverse, 4.5, 0.1, 0.0), KN_SIDE_ABOVE);
    assert_int_equal(side(ctx, inverse, 3.5, 0.1, 0.1), KN_SIDE_BELOW); // the far side is 5.58 away
    assert_int_equal(side(ctx, inverse, 2.2, 0.1, 0.1), KN_SIDE_BOTH);  // and now 4.2
    assert_int_equal(side(ctx, inverse, 2.0, 0.0, 0.0), KN_SIDE_ON);    // although also above the far side
    assert_int_equal(side(ctx, inverse, 12.0, 0.0, 0.0), KN_SIDE_NONE);
    kn_shell_inverse_destroy(ctx, inverse);
    test_ctx_end(ctx, &memory);
}

// T = (u, v, w^2 - w + 1/4) folds at w = 1/2, where z = 0: whether there is a place cannot be certified.
static void fold_is_undecided(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int degree[3] = {1, 1, 2}, count[3] = {2, 2, 3};
    const double k1[4] = {0, 0, 1, 1}, k2[6] = {0, 0, 0, 1, 1, 1}, *knots[3] = {k1, k1, k2};
    const double height[3] = {0.25, -0.25, 0.25};
    double coef[36];
    for (int i = 0; i < 12; i++) coef[i] = i / 6, coef[12 + i] = i / 3 % 2, coef[24 + i] = height[i % 3];
    kn_spline volume;
    kn_shell *shell = NULL;
    kn_shell_inverse *inverse = NULL;
    assert_int_equal(kn_spline_init(ctx, &volume, 3, 3, false, degree, count, knots, coef), KN_OK);
    assert_int_equal(kn_shell_from_volume(ctx, &shell, &volume, NULL), KN_OK);
    assert_int_equal(kn_shell_inverse_create(ctx, &inverse, shell, 0.0, 1.0), KN_OK);
    assert_int_equal(side(ctx, inverse, 0.5, 0.5, 0.0), KN_SIDE_UNDECIDED);
    assert_int_equal(side(ctx, inverse, 0.5, 0.5, 0.01), KN_SIDE_ABOVE);
    assert_int_equal(side(ctx, inverse, 0.5, 0.5, 0.25), KN_SIDE_ON); // and above
    assert_int_equal(side(ctx, inverse, 0.5, 0.5, -1e-6), KN_SIDE_NONE);
    kn_shell_inverse_destroy(ctx, inverse);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &volume);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_shell_inverse *inverse = inverse_of(ctx, make_plane, -1.0, 1.0);
    const double bad[3] = {0.0, NAN, 0.0};
    kn_side out = KN_SIDE_BOTH;
    assert_int_equal(kn_shell_side(ctx, &out, inverse, bad), KN_EDOMAIN);
    assert_int_equal(out, KN_SIDE_BOTH);
    kn_shell_inverse_destroy(ctx, inverse);
    test_ctx_end(ctx, &memory);
}

static kn_status ask(kn_ctx *ctx, void *user)
{
    const double p[3] = {0.5, 1.0, 1.5};
    kn_side out = KN_SIDE_BOTH;
    kn_status status = kn_shell_side(ctx, &out, user, p);
    assert_int_equal(out, status == KN_OK ? KN_SIDE_ABOVE : KN_SIDE_BOTH);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_shell_inverse *inverse = inverse_of(ctx, make_plane, -1.0, 1.0);
    test_allocation_failures(ask, inverse);
    kn_shell_inverse_destroy(ctx, inverse);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plane),    cmocka_unit_test(sphere),
        cmocka_unit_test(torus),    cmocka_unit_test(fold_is_undecided),
        cmocka_unit_test(failures), cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests_name("trivar/side", tests, NULL, NULL);
}
