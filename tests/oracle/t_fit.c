// SPDX-License-Identifier: Apache-2.0
// Fits against exact collocation matrices: what is left over in A c = f and in A^T (A c - f) = 0, without any rounding,
// and interpolation against the exact solution.
#include <math.h>
#include <string.h>

#include <flint/flint.h>
#include <flint/fmpq_mat.h>

#include <knurl/fit.h>

#include "tests/oracle/exact.h"

enum { ROOM = 160 };

// row[0 .. count-1] = the B-splines at x, by Cox and de Boor over the rationals; at the end of the domain from the left.
static void exact_row(fmpq *row, const double *knots, int degree, int count, double x)
{
    fmpq t[ROOM], at[1], left[1], right[1], size[1];
    int last = count + degree;
    fmpq_init(at), fmpq_init(left), fmpq_init(right), fmpq_init(size);
    for (int i = 0; i <= last; i++) fmpq_init(&t[i]), fmpq_of_double(&t[i], knots[i]);
    fmpq_of_double(at, x);
    fmpq b[ROOM];
    for (int i = 0; i < last; i++) {
        bool inside = knots[i] <= x && x < knots[i + 1];
        bool end = x == knots[last] && knots[i] < x && knots[i + 1] == x;
        fmpq_init(&b[i]);
        fmpq_set_si(&b[i], inside || end, 1);
    }
    for (int p = 1; p <= degree; p++)
        for (int i = 0; i + p < last; i++) {
            fmpq_zero(left), fmpq_zero(right);
            if (knots[i] < knots[i + p]) {
                fmpq_sub(left, at, &t[i]), fmpq_sub(size, &t[i + p], &t[i]);
                fmpq_div(left, left, size), fmpq_mul(left, left, &b[i]);
            }
            if (knots[i + 1] < knots[i + p + 1]) {
                fmpq_sub(right, &t[i + p + 1], at), fmpq_sub(size, &t[i + p + 1], &t[i + 1]);
                fmpq_div(right, right, size), fmpq_mul(right, right, &b[i + 1]);
            }
            fmpq_add(&b[i], left, right);
        }
    for (int i = 0; i < count; i++) fmpq_set(&row[i], &b[i]);
    for (int i = 0; i <= last; i++) fmpq_clear(&t[i]);
    for (int i = 0; i < last; i++) fmpq_clear(&b[i]);
    fmpq_clear(at), fmpq_clear(left), fmpq_clear(right), fmpq_clear(size);
}

static void exact_matrix(fmpq_mat_t a, const double *knots, int degree, int count, const double *sites, int nsites)
{
    fmpq_mat_init(a, nsites, count);
    for (int i = 0; i < nsites; i++) exact_row(fmpq_mat_entry(a, i, 0), knots, degree, count, sites[i]);
}

// out = (a x b) c or, with absolute, (a x b) |c|; c holds rows of b's columns.
static void apply_both(fmpq_mat_t out, const fmpq_mat_t a, const fmpq_mat_t b, const double *c, bool absolute)
{
    fmpq_mat_t m, bt, half;
    fmpq_mat_init(m, fmpq_mat_ncols(a), fmpq_mat_ncols(b));
    fmpq_mat_init(bt, fmpq_mat_ncols(b), fmpq_mat_nrows(b));
    fmpq_mat_init(half, fmpq_mat_nrows(a), fmpq_mat_ncols(b));
    fmpq_mat_init(out, fmpq_mat_nrows(a), fmpq_mat_nrows(b));
    for (slong i = 0; i < fmpq_mat_nrows(m); i++)
        for (slong j = 0; j < fmpq_mat_ncols(m); j++) {
            double x = c[i * fmpq_mat_ncols(m) + j];
            fmpq_of_double(fmpq_mat_entry(m, i, j), absolute ? fabs(x) : x);
        }
    fmpq_mat_transpose(bt, b);
    fmpq_mat_mul(half, a, m);
    fmpq_mat_mul(out, half, bt);
    fmpq_mat_clear(m), fmpq_mat_clear(bt), fmpq_mat_clear(half);
}

// Knots in [0,1] with spans that differ by up to `spread`, multiplicities up to the degree.
static void random_knots(test_rng *rng, double *knots, int degree, int count, double spread)
{
    double at = 0.0;
    for (int i = 0, times = degree + 1; i <= count + degree; i++) {
        bool rise = i > degree && i <= count &&
                    (times >= (degree > 0 ? degree : 1) || i == count || test_int(rng, 0, 2) > 0);
        if (rise) at += exp(test_uniform(rng, -log(spread), 0.0));
        times = rise ? 1 : times + 1;
        knots[i] = at;
    }
}

