// SPDX-License-Identifier: Apache-2.0
// Sum, products, derivative and elevation of splines: values against long double, knots minimal, failures, memory.
#include <float.h>
#include <math.h>
#include <string.h>

#include "kernel/knots.h"
#include "tests/spline/oracle.h"
#include "tests/support/support.h"

static kn_spline curve(kn_ctx *ctx, int degree, int count, int ncomp, const double *knots, const double *coef)
{
    kn_spline s;
    const double *const k[] = {knots};
    assert_int_equal(kn_spline_init(ctx, &s, 1, ncomp, false, &degree, &count, k, coef), KN_OK);
    return s;
}

static void assert_numbers(const double *a, const double *b, int n)
{
    for (int i = 0; i < n; i++) assert_true(a[i] == b[i]);
}

// Degrees 1 .. 3 over [0,4] in every variable; knots at random integers, so that operands share some and not others.
static kn_spline random_operand(kn_ctx *ctx, test_rng *rng, int nvars, int dim, bool rational)
{
    int degree[3], count[3];
    double knots[3][24];
    const double *at[3];
    for (int d = 0; d < nvars; d++) {
        int p = degree[d] = test_int(rng, 1, nvars > 2 ? 2 : 3), n = 0;
        for (int i = 0; i <= p; i++) knots[d][n++] = 0;
        for (int x = 1; x < 4; x++)
            for (int m = test_int(rng, -2, p + 1); m > 0; m--) knots[d][n++] = x;
        for (int i = 0; i <= p; i++) knots[d][n++] = 4;
        count[d] = n - p - 1, at[d] = knots[d];
    }
    kn_spline s;
    assert_int_equal(kn_spline_init(ctx, &s, nvars, dim + rational, rational, degree, count, at, NULL), KN_OK);
    size_t n = kn_spline_count(&s);
    for (size_t i = 0; i < n * (size_t)s.ncomp; i++)
        s.coef[i] = i < n * (size_t)dim ? test_int(rng, -9, 9) : test_int(rng, 1, 4);
    return s;
}

// The continuity at x that two operands leave: degree - multiplicity of the rougher one.
static int common_continuity(const kn_spline *a, const kn_spline *b, int var, double x)
{
    int c = 99, ma = oracle_multiplicity(a, var, x), mb = oracle_multiplicity(b, var, x);
    if (ma) c = a->degree[var] - ma;
    if (mb) c = oracle_lower(c, b->degree[var] - mb);
    return c;
}

static void assert_minimal(const kn_spline *out, const kn_spline *a, const kn_spline *b)
{
    for (int d = 0; d < a->nvars; d++)
        for (int x = 1; x < 4; x++) {
            int c = common_continuity(a, b, d, x);
            assert_int_equal(oracle_multiplicity(out, d, x), c == 99 ? 0 : out->degree[d] - c);
        }
}

typedef kn_status (*binary)(kn_ctx *, kn_spline *, const kn_spline *, const kn_spline *);
// expected[] from the homogeneous values of the operands.
typedef void (*formula)(long double *expected, const kn_spline *a, const long double *x, const kn_spline *b,
                        const long double *y);

static long double weight(const kn_spline *s, const long double *x)
{
    return s->rational ? x[kn_spline_dim(s)] : 1;
}

static void sum_formula(long double *e, const kn_spline *a, const long double *x, const kn_spline *b,
                        const long double *y)
{
    int dim = kn_spline_dim(a);
    for (int i = 0; i < dim; i++) e[i] = x[i] * weight(b, y) + y[i] * weight(a, x);
    e[dim] = weight(a, x) * weight(b, y);
}

static void product_formula(long double *e, const kn_spline *a, const long double *x, const kn_spline *b,
                            const long double *y)
{
    int na = kn_spline_dim(a), nb = kn_spline_dim(b), n = na > nb ? na : nb;
    for (int i = 0; i < n; i++) e[i] = x[na > 1 ? i : 0] * y[nb > 1 ? i : 0];
    e[n] = weight(a, x) * weight(b, y);
}

