// SPDX-License-Identifier: Apache-2.0
// Products, dot, cross, sums over different weights, derivatives of rational pieces: every coefficient within the
// bound that bezier.h states.
#include "tests/oracle/terms.h"

#include <flint/flint.h>
#include <stdio.h>

typedef struct shape {
    int nvars, m[3], n[3], rounds;
} shape;

static const shape SHAPES[] = {
    {1, {3}, {3}, 20},      {1, {8}, {5}, 10},        {1, {16}, {16}, 6},         {1, {28}, {28}, 6},
    {1, {1}, {55}, 6},      {1, {56}, {0}, 6},        {2, {3, 3}, {3, 3}, 10},    {2, {8, 8}, {8, 8}, 2},
    {2, {5, 0}, {0, 7}, 6}, {2, {16, 2}, {3, 12}, 1}, {2, {25, 25}, {31, 31}, 1}, {3, {3, 3, 1}, {2, 3, 2}, 2},
};
enum { NSHAPES = sizeof SHAPES / sizeof *SHAPES };

static const char *const NAMES[] = {"", "in one variable", "in two", "in three"};

typedef struct pair {
    kn_bezier a, b, c;
    exact_factor fa[4], fb[4];
} pair;

static void pair_make(kn_ctx *ctx, pair *p, test_rng *rng, const shape *s, int dim, bool ra, bool rb, exact_kind kind)
{
    p->c = (kn_bezier){0};
    exact_random_bezier(ctx, &p->a, rng, s->nvars, dim + ra, ra, s->m, kind);
    exact_random_bezier(ctx, &p->b, rng, s->nvars, dim + rb, rb, s->n, kind);
    for (int i = 0; i <= dim; i++) {
        p->fa[i] = exact_factor_of(&p->a, i);
        p->fb[i] = exact_factor_of(&p->b, i);
    }
}

static void pair_free(kn_ctx *ctx, pair *p)
{
    int dim = kn_bezier_dim(&p->a);
    for (int i = 0; i <= dim; i++) exact_factor_free(&p->fa[i]), exact_factor_free(&p->fb[i]);
    kn_bezier_clear(ctx, &p->a), kn_bezier_clear(ctx, &p->b), kn_bezier_clear(ctx, &p->c);
}

static void judge_pair(exact_judge_t *judge, const pair *p, int comp, const exact_term *terms, int nterms, int per)
{
    exact_judge_terms(judge, &p->c, comp, terms, nterms, p->a.degree, p->b.degree, per, 3 * p->a.nvars);
}

static void judge_weight(exact_judge_t *judge, const pair *p)
{
    int da = kn_bezier_dim(&p->a), db = kn_bezier_dim(&p->b);
    const exact_term w = {1.0, {&p->fa[da], &p->fb[db]}};
    if (p->c.rational) judge_pair(judge, p, kn_bezier_dim(&p->c), &w, 1, 1);
}

static void products(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int i = 0; i < NSHAPES; i++) {
        const shape *s = &SHAPES[i];
        char name[64];
        snprintf(name, sizeof name, "product %s, %d + %d", NAMES[s->nvars], s->m[0], s->n[0]);
        exact_judge_t judge = {.name = name};
        for (exact_kind kind = EXACT_INTEGERS; kind < EXACT_KINDS; kind++)
            for (int round = test_scale(s->rounds); round > 0; round--) {
                pair p;
                bool small = s->m[0] + s->n[0] < 20;
                pair_make(ctx, &p, &rng, s, 1, small && test_int(&rng, 0, 1), false, kind);
                assert_int_equal(kn_bezier_product(ctx, &p.c, &p.a, &p.b), KN_OK);
                const exact_term t = {1.0, {&p.fa[0], &p.fb[0]}};
                judge_pair(&judge, &p, 0, &t, 1, 1);
                if (kind == EXACT_INTEGERS && s->m[0] + s->n[0] <= 16) exact_assert_terms(&p.c, 0, &t, 1);
                judge_weight(&judge, &p);
                pair_free(ctx, &p);
            }
        // Signs differ: errors are about u / 2 at any degree, and (25,25) + (31,31) has up to 118 roundings in a row.
        exact_judge_end(&judge, s->nvars == 2 && s->m[0] > 20 ? 300.0 : 100.0);
    }
    test_ctx_end(ctx, &memory);
}

