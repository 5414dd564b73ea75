// SPDX-License-Identifier: Apache-2.0
// Affine maps, antiderivatives, integrals, gradients, divergences of pieces: within the bounds that bezier.h states.
#include "tests/oracle/terms.h"

#include <math.h>
#include <stdlib.h>

#include <flint/flint.h>

static const int SHAPES[][4] = {{1, 0}, {1, 3}, {1, 9}, {1, 27}, {2, 3, 3}, {2, 1, 6}, {2, 2, 3}, {3, 2, 1, 1}};
enum { NSHAPES = sizeof SHAPES / sizeof *SHAPES };

typedef struct world {
    test_memory memory;
    kn_ctx *ctx;
    test_rng rng;
    exact value, size;
} world;

typedef void (*case_body)(world *w, exact_judge_t *judge, exact_kind kind, const kn_bezier *a);

// Polynomial pieces of nvars components, and rational ones.
static void run(uint64_t salt, const char *const *names, int n, case_body body)
{
    world w = {.memory = TEST_MEMORY_INIT, .rng = test_random(salt), .value = exact_new(), .size = exact_new()};
    exact_judge_t judge[2] = {{.name = names[0]}, {.name = names[n - 1]}};
    w.ctx = test_ctx(&w.memory, 1);
    for (int i = 0; i < NSHAPES; i++)
        for (exact_kind kind = EXACT_INTEGERS; kind < EXACT_KINDS; kind++)
            for (int round = test_scale(2); round > 0; round--) {
                kn_bezier a;
                bool rational = n > 1 && round % 2;
                int nvars = SHAPES[i][0];
                exact_random_bezier(w.ctx, &a, &w.rng, nvars, nvars + rational, rational, SHAPES[i] + 1, kind);
                body(&w, &judge[rational], kind, &a);
                kn_bezier_clear(w.ctx, &a);
            }
    for (int i = 0; i < n; i++) exact_judge_end(&judge[i], 100.0);
    exact_free(&w.value), exact_free(&w.size);
    test_ctx_end(w.ctx, &w.memory);
}

static const double *comp(const kn_bezier *b, int c)
{
    return b->coef + (size_t)c * kn_bezier_count(b);
}

// out += factor a as arrays, or |factor| |a|.
static void accumulate(exact *out, const kn_bezier *a, int c, double factor, bool absolute)
{
    exact x = exact_new();
    fmpq_t f;
    fmpq_init(f);
    fmpq_of_double(f, absolute ? fabs(factor) : factor);
    if (c == a->ncomp)
        exact_constant(&x, a->nvars, 1.0);
    else
        exact_of_bezier(&x, a, c, absolute);
    exact_scale(&x, &x, f);
    exact_add(out, out, &x);
    fmpq_clear(f), exact_free(&x);
}

// gamma(dim(a) + 1)(sum_c |matrix_rc| |a_c| + |offset_r| |w|).
static void affine(world *w, exact_judge_t *judge, exact_kind kind, const kn_bezier *a)
{
    kn_bezier r = {0};
    double matrix[3 * 3], offset[3];
    int dim = kn_bezier_dim(a), rows = test_int(&w->rng, 1, 3);
    exact_fill(matrix, (size_t)(rows * dim), &w->rng, kind == EXACT_INTEGERS ? kind : EXACT_UNIFORM);
    exact_fill(offset, (size_t)rows, &w->rng, kind);
    assert_int_equal(kn_bezier_affine(w->ctx, &r, a, rows, matrix, offset), KN_OK);
    for (int i = 0; i < rows; i++) {
        exact_constant(&w->value, a->nvars, 0.0);
        exact_constant(&w->size, a->nvars, 0.0);
        for (int c = 0; c <= dim; c++) {
            double factor = c < dim ? matrix[i * dim + c] : offset[i];
            accumulate(&w->value, a, c, factor, false);
            accumulate(&w->size, a, c, factor, true);
        }
        exact_bernstein(&w->value, &w->value, r.degree);
        exact_bernstein(&w->size, &w->size, r.degree);
        exact_judge(judge, comp(&r, i), &w->value, &w->size, NULL, dim + 1);
        if (kind == EXACT_INTEGERS) exact_assert_nearest(comp(&r, i), &w->value);
    }
    kn_bezier_clear(w->ctx, &r);
}

