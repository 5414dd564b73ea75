// SPDX-License-Identifier: Apache-2.0
// Closest points: closed forms, random splines against sampling and Newton's method, ties, failures.
#include "tests/support/support.h"

#include <knurl/solve.h>

#include <math.h>
#include <string.h>

enum { CIRCLE = 9 };

// A full circle in homogeneous coordinates (x, y, w), with double knots at quarters.
static void circle(double x[CIRCLE], double y[CIRCLE], double w[CIRCLE])
{
    const double cx[CIRCLE] = {1, 1, 0, -1, -1, -1, 0, 1, 1}, cy[CIRCLE] = {0, 1, 1, 1, 0, -1, -1, -1, 0};
    for (int i = 0; i < CIRCLE; i++) {
        w[i] = i % 2 ? sqrt(0.5) : 1.0;
        x[i] = cx[i] * w[i];
        y[i] = cy[i] * w[i];
    }
}

static const double QUARTERS[CIRCLE + 3] = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};

// The torus with axis z, radii R and r.
static void torus(kn_ctx *ctx, kn_spline *out, double big, double small)
{
    const int degree[2] = {2, 2}, count[2] = {CIRCLE, CIRCLE};
    const double *knots[2] = {QUARTERS, QUARTERS};
    double x[CIRCLE], y[CIRCLE], w[CIRCLE], c[4 * CIRCLE * CIRCLE];
    circle(x, y, w);
    for (int i = 0; i < CIRCLE; i++)
        for (int j = 0; j < CIRCLE; j++) {
            double *p = c + CIRCLE * i + j;
            p[0] = (big * w[j] + small * x[j]) * x[i];
            p[CIRCLE * CIRCLE] = (big * w[j] + small * x[j]) * y[i];
            p[2 * CIRCLE * CIRCLE] = small * y[j] * w[i];
            p[3 * CIRCLE * CIRCLE] = w[i] * w[j];
        }
    assert_int_equal(kn_spline_init(ctx, out, 2, 4, true, degree, count, knots, c), KN_OK);
}

