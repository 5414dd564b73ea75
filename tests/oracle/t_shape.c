// SPDX-License-Identifier: Apache-2.0
// Elevation, sums, derivatives, subdivision, restriction, division by an edge: every coefficient within the bound
// that bezier.h states.
#include "tests/oracle/exact.h"

#include <stdlib.h>

#include <flint/flint.h>

typedef struct shape {
    int nvars, degree[3], to[3], rounds;
} shape;

static const shape SHAPES[] = {
    {1, {0}, {3}, 4},
    {1, {3}, {4}, 8},
    {1, {5}, {12}, 6},
    {1, {20}, {56}, 2},
    {1, {55}, {56}, 2},
    {1, {1}, {56}, 4},
    {2, {3, 3}, {6, 6}, 4},
    {2, {8, 5}, {9, 5}, 2},
    {2, {14, 6}, {20, 20}, 1},
    {2, {25, 31}, {31, 56}, 1},
    {3, {3, 3, 1}, {4, 3, 5}, 2},
};
enum { NSHAPES = sizeof SHAPES / sizeof *SHAPES };

typedef struct world {
    test_memory memory;
    kn_ctx *ctx;
    test_rng rng;
    exact value, size; // Bernstein coefficients of what is judged
} world;

static void begin(world *w, uint64_t salt)
{
    *w = (world){.memory = TEST_MEMORY_INIT, .rng = test_random(salt), .value = exact_new(), .size = exact_new()};
    w->ctx = test_ctx(&w->memory, 1);
}

static void end(world *w)
{
    exact_free(&w->value), exact_free(&w->size);
    test_ctx_end(w->ctx, &w->memory);
}

static const double *comp(const kn_bezier *b, int c)
{
    return b->coef + (size_t)c * kn_bezier_count(b);
}

static bool is_high(const shape *s)
{
    return s->degree[0] + s->degree[1] + s->degree[2] > 20;
}