static void affine_maps(void **state)
{
    (void)state;
    run(1, (const char *const[]){"affine", "affine, rational"}, 2, affine);
}

// gamma(k) sum_(i<k) |p_i| / (n + 1): the antiderivative of |a|.
static void antiderivative(world *w, exact_judge_t *judge, exact_kind kind, const kn_bezier *a)
{
    kn_bezier r = {0};
    int var = test_int(&w->rng, 0, a->nvars - 1);
    assert_int_equal(kn_bezier_antiderivative(w->ctx, &r, a, var), KN_OK);
    size_t count = kn_bezier_count(&r), inner = 1;
    for (int d = var + 1; d < r.nvars; d++) inner *= (size_t)r.degree[d] + 1;
    int *roundings = malloc(count * sizeof *roundings);
    assert_non_null(roundings);
    for (size_t i = 0; i < count; i++) roundings[i] = (int)(i / inner % (size_t)(r.degree[var] + 1));
    for (int c = 0; c < a->ncomp; c++) {
        exact_of_bezier(&w->value, a, c, false);
        exact_of_bezier(&w->size, a, c, true);
        exact_antiderivative(&w->value, &w->value, var);
        exact_antiderivative(&w->size, &w->size, var);
        exact_bernstein(&w->value, &w->value, r.degree);
        exact_bernstein(&w->size, &w->size, r.degree);
        exact_judge(judge, comp(&r, c), &w->value, &w->size, roundings, 0);
        if (kind == EXACT_INTEGERS) exact_assert_nearest(comp(&r, c), &w->value);
    }
    free(roundings);
    kn_bezier_clear(w->ctx, &r);
}

static void antiderivatives(void **state)
{
    (void)state;
    run(2, (const char *const[]){"antiderivative"}, 1, antiderivative);
}

// gamma(sum_d degree[d] + 1) times the mean of |p_i|.
static void integral(world *w, exact_judge_t *judge, exact_kind kind, const kn_bezier *a)
{
    double out[3];
    const double ones[3] = {1.0, 1.0, 1.0};
    int roundings = 1;
    fmpq_t x, s;
    (void)kind;
    fmpq_init(x), fmpq_init(s);
    assert_int_equal(kn_bezier_integral(w->ctx, out, a), KN_OK);
    for (int d = 0; d < a->nvars; d++) roundings += a->degree[d];
    for (int c = 0; c < a->ncomp; c++) {
        exact_of_bezier(&w->value, a, c, false);
        exact_of_bezier(&w->size, a, c, true);
        for (int d = 0; d < a->nvars; d++) { // each is zero where x_d is
            exact_antiderivative(&w->value, &w->value, d);
            exact_antiderivative(&w->size, &w->size, d);
        }
        exact_value(x, &w->value, ones);
        exact_value(s, &w->size, ones);
        exact_judge_one(judge, out[c], x, s, roundings);
    }
    fmpq_clear(x), fmpq_clear(s);
}

static void integrals(void **state)
{
    (void)state;
    run(3, (const char *const[]){"integral"}, 1, integral);
}

