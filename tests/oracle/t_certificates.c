// SPDX-License-Identifier: Apache-2.0
// What the library says about its own errors: *error of reductions, removals and merges against exact distances.
#include "tests/oracle/exact.h"

#include <math.h>
#include <string.h>

#include <flint/flint.h>

typedef struct world {
    test_memory memory;
    kn_ctx *ctx;
    test_rng rng;
    exact value;
    fmpq_t square, x, y, weight;
    double sharpest; // the largest distance / *error so far
} world;

static void begin(world *w, uint64_t salt)
{
    *w = (world){.memory = TEST_MEMORY_INIT, .rng = test_random(salt), .value = exact_new()};
    w->ctx = test_ctx(&w->memory, 1);
    fmpq_init(w->square), fmpq_init(w->x), fmpq_init(w->y), fmpq_init(w->weight);
}

// A bound that is never reached by half is no good either.
static void end(world *w)
{
    printf("# distance/error <= %.3f\n", w->sharpest);
    assert_true(w->sharpest > 0.5);
    fmpq_clear(w->square), fmpq_clear(w->x), fmpq_clear(w->y), fmpq_clear(w->weight);
    exact_free(&w->value);
    test_ctx_end(w->ctx, &w->memory);
}

static void value_of(world *w, fmpq_t out, const kn_spline *s, int comp, const double *at)
{
    exact_of_spline(&w->value, s, comp, at, false);
    exact_value(out, &w->value, at);
    if (!s->rational) return;
    exact_of_spline(&w->value, s, kn_spline_dim(s), at, false);
    exact_value(w->weight, &w->value, at);
    fmpq_div(out, out, w->weight);
}

static void check_at(world *w, const kn_spline *a, const kn_spline *b, double error, const double *at)
{
    fmpq_zero(w->square);
    for (int c = 0; c < kn_spline_dim(a); c++) {
        value_of(w, w->x, a, c, at);
        value_of(w, w->y, b, c, at);
        fmpq_sub(w->x, w->x, w->y);
        fmpq_addmul(w->square, w->x, w->x);
    }
    fmpq_of_double(w->y, error);
    fmpq_mul(w->y, w->y, w->y);
    if (fmpq_cmp(w->square, w->y) > 0)
        fail_msg("degree %d, at %.17g: the distance is more than %.17g", a->degree[0], at[0], error);
    if (fmpq_is_zero(w->y)) return;
    fmpq_div(w->x, w->square, w->y);
    w->sharpest = fmax(w->sharpest, sqrt(fmpz_get_d(fmpq_numref(w->x)) / fmpz_get_d(fmpq_denref(w->x))));
}

// |a - b| <= error at a's breaks, where splines of degree 1 have their largest distances, and in between. b's domain
// holds a's.
static void check(world *w, const kn_spline *a, const kn_spline *b, double error)
{
    if (isinf(error)) return; // a weight of b that is not positive
    for (int i = a->degree[0]; i < a->count[0]; i++)
        for (int k = 0; k < 3; k++) {
            double at[2];
            for (int d = 0; d < a->nvars; d++) {
                int j = d == 0 ? i : test_int(&w->rng, a->degree[d], a->count[d] - 1);
                double lo = a->knots[d][j], hi = a->knots[d][j + 1];
                at[d] = k == 0 || lo == hi ? lo : lo + test_uniform(&w->rng, 0.0, 0.9) * (hi - lo);
            }
            if (at[0] < a->knots[0][a->count[0]]) check_at(w, a, b, error, at);
        }
}

static void random_spline(world *w, kn_spline *s, int least_degree, double amplitude)
{
    int nvars = test_int(&w->rng, 1, 2), degree[2], count[2];
    bool rational = test_int(&w->rng, 0, 1);
    double *knots[2], coef[512], store[2][32];
    for (int d = 0; d < nvars; d++) {
        int p = degree[d] = test_int(&w->rng, least_degree, least_degree + (nvars == 1 ? 3 : 1)), n = 0;
        double x = test_uniform(&w->rng, -1.0, 1.0);
        knots[d] = store[d];
        for (int i = 0; i <= p; i++) knots[d][n++] = x;
        for (int b = test_int(&w->rng, 1, 3); b > 0; b--) {
            x += test_int(&w->rng, 0, 3) ? test_uniform(&w->rng, 0.1, 1.0) : 1e-6;
            for (int i = test_int(&w->rng, 0, 2) ? 1 : test_int(&w->rng, 1, p + 1); i > 0; i--) knots[d][n++] = x;
        }
        x += test_uniform(&w->rng, 0.1, 1.0);
        for (int i = 0; i <= p; i++) knots[d][n++] = x;
        count[d] = n - p - 1;
    }
    int dim = test_int(&w->rng, 1, 2), total = count[0] * (nvars > 1 ? count[1] : 1);
    assert_true(total * (dim + 1) <= 512);
    for (int i = 0; i < total * (dim + rational); i++)
        coef[i] = i < total * dim ? 3.0 + amplitude * test_uniform(&w->rng, -1.0, 1.0)
                                  : exp(amplitude * test_uniform(&w->rng, -1.0, 1.0));
    assert_int_equal(
        kn_spline_init(w->ctx, s, nvars, dim + rational, rational, degree, count, (const double *const *)knots, coef),
        KN_OK);
}

