// SPDX-License-Identifier: Apache-2.0
// Products, sums and determinants of splines over domains that differ; determinants, differences and multiples; and
// that repeated operations allocate nothing.
#include <math.h>
#include <string.h>

#include "kernel/knots.h"
#include "tests/spline/oracle.h"
#include "tests/support/support.h"

typedef kn_status (*binary)(kn_ctx *, kn_spline *, const kn_spline *, const kn_spline *);

// Of degree 1 .. 3 over [lo,hi] in each variable, knots at integers.
static kn_spline random_over(kn_ctx *ctx, test_rng *rng, int nvars, int dim, bool rational, const int *lo,
                             const int *hi)
{
    int degree[2], count[2];
    double knots[2][40];
    const double *at[2];
    for (int d = 0; d < nvars; d++) {
        int p = degree[d] = test_int(rng, 1, 3), n = 0;
        for (int i = 0; i <= p; i++) knots[d][n++] = lo[d];
        for (int x = lo[d] + 1; x < hi[d]; x++)
            for (int m = test_int(rng, -1, p); m > 0; m--) knots[d][n++] = x;
        for (int i = 0; i <= p; i++) knots[d][n++] = hi[d];
        count[d] = n - p - 1, at[d] = knots[d];
    }
    kn_spline s;
    assert_int_equal(kn_spline_init(ctx, &s, nvars, dim + rational, rational, degree, count, at, NULL), KN_OK);
    size_t n = kn_spline_count(&s);
    for (size_t i = 0; i < n * (size_t)s.ncomp; i++)
        s.coef[i] = i < n * (size_t)dim ? test_int(rng, -9, 9) : test_int(rng, 1, 4);
    return s;
}

static long double weight(const kn_spline *s, const long double *x)
{
    return s->rational ? x[kn_spline_dim(s)] : 1;
}

// kind 0 sum, 1 difference, 2 product, 3 dot, 4 cross: homogeneous values of the result times a common factor.
static void expect(long double *e, int kind, const kn_spline *a, const long double *x, const kn_spline *b,
                   const long double *y)
{
    int dim = 3;
    long double wa = weight(a, x), wb = weight(b, y);
    memset(e, 0, 4 * sizeof *e);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        if (kind < 2) e[i] = x[i] * wb + (kind ? -1 : 1) * y[i] * wa;
        if (kind == 2) e[i] = x[i] * y[i];
        if (kind == 3) e[0] += x[i] * y[i];
        if (kind == 4) e[i] = x[j] * y[k] - x[k] * y[j];
    }
    if (kind == 3) dim = 1;
    e[dim] = wa * wb;
}

// The header: J gamma(T + 3 nvars + sum (12 (p + q) + 3)) times the largest coefficients of the operands and the
// number of products in a value. That also bounds the error of a value, a mean of coefficients.
static double bound_of(const kn_spline *out, const kn_spline *a, const kn_spline *b, int products)
{
    int roundings = 3 * a->nvars, terms = products;
    for (int d = 0; d < a->nvars; d++) {
        roundings += 12 * (a->degree[d] + b->degree[d]) + 3;
        terms *= (a->degree[d] < b->degree[d] ? a->degree[d] : b->degree[d]) + 1;
    }
    return oracle_growth(out) * oracle_gamma(roundings + terms) * fmax(1.0, oracle_largest(a)) *
           fmax(1.0, oracle_largest(b)) * products;
}

static const binary operations[] = {kn_spline_sum, kn_spline_difference, kn_spline_product, kn_spline_dot,
                                    kn_spline_cross};