// Polynomial: gamma(3)(k |p_k - p_k-1| + (n-k) |p_k+1 - p_k|), which is |differences| raised by a degree. Rational: as
// kn_bezier_derivative.
static void gradient(world *w, exact_judge_t *judge, exact_kind kind, const kn_bezier *a)
{
    kn_bezier r = {0};
    int dim = kn_bezier_dim(a);
    assert_int_equal(kn_bezier_gradient(w->ctx, &r, a), KN_OK);
    exact_factor weight = exact_factor_of(a, dim);
    for (int v = 0; v < a->nvars; v++) {
        exact_factor dw = exact_factor_of(a, dim);
        if (a->rational) {
            exact_factor_free(&dw);
            dw = exact_factor_derivative(a, dim, v);
        }
        for (int c = 0; c < dim; c++) {
            exact_factor n = exact_factor_of(a, c), dn = exact_factor_derivative(a, c, v);
            if (a->rational) {
                const exact_term t[2] = {{1.0, {&dn, &weight}}, {-1.0, {&dw, &n}}};
                exact_judge_terms(judge, &r, c * a->nvars + v, t, 2, a->degree, a->degree, 2, 3 * a->nvars + 3);
            } else {
                exact_bernstein(&w->value, &dn.value, r.degree);
                exact_bernstein(&w->size, &dn.size, r.degree);
                exact_judge(judge, comp(&r, c * a->nvars + v), &w->value, &w->size, NULL, 3);
                if (kind == EXACT_INTEGERS) exact_assert_nearest(comp(&r, c * a->nvars + v), &w->value);
            }
            exact_factor_free(&n), exact_factor_free(&dn);
        }
        exact_factor_free(&dw);
    }
    exact_factor_free(&weight);
    kn_bezier_clear(w->ctx, &r);
}

static void gradients(void **state)
{
    (void)state;
    run(4, (const char *const[]){"gradient", "gradient, rational"}, 2, gradient);
}

// Polynomial: gamma(nvars + 2) times the sum of the gradient's sizes. Rational: gamma(T + 4 nvars + 2)(sum_d D_d * |w|
// + |N_d| * |D_w|), T = nvars + 1 products, or T + nvars + 5 where all weights are exact.
static void divergence(world *w, exact_judge_t *judge, exact_kind kind, const kn_bezier *a)
{
    kn_bezier r = {0};
    int dim = kn_bezier_dim(a), n = 0;
    exact_term t[6];
    exact_factor part[3], component[3], dw[3], weight = exact_factor_of(a, dim);
    (void)kind;
    assert_int_equal(kn_bezier_divergence(w->ctx, &r, a), KN_OK);
    for (int v = 0; v < dim; v++) {
        part[v] = exact_factor_derivative(a, v, v);
        component[v] = exact_factor_of(a, v);
        t[n++] = (exact_term){1.0, {&part[v], a->rational ? &weight : NULL}};
        if (!a->rational) continue;
        dw[v] = exact_factor_derivative(a, dim, v);
        t[n++] = (exact_term){-1.0, {&component[v], &dw[v]}};
    }
    int none[3] = {0}, degrees = 0;
    for (int v = 0; v < dim; v++) degrees += r.degree[v];
    if (a->rational)
        exact_judge_terms(judge, &r, 0, t, n, a->degree, a->degree, dim + 1, degrees <= 47 ? dim + 5 : 4 * dim + 2);
    else
        exact_judge_terms(judge, &r, 0, t, n, none, none, 0, dim + 2);
    for (int v = 0; v < dim; v++) {
        exact_factor_free(&part[v]), exact_factor_free(&component[v]);
        if (a->rational) exact_factor_free(&dw[v]);
    }
    exact_factor_free(&weight);
    kn_bezier_clear(w->ctx, &r);
}

static void divergences(void **state)
{
    (void)state;
    run(5, (const char *const[]){"divergence", "divergence, rational"}, 2, divergence);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(affine_maps), cmocka_unit_test(antiderivatives),
                                       cmocka_unit_test(integrals), cmocka_unit_test(gradients),
                                       cmocka_unit_test(divergences)};
    int failed = cmocka_run_group_tests_name("oracle/calculus", tests, NULL, NULL);
    flint_cleanup();
    return failed;
}
