// SPDX-License-Identifier: Apache-2.0
// Cuts of regions: against the sign of f at random points, areas, and the pieces' own shapes.
#include "tests/support/scene.h"
#include "tests/support/support.h"

#include <knurl/trim.h>
#include <math.h>
#include <string.h>

static void random_function(kn_ctx *ctx, kn_bezier *f, test_rng *rng, int n, int m)
{
    assert_int_equal(kn_bezier_init(ctx, f, 2, 1, false, (int[]){n, m}), KN_OK);
    for (size_t i = 0; i < kn_bezier_count(f); i++) f->coef[i] = test_uniform(rng, -1.0, 1.0);
}

static double value_of(kn_ctx *ctx, const kn_bezier *f, const double at[2])
{
    double value;
    assert_int_equal(kn_bezier_eval(ctx, &value, f, at), KN_OK);
    return value;
}

// Every curve inside the square of one side is a curve of the other side run backwards, bit for bit.
static void assert_shared(const kn_trim *a, const kn_trim *b, int *shared)
{
    for (int i = 0; i < a->ncurves; i++) {
        const kn_spline *p = &a->curves[i];
        int n = p->count[0];
        bool found = false;
        for (int j = 0; j < b->ncurves && !found; j++) {
            const kn_spline *q = &b->curves[j];
            if (q->count[0] != n) continue;
            found = true;
            for (int k = 0; k < n && found; k++)
                found = p->coef[k] == q->coef[n - 1 - k] && p->coef[n + k] == q->coef[2 * n - 1 - k];
            for (int k = 0; k < n + 2 && found; k++) found = p->knots[0][k] == -q->knots[0][n + 1 - k];
        }
        *shared += found;
    }
}

// Whether points lie on the sides where the signs of the functions put them; true of nf functions: below.
static void assert_region(kn_ctx *ctx, const kn_trim *trim, bool there, const kn_bezier *const *f, const int *sign,
                          int nf, double near, test_rng *rng)
{
    for (int k = 0; k < 60; k++) {
        double at[2] = {test_uniform(rng, 0.0, 1.0), test_uniform(rng, 0.0, 1.0)};
        bool inside = true, far = true;
        for (int i = 0; i < nf; i++) {
            double v = value_of(ctx, f[i], at);
            far = far && fabs(v) > near;
            inside = inside && (v > 0.0) == (sign[i] > 0);
        }
        if (!far) continue;
        kn_answer answer = KN_NO;
        if (there) assert_int_equal(kn_trim_contains(ctx, &answer, trim, at), KN_OK);
        assert_int_equal(answer, inside ? KN_YES : KN_NO);
    }
}

static const double tol = 1e-3;