static void dot_formula(long double *e, const kn_spline *a, const long double *x, const kn_spline *b,
                        const long double *y)
{
    e[0] = 0;
    for (int i = 0; i < kn_spline_dim(a); i++) e[0] += x[i] * y[i];
    e[1] = weight(a, x) * weight(b, y);
}

static void cross_formula(long double *e, const kn_spline *a, const long double *x, const kn_spline *b,
                          const long double *y)
{
    for (int i = 0; i < 3; i++) e[i] = x[(i + 1) % 3] * y[(i + 2) % 3] - x[(i + 2) % 3] * y[(i + 1) % 3];
    e[3] = weight(a, x) * weight(b, y);
}

// Coefficients of pieces are at most dim |a| |b|, each with at most 6 p + 3 roundings a variable from splitting, the
// product's 4 nvars + terms, and 5 q + 2 from joining, times the growth there. The oracle's own error is negligible.
static void check_binary(kn_ctx *ctx, test_rng *rng, binary op, formula f, kn_spline *a, kn_spline *b)
{
    kn_spline out = {0};
    assert_int_equal(op(ctx, &out, a, b), KN_OK);
    assert_minimal(&out, a, b);
    int operations = 8, terms = 6;
    for (int d = 0; d < a->nvars; d++) {
        operations += 6 * (a->degree[d] + b->degree[d]) + 10 + 5 * out.degree[d];
        terms *= out.degree[d] + 1;
    }
    double unit = oracle_largest(a) * oracle_largest(b) * terms;
    double bound = oracle_gamma(operations + terms) * oracle_growth(&out) * unit;
    for (int i = 0; i < 6; i++) {
        long double x[8], y[8], z[8], expected[8];
        double at[3];
        for (int d = 0; d < a->nvars; d++) at[d] = test_uniform(rng, 0, 4);
        oracle_homogeneous(x, NULL, a, at, NULL, NULL);
        oracle_homogeneous(y, NULL, b, at, NULL, NULL);
        oracle_homogeneous(z, NULL, &out, at, NULL, NULL);
        f(expected, a, x, b, y);
        for (int c = 0; c < out.ncomp; c++) assert_true(fabsl(z[c] - expected[c]) <= bound);
    }
    kn_spline again = {0};
    assert_int_equal(kn_spline_copy(ctx, &again, b), KN_OK);
    assert_int_equal(op(ctx, &again, a, &again), KN_OK); // out may be an operand
    assert_memory_equal(again.coef, out.coef, kn_spline_count(&out) * (size_t)out.ncomp * sizeof *out.coef);
    kn_spline_clear(ctx, &again);
    assert_int_equal(kn_spline_copy(ctx, &again, a), KN_OK);
    assert_int_equal(op(ctx, &again, &again, b), KN_OK);
    assert_memory_equal(again.coef, out.coef, kn_spline_count(&out) * (size_t)out.ncomp * sizeof *out.coef);
    kn_spline_clear(ctx, &again);
    kn_spline_clear(ctx, &out);
}

static void binary_operations(void **state)
{
    (void)state;
    static const struct {
        binary op;
        formula f;
        int dim_a, dim_b;
    } cases[] = {
        {kn_spline_sum, sum_formula, 2, 2},         {kn_spline_product, product_formula, 2, 2},
        {kn_spline_product, product_formula, 1, 3}, {kn_spline_product, product_formula, 2, 1},
        {kn_spline_dot, dot_formula, 3, 3},         {kn_spline_cross, cross_formula, 3, 3},
    };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = test_scale(2); round > 0; round--)
        for (int nvars = 1; nvars <= 3; nvars++)
            for (int k = 0; k < 6; k++)
                for (int rational = 0; rational < (nvars == 3 ? 1 : 4); rational++) {
                    kn_spline a = random_operand(ctx, &rng, nvars, cases[k].dim_a, rational & 1);
                    kn_spline b = random_operand(ctx, &rng, nvars, cases[k].dim_b, rational & 2);
                    check_binary(ctx, &rng, cases[k].op, cases[k].f, &a, &b);
                    kn_spline_clear(ctx, &a);
                    kn_spline_clear(ctx, &b);
                }
    test_ctx_end(ctx, &memory);
}

