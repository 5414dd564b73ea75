// SPDX-License-Identifier: Apache-2.0
// Boxes over parts of a domain, oriented boxes and Lipschitz bounds of splines: jumps, ends, tightness, failures, memory.
// tests/oracle/t_bounds.c holds them against exact arithmetic.
#include <float.h>
#include <math.h>
#include <string.h>

#include "tests/support/support.h"

static kn_spline curve(kn_ctx *ctx, int degree, int count, int ncomp, bool rational, const double *knots,
                       const double *coef)
{
    kn_spline s;
    const double *const k[] = {knots};
    assert_int_equal(kn_spline_init(ctx, &s, 1, ncomp, rational, &degree, &count, k, coef), KN_OK);
    return s;
}

// [least, most] is contained in the box, which is wider by at most 2 (6 p + 5) u of the coefficients, all below 10.
static void assert_box(kn_ctx *ctx, const kn_spline *s, double lo, double hi, double least, double most)
{
    double a, b, slack = 2 * (6 * s->degree[0] + 5) * 10 * DBL_EPSILON;
    assert_int_equal(kn_spline_box_over(ctx, &a, &b, s, &lo, &hi), KN_OK);
    if (!(a <= least && a >= least - slack && b >= most && b <= most + slack))
        fail_msg("over [%g, %g]: [%.17g, %.17g], not [%g, %g]", lo, hi, a, b, least, most);
}

static void parts_of_the_domain(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 1, 1, 2, 4, 4}, coef[] = {0, 1, 5, 7, 3}; // lines; a jump from 1 to 5 at 1
    kn_spline s = curve(ctx, 1, 5, 1, false, knots, coef);
    double lo = 0, hi = 4, a, b;
    assert_int_equal(kn_spline_box_over(ctx, &a, &b, &s, &lo, &hi), KN_OK);
    assert_true(a == 0 && b == 7); // the whole domain: exact
    assert_box(ctx, &s, 0.25, 0.5, 0.25, 0.5);
    assert_box(ctx, &s, 0.5, 1, 0.5, 5); // at the jump the right-hand piece counts
    assert_box(ctx, &s, 0, 1, 0, 5);
    assert_box(ctx, &s, 1, 1, 5, 5);
    assert_box(ctx, &s, 1, 1.5, 5, 6);
    assert_box(ctx, &s, 0.5, 1.5, 0.5, 6); // both sides of it
    assert_box(ctx, &s, 1.5, 3, 5, 7);
    assert_box(ctx, &s, 4, 4, 3, 3);
    assert_box(ctx, &s, -1, 0.5, -1, 0.5); // the end pieces go on
    assert_box(ctx, &s, 3, 5, 1, 5);
    assert_box(ctx, &s, -2, -1, -2, -1);
    kn_spline_clear(ctx, &s);
    const double steps[] = {0, 1, 2, 3}, level[] = {2, 9, 4};
    s = curve(ctx, 0, 3, 1, false, steps, level);
    assert_box(ctx, &s, 0, 0.5, 2, 2);
    assert_box(ctx, &s, 0, 1, 2, 9);
    assert_box(ctx, &s, 2, 2.5, 4, 4);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// A rational surface: weights matter, and a part may be positive where the whole is not.
static void rational_parts(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 1, 2, 2};
    kn_spline s = curve(ctx, 1, 3, 2, true, knots, (double[]){1, 1, 1, 1, 2, -1});
    double a = 17, b = 17, lo = 0, hi = 1;
    assert_int_equal(kn_spline_box_over(ctx, &a, &b, &s, &lo, &hi), KN_OK);
    assert_true(a <= 0.5 && a > 0.5 - 1e-14 && b >= 1 && b < 1 + 1e-14);
    a = b = 17, hi = 2;
    assert_int_equal(kn_spline_box_over(ctx, &a, &b, &s, &lo, &hi), KN_EDOMAIN);
    assert_int_equal(kn_spline_box(ctx, &a, &b, &s), KN_EDOMAIN);
    assert_int_equal(kn_spline_lipschitz(ctx, &a, &s), KN_EDOMAIN);
    assert_true(a == 17 && b == 17);
    kn_spline_clear(ctx, &s);
    s = curve(ctx, 1, 3, 2, true, knots, (double[]){1, 1, 2, 3, 1, 1}); // 1/3 .. 2: the tightest doubles
    assert_int_equal(kn_spline_box(ctx, &a, &b, &s), KN_OK);
    assert_true(3.0L * a <= 1.0L && 3.0L * nextafter(a, 1.0) > 1.0L && b == 2);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// A quarter of a thin pipe, slanted: axes along it leave a box of less than half the volume of the one along the