// Calls body, with the first judge or with the second for high degrees, for each shape, kind and round with a random
// piece of two components, rational now and then.
typedef void (*case_body)(world *w, exact_judge_t *judge, const shape *s, exact_kind kind, const kn_bezier *a);
static void for_all(world *w, exact_judge_t *judge, case_body body)
{
    for (int i = 0; i < NSHAPES; i++)
        for (exact_kind kind = EXACT_INTEGERS; kind < EXACT_KINDS; kind++)
            for (int round = test_scale(SHAPES[i].rounds); round > 0; round--) {
                if (is_high(&SHAPES[i]) && (kind == EXACT_HUGE || kind == EXACT_TINY)) continue;
                kn_bezier a;
                bool rational = round % 2 == 0;
                exact_random_bezier(w->ctx, &a, &w->rng, SHAPES[i].nvars, 2, rational, SHAPES[i].degree, kind);
                body(w, judge + is_high(&SHAPES[i]), &SHAPES[i], kind, &a);
                kn_bezier_clear(w->ctx, &a);
            }
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

// Roundings of each coefficient of c: `all`, and what along gives for its index in each variable.
typedef int (*along)(int k, int from, int to);
static int *count_roundings(const kn_bezier *c, const int *from, int all, along f)
{
    size_t count = kn_bezier_count(c);
    int *n = malloc(count * sizeof *n), k[KN_MAX_VARS] = {0};
    assert_non_null(n);
    for (size_t i = 0; i < count; i++) {
        n[i] = all;
        for (int d = 0; d < c->nvars; d++) n[i] += f(k[d], from[d], c->degree[d]);
        for (int d = c->nvars - 1; d >= 0 && ++k[d] > c->degree[d]; d--) k[d] = 0;
    }
    return n;
}

// T + 2, T = min(n, M - n, k, M - k) + 1 terms.
static int elevation_roundings(int k, int n, int to)
{
    return to > n ? least(least(n, to - n), least(k, to - k)) + 3 : 0;
}

static void elevate(world *w, exact_judge_t *judge, const shape *s, exact_kind kind, const kn_bezier *a)
{
    kn_bezier c = {0};
    (void)kind;
    assert_int_equal(kn_bezier_elevate(w->ctx, &c, a, s->to), KN_OK);
    int *roundings = count_roundings(&c, s->degree, 0, elevation_roundings);
    for (int i = 0; i < 2; i++) {
        exact_of_bezier(&w->value, a, i, false);
        exact_of_bezier(&w->size, a, i, true);
        exact_bernstein(&w->value, &w->value, s->to);
        exact_bernstein(&w->size, &w->size, s->to);
        exact_judge(judge, comp(&c, i), &w->value, &w->size, roundings, 0);
    }
    free(roundings);
    kn_bezier_clear(w->ctx, &c);
}

static void elevations(void **state)
{
    (void)state;
    world w;
    begin(&w, 1);
    exact_judge_t judge[2] = {{.name = "elevate"}, {.name = "elevate, high degree"}};
    for_all(&w, judge, elevate);
    for (int i = 0; i < 2; i++) exact_judge_end(&judge[i], 100.0);
    end(&w);
}

// sizes n_i |a|_i: gamma(1) times it is just below gamma(n_i) |a|_i.
static void count_in(exact *size, const int *n)
{
    size_t count = exact_count(size);
    for (size_t i = 0; i < count; i++) fmpz_mul_si(size->num + i, size->num + i, n[i]);
}

// a is raised to b's degrees: gamma(1 + e)|a| + gamma(1)|b|, e its roundings.
static void sum(world *w, exact_judge_t *judge, const shape *s, exact_kind kind, const kn_bezier *a)
{
    kn_bezier b, c = {0}, plain = *a;
    exact x = exact_new();
    bool minus = test_int(&w->rng, 0, 1);
    plain.rational = false;
    exact_random_bezier(w->ctx, &b, &w->rng, s->nvars, 2, false, s->to, kind);
    assert_int_equal((minus ? kn_bezier_difference : kn_bezier_sum)(w->ctx, &c, &plain, &b), KN_OK);
    int *roundings = count_roundings(&c, s->degree, 1, elevation_roundings);
    for (int i = 0; i < 2; i++) {
        exact_of_bezier(&w->value, a, i, false);
        exact_of_bezier(&x, &b, i, false);
        (minus ? exact_sub : exact_add)(&w->value, &w->value, &x);
        exact_bernstein(&w->value, &w->value, c.degree);
        exact_of_bezier(&w->size, a, i, true);
        exact_bernstein(&w->size, &w->size, c.degree);
        count_in(&w->size, roundings);
        exact_of_array(&x, s->nvars, c.degree, comp(&b, i), true);
        exact_add(&w->size, &w->size, &x);
        exact_judge(judge, comp(&c, i), &w->value, &w->size, NULL, 1);
    }
    free(roundings);
    exact_free(&x);
    kn_bezier_clear(w->ctx, &b), kn_bezier_clear(w->ctx, &c);
}

static void sums(void **state)
{
    (void)state;
    world w;
    begin(&w, 2);
    exact_judge_t judge[2] = {{.name = "sum, difference"}, {.name = "sum, difference, high degree"}};
    for_all(&w, judge, sum);
    for (int i = 0; i < 2; i++) exact_judge_end(&judge[i], 100.0);
    end(&w);
}

static void scale_and_differentiate(world *w, exact_judge_t *judge, const shape *s, exact_kind kind,
                                    const kn_bezier *a)
{
    kn_bezier c = {0}, plain = *a;
    int var = test_int(&w->rng, 0, s->nvars - 1);
    double factor = kind == EXACT_INTEGERS ? 3.0 : test_uniform(&w->rng, -1e3, 1e3);
    fmpq_t f;
    fmpq_init(f);
    fmpq_of_double(f, factor);
    assert_int_equal(kn_bezier_scale(w->ctx, &c, a, factor), KN_OK);
    exact_of_array(&w->value, s->nvars, s->degree, a->coef, false);
    exact_scale(&w->value, &w->value, f);
    exact_judge(&judge[0], c.coef, &w->value, NULL, NULL, 1);
    if (a->rational) assert_memory_equal(comp(&c, 1), comp(a, 1), kn_bezier_count(a) * sizeof *a->coef);

    plain.rational = false;
    assert_int_equal(kn_bezier_derivative(w->ctx, &c, &plain, var), KN_OK);
    for (int i = 0; i < 2; i++) {
        exact_of_bezier(&w->value, a, i, false);
        exact_derivative(&w->value, &w->value, var);
        exact_bernstein(&w->value, &w->value, c.degree);
        exact_judge(&judge[2], comp(&c, i), &w->value, NULL, NULL, 2);
        if (kind == EXACT_INTEGERS) exact_assert_nearest(comp(&c, i), &w->value);
    }
    fmpq_clear(f);
    kn_bezier_clear(w->ctx, &c);
}

static void scalings_and_derivatives(void **state)
{
    (void)state;
    world w;
    begin(&w, 3);
    exact_judge_t judge[4] = {{.name = "scale"},
                              {.name = "scale, high degree"},
                              {.name = "derivative, polynomial"},
                              {.name = "derivative, polynomial, high"}};
    for_all(&w, judge, scale_and_differentiate);
    for (int i = 0; i < 4; i++) exact_judge_end(&judge[i], 100.0);
    end(&w);
}

// Row i of the restriction has the coefficients of ((1-lo) + lo x)^(n-i) ((1-hi) + hi x)^i: here with the absolute
// values of the four numbers.
static void size_matrix(exact *out, int n, double lo, double hi)
{
    const int line = 1, square[2] = {n, n};
    const double unit[2] = {1.0, 0.0}, low[2] = {-lo, lo}, high[2] = {-hi, hi};
    exact one = exact_new(), a = exact_new(), b = exact_new(), row = exact_new();
    exact_of_array(&one, 1, &line, unit, false);
    exact_of_array(&a, 1, &line, low, false);
    exact_of_array(&b, 1, &line, high, false);
    exact_add(&a, &a, &one), exact_abs(&a);
    exact_add(&b, &b, &one), exact_abs(&b);
    size_t m = (size_t)n + 1;
    fmpq *all = _fmpq_vec_init((slong)(m * m));
    exact first = exact_new(); // a^(n-i), from the last row back
    exact_constant(&first, 1, 1.0);
    exact *powers = calloc(m, sizeof *powers);
    assert_non_null(powers);
    for (size_t i = m; i-- > 0; exact_mul(&first, &first, &a)) {
        powers[i] = exact_new();
        exact_copy(&powers[i], &first);
    }
    exact_constant(&first, 1, 1.0);
    for (size_t i = 0; i < m; i++, exact_mul(&first, &first, &b)) {
        exact_mul(&row, &powers[i], &first);
        for (size_t k = 0; k < m; k++) exact_get(all + i * m + k, &row, k);
        exact_free(&powers[i]);
    }
    exact_of_fractions(out, 2, square, all);
    _fmpq_vec_clear(all, (slong)(m * m));
    free(powers);
    exact_free(&one), exact_free(&a), exact_free(&b), exact_free(&row), exact_free(&first);
}

// Bernstein coefficients over the box, and the same expression with absolute values.
static void restrict_exactly(world *w, const kn_bezier *a, int c, const double *lo, const double *hi)
{
    exact matrix = exact_new();
    exact_of_bezier(&w->value, a, c, false);
    exact_of_array(&w->size, a->nvars, a->degree, comp(a, c), true);
    for (int d = 0; d < a->nvars; d++) {
        if (lo[d] == 0.0 && hi[d] == 1.0) continue;
        exact_substitute(&w->value, &w->value, d, lo[d], hi[d]);
        size_matrix(&matrix, a->degree[d], lo[d], hi[d]);
        exact_map(&w->size, &w->size, d, &matrix);
    }
    exact_bernstein(&w->value, &w->value, a->degree);
    exact_free(&matrix);
}

// Coefficient k of the left piece has seen k steps of de Casteljau, of the right one n - k: gamma(3) each.
static int *step_roundings(const kn_bezier *a, int var, bool right)
{
    size_t count = kn_bezier_count(a), inner = 1;
    int *n = malloc(count * sizeof *n), m = a->degree[var];
    assert_non_null(n);
    for (int d = var + 1; d < a->nvars; d++) inner *= (size_t)a->degree[d] + 1;
    for (size_t i = 0; i < count; i++) {
        int k = (int)(i / inner % (size_t)(m + 1));
        n[i] = 3 * (right ? m - k : k);
    }
    return n;
}

static void subdivide(world *w, exact_judge_t *judge, const shape *s, exact_kind kind, const kn_bezier *a)
{
    kn_bezier left = {0}, right = {0};
    int var = test_int(&w->rng, 0, s->nvars - 1);
    double at = test_int(&w->rng, 0, 3) ? test_uniform(&w->rng, 0.0, 1.0) : test_uniform(&w->rng, -1.0, 2.0);
    if (kind == EXACT_INTEGERS) at = 0.5;
    assert_int_equal(kn_bezier_subdivide(w->ctx, &left, &right, a, var, at), KN_OK);
    int *n = step_roundings(a, var, false), *m = step_roundings(a, var, true);
    for (int i = 0; i < 2; i++) {
        double lo[3] = {0, 0, 0}, hi[3] = {1, 1, 1};
        hi[var] = at;
        restrict_exactly(w, a, i, lo, hi);
        exact_judge(judge, comp(&left, i), &w->value, &w->size, n, 0);
        lo[var] = at, hi[var] = 1.0;
        restrict_exactly(w, a, i, lo, hi);
        exact_judge(judge, comp(&right, i), &w->value, &w->size, m, 0);
    }
    free(n), free(m);
    kn_bezier_clear(w->ctx, &left), kn_bezier_clear(w->ctx, &right);
}

static void subdivisions(void **state)
{
    (void)state;
    world w;
    begin(&w, 4);
    exact_judge_t judge[2] = {{.name = "subdivide"}, {.name = "subdivide, high degree"}};
    for_all(&w, judge, subdivide);
    for (int i = 0; i < 2; i++) exact_judge_end(&judge[i], i == 0 ? 100.0 : 0.0);
    end(&w);
}

static void restrict_inside(world *w, exact_judge_t *judge, const shape *s, exact_kind kind, const kn_bezier *a)
{
    kn_bezier c = {0};
    double lo[3], hi[3], reach = test_int(&w->rng, 0, 1);
    judge += reach > 0.0 ? 2 : 0;
    int roundings = 0;
    (void)kind;
    for (int d = 0; d < s->nvars; d++) {
        lo[d] = test_uniform(&w->rng, -reach, 1.0 + reach);
        hi[d] = test_uniform(&w->rng, -reach, 1.0 + reach);
        if (test_int(&w->rng, 0, 3) == 0) lo[d] = 0.0;
        if (test_int(&w->rng, 0, 3) == 0) hi[d] = 1.0;
        roundings += 5 * s->degree[d] + 2;
    }
    assert_int_equal(kn_bezier_restrict(w->ctx, &c, a, lo, hi), KN_OK);
    for (int i = 0; i < 2; i++) {
        restrict_exactly(w, a, i, lo, hi);
        exact_judge(judge, comp(&c, i), &w->value, &w->size, NULL, roundings);
    }
    kn_bezier_clear(w->ctx, &c);
}

static void restrictions(void **state)
{
    (void)state;
    world w;
    begin(&w, 5);
    exact_judge_t judge[4] = {{.name = "restrict inside"},
                              {.name = "restrict inside, high degree"},
                              {.name = "restrict beyond"},
                              {.name = "restrict beyond, high degree"}};
    for_all(&w, judge, restrict_inside);
    for (int i = 0; i < 4; i++) exact_judge_end(&judge[i], 0.0);
    end(&w);
}

// The first or last k coefficients are zero: the quotient is the polynomial's, in powers of x or 1 - x.
static void divide(world *w, exact_judge_t *judge, const shape *s, exact_kind kind, const kn_bezier *a)
{
    kn_bezier b = {0}, c = {0};
    int var = test_int(&w->rng, 0, s->nvars - 1), order = -1, n = s->degree[var];
    bool at_end = test_int(&w->rng, 0, 1);
    int k = test_int(&w->rng, 0, n < 4 ? n : 4);
    size_t inner = 1, count = kn_bezier_count(a);
    (void)kind;
    for (int d = var + 1; d < s->nvars; d++) inner *= (size_t)s->degree[d] + 1;
    assert_int_equal(kn_bezier_copy(w->ctx, &b, a), KN_OK);
    for (size_t i = 0; i < 2 * count; i++) {
        int row = (int)(i / inner) % (n + 1);
        if (at_end ? row > n - k : row < k)
            b.coef[i] = 0.0;
        else if (b.coef[i] == 0.0)
            b.coef[i] = 1.0;
    }
    assert_int_equal(kn_bezier_divide_edge(w->ctx, &c, &order, &b, var, at_end), KN_OK);
    assert_int_equal(order, k);
    for (int i = 0; i < 2; i++) {
        exact_of_bezier(&w->value, &b, i, false);
        if (at_end) exact_substitute(&w->value, &w->value, var, 1.0, 0.0);
        exact_divide_power(&w->value, &w->value, var, k);
        if (at_end) exact_substitute(&w->value, &w->value, var, 1.0, 0.0);
        exact_bernstein(&w->value, &w->value, c.degree);
        exact_judge(judge, comp(&c, i), &w->value, NULL, NULL, 2);
    }
    kn_bezier_clear(w->ctx, &b), kn_bezier_clear(w->ctx, &c);
}

static void divisions(void **state)
{
    (void)state;
    world w;
    begin(&w, 6);
    exact_judge_t judge[2] = {{.name = "divide_edge"}, {.name = "divide_edge, high degree"}};
    for_all(&w, judge, divide);
    for (int i = 0; i < 2; i++) exact_judge_end(&judge[i], 100.0);
    end(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elevations),   cmocka_unit_test(sums),         cmocka_unit_test(scalings_and_derivatives),
        cmocka_unit_test(subdivisions), cmocka_unit_test(restrictions), cmocka_unit_test(divisions),
    };
    int failed = cmocka_run_group_tests_name("oracle/shape", tests, NULL, NULL);
    flint_cleanup();
    return failed;
}