static void check_overlap(kn_ctx *ctx, test_rng *rng, int nvars, int kind, bool ra, bool rb)
{
    int lo[2][2], hi[2][2];
    for (int d = 0; d < nvars; d++)
        for (int i = 0; i < 2; i++) {
            lo[i][d] = test_int(rng, -2, 1);
            hi[i][d] = test_int(rng, 2, 5);
        }
    kn_spline a = random_over(ctx, rng, nvars, 3, ra, lo[0], hi[0]);
    kn_spline b = random_over(ctx, rng, nvars, 3, rb, lo[1], hi[1]), c = {0}, same = {0};
    assert_int_equal(operations[kind](ctx, &c, &a, &b), KN_OK);
    assert_int_equal(kn_spline_check(ctx, &c), KN_OK);
    double bound = bound_of(&c, &a, &b, kind == 3 ? 3 : 2);
    for (int round = 0; round < 5; round++) {
        double at[2];
        long double x[8], y[8], z[8], e[8];
        for (int d = 0; d < nvars; d++) {
            double from = lo[0][d] > lo[1][d] ? lo[0][d] : lo[1][d], to = hi[0][d] < hi[1][d] ? hi[0][d] : hi[1][d];
            double first, last;
            kn_spline_domain(&c, d, &first, &last);
            assert_true(first == from && last == to);
            at[d] = test_uniform(rng, from, to);
        }
        oracle_homogeneous(x, NULL, &a, at, NULL, NULL);
        oracle_homogeneous(y, NULL, &b, at, NULL, NULL);
        oracle_homogeneous(z, NULL, &c, at, NULL, NULL);
        expect(e, kind, &a, x, &b, y);
        for (int i = 0; i < c.ncomp; i++) assert_true(fabsl(z[i] - e[i]) <= bound);
    }
    assert_int_equal(kn_spline_copy(ctx, &same, &a), KN_OK); // in place: the same bits
    assert_int_equal(operations[kind](ctx, &same, &same, &b), KN_OK);
    assert_memory_equal(same.coef, c.coef, kn_spline_count(&c) * (size_t)c.ncomp * sizeof *c.coef);
    kn_spline_clear(ctx, &a);
    kn_spline_clear(ctx, &b);
    kn_spline_clear(ctx, &c);
    kn_spline_clear(ctx, &same);
}

static void domains_that_differ(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = test_scale(3); round > 0; round--)
        for (int nvars = 1; nvars <= 2; nvars++)
            for (int kind = 0; kind < 5; kind++)
                for (int r = 0; r < 4; r++) check_overlap(ctx, &rng, nvars, kind, r & 1, r & 2);
    test_ctx_end(ctx, &memory);
}

// Values against products of values; six products of three in each.
static void determinants(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    for (int round = test_scale(20); round > 0; round--) {
        int nvars = test_int(&rng, 1, 2), lo[2] = {0, 0}, hi[2] = {3, 2};
        kn_spline s[3], det = {0}, copy = {0};
        for (int i = 0; i < 3; i++) s[i] = random_over(ctx, &rng, nvars, 3, test_int(&rng, 0, 2) == 0, lo, hi);
        assert_int_equal(kn_spline_determinant(ctx, &det, &s[0], &s[1], &s[2]), KN_OK);
        bool rational = s[0].rational || s[1].rational || s[2].rational;
        assert_true(det.rational == rational && det.ncomp == 1 + rational);
        double size = fmax(1.0, oracle_largest(&s[0])) * fmax(1.0, oracle_largest(&s[1])) *
                      fmax(1.0, oracle_largest(&s[2])) * 6.0,
               growth = oracle_growth(&det);
        int operations_done = 4 * nvars, terms = 6; // products of three, binomials once: T and T', splitting, joining
        for (int d = 0; d < nvars; d++) {
            operations_done += 12 * det.degree[d] + 3;
            terms *= 2 * (det.degree[d] + 1);
        }
        for (int k = 0; k < 5; k++) {
            double at[2];
            long double x[3][4], z[4], e = 0, w = 1;
            for (int d = 0; d < nvars; d++) at[d] = test_uniform(&rng, lo[d], hi[d]);
            for (int i = 0; i < 3; i++) {
                oracle_homogeneous(x[i], NULL, &s[i], at, NULL, NULL);
                w *= weight(&s[i], x[i]);
            }
            oracle_homogeneous(z, NULL, &det, at, NULL, NULL);
            for (int i = 0; i < 3; i++) {
                int j = (i + 1) % 3, m = (i + 2) % 3;
                e += x[0][i] * (x[1][j] * x[2][m] - x[1][m] * x[2][j]);
            }
            double bound = growth * oracle_gamma(operations_done + terms) * size;
            assert_true(fabsl(z[0] - e) <= bound);
            if (rational) assert_true(fabsl(z[1] - w) <= bound);
        }
        assert_int_equal(kn_spline_copy(ctx, &copy, &s[2]), KN_OK);
        assert_int_equal(kn_spline_determinant(ctx, &copy, &s[0], &s[1], &copy), KN_OK);
        assert_memory_equal(copy.coef, det.coef, kn_spline_count(&det) * (size_t)det.ncomp * sizeof *det.coef);
        for (int i = 0; i < 3; i++) kn_spline_clear(ctx, &s[i]);
        kn_spline_clear(ctx, &det);
        kn_spline_clear(ctx, &copy);
    }
    test_ctx_end(ctx, &memory);
}

