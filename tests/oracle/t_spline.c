// SPDX-License-Identifier: Apache-2.0
// Splines: knots, elevation, sums, derivatives, antiderivatives, values: within the bounds that spline.h states.
#include "tests/oracle/spline_cases.h"

#include <math.h>
#include <stdlib.h>

#include <flint/flint.h>

// v <= p of the arguments of a coefficient are new knots: v levels of 5 roundings, but for a first product by 1 and a
// first sum with 0; a product and v additions.
static int refinement_roundings(const kn_spline *a, int var, int fresh)
{
    return 6 * (fresh < a->degree[var] ? fresh : a->degree[var]) + 1;
}

static void insertion(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *a)
{
    kn_spline b = {0}, c = {0};
    double knots[3], lo, hi;
    int var = test_int(&w->rng, 0, a->nvars - 1), n = test_int(&w->rng, 1, 3);
    (void)kind;
    kn_spline_domain(a, var, &lo, &hi);
    for (int i = 0; i < n; i++) knots[i] = test_uniform(&w->rng, lo + 0.01, hi - 0.01);
    if (a->degree[var] > 0) knots[n - 1] = knots[0];
    assert_int_equal(kn_spline_insert_knots(w->ctx, &b, a, var, knots, n), KN_OK);
    spline_judge_sum(w, &judge[0], &b, (spline_sum){.s = {a}}, NULL, refinement_roundings(a, var, n));

    double at = test_uniform(&w->rng, lo + 0.01, hi - 0.01);
    assert_int_equal(kn_spline_subdivide(w->ctx, &b, &c, a, var, at), KN_OK);
    spline_judge_sum(w, &judge[1], &b, (spline_sum){.s = {a}}, NULL, refinement_roundings(a, var, a->degree[var]));
    spline_judge_sum(w, &judge[1], &c, (spline_sum){.s = {a}}, NULL, refinement_roundings(a, var, a->degree[var]));

    double low[3], high[3];
    int roundings = 0;
    for (int d = 0; d < a->nvars; d++) {
        kn_spline_domain(a, d, &lo, &hi);
        low[d] = test_uniform(&w->rng, lo, 0.5 * (lo + hi));
        high[d] = test_uniform(&w->rng, 0.5 * (lo + hi), hi);
        roundings += refinement_roundings(a, d, a->degree[d]);
    }
    assert_int_equal(kn_spline_restrict(w->ctx, &b, a, low, high), KN_OK);
    spline_judge_sum(w, &judge[2], &b, (spline_sum){.s = {a}}, NULL, roundings);
    kn_spline_clear(w->ctx, &b), kn_spline_clear(w->ctx, &c);
}

static void insertions(void **state)
{
    (void)state;
    spline_world w;
    spline_begin(&w, 1);
    exact_judge_t judge[3] = {{.name = "insert_knots"}, {.name = "spline_subdivide"}, {.name = "spline_restrict"}};
    spline_for_all(&w, judge, insertion);
    for (int i = 0; i < 3; i++) exact_judge_end(&judge[i], 100.0);
    spline_end(&w);
}

// The pieces as exact splines on their boxes.
static void splitting(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *a)
{
    kn_bezier *pieces = NULL;
    size_t n = 0, at = 0;
    int span[3] = {0}, roundings = 0;
    (void)kind;
    assert_int_equal(kn_spline_to_bezier(w->ctx, &pieces, &n, a), KN_OK);
    for (int d = 0; d < a->nvars; d++) span[d] = a->degree[d], roundings += refinement_roundings(a, d, a->degree[d]);
    for (int d = 0; d >= 0; at++) {
        double lo[3];
        for (d = 0; d < a->nvars; d++) {
            while (a->knots[d][span[d]] == a->knots[d][span[d] + 1]) span[d]++;
            lo[d] = a->knots[d][span[d]];
        }
        exact_of_spline(&w->value, a, 0, lo, false);
        exact_of_spline(&w->size, a, 0, lo, true);
        for (d = 0; d < a->nvars; d++) {
            exact_substitute(&w->value, &w->value, d, lo[d], a->knots[d][span[d] + 1]);
            exact_substitute(&w->size, &w->size, d, lo[d], a->knots[d][span[d] + 1]);
        }
        exact_bernstein(&w->value, &w->value, a->degree);
        exact_bernstein(&w->size, &w->size, a->degree);
        exact_judge(judge, pieces[at].coef, &w->value, &w->size, NULL, roundings);
        for (d = a->nvars - 1; d >= 0; d--) { // the next span that is not empty
            while (++span[d] < a->count[d] && a->knots[d][span[d]] == a->knots[d][span[d] + 1]) {
            }
            if (span[d] < a->count[d]) break;
            span[d] = a->degree[d];
        }
    }
    assert_int_equal(at, n);
    for (size_t i = 0; i < n; i++) kn_bezier_clear(w->ctx, &pieces[i]);
    kn_free(w->ctx, pieces);
}

static void splittings(void **state)
{
    (void)state;
    spline_world w;
    spline_begin(&w, 2);
    exact_judge_t judge = {.name = "to_bezier"};
    spline_for_all(&w, &judge, splitting);
    exact_judge_end(&judge, 100.0);
    spline_end(&w);
}

// Expands the knots of variable var, each `more` times more often; answers how many they are.
static int repeated(double *to, const kn_spline *a, int var, int more)
{
    const double *knots = a->knots[var];
    int last = a->count[var] + a->degree[var], n = 0;
    for (int k = 0; k <= last; k++)
        for (int times = k == last || knots[k] != knots[k + 1] ? more + 1 : 1; times > 0; times--) to[n++] = knots[k];
    return n;
}

