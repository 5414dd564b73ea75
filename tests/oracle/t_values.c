// SPDX-License-Identifier: Apache-2.0
// Values and derivatives of pieces at points: within the bounds that bezier.h states.
#include "tests/oracle/exact.h"

#include <math.h>
#include <stdlib.h>

#include <flint/flint.h>

static const int SHAPES[][4] = {
    {1, 0}, {1, 1}, {1, 3}, {1, 7}, {1, 20}, {1, 56}, {2, 3, 3}, {2, 2, 6}, {2, 25, 31}, {3, 3, 3, 1}, {3, 2, 5, 4},
};
enum { NSHAPES = sizeof SHAPES / sizeof *SHAPES, POINTS = 5 };

typedef struct world {
    test_memory memory;
    kn_ctx *ctx;
    test_rng rng;
} world;

static void begin(world *w, uint64_t salt)
{
    *w = (world){.memory = TEST_MEMORY_INIT, .rng = test_random(salt)};
    w->ctx = test_ctx(&w->memory, 1);
}

static bool is_high(const int *shape)
{
    int sum = 0;
    for (int d = 1; d <= shape[0]; d++) sum += shape[d];
    return sum > 20;
}

typedef void (*case_body)(world *w, exact_judge_t *judge, const kn_bezier *a);
static void for_all(world *w, exact_judge_t *judge, int rounds, case_body body)
{
    for (int i = 0; i < NSHAPES; i++)
        for (exact_kind kind = EXACT_INTEGERS; kind < EXACT_KINDS; kind++)
            for (int round = test_scale(rounds); round > 0; round--) {
                kn_bezier a;
                bool rational = round % 2 == 0;
                exact_random_bezier(w->ctx, &a, &w->rng, SHAPES[i][0], 1 + rational, rational, SHAPES[i] + 1, kind);
                body(w, judge + is_high(SHAPES[i]), &a);
                kn_bezier_clear(w->ctx, &a);
            }
}

static double factorial_ratio(int n, int k) // n!/(n-k)!
{
    double all = 1.0;
    for (int i = 0; i < k; i++) all *= n - i;
    return all;
}

// The weights sum of |coefficients| in derivative number k at t, as a row: n!/(n-k)! sum_i B^(n-k)_i sum_j C(k,j)
// |p_i+j|, with |t| and |1-t|.
static void size_row(exact *out, int n, int k, double t)
{
    const int line = 1, row[2] = {0, n};
    const double plus[2] = {1.0, 1.0};
    exact b = exact_new(), c = exact_new();
    fmpq_t x, y;
    fmpq_init(x), fmpq_init(y);
    exact_of_array(&b, 1, &line, (const double[]){1.0 - 0.0, t}, false); // |1-t| + |t| x: exactly 1 - t below
    fmpq_of_double(x, t);
    fmpq_set_si(y, 1, 1);
    fmpq_sub(y, y, x);
    exact_set(&b, 0, y);
    exact_abs(&b);
    exact_constant(&c, 1, factorial_ratio(n, k));
    for (int i = 0; i < n - k; i++) exact_mul(&c, &c, &b);
    exact_of_array(&b, 1, &line, plus, false);
    for (int i = 0; i < k; i++) exact_mul(&c, &c, &b);
    exact_shape(out, 2, row);
    for (int i = 0; i <= n && k <= n; i++) {
        exact_get(x, &c, (size_t)i);
        exact_set(out, (size_t)i, x);
    }
    fmpq_clear(x), fmpq_clear(y);
    exact_free(&b), exact_free(&c);
}

// The partial derivative order[] of component c at a point, and its sum of absolute values.
static void partial(fmpq_t value, fmpq_t size, const kn_bezier *a, int c, const double *at, const int *order)
{
    exact p = exact_new(), s = exact_new(), row = exact_new();
    exact_of_bezier(&p, a, c, false);
    exact_of_array(&s, a->nvars, a->degree, a->coef + (size_t)c * kn_bezier_count(a), true);
    for (int d = 0; d < a->nvars; d++) {
        for (int k = 0; k < order[d]; k++) exact_derivative(&p, &p, d);
        size_row(&row, a->degree[d], order[d], at[d]);
        exact_map(&s, &s, d, &row);
    }
    exact_value(value, &p, at);
    exact_get(size, &s, 0);
    exact_free(&p), exact_free(&s), exact_free(&row);
}

static int value_roundings(const kn_bezier *a)
{
    int n = 0;
    for (int d = 0; d < a->nvars; d++) n += 4 * a->degree[d] + 1;
    return n;
}

