// SPDX-License-Identifier: Apache-2.0
// Cuts of regions: against the sign of f at random points, areas, and the pieces' own shapes.
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

// Shoelace of polylines: all curves here are of degree 1.
static double area_of(const kn_trim *trim)
{
    double area = 0.0;
    if (trim->nloops == 0) return 1.0;
    for (int i = 0; i < trim->ncurves; i++) {
        const kn_spline *c = &trim->curves[i];
        int n = c->count[0];
        assert_int_equal(c->degree[0], 1);
        for (int k = 0; k + 1 < n; k++)
            area += 0.5 * (c->coef[k] * c->coef[n + k + 1] - c->coef[k + 1] * c->coef[n + k]);
    }
    return area;
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
                area += area_of(&part[2 * k + i]);
            }
            assert_true(fabs(area - area_of(&side[k])) < 1e-12); // they share their curves
        }
        if (first.below && first.above) {
            assert_true(fabs(area_of(&side[0]) + area_of(&side[1]) - 1.0) < 1e-12);
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

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(random_cuts)};
    return cmocka_run_group_tests_name("trim/cut", tests, NULL, NULL);
}
