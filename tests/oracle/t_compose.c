// SPDX-License-Identifier: Apache-2.0
// Compositions, substitutions and sensitivities of pieces against exact rational arithmetic.
#include "tests/oracle/exact.h"

#include <knurl/compose.h>
#include <math.h>
#include <string.h>

enum { MOST = 4 };

// ---- the exact composition, and the same expression in absolute values ----
typedef struct factors {
    exact x[MOST], s[MOST], x_abs[MOST], s_abs[MOST], weight;
    bool rational;
    int n;
} factors;

// x_d and w - x_d of inner's components, and with the absolute values of their Bernstein coefficients.
static factors factors_of(const kn_bezier *inner)
{
    factors f = {.rational = inner->rational, .n = kn_bezier_dim(inner), .weight = exact_new()};
    exact_of_bezier(&f.weight, inner, f.n, false);
    for (int d = 0; d < f.n; d++) {
        f.x[d] = exact_new(), f.s[d] = exact_new(), f.x_abs[d] = exact_new(), f.s_abs[d] = exact_new();
        exact_of_bezier(&f.x[d], inner, d, false);
        exact_sub(&f.s[d], &f.weight, &f.x[d]);
        exact_of_bezier(&f.x_abs[d], inner, d, true);
        exact_bernstein(&f.s_abs[d], &f.s[d], inner->degree);
        exact_abs(&f.s_abs[d]);
        exact_power(&f.s_abs[d]);
    }
    return f;
}

static void factors_free(factors *f)
{
    for (int d = 0; d < f->n; d++)
        exact_free(&f->x[d]), exact_free(&f->s[d]), exact_free(&f->x_abs[d]), exact_free(&f->s_abs[d]);
    exact_free(&f->weight);
}

// out = sum over the Bernstein coefficients of outer's component from place `at` of |c| prod C(p,i) |x|^i |s|^(p-i).
static void absolute(exact *out, const kn_bezier *outer, int comp, const factors *f, int d, size_t at)
{
    if (d == outer->nvars) {
        size_t n = kn_bezier_count(outer);
        double c = comp < outer->ncomp ? outer->coef[(size_t)comp * n + at] : 1.0;
        exact_constant(out, f->weight.nvars, c < 0 ? -c : c);
        return;
    }
    int p = outer->degree[d];
    exact sum = exact_new(), term = exact_new(), power = exact_new();
    fmpq_t binomial;
    fmpq_init(binomial);
    exact_constant(&sum, f->weight.nvars, 0.0);
    for (int i = 0; i <= p; i++) {
        absolute(&term, outer, comp, f, d + 1, at * (size_t)(p + 1) + (size_t)i);
        for (int k = 0; k < p; k++) exact_mul(&term, &term, k < i ? &f->x_abs[d] : &f->s_abs[d]);
        fmpz_bin_uiui(fmpq_numref(binomial), (ulong)p, (ulong)i);
        fmpz_one(fmpq_denref(binomial));
        exact_scale(&term, &term, binomial);
        exact_add(&sum, &sum, &term);
    }
    exact_swap(out, &sum);
    fmpq_clear(binomial);
    exact_free(&sum), exact_free(&term), exact_free(&power);
}

// Component comp of outer(inner) times w^(sum p), as a polynomial.
static void composed(exact *out, const kn_bezier *outer, int comp, const factors *f)
{
    exact o = exact_new();
    if (comp < outer->ncomp) {
        exact_of_bezier(&o, outer, comp, false);
    } else { // the weight of a polynomial: 1, of all its degrees
        fmpq_t one;
        fmpq_init(one);
        fmpq_one(one);
        exact_shape(&o, outer->nvars, outer->degree);
        exact_set(&o, 0, one);
        fmpq_clear(one);
    }
    for (int d = 0; d < outer->nvars; d++) assert_int_equal(o.degree[d], outer->degree[d]);
    exact_compose(out, &o, f->x, f->rational ? &f->weight : NULL);
    exact_free(&o);
}

// The roundings that compose.h states.
static int roundings(const kn_bezier *outer, const kn_bezier *inner)
{
    int sum = 0, terms = 1, most[2] = {0, 0}, n = inner->nvars;
    for (int d = 0; d < outer->nvars; d++) {
        int p = outer->degree[d];
        sum += p;
        if (p > most[0])
            most[1] = most[0], most[0] = p;
        else if (p > most[1])
            most[1] = p;
    }
    for (int d = 0; d < n; d++) terms *= inner->degree[d] + 1;
    return sum * (terms + n + 3) + (most[0] + 1) * (most[1] + 1) + outer->nvars + n + 1;
}

typedef enum data { INTEGERS, ANY, IN_CELL } data; // IN_CELL: inner's values and coefficients lie in the unit cell