// Two functions, one after the other: four regions that fill the square.
static void random_cuts(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    int cuts = 0, undecided = 0, shared = 0;
    for (int trial = 0; trial < test_scale(60); trial++) {
        kn_bezier f = {0}, g = {0};
        kn_trim whole = {0}, side[2] = {0}, part[4] = {0};
        kn_trim_cut_report first, then[2] = {0};
        random_function(ctx, &f, &rng, test_int(&rng, 1, 4), test_int(&rng, 1, 4));
        random_function(ctx, &g, &rng, test_int(&rng, 1, 3), test_int(&rng, 1, 3));
        assert_int_equal(kn_trim_cut(ctx, &side[0], &side[1], &first, &whole, &f, tol), KN_OK);
        const kn_bezier *const both[2] = {&f, &g};
        // 60: |grad f| for coefficients in [-1,1] and degrees up to 4
        assert_true(first.residual <= 60.0 * tol);
        for (int k = 0; k < 2; k++) {
            bool there = k == 0 ? first.below : first.above;
            if (!there) continue;
            assert_int_equal(kn_trim_check(ctx, &side[k]), KN_OK);
            assert_region(ctx, &side[k], true, both, (int[]){k == 0 ? -1 : 1}, 1, first.residual, &rng);
            kn_status status = kn_trim_cut(ctx, &part[2 * k], &part[2 * k + 1], &then[k], &side[k], &g, tol);
            if (status == KN_EUNDECIDED) {
                kn_ctx_clear_error(ctx);
                undecided++;
                continue;
            }
            assert_int_equal(status, KN_OK);
            cuts++;
            double area = 0.0, near = fmax(first.residual, then[k].residual);
            for (int i = 0; i < 2; i++) {
                bool here = i == 0 ? then[k].below : then[k].above;
                const int sign[2] = {k == 0 ? -1 : 1, i == 0 ? -1 : 1};
                assert_region(ctx, &part[2 * k + i], here, both, sign, 2, near, &rng);
                if (!here) continue;
                assert_int_equal(kn_trim_check(ctx, &part[2 * k + i]), KN_OK);
                area += scene_trim_area(&part[2 * k + i]);
            }
            assert_true(fabs(area - scene_trim_area(&side[k])) < 1e-12); // they share their curves
        }
        if (first.below && first.above) {
            assert_true(fabs(scene_trim_area(&side[0]) + scene_trim_area(&side[1]) - 1.0) < 1e-12);
            int n = 0;
            assert_shared(&side[0], &side[1], &n);
            assert_true(n > 0);
        }
        if (first.below && first.above && then[0].below && then[0].above && then[1].below && then[1].above) {
            // the first cut's curve is divided at the same places on both sides of it
            assert_shared(&part[0], &part[2], &shared);
            assert_shared(&part[1], &part[3], &shared);
        }
        for (int k = 0; k < 4; k++) kn_trim_clear(ctx, &part[k]);
        for (int k = 0; k < 2; k++) kn_trim_clear(ctx, &side[k]);
        kn_bezier_clear(ctx, &f);
        kn_bezier_clear(ctx, &g);
    }
    assert_true(undecided * 50 < cuts && shared > 0);
    test_ctx_end(ctx, &memory);
}

// A circle: closed inside, its area, its restrictions to a grid of boxes, which fill it and meet on their sides.
static void restricted(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_bezier f = {0};
    kn_trim whole = {0}, in = {0}, out = {0}, part = {0};
    kn_trim_cut_report report;
    bool any;
    static const double square[3] = {0.25, -0.25, 0.25};
    assert_int_equal(kn_bezier_init(ctx, &f, 2, 1, false, (int[]){2, 2}), KN_OK);
    for (int k = 0; k < 9; k++) f.coef[k] = square[k / 3] + square[k % 3] - 0.16;
    assert_int_equal(kn_trim_cut(ctx, &in, &out, &report, &whole, &f, 1e-4), KN_OK);
    assert_true(report.below && report.above && in.nloops == 1 && out.nloops == 2);
    assert_true(fabs(scene_trim_area(&in) - 3.14159265358979 * 0.16) < 1e-4 * 2.6); // tol times the circumference
    for (int n = 1; n <= 4; n++) {
        double sum = 0.0;
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                const double lo[2] = {(double)i / n, (double)j / n}, hi[2] = {(i + 1.0) / n, (j + 1.0) / n};
                assert_int_equal(kn_trim_restrict(ctx, &part, &any, &out, lo, hi), KN_OK);
                if (!any) continue;
                assert_int_equal(kn_trim_check(ctx, &part), KN_OK);
                sum += scene_trim_area(&part) / (n * n);
            }
        assert_true(fabs(sum - scene_trim_area(&out)) < 1e-8); // snapping to sides: 1e-9 times their lengths
    }
    // the middle is empty, and a corner is all there
    assert_int_equal(kn_trim_restrict(ctx, &part, &any, &out, (double[]){0.4, 0.4}, (double[]){0.6, 0.6}), KN_OK);
    assert_true(!any && part.nloops == 0);
    assert_int_equal(kn_trim_restrict(ctx, &part, &any, &out, (double[]){0, 0}, (double[]){0.1, 0.1}), KN_OK);
    assert_true(any && fabs(scene_trim_area(&part) - 1.0) < 1e-12);
    assert_int_equal(kn_trim_restrict(ctx, &part, &any, &whole, (double[]){0, 0}, (double[]){0.1, 0.1}), KN_OK);
    assert_true(any && part.nloops == 0);
    assert_int_equal(kn_trim_restrict(ctx, &part, &any, &out, (double[]){0.5, 0}, (double[]){0.5, 1}), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    kn_trim_clear(ctx, &in), kn_trim_clear(ctx, &out), kn_trim_clear(ctx, &part);
    kn_bezier_clear(ctx, &f);
    test_ctx_end(ctx, &memory);
}

