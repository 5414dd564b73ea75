// SPDX-License-Identifier: Apache-2.0
// Gradients, divergences, affine maps and multiples of splines within the bounds that spline.h states; small integers
// bit for bit, where pieces meet without a map.
#include "tests/oracle/spline_cases.h"

#include <math.h>

#include <flint/flint.h>

// a's shape with ncomp components.
static void more_components(spline_world *w, kn_spline *b, const kn_spline *a, int ncomp, exact_kind kind)
{
    assert_int_equal(
        kn_spline_init(w->ctx, b, a->nvars, ncomp, false, a->degree, a->count, (const double *const *)a->knots, NULL),
        KN_OK);
    exact_fill(b->coef, kn_spline_count(b) * (size_t)ncomp, &w->rng, kind);
}

// Partials of components first + v in variable var + v, summed; of: splines whose components' absolute values count.
typedef struct partials {
    const kn_spline *a, *of[3];
    int comp[3], var[3], n;
} partials;

static void value_piece(exact *out, const double *at, void *user)
{
    const partials *p = user;
    exact x = exact_new();
    exact_constant(out, p->a->nvars, 0.0);
    for (int i = 0; i < p->n; i++) {
        exact_of_spline(&x, p->a, p->comp[i], at, false);
        exact_derivative(&x, &x, p->var[i]);
        exact_add(out, out, &x);
    }
    exact_free(&x);
}

static void size_piece(exact *out, const double *at, void *user)
{
    const partials *p = user;
    exact x = exact_new();
    exact_constant(out, p->a->nvars, 0.0);
    for (int i = 0; i < p->n; i++) {
        exact_of_spline(&x, p->of[i], p->comp[i], at, true);
        exact_add(out, out, &x);
    }
    exact_free(&x);
}

// gamma(7 p_v + sum_(d != v) (6 u_d + 1)), and what adds the partials up.
static void judge_partials(spline_world *w, exact_judge_t *judge, const kn_spline *r, int comp, partials *p)
{
    int most = 0;
    for (int i = 0; i < p->n; i++) {
        int n = 7 * p->a->degree[p->var[i]];
        for (int d = 0; d < p->a->nvars; d++) n += d != p->var[i] ? 6 * spline_fresh_arguments(r, p->a, d) + 1 : 0;
        most = n > most ? n : most;
    }
    exact_spline_coefs(&w->value, r, value_piece, p);
    exact_spline_coefs(&w->size, r, size_piece, p);
    exact_judge(judge, r->coef + (size_t)comp * kn_spline_count(r), &w->value, &w->size, NULL, most + p->n - 1);
}

static void gradient(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *shape)
{
    kn_spline a, r = {0}, of[3] = {{0}};
    int n = shape->nvars;
    if (shape->degree[0] > 5) return;
    more_components(w, &a, shape, n, kind);
    for (int v = 0; v < n; v++) assert_int_equal(kn_spline_derivative(w->ctx, &of[v], &a, v), KN_OK);
    assert_int_equal(kn_spline_gradient(w->ctx, &r, &a), KN_OK);
    int c = test_int(&w->rng, 0, n - 1);
    for (int v = 0; v < n; v++) {
        partials p = {&a, {&of[v]}, {c}, {v}, 1};
        judge_partials(w, &judge[0], &r, c * n + v, &p);
    }
    assert_int_equal(kn_spline_divergence(w->ctx, &r, &a), KN_OK);
    partials p = {&a, {&of[0], &of[1], &of[2]}, {0, 1, 2}, {0, 1, 2}, n};
    judge_partials(w, &judge[1], &r, 0, &p);
    for (int v = 0; v < n; v++) kn_spline_clear(w->ctx, &of[v]);
    kn_spline_clear(w->ctx, &a), kn_spline_clear(w->ctx, &r);
}