static void judge_composition(exact_judge_t *judge, const kn_bezier *out, const kn_bezier *outer,
                              const kn_bezier *inner, data kind)
{
    factors f = factors_of(inner);
    exact value = exact_new(), size = exact_new();
    size_t n = kn_bezier_count(out), all = kn_bezier_count(outer) * (size_t)outer->ncomp;
    kn_bezier positive = *outer;
    positive.coef = test_malloc(all * sizeof *positive.coef);
    for (size_t i = 0; i < all; i++) positive.coef[i] = fabs(outer->coef[i]);
    for (int c = 0; c < out->ncomp; c++) {
        composed(&value, outer, c, &f);
        exact_bernstein(&value, &value, out->degree);
        if (kind == INTEGERS) {
            exact_assert_nearest(out->coef + (size_t)c * n, &value);
            continue;
        }
        if (kind == IN_CELL) // there |x| = x and |s| = s
            composed(&size, &positive, c, &f);
        else
            absolute(&size, outer, c, &f, 0, 0);
        exact_bernstein(&size, &size, out->degree);
        exact_judge(judge, out->coef + (size_t)c * n, &value, &size, NULL, roundings(outer, inner));
    }
    test_free(positive.coef);
    exact_free(&value), exact_free(&size);
    factors_free(&f);
}

// ---- every pairing ----
typedef struct pairing {
    int outer_vars, outer[MOST], inner_vars, inner[MOST];
} pairing;

static const pairing pairings[] = {
    {1, {5}, 0, {0}},                   // a point on a curve
    {3, {2, 0, 1}, 0, {0}},             // in a volume
    {1, {4}, 1, {3}},                   // reparameterization
    {1, {3}, 2, {2, 1}},                // a function of a surface
    {2, {3, 3}, 1, {3}},                // curve in surface
    {2, {0, 2}, 1, {2}},                //
    {3, {2, 3, 1}, 1, {3}},             // curve in volume
    {2, {2, 1}, 2, {2, 2}},             // surface in surface
    {2, {1, 0}, 2, {2, 0}},             //
    {2, {0, 0}, 2, {2, 1}},             //
    {3, {2, 1, 1}, 2, {1, 2}},          // surface in volume
    {3, {1, 1, 1}, 3, {2, 1, 1}},       // volume in volume
    {2, {2, 1}, 3, {1, 1, 2}},          // volume in surface
    {4, {1, 2, 1, 1}, 2, {1, 1}},       //
    {4, {1, 1, 0, 1}, 4, {1, 1, 1, 1}}, //
};

static void make(kn_ctx *ctx, kn_bezier *outer, kn_bezier *inner, const pairing *p, test_rng *rng,
                 bool outer_rational, bool inner_rational, exact_kind kind)
{
    int dim = test_int(rng, 1, 3);
    exact_random_bezier(ctx, outer, rng, p->outer_vars, dim + outer_rational, outer_rational, p->outer, kind);
    exact_random_bezier(ctx, inner, rng, p->inner_vars, p->outer_vars + inner_rational, inner_rational, p->inner,
                        kind);
}

static void every_pairing(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(11);
    exact_judge_t judge = {.name = "compose: every pairing"};
    for (size_t i = 0; i < sizeof pairings / sizeof *pairings; i++)
        for (int kind = 0; kind < 8; kind++) {
            kn_bezier outer, inner, out = {0};
            exact_kind numbers = kind < 4 ? EXACT_INTEGERS : i % 3 == 2 ? EXACT_CANCEL : EXACT_UNIFORM;
            make(ctx, &outer, &inner, &pairings[i], &rng, kind & 1, kind & 2, numbers);
            assert_int_equal(kn_bezier_compose(ctx, &out, &outer, &inner), KN_OK);
            assert_int_equal(out.rational, (kind & 3) != 0);
            assert_int_equal(kn_bezier_dim(&out), kn_bezier_dim(&outer));
            judge_composition(&judge, &out, &outer, &inner, kind < 4 ? INTEGERS : ANY);
            kn_bezier_clear(ctx, &outer), kn_bezier_clear(ctx, &inner), kn_bezier_clear(ctx, &out);
        }
    exact_judge_end(&judge, 1500.0); // docs/numerics.md, compose: why the bound cannot be near
    test_ctx_end(ctx, &memory);
}

// ---- up to degree 56, inside the unit cell: errors are relative ----
static void move_into_cell(kn_bezier *inner)
{
    size_t n = kn_bezier_count(inner), dim = (size_t)kn_bezier_dim(inner);
    for (size_t i = 0; i < n * dim; i++) {
        double w = inner->rational ? inner->coef[dim * n + i % n] : 1.0;
        inner->coef[i] = w * (0.5 + 0.5 * inner->coef[i]);
    }
}

