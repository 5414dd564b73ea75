// SPDX-License-Identifier: Apache-2.0
// Zero curves of functions of two variables: within the tolerance, complete, oriented, closed, alike on shared edges.
#include "tests/support/support.h"

#include "solve/curves.h"

#include <knurl/solve.h>

#include <math.h>
#include <string.h>

typedef struct lines {
    kn_solve_curve *list;
    size_t n;
    kn_solve_report report;
} lines;

// Values in long double, by de Casteljau.
static long double value_at(const kn_bezier *f, long double x, long double y)
{
    long double row[KN_MAX_DEGREE + 1], all[KN_MAX_DEGREE + 1];
    int n = f->degree[0], m = f->degree[1];
    for (int i = 0; i <= n; i++) {
        for (int j = 0; j <= m; j++) row[j] = f->coef[i * (m + 1) + j];
        for (int k = m; k > 0; k--)
            for (int j = 0; j < k; j++) row[j] = row[j] * (1 - y) + row[j + 1] * y;
        all[i] = row[0];
    }
    for (int k = n; k > 0; k--)
        for (int i = 0; i < k; i++) all[i] = all[i] * (1 - x) + all[i + 1] * x;
    return all[0];
}

static lines trace(kn_ctx *ctx, const kn_bezier *f, double tol)
{
    lines l = {0};
    assert_int_equal(kn_solve_curves_bezier(ctx, &l.list, &l.n, &l.report, f, tol), KN_OK);
    return l;
}

// Whether f changes its sign, or vanishes, within r of (x,y) along a parameter line.
static bool near_zero(const kn_bezier *f, long double x, long double y, long double r)
{
    bool below = false, above = false;
    for (int k = 0; k < 5; k++) {
        long double dx = k == 1 ? -r : k == 2 ? r : 0, dy = k == 3 ? -r : k == 4 ? r : 0;
        long double value = value_at(f, x + dx, y + dy);
        below = below || value <= 0;
        above = above || value >= 0;
    }
    return below && above;
}

static long double to_segment(long double x, long double y, const double *a, const double *b)
{
    long double dx = (long double)b[0] - a[0], dy = (long double)b[1] - a[1], l = dx * dx + dy * dy;
    long double s = l > 0 ? ((x - a[0]) * dx + (y - a[1]) * dy) / l : 0;
    s = s < 0 ? 0 : s > 1 ? 1 : s;
    return hypotl(x - a[0] - s * dx, y - a[1] - s * dy);
}

// Points and middles of chords near zeros; f < 0 on the right of each chord; ends on edges.
static void check_lines(const kn_bezier *f, const lines *l, double tol)
{
    double largest = 0;
    for (size_t i = 0; i < kn_bezier_count(f); i++) largest = fmax(largest, fabs(f->coef[i]));
    for (size_t c = 0; c < l->n; c++) {
        const kn_solve_curve *k = &l->list[c];
        assert_true(k->npoints >= 2);
        const double *first = k->points, *last = k->points + 2 * (k->npoints - 1);
        if (k->closed) {
            assert_memory_equal(first, last, 2 * sizeof *first);
        } else {
            assert_true(first[0] == 0 || first[0] == 1 || first[1] == 0 || first[1] == 1);
            assert_true(last[0] == 0 || last[0] == 1 || last[1] == 0 || last[1] == 1);
        }
        for (size_t i = 0; i + 1 < k->npoints; i++) {
            const double *a = first + 2 * i, *b = a + 2;
            for (int s = 0; s < 4; s++) {
                long double x = a[0] + s / 4.0L * ((long double)b[0] - a[0]);
                long double y = a[1] + s / 4.0L * ((long double)b[1] - a[1]);
                assert_true(near_zero(f, x, y, 1.0000001L * tol));
            }
            long double dx = (long double)b[0] - a[0], dy = (long double)b[1] - a[1], length = hypotl(dx, dy);
            if (length < 4 * tol) continue;
            long double right = value_at(f, (a[0] + b[0]) / 2.0L + 2 * tol * dy / length,
                                         (a[1] + b[1]) / 2.0L - 2 * tol * dx / length);
            assert_true(right < 1e-13L * largest);
        }
    }
}

