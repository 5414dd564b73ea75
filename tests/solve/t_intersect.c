// SPDX-License-Identifier: Apache-2.0
// Lines, curves and surfaces that meet in known points.
#include "tests/support/support.h"

#include <knurl/solve.h>

#include <math.h>

// The graph z = x^2 + y^2 - 1/2 over the unit square, exactly: biquadratic, with extra knots.
static void paraboloid(kn_ctx *ctx, kn_spline *out, bool knots)
{
    const int degree[2] = {2, 2};
    const double x[3] = {0.0, 0.5, 1.0}, xx[3] = {0.0, 0.0, 1.0}, more[2] = {0.25, 0.5};
    kn_bezier b;
    assert_int_equal(kn_bezier_init(ctx, &b, 2, 3, false, degree), KN_OK);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            b.coef[3 * i + j] = x[i];
            b.coef[9 + 3 * i + j] = x[j];
            b.coef[18 + 3 * i + j] = xx[i] + xx[j] - 0.5;
        }
    assert_int_equal(kn_spline_of_bezier(ctx, out, &b), KN_OK);
    for (int d = 0; d < 2 && knots; d++) assert_int_equal(kn_spline_insert_knots(ctx, out, out, d, more, 2), KN_OK);
    kn_bezier_clear(ctx, &b);
}