// Large distances, and those of rounding alone.
static void reductions(void **state)
{
    (void)state;
    world w;
    begin(&w, 1);
    for (int round = test_scale(60); round > 0; round--) {
        kn_spline a, b = {0};
        int degree[2];
        double error = -1.0;
        random_spline(&w, &a, 1, 1.0);
        bool raised = round % 2;
        for (int d = 0; d < a.nvars; d++) degree[d] = raised ? a.degree[d] + 1 : a.degree[d];
        assert_int_equal(kn_spline_elevate(w.ctx, &a, &a, degree), KN_OK);
        for (int d = 0; d < a.nvars; d++) degree[d] -= raised ? 1 : test_int(&w.rng, 0, 1);
        assert_int_equal(kn_spline_reduce(w.ctx, &b, &error, &a, degree), KN_OK);
        if (raised) assert_true(error < 1e-11 || isinf(error)); // some thousand roundings, weights e .. 1/e
        check(&w, &a, &b, error);
        kn_spline_clear(w.ctx, &a), kn_spline_clear(w.ctx, &b);
    }
    end(&w);
}

static void removals(void **state)
{
    (void)state;
    static const double tolerance[] = {1e-13, 1e-3, 0.3, 10.0};
    world w;
    begin(&w, 2);
    for (int round = test_scale(120); round > 0; round--) {
        kn_spline a, b = {0};
        double lo, hi, knots[3], error = -1.0, within = tolerance[round % 4];
        random_spline(&w, &a, round % 3 ? 1 : 0, within < 1e-6 ? 1.0 : test_uniform(&w.rng, 0.5, 2.0));
        kn_spline_domain(&a, 0, &lo, &hi);
        for (int i = 0; i < 3; i++) knots[i] = test_uniform(&w.rng, lo + 1e-3, hi - 1e-3);
        assert_int_equal(kn_spline_insert_knots(w.ctx, &a, &a, 0, knots, 3), KN_OK);
        assert_int_equal(kn_spline_remove_knots(w.ctx, &b, &error, &a, 0, within), KN_OK);
        assert_true(error <= within);
        check(&w, &a, &b, error);
        kn_spline_clear(w.ctx, &a), kn_spline_clear(w.ctx, &b);
    }
    end(&w);
}

static void merges(void **state)
{
    (void)state;
    static const double tolerance[] = {0.0, 1e-13, 0.3, 10.0};
    world w;
    begin(&w, 3);
    for (int round = test_scale(80); round > 0; round--) {
        kn_spline a, half[2] = {{0}, {0}}, b = {0};
        double lo, hi, error = -1.0, within = tolerance[round % 4];
        random_spline(&w, &a, 0, 1.0);
        kn_spline_domain(&a, 0, &lo, &hi);
        assert_int_equal(
            kn_spline_subdivide(w.ctx, &half[0], &half[1], &a, 0, lo + test_uniform(&w.rng, 0.1, 0.9) * (hi - lo)),
            KN_OK);
        if (within > 1e-6) half[1].coef[0] += test_uniform(&w.rng, -0.3, 0.3);
        assert_int_equal(kn_spline_merge(w.ctx, &b, &error, &half[0], &half[1], 0, within), KN_OK);
        assert_true(error <= within);
        for (int i = 0; i < 2; i++) check(&w, &half[i], &b, error);
        for (int i = 0; i < 2; i++) kn_spline_clear(w.ctx, &half[i]);
        kn_spline_clear(w.ctx, &a), kn_spline_clear(w.ctx, &b);
    }
    end(&w);
}