// Linear splines with integer values at integer knots: products of pieces (a0, a1)(b0, b1) = a0 b0, mean, a1 b1; even
// values keep the mean an integer. A kink of one operand: degree 2, multiplicity 2, everything exact.
static void exact_product(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double ka[] = {0, 0, 1, 2, 2}, kb[] = {0, 0, 2, 2}, a[] = {2, 6, -4}, b[] = {4, 8};
    const double knots[] = {0, 0, 0, 1, 1, 2, 2, 2}, coef[] = {8, 18, 36, 6 * 4 - 12, -32};
    kn_spline s = curve(ctx, 1, 3, 1, ka, a), t = curve(ctx, 1, 2, 1, kb, b), out = {0};
    assert_int_equal(kn_spline_product(ctx, &out, &s, &t), KN_OK);
    assert_int_equal(out.count[0], 5);
    assert_numbers(out.knots[0], knots, 8);
    assert_numbers(out.coef, coef, 5);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &t);
    kn_spline_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

// A quadratic with knots 1, 2 plus a line with a kink at 3: the line at degree 2, knot 3 twice; integers throughout.
static void exact_sum(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double ka[] = {0, 0, 0, 1, 2, 4, 4, 4}, kb[] = {0, 0, 3, 4, 4};
    const double a[] = {0, 0, 2, 8, 16}, b[] = {0, 6, 0}; // u^2; 2u, then 24 - 6u
    const double knots[] = {0, 0, 0, 1, 2, 3, 3, 4, 4, 4};
    const double coef[] = {0, 0 + 1, 2 + 3, 6 + 5, 9 + 6, 12 + 3, 16}; // polar forms: xy + (x + y), ... - 3 (x + y)
    kn_spline s = curve(ctx, 2, 5, 1, ka, a), t = curve(ctx, 1, 3, 1, kb, b), out = {0};
    assert_int_equal(kn_spline_sum(ctx, &out, &s, &t), KN_OK);
    assert_int_equal(out.count[0], 7);
    assert_numbers(out.knots[0], knots, 10);
    assert_numbers(out.coef, coef, 7);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &t);
    kn_spline_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

// Equal weights on equal knots stay as they are: no product of weights, no higher degree.
static void sum_over_one_weight(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    kn_spline a = random_operand(ctx, &rng, 2, 2, true), b = {0}, out = {0};
    size_t n = kn_spline_count(&a);
    assert_int_equal(kn_spline_copy(ctx, &b, &a), KN_OK);
    for (size_t i = 0; i < 2 * n; i++) b.coef[i] = test_int(&rng, -9, 9);
    assert_int_equal(kn_spline_sum(ctx, &out, &a, &b), KN_OK);
    assert_int_equal(out.degree[0], a.degree[0]);
    for (size_t i = 0; i < 3 * n; i++) assert_true(out.coef[i] == (i < 2 * n ? a.coef[i] + b.coef[i] : a.coef[i]));
    kn_spline_clear(ctx, &a);
    kn_spline_clear(ctx, &b);
    kn_spline_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

static void derivatives(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    for (int round = test_scale(20); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3), var = test_int(&rng, 0, nvars - 1), a[3] = {0};
        kn_spline s = random_operand(ctx, &rng, nvars, 2, false), t = {0};
        assert_int_equal(kn_spline_derivative(ctx, &t, &s, var), KN_OK);
        assert_int_equal(t.degree[var], s.degree[var] - 1);
        for (int x = 1; x < 4; x++) // a jump leaves no more than a jump
            assert_int_equal(oracle_multiplicity(&t, var, x),
                             oracle_lower(oracle_multiplicity(&s, var, x), s.degree[var]));
        if (t.degree[var] > 0) assert_int_equal(kn_spline_check(ctx, &t), KN_OK);
        a[var] = 1;
        for (int i = 0; i < 6; i++) {
            double at[3];
            long double x[2], y[2], size[2];
            for (int d = 0; d < nvars; d++) at[d] = test_uniform(&rng, 0, 4);
            oracle_homogeneous(x, size, &s, at, a, NULL);
            oracle_homogeneous(y, NULL, &t, at, NULL, NULL);
            for (int c = 0; c < 2; c++) assert_true(fabsl(x[c] - y[c]) <= oracle_gamma(4) * size[c]); // p/h, 2 terms
        }
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &t);
    }
    test_ctx_end(ctx, &memory);
}

