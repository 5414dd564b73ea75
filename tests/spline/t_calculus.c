// SPDX-License-Identifier: Apache-2.0
// Affine maps, components, antiderivatives, integrals, gradients, divergences, mirrored and permuted splines.
#include <float.h>
#include <math.h>
#include <string.h>

#include "kernel/knots.h"
#include "tests/spline/oracle.h"
#include "tests/support/support.h"

// Over [0,4] in every variable, knots at random integers up to degree + 1 times (jumps); coefficients are integers
// times unit, weights from 1 to 4.
static kn_spline random_operand(kn_ctx *ctx, test_rng *rng, int nvars, int dim, bool rational, int least, double unit)
{
    int degree[3], count[3];
    double knots[3][32];
    const double *at[3];
    for (int d = 0; d < nvars; d++) {
        int p = degree[d] = test_int(rng, least, nvars > 2 ? 2 : 3), n = 0;
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
        s.coef[i] = i < n * (size_t)dim ? unit * test_int(rng, -9, 9) : test_int(rng, 1, 4);
    return s;
}

static void assert_same(const kn_spline *a, const kn_spline *b)
{
    assert_int_equal(a->nvars, b->nvars);
    assert_int_equal(a->ncomp, b->ncomp);
    assert_true(a->rational == b->rational);
    for (int d = 0; d < a->nvars; d++) {
        assert_int_equal(a->degree[d], b->degree[d]);
        assert_int_equal(a->count[d], b->count[d]);
        for (int i = 0; i <= a->count[d] + a->degree[d]; i++) assert_true(a->knots[d][i] == b->knots[d][i]);
    }
    for (size_t i = 0; i < kn_spline_count(a) * (size_t)a->ncomp; i++) assert_true(a->coef[i] == b->coef[i]);
}

static void affine_maps_and_components(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = test_scale(20); round > 0; round--) {
        bool rational = test_int(&rng, 0, 1);
        kn_spline a = random_operand(ctx, &rng, test_int(&rng, 1, 2), 3, rational, 0, 1), b = {0}, c = {0};
        double m[6], offset[2] = {test_int(&rng, -3, 3), test_int(&rng, -3, 3)};
        for (int i = 0; i < 6; i++) m[i] = test_int(&rng, -3, 3);
        assert_int_equal(kn_spline_affine(ctx, &b, &a, 2, m, offset), KN_OK);
        size_t n = kn_spline_count(&a);
        for (size_t i = 0; i < n; i++) {
            double w = rational ? a.coef[3 * n + i] : 1.0;
            for (int r = 0; r < 2; r++)
                assert_true(b.coef[(size_t)r * n + i] == m[3 * r] * a.coef[i] + m[3 * r + 1] * a.coef[n + i] +
                                                             m[3 * r + 2] * a.coef[2 * n + i] + offset[r] * w);
            if (rational) assert_true(b.coef[2 * n + i] == w);
        }
        int first = test_int(&rng, 0, a.ncomp - 1), count = test_int(&rng, 1, a.ncomp - first);
        assert_int_equal(kn_spline_components(ctx, &c, &a, first, count), KN_OK);
        assert_int_equal(c.ncomp, count);
        assert_false(c.rational);
        assert_memory_equal(c.coef, a.coef + (size_t)first * n, (size_t)count * n * sizeof *c.coef);
        kn_spline again = {0};
        assert_int_equal(kn_spline_copy(ctx, &again, &a), KN_OK);
        assert_int_equal(kn_spline_components(ctx, &again, &again, first, count), KN_OK); // in place
        assert_same(&again, &c);
        assert_int_equal(kn_spline_affine(ctx, &a, &a, 2, m, offset), KN_OK);
        assert_same(&a, &b);
        kn_spline_clear(ctx, &a);
        kn_spline_clear(ctx, &b);
        kn_spline_clear(ctx, &c);
        kn_spline_clear(ctx, &again);
    }
    test_ctx_end(ctx, &memory);
}

