// SPDX-License-Identifier: Apache-2.0
// Products of splines on few knots, exactly: every coefficient within the bound that spline.h states.
#include "tests/oracle/spline_cases.h"

#include <math.h>
#include <stdlib.h>

#include <flint/flint.h>

// Coefficients of that kind; weights are positive whatever the kind.
static void spline_fill(spline_world *w, kn_spline *s, exact_kind kind)
{
    size_t n = kn_spline_count(s), all = n * (size_t)s->ncomp;
    exact_fill(s->coef, all, &w->rng, kind);
    for (size_t i = all - n; i < all && s->rational; i++)
        s->coef[i] = kind == EXACT_INTEGERS ? test_int(&w->rng, 1, 4) : test_uniform(&w->rng, 0.5, 2.0);
}

// A spline over a's domain: of degree q, on every other of a's knots and one or two of its own.
static void companion(spline_world *w, kn_spline *b, const kn_spline *a, int q, int ncomp, bool rational,
                      exact_kind kind)
{
    int degree[3], count[3];
    double *knots[3];
    for (int d = 0; d < a->nvars; d++) {
        double lo, hi, own = INFINITY;
        int n = 0, last = a->count[d];
        kn_spline_domain(a, d, &lo, &hi);
        knots[d] = malloc((size_t)(last + 2 * q + 8) * sizeof(double));
        assert_non_null(knots[d]);
        degree[d] = q;
        if (q > 0) own = lo + 0.375 * (hi - lo);
        while (n <= q) knots[d][n++] = lo;
        for (int i = a->degree[d] + 1; i < last; i++) {
            double k = a->knots[d][i];
            if (own < k) knots[d][n++] = own, own = INFINITY;
            if (i % 2 && knots[d][n - 1] != k) knots[d][n++] = k;
        }
        count[d] = n;
        for (int i = 0; i <= q; i++) knots[d][n++] = hi;
    }
    assert_int_equal(kn_spline_init(w->ctx, b, a->nvars, ncomp + rational, rational, degree, count,
                                    (const double *const *)knots, NULL),
                     KN_OK);
    for (int d = 0; d < a->nvars; d++) free(knots[d]);
    spline_fill(w, b, kind);
}

static int lesser(int a, int b)
{
    return a < b ? a : b;
}

// L of a product of pieces that is summed `per` times.
static int roundings_of(int nvars, const int *p, const int *q, int per)
{
    int terms = per, r = 1, c = 1;
    for (int d = 0; d < nvars; d++) {
        int pairs = lesser(p[d], q[d]) + 1;
        terms *= pairs;
        if (d < nvars - 2) per *= pairs;
        if (d == nvars - 2) r = pairs;
        if (d == nvars - 1) c = pairs;
    }
    return lesser(terms, 20 + per * (r + c + 40));
}

// 0: degrees of the result add up to 6 at most; 1: more. There the bound counts roundings of means that mostly
// average out, in each variable, and sizes that grow by J in each.
static int judge_of(const kn_spline *r)
{
    int sum = 0;
    for (int d = 0; d < r->nvars; d++) sum += r->degree[d];
    return sum > 6;
}

static void product(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *a)
{
    kn_spline b = {0}, c = {0};
    companion(w, &b, a, test_int(&w->rng, 0, 3), 1, false, kind);
    assert_int_equal(kn_spline_product(w->ctx, &c, a, &b), KN_OK);
    const spline_term term = {1.0, {a, &b}, {0, 0}};
    spline_judge_terms(w, &judge[judge_of(&c)], &c, 0, &term, 1,
                       3 * a->nvars + roundings_of(a->nvars, a->degree, b.degree, 1));
    kn_spline_clear(w->ctx, &b), kn_spline_clear(w->ctx, &c);
}

static void products(void **state)
{
    (void)state;
    spline_world w;
    spline_begin(&w, 1);
    exact_judge_t judge[2] = {{.name = "spline_product, low degrees"}, {.name = "spline_product, high degrees"}};
    spline_for_all(&w, judge, product);
    exact_judge_end(&judge[0], 100.0);
    exact_judge_end(&judge[1], 600.0);
    spline_end(&w);
}

// Weights of c, a product of those of a and b.
static void weights(spline_world *w, exact_judge_t *judge, const kn_spline *a, const kn_spline *b, const kn_spline *c)
{
    const spline_term term = {1.0, {a, b}, {kn_spline_dim(a), kn_spline_dim(b)}};
    if (c->rational)
        spline_judge_terms(w, judge, c, kn_spline_dim(c), &term, 1,
                           3 * a->nvars + roundings_of(a->nvars, a->degree, b->degree, 1));
}