static void dots_and_crosses(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    exact_judge_t dot = {.name = "dot"}, cross = {.name = "cross"};
    for (int i = 0; i < NSHAPES; i++) {
        const shape *s = &SHAPES[i];
        if (s->nvars == 2 && s->m[0] > 16) continue;
        for (exact_kind kind = EXACT_INTEGERS; kind < EXACT_KINDS; kind++) {
            pair p;
            pair_make(ctx, &p, &rng, s, 3, test_int(&rng, 0, 1), test_int(&rng, 0, 1), kind);
            assert_int_equal(kn_bezier_dot(ctx, &p.c, &p.a, &p.b), KN_OK);
            exact_term t[3];
            for (int k = 0; k < 3; k++) t[k] = (exact_term){1.0, {&p.fa[k], &p.fb[k]}};
            judge_pair(&dot, &p, 0, t, 3, 3);
            if (kind == EXACT_INTEGERS && s->m[0] + s->n[0] <= 16) exact_assert_terms(&p.c, 0, t, 3);
            judge_weight(&dot, &p);
            assert_int_equal(kn_bezier_cross(ctx, &p.c, &p.a, &p.b), KN_OK);
            for (int k = 0; k < 3; k++) {
                int u = (k + 1) % 3, v = (k + 2) % 3;
                const exact_term x[2] = {{1.0, {&p.fa[u], &p.fb[v]}}, {-1.0, {&p.fa[v], &p.fb[u]}}};
                judge_pair(&cross, &p, k, x, 2, 2);
                if (kind == EXACT_INTEGERS && s->m[0] + s->n[0] <= 16) exact_assert_terms(&p.c, k, x, 2);
            }
            judge_weight(&cross, &p);
            pair_free(ctx, &p);
        }
    }
    exact_judge_end(&dot, 100.0);
    exact_judge_end(&cross, 100.0);
    test_ctx_end(ctx, &memory);
}

// a . (b x c): L + L' + 4 nvars, L' of the sums in b x c. Integers give the double nearest to the exact number.
static void determinants(void **state)
{
    (void)state;
    static const int degrees[][3] = {{1, 2, 3}, {3, 3, 3}, {8, 8, 8}, {18, 19, 19}};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    exact_judge_t judge[2] = {{.name = "determinant, degree 9 at most"}, {.name = "determinant"}};
    for (int i = 0; i < 6; i++)
        for (exact_kind kind = EXACT_INTEGERS; kind < EXACT_KINDS; kind++) {
            kn_bezier s[3], det = {0};
            exact_factor f[3][3];
            int nvars = i < 4 ? 1 : 2, inner[2];
            for (int k = 0; k < 3; k++) {
                const int degree[2] = {degrees[i % 4][k], 2};
                exact_random_bezier(ctx, &s[k], &rng, nvars, 3, false, degree, kind);
                for (int c = 0; c < 3; c++) f[k][c] = exact_factor_of(&s[k], c);
            }
            assert_int_equal(kn_bezier_determinant(ctx, &det, &s[0], &s[1], &s[2]), KN_OK);
            exact_term t[6];
            for (int j = 0; j < 6; j++) {
                int u = j / 2, v = (u + 1 + j % 2) % 3;
                t[j] = (exact_term){j % 2 ? -1.0 : 1.0, {&f[0][u], &f[1][v], &f[2][3 - u - v]}};
            }
            int terms = 2; // of b x c: at most 20 + 2 (r + c + 40), which they do not reach
            for (int d = 0; d < nvars; d++) {
                inner[d] = s[1].degree[d] + s[2].degree[d];
                terms *= (s[1].degree[d] < s[2].degree[d] ? s[1].degree[d] : s[2].degree[d]) + 1;
            }
            exact_judge_terms(&judge[i > 1], &det, 0, t, 6, s[0].degree, inner, 3, terms + 4 * nvars);
            if (kind == EXACT_INTEGERS && i < 2) exact_assert_terms(&det, 0, t, 6);
            for (int k = 0; k < 3; k++) {
                for (int c = 0; c < 3; c++) exact_factor_free(&f[k][c]);
                kn_bezier_clear(ctx, &s[k]);
            }
            kn_bezier_clear(ctx, &det);
        }
    exact_judge_end(&judge[0], 150.0); // two sums in a row with six products: 85 to 110
    exact_judge_end(&judge[1], 600.0); // degree 56, and two variables: 350 to 400
    test_ctx_end(ctx, &memory);
}