// Coefficients are multiples of all (p + 1), knots are integers: everything is exact, and the antiderivatives in all
// variables one after the other end, in the last corner, in the integral.
static void integrals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    for (int round = test_scale(20); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3);
        kn_spline a = random_operand(ctx, &rng, nvars, 2, false, 0, 12 * 12 * 12);
        double value[2];
        assert_int_equal(kn_spline_integral(ctx, value, &a), KN_OK);
        for (int d = 0; d < nvars; d++) assert_int_equal(kn_spline_antiderivative(ctx, &a, &a, d), KN_OK); // in place
        assert_int_equal(kn_spline_check(ctx, &a), KN_OK);
        size_t n = kn_spline_count(&a);
        for (size_t c = 0; c < 2; c++) assert_true(a.coef[c * n] == 0.0 && a.coef[(c + 1) * n - 1] == value[c]);
        kn_spline_clear(ctx, &a);
    }
    test_ctx_end(ctx, &memory);
}

// The derivative of the antiderivative, in long double, is the function: the coefficients are exact, the oracle's own
// roundings are fewer than 16 a level. It is zero at the start, knots keep their multiplicity, jumps become kinks.
static void antiderivatives(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    for (int round = test_scale(20); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3), var = test_int(&rng, 0, nvars - 1), order[3] = {0};
        kn_spline a = random_operand(ctx, &rng, nvars, 2, false, 0, 12), f = {0};
        assert_int_equal(kn_spline_antiderivative(ctx, &f, &a, var), KN_OK);
        assert_int_equal(f.degree[var], a.degree[var] + 1);
        for (int x = 0; x <= 4; x++)
            assert_int_equal(oracle_multiplicity(&f, var, x), oracle_multiplicity(&a, var, x) + (x == 0 || x == 4));
        order[var] = 1;
        for (int i = 0; i < 6; i++) {
            double at[3];
            long double x[2], y[2], size[2], start[2];
            for (int d = 0; d < nvars; d++) at[d] = test_uniform(&rng, 0, 4);
            oracle_homogeneous(x, NULL, &a, at, NULL, NULL);
            oracle_homogeneous(y, size, &f, at, order, NULL);
            for (int c = 0; c < 2; c++) assert_true(fabsl(x[c] - y[c]) <= 64 * LDBL_EPSILON * size[c]);
            at[var] = 0;
            oracle_homogeneous(start, NULL, &f, at, NULL, NULL);
            assert_true(start[0] == 0 && start[1] == 0);
        }
        kn_spline_clear(ctx, &a);
        kn_spline_clear(ctx, &f);
    }
    test_ctx_end(ctx, &memory);
}

static void check_partial_knots(const kn_spline *g, const kn_spline *a)
{
    for (int d = 0; d < a->nvars; d++) {
        assert_int_equal(g->degree[d], a->degree[d]);
        for (int x = 0; x <= 4; x++) {
            int m = oracle_multiplicity(a, d, x);
            assert_int_equal(oracle_multiplicity(g, d, x), m == 0 ? 0 : oracle_lower(m + 1, a->degree[d] + 1));
        }
    }
}

