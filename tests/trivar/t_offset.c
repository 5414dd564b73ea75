// SPDX-License-Identifier: Apache-2.0
// Rational bases without loss: T of a sphere, a torus and a cylinder at height w is the sphere, torus or cylinder of
// a radius larger by w, within |w| times the certificate of n.
#include "tests/support/surfaces.h"

#include <math.h>

// The radius, the outward normal's sign against S_u x S_v, and the signed distance of a point.
typedef struct solid {
    const char *name;
    void (*make)(kn_ctx *ctx, kn_spline *out);
    double radius;
    double (*outside)(const double p[3]);
} solid;

static double from_sphere(const double p[3])
{
    return hypot(hypot(p[0], p[1]), p[2]) - 2.0;
}

static double from_torus(const double p[3])
{
    return hypot(hypot(p[0], p[1]) - 3.0, p[2]) - 1.0;
}

static double from_cylinder(const double p[3])
{
    return hypot(p[0], p[1]) - 1.0;
}

static const solid solids[] = {
    {"sphere", make_sphere, 2.0, from_sphere},
    {"torus", make_torus, 1.0, from_torus},
    {"cylinder", make_cylinder, 1.0, from_cylinder},
};

// T = S + w n. |n - N/|N|| is at most the length error and the angle error together, so that T is as near as |w|
// times that to the true offset point; hence so is its distance from S to w. Rounding: values of S and n of degree 11
// at most in each variable, 2 (6 * 11 + 1) roundings of numbers below 4, and as many of the distance: 1e-13.
static void check(kn_ctx *ctx, const solid *b, const kn_spline *s, kn_normal_method method, double tol)
{
    kn_shell_options o = {.normal = method, .normal_tol = tol, .max_degree = 5};
    kn_shell *shell = NULL;
    if (kn_shell_create(ctx, &shell, s, &o) != KN_OK) fail_msg("%s: %s", b->name, kn_ctx_message(ctx));
    kn_normal_certificate c = kn_shell_certificate(shell);
    double lo[2], hi[2], p[3], on[3];
    for (int v = 0; v < 2; v++) kn_spline_domain(s, v, &lo[v], &hi[v]);
    assert_int_equal(kn_shell_eval(ctx, p, NULL, shell, lo[0], 0.5 * (lo[1] + hi[1]), 0.25 * b->radius), KN_OK);
    double outward = b->outside(p) > 0.0 ? 1.0 : -1.0;
    for (int i = 0; i <= 40; i++)
        for (int j = 0; j <= 40; j++) // the ends are the poles of the sphere
            for (int k = -4; k <= 4; k++) {
                double u = lo[0] + (hi[0] - lo[0]) * i / 40, v = lo[1] + (hi[1] - lo[1]) * j / 40,
                       w = b->radius * k / 8;
                assert_int_equal(kn_shell_eval(ctx, p, NULL, shell, u, v, w), KN_OK);
                double off = b->outside(p) - outward * w, most = fabs(w) * (c.length_error + c.angle_error) + 1e-13;
                if (!(fabs(off) <= most))
                    fail_msg("%s: T(%g, %g, %g) is off by %g, above %g", b->name, u, v, w, off, most);
                if (k != 0) continue;
                assert_int_equal(kn_spline_eval(ctx, on, s, (const double[2]){u, v}), KN_OK);
                assert_true(test_max_difference(p, on, 3) <= 1e-15 * 4);
            }
    kn_shell_destroy(ctx, shell);
}

static void offsets(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (size_t k = 0; k < sizeof solids / sizeof *solids; k++) {
        kn_spline s;
        solids[k].make(ctx, &s);
        for (double tol = 1e-3; tol > (test_scale(1) > 1 ? 1e-10 : 1e-7); tol *= 1e-3) {
            check(ctx, &solids[k], &s, KN_NORMAL_FITTED, tol);
            check(ctx, &solids[k], &s, KN_NORMAL_EXACT_DIRECTION, tol);
        }
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(offsets)};
    return cmocka_run_group_tests_name("trivar/offset", tests, NULL, NULL);
}