// Polynomial: gamma(E) sum |p_i| B_i. Rational, in the unit cube: gamma(2E + 1) (sum |p_i| B_i) / (sum w_i B_i).
static void value(world *w, exact_judge_t *judge, const kn_bezier *a)
{
    static const int none[KN_MAX_VARS] = {0};
    fmpq_t x, s, y, t;
    fmpq_init(x), fmpq_init(s), fmpq_init(y), fmpq_init(t);
    for (int k = 0; k < POINTS; k++) {
        double at[3], out, reach = a->rational || k % 2 ? 0.0 : 1.0;
        for (int d = 0; d < 3; d++) at[d] = test_uniform(&w->rng, -reach, 1.0 + reach);
        assert_int_equal(kn_bezier_eval(w->ctx, &out, a, at), KN_OK);
        partial(x, s, a, 0, at, none);
        if (a->rational) {
            partial(y, t, a, 1, at, none);
            fmpq_div(x, x, y);
            fmpq_div(s, s, y);
        }
        exact_judge_one(judge, out, x, s, a->rational ? 2 * value_roundings(a) + 1 : value_roundings(a));
    }
    fmpq_clear(x), fmpq_clear(s), fmpq_clear(y), fmpq_clear(t);
}

static void values(void **state)
{
    (void)state;
    world w;
    begin(&w, 1);
    exact_judge_t judge[2] = {{.name = "eval"}, {.name = "eval, high degree"}};
    for_all(&w, judge, 8, value);
    for (int i = 0; i < 2; i++) exact_judge_end(&judge[i], i == 0 ? 100.0 : 0.0);
    test_ctx_end(w.ctx, &w.memory);
}

// gamma(sum_d 12 degree[d] + 6) max |p_i|, polynomial, in the unit cube.
static void batch(world *w, exact_judge_t *judge, const kn_bezier *a)
{
    static const int none[KN_MAX_VARS] = {0};
    if (a->rational) return;
    double at[3 * POINTS], out[POINTS], most = 0.0;
    size_t n = kn_bezier_count(a);
    int roundings = 6;
    fmpq_t x, s;
    fmpq_init(x), fmpq_init(s);
    for (size_t i = 0; i < n; i++) most = fmax(most, fabs(a->coef[i]));
    for (int d = 0; d < a->nvars; d++) roundings += 12 * a->degree[d];
    for (int i = 0; i < 3 * POINTS; i++) at[i] = test_uniform(&w->rng, 0.0, 1.0);
    assert_int_equal(kn_bezier_eval_batch(w->ctx, out, a, POINTS, at), KN_OK);
    for (int k = 0; k < POINTS; k++) {
        partial(x, s, a, 0, at + k * a->nvars, none);
        fmpq_of_double(s, most);
        exact_judge_one(judge, out[k], x, s, roundings);
    }
    fmpq_clear(x), fmpq_clear(s);
}

static void batches(void **state)
{
    (void)state;
    world w;
    begin(&w, 2);
    exact_judge_t judge[2] = {{.name = "eval_batch"}, {.name = "eval_batch, high degree"}};
    for_all(&w, judge, 8, batch);
    for (int i = 0; i < 2; i++) exact_judge_end(&judge[i], 0.0);
    test_ctx_end(w.ctx, &w.memory);
}

// Order k_d in variable d: k_d times a subtraction and a product, then a value of degree n_d - k_d: gamma(sum_d (2 k_d +
// 4 (n_d - k_d) + 1)), 0 beyond the degree, times the sum with each difference taken as a sum of absolute values.
static int derivative_roundings(const kn_bezier *a, const int *order)
{
    int n = 0;
    for (int d = 0; d < a->nvars; d++) n += order[d] > a->degree[d] ? 0 : 4 * a->degree[d] - 2 * order[d] + 1;
    return n;
}

static void derivative(world *w, exact_judge_t *judge, const kn_bezier *a)
{
    double at[3], out[40];
    int order = test_int(&w->rng, 1, 4);
    if (a->rational) return;
    fmpq_t x, s;
    fmpq_init(x), fmpq_init(s);
    for (int d = 0; d < 3; d++) at[d] = test_uniform(&w->rng, 0.0, 1.0);
    assert_true(kn_derivative_count(a->nvars, order) <= 40);
    assert_int_equal(kn_bezier_derivatives(w->ctx, out, a, at, order), KN_OK);
    for (int k = 0; k < 8; k++) {
        int index[KN_MAX_VARS] = {0}, left = order;
        for (int d = 0; d < a->nvars; d++) {
            index[d] = test_int(&w->rng, 0, left);
            left -= index[d];
        }
        partial(x, s, a, 0, at, index);
        exact_judge_one(judge, out[kn_derivative_index(a->nvars, index)], x, s, derivative_roundings(a, index));
    }
    fmpq_clear(x), fmpq_clear(s);
}

static void derivatives(void **state)
{
    (void)state;
    world w;
    begin(&w, 3);
    exact_judge_t judge[2] = {{.name = "derivatives"}, {.name = "derivatives, high degree"}};
    for_all(&w, judge, 6, derivative);
    for (int i = 0; i < 2; i++) exact_judge_end(&judge[i], 0.0);
    test_ctx_end(w.ctx, &w.memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(values), cmocka_unit_test(batches),
                                       cmocka_unit_test(derivatives)};
    int failed = cmocka_run_group_tests_name("oracle/values", tests, NULL, NULL);
    flint_cleanup();
    return failed;
}
