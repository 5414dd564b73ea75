// SPDX-License-Identifier: Apache-2.0
// Interpolation on grids.
#include <math.h>
#include <string.h>

#include "tests/fit/check.h"

enum { ROOM = 24 }; // knots and sites in one variable

typedef struct problem {
    int nvars, dim;
    int degree[3], count[3];
    double knots[3][ROOM], sites[3][ROOM], values[4096];
    const double *k[3], *x[3];
} problem;

static void random_problem(kn_ctx *ctx, problem *w, test_rng *rng, bool greville)
{
    w->nvars = test_int(rng, 1, 3), w->dim = test_int(rng, 1, 3);
    for (int d = 0; d < w->nvars; d++) {
        w->degree[d] = test_int(rng, 0, 5);
        w->count[d] = w->degree[d] + 1 + test_int(rng, 0, w->nvars > 2 ? 3 : 8);
        w->k[d] = w->knots[d], w->x[d] = w->sites[d];
        kn_spline s;
        test_random_spline(ctx, &s, rng, 1, 1, false, &w->degree[d], &w->count[d], 9);
        memcpy(w->knots[d], s.knots[0], (size_t)(w->count[d] + w->degree[d] + 1) * sizeof(double));
        kn_spline_clear(ctx, &s);
        if (greville)
            assert_int_equal(kn_fit_greville(ctx, w->sites[d], w->knots[d], w->degree[d], w->count[d]), KN_OK);
        else
            check_random_sites(rng, w->sites[d], w->knots[d], w->degree[d], w->count[d]);
    }
    size_t n = check_product(w->count, w->nvars) * (size_t)w->dim;
    for (size_t i = 0; i < n; i++) w->values[i] = test_int(rng, -99, 99);
}

static kn_status solve(kn_ctx *ctx, kn_spline *out, const problem *w)
{
    return kn_fit_interpolate(ctx, out, w->nvars, w->dim, w->degree, w->count, w->k, w->x, w->values);
}