static void sites_between(test_rng *rng, double *sites, const double *knots, int degree, int count, kn_ctx *ctx)
{
    double g[ROOM]; // Greville's, moved towards their neighbours' middles
    assert_int_equal(kn_fit_greville(ctx, g, knots, degree, count), KN_OK);
    for (int i = 0; i < count; i++) {
        double lo = i > 0 ? 0.5 * (g[i - 1] + g[i]) : g[i], hi = i + 1 < count ? 0.5 * (g[i] + g[i + 1]) : g[i];
        double x = g[i] + 0.8 * test_uniform(rng, 0, 1) * ((i % 2 ? hi : lo) - g[i]);
        if (x > knots[i] && x < knots[i + degree + 1]) g[i] = x;
    }
    memcpy(sites, g, (size_t)count * sizeof *g);
}

// |A c - f| <= gamma(sum_d (8 p_d + 4)) A|c|.
static void interpolation_leaves_no_more(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    exact_judge_t judge = {.name = "interpolation, residual"};
    for (int round = test_scale(10); round > 0; round--) {
        int p[2], n[2];
        double knots[2][ROOM], sites[2][ROOM], values[400];
        const double *k[] = {knots[0], knots[1]}, *x[] = {sites[0], sites[1]};
        for (int d = 0; d < 2; d++) {
            p[d] = test_int(&rng, 0, round % 5 ? 4 : 9), n[d] = p[d] + 1 + test_int(&rng, 0, 6);
            random_knots(&rng, knots[d], p[d], n[d], round % 2 ? 1.0 : 1e6);
            sites_between(&rng, sites[d], knots[d], p[d], n[d], ctx);
        }
        exact_fill(values, (size_t)(n[0] * n[1]), &rng, (exact_kind)(round % EXACT_KINDS));
        kn_spline s = {0};
        assert_int_equal(kn_fit_interpolate(ctx, &s, 2, 1, p, n, k, x, values), KN_OK);
        fmpq_mat_t a, b, value, size;
        exact_matrix(a, knots[0], p[0], n[0], sites[0], n[0]);
        exact_matrix(b, knots[1], p[1], n[1], sites[1], n[1]);
        apply_both(value, a, b, s.coef, false);
        apply_both(size, a, b, s.coef, true);
        for (int i = 0; i < n[0] * n[1]; i++)
            exact_judge_one(&judge, values[i], fmpq_mat_entry(value, i / n[1], i % n[1]),
                            fmpq_mat_entry(size, i / n[1], i % n[1]), 8 * (p[0] + p[1]) + 8);
        fmpq_mat_clear(a), fmpq_mat_clear(b), fmpq_mat_clear(value), fmpq_mat_clear(size);
        kn_spline_clear(ctx, &s);
    }
    exact_judge_end(&judge, 300);
    test_ctx_end(ctx, &memory);
}

// The same in one variable up to the highest degree; and against the solution c' of A c' = f:
// |c - c'| <= |A^-1| e A|c|.
static void interpolation_of_high_degree(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    exact_judge_t residual = {.name = "interpolation, high degree"}, error = {.name = "interpolation, solution"};
    static const int degrees[] = {1, 3, 5, 8, 24, KN_MAX_DEGREE};
    for (int round = 0; round < 6; round++) {
        int p = degrees[round], n = p + 1 + test_int(&rng, 0, 3), ops = 8 * p + 4;
        double knots[ROOM], sites[ROOM], values[ROOM];
        const double *k = knots, *x = sites;
        for (int i = 0; i <= n + p; i++) knots[i] = i <= p ? 0 : i >= n ? n - p : i - p;
        for (int i = 0; i < n;
             i++) { // denser at the ends, as high degrees need it; short numbers keep fractions short
            double at = i == n - 1 ? 1.0 : 0.5 - 0.5 * cos(i * acos(-1.0) / (n - 1));
            sites[i] = floor(knots[n] * at * 4096.0) / 4096.0;
        }
        exact_fill(values, (size_t)n, &rng, EXACT_UNIFORM);
        kn_spline s = {0};
        assert_int_equal(kn_fit_interpolate(ctx, &s, 1, 1, &p, &n, &k, &x, values), KN_OK);
        fmpq_mat_t a, one, value, size, f, solution;
        exact_matrix(a, knots, p, n, sites, n);
        fmpq_mat_init(one, 1, 1), fmpq_mat_one(one);
        apply_both(value, a, one, s.coef, false);
        apply_both(size, a, one, s.coef, true);
        for (int i = 0; i < n; i++)
            exact_judge_one(&residual, values[i], fmpq_mat_entry(value, i, 0), fmpq_mat_entry(size, i, 0), ops);
        if (p <= 8) { // an exact solution takes too long beyond
            fmpq_mat_init(f, n, 1), fmpq_mat_init(solution, n, 1);
            for (int i = 0; i < n; i++) fmpq_of_double(fmpq_mat_entry(f, i, 0), values[i]);
            assert_true(fmpq_mat_solve(solution, a, f));
            fmpq_mat_t inverse, bound;
            fmpq_mat_init(inverse, n, n), fmpq_mat_init(bound, n, 1);
            assert_true(fmpq_mat_inv(inverse, a));
            for (int i = 0; i < n * n; i++)
                fmpq_abs(fmpq_mat_entry(inverse, i / n, i % n), fmpq_mat_entry(inverse, i / n, i % n));
            fmpq_mat_mul(bound, inverse, size);
            for (int i = 0; i < n; i++)
                exact_judge_one(&error, s.coef[i], fmpq_mat_entry(solution, i, 0), fmpq_mat_entry(bound, i, 0), ops);
            fmpq_mat_clear(inverse), fmpq_mat_clear(bound);
            fmpq_mat_clear(f), fmpq_mat_clear(solution);
        }
        fmpq_mat_clear(a), fmpq_mat_clear(one), fmpq_mat_clear(value), fmpq_mat_clear(size);
        kn_spline_clear(ctx, &s);
    }
    exact_judge_end(&residual, 0);
    exact_judge_end(&error, 0);
    test_ctx_end(ctx, &memory);
}