// A step from p to p + 1 costs 6 V + 2 D, for a coefficient between p + 1 neighbours of the new knots: D different
// ones, V that have all their copies there, one less if all have. The largest of all coefficients.
static int step_roundings(const kn_spline *a, int var, int p)
{
    double to[512];
    int n = repeated(to, a, var, p + 1 - a->degree[var]), most = 0;
    for (int j = 0; j + p + 2 < n; j++) { // arguments to[j+1] .. to[j+p+1]
        int different = 0, whole = 0;
        for (int k = j + 1; k <= j + p + 1; k++)
            if (k == j + 1 || to[k] != to[k - 1]) {
                int end = k;
                while (to[end] == to[k] && end <= j + p + 1) end++;
                different++;
                whole += to[k - 1] != to[k] && to[end] != to[k];
            }
        int roundings = 6 * (whole - (whole == different)) + 2 * different;
        most = roundings > most ? roundings : most;
    }
    return most;
}

static int elevation_roundings(const kn_spline *a, const int *to)
{
    int n = 0;
    for (int d = 0; d < a->nvars; d++)
        for (int p = a->degree[d]; p < to[d]; p++) n += step_roundings(a, d, p);
    return n;
}

static void elevation(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *a)
{
    kn_spline b = {0};
    int degree[3];
    (void)kind;
    for (int d = 0; d < a->nvars; d++) degree[d] = a->degree[d] + test_int(&w->rng, d == 0, 2);
    assert_int_equal(kn_spline_elevate(w->ctx, &b, a, degree), KN_OK);
    spline_judge_sum(w, &judge[0], &b, (spline_sum){.s = {a}}, NULL, elevation_roundings(a, degree));
    kn_spline_clear(w->ctx, &b);
}

static void elevations(void **state)
{
    (void)state;
    spline_world w;
    spline_begin(&w, 3);
    exact_judge_t judge = {.name = "spline_elevate"};
    spline_for_all(&w, &judge, elevation);
    exact_judge_end(&judge, 100.0);
    spline_end(&w);
}

// Another spline over a's domain: degrees moved by up to one, a's interior knots thinned out and one of its own.
static void companion(spline_world *w, kn_spline *b, const kn_spline *a, exact_kind kind)
{
    int degree[3], count[3];
    double *knots[3];
    for (int d = 0; d < a->nvars; d++) {
        double lo, hi;
        int p = degree[d] = a->degree[d] + test_int(&w->rng, a->degree[d] > 0 ? -1 : 0, 1), n = p + 1;
        kn_spline_domain(a, d, &lo, &hi);
        knots[d] = malloc((size_t)(a->count[d] + 3 * p + 8) * sizeof(double));
        assert_non_null(knots[d]);
        for (int i = 0; i <= p; i++) knots[d][i] = lo;
        double own = lo + 0.375 * (hi - lo);
        for (int i = a->degree[d] + 1; i < a->count[d]; i++) {
            double k = a->knots[d][i];
            if (own < k) knots[d][n++] = own, own = INFINITY;
            if (i % 2 && !(n > p && knots[d][n - 1] == k)) knots[d][n++] = k;
        }
        count[d] = n;
        for (int i = 0; i <= p; i++) knots[d][n++] = hi;
    }
    assert_int_equal(kn_spline_init(w->ctx, b, a->nvars, 1, false, degree, count, (const double *const *)knots, NULL),
                     KN_OK);
    for (int d = 0; d < a->nvars; d++) free(knots[d]);
    exact_fill(b->coef, kn_spline_count(b), &w->rng, kind);
}

// Elevation to c's degrees, insertion where that leaves fewer knots than c's, one addition.
static int sum_roundings(spline_world *w, const kn_spline *a, const kn_spline *c)
{
    kn_spline e = {0};
    int n = elevation_roundings(a, c->degree) + 1;
    assert_int_equal(kn_spline_elevate(w->ctx, &e, a, c->degree), KN_OK);
    for (int d = 0; d < a->nvars; d++) {
        if (c->count[d] > e.count[d]) n += refinement_roundings(&e, d, spline_fresh_arguments(c, &e, d));
    }
    kn_spline_clear(w->ctx, &e);
    return n;
}

// gamma(na)|a| + gamma(nb)|b|, just above gamma(1) (na |a| + nb |b|).
static void addition(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *a)
{
    kn_spline b, c = {0};
    companion(w, &b, a, kind);
    bool minus = test_int(&w->rng, 0, 1);
    assert_int_equal((minus ? kn_spline_difference : kn_spline_sum)(w->ctx, &c, a, &b), KN_OK);
    int na = sum_roundings(w, a, &c), nb = sum_roundings(w, &b, &c);
    spline_judge_sum(w, judge, &c, (spline_sum){.s = {a, &b}, .minus = minus, .times = {na, nb}}, NULL, 1);
    kn_spline_clear(w->ctx, &b), kn_spline_clear(w->ctx, &c);
}

static void additions(void **state)
{
    (void)state;
    spline_world w;
    spline_begin(&w, 4);
    exact_judge_t judge = {.name = "spline_sum"};
    spline_for_all(&w, &judge, addition);
    exact_judge_end(&judge, 100.0);
    spline_end(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(insertions), cmocka_unit_test(splittings),
                                       cmocka_unit_test(elevations), cmocka_unit_test(additions)};
    int failed = cmocka_run_group_tests_name("oracle/spline", tests, NULL, NULL);
    flint_cleanup();
    return failed;
}