// Every change of sign on a fine net of parameter lines has a chord within tol of it.
static void check_complete(const kn_bezier *f, const lines *l, double tol, int steps)
{
    for (int v = 0; v < 2; v++)
        for (int i = 0; i <= steps; i++)
            for (int j = 0; j < steps; j++) {
                long double at[2][2], value[2], least = INFINITY;
                for (int e = 0; e < 2; e++) {
                    at[e][v] = (i + 0.013L) / (steps + 0.1L);
                    at[e][1 - v] = (j + e) / (long double)steps;
                    value[e] = value_at(f, at[e][0], at[e][1]);
                }
                if ((value[0] < 0) == (value[1] < 0)) continue;
                for (int k = 0; k < 60; k++) {
                    long double mid[2] = {(at[0][0] + at[1][0]) / 2, (at[0][1] + at[1][1]) / 2};
                    int side = (value_at(f, mid[0], mid[1]) < 0) == (value[0] < 0) ? 0 : 1;
                    memcpy(at[side], mid, sizeof mid);
                }
                for (size_t c = 0; c < l->n; c++)
                    for (size_t k = 0; k + 1 < l->list[c].npoints; k++)
                        least = fminl(least, to_segment(at[0][0], at[0][1], l->list[c].points + 2 * k,
                                                        l->list[c].points + 2 * k + 2));
                assert_true(least <= 1.0000001L * tol);
            }
}

// (x - 1/2)^2 + (y - 1/2)^2 - r^2: one oval, run so that f >= 0 lies outside it: clockwise.
static void oval(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double c[9];
    const double q[3] = {0.25, -0.25, 0.25}; // (x - 1/2)^2
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) c[3 * i + j] = q[i] + q[j] - 0.09;
    kn_bezier f = {.nvars = 2, .ncomp = 1, .degree = {2, 2}, .coef = c};
    for (int k = 1; k < 6; k++) {
        double tol = pow(10, -k);
        lines l = trace(ctx, &f, tol);
        assert_int_equal(l.n, 1);
        assert_true(l.list[0].closed && l.report.possible == 0 && !l.report.limited);
        check_lines(&f, &l, tol);
        check_complete(&f, &l, tol, 20);
        double area = 0;
        for (size_t i = 0; i + 1 < l.list[0].npoints; i++) {
            const double *a = l.list[0].points + 2 * i;
            area += (a[0] * a[3] - a[2] * a[1]) / 2;
        }
        // chords lie within tol of the circle of radius 0.3
        assert_true(fabs(area + 3.14159265358979 * 0.09) <= 2 * 3.1416 * 0.3 * tol + 1e-15);
        kn_free(ctx, l.list);
    }
    test_ctx_end(ctx, &memory);
}

// Values on corners and edges that are zero count as positive.
static void zeros_on_the_boundary(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double c[4] = {0, 1, -1, 0}; // y - x: from corner to corner, f > 0 above it
    kn_bezier f = {.nvars = 2, .ncomp = 1, .degree = {1, 1}, .coef = c};
    lines l = trace(ctx, &f, 1e-6);
    assert_int_equal(l.n, 1);
    const double *p = l.list[0].points, *q = p + 2 * (l.list[0].npoints - 1);
    assert_true(!l.list[0].closed && p[0] == 0 && p[1] == 0 && q[0] == 1 && q[1] == 1);
    kn_free(ctx, l.list);

    const double plane[4] = {0, 0, 1, 1}; // x: zero along an edge
    memcpy(c, plane, sizeof c);
    l = trace(ctx, &f, 1e-6);
    assert_int_equal(l.n, 0);
    kn_free(ctx, l.list);
    for (int i = 0; i < 4; i++) c[i] = -plane[i]; // negative up to the edge: a line on it
    l = trace(ctx, &f, 1e-6);
    assert_int_equal(l.n, 1);
    check_lines(&f, &l, 1e-6);
    kn_free(ctx, l.list);
    memset(c, 0, sizeof c);
    l = trace(ctx, &f, 1e-6);
    assert_int_equal(l.n, 0);
    kn_free(ctx, l.list);
    test_ctx_end(ctx, &memory);
}

// (x - 1/2)(y - 1/2): lines that meet. They are drawn apart, within the tolerance.
static void crossing_lines(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double c[4] = {0.25, -0.25, -0.25, 0.25};
    kn_bezier f = {.nvars = 2, .ncomp = 1, .degree = {1, 1}, .coef = c};
    lines l = trace(ctx, &f, 1e-4);
    assert_int_equal(l.n, 2);
    assert_true(l.report.possible > 0);
    check_complete(&f, &l, 1e-4, 7);
    kn_free(ctx, l.list);
    test_ctx_end(ctx, &memory);
}

static void random_functions(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(71);
    for (int k = 0; k < 60; k++) {
        kn_bezier f = {0};
        const int degree[2] = {1 + k % 7, 1 + k / 7 % 5};
        test_random_bezier(ctx, &f, &rng, 2, 1, false, degree, 100);
        lines l = trace(ctx, &f, k % 2 ? 1e-3 : 1e-2);
        check_lines(&f, &l, k % 2 ? 1e-3 : 1e-2);
        check_complete(&f, &l, k % 2 ? 1e-3 : 1e-2, 12);
        kn_free(ctx, l.list);
        kn_bezier_clear(ctx, &f);
    }
    test_ctx_end(ctx, &memory);
}