static void scales_and_differences(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    const int lo[2] = {0, 0}, hi[2] = {3, 3};
    for (int rational = 0; rational < 2; rational++) {
        kn_spline a = random_over(ctx, &rng, 2, 3, rational, lo, hi), b = {0}, c = {0};
        size_t n = kn_spline_count(&a), all = n * (size_t)a.ncomp;
        assert_int_equal(kn_spline_scale(ctx, &b, &a, -2.5), KN_OK);
        for (size_t i = 0; i < all; i++) assert_true(b.coef[i] == (i < 3 * n ? -2.5 * a.coef[i] : a.coef[i]));
        assert_int_equal(kn_spline_difference(ctx, &c, &b, &a), KN_OK); // one weight: it stays
        for (size_t i = 0; i < all; i++) assert_true(c.coef[i] == (i < 3 * n ? b.coef[i] - a.coef[i] : a.coef[i]));
        assert_int_equal(kn_spline_scale(ctx, &a, &a, 2.0), KN_OK);
        assert_int_equal(kn_spline_difference(ctx, &a, &a, &a), KN_OK);
        for (size_t i = 0; i < 3 * n; i++) assert_true(a.coef[i] == 0.0);
        kn_spline_clear(ctx, &a);
        kn_spline_clear(ctx, &b);
        kn_spline_clear(ctx, &c);
    }
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    kn_spline a = random_over(ctx, &rng, 2, 3, false, (int[]){0, 0}, (int[]){2, 2});
    kn_spline b = random_over(ctx, &rng, 2, 3, false, (int[]){1, 2}, (int[]){3, 3}); // they share an edge alone
    kn_spline plane = random_over(ctx, &rng, 2, 2, false, (int[]){0, 0}, (int[]){2, 2});
    kn_spline curve = random_over(ctx, &rng, 1, 3, false, (int[]){0}, (int[]){2}), out = {0}, empty = {0};
    for (int i = 0; i < 5; i++) {
        assert_int_equal(operations[i](ctx, &out, &a, &b), KN_EDOMAIN);
        assert_int_equal(operations[i](ctx, &out, &a, &curve), KN_EDOMAIN);
        assert_int_equal(operations[i](ctx, &out, &a, &plane), KN_EDOMAIN);
        assert_int_equal(operations[i](ctx, &out, &empty, &a), KN_EDOMAIN);
    }
    assert_int_equal(kn_spline_determinant(ctx, &out, &a, &a, &b), KN_EDOMAIN);
    assert_int_equal(kn_spline_determinant(ctx, &out, &a, &plane, &a), KN_EDOMAIN);
    assert_int_equal(kn_spline_determinant(ctx, &out, &curve, &a, &a), KN_EDOMAIN);
    assert_int_equal(kn_spline_determinant(ctx, &out, &a, &a, &empty), KN_EDOMAIN);
    assert_int_equal(kn_spline_scale(ctx, &out, &empty, 2.0), KN_EDOMAIN);
    assert_int_equal(kn_spline_elevate(ctx, &plane, &a, (int[]){20, 3}), KN_OK);
    assert_int_equal(kn_spline_determinant(ctx, &out, &plane, &plane, &plane), KN_ELIMIT);
    assert_int_equal(out.nvars, 0);
    kn_spline_clear(ctx, &a);
    kn_spline_clear(ctx, &b);
    kn_spline_clear(ctx, &plane);
    kn_spline_clear(ctx, &curve);
    test_ctx_end(ctx, &memory);
}