// coordinates, and every control point is in it (in long double: half holds several hundred times its roundings).
static void slanted_pipe(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double ku[] = {0, 0, 0, 1, 1, 1}, kv[] = {0, 0, 1, 2, 2};
    const double *const knots[] = {ku, kv};
    kn_spline s;
    kn_oriented_box box;
    double lo[3], hi[3], volume = 1, root = sqrt(0.5);
    assert_int_equal(kn_spline_init(ctx, &s, 2, 4, true, (int[]){2, 1}, (int[]){3, 3}, knots, NULL), KN_OK);
    for (int k = 0; k < 9; k++) {
        double w = k / 3 == 1 ? root : 1, x = k / 3 < 2 ? 0.1 : 0, y = k / 3 > 0 ? 0.1 : 0, z = k % 3;
        s.coef[k] = w * (x * root + z / 2), s.coef[9 + k] = w * (y - z / 3);
        s.coef[18 + k] = w * (z - x * root), s.coef[27 + k] = w;
    }
    assert_int_equal(kn_spline_box(ctx, lo, hi, &s), KN_OK);
    assert_int_equal(kn_spline_oriented_box(ctx, &box, &s), KN_OK);
    for (int i = 0; i < 3; i++) volume *= 0.5 * (hi[i] - lo[i]);
    assert_true(box.half[0] * box.half[1] * box.half[2] < 0.5 * volume);
    for (int k = 0; k < 9; k++)
        for (int i = 0; i < 3; i++) {
            long double y = 0.0L;
            for (int c = 0; c < 3; c++)
                y += box.axis[i][c] * ((long double)s.coef[9 * c + k] / s.coef[27 + k] - box.center[c]);
            assert_true(fabsl(y) <= box.half[i]);
        }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Slopes on both sides of knots count, jumps and constants do not; a circle of radius 2 in four arcs over [0,4].
static void slopes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double bound[2], r = sqrt(0.5);
    const double knots[] = {0, 0, 1, 1, 2, 4, 4}, coef[] = {0, 1, 5, 8, 4}, ends[] = {0, 1};
    kn_spline s = curve(ctx, 1, 5, 1, false, knots, coef);
    assert_int_equal(kn_spline_lipschitz(ctx, bound, &s), KN_OK);
    assert_true(bound[0] >= 3 && bound[0] <= 3 * (1 + 64 * DBL_EPSILON)); // 1, 3, -2
    kn_spline_clear(ctx, &s);
    s = curve(ctx, 0, 1, 1, false, ends, (double[]){5});
    assert_int_equal(kn_spline_lipschitz(ctx, bound, &s), KN_OK);
    assert_true(bound[0] == 0);
    kn_spline_clear(ctx, &s);

    const double arcs[] = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};
    const double x[] = {1, 1, 0, -1, -1, -1, 0, 1, 1}, y[] = {0, 1, 1, 1, 0, -1, -1, -1, 0};
    double circle[27];
    for (int i = 0; i < 9; i++) {
        double w = i % 2 ? r : 1;
        circle[i] = 2 * x[i] * w, circle[9 + i] = 2 * y[i] * w, circle[18 + i] = w;
    }
    s = curve(ctx, 2, 9, 3, true, arcs, circle);
    assert_int_equal(kn_spline_lipschitz(ctx, bound, &s), KN_OK);
    double fastest = 0;
    for (int i = 0; i <= 64; i++) {
        double d[4], at = i / 16.0;
        assert_int_equal(kn_spline_derivatives(ctx, d, &s, &at, 1), KN_OK);
        fastest = fmax(fastest, hypot(d[2], d[3]));
    }
    assert_true(bound[0] >= fastest * (1 - 1e-13) && bound[0] <= 1.2 * fastest); // 1 + 2 sqrt 2, 8 (sqrt 2 - 1)
    for (int i = 0; i < 12; i++) s.knots[0][i] *= 10;
    assert_int_equal(kn_spline_lipschitz(ctx, bound + 1, &s), KN_OK);
    assert_true(fabs(10 * bound[1] - bound[0]) <= 1e-13 * bound[0]); // slower over a longer domain
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 1, 1}, zero = 0, one = 1, nan = NAN, infinite = INFINITY;
    double lo[4] = {17}, hi[4] = {17}, ends[60], high[60];
    kn_oriented_box box = {.half = {17}};
    for (int i = 0; i < 60; i++) ends[i] = i < 30 ? 0 : 1, high[i] = 1;
    kn_spline s = curve(ctx, 1, 2, 1, false, knots, NULL), empty = {0}, flat = curve(ctx, 1, 2, 3, true, knots, NULL);
    kn_spline steep = curve(ctx, 29, 30, 2, true, ends, high);
    assert_int_equal(kn_spline_box_over(ctx, lo, hi, &empty, &zero, &one), KN_EDOMAIN);
    assert_int_equal(kn_spline_box_over(ctx, lo, hi, &s, &one, &zero), KN_EDOMAIN);
    assert_int_equal(kn_spline_box_over(ctx, lo, hi, &s, &nan, &one), KN_EDOMAIN);
    assert_int_equal(kn_spline_box_over(ctx, lo, hi, &s, &zero, &infinite), KN_EDOMAIN);
    assert_int_equal(kn_spline_oriented_box(ctx, &box, &empty), KN_EDOMAIN);
    assert_int_equal(kn_spline_oriented_box(ctx, &box, &s), KN_EDOMAIN);    // dimension 1
    assert_int_equal(kn_spline_oriented_box(ctx, &box, &flat), KN_EDOMAIN); // weights 0
    assert_int_equal(kn_spline_lipschitz(ctx, lo, &empty), KN_EDOMAIN);
    assert_int_equal(kn_spline_lipschitz(ctx, lo, &flat), KN_EDOMAIN);
    assert_int_equal(kn_ctx_error(ctx), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_spline_lipschitz(ctx, lo, &steep), KN_ELIMIT); // degree 58
    assert_int_equal(kn_ctx_error(ctx), KN_ELIMIT);
    assert_true(lo[0] == 17 && hi[0] == 17 && box.half[0] == 17);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &flat);
    kn_spline_clear(ctx, &steep);
    test_ctx_end(ctx, &memory);
}