static void high_degrees(void **state)
{
    (void)state;
    static const pairing list[] = {{1, {56}, 1, {1}},        {1, {14}, 1, {4}},      {2, {9, 9}, 1, {3}},
                                   {3, {9, 9, 10}, 1, {2}},  {2, {4, 3}, 2, {8, 1}}, {3, {3, 3, 1}, 2, {3, 3}},
                                   {3, {5, 5, 1}, 2, {1, 2}}};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(12);
    exact_judge_t judge = {.name = "compose: up to degree 56"};
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        kn_bezier outer, inner, out = {0};
        make(ctx, &outer, &inner, &list[i], &rng, i % 3 == 1, i % 2 == 1, EXACT_UNIFORM);
        move_into_cell(&inner);
        assert_int_equal(kn_bezier_compose(ctx, &out, &outer, &inner), KN_OK);
        judge_composition(&judge, &out, &outer, &inner, IN_CELL);
        kn_bezier_clear(ctx, &outer), kn_bezier_clear(ctx, &inner), kn_bezier_clear(ctx, &out);
    }
    exact_judge_end(&judge, 1500.0);
    test_ctx_end(ctx, &memory);
}

// ---- substitution: every line of coefficients along the variable is the composition of a curve ----
static void line_of(double *line, const kn_bezier *b, int comp, int var, size_t outer, size_t inner, size_t step)
{
    size_t n = (size_t)b->degree[var] + 1;
    for (size_t i = 0; i < n; i++)
        line[i] = b->coef[(size_t)comp * kn_bezier_count(b) + (outer * n + i) * step + inner];
}

static void judge_substitution(exact_judge_t *judge, const kn_bezier *out, const kn_bezier *a, int var,
                               const kn_bezier *g, bool integers)
{
    factors f = factors_of(g);
    exact value = exact_new(), size = exact_new();
    size_t step = 1, lines = kn_bezier_count(a) / ((size_t)a->degree[var] + 1);
    double from[KN_MAX_DEGREE + 1], to[KN_MAX_DEGREE + 1];
    for (int d = var + 1; d < a->nvars; d++) step *= (size_t)a->degree[d] + 1;
    for (int c = 0; c < out->ncomp; c++)
        for (size_t k = 0; k < lines; k++) {
            kn_bezier curve = {.nvars = 1, .ncomp = 1, .degree = {a->degree[var]}, .coef = from};
            if (c < a->ncomp) line_of(from, a, c, var, k / step, k % step, step);
            line_of(to, out, c, var, k / step, k % step, step);
            composed(&value, &curve, c < a->ncomp ? 0 : 1, &f);
            exact_bernstein(&value, &value, &out->degree[var]);
            absolute(&size, &curve, c < a->ncomp ? 0 : 1, &f, 0, 0);
            exact_bernstein(&size, &size, &out->degree[var]);
            if (integers)
                exact_assert_nearest(to, &value);
            else
                exact_judge(judge, to, &value, &size, NULL, roundings(&curve, g) + a->degree[var] + 1);
        }
    exact_free(&value), exact_free(&size);
    factors_free(&f);
}

static void substitution(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(13);
    exact_judge_t judge = {.name = "substitute"};
    for (int run = 0; run < test_scale(32); run++) {
        int nvars = test_int(&rng, 1, 3), var = test_int(&rng, 0, nvars - 1), degree[MOST], m = test_int(&rng, 0, 3);
        for (int d = 0; d < nvars; d++) degree[d] = test_int(&rng, 0, 3);
        exact_kind kind = run < 16 ? EXACT_INTEGERS : EXACT_UNIFORM;
        kn_bezier a, g, out = {0};
        exact_random_bezier(ctx, &a, &rng, nvars, 3, run & 1, degree, kind);
        exact_random_bezier(ctx, &g, &rng, 1, 1 + (run >> 1 & 1), run & 2, &m, kind);
        assert_int_equal(kn_bezier_substitute(ctx, &out, &a, var, &g), KN_OK);
        assert_int_equal(out.rational, (run & 3) != 0);
        for (int d = 0; d < nvars; d++) assert_int_equal(out.degree[d], d == var ? degree[d] * m : degree[d]);
        judge_substitution(&judge, &out, &a, var, &g, kind == EXACT_INTEGERS);
        kn_bezier_clear(ctx, &a), kn_bezier_clear(ctx, &g), kn_bezier_clear(ctx, &out);
    }
    exact_judge_end(&judge, 100.0);
    test_ctx_end(ctx, &memory);
}

// ---- splines: coefficients of outer(inner) on the knots that came out ----
typedef struct composite {
    kn_ctx *ctx;
    const kn_spline *outer, *inner, *out;
    int comp;
} composite;