// Of a rational spline: the quotient rule at points, and the weight is the square of the weight.
static void rational_derivatives(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    for (int round = test_scale(10); round > 0; round--) {
        int nvars = test_int(&rng, 1, 2), var = test_int(&rng, 0, nvars - 1), a[2] = {0};
        kn_spline s = random_operand(ctx, &rng, nvars, 2, true), t = {0};
        assert_int_equal(kn_spline_derivative(ctx, &t, &s, var), KN_OK);
        assert_int_equal(kn_spline_check(ctx, &t) == KN_EDOMAIN, false);
        int operations = 8, terms = 2;
        for (int d = 0; d < nvars; d++)
            operations += 12 * s.degree[d] + 10 + 5 * t.degree[d], terms *= t.degree[d] + 1;
        // a derivative's coefficients are at most 2 p times larger, twice in N'w - w'N
        double bound = oracle_gamma(operations + terms) * oracle_growth(&t) * terms * 12 * oracle_largest(&s) *
                       oracle_largest(&s);
        a[var] = 1;
        for (int i = 0; i < 6; i++) {
            double at[2];
            long double x[3], dx[3], y[3];
            for (int d = 0; d < nvars; d++) at[d] = test_uniform(&rng, 0, 4);
            oracle_homogeneous(x, NULL, &s, at, NULL, NULL);
            oracle_homogeneous(dx, NULL, &s, at, a, NULL);
            oracle_homogeneous(y, NULL, &t, at, NULL, NULL);
            for (int c = 0; c < 2; c++) assert_true(fabsl(y[c] - (dx[c] * x[2] - dx[2] * x[c])) <= bound);
            assert_true(fabsl(y[2] - x[2] * x[2]) <= bound);
        }
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &t);
    }
    test_ctx_end(ctx, &memory);
}