// On unit spans D <= 2 p max |c|; the bound of the header, whose values are convex combinations of coefficients.
static void gradients(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    for (int round = test_scale(20); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3);
        kn_spline a = random_operand(ctx, &rng, nvars, nvars, false, 0, 1), g = {0}, div = {0};
        assert_int_equal(kn_spline_gradient(ctx, &g, &a), KN_OK);
        assert_int_equal(kn_spline_divergence(ctx, &div, &a), KN_OK);
        assert_int_equal(kn_spline_dim(&g), nvars * nvars);
        assert_int_equal(kn_spline_dim(&div), 1);
        check_partial_knots(&g, &a);
        check_partial_knots(&div, &a);
        assert_int_equal(kn_spline_check(ctx, &g), KN_OK);
        int roundings = 8;
        double steepest = 0.0;
        for (int d = 0; d < nvars; d++) {
            roundings += 7 * a.degree[d] + 1;
            steepest = fmax(steepest, 2.0 * a.degree[d] * oracle_largest(&a));
        }
        for (int i = 0; i < 6; i++) {
            double at[3];
            long double df[3], got[9], d[1], sum = 0.0L;
            for (int k = 0; k < nvars; k++) at[k] = test_uniform(&rng, 0, 4);
            oracle_homogeneous(got, NULL, &g, at, NULL, NULL);
            oracle_homogeneous(d, NULL, &div, at, NULL, NULL);
            for (int v = 0; v < nvars; v++) {
                int order[3] = {0};
                order[v] = 1;
                oracle_homogeneous(df, NULL, &a, at, order, NULL);
                for (int c = 0; c < nvars; c++)
                    assert_true(fabsl(got[c * nvars + v] - df[c]) <= oracle_gamma(roundings) * steepest);
                sum += df[v];
            }
            assert_true(fabsl(d[0] - sum) <= oracle_gamma(roundings) * nvars * steepest);
        }
        kn_spline b = {0};
        assert_int_equal(kn_spline_copy(ctx, &b, &a), KN_OK);
        assert_int_equal(kn_spline_gradient(ctx, &a, &a), KN_OK); // in place
        assert_same(&a, &g);
        assert_int_equal(kn_spline_divergence(ctx, &b, &b), KN_OK);
        assert_same(&b, &div);
        kn_spline_clear(ctx, &a);
        kn_spline_clear(ctx, &b);
        kn_spline_clear(ctx, &g);
        kn_spline_clear(ctx, &div);
    }
    test_ctx_end(ctx, &memory);
}

// Pieces carry 6 p + 1 roundings a variable, their partials are at most 2 p max |c| <= 6 max |c|, in products with
// 3 nvars more and a sum of at most (nvars + 1) terms; joining 6 (2 p) + 1 and its growth.
static void rational_gradients(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    for (int round = test_scale(10); round > 0; round--) {
        int nvars = test_int(&rng, 1, 2);
        kn_spline a = random_operand(ctx, &rng, nvars, nvars, true, 1, 1), g = {0}, div = {0};
        assert_int_equal(kn_spline_gradient(ctx, &g, &a), KN_OK);
        assert_int_equal(kn_spline_divergence(ctx, &div, &a), KN_OK);
        double terms = nvars + 1, operations = 4 * nvars + 8;
        for (int d = 0; d < nvars; d++) {
            operations += 24 * a.degree[d] + 4, terms *= a.degree[d] + 1;
            for (int x = 1; x < 4; x++) {
                int m = oracle_multiplicity(&a, d, x);
                assert_int_equal(oracle_multiplicity(&g, d, x),
                                 m == 0 ? 0 : oracle_lower(a.degree[d] + m + 1, 2 * a.degree[d] + 1));
            }
        }
        double most = oracle_largest(&a);
        double bound = oracle_gamma((int)(operations + terms)) * oracle_growth(&g) * (nvars + 1) * 6 * most * most;
        for (int i = 0; i < 6; i++) {
            double at[2];
            long double f[3], df[3], got[5], d[2], sum = 0.0L;
            for (int k = 0; k < nvars; k++) at[k] = test_uniform(&rng, 0, 4);
            oracle_homogeneous(f, NULL, &a, at, NULL, NULL);
            oracle_homogeneous(got, NULL, &g, at, NULL, NULL);
            oracle_homogeneous(d, NULL, &div, at, NULL, NULL);
            for (int v = 0; v < nvars; v++) {
                int order[2] = {0};
                order[v] = 1;
                oracle_homogeneous(df, NULL, &a, at, order, NULL);
                for (int c = 0; c < nvars; c++) {
                    long double top = df[c] * f[nvars] - df[nvars] * f[c];
                    assert_true(fabsl(got[c * nvars + v] - top) <= bound);
                    sum += c == v ? top : 0.0L;
                }
            }
            assert_true(fabsl(d[0] - sum) <= bound);
            assert_true(fabsl(d[1] - f[nvars] * f[nvars]) <= bound);
            assert_true(fabsl(got[nvars * nvars] - f[nvars] * f[nvars]) <= bound);
        }
        kn_spline_clear(ctx, &a);
        kn_spline_clear(ctx, &g);
        kn_spline_clear(ctx, &div);
    }
    test_ctx_end(ctx, &memory);
}