// Two patches that share an edge, run in opposite directions: their cuts meet it in the same points. And a curve
// turned twice is itself.
static void neighbours_agree(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(8);
    int met = 0;
    for (int trial = 0; trial < test_scale(40); trial++) {
        kn_bezier f = {0}, g = {0};
        kn_trim whole = {0}, a[2] = {0}, b[2] = {0};
        kn_trim_cut_report report;
        random_function(ctx, &f, &rng, 3, 3);
        random_function(ctx, &g, &rng, 3, 3);
        for (int k = 0; k <= 3; k++) g.coef[4 * k] = f.coef[12 + 3 - k]; // g(r, 0) = f(1, 1 - r)
        assert_int_equal(kn_trim_cut(ctx, &a[0], &a[1], &report, &whole, &f, tol), KN_OK);
        assert_int_equal(kn_trim_cut(ctx, &b[0], &b[1], &report, &whole, &g, tol), KN_OK);
        for (int s = 0; s < 2; s++)
            for (int i = 0; i < a[s].ncurves; i++) {
                const kn_spline *c = &a[s].curves[i];
                int n = c->count[0];
                if (c->coef[0] != 1.0 || c->coef[n] == 0.0 || c->coef[n] == 1.0) continue;
                bool found = false;
                for (int j = 0; j < b[s].ncurves; j++)
                    found = found || (b[s].curves[j].coef[b[s].curves[j].count[0]] == 0.0 &&
                                      b[s].curves[j].coef[0] == 1.0 - c->coef[n]);
                assert_true(found);
                met++;
                kn_spline copy = {0};
                assert_int_equal(kn_spline_copy(ctx, &copy, c), KN_OK);
                kn_trim_turn(&copy);
                assert_true(copy.coef[0] == c->coef[n - 1] && copy.knots[0][0] == -c->knots[0][n + 1]);
                kn_trim_turn(&copy);
                assert_memory_equal(copy.coef, c->coef, 2 * (size_t)n * sizeof(double));
                kn_spline_clear(ctx, &copy);
            }
        for (int k = 0; k < 2; k++) kn_trim_clear(ctx, &a[k]), kn_trim_clear(ctx, &b[k]);
        kn_bezier_clear(ctx, &f), kn_bezier_clear(ctx, &g);
    }
    assert_true(met > 10);
    test_ctx_end(ctx, &memory);
}

