// SPDX-License-Identifier: Apache-2.0
// Sums of products of components, exactly.
#include "tests/oracle/terms.h"

#include <stdlib.h>

exact_factor exact_factor_of(const kn_bezier *b, int comp)
{
    exact_factor f = {exact_new(), exact_new()};
    exact_of_bezier(&f.value, b, comp, false);
    exact_of_bezier(&f.size, b, comp, true);
    return f;
}

exact_factor exact_factor_derivative(const kn_bezier *b, int comp, int var)
{
    exact_factor f = {exact_new(), exact_new()};
    int degree[KN_MAX_VARS];
    for (int d = 0; d < b->nvars; d++) degree[d] = b->degree[d];
    if (degree[var] > 0) degree[var]--;
    exact_of_bezier(&f.value, b, comp, false);
    exact_derivative(&f.value, &f.value, var);
    exact_bernstein(&f.size, &f.value, degree);
    exact_abs(&f.size);
    exact_power(&f.size);
    return f;
}

void exact_factor_free(exact_factor *f)
{
    exact_free(&f->value), exact_free(&f->size);
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

// prod_d of the pairs i + j = k with i <= m, j <= n.
static int pairs(const int *k, int nvars, const int *m, const int *n)
{
    int all = 1;
    for (int d = 0; d < nvars; d++) all *= least(least(m[d], n[d]), least(k[d], m[d] + n[d] - k[d])) + 1;
    return all;
}

// L = min(T, 20 + M (r + c + 40)).
static int sum_roundings(int nvars, const int *m, const int *n, int per, int terms)
{
    int r = nvars > 1 ? least(m[nvars - 2], n[nvars - 2]) + 1 : 1,
        c = nvars > 0 ? least(m[nvars - 1], n[nvars - 1]) + 1 : 1;
    for (int d = 0; d < nvars - 2; d++) per *= least(m[d], n[d]) + 1;
    return least(terms, 20 + per * (r + c + 40));
}

static int *count_roundings(const kn_bezier *c, const int *m, const int *n, int per, int more)
{
    size_t count = kn_bezier_count(c);
    int *roundings = malloc(count * sizeof *roundings), k[KN_MAX_VARS] = {0};
    assert_non_null(roundings);
    for (size_t i = 0; i < count; i++) {
        roundings[i] = sum_roundings(c->nvars, m, n, per, per * pairs(k, c->nvars, m, n)) + more;
        for (int d = c->nvars - 1; d >= 0 && ++k[d] > c->degree[d]; d--) k[d] = 0;
    }
    return roundings;
}

static void sum_of_terms(exact *value, exact *size, const kn_bezier *c, const exact_term *terms, int nterms)
{
    exact v = exact_new(), s = exact_new();
    exact_constant(value, c->nvars, 0.0);
    exact_constant(size, c->nvars, 0.0);
    for (int t = 0; t < nterms; t++) {
        exact_constant(&v, c->nvars, terms[t].sign);
        exact_constant(&s, c->nvars, 1.0);
        for (int i = 0; i < 3 && terms[t].f[i]; i++) {
            exact_mul(&v, &v, &terms[t].f[i]->value);
            exact_mul(&s, &s, &terms[t].f[i]->size);
        }
        exact_add(value, value, &v);
        exact_add(size, size, &s);
    }
    exact_bernstein(value, value, c->degree);
    exact_bernstein(size, size, c->degree);
    exact_free(&v), exact_free(&s);
}

void exact_assert_terms(const kn_bezier *c, int comp, const exact_term *terms, int nterms)
{
    exact value = exact_new(), size = exact_new();
    sum_of_terms(&value, &size, c, terms, nterms);
    exact_assert_nearest(c->coef + (size_t)comp * kn_bezier_count(c), &value);
    exact_free(&value), exact_free(&size);
}

void exact_judge_terms(exact_judge_t *judge, const kn_bezier *c, int comp, const exact_term *terms, int nterms,
                       const int *m, const int *n, int per, int more)
{
    exact value = exact_new(), size = exact_new();
    sum_of_terms(&value, &size, c, terms, nterms);
    int *roundings = count_roundings(c, m, n, per, more);
    exact_judge(judge, c->coef + (size_t)comp * kn_bezier_count(c), &value, &size, roundings, 0);
    free(roundings);
    exact_free(&value), exact_free(&size);
}