// Values at mirrored and permuted points are equal within the oracle's own roundings, fewer than 64 in long double;
// twice mirrored, or permuted back, is a itself: its knots are integers.
static void mirrors_and_permutations(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(6);
    for (int round = test_scale(20); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3), var = test_int(&rng, 0, nvars - 1), order[3] = {0, 1, 2}, back[3];
        kn_spline a = random_operand(ctx, &rng, nvars, 2, test_int(&rng, 0, 1), 0, 1), b = {0}, c = {0};
        for (int d = nvars - 1; d > 0; d--) {
            int e = test_int(&rng, 0, d), t = order[d];
            order[d] = order[e], order[e] = t;
        }
        for (int d = 0; d < nvars; d++) back[order[d]] = d;
        assert_int_equal(kn_spline_reverse(ctx, &b, &a, var), KN_OK);
        assert_int_equal(kn_spline_permute(ctx, &c, &a, order), KN_OK);
        for (int i = 0; i < 4; i++) {
            double at[3], mirrored[3], turned[3];
            long double x[3], y[3], z[3], size[3];
            for (int d = 0; d < nvars; d++) at[d] = mirrored[d] = (2 * test_int(&rng, 0, 31) + 1) / 16.0;
            for (int d = 0; d < nvars; d++) turned[d] = at[order[d]];
            mirrored[var] = 4 - at[var];
            oracle_homogeneous(x, size, &a, at, NULL, NULL);
            oracle_homogeneous(y, NULL, &b, mirrored, NULL, NULL);
            oracle_homogeneous(z, NULL, &c, turned, NULL, NULL);
            for (int k = 0; k < a.ncomp; k++)
                assert_true(fmaxl(fabsl(x[k] - y[k]), fabsl(x[k] - z[k])) <= 64 * LDBL_EPSILON * size[k]);
        }
        assert_int_equal(kn_spline_reverse(ctx, &b, &b, var), KN_OK); // in place
        assert_same(&a, &b);
        assert_int_equal(kn_spline_permute(ctx, &c, &c, back), KN_OK); // in place
        assert_same(&a, &c);
        kn_spline_clear(ctx, &a);
        kn_spline_clear(ctx, &b);
        kn_spline_clear(ctx, &c);
    }
    test_ctx_end(ctx, &memory);
}