static void gradients(void **state)
{
    (void)state;
    spline_world w;
    spline_begin(&w, 1);
    exact_judge_t judge[2] = {{.name = "spline_gradient"}, {.name = "spline_divergence"}};
    spline_for_all(&w, judge, gradient);
    for (int i = 0; i < 2; i++) exact_judge_end(&judge[i], 100.0);
    spline_end(&w);
}

// gamma(dim + 1) (sum_c |matrix_rc| |a_c| + |offset_r|) for each coefficient; scale: the rounded product itself.
static void affine(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *shape)
{
    kn_spline a, r = {0};
    double matrix[2 * 3], offset[2];
    more_components(w, &a, shape, 3, kind);
    exact_fill(matrix, 6, &w->rng, kind == EXACT_INTEGERS ? kind : EXACT_UNIFORM);
    exact_fill(offset, 2, &w->rng, kind);
    assert_int_equal(kn_spline_affine(w->ctx, &r, &a, 2, matrix, offset), KN_OK);
    size_t n = kn_spline_count(&a);
    fmpq_t x, y, sum, size;
    fmpq_init(x), fmpq_init(y), fmpq_init(sum), fmpq_init(size);
    for (size_t i = 0; i < 2 * n; i++) {
        fmpq_of_double(sum, offset[i / n]);
        fmpq_abs(size, sum);
        for (size_t c = 0; c < 3; c++) {
            fmpq_of_double(x, matrix[3 * (i / n) + c]);
            fmpq_of_double(y, a.coef[c * n + i % n]);
            fmpq_mul(x, x, y);
            fmpq_add(sum, sum, x);
            fmpq_abs(x, x);
            fmpq_add(size, size, x);
        }
        exact_judge_one(judge, r.coef[i], sum, size, 4);
    }
    fmpq_clear(x), fmpq_clear(y), fmpq_clear(sum), fmpq_clear(size);
    assert_int_equal(kn_spline_scale(w->ctx, &r, &a, matrix[0]), KN_OK);
    for (size_t i = 0; i < 3 * n; i++) assert_true(r.coef[i] == matrix[0] * a.coef[i]);
    kn_spline_clear(w->ctx, &a), kn_spline_clear(w->ctx, &r);
}

static void affines(void **state)
{
    (void)state;
    spline_world w;
    spline_begin(&w, 2);
    exact_judge_t judge = {.name = "spline_affine"};
    spline_for_all(&w, &judge, affine);
    exact_judge_end(&judge, 100.0);
    spline_end(&w);
}

// ---- small integers ----
// Over [0,3] with knots as often as the degree, so that pieces are there already and come back as copies.
static void of_pieces(spline_world *w, kn_spline *s, int nvars, int ncomp, int degree)
{
    double knots[32];
    const double *const all[2] = {knots, knots};
    const int degrees[2] = {degree, degree}, count[2] = {3 * degree + 1, 3 * degree + 1};
    for (int i = 0; i <= 3 * degree + 1 + degree; i++) {
        int k = i == 0 ? 0 : (i - 1) / degree;
        knots[i] = k > 3 ? 3 : k;
    }
    assert_int_equal(kn_spline_init(w->ctx, s, nvars, ncomp, false, degrees, count, all, NULL), KN_OK);
    exact_fill(s->coef, kn_spline_count(s) * (size_t)ncomp, &w->rng, EXACT_INTEGERS);
}

static void assert_terms(spline_world *w, const kn_spline *r, int comp, const spline_term *t, int n)
{
    spline_exact_terms(&w->value, r, t, n);
    exact_assert_nearest(r->coef + (size_t)comp * kn_spline_count(r), &w->value);
}