// A curve c that minimises |(A + dA) c - (f + df)|, |dA| <= g |A|, |df| <= g |f| in Frobenius norms, has
// |A^T (A c - f)| <= g |A| (2 (|A| |c| + |f|)) + O(g^2), g = gamma(9 (m + n) + 5 p).
static void least_squares_is_stationary(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    exact_judge_t judge = {.name = "least squares, gradient"};
    for (int round = test_scale(10); round > 0; round--) {
        int p = test_int(&rng, 0, 6), n = p + 1 + test_int(&rng, 0, 8), m = n + test_int(&rng, 0, 20);
        double knots[ROOM], sites[ROOM], values[ROOM], norm[3] = {0};
        const double *k = knots, *x = sites;
        exact_fill(values, (size_t)m, &rng, round % 2 ? EXACT_UNIFORM : EXACT_CANCEL);
        for (int i = 0; i < m; i++) sites[i] = (i > 0 ? sites[i - 1] : 0.0) + test_int(&rng, 1, 400) / 256.0;
        assert_int_equal(kn_fit_averaged_knots(ctx, knots, p, n, m, sites), KN_OK);
        kn_spline s = {0};
        assert_int_equal(kn_fit_least_squares(ctx, &s, NULL, 1, 1, &p, &n, &k, &m, &x, values, NULL), KN_OK);
        fmpq_mat_t a, at, one, value, gradient;
        exact_matrix(a, knots, p, n, sites, m);
        fmpq_mat_init(one, 1, 1), fmpq_mat_one(one);
        apply_both(value, a, one, s.coef, false);
        for (int i = 0; i < m; i++) {
            fmpq_t f;
            fmpq_init(f), fmpq_of_double(f, values[i]);
            fmpq_sub(fmpq_mat_entry(value, i, 0), fmpq_mat_entry(value, i, 0), f);
            fmpq_clear(f);
            norm[0] += values[i] * values[i];
            for (int j = 0; j < n; j++) {
                double entry = fmpq_get_d(fmpq_mat_entry(a, i, j));
                norm[1] += entry * entry;
            }
        }
        for (int j = 0; j < n; j++) norm[2] += s.coef[j] * s.coef[j];
        double size = 2.0 * sqrt(norm[1]) * (sqrt(norm[1] * norm[2]) + sqrt(norm[0])) * (1.0 + 1e-9);
        fmpq_mat_init(at, n, m), fmpq_mat_init(gradient, n, 1);
        fmpq_mat_transpose(at, a);
        fmpq_mat_mul(gradient, at, value);
        fmpq_t of_size;
        fmpq_init(of_size), fmpq_of_double(of_size, size);
        for (int j = 0; j < n; j++)
            exact_judge_one(&judge, 0.0, fmpq_mat_entry(gradient, j, 0), of_size, 9 * (m + n) + 5 * p);
        fmpq_clear(of_size);
        fmpq_mat_clear(a), fmpq_mat_clear(at), fmpq_mat_clear(one), fmpq_mat_clear(value), fmpq_mat_clear(gradient);
        kn_spline_clear(ctx, &s);
    }
    exact_judge_end(&judge, 0);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(interpolation_leaves_no_more),
                                       cmocka_unit_test(interpolation_of_high_degree),
                                       cmocka_unit_test(least_squares_is_stationary)};
    return cmocka_run_group_tests_name("oracle/fit", tests, NULL, NULL);
}