static void known(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(41);
    kn_spline s = {0};
    torus(ctx, &s, 3.0, 1.0);
    size_t boxes = 0;
    int n = test_scale(40);
    for (int k = 0; k < n; k++) {
        double q[3], lower = -1.0;
        for (int i = 0; i < 3; i++) q[i] = test_uniform(&rng, -5.0, 5.0);
        double exact = fabs(hypot(hypot(q[0], q[1]) - 3.0, q[2]) - 1.0);
        kn_closest *best = NULL;
        kn_solve_report report;
        size_t count = 0;
        assert_int_equal(kn_solve_closest(ctx, &best, &count, &lower, &report, &s, q, NULL), KN_OK);
        // the default accuracy, 1e-12 of the largest distance to a control point, below 20; the closed form rounds,
        // too
        assert_true(count >= 1 && fabs(best[0].distance - exact) < 2e-11);
        assert_true(lower <= exact + 1e-14 && lower >= exact - 2e-11);
        assert_false(report.limited);
        assert_true(fabs(hypot(hypot(best[0].point[0] - q[0], best[0].point[1] - q[1]), best[0].point[2] - q[2]) -
                         exact) < 2e-11);
        boxes += report.boxes;
        kn_free(ctx, best);
    }
    print_message("# torus: %zu boxes for %d points\n", boxes, n);
    const double axis[3] = {0.0, 0.0, 0.0}; // a circle of closest points
    kn_closest *best = NULL;
    size_t count = 0;
    double lower = -1.0;
    assert_int_equal(kn_solve_closest(ctx, &best, &count, &lower, NULL, &s, axis, NULL), KN_OK);
    assert_true(count >= 4 && fabs(best[0].distance - 2.0) < 1e-11 && lower <= 2.0 && lower > 2.0 - 1e-11);
    for (size_t i = 0; i < count; i++) assert_true(fabs(hypot(best[i].point[0], best[i].point[1]) - 2.0) < 1e-10);
    kn_free(ctx, best);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// A rectangle in space, a segment, a circle and its centre, a curve with two closest points.
static void small_ones(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(42);
    double knots[4] = {0, 0, 1, 1}, flat[12] = {0, 0, 2, 2, 0, 3, 0, 3, 1, 1, 1, 1};
    kn_spline s = {.nvars = 2, .ncomp = 3, .degree = {1, 1}, .count = {2, 2}, .knots = {knots, knots}, .coef = flat};
    kn_closest *best = NULL;
    size_t n = 0;
    double lower;
    for (int k = test_scale(50); k > 0; k--) {
        double q[3];
        for (int i = 0; i < 3; i++) q[i] = test_uniform(&rng, -2.0, 5.0);
        double x = fmin(fmax(q[0], 0.0), 2.0), y = fmin(fmax(q[1], 0.0), 3.0),
               d = hypot(hypot(x - q[0], y - q[1]), 1.0 - q[2]);
        assert_int_equal(kn_solve_closest(ctx, &best, &n, &lower, NULL, &s, q, NULL), KN_OK);
        assert_int_equal(n, 1);
        assert_true(fabs(best[0].distance - d) < 1e-11 && lower <= d * (1.0 + 1e-15) && lower >= d - 1e-11);
        assert_true(fabs(best[0].at[0] - x / 2.0) < 1e-5 && fabs(best[0].at[1] - y / 3.0) < 1e-5);
        kn_free(ctx, best);
    }
    const double on[3] = {1.25, 0.5, 1.0};
    assert_int_equal(kn_solve_closest(ctx, &best, &n, &lower, NULL, &s, on, NULL), KN_OK); // point inversion
    assert_true(n == 1 && lower == 0.0 && best[0].distance < 1e-11 && fabs(best[0].at[0] - 0.625) < 1e-11);
    kn_free(ctx, best);
    double jump[4] = {0, 1, 3, 4}, twice[6] = {0, 0, 0.5, 0.5, 1, 1},
           beside = 1.25; // s leaves 1 at 1/2, and goes on from 3
    kn_spline j = {.nvars = 1, .ncomp = 1, .degree = {1}, .count = {4}, .knots = {twice}, .coef = jump};
    assert_int_equal(kn_solve_closest(ctx, &best, &n, &lower, NULL, &j, &beside, NULL), KN_OK);
    assert_true(n == 1 && best[0].at[0] == 0.5 && best[0].distance == 0.25 && best[0].point[0] == 1.0);
    kn_free(ctx, best);
    double x[CIRCLE], y[CIRCLE], w[CIRCLE], c[3 * CIRCLE], own[CIRCLE + 3];
    circle(x, y, w);
    memcpy(c, x, sizeof x);
    memcpy(c + CIRCLE, y, sizeof y);
    memcpy(c + 2 * CIRCLE, w, sizeof w);
    memcpy(own, QUARTERS, sizeof own);
    kn_spline o = {
        .nvars = 1, .ncomp = 3, .rational = true, .degree = {2}, .count = {CIRCLE}, .knots = {own}, .coef = c};
    const double centre[2] = {0.0, 0.0}, off[2] = {0.25, 0.0};
    assert_int_equal(kn_solve_closest(ctx, &best, &n, &lower, NULL, &o, centre, NULL), KN_OK);
    assert_true(n >= 2 && fabs(best[0].distance - 1.0) < 1e-12 && lower <= 1.0 && lower > 1.0 - 1e-11);
    kn_free(ctx, best);
    assert_int_equal(kn_solve_closest(ctx, &best, &n, &lower, NULL, &o, off, NULL), KN_OK); // the seam of the circle
    assert_true(n == 2 && fabs(best[0].distance - 0.75) < 1e-11 && fabs(best[1].distance - 0.75) < 1e-11);
    kn_free(ctx, best);
    double bow[6] = {-1.0, 0.0, 1.0, 1.0, -1.0, 1.0}, three[6] = {0, 0, 0, 1, 1, 1}; // y = x^2
    kn_spline p = {.nvars = 1, .ncomp = 2, .degree = {2}, .count = {3}, .knots = {three}, .coef = bow};
    const double above[2] = {0.0, 1.0}; // x^2 = 1/2 on both sides
    assert_int_equal(kn_solve_closest(ctx, &best, &n, &lower, NULL, &p, above, NULL), KN_OK);
    assert_true(n == 2 && fabs(best[0].distance - sqrt(0.75)) < 1e-11);
    assert_true(fabs(fabs(best[0].at[0] - 0.5) - 0.5 * sqrt(0.5)) < 1e-6 &&
                fabs(best[0].at[0] + best[1].at[0] - 1.0) < 1e-6);
    kn_free(ctx, best);
    test_ctx_end(ctx, &memory);
}

// |s(at) - q| in long double, by the sum of products with B-splines computed on the way of kn_spline_eval would not
// be independent: the value comes from kn_spline_eval, the rest is done here.
static long double distance(kn_ctx *ctx, const kn_spline *s, const double *at, const double *q)
{
    double x[3];
    long double sum = 0.0L;
    assert_int_equal(kn_spline_eval(ctx, x, s, at), KN_OK);
    for (int c = 0; c < 3; c++) sum += ((long double)x[c] - q[c]) * ((long double)x[c] - q[c]);
    return sqrtl(sum);
}

// Downhill from a sample: Gauss-Newton steps with halving, held inside the domain.
static long double refine(kn_ctx *ctx, const kn_spline *s, double *at, const double *q, const double *hi)
{
    long double now = distance(ctx, s, at, q);
    for (int step = 0; step < 40; step++) {
        double d[9], m[3] = {0}, r[2] = {0}, by[2];
        assert_int_equal(kn_spline_derivatives(ctx, d, s, at, 1), KN_OK);
        for (int c = 0; c < 3; c++) {
            m[0] += d[3 + c] * d[3 + c], m[1] += d[3 + c] * d[6 + c], m[2] += d[6 + c] * d[6 + c];
            r[0] -= d[3 + c] * (d[c] - q[c]), r[1] -= d[6 + c] * (d[c] - q[c]);
        }
        double det = m[0] * m[2] - m[1] * m[1];
        by[0] = (r[0] * m[2] - r[1] * m[1]) / det, by[1] = (r[1] * m[0] - r[0] * m[1]) / det;
        double t = 1.0;
        for (; t > 1e-4; t *= 0.5) {
            double to[2];
            for (int i = 0; i < 2; i++) to[i] = fmin(fmax(at[i] + t * by[i], 0.0), hi[i]);
            long double then = distance(ctx, s, to, q);
            if (then >= now) continue;
            now = then;
            at[0] = to[0], at[1] = to[1];
            break;
        }
        if (t <= 1e-4) break;
    }
    return now;
}

static void random_surfaces(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(43);
    size_t boxes = 0;
    int n = test_scale(60), limited = 0;
    for (int k = 0; k < n; k++) {
        const int degree[2] = {test_int(&rng, 1, 4), test_int(&rng, 1, 4)};
        const int count[2] = {degree[0] + test_int(&rng, 1, 5), degree[1] + test_int(&rng, 1, 5)};
        kn_spline s = {0};
        double q[3], hi[2], lower = -1.0, lo;
        test_random_spline(ctx, &s, &rng, 2, k % 2 ? 4 : 3, k % 2 == 1, degree, count, 5);
        for (int i = 0; i < 3; i++) q[i] = test_uniform(&rng, -6.0, 6.0);
        for (int d = 0; d < 2; d++) kn_spline_domain(&s, d, &lo, &hi[d]);
        kn_closest *best = NULL;
        kn_solve_report report;
        size_t found = 0;
        assert_int_equal(kn_solve_closest(ctx, &best, &found, &lower, &report, &s, q, NULL), KN_OK);
        long double least = INFINITY;
        double start[2] = {0.0, 0.0};
        for (int i = 0; i <= 30; i++)
            for (int j = 0; j <= 30; j++) {
                double at[2] = {hi[0] * i / 30.0, hi[1] * j / 30.0};
                long double d = distance(ctx, &s, at, q);
                if (d < least) least = d, start[0] = at[0], start[1] = at[1];
                assert_true(d >= (long double)lower - 1e-13L); // rounding of the value
            }
        least = refine(ctx, &s, start, q, hi);
        assert_true((long double)lower <= least + 1e-13L);
        assert_true(found >= 1 && (long double)best[0].distance <= least + 2e-11L); // 1e-12 of 20
        assert_true(report.limited || best[0].distance - lower <= 2e-11);
        assert_true(fabsl(distance(ctx, &s, best[0].at, q) - (long double)best[0].distance) < 1e-12L);
        limited += report.limited;
        boxes += report.boxes;
        kn_free(ctx, best);
        kn_spline_clear(ctx, &s);
    }
    print_message("# random: %zu boxes for %d surfaces, %d limited\n", boxes, n, limited);
    assert_true(limited <= n / 20);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double knots[2 * (KN_MAX_DEGREE + 1)], c[2 * (KN_MAX_DEGREE + 1)] = {0.0, 1.0}, q[2] = {NAN, 0.0};
    for (int i = 0; i < 2 * (KN_MAX_DEGREE + 1); i++) knots[i] = i > KN_MAX_DEGREE;
    kn_spline s = {.nvars = 1,
                   .ncomp = 2,
                   .degree = {KN_MAX_DEGREE},
                   .count = {KN_MAX_DEGREE + 1},
                   .knots = {knots},
                   .coef = c},
              empty = {0};
    kn_closest mine, *best = &mine;
    size_t n = 3;
    double lower = 7.0;
    const kn_solve_options bad = {.residual = -1.0};
    assert_int_equal(kn_solve_closest(ctx, &best, &n, &lower, NULL, &empty, q, NULL), KN_EDOMAIN);
    assert_int_equal(kn_solve_closest(ctx, &best, &n, &lower, NULL, &s, q, NULL), KN_ELIMIT);
    s.degree[0] = 1, s.count[0] = 2, s.knots[0] = knots + KN_MAX_DEGREE - 1;
    assert_int_equal(kn_solve_closest(ctx, &best, &n, &lower, NULL, &s, q, NULL), KN_EDOMAIN);
    q[0] = 0.0;
    assert_int_equal(kn_solve_closest(ctx, &best, &n, &lower, NULL, &s, q, &bad), KN_EDOMAIN);
    for (int k = 0; k < 3; k++) { // squares overflow: of a point, a control point, the span between them
        q[0] = k == 1 ? 0.0 : 0x1p511, c[0] = k == 0 ? 0.0 : -0x1p511;
        assert_int_equal(kn_solve_closest(ctx, &best, &n, &lower, NULL, &s, q, NULL), KN_EUNDECIDED);
    }
    q[0] = 0x1p1023, c[0] = -0x1p1023;
    assert_int_equal(kn_solve_closest(ctx, &best, &n, &lower, NULL, &s, q, NULL), KN_EUNDECIDED);
    assert_true(best == &mine && n == 3 && lower == 7.0);
    test_ctx_end(ctx, &memory);
}

static kn_status one(kn_ctx *ctx, void *user)
{
    double knots[6] = {0, 0, 0, 1, 1, 1}, c[6] = {-1, 0, 1, 1, -1, 1}, q[2] = {0.3, 0.9}, lower = -1.0;
    kn_spline s = {.nvars = 1, .ncomp = 2, .degree = {2}, .count = {3}, .knots = {knots}, .coef = c};
    kn_closest *best = user;
    size_t n = 0;
    kn_status status = kn_solve_closest(ctx, &best, &n, &lower, NULL, &s, q, NULL);
    if (status != KN_OK) assert_true(best == user && lower == -1.0);
    if (status == KN_OK) kn_free(ctx, best);
    return status;
}

static void allocation(void **state)
{
    (void)state;
    kn_closest mine;
    test_allocation_failures(one, &mine);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(known), cmocka_unit_test(small_ones),
                                       cmocka_unit_test(random_surfaces), cmocka_unit_test(failures),
                                       cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("solve/closest", tests, NULL, NULL);
}