static kn_spline curve(kn_ctx *ctx, int degree, int count, int ncomp, bool rational, const double *knots)
{
    kn_spline s;
    const double *const k[] = {knots};
    assert_int_equal(kn_spline_init(ctx, &s, 1, ncomp, rational, &degree, &count, k, NULL), KN_OK);
    return s;
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double ends[60], value = 17.0;
    for (int i = 0; i < 30; i++) ends[i] = 0, ends[30 + i] = 1;
    const double one[] = {1}, tight[] = {0, 0, 1, 0x1p60, 0x1p60};
    kn_spline a = curve(ctx, 1, 2, 2, false, ends + 28), close = curve(ctx, 1, 3, 1, false, tight), empty = {0};
    kn_spline rational = curve(ctx, 29, 30, 2, true, ends), out = {0}, wide;
    kn_spline constant = curve(ctx, 0, 1, KN_MAX_COMPS, false, ends + 29);
    assert_int_equal(kn_spline_init(ctx, &wide, 2, 33, false, (int[]){0, 0}, (int[]){1, 1},
                                    (const double *[]){ends + 29, ends + 29}, NULL),
                     KN_OK);
    assert_int_equal(kn_spline_affine(ctx, &out, &empty, 1, one, NULL), KN_EDOMAIN);
    assert_int_equal(kn_spline_affine(ctx, &out, &a, 0, one, NULL), KN_EDOMAIN);
    assert_int_equal(kn_spline_components(ctx, &out, &empty, 0, 1), KN_EDOMAIN);
    assert_int_equal(kn_spline_components(ctx, &out, &a, -1, 1), KN_EDOMAIN);
    assert_int_equal(kn_spline_components(ctx, &out, &a, 0, 0), KN_EDOMAIN);
    assert_int_equal(kn_spline_components(ctx, &out, &a, 1, 2), KN_EDOMAIN);
    assert_int_equal(kn_spline_antiderivative(ctx, &out, &empty, 0), KN_EDOMAIN);
    assert_int_equal(kn_spline_antiderivative(ctx, &out, &a, 1), KN_EDOMAIN);
    assert_int_equal(kn_spline_antiderivative(ctx, &out, &rational, 0), KN_EDOMAIN);
    assert_int_equal(kn_spline_integral(ctx, &value, &empty), KN_EDOMAIN);
    assert_int_equal(kn_spline_integral(ctx, &value, &rational), KN_EDOMAIN);
    assert_int_equal(kn_spline_gradient(ctx, &out, &empty), KN_EDOMAIN);
    assert_int_equal(kn_spline_divergence(ctx, &out, &empty), KN_EDOMAIN);
    assert_int_equal(kn_spline_divergence(ctx, &out, &a), KN_EDOMAIN); // 2 components, 1 variable
    assert_int_equal(kn_spline_reverse(ctx, &out, &empty, 0), KN_EDOMAIN);
    assert_int_equal(kn_spline_reverse(ctx, &out, &a, -1), KN_EDOMAIN);
    assert_int_equal(kn_spline_reverse(ctx, &out, &close, 0), KN_EDOMAIN); // 2^60 - 1 rounds to 2^60
    assert_int_equal(kn_spline_permute(ctx, &out, &empty, (int[]){0}), KN_EDOMAIN);
    assert_int_equal(kn_spline_permute(ctx, &out, &a, (int[]){1}), KN_EDOMAIN);
    assert_int_equal(kn_ctx_error(ctx), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_spline_affine(ctx, &out, &a, KN_MAX_COMPS + 1, one, NULL), KN_ELIMIT);
    assert_int_equal(kn_spline_affine(ctx, &out, &rational, KN_MAX_COMPS, one, NULL), KN_ELIMIT);
    assert_int_equal(kn_spline_gradient(ctx, &out, &rational), KN_ELIMIT); // degree 58
    assert_int_equal(kn_spline_divergence(ctx, &out, &rational), KN_ELIMIT);
    assert_int_equal(kn_spline_gradient(ctx, &out, &constant), KN_OK); // as many components as there may be
    kn_spline_clear(ctx, &out);
    assert_int_equal(kn_spline_gradient(ctx, &out, &wide), KN_ELIMIT); // 66
    rational.rational = false;
    for (int i = 0; i < 27; i++) assert_int_equal(kn_spline_antiderivative(ctx, &rational, &rational, 0), KN_OK);
    assert_int_equal(kn_spline_antiderivative(ctx, &out, &rational, 0), KN_ELIMIT); // degree 57
    assert_true(out.nvars == 0 && value == 17.0);
    kn_spline_clear(ctx, &a);
    kn_spline_clear(ctx, &close);
    kn_spline_clear(ctx, &rational);
    kn_spline_clear(ctx, &constant);
    kn_spline_clear(ctx, &wide);
    test_ctx_end(ctx, &memory);
}

enum { CALLS = 8 };