static void pieces(void **state)
{
    (void)state;
    world w;
    begin(&w, 4);
    for (int round = test_scale(80); round > 0; round--) {
        kn_bezier a, low = {0};
        kn_spline s = {0}, t = {0};
        int nvars = test_int(&w.rng, 1, 2), degree[2] = {test_int(&w.rng, 1, 6), test_int(&w.rng, 1, 3)};
        double error = -1.0;
        exact_random_bezier(w.ctx, &a, &w.rng, nvars, 3, round % 3 == 0, degree, EXACT_UNIFORM);
        if (round % 2) {
            assert_int_equal(kn_bezier_elevate(w.ctx, &a, &a, (int[]){degree[0] + 1, degree[1] + 2}), KN_OK);
        } else {
            for (int d = 0; d < nvars; d++) degree[d] -= test_int(&w.rng, 0, 1);
        }
        assert_int_equal(kn_bezier_reduce(w.ctx, &low, &error, &a, degree), KN_OK);
        if (round % 2) assert_true(error < 1e-12);
        assert_int_equal(kn_spline_of_bezier(w.ctx, &s, &a), KN_OK);
        assert_int_equal(kn_spline_of_bezier(w.ctx, &t, &low), KN_OK);
        check(&w, &s, &t, error);
        kn_bezier_clear(w.ctx, &a), kn_bezier_clear(w.ctx, &low);
        kn_spline_clear(w.ctx, &s), kn_spline_clear(w.ctx, &t);
    }
    end(&w);
}

// Halves that meet at -2/4. Without a knot there the curve is at 1 instead: a distance of 3/2, of which |P - Q| / w
// and |w - v| R / w are one half each.
static void weights_count(void **state)
{
    (void)state;
    world w;
    begin(&w, 5);
    const double knots[] = {0, 0, 1, 1, 2, 3, 3}, left[] = {1, -2, 1, 4}, right[] = {-2, 1, -1, 4, 1, 1};
    const double *const from[] = {knots, knots + 2};
    double error = -1.0;
    kn_spline a, b, c = {0};
    assert_int_equal(kn_spline_init(w.ctx, &a, 1, 2, true, (int[]){1}, (int[]){2}, from, left), KN_OK);
    assert_int_equal(kn_spline_init(w.ctx, &b, 1, 2, true, (int[]){1}, (int[]){3}, from + 1, right), KN_OK);
    assert_int_equal(kn_spline_merge(w.ctx, &c, &error, &a, &b, 0, 10.0), KN_OK);
    assert_int_equal(c.count[0], 3);
    check(&w, &a, &c, error);
    check(&w, &b, &c, error);
    kn_spline_clear(w.ctx, &a), kn_spline_clear(w.ctx, &b), kn_spline_clear(w.ctx, &c);
    end(&w);
}

// At (1/2, 0), where the reduced piece is at the end of its ball, |P - Q| and |w - v| R add up to 0.1, over w = 1.05.
static void weights_count_in_pieces(void **state)
{
    (void)state;
    world w;
    begin(&w, 6);
    const double coef[] = {1, -1, 0.9, -1, 1, -1, 1, 1, 1.1, 1, 1, 1}, at[] = {0.5, 0.0};
    double error = -1.0;
    kn_bezier a, low = {0};
    kn_spline s = {0}, t = {0};
    assert_int_equal(kn_bezier_init(w.ctx, &a, 2, 2, true, (int[]){2, 1}), KN_OK);
    memcpy(a.coef, coef, sizeof coef);
    assert_int_equal(kn_bezier_reduce(w.ctx, &low, &error, &a, (int[]){1, 1}), KN_OK);
    assert_int_equal(kn_spline_of_bezier(w.ctx, &s, &a), KN_OK);
    assert_int_equal(kn_spline_of_bezier(w.ctx, &t, &low), KN_OK);
    check_at(&w, &s, &t, error, at);
    kn_bezier_clear(w.ctx, &a), kn_bezier_clear(w.ctx, &low);
    kn_spline_clear(w.ctx, &s), kn_spline_clear(w.ctx, &t);
    end(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(reductions),    cmocka_unit_test(removals),
                                       cmocka_unit_test(merges),        cmocka_unit_test(pieces),
                                       cmocka_unit_test(weights_count), cmocka_unit_test(weights_count_in_pieces)};
    int failed = cmocka_run_group_tests_name("oracle/certificates", tests, NULL, NULL);
    flint_cleanup();
    return failed;
}