static void lines(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(31);
    kn_spline s = {0};
    for (int k = test_scale(300); k > 0; k--) {
        // through two points of the surface; the rest of the line meets the paraboloid nowhere
        double a[2], b[2], p[3], d[3];
        paraboloid(ctx, &s, k % 2 == 0);
        for (int i = 0; i < 2; i++) {
            a[i] = k % 3 == 0 ? test_int(&rng, 0, 4) / 4.0 : test_uniform(&rng, 0.0, 1.0);
            b[i] = k % 3 == 0 ? test_int(&rng, 0, 4) / 4.0 : test_uniform(&rng, 0.0, 1.0);
            p[i] = a[i], d[i] = b[i] - a[i];
        }
        if (fabs(d[0]) + fabs(d[1]) < 0.01) continue;
        p[2] = a[0] * a[0] + a[1] * a[1] - 0.5;
        d[2] = b[0] * b[0] + b[1] * b[1] - 0.5 - p[2];
        kn_root *roots = NULL;
        size_t n = 0;
        kn_solve_report report;
        assert_int_equal(kn_solve_intersect_line_surface(ctx, &roots, &n, &report, &s, p, d, NULL), KN_OK);
        int near = 0;
        for (size_t i = 0; i < n; i++) {
            bool at_a = fabs(roots[i].at[0] - a[0]) + fabs(roots[i].at[1] - a[1]) < 1e-9;
            bool at_b = fabs(roots[i].at[0] - b[0]) + fabs(roots[i].at[1] - b[1]) < 1e-9;
            assert_true(at_a || at_b);
            if (at_a) assert_true(fabs(roots[i].at[2]) < 1e-9);
            if (at_b) assert_true(fabs(roots[i].at[2] - 1.0) < 1e-6);
            near += roots[i].kind == KN_ROOT_UNIQUE;
        }
        if (k % 3 != 0) assert_true(n == 2 && near == 2); // on the boundary rounding may move a point outside
        assert_true(n >= 1 && report.possible == 0);
        kn_free(ctx, roots);
    }
    // beside it, along it, and through a plane that contains the line
    const double beside[3] = {3.0, 3.0, 0.0}, up[3] = {0.0, 0.0, 1.0}, none[3] = {0.0, 0.0, 0.0},
                 nan[3] = {NAN, 0.0, 0.0};
    kn_root mine, *roots = &mine;
    kn_solve_report report;
    size_t n = 9;
    assert_int_equal(kn_solve_intersect_line_surface(ctx, &roots, &n, &report, &s, beside, up, NULL), KN_OK);
    assert_int_equal(n, 0);
    kn_free(ctx, roots);
    roots = &mine, n = 9;
    assert_int_equal(kn_solve_intersect_line_surface(ctx, &roots, &n, &report, &s, beside, none, NULL), KN_EDOMAIN);
    assert_int_equal(kn_solve_intersect_line_surface(ctx, &roots, &n, &report, &s, nan, up, NULL), KN_EDOMAIN);
    assert_int_equal(kn_solve_intersect_curve_surface(ctx, &roots, &n, &report, &s, &s, NULL), KN_EDOMAIN);
    assert_int_equal(kn_solve_intersect_curves(ctx, &roots, &n, &report, &s, &s, NULL), KN_EDOMAIN);
    assert_true(roots == &mine && n == 9);
    for (size_t i = 0; i < kn_spline_count(&s); i++) s.coef[2 * kn_spline_count(&s) + i] = 0.0; // z = 0
    const double inside[3] = {0.3, 0.2, 0.0}, slanted[3] = {1.0, 0.7, 0.0};
    assert_int_equal(kn_solve_intersect_line_surface(ctx, &roots, &n, &report, &s, inside, slanted, NULL), KN_OK);
    assert_true(report.curve_like && n > 1);
    kn_free(ctx, roots);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// A rational cylinder of radius 1 (a quarter) and a line through it: x = cos, y = sin.
static void cylinder(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double knots[2][6] = {{0, 0, 0, 1, 1, 1}, {0, 0, 3, 3}}, r = sqrt(0.5);
    double coef[24] = {1, 1, r, r, 0, 0, 0, 0, r, r, 1, 1, 0, 3, 0, 3 * r, 0, 3, 1, 1, r, r, 1, 1};
    kn_spline s = {.nvars = 2,
                   .ncomp = 4,
                   .rational = true,
                   .degree = {2, 1},
                   .count = {3, 2},
                   .knots = {knots[0], knots[1]},
                   .coef = coef};
    kn_root *roots = NULL;
    size_t n = 0;
    const double p[3] = {0.0, 0.0, 1.0}, d[3] = {0.6, 0.8, 0.25};
    assert_int_equal(kn_solve_intersect_line_surface(ctx, &roots, &n, NULL, &s, p, d, NULL), KN_OK);
    assert_int_equal(n, 1);
    assert_int_equal(roots[0].kind, KN_ROOT_UNIQUE);
    assert_true(fabs(roots[0].at[2] - 1.0) < 1e-14 && fabs(roots[0].at[1] - 1.25) < 1e-14);
    kn_free(ctx, roots);
    const double q[3] = {1.0, -1.0, 1.5}, tangent[3] = {0.0, 1.0, 0.0}; // touches at u = 0
    assert_int_equal(kn_solve_intersect_line_surface(ctx, &roots, &n, NULL, &s, q, tangent, NULL), KN_OK);
    assert_true(n >= 1 && roots[0].kind == KN_ROOT_POSSIBLE && roots[0].lo[0] <= 0.0 && roots[0].hi[0] < 1e-6);
    kn_free(ctx, roots);
    test_ctx_end(ctx, &memory);
}

// A curve on the paraboloid's axis directions: (t, 1/2, t^2 + h) meets z = x^2 + 1/4 - 1/2 nowhere unless h = -1/4,
// and then everywhere; (t, t, 1/2) meets it where 2 t^2 = 1.
static void curves(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double knots[6] = {0, 0, 0, 1, 1, 1}, c[9] = {0.0, 0.5, 1.0, 0.0, 0.5, 1.0, 0.5, 0.5, 0.5};
    kn_spline curve = {.nvars = 1, .ncomp = 3, .degree = {2}, .count = {3}, .knots = {knots}, .coef = c}, s = {0};
    kn_root *roots = NULL;
    kn_solve_report report;
    size_t n = 0;
    paraboloid(ctx, &s, true);
    assert_int_equal(kn_solve_intersect_curve_surface(ctx, &roots, &n, &report, &curve, &s, NULL), KN_OK);
    assert_int_equal(n, 1);
    assert_int_equal(roots[0].kind, KN_ROOT_UNIQUE);
    for (int d = 0; d < 3; d++) assert_true(fabs(roots[0].at[d] - sqrt(0.5)) < 1e-14);
    kn_free(ctx, roots);
    for (int i = 0; i < 3; i++) c[3 + i] = 0.5, c[6 + i] = (i == 2) - 0.25;
    const kn_solve_options few = {.max_undecided = 200};
    assert_int_equal(kn_solve_intersect_curve_surface(ctx, &roots, &n, &report, &curve, &s, &few), KN_OK);
    assert_true(report.curve_like);
    kn_free(ctx, roots);
    for (int i = 0; i < 3; i++) c[6 + i] = (i == 2) - 0.3;
    assert_int_equal(kn_solve_intersect_curve_surface(ctx, &roots, &n, &report, &curve, &s, &few), KN_OK);
    assert_int_equal(n, 0);
    kn_free(ctx, roots);
    kn_spline_clear(ctx, &s);
    // the parabola y = x^2 and the line y = x / 2 + 1/10 in the plane; with z = 1 on both in space; and z = 2 on one
    double a[9] = {0.0, 0.5, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0}, b[6] = {0.0, 1.0, 0.1, 0.6, 1.0, 1.0},
           ends[4] = {0, 0, 1, 1};
    kn_spline first = {.nvars = 1, .ncomp = 2, .degree = {2}, .count = {3}, .knots = {knots}, .coef = a};
    kn_spline second = {.nvars = 1, .ncomp = 2, .degree = {1}, .count = {2}, .knots = {ends}, .coef = b};
    double x = 0.25 + sqrt(0.0625 + 0.1);
    for (int dim = 2; dim < 4; dim++) {
        first.ncomp = second.ncomp = dim;
        assert_int_equal(kn_solve_intersect_curves(ctx, &roots, &n, &report, &first, &second, NULL), KN_OK);
        assert_int_equal(n, 1);
        assert_int_equal(roots[0].kind, dim == 2 ? KN_ROOT_UNIQUE : KN_ROOT_POSSIBLE);
        assert_true(fabs(roots[0].at[0] - x) < 1e-11 && fabs(roots[0].at[1] - x) < 1e-11);
        kn_free(ctx, roots);
    }
    b[4] = b[5] = 2.0;
    assert_int_equal(kn_solve_intersect_curves(ctx, &roots, &n, &report, &first, &second, NULL), KN_OK);
    assert_int_equal(n, 0);
    kn_free(ctx, roots);
    second.ncomp = 2;
    assert_int_equal(kn_solve_intersect_curves(ctx, &roots, &n, &report, &first, &second, NULL), KN_EDOMAIN);
    test_ctx_end(ctx, &memory);
}

// A rational circle with knots, and a line through its centre; two segments in space that miss one another by 1e-13.
static void pairs(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double knots[12] = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}, ends[4] = {0, 0, 1, 1}, r = sqrt(0.5);
    double c[27] = {1, r, 0, -r, -1, -r, 0, r, 1, 0, r, 1, r, 0, -r, -1, -r, 0, 1, r, 1, r, 1, r, 1, r, 1};
    double l[4] = {-1.2, 1.2, -1.6, 1.6};
    kn_spline circle = {
        .nvars = 1, .ncomp = 3, .rational = true, .degree = {2}, .count = {9}, .knots = {knots}, .coef = c};
    kn_spline line = {.nvars = 1, .ncomp = 2, .degree = {1}, .count = {2}, .knots = {ends}, .coef = l};
    kn_root *roots = NULL;
    size_t n = 0;
    assert_int_equal(kn_solve_intersect_curves(ctx, &roots, &n, NULL, &line, &circle, NULL), KN_OK);
    assert_int_equal(n, 2);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(roots[i].kind, KN_ROOT_UNIQUE);
        assert_true(fabs(roots[i].at[0] - (i == 0 ? 0.25 : 0.75)) < 1e-14);
    }
    kn_free(ctx, roots);
    l[0] = 0.0, l[1] = 2.0, l[2] = l[3] = 0.0; // through the seam of the circle: both of its ends
    assert_int_equal(kn_solve_intersect_curves(ctx, &roots, &n, NULL, &line, &circle, NULL), KN_OK);
    assert_int_equal(n, 2);
    assert_true(roots[0].at_edge && roots[1].at_edge);
    kn_free(ctx, roots);
    l[1] = -2.0; // through a knot
    assert_int_equal(kn_solve_intersect_curves(ctx, &roots, &n, NULL, &line, &circle, NULL), KN_OK);
    assert_int_equal(n, 1);
    assert_int_equal(roots[0].kind, KN_ROOT_UNIQUE);
    assert_true(fabs(roots[0].at[1] - 2.0) < 1e-14);
    kn_free(ctx, roots);
    double a[6] = {0, 1, 0, 1, 0, 1}, b[6] = {1.0 + 1e-13, 2, 1, 3, 1, 1};
    kn_spline first = {.nvars = 1, .ncomp = 3, .degree = {1}, .count = {2}, .knots = {ends}, .coef = a},
              second = first;
    second.coef = b;
    assert_int_equal(kn_solve_intersect_curves(ctx, &roots, &n, NULL, &first, &second, NULL), KN_OK);
    assert_int_equal(n, 1);
    assert_int_equal(roots[0].kind, KN_ROOT_POSSIBLE);
    kn_free(ctx, roots);
    b[0] = 1.0 + 1e-10;
    assert_int_equal(kn_solve_intersect_curves(ctx, &roots, &n, NULL, &first, &second, NULL), KN_OK);
    assert_int_equal(n, 0);
    kn_free(ctx, roots);
    test_ctx_end(ctx, &memory);
}