static void derivative_of_a_constant(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double k[] = {0, 1, 2}, coef[] = {3, 5};
    kn_spline s = curve(ctx, 0, 2, 1, k, coef);
    assert_int_equal(kn_spline_derivative(ctx, &s, &s, 0), KN_OK);
    assert_int_equal(s.degree[0], 0);
    assert_true(s.coef[0] == 0 && s.coef[1] == 0);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void elevations(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    for (int round = test_scale(20); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3), degree[3], operations = 0;
        kn_spline s = random_operand(ctx, &rng, nvars, 2, round % 2), t = {0};
        for (int d = 0; d < nvars; d++) {
            degree[d] = s.degree[d] + test_int(&rng, 0, 3);
            for (int p = s.degree[d]; p < degree[d]; p++) operations += 7 * p + 5; // blossom, mean, p + 1 terms
        }
        assert_int_equal(kn_spline_elevate(ctx, &t, &s, degree), KN_OK);
        for (int d = 0; d < nvars; d++)
            for (int x = 0; x <= 4; x++) {
                int m = oracle_multiplicity(&s, d, x);
                assert_int_equal(oracle_multiplicity(&t, d, x), m ? m + degree[d] - s.degree[d] : 0);
            }
        assert_int_equal(kn_spline_check(ctx, &t), KN_OK);
        double unit = oracle_largest(&s), bound = oracle_gamma(operations) * unit; // convex combinations all the way
        for (int i = 0; i < 6; i++) {
            double at[3];
            long double x[3], y[3];
            for (int d = 0; d < nvars; d++) at[d] = test_uniform(&rng, 0, 4);
            oracle_homogeneous(x, NULL, &s, at, NULL, NULL);
            oracle_homogeneous(y, NULL, &t, at, NULL, NULL);
            for (int c = 0; c < s.ncomp; c++) assert_true(fabsl(x[c] - y[c]) <= bound);
        }
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &t);
    }
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double k[] = {0, 0, 1, 1}, other[] = {1, 1, 2, 2}, coef[] = {1, 2, 3, 4, 5, 6};
    const double *const k2[] = {k, k};
    kn_spline a = curve(ctx, 1, 2, 3, k, coef), b = curve(ctx, 1, 2, 2, k, coef),
              c = curve(ctx, 1, 2, 3, other, coef);
    kn_spline d, out = {0}, empty = {0};
    assert_int_equal(kn_spline_init(ctx, &d, 2, 3, false, (int[]){1, 1}, (int[]){2, 2}, k2, NULL), KN_OK);
    const binary ops[] = {kn_spline_sum, kn_spline_product, kn_spline_dot, kn_spline_cross, kn_spline_difference};
    for (int i = 0; i < 5; i++) {
        assert_int_equal(ops[i](ctx, &out, &a, &b), KN_EDOMAIN);     // components
        assert_int_equal(ops[i](ctx, &out, &a, &c), KN_EDOMAIN);     // domains that only touch
        assert_int_equal(ops[i](ctx, &out, &a, &d), KN_EDOMAIN);     // variables
        assert_int_equal(ops[i](ctx, &out, &a, &empty), KN_EDOMAIN); // nothing there
        assert_int_equal(ops[i](ctx, &out, &empty, &a), KN_EDOMAIN);
    }
    assert_int_equal(kn_spline_cross(ctx, &out, &b, &b), KN_EDOMAIN);
    assert_int_equal(kn_spline_derivative(ctx, &out, &a, 1), KN_EDOMAIN);
    assert_int_equal(kn_spline_derivative(ctx, &out, &a, -1), KN_EDOMAIN);
    assert_int_equal(kn_spline_derivative(ctx, &out, &empty, 0), KN_EDOMAIN);
    assert_int_equal(kn_spline_elevate(ctx, &out, &a, (int[]){0}), KN_EDOMAIN);
    assert_int_equal(kn_spline_elevate(ctx, &out, &a, (int[]){KN_MAX_DEGREE + 1}), KN_ELIMIT);
    assert_int_equal(kn_spline_elevate(ctx, &out, &empty, (int[]){1}), KN_EDOMAIN);
    assert_int_equal(out.nvars, 0);
    assert_int_equal(kn_spline_elevate(ctx, &a, &a, (int[]){30}), KN_OK);
    for (int i = 1; i < 4; i++) assert_int_equal(ops[i](ctx, &out, &a, &a), KN_ELIMIT); // degree 60
    kn_spline_clear(ctx, &a);
    kn_spline_clear(ctx, &b);
    kn_spline_clear(ctx, &c);
    kn_spline_clear(ctx, &d);
    assert_int_equal(out.nvars, 0);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(binary_operations),
        cmocka_unit_test(exact_product),
        cmocka_unit_test(exact_sum),
        cmocka_unit_test(sum_over_one_weight),
        cmocka_unit_test(derivatives),
        cmocka_unit_test(rational_derivatives),
        cmocka_unit_test(derivative_of_a_constant),
        cmocka_unit_test(elevations),
        cmocka_unit_test(failures),
    };
    return cmocka_run_group_tests_name("spline/algebra", tests, NULL, NULL);
}