static void dot_and_cross(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *shape)
{
    kn_spline a = {0}, b = {0}, c = {0};
    if (shape->nvars > 1 || shape->degree[0] > 5) return;
    companion(w, &a, shape, test_int(&w->rng, 1, 3), 3, test_int(&w->rng, 0, 1), kind);
    companion(w, &b, shape, test_int(&w->rng, 0, 2), 3, test_int(&w->rng, 0, 1), kind);
    assert_int_equal(kn_spline_dot(w->ctx, &c, &a, &b), KN_OK);
    spline_term t[3];
    for (int i = 0; i < 3; i++) t[i] = (spline_term){1.0, {&a, &b}, {i, i}};
    spline_judge_terms(w, &judge[0], &c, 0, t, 3, 3 * a.nvars + roundings_of(a.nvars, a.degree, b.degree, 3));
    weights(w, &judge[0], &a, &b, &c);
    assert_int_equal(kn_spline_cross(w->ctx, &c, &a, &b), KN_OK);
    for (int i = 0; i < 3; i++) {
        int u = (i + 1) % 3, v = (i + 2) % 3;
        t[0] = (spline_term){1.0, {&a, &b}, {u, v}};
        t[1] = (spline_term){-1.0, {&a, &b}, {v, u}};
        spline_judge_terms(w, &judge[1], &c, i, t, 2, 3 * a.nvars + roundings_of(a.nvars, a.degree, b.degree, 2));
    }
    weights(w, &judge[1], &a, &b, &c);
    if (a.rational || b.rational) {
        bool minus = test_int(&w->rng, 0, 1);
        assert_int_equal((minus ? kn_spline_difference : kn_spline_sum)(w->ctx, &c, &a, &b), KN_OK);
        for (int i = 0; i < 3; i++) {
            t[0] = (spline_term){1.0, {&a, &b}, {i, 3}};
            t[1] = (spline_term){minus ? -1.0 : 1.0, {&a, &b}, {3, i}};
            spline_judge_terms(w, &judge[2], &c, i, t, 2, 3 * a.nvars + roundings_of(a.nvars, a.degree, b.degree, 2));
        }
        weights(w, &judge[2], &a, &b, &c);
    }
    kn_spline_clear(w->ctx, &a), kn_spline_clear(w->ctx, &b), kn_spline_clear(w->ctx, &c);
}

static void dots_and_crosses(void **state)
{
    (void)state;
    spline_world w;
    spline_begin(&w, 2);
    exact_judge_t judge[3] = {{.name = "spline_dot"}, {.name = "spline_cross"}, {.name = "rational spline_sum"}};
    spline_for_all(&w, judge, dot_and_cross);
    for (int i = 0; i < 3; i++) exact_judge_end(&judge[i], 100.0);
    spline_end(&w);
}

// L + L' + 4 nvars beside the maps: b x c first, then times a.
static void determinant(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *shape)
{
    kn_spline a = {0}, b = {0}, c = {0}, det = {0};
    int inner[3];
    if (shape->nvars > 1 || shape->degree[0] > 3) return;
    companion(w, &a, shape, test_int(&w->rng, 0, 2), 3, test_int(&w->rng, 0, 1), kind);
    companion(w, &b, shape, test_int(&w->rng, 0, 2), 3, false, kind);
    companion(w, &c, shape, test_int(&w->rng, 0, 2), 3, false, kind);
    assert_int_equal(kn_spline_determinant(w->ctx, &det, &a, &b, &c), KN_OK);
    spline_term t[6];
    for (int i = 0; i < 6; i++) {
        int u = i / 2, v = (u + 1 + i % 2) % 3;
        t[i] = (spline_term){i % 2 ? -1.0 : 1.0, {&a, &b, &c}, {u, v, 3 - u - v}};
    }
    for (int d = 0; d < a.nvars; d++) inner[d] = b.degree[d] + c.degree[d];
    int sums = roundings_of(a.nvars, b.degree, c.degree, 2) + roundings_of(a.nvars, a.degree, inner, 3);
    spline_judge_terms(w, judge, &det, 0, t, 6, sums + 4 * a.nvars);
    kn_spline_clear(w->ctx, &a), kn_spline_clear(w->ctx, &b), kn_spline_clear(w->ctx, &c);
    kn_spline_clear(w->ctx, &det);
}

static void determinants(void **state)
{
    (void)state;
    spline_world w;
    spline_begin(&w, 3);
    exact_judge_t judge = {.name = "spline_determinant"};
    spline_for_all(&w, &judge, determinant);
    exact_judge_end(&judge, 150.0); // degrees up to 9, three operands: 80 to 120
    spline_end(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(products), cmocka_unit_test(dots_and_crosses),
                                       cmocka_unit_test(determinants)};
    int failed = cmocka_run_group_tests_name("oracle/spline_product", tests, NULL, NULL);
    flint_cleanup();
    return failed;
}