// Two functions that share an edge, run either way, end their lines in the same places of it.
static void shared_edges(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(72);
    for (int k = 0; k < 40; k++) {
        kn_bezier f = {0}, g = {0};
        const int degree[2] = {3, 5}, other[2] = {2, 5};
        test_random_bezier(ctx, &f, &rng, 2, 1, false, degree, 100);
        test_random_bezier(ctx, &g, &rng, 2, 1, false, other, 100);
        bool reversed = k % 2;
        for (int j = 0; j < 6; j++) g.coef[reversed ? 5 - j : j] = f.coef[18 + j]; // x = 1 of f is x = 0 of g
        lines a = trace(ctx, &f, 1e-2), b = trace(ctx, &g, 1e-2);
        double end[2][8];
        int n[2] = {0, 0};
        for (int s = 0; s < 2; s++) {
            const lines *l = s ? &b : &a;
            for (size_t c = 0; c < l->n; c++)
                for (int e = 0; e < 2 && !l->list[c].closed; e++) {
                    const double *p = l->list[c].points + 2 * (e ? l->list[c].npoints - 1 : 0);
                    if (p[0] == (s ? 0 : 1)) end[s][n[s]++] = s && reversed ? 1 - p[1] : p[1];
                }
        }
        assert_int_equal(n[0], n[1]);
        for (int i = 0; i < n[0]; i++) {
            double least = 1;
            for (int j = 0; j < n[1]; j++) least = fmin(least, fabs(end[0][i] - end[1][j]));
            // of reversed coefficients the same values come with other roundings
            assert_true(reversed ? least <= 1e-12 : least == 0);
        }
        kn_free(ctx, a.list), kn_free(ctx, b.list);
        kn_bezier_clear(ctx, &f), kn_bezier_clear(ctx, &g);
    }
    test_ctx_end(ctx, &memory);
}

static void changes_of_one_variable(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const struct {
        double c[3];
        size_t n;
        double at;
        bool rise;
    } cases[] = {
        {{0, 1, 2}, 0, 0, false},   {{0, -1, -2}, 1, 0, false}, {{-1, -1, 0}, 1, 1, true},
        {{-1, 0, 1}, 1, 0.5, true}, {{0, 0, 0}, 0, 0, false},   {{1, 1, -1}, 1, 0.70710678118654752, false},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        kn_sign_changes found = {0};
        size_t doubtful = 0;
        assert_int_equal(kn_solve_sign_changes(ctx, &found, &doubtful, cases[i].c, 2), KN_OK);
        assert_int_equal(found.count, cases[i].n);
        assert_int_equal(doubtful, 0);
        // the root of 1 - 2 x^2 is as sharp as the rounding of its values, 4 u, over its slope
        if (found.count)
            assert_true(fabs(found.list[0].at - cases[i].at) <= 1e-15 && found.list[0].rise == cases[i].rise);
        kn_free(ctx, found.list);
    }
    test_ctx_end(ctx, &memory);
}

static kn_status call(kn_ctx *ctx, void *user)
{
    lines l = {0};
    kn_status status = kn_solve_curves_bezier(ctx, &l.list, &l.n, NULL, user, 1e-2);
    if (status == KN_OK)
        kn_free(ctx, l.list);
    else
        assert_null(l.list);
    return status;
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double c[9] = {1, -1, 1, -1, 3, -1, 1, -1, 1};
    kn_bezier f = {.nvars = 2, .ncomp = 1, .degree = {2, 2}, .coef = c}, bad = f;
    lines l = {0};
    test_allocation_failures(call, &f);
    bad.nvars = 1;
    assert_int_equal(kn_solve_curves_bezier(ctx, &l.list, &l.n, NULL, &bad, 1e-2), KN_EDOMAIN);
    assert_int_equal(kn_solve_curves_bezier(ctx, &l.list, &l.n, NULL, &f, 0), KN_EDOMAIN);
    assert_int_equal(kn_solve_curves_bezier(ctx, &l.list, &l.n, NULL, &f, NAN), KN_EDOMAIN);
    c[4] = NAN;
    assert_int_equal(kn_solve_curves_bezier(ctx, &l.list, &l.n, NULL, &f, 1e-2), KN_EDOMAIN);
    assert_null(l.list);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(oval),           cmocka_unit_test(zeros_on_the_boundary),
        cmocka_unit_test(crossing_lines), cmocka_unit_test(random_functions),
        cmocka_unit_test(shared_edges),   cmocka_unit_test(changes_of_one_variable),
        cmocka_unit_test(failures),
    };
    return cmocka_run_group_tests_name("solve/curves", tests, NULL, NULL);
}