static void composite_piece(exact *out, const double *at, void *user)
{
    const composite *f = user;
    exact o = exact_new(), x[2] = {exact_new(), exact_new()};
    double value[2], middle[2]; // of the box that begins at `at`: its image is inside a box of outer
    for (int d = 0; d < 2; d++) {
        const double *next = f->out->knots[d];
        while (*next <= at[d]) next++;
        middle[d] = (at[d] + *next) / 2;
    }
    assert_int_equal(kn_spline_eval(f->ctx, value, f->inner, middle), KN_OK);
    exact_of_spline(&o, f->outer, f->comp, value, false);
    for (int d = 0; d < 2; d++) exact_of_spline(&x[d], f->inner, d, middle, false);
    exact_compose(out, &o, x, NULL);
    exact_free(&o), exact_free(&x[0]), exact_free(&x[1]);
}

// A spline with knots at 0, 1, .., spans of full multiplicity: continuous, and joined without extrapolation (J = 1).
static void rough(kn_ctx *ctx, kn_spline *out, test_rng *rng, int ncomp, const int *degree, const int *spans)
{
    double knots[2][32];
    const double *list[2] = {knots[0], knots[1]};
    int count[2];
    for (int d = 0; d < 2; d++) {
        int n = 0;
        for (int i = 0; i <= spans[d]; i++)
            for (int k = 0; k < degree[d] + (i == 0 || i == spans[d]); k++) knots[d][n++] = i;
        count[d] = n - degree[d] - 1;
    }
    assert_int_equal(kn_spline_init(ctx, out, 2, ncomp, false, degree, count, list, NULL), KN_OK);
    for (size_t i = 0; i < kn_spline_count(out) * (size_t)ncomp; i++) out->coef[i] = test_uniform(rng, -1, 1);
}

// A piecewise bilinear inner function, x_0 of the first variable and x_1 of the second, up and down over outer's spans.
// Its pieces have their control points inside them, so that all is convex: the composition's roundings, per factor
// those of inner's splitting (6 + 1) and of (X - lo)/(hi - lo) (4), outer's splitting and the join (6 p + 1 each).
// (A crossing is rounded to a double: (X - lo) there is 4 u of the largest knot instead of 0, and x in one span more
// or less by 4 u 4, each of P times.)
static void splines(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(14);
    exact_judge_t judge = {.name = "spline_compose"};
    for (int run = 0; run < test_scale(6); run++) {
        const int degree[2] = {test_int(&rng, 1, 3), test_int(&rng, 1, 2)}, spans[2] = {4, 3}, one[2] = {1, 1};
        const int pieces[2] = {2, 2};
        kn_spline outer, inner, out = {0};
        rough(ctx, &outer, &rng, 2, degree, spans);
        rough(ctx, &inner, &rng, 2, one, pieces);
        double line[2][3];
        for (int i = 0; i < 3; i++)
            for (int d = 0; d < 2; d++) line[d][i] = test_uniform(&rng, 0, spans[d]);
        for (int i = 0; i < 9; i++) inner.coef[i] = line[0][i / 3], inner.coef[9 + i] = line[1][i % 3];
        assert_int_equal(kn_spline_compose(ctx, &out, &outer, &inner), KN_OK);
        int p = degree[0] + degree[1],
            n = p * (4 + 2 + 3 + 7 + 4 + 32) + (degree[0] + 1) * (degree[1] + 1) + 2 + 2 + 1;
        n += 2 * (6 * p + 2) + 2 * (6 * 2 * p + 2);
        exact value = exact_new();
        fmpq_t number, size;
        fmpq_init(number), fmpq_init(size);
        fmpq_one(size); // the largest |c|
        for (int c = 0; c < 2; c++) {
            exact_spline_coefs(&value, &out, composite_piece, &(composite){ctx, &outer, &inner, &out, c});
            assert_int_equal(exact_count(&value), kn_spline_count(&out));
            for (size_t i = 0; i < kn_spline_count(&out); i++) {
                exact_get(number, &value, i);
                exact_judge_one(&judge, out.coef[(size_t)c * kn_spline_count(&out) + i], number, size, n);
            }
        }
        fmpq_clear(number), fmpq_clear(size);
        exact_free(&value);
        kn_spline_clear(ctx, &outer), kn_spline_clear(ctx, &inner), kn_spline_clear(ctx, &out);
    }
    exact_judge_end(&judge, 2500.0);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_pairing), cmocka_unit_test(high_degrees),
                                       cmocka_unit_test(substitution), cmocka_unit_test(splines)};
    return cmocka_run_group_tests_name("oracle/compose", tests, NULL, NULL);
}