static kn_status call(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int which)
{
    static const double matrix[6] = {0, 1, 2, 0, 1, 1};
    static const int order[2] = {1, 0};
    switch (which) {
    case 0: return kn_spline_affine(ctx, out, a, 3, matrix, NULL);
    case 1: return kn_spline_gradient(ctx, out, a);
    case 2: return kn_spline_divergence(ctx, out, a);
    case 3: return kn_spline_reverse(ctx, out, a, 0);
    case 4: return kn_spline_permute(ctx, out, a, order);
    case 5: return kn_spline_derivative(ctx, out, a, 1);
    case 6: return kn_spline_components(ctx, out, a, 1, 1);
    default: return a->rational ? KN_OK : kn_spline_antiderivative(ctx, out, a, 0);
    }
}

static kn_status make(kn_ctx *ctx, kn_spline *a, bool rational)
{
    static const double u[] = {0, 0, 0, 1, 2, 2, 2}, v[] = {0, 0, 1, 2, 2};
    double coef[36];
    for (int i = 0; i < 36; i++) coef[i] = 1 + i % 5;
    return kn_spline_init(ctx, a, 2, 2 + rational, rational, (int[]){2, 1}, (int[]){4, 3}, (const double *[]){u, v},
                          coef);
}

static kn_status call_once(kn_ctx *ctx, void *user)
{
    int which = *(const int *)user;
    kn_spline a = {0}, out = {0};
    kn_status status = make(ctx, &a, which >= CALLS);
    if (status == KN_OK) status = call(ctx, &out, &a, which % CALLS);
    if (status != KN_OK) assert_true(out.nvars == 0 && !out.coef);
    if (status == KN_OK) {
        kn_spline before = a;
        status = call(ctx, &a, &a, which % CALLS);
        if (status != KN_OK) assert_memory_equal(&before, &a, sizeof a);
    }
    kn_spline_clear(ctx, &a);
    kn_spline_clear(ctx, &out);
    return status;
}

static kn_status integral_once(kn_ctx *ctx, void *user)
{
    kn_spline a = {0};
    double value[2] = {17.0, 17.0};
    (void)user;
    kn_status status = make(ctx, &a, false);
    if (status == KN_OK) status = kn_spline_integral(ctx, value, &a);
    if (status != KN_OK) assert_true(value[0] == 17.0 && value[1] == 17.0);
    kn_spline_clear(ctx, &a);
    return status;
}

static void out_of_memory(void **state)
{
    (void)state;
    for (int which = 0; which < 2 * CALLS; which++) test_allocation_failures(call_once, &which);
    test_allocation_failures(integral_once, NULL);
}

// The second time nothing is allocated.
static void steady_state(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int which = 0; which < 2 * CALLS; which++) {
        kn_spline a = {0}, out = {0};
        double value[2];
        assert_int_equal(make(ctx, &a, which >= CALLS), KN_OK);
        for (int i = 0; i < 2; i++) { // scratch may grow once more as its blocks become one
            assert_int_equal(call(ctx, &out, &a, which % CALLS), KN_OK);
            if (!a.rational) assert_int_equal(kn_spline_integral(ctx, value, &a), KN_OK);
        }
        size_t before = kn_ctx_counters(ctx).allocations;
        assert_int_equal(call(ctx, &out, &a, which % CALLS), KN_OK);
        if (!a.rational) assert_int_equal(kn_spline_integral(ctx, value, &a), KN_OK);
        assert_int_equal(kn_ctx_counters(ctx).allocations, before);
        kn_spline_clear(ctx, &a);
        kn_spline_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(affine_maps_and_components),
        cmocka_unit_test(integrals),
        cmocka_unit_test(antiderivatives),
        cmocka_unit_test(gradients),
        cmocka_unit_test(rational_gradients),
        cmocka_unit_test(mirrors_and_permutations),
        cmocka_unit_test(failures),
        cmocka_unit_test(out_of_memory),
        cmocka_unit_test(steady_state),
    };
    return cmocka_run_group_tests_name("spline/calculus", tests, NULL, NULL);
}