static kn_status all(kn_ctx *ctx, void *user)
{
    double knots[4] = {0, 0, 1, 1}, c[12] = {0, 0, 1, 1, 0, 1, 0, 1, 0, 0, 0, 0.1},
           line[6] = {0.1, 0.8, 0.2, 0.9, -1, 1};
    kn_spline s = {.nvars = 2, .ncomp = 3, .degree = {1, 1}, .count = {2, 2}, .knots = {knots, knots}, .coef = c};
    kn_spline curve = {.nvars = 1, .ncomp = 3, .degree = {1}, .count = {2}, .knots = {knots}, .coef = line},
              flat = curve;
    const double p[3] = {0.3, 0.4, -1.0}, d[3] = {0.1, 0.0, 1.0};
    kn_root *roots = user;
    size_t n = 0;
    flat.ncomp = 2;
    kn_status status = kn_solve_intersect_line_surface(ctx, &roots, &n, NULL, &s, p, d, NULL);
    if (status == KN_OK) kn_free(ctx, roots), roots = user;
    if (status == KN_OK) status = kn_solve_intersect_curve_surface(ctx, &roots, &n, NULL, &curve, &s, NULL);
    if (status == KN_OK) kn_free(ctx, roots), roots = user;
    if (status == KN_OK) status = kn_solve_intersect_curves(ctx, &roots, &n, NULL, &flat, &flat, NULL);
    if (status == KN_OK) kn_free(ctx, roots), roots = user;
    assert_ptr_equal(roots, user);
    return status;
}

static void allocation(void **state)
{
    (void)state;
    kn_root mine;
    test_allocation_failures(all, &mine);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lines), cmocka_unit_test(cylinder), cmocka_unit_test(curves),
                                       cmocka_unit_test(pairs), cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("solve/intersect", tests, NULL, NULL);
}