// |A c - f| <= gamma(sum_d (8 p_d + 4)) A|c|, whatever the condition; the evaluation that checks
// it adds gamma(E) A|c|.
static void takes_the_values(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    static problem w;
    for (int round = test_scale(40); round > 0; round--) {
        random_problem(ctx, &w, &rng, round % 2 == 0);
        kn_spline s = {0};
        assert_int_equal(solve(ctx, &s, &w), KN_OK);
        assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
        double e = 0.0, at[3], value[3];
        for (int d = 0; d < w.nvars; d++) e += 8 * w.degree[d] + 4;
        double factor = check_gamma(e + check_eval_operations(&s) +
                                    10.0 * w.nvars); // the products of e's: far below 10
        size_t n = check_product(w.count, w.nvars);
        for (size_t i = 0; i < n; i++) {
            check_grid_place(at, i, w.nvars, w.count, w.x);
            assert_int_equal(kn_spline_eval(ctx, value, &s, at), KN_OK);
            double size = check_size(ctx, &s, at);
            for (int c = 0; c < w.dim; c++)
                assert_true(fabs(value[c] - w.values[i * (size_t)w.dim + (size_t)c]) <= factor * size);
        }
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// Degree 1 at its knots: coefficients are the values. Degree 2 on one span at 0, 1/2, 1: 2 f(1/2) - (f(0) + f(1)) / 2.
static void exact_cases(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    const double k1[] = {0, 0, 1, 3, 4, 4}, x1[] = {0, 1, 3, 4}, f1[] = {7, 1, -2, 0, 5, 5, 3, 9};
    assert_int_equal(
        kn_fit_interpolate(ctx, &s, 1, 2, (int[]){1}, (int[]){4}, (const double *[]){k1}, (const double *[]){x1}, f1),
        KN_OK);
    for (int i = 0; i < 4; i++) assert_true(s.coef[i] == f1[2 * i] && s.coef[4 + i] == f1[2 * i + 1]);
    const double k2[] = {0, 0, 0, 1, 1, 1}, x2[] = {0, 0.5, 1};
    const double f2[] = {4, 1, -2, 8, 5, 6, 0, -6, 2}; // f[i][j]
    assert_int_equal(kn_fit_interpolate(ctx, &s, 2, 1, (int[]){2, 2}, (int[]){3, 3}, (const double *[]){k2, k2},
                                        (const double *[]){x2, x2}, f2),
                     KN_OK);
    double g[9], h[9]; // the rule along the first variable, then along the second
    for (int j = 0; j < 3; j++)
        g[j] = f2[j], g[6 + j] = f2[6 + j], g[3 + j] = 2 * f2[3 + j] - (f2[j] + f2[6 + j]) / 2;
    for (int i = 0; i < 9; i += 3) h[i] = g[i], h[i + 2] = g[i + 2], h[i + 1] = 2 * g[i + 1] - (g[i] + g[i + 2]) / 2;
    for (int i = 0; i < 9; i++) assert_true(s.coef[i] == h[i]);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// The edge of a surface is the curve through the edge's values, bit for bit; corners are the values.
static void edges_depend_on_themselves(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    static problem w;
    for (int round = test_scale(30); round > 0; round--) {
        do random_problem(ctx, &w, &rng, true);
        while (w.nvars != 2 || w.degree[0] < 1 || w.degree[1] < 1);
        kn_spline s = {0}, edge = {0};
        assert_int_equal(solve(ctx, &s, &w), KN_OK);
        int m = w.count[0], n = w.count[1];
        for (int e = 0; e < 4; e++) { // 0, 1: the ends of the first variable; 2, 3: of the second
            int along = e < 2 ? 1 : 0, length = along ? n : m, step = along ? 1 : n;
            int first = e == 1 ? (m - 1) * n : e == 3 ? n - 1 : 0;
            double values[3 * ROOM];
            for (int i = 0; i < length * w.dim; i++)
                values[i] = w.values[(first + i / w.dim * step) * w.dim + i % w.dim];
            assert_int_equal(kn_fit_interpolate(ctx, &edge, 1, w.dim, &w.degree[along], &w.count[along], &w.k[along],
                                                &w.x[along], values),
                             KN_OK);
            for (int c = 0; c < w.dim; c++) {
                for (int i = 0; i < length; i++)
                    assert_true(edge.coef[c * length + i] == s.coef[c * m * n + first + i * step]);
                assert_true(edge.coef[c * length] == values[c]);
                assert_true(edge.coef[c * length + length - 1] == values[(length - 1) * w.dim + c]);
            }
        }
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &edge);
    }
    test_ctx_end(ctx, &memory);
}

static void expect(kn_ctx *ctx, const problem *w, kn_status expected, const char *said)
{
    kn_spline out = {0};
    kn_ctx_clear_error(ctx);
    assert_int_equal(solve(ctx, &out, w), expected);
    if (!strstr(kn_ctx_message(ctx), said)) fail_msg("\"%s\" does not say \"%s\"", kn_ctx_message(ctx), said);
    assert_true(out.nvars == 0 && !out.coef);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 0, 1, 2, 3, 3, 3}, sites[] = {0, 0.5, 1.5, 2.5, 3};
    static problem w;
    w = (problem){.nvars = 2, .dim = 1, .degree = {2, 2}, .count = {5, 5}};
    for (int d = 0; d < 2; d++) {
        memcpy(w.knots[d], knots, sizeof knots), memcpy(w.sites[d], sites, sizeof sites);
        w.k[d] = w.knots[d], w.x[d] = w.sites[d];
    }
    // Schoenberg and Whitney: B-spline 2 lives on (0,3), 3 on (1,3), 1 on (0,2), 0 on [0,1), 4 on (2,3].
    static const double bad[][5] = {
        {0, 2, 2.2, 2.5, 3}, {0.5, 0.6, 0.7, 1, 3}, {1, 1.2, 1.5, 2.5, 3}, {0, 0.5, 1, 1.5, 2}};
    static const char *const said[] = {"variable 1: site 1", "variable 1: site 3", "variable 1: site 0",
                                       "variable 1: site 4"};
    for (int i = 0; i < 4; i++) {
        memcpy(w.sites[1], bad[i], sizeof bad[i]);
        expect(ctx, &w, KN_EUNDEFINED, said[i]);
    }
    memcpy(w.sites[1], (const double[]){0, 0.5, 0.5, 2.5, 3}, sizeof sites);
    expect(ctx, &w, KN_EDOMAIN, "increase");
    memcpy(w.sites[1], (const double[]){0, 0.5, NAN, 2.5, 3}, sizeof sites);
    expect(ctx, &w, KN_EDOMAIN, "variable 1: site 2");
    memcpy(w.sites[1], (const double[]){0, 0.5, 1.5, 2.5, 3.5}, sizeof sites);
    expect(ctx, &w, KN_EDOMAIN, "variable 1: site 4");
    memcpy(w.sites[1], sites, sizeof sites);
    w.knots[0][3] = 5;
    expect(ctx, &w, KN_EDOMAIN, "variable 0: knots decrease");
    w.knots[0][3] = 1, w.degree[1] = 5;
    expect(ctx, &w, KN_EDOMAIN, "degree 5");
    w.degree[1] = KN_MAX_DEGREE + 1, w.count[1] = 100;
    expect(ctx, &w, KN_ELIMIT, "degree");
    w.degree[1] = 2, w.count[1] = 5, w.nvars = 0;
    expect(ctx, &w, KN_EDOMAIN, "nvars");
    // 3 x^2 underflows at 1e-200.
    memcpy(w.knots[0], (const double[]){0, 0, 0, 0, 1, 1, 1, 1}, 8 * sizeof(double));
    memcpy(w.sites[0], (const double[]){0, 1e-200, 2e-200, 1}, 4 * sizeof(double));
    w.nvars = 1, w.degree[0] = 3, w.count[0] = 4;
    expect(ctx, &w, KN_EUNDECIDED, "underflow");
    test_ctx_end(ctx, &memory);
}

// A knot of multiplicity degree + 1 cuts the curve in two; a site on it belongs to the right.
static void jumps(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    const double knots[] = {0, 0, 1, 1, 2, 2}, sites[] = {0, 0.5, 1, 2}, f[] = {1, 3, -7, 4};
    assert_int_equal(kn_fit_interpolate(ctx, &s, 1, 1, (int[]){1}, (int[]){4}, (const double *[]){knots},
                                        (const double *[]){sites}, f),
                     KN_OK);
    const double expected[] = {1, 5, -7, 4}; // (1 + 5) / 2 = 3
    for (int i = 0; i < 4; i++) assert_true(s.coef[i] == expected[i]);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// In place, and with the same shape again nothing is allocated.
static void steady_state(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    static problem w;
    random_problem(ctx, &w, &rng, true);
    kn_spline s = {0}, again = {0};
    assert_int_equal(solve(ctx, &s, &w), KN_OK);
    assert_int_equal(kn_spline_copy(ctx, &again, &s), KN_OK);
    size_t calls = atomic_load(&memory.calls);
    for (int d = 0; d < w.nvars; d++) w.k[d] = again.knots[d]; // knots of the output
    assert_int_equal(solve(ctx, &again, &w), KN_OK);
    assert_true(atomic_load(&memory.calls) == calls);
    assert_memory_equal(s.coef, again.coef, kn_spline_count(&s) * (size_t)s.ncomp * sizeof *s.coef);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &again);
    test_ctx_end(ctx, &memory);
}

static kn_status once(kn_ctx *ctx, void *user)
{
    kn_spline out = {0};
    kn_status status = solve(ctx, &out, user);
    if (status != KN_OK) assert_true(out.nvars == 0 && !out.coef);
    kn_spline_clear(ctx, &out);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    static problem w;
    random_problem(ctx, &w, &rng, true);
    test_allocation_failures(once, &w);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(takes_the_values),
                                       cmocka_unit_test(exact_cases),
                                       cmocka_unit_test(edges_depend_on_themselves),
                                       cmocka_unit_test(failures),
                                       cmocka_unit_test(jumps),
                                       cmocka_unit_test(steady_state),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("fit/interpolate", tests, NULL, NULL);
}