// Sums of integers divided once: the double nearest to the exact number.
static void integers(void **state)
{
    (void)state;
    spline_world w;
    spline_begin(&w, 3);
    for (int round = test_scale(6); round > 0; round--) {
        kn_spline a, b, c, r = {0};
        int nvars = round % 2 + 1;
        of_pieces(&w, &a, nvars, 3, test_int(&w.rng, 1, 3));
        of_pieces(&w, &b, nvars, 3, test_int(&w.rng, 1, 3));
        of_pieces(&w, &c, nvars, 3, 1);
        spline_term t[6];
        assert_int_equal(kn_spline_product(w.ctx, &r, &a, &b), KN_OK);
        for (int i = 0; i < 3; i++) assert_terms(&w, &r, i, &(spline_term){1.0, {&a, &b}, {i, i}}, 1);
        assert_int_equal(kn_spline_dot(w.ctx, &r, &a, &b), KN_OK);
        for (int i = 0; i < 3; i++) t[i] = (spline_term){1.0, {&a, &b}, {i, i}};
        assert_terms(&w, &r, 0, t, 3);
        assert_int_equal(kn_spline_cross(w.ctx, &r, &a, &b), KN_OK);
        for (int i = 0; i < 3; i++) {
            int u = (i + 1) % 3, v = (i + 2) % 3;
            t[0] = (spline_term){1.0, {&a, &b}, {u, v}}, t[1] = (spline_term){-1.0, {&a, &b}, {v, u}};
            assert_terms(&w, &r, i, t, 2);
        }
        assert_int_equal(kn_spline_determinant(w.ctx, &r, &a, &b, &c), KN_OK);
        for (int i = 0; i < 6; i++) {
            int u = i / 2, v = (u + 1 + i % 2) % 3;
            t[i] = (spline_term){i % 2 ? -1.0 : 1.0, {&a, &b, &c}, {u, v, 3 - u - v}};
        }
        assert_terms(&w, &r, 0, t, 6);
        assert_int_equal(kn_spline_scale(w.ctx, &r, &a, -3.0), KN_OK);
        assert_terms(&w, &r, 2, &(spline_term){-3.0, {&a}, {2}}, 1);
        kn_spline_clear(w.ctx, &a), kn_spline_clear(w.ctx, &b), kn_spline_clear(w.ctx, &c);
        kn_spline_clear(w.ctx, &r);
    }
    spline_end(&w);
}

// Quadratics on equal spans: all weights are dyadic, and everything comes back bit for bit.
static void there_and_back(void **state)
{
    (void)state;
    spline_world w;
    spline_begin(&w, 4);
    const double knots[] = {0, 0, 0, 1, 2, 3, 4, 4, 4}, breaks[] = {0, 1, 2, 3, 4};
    const double *const axes[2] = {knots, knots}, *const at[2] = {breaks, breaks};
    const int degree[2] = {2, 2}, count[2] = {6, 6}, nbreaks[2] = {5, 5}, continuity[2] = {1, 1};
    for (int nvars = 1; nvars <= 2; nvars++) {
        kn_spline a, r = {0};
        kn_bezier *pieces = NULL;
        size_t n = 0;
        assert_int_equal(kn_spline_init(w.ctx, &a, nvars, 2, false, degree, count, axes, NULL), KN_OK);
        exact_fill(a.coef, 2 * kn_spline_count(&a), &w.rng, EXACT_INTEGERS);
        assert_int_equal(kn_spline_to_bezier(w.ctx, &pieces, &n, &a), KN_OK);
        assert_int_equal(kn_spline_from_bezier(w.ctx, &r, pieces, nbreaks, at, continuity), KN_OK);
        assert_int_equal(kn_spline_count(&r), kn_spline_count(&a));
        for (size_t i = 0; i < 2 * kn_spline_count(&a); i++) assert_true(r.coef[i] == a.coef[i]);
        for (size_t i = 0; i < n; i++) kn_bezier_clear(w.ctx, &pieces[i]);
        kn_free(w.ctx, pieces);
        kn_spline_clear(w.ctx, &a), kn_spline_clear(w.ctx, &r);
    }
    spline_end(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(gradients), cmocka_unit_test(affines),
                                       cmocka_unit_test(integers), cmocka_unit_test(there_and_back)};
    int failed = cmocka_run_group_tests_name("oracle/spline_calculus", tests, NULL, NULL);
    flint_cleanup();
    return failed;
}
