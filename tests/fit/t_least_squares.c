// SPDX-License-Identifier: Apache-2.0
// Least squares on grids and of scattered points, with given control points.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/fit/check.h"

enum { ROOM = 32, POINTS = 1024 };

typedef struct problem {
    int nvars, dim;
    int degree[2], count[2], nsites[2];
    double knots[2][ROOM], sites[2][ROOM];
    const double *k[2], *x[2];
    size_t npoints; // of the grid, or scattered
    double at[2 * POINTS], values[2 * POINTS], weights[POINTS], given[2 * POINTS];
    bool weighted;
    kn_fit_fixed fixed;
} problem;

static int by_double(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Random sites that suit, and up to five more.
static void random_problem(kn_ctx *ctx, problem *w, test_rng *rng, int nvars)
{
    *w = (problem){.nvars = nvars, .dim = test_int(rng, 1, 2), .fixed = {.coef = w->given}};
    for (int d = 0; d < nvars; d++) {
        w->degree[d] = test_int(rng, 0, 4);
        w->count[d] = w->degree[d] + 1 + test_int(rng, 0, 8);
        kn_spline s;
        test_random_spline(ctx, &s, rng, 1, 1, false, &w->degree[d], &w->count[d], 9);
        memcpy(w->knots[d], s.knots[0], (size_t)(w->count[d] + w->degree[d] + 1) * sizeof(double));
        kn_spline_clear(ctx, &s);
        check_random_sites(rng, w->sites[d], w->knots[d], w->degree[d], w->count[d]);
        w->nsites[d] = w->count[d] + test_int(rng, 0, 5);
        for (int i = w->count[d]; i < w->nsites[d]; i++)
            w->sites[d][i] = test_uniform(rng, w->knots[d][0], w->knots[d][w->count[d]]);
        qsort(w->sites[d], (size_t)w->nsites[d], sizeof(double), by_double);
        w->k[d] = w->knots[d], w->x[d] = w->sites[d];
    }
    w->npoints = check_product(w->nsites, nvars);
    for (size_t i = 0; i < w->npoints; i++) {
        check_grid_place(w->at + i * (size_t)nvars, i, nvars, w->nsites, w->x);
        w->weights[i] = 1.0;
        for (int c = 0; c < w->dim; c++) w->values[i * (size_t)w->dim + (size_t)c] = test_int(rng, -99, 99);
    }
    for (int i = 0; i < 2 * POINTS; i++) w->given[i] = test_uniform(rng, -9, 9);
}

static kn_status on_grid(kn_ctx *ctx, kn_spline *out, double *residual, const problem *w)
{
    return kn_fit_least_squares(ctx, out, residual, w->nvars, w->dim, w->degree, w->count, w->k, w->nsites, w->x,
                                w->values, &w->fixed);
}

static kn_status scattered(kn_ctx *ctx, kn_spline *out, double *residual, const problem *w)
{
    return kn_fit_scattered(ctx, out, residual, w->nvars, w->dim, w->degree, w->count, w->k, w->npoints, w->at,
                            w->values, w->weighted ? w->weights : NULL, &w->fixed);
}

static bool is_fixed(const problem *w, size_t at)
{
    bool fixed = false;
    for (int d = w->nvars - 1; d >= 0; d--) {
        int k = (int)(at % (size_t)w->count[d]);
        fixed = fixed || k < w->fixed.first[d] || k >= w->count[d] - w->fixed.last[d];
        at /= (size_t)w->count[d];
    }
    return fixed;
}

// At the minimum sum_i w_i^2 N_j(x_i) (s(x_i) - f_i) = 0 for each free j. A backward stable solution of the problem with
// rows w_i N(x_i) of norm at most w_i has there at most gamma(K) (F |f| + F^2 |c|), in Euclidean norms, F^2 = sum w_i^2
// >= |A|_F^2, in each variable: both terms of the residual against dA and A against df and dA c. K counts a few
// operations for each rotation that a row meets.
static void assert_minimum(kn_ctx *ctx, const kn_spline *s, double residual, const problem *w)
{
    double norm[4] = {0}, value[2], largest = 0.0, operations = check_eval_operations(s);
    size_t n = kn_spline_count(s), dim = (size_t)w->dim;
    for (int d = 0; d < w->nvars; d++) operations += 9.0 * (double)(w->npoints + n) + 5 * w->degree[d];
    for (size_t i = 0; i < n * dim; i++) norm[0] += s->coef[i] * s->coef[i];
    static double off[2 * POINTS];
    for (size_t i = 0; i < w->npoints; i++) {
        double square = 0.0, weight = w->weights[i] * w->weights[i];
        assert_int_equal(kn_spline_eval(ctx, value, s, w->at + i * (size_t)w->nvars), KN_OK);
        norm[1] += weight;
        for (size_t c = 0; c < dim; c++) {
            off[i * dim + c] = value[c] - w->values[i * dim + c];
            norm[2] += weight * w->values[i * dim + c] * w->values[i * dim + c];
            square += off[i * dim + c] * off[i * dim + c];
        }
        largest = fmax(largest, sqrt(square));
    }
    double c = sqrt(norm[0]), F = sqrt(norm[1]), f = sqrt(norm[2]);
    double tolerance = check_gamma(operations) * w->nvars * (F * f + F * F * c) * 2.0;
    assert_true(fabs(residual - largest) <= check_gamma(operations) * 4.0 * (c + f)); // weights >= 1
    kn_spline unit = {0};
    assert_int_equal(kn_spline_components(ctx, &unit, s, 0, 1), KN_OK);
    for (size_t j = 0; j < n; j++) {
        double gradient[2] = {0};
        for (size_t i = 0; i < n; i++) unit.coef[i] = i == j;
        for (size_t i = 0; i < w->npoints; i++) {
            assert_int_equal(kn_spline_eval(ctx, value, &unit, w->at + i * (size_t)w->nvars), KN_OK);
            for (size_t k = 0; k < dim; k++)
                gradient[k] += w->weights[i] * w->weights[i] * value[0] * off[i * dim + k];
        }
        for (size_t k = 0; k < dim; k++) {
            if (is_fixed(w, j))
                assert_true(s->coef[k * n + j] == w->given[k * n + j]);
            else
                assert_true(fabs(gradient[k]) <= tolerance);
        }
    }
    kn_spline_clear(ctx, &unit);
}

static void random_layers(problem *w, test_rng *rng)
{
    for (int d = 0; d < w->nvars; d++) {
        w->fixed.first[d] = test_int(rng, 0, w->count[d] > 2 ? 2 : w->count[d] - 1);
        w->fixed.last[d] = test_int(rng, 0, w->count[d] - w->fixed.first[d] > 2 ? 1 : 0);
    }
}

static void minimises_on_grids(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    static problem w;
    for (int round = test_scale(16); round > 0; round--) {
        random_problem(ctx, &w, &rng, 1 + round % 2);
        if (round % 3 == 0) random_layers(&w, &rng);
        kn_spline s = {0};
        double residual = -1.0;
        assert_int_equal(on_grid(ctx, &s, &residual, &w), KN_OK);
        assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
        assert_minimum(ctx, &s, residual, &w);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

static void minimises_over_points(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    static problem w;
    for (int round = test_scale(16); round > 0; round--) {
        random_problem(ctx, &w, &rng, 1 + round % 2);
        if (round % 3 == 0) random_layers(&w, &rng);
        w.weighted = round % 4 < 2;
        for (size_t i = w.npoints - 1; i > 0; i--) { // another order, and some points twice
            size_t j = (size_t)test_int(&rng, 0, (int)i);
            for (int d = 0; d < w.nvars; d++) {
                double x = w.at[i * (size_t)w.nvars + (size_t)d];
                w.at[i * (size_t)w.nvars + (size_t)d] = w.at[j * (size_t)w.nvars + (size_t)d];
                w.at[j * (size_t)w.nvars + (size_t)d] = x;
            }
        }
        for (size_t i = 0; i < w.npoints && w.weighted; i++) w.weights[i] = test_int(&rng, 1, 5);
        if (w.npoints + 3 < POINTS)
            for (int k = 0; k < 3; k++, w.npoints++) {
                memcpy(w.at + w.npoints * (size_t)w.nvars, w.at, (size_t)w.nvars * sizeof(double));
                for (int c = 0; c < w.dim; c++)
                    w.values[w.npoints * (size_t)w.dim + (size_t)c] = test_int(&rng, -99, 99);
                w.weights[w.npoints] = 1.0;
            }
        kn_spline s = {0};
        double residual = -1.0;
        assert_int_equal(scattered(ctx, &s, &residual, &w), KN_OK);
        assert_minimum(ctx, &s, residual, &w);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// Data of a spline of the space come back: residuals, in norm, of a backward stable solution of a problem without any.
static void reproduces_the_space(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    static problem w;
    for (int round = test_scale(20); round > 0; round--) {
        random_problem(ctx, &w, &rng, 1 + round % 2);
        kn_spline a, s = {0};
        double value[2], residual, norm = 0.0;
        assert_int_equal(kn_spline_init(ctx, &a, w.nvars, w.dim, false, w.degree, w.count, w.k, NULL), KN_OK);
        size_t n = kn_spline_count(&a) * (size_t)w.dim;
        for (size_t i = 0; i < n; i++) a.coef[i] = test_int(&rng, -9, 9);
        for (size_t i = 0; i < w.npoints; i++) {
            assert_int_equal(kn_spline_eval(ctx, value, &a, w.at + i * (size_t)w.nvars), KN_OK);
            for (int c = 0; c < w.dim; c++) w.values[i * (size_t)w.dim + (size_t)c] = value[c];
        }
        w.fixed.coef = a.coef; // layers that are given agree with the data
        random_layers(&w, &rng);
        for (int kind = 0; kind < 2; kind++) {
            assert_int_equal((kind ? scattered : on_grid)(ctx, &s, &residual, &w), KN_OK);
            norm = 0.0;
            for (size_t i = 0; i < n; i++) norm += s.coef[i] * s.coef[i] + a.coef[i] * a.coef[i];
            double operations = 2.0 * check_eval_operations(&a) + w.nvars * (9.0 * (double)(w.npoints + n) + 5 * 4);
            assert_true(residual <= check_gamma(operations) * 2.0 * w.nvars * sqrt((double)w.npoints * norm));
        }
        kn_spline_clear(ctx, &a);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// As many sites as free control points: complete spline interpolation. A cubic polynomial with its end derivatives, all
// powers of two: x^3 on [0,4] has the coefficients of its blossom, products of three knots.
static void end_derivatives(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 0, 0, 1, 2, 4, 4, 4, 4}, sites[] = {1, 2};
    double coef[12];
    for (int i = 0; i < 12; i++) coef[i] = -77;
    const double start[] = {0, 1, 0, 0}, end[] = {64, 1, 48, 0, 24, 0}; // x^3 and 1: value, first, second derivative
    assert_int_equal(kn_fit_end_coefficients(ctx, coef, 2, knots, 3, 6, false, 2, start), KN_OK);
    assert_int_equal(kn_fit_end_coefficients(ctx, coef, 2, knots, 3, 6, true, 3, end), KN_OK);
    const double expected[] = {0, 0, 0, 8, 32, 64};
    for (int i = 0; i < 6; i++) {
        assert_true(coef[i] == (i == 2 ? -77 : expected[i]));
        assert_true(coef[6 + i] == (i == 2 ? -77 : 1));
    }
    kn_spline s = {0};
    kn_fit_fixed fixed = {.first = {2}, .last = {2}, .coef = coef};
    double residual;
    const double values[] = {1, 1, 8, 1};
    assert_int_equal(kn_fit_least_squares(ctx, &s, &residual, 1, 2, (int[]){3}, (int[]){6}, (const double *[]){knots},
                                          (int[]){2}, (const double *[]){sites}, values, &fixed),
                     KN_OK);
    // Two unknowns in a matrix of condition below 10, numbers up to 64.
    for (int i = 0; i < 6; i++) {
        assert_true(fabs(s.coef[i] - expected[i]) <= 10 * check_gamma(100) * 64);
        assert_true(fabs(s.coef[6 + i] - 1) <= 10 * check_gamma(100) * 64);
    }
    double before[12];
    memcpy(before, coef, sizeof coef);
    assert_int_equal(kn_fit_end_coefficients(ctx, coef, 2, knots, 3, 6, true, 0, end), KN_EDOMAIN);
    assert_int_equal(kn_fit_end_coefficients(ctx, coef, 2, knots, 3, 6, true, 5, end), KN_EDOMAIN);
    assert_int_equal(kn_fit_end_coefficients(ctx, coef, 2, knots, 3, 3, true, 1, end), KN_EDOMAIN);
    assert_memory_equal(before, coef, sizeof coef);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

typedef kn_status (*fit)(kn_ctx *ctx, kn_spline *out, double *residual, const problem *w);

static void expect(kn_ctx *ctx, fit f, const problem *w, kn_status expected, const char *said)
{
    kn_spline out = {0};
    double residual = -5.0;
    kn_ctx_clear_error(ctx);
    kn_status status = f(ctx, &out, &residual, w);
    if (status != expected || !strstr(kn_ctx_message(ctx), said))
        fail_msg("%s \"%s\", not %s \"%s\"", kn_status_name(status), kn_ctx_message(ctx), kn_status_name(expected),
                 said);
    assert_true(out.nvars == 0 && !out.coef && residual == -5.0);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    static problem w, good;
    do random_problem(ctx, &good, &rng, 2);
    while (good.degree[0] != 2 || good.degree[1] != 3 || good.count[1] != 6 || good.count[0] != 5);
    w = good, w.fixed.coef = w.given;
    w.fixed.first[1] = 3, w.fixed.last[1] = 3;
    expect(ctx, on_grid, &w, KN_EDOMAIN, "variable 1: 3 and 3 fixed layers of 6");
    expect(ctx, scattered, &w, KN_EDOMAIN, "variable 1: 3 and 3 fixed layers of 6");
    w.fixed.first[1] = -1;
    expect(ctx, on_grid, &w, KN_EDOMAIN, "fixed layers");
    w.fixed.first[1] = 1, w.fixed.last[1] = 0, w.fixed.coef = NULL;
    expect(ctx, on_grid, &w, KN_EDOMAIN, "without coefficients");
    w = good, w.x[1] = w.sites[1], w.nsites[1] = 5;
    expect(ctx, on_grid, &w, KN_EUNDEFINED, "variable 1: 5 sites for 6");
    w.nsites[1] = 6;
    for (int i = 0; i < 6; i++) w.sites[1][i] = 1e-3 * (i + 1); // all in the first span
    expect(ctx, on_grid, &w, KN_EUNDEFINED, "variable 1: no site for B-spline");
    w.sites[1][3] = w.sites[1][2];
    expect(ctx, on_grid, &w, KN_EDOMAIN, "increase");
    w.sites[1][3] = -1;
    expect(ctx, on_grid, &w, KN_EDOMAIN, "is not in");

    w = good, w.at[7] = -1;
    expect(ctx, scattered, &w, KN_EDOMAIN, "point 3");
    w = good, w.weighted = true, w.weights[5] = 0;
    expect(ctx, scattered, &w, KN_EDOMAIN, "point 5: weight 0");
    w = good;
    for (size_t i = 0; i < w.npoints; i++) w.at[2 * i] = w.at[2 * i + 1] * w.knots[0][5] / w.knots[1][6]; // a line
    expect(ctx, scattered, &w, KN_EUNDEFINED, "do not determine");
    w = good, w.nvars = 1, w.npoints = 30;
    for (size_t i = 0; i < w.npoints; i++) w.at[i] = (double)(i % 4) * 0.125; // four places for five B-splines
    expect(ctx, scattered, &w, KN_EUNDEFINED, "variable 0: no site for B-spline");
    w.degree[0] = -1;
    expect(ctx, scattered, &w, KN_EDOMAIN, "degree -1");
    expect(ctx, on_grid, &w, KN_EDOMAIN, "degree -1");
    // Values of x^2 that underflow.
    const double knots[] = {0, 0, 0, 1, 1, 1};
    memcpy(w.knots[0], knots, sizeof knots);
    w.degree[0] = 2, w.count[0] = 3, w.npoints = 3, w.nsites[0] = 3;
    for (int i = 0; i < 3; i++) w.at[i] = w.sites[0][i] = i * 1e-200;
    w.k[0] = w.knots[0], w.x[0] = w.sites[0];
    expect(ctx, on_grid, &w, KN_EUNDECIDED, "variable 0");
    expect(ctx, scattered, &w, KN_EUNDECIDED, "free control point");
    test_ctx_end(ctx, &memory);
}

typedef struct job {
    fit f;
    problem *w;
} job;

static kn_status once(kn_ctx *ctx, void *user)
{
    const job *j = user;
    kn_spline out = {0};
    double residual = -5.0;
    kn_status status = j->f(ctx, &out, &residual, j->w);
    if (status != KN_OK) assert_true(out.nvars == 0 && !out.coef && residual == -5.0);
    kn_spline_clear(ctx, &out);
    return status;
}

static kn_status end_once(kn_ctx *ctx, void *user)
{
    double *coef = user;
    const double knots[] = {0, 0, 0, 1, 1, 1}, d[] = {4, 2};
    coef[0] = coef[1] = -5;
    kn_status status = kn_fit_end_coefficients(ctx, coef, 1, knots, 2, 3, false, 2, d);
    if (status != KN_OK) assert_true(coef[0] == -5 && coef[1] == -5);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    static problem w;
    random_problem(ctx, &w, &rng, 2);
    w.fixed.first[0] = 1, w.fixed.coef = w.given;
    if (w.count[0] < 2) w.fixed.first[0] = 0;
    test_allocation_failures(once, &(job){on_grid, &w});
    test_allocation_failures(once, &(job){scattered, &w});
    double coef[3];
    test_allocation_failures(end_once, coef);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(minimises_on_grids),
                                       cmocka_unit_test(minimises_over_points),
                                       cmocka_unit_test(reproduces_the_space),
                                       cmocka_unit_test(end_derivatives),
                                       cmocka_unit_test(failures),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("fit/least_squares", tests, NULL, NULL);
}