// Along an edge, through corners, and what cannot be decided or is refused.
static void borders(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_trim whole = {0}, a = {0}, b = {0};
    kn_trim_cut_report report;
    double edge[4] = {0, 0, 1, 1}, diagonal[4] = {0, 1, -1, 0}, corner[4] = {0, 1, 1, 2}, wrong[4] = {0, NAN, 1, 1};
    kn_bezier f = {.nvars = 2, .ncomp = 1, .degree = {1, 1}, .coef = edge};
    assert_int_equal(kn_trim_cut(ctx, &a, &b, &report, &whole, &f, tol), KN_OK); // zero along r = 0: no cut
    assert_true(report.above && !report.below && a.nloops == 0 && b.nloops == 0);
    f.coef = diagonal;
    assert_int_equal(kn_trim_cut(ctx, &a, &b, &report, &whole, &f, tol), KN_OK);
    assert_true(report.above && report.below && scene_trim_area(&a) == 0.5 && scene_trim_area(&b) == 0.5);
    f.coef = corner;
    assert_int_equal(kn_trim_cut(ctx, &a, &b, &report, &whole, &f, tol), KN_OK);
    assert_true(report.above && !report.below);
    f.coef = diagonal; // a region cut where it was cut before
    assert_int_equal(kn_trim_cut(ctx, &a, &b, &report, &whole, &f, tol), KN_OK);
    kn_trim again = {0};
    assert_int_equal(kn_trim_cut(ctx, &again, &b, &report, &a, &f, tol), KN_EUNDECIDED);
    assert_true(again.nloops == 0 && b.nloops == 1);
    kn_ctx_clear_error(ctx);
    f.coef = wrong;
    assert_int_equal(kn_trim_cut(ctx, &again, &b, &report, &whole, &f, tol), KN_EDOMAIN);
    f.coef = edge;
    assert_int_equal(kn_trim_cut(ctx, &again, &b, &report, &whole, &f, 0.0), KN_EDOMAIN);
    f.nvars = 1;
    assert_int_equal(kn_trim_cut(ctx, &again, &b, &report, &whole, &f, tol), KN_EDOMAIN);
    kn_answer answer = KN_YES;
    assert_int_equal(kn_trim_contains(ctx, &answer, &a, (double[]){NAN, 0}), KN_EDOMAIN);
    assert_int_equal(kn_trim_contains(ctx, &answer, &whole, (double[]){0.5, 1.5}), KN_OK);
    assert_int_equal(answer, KN_NO);
    kn_ctx_clear_error(ctx);
    // a loop that is open, and one that is numbered wrongly
    double keep = a.curves[0].coef[0];
    a.curves[0].coef[0] += 0.125;
    assert_int_equal(kn_trim_check(ctx, &a), KN_EDOMAIN);
    a.curves[0].coef[0] = keep;
    a.loop_end[0]--;
    assert_int_equal(kn_trim_check(ctx, &a), KN_EDOMAIN);
    a.loop_end[0]++;
    for (int k = 0; k < a.ncurves; k++) kn_trim_turn(&a.curves[k]); // each curve alone: not closed
    assert_int_equal(kn_trim_check(ctx, &a), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    kn_trim_clear(ctx, &a), kn_trim_clear(ctx, &b);
    test_ctx_end(ctx, &memory);
}

static kn_status cut_twice(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_trim whole = {0}, a = {0}, b = {0}, c = {0};
    kn_trim_cut_report report;
    bool any;
    double f[4] = {-0.4, -0.5, 0.6, 0.7}, g[4] = {-0.3, 0.7, -0.5, 0.5};
    const kn_bezier first = {.nvars = 2, .ncomp = 1, .degree = {1, 1}, .coef = f};
    const kn_bezier second = {.nvars = 2, .ncomp = 1, .degree = {1, 1}, .coef = g};
    kn_answer answer;
    kn_status status = kn_trim_cut(ctx, &a, &b, &report, &whole, &first, 0.05);
    if (status == KN_OK) status = kn_trim_cut(ctx, &b, &c, &report, &a, &second, 0.05);
    if (status == KN_OK) status = kn_trim_copy(ctx, &c, &b);
    if (status == KN_OK) status = kn_trim_check(ctx, &c);
    if (status == KN_OK) status = kn_trim_contains(ctx, &answer, &c, (double[]){0.1, 0.1});
    if (status == KN_OK) status = kn_trim_restrict(ctx, &c, &any, &b, (double[]){0, 0}, (double[]){0.25, 1});
    kn_trim_clear(ctx, &a), kn_trim_clear(ctx, &b), kn_trim_clear(ctx, &c);
    return status;
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    test_allocation_failures(cut_twice, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(random_cuts), cmocka_unit_test(restricted),
                                       cmocka_unit_test(neighbours_agree), cmocka_unit_test(borders),
                                       cmocka_unit_test(every_allocation_may_fail)};
    return cmocka_run_group_tests_name("trim/cut", tests, NULL, NULL);
}