static void rational_sums(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    exact_judge_t judge = {.name = "rational sum, difference"};
    for (int i = 0; i < NSHAPES; i++) {
        const shape *s = &SHAPES[i];
        if (s->nvars == 2 && s->m[0] > 16) continue;
        for (exact_kind kind = EXACT_INTEGERS; kind < EXACT_KINDS; kind++) {
            pair p;
            bool first = test_int(&rng, 0, 1), minus = test_int(&rng, 0, 1);
            pair_make(ctx, &p, &rng, s, 1, first, !first || test_int(&rng, 0, 1), kind);
            assert_int_equal((minus ? kn_bezier_difference : kn_bezier_sum)(ctx, &p.c, &p.a, &p.b), KN_OK);
            assert_true(p.c.rational);
            const exact_term t[2] = {{1.0, {&p.fa[0], &p.fb[1]}}, {minus ? -1.0 : 1.0, {&p.fa[1], &p.fb[0]}}};
            judge_pair(&judge, &p, 0, t, 2, 2);
            judge_weight(&judge, &p);
            pair_free(ctx, &p);
        }
    }
    exact_judge_end(&judge, 100.0);
    test_ctx_end(ctx, &memory);
}

// (N/w)' = (N' w - w' N)/w^2, N' and w' raised to the degrees of N and w: gamma(L + 3 nvars + 3), L of both products.
static void rational_derivatives(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    exact_judge_t judge = {.name = "rational derivative"};
    for (int i = 0; i < NSHAPES; i++) {
        const shape *s = &SHAPES[i];
        int var = test_int(&rng, 0, s->nvars - 1);
        bool fits = s->m[var] > 0;
        for (int d = 0; d < s->nvars; d++) fits &= 2 * s->m[d] <= KN_MAX_DEGREE;
        if (!fits || (s->nvars == 2 && s->m[0] > 16)) continue;
        for (exact_kind kind = EXACT_INTEGERS; kind < EXACT_KINDS; kind++) {
            kn_bezier a, c = {0};
            exact_random_bezier(ctx, &a, &rng, s->nvars, 2, true, s->m, kind);
            assert_int_equal(kn_bezier_derivative(ctx, &c, &a, var), KN_OK);
            exact_factor n = exact_factor_of(&a, 0), w = exact_factor_of(&a, 1);
            exact_factor dn = exact_factor_derivative(&a, 0, var), dw = exact_factor_derivative(&a, 1, var);
            const exact_term t[2] = {{1.0, {&dn, &w}}, {-1.0, {&dw, &n}}}, square = {1.0, {&w, &w}};
            exact_judge_terms(&judge, &c, 0, t, 2, s->m, s->m, 2, 3 * s->nvars + 3);
            exact_judge_terms(&judge, &c, 1, &square, 1, s->m, s->m, 1, 3 * s->nvars);
            exact_factor_free(&n), exact_factor_free(&w), exact_factor_free(&dn), exact_factor_free(&dw);
            kn_bezier_clear(ctx, &a), kn_bezier_clear(ctx, &c);
        }
    }
    exact_judge_end(&judge, 100.0);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(products), cmocka_unit_test(dots_and_crosses),
                                       cmocka_unit_test(determinants), cmocka_unit_test(rational_sums),
                                       cmocka_unit_test(rational_derivatives)};
    int failed = cmocka_run_group_tests_name("oracle/product", tests, NULL, NULL);
    flint_cleanup();
    return failed;
}
