// SPDX-License-Identifier: Apache-2.0
// Products of splines on few knots, exactly: every coefficient within the bound that spline.h states.
#include "tests/oracle/spline_cases.h"

#include <math.h>
#include <stdlib.h>

#include <flint/flint.h>

// A spline over a's domain: of degree q, on every other of a's knots and one or two of its own.
static void companion(spline_world *w, kn_spline *b, const kn_spline *a, int q, exact_kind kind)
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
    assert_int_equal(kn_spline_init(w->ctx, b, a->nvars, 1, false, degree, count, (const double *const *)knots, NULL),
                     KN_OK);
    for (int d = 0; d < a->nvars; d++) free(knots[d]);
    exact_fill(b->coef, kn_spline_count(b), &w->rng, kind);
}

typedef struct pair {
    const kn_spline *a, *b;
} pair;

static void product_piece(exact *out, const double *at, void *user)
{
    const pair *p = user;
    exact b = exact_new();
    exact_of_spline(out, p->a, 0, at, false);
    exact_of_spline(&b, p->b, 0, at, false);
    exact_mul(out, out, &b);
    exact_free(&b);
}

// The largest sum of absolute weights of the polar form of a Bezier piece over [lo,hi] at args.
static double growth(int p, double lo, double hi, const double *args)
{
    double w[KN_MAX_DEGREE + 2] = {1.0}, sum = 0.0;
    for (int m = 1; m <= p; m++)
        for (int k = m; k >= 0; k--)
            w[k] = (k < m ? (hi - args[m - 1]) / (hi - lo) * w[k] : 0.0) +
                   (k > 0 ? (args[m - 1] - lo) / (hi - lo) * w[k - 1] : 0.0);
    for (int k = 0; k <= p; k++) sum += fabs(w[k]);
    return sum;
}

// J: for each coefficient the piece in its support where the sum is smallest; of these the largest; of all variables
// the product.
static double join_growth(const kn_spline *r)
{
    double all = 1.0;
    for (int d = 0; d < r->nvars; d++) {
        const double *t = r->knots[d];
        int p = r->degree[d];
        double worst = 1.0;
        for (int j = 0; j < r->count[d]; j++) {
            double best = INFINITY;
            for (int k = j; k <= j + p; k++)
                if (t[k] < t[k + 1]) best = fmin(best, growth(p, t[k], t[k + 1], t + j + 1));
            worst = fmax(worst, best);
        }
        all *= worst;
    }
    return all;
}

static double most(const kn_spline *s)
{
    double all = 0.0;
    size_t n = kn_spline_count(s);
    for (size_t i = 0; i < n; i++) all = fmax(all, fabs(s->coef[i]));
    return all;
}

// J gamma(T + 3 nvars + sum_d (12 (p_d + q_d) + 3)) max |a| max |b|.
static void product(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *a)
{
    kn_spline b = {0}, c = {0};
    int q = test_int(&w->rng, 0, 3), roundings = 0, terms = 1;
    companion(w, &b, a, q, kind);
    assert_int_equal(kn_spline_product(w->ctx, &c, a, &b), KN_OK);
    pair p = {a, &b};
    exact_spline_coefs(&w->value, &c, product_piece, &p);
    for (int d = 0; d < a->nvars; d++) {
        terms *= (a->degree[d] < q ? a->degree[d] : q) + 1;
        roundings += 3 + 12 * (a->degree[d] + q) + 3;
    }
    fmpq_t x;
    fmpq_init(x);
    fmpq_of_double(w->s, most(a));
    fmpq_of_double(x, most(&b));
    fmpq_mul(w->s, w->s, x);
    fmpq_of_double(x, join_growth(&c) * (1.0 + 1e-9));
    fmpq_mul(w->s, w->s, x);
    size_t n = kn_spline_count(&c);
    for (size_t i = 0; i < n; i++) {
        exact_get(w->x, &w->value, i);
        exact_judge_one(judge, c.coef[i], w->x, w->s, terms + roundings);
    }
    fmpq_clear(x);
    kn_spline_clear(w->ctx, &b), kn_spline_clear(w->ctx, &c);
}

static void products(void **state)
{
    (void)state;
    spline_world w;
    spline_begin(&w, 1);
    exact_judge_t judge = {.name = "spline_product"};
    spline_for_all(&w, &judge, product);
    exact_judge_end(&judge, 0.0);
    spline_end(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(products)};
    int failed = cmocka_run_group_tests_name("oracle/spline_product", tests, NULL, NULL);
    flint_cleanup();
    return failed;
}