// The first call makes the result's arrays and the scratch, the others find them.
static void nothing_is_allocated_again(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    for (int rational = 0; rational < 2; rational++) {
        kn_spline a = random_over(ctx, &rng, 2, 3, rational, (int[]){0, 0}, (int[]){4, 4});
        kn_spline b = random_over(ctx, &rng, 2, 3, false, (int[]){1, 0}, (int[]){5, 3}), c = {0};
        for (int kind = 0; kind < 7; kind++) {
            size_t before = 0;
            for (int i = 0; i < 4; i++) {
                before = kn_ctx_counters(ctx).allocations;
                kn_status status = kind < 5    ? operations[kind](ctx, &c, &a, &b)
                                   : kind == 5 ? kn_spline_determinant(ctx, &c, &a, &b, &a)
                                               : kn_spline_scale(ctx, &c, &b, 3.0);
                assert_int_equal(status, KN_OK);
            }
            assert_int_equal(kn_ctx_counters(ctx).allocations, before);
        }
        kn_spline_clear(ctx, &a);
        kn_spline_clear(ctx, &b);
        kn_spline_clear(ctx, &c);
    }
    test_ctx_end(ctx, &memory);
}

typedef struct memory_case {
    int kind;
    bool rational;
} memory_case;

static kn_status call(kn_ctx *ctx, void *user)
{
    const memory_case *m = user;
    const double k[] = {0, 0, 1, 2, 2}, l[] = {1, 1, 3, 3}, coef[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 1, 2, 3};
    const double *const ka[] = {k}, *const kb[] = {l};
    kn_spline a = {0}, b = {0}, out = {0};
    kn_status status = kn_spline_init(ctx, &a, 1, 3 + m->rational, m->rational, (int[]){1}, (int[]){3}, ka, coef);
    if (status == KN_OK) status = kn_spline_init(ctx, &b, 1, 3, false, (int[]){1}, (int[]){2}, kb, coef);
    for (int pass = 0; pass < 2 && status == KN_OK; pass++) {
        kn_spline *to = pass ? &b : &out, before = *to;
        if (m->kind < 5) status = operations[m->kind](ctx, to, &a, &b);
        if (m->kind == 5) status = kn_spline_determinant(ctx, to, &a, &a, &b);
        if (m->kind == 6) status = kn_spline_scale(ctx, to, &a, 2.0);
        if (status != KN_OK) assert_memory_equal(&before, to, sizeof before);
    }
    kn_spline_clear(ctx, &a);
    kn_spline_clear(ctx, &b);
    kn_spline_clear(ctx, &out);
    return status;
}

static void out_of_memory(void **state)
{
    (void)state;
    for (int kind = 0; kind < 7; kind++)
        for (int rational = 0; rational < 2; rational++) {
            memory_case m = {kind, rational != 0};
            test_allocation_failures(call, &m);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(domains_that_differ),        cmocka_unit_test(determinants),
        cmocka_unit_test(scales_and_differences),     cmocka_unit_test(failures),
        cmocka_unit_test(nothing_is_allocated_again), cmocka_unit_test(out_of_memory),
    };
    return cmocka_run_group_tests_name("spline/product", tests, NULL, NULL);
}