static kn_status call_once(kn_ctx *ctx, void *user)
{
    static const double u[] = {0, 0, 0, 1, 2, 2, 2}, v[] = {0, 0, 1, 2, 2}, lo[] = {0.5, 0.5}, hi[] = {1.5, 2};
    int which = *(const int *)user, rational = which % 2;
    double coef[48], least[3] = {17, 17, 17}, most[3] = {17, 17, 17};
    kn_oriented_box box = {.half = {17}};
    kn_spline a = {0};
    for (int i = 0; i < 48; i++) coef[i] = 1 + i % 5;
    kn_status status = kn_spline_init(ctx, &a, 2, 3 + rational, rational, (int[]){2, 1}, (int[]){4, 3},
                                      (const double *[]){u, v}, coef);
    if (status == KN_OK && which / 2 == 0) status = kn_spline_box_over(ctx, least, most, &a, lo, hi);
    if (status == KN_OK && which / 2 == 1) status = kn_spline_oriented_box(ctx, &box, &a);
    if (status == KN_OK && which / 2 == 2) status = kn_spline_lipschitz(ctx, least, &a);
    if (status != KN_OK) assert_true(least[0] == 17 && most[2] == 17 && box.half[0] == 17);
    kn_spline_clear(ctx, &a);
    return status;
}

static void out_of_memory(void **state)
{
    (void)state;
    for (int which = 0; which < 6; which++) test_allocation_failures(call_once, &which);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_of_the_domain),
        cmocka_unit_test(rational_parts),
        cmocka_unit_test(slanted_pipe),
        cmocka_unit_test(slopes),
        cmocka_unit_test(failures),
        cmocka_unit_test(out_of_memory),
    };
    return cmocka_run_group_tests_name("spline/bounds", tests, NULL, NULL);
}
