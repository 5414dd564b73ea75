// SPDX-License-Identifier: Apache-2.0
// Affine maps, antiderivatives, integrals, gradients, divergences, mirrored and permuted pieces: in integers, with
// ==.
#include <math.h>
#include <string.h>

#include "tests/bezier/reference.h"

static void fill_matrix(test_rng *rng, double *matrix, double *offset, int rows, int columns)
{
    for (int i = 0; i < rows * columns; i++) matrix[i] = test_int(rng, -3, 3);
    for (int i = 0; i < rows; i++) offset[i] = test_int(rng, -3, 3);
}

static void affine_maps(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int n = test_scale(60); n > 0; n--) {
        int nvars = test_int(&rng, 0, 3), degree[3], rows = test_int(&rng, 1, 4), dim = test_int(&rng, 1, 4);
        bool rational = test_int(&rng, 0, 1), moved = test_int(&rng, 0, 1);
        double matrix[16], offset[4];
        kn_bezier a, b = {0};
        ref_random_degrees(&rng, degree, nvars);
        test_random_bezier(ctx, &a, &rng, nvars, dim + rational, rational, degree, 9);
        fill_matrix(&rng, matrix, offset, rows, dim);
        assert_int_equal(kn_bezier_affine(ctx, &b, &a, rows, matrix, moved ? offset : NULL), KN_OK);
        assert_int_equal(kn_bezier_dim(&b), rows);
        assert_int_equal(b.rational, rational);
        size_t count = kn_bezier_count(&a);
        for (size_t i = 0; i < count; i++) {
            double w = rational ? a.coef[(size_t)dim * count + i] : 1.0;
            for (int r = 0; r < rows; r++) {
                double sum = moved ? offset[r] * w : 0.0;
                for (int c = 0; c < dim; c++) sum += matrix[r * dim + c] * a.coef[(size_t)c * count + i];
                assert_true(b.coef[(size_t)r * count + i] == sum);
            }
            if (rational) assert_true(b.coef[(size_t)rows * count + i] == w);
        }
        assert_int_equal(kn_bezier_affine(ctx, &a, &a, rows, matrix, moved ? offset : NULL), KN_OK); // in place
        ref_assert_same(&a, &b);
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &b);
    }
    test_ctx_end(ctx, &memory);
}

// What a projection drops may be anything; what it keeps stays bit for bit.
static void projection(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double matrix[6] = {0, 0, 1, 1, 0, 0}, coef[6] = {0.1, -0.3, NAN, INFINITY, 1e-310, -7.7};
    kn_bezier a;
    assert_int_equal(kn_bezier_init(ctx, &a, 1, 3, false, (int[]){1}), KN_OK);
    memcpy(a.coef, coef, sizeof coef);
    assert_int_equal(kn_bezier_affine(ctx, &a, &a, 2, matrix, NULL), KN_OK);
    assert_memory_equal(a.coef, coef + 4, 2 * sizeof *coef);
    assert_memory_equal(a.coef + 2, coef, 2 * sizeof *coef);
    kn_bezier_clear(ctx, &a);
    test_ctx_end(ctx, &memory);
}

// Coefficients are multiples of n + 1, so that every division is exact: the derivative gives a back, the
// antiderivative is zero at 0, and all of them one after the other end, in the last corner, in the integral.
static void antiderivatives(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    for (int n = test_scale(60); n > 0; n--) {
        int nvars = test_int(&rng, 1, 4), degree[4], index[4], var = test_int(&rng, 0, nvars - 1);
        double integral[2], all = 1.0;
        kn_bezier a, b = {0}, c = {0};
        ref_random_degrees(&rng, degree, nvars);
        test_random_bezier(ctx, &a, &rng, nvars, 2, false, degree, 9);
        for (int d = 0; d < nvars; d++) all *= degree[d] + 1;
        for (size_t i = 0; i < 2 * kn_bezier_count(&a); i++) a.coef[i] *= all;
        assert_int_equal(kn_bezier_antiderivative(ctx, &b, &a, var), KN_OK);
        assert_int_equal(b.degree[var], degree[var] + 1);
        for (size_t i = 0; i < kn_bezier_count(&b); i++) {
            ref_split(index, i, nvars, b.degree);
            if (index[var] == 0) assert_true(b.coef[i] == 0.0 && b.coef[kn_bezier_count(&b) + i] == 0.0);
        }
        assert_int_equal(kn_bezier_derivative(ctx, &c, &b, var), KN_OK);
        ref_assert_same(&c, &a);
        assert_int_equal(kn_bezier_integral(ctx, integral, &a), KN_OK);
        for (int d = 0; d < nvars; d++) assert_int_equal(kn_bezier_antiderivative(ctx, &a, &a, d), KN_OK); // in place
        for (size_t k = 0; k < 2; k++) assert_true(a.coef[(k + 1) * kn_bezier_count(&a) - 1] == integral[k]);
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &b);
        kn_bezier_clear(ctx, &c);
    }
    test_ctx_end(ctx, &memory);
}

static void integral_of_a_constant(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_bezier a;
    double value;
    assert_int_equal(kn_bezier_init(ctx, &a, 0, 1, false, NULL), KN_OK);
    a.coef[0] = 0.1;
    assert_int_equal(kn_bezier_integral(ctx, &value, &a), KN_OK);
    assert_true(value == 0.1);
    kn_bezier_clear(ctx, &a);
    test_ctx_end(ctx, &memory);
}

// Numerators and weights of the gradient and the divergence at a point, from the definition: over w^2.
static void expected_partials(long double *top, long double *w, const kn_bezier *a, const double *at)
{
    int dim = kn_bezier_dim(a);
    long double f[5], df[5];
    ref_homogeneous(f, a, at);
    *w = a->rational ? f[dim] : 1.0L;
    for (int v = 0; v < a->nvars; v++) {
        int order[KN_MAX_VARS] = {0};
        order[v] = 1;
        ref_partial(df, a, at, order);
        for (int c = 0; c < dim; c++) top[c * a->nvars + v] = a->rational ? df[c] * *w - df[dim] * f[c] : df[c];
    }
}

static void gradients(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    for (int n = test_scale(80); n > 0; n--) {
        bool rational = test_int(&rng, 0, 1);
        int nvars = test_int(&rng, 1, rational ? 2 : 3), degree[3], to[3];
        kn_bezier a, g = {0}, div = {0};
        double at[3];
        long double top[9], w, got[10], d[2], sum = 0.0L;
        for (int v = 0; v < nvars; v++) degree[v] = test_int(&rng, 0, 2), to[v] = 2 * degree[v];
        test_random_bezier(ctx, &a, &rng, nvars, nvars + rational, rational, degree, 5);
        double m = rational ? ref_multiple(nvars, to) : 1.0; // all stays in integers
        for (size_t i = 0; i < (size_t)a.ncomp * kn_bezier_count(&a); i++) a.coef[i] *= m;
        assert_int_equal(kn_bezier_gradient(ctx, &g, &a), KN_OK);
        assert_int_equal(kn_bezier_divergence(ctx, &div, &a), KN_OK);
        assert_int_equal(kn_bezier_dim(&g), nvars * nvars);
        assert_int_equal(kn_bezier_dim(&div), 1);
        for (int v = 0; v < nvars; v++) assert_int_equal(g.degree[v], rational ? to[v] : degree[v]);
        ref_random_point(&rng, at, nvars);
        expected_partials(top, &w, &a, at);
        ref_homogeneous(got, &g, at);
        ref_homogeneous(d, &div, at);
        for (int k = 0; k < nvars * nvars; k++) assert_true(got[k] == top[k]);
        for (int v = 0; v < nvars; v++) sum += top[v * nvars + v];
        assert_true(d[0] == sum);
        if (rational) assert_true(got[nvars * nvars] == w * w && d[1] == w * w);
        kn_bezier b = {0};
        assert_int_equal(kn_bezier_copy(ctx, &b, &a), KN_OK);
        assert_int_equal(kn_bezier_gradient(ctx, &a, &a), KN_OK); // in place
        ref_assert_same(&a, &g);
        assert_int_equal(kn_bezier_divergence(ctx, &b, &b), KN_OK);
        ref_assert_same(&b, &div);
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &b);
        kn_bezier_clear(ctx, &g);
        kn_bezier_clear(ctx, &div);
    }
    test_ctx_end(ctx, &memory);
}

// Values at mirrored and permuted points are equal; twice mirrored, or permuted back, is a itself bit for bit.
static void mirrors_and_permutations(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    for (int n = test_scale(60); n > 0; n--) {
        int nvars = test_int(&rng, 1, 4), degree[4], order[4], back[4], var = test_int(&rng, 0, nvars - 1);
        kn_bezier a, b = {0}, c = {0};
        double at[4], to[4];
        long double x[3], y[3];
        ref_random_degrees(&rng, degree, nvars);
        test_random_bezier(ctx, &a, &rng, nvars, 3, test_int(&rng, 0, 1), degree, 9);
        ref_random_point(&rng, at, nvars);
        ref_homogeneous(x, &a, at);

        assert_int_equal(kn_bezier_reverse(ctx, &b, &a, var), KN_OK);
        memcpy(to, at, sizeof to);
        to[var] = 1.0 - at[var];
        ref_homogeneous(y, &b, to);
        for (int k = 0; k < 3; k++) assert_true(x[k] == y[k]);
        assert_int_equal(kn_bezier_reverse(ctx, &b, &b, var), KN_OK); // in place
        ref_assert_same(&a, &b);

        for (int d = 0; d < nvars; d++) order[d] = d;
        for (int d = nvars - 1; d > 0; d--) {
            int e = test_int(&rng, 0, d), t = order[d];
            order[d] = order[e], order[e] = t;
        }
        for (int d = 0; d < nvars; d++) back[order[d]] = d, to[d] = at[order[d]];
        assert_int_equal(kn_bezier_permute(ctx, &c, &a, order), KN_OK);
        ref_homogeneous(y, &c, to);
        for (int k = 0; k < 3; k++) assert_true(x[k] == y[k]);
        assert_int_equal(kn_bezier_permute(ctx, &c, &c, back), KN_OK); // in place
        ref_assert_same(&a, &c);
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &b);
        kn_bezier_clear(ctx, &c);
    }
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double one[1] = {1.0};
    double value[33] = {17.0};
    kn_bezier a, rational, high, wide, constant, empty = {0}, out;
    assert_int_equal(kn_bezier_init(ctx, &a, 2, 3, false, (int[]){2, 1}), KN_OK);
    assert_int_equal(kn_bezier_init(ctx, &rational, 1, 2, true, (int[]){29}), KN_OK);
    assert_int_equal(kn_bezier_init(ctx, &high, 1, 1, false, (int[]){KN_MAX_DEGREE}), KN_OK);
    assert_int_equal(kn_bezier_init(ctx, &wide, 2, 33, false, (int[]){1, 1}), KN_OK);
    assert_int_equal(kn_bezier_init(ctx, &constant, 0, 1, false, NULL), KN_OK);
    ref_make_sentinel(ctx, &out);
    assert_int_equal(kn_bezier_affine(ctx, &out, &empty, 1, one, NULL), KN_EDOMAIN);
    assert_int_equal(kn_bezier_affine(ctx, &out, &a, 0, one, NULL), KN_EDOMAIN);
    assert_int_equal(kn_bezier_antiderivative(ctx, &out, &empty, 0), KN_EDOMAIN);
    assert_int_equal(kn_bezier_antiderivative(ctx, &out, &a, 2), KN_EDOMAIN);
    assert_int_equal(kn_bezier_antiderivative(ctx, &out, &a, -1), KN_EDOMAIN);
    assert_int_equal(kn_bezier_antiderivative(ctx, &out, &rational, 0), KN_EDOMAIN);
    assert_int_equal(kn_bezier_integral(ctx, value, &empty), KN_EDOMAIN);
    assert_int_equal(kn_bezier_integral(ctx, value, &rational), KN_EDOMAIN);
    assert_int_equal(kn_bezier_gradient(ctx, &out, &empty), KN_EDOMAIN);
    assert_int_equal(kn_bezier_gradient(ctx, &out, &constant), KN_EDOMAIN);
    assert_int_equal(kn_bezier_divergence(ctx, &out, &empty), KN_EDOMAIN);
    assert_int_equal(kn_bezier_divergence(ctx, &out, &a), KN_EDOMAIN); // 3 components, 2 variables
    assert_int_equal(kn_bezier_reverse(ctx, &out, &empty, 0), KN_EDOMAIN);
    assert_int_equal(kn_bezier_reverse(ctx, &out, &a, 2), KN_EDOMAIN);
    assert_int_equal(kn_bezier_permute(ctx, &out, &empty, (int[]){0}), KN_EDOMAIN);
    assert_int_equal(kn_bezier_permute(ctx, &out, &a, (int[]){0, 0}), KN_EDOMAIN);
    assert_int_equal(kn_bezier_permute(ctx, &out, &a, (int[]){0, 2}), KN_EDOMAIN);
    assert_int_equal(kn_bezier_permute(ctx, &out, &a, (int[]){-1, 0}), KN_EDOMAIN);
    assert_int_equal(kn_ctx_error(ctx), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_bezier_affine(ctx, &out, &a, KN_MAX_COMPS + 1, one, NULL), KN_ELIMIT);
    assert_int_equal(kn_bezier_affine(ctx, &out, &rational, KN_MAX_COMPS, one, NULL), KN_ELIMIT);
    assert_int_equal(kn_bezier_antiderivative(ctx, &out, &high, 0), KN_ELIMIT);
    assert_int_equal(kn_bezier_gradient(ctx, &out, &wide), KN_ELIMIT);     // 66 components
    assert_int_equal(kn_bezier_gradient(ctx, &out, &rational), KN_ELIMIT); // degree 58
    assert_int_equal(kn_bezier_divergence(ctx, &out, &rational), KN_ELIMIT);
    assert_int_equal(kn_ctx_error(ctx), KN_ELIMIT);
    assert_true(ref_is_sentinel(&out) && value[0] == 17.0);
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &rational);
    kn_bezier_clear(ctx, &high);
    kn_bezier_clear(ctx, &wide);
    kn_bezier_clear(ctx, &constant);
    kn_bezier_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

enum { CALLS = 7 };

static kn_status call(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int which)
{
    static const double matrix[6] = {0, 1, 2, 0, 1, 1};
    static const int order[2] = {1, 0};
    switch (which) {
    case 0: return kn_bezier_affine(ctx, out, a, 3, matrix, NULL);
    case 1: return kn_bezier_gradient(ctx, out, a);
    case 2: return kn_bezier_divergence(ctx, out, a);
    case 3: return kn_bezier_reverse(ctx, out, a, 0);
    case 4: return kn_bezier_permute(ctx, out, a, order);
    case 5: return kn_bezier_derivative(ctx, out, a, 1);
    default: return a->rational ? KN_OK : kn_bezier_antiderivative(ctx, out, a, 0);
    }
}

static kn_status make(kn_ctx *ctx, kn_bezier *a, bool rational)
{
    kn_status status = kn_bezier_init(ctx, a, 2, 2 + rational, rational, (int[]){2, 1});
    for (size_t i = 0; status == KN_OK && i < (size_t)a->ncomp * kn_bezier_count(a); i++)
        a->coef[i] = 1.0 + (double)i;
    return status;
}

static kn_status call_once(kn_ctx *ctx, void *user)
{
    int which = *(const int *)user;
    kn_bezier a = {0}, out = {0};
    kn_status status = make(ctx, &a, which >= CALLS);
    if (status == KN_OK) status = kn_bezier_init(ctx, &out, 1, 1, false, (int[]){0});
    bool made = status == KN_OK;
    if (made) status = call(ctx, &out, &a, which % CALLS);
    if (made && status != KN_OK) assert_true(out.nvars == 1 && out.coef && out.coef[0] == 0.0);
    kn_bezier before = a;
    if (status == KN_OK) status = call(ctx, &a, &a, which % CALLS);
    if (status != KN_OK) assert_memory_equal(&before, &a, sizeof a);
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &out);
    return status;
}

static void out_of_memory(void **state)
{
    (void)state;
    for (int which = 0; which < 2 * CALLS; which++) test_allocation_failures(call_once, &which);
}

// The second time nothing is allocated.
static void steady_state(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int which = 0; which < 2 * CALLS; which++) {
        kn_bezier a, out = {0};
        assert_int_equal(make(ctx, &a, which >= CALLS), KN_OK);
        assert_int_equal(call(ctx, &out, &a, which % CALLS), KN_OK);
        size_t before = kn_ctx_counters(ctx).allocations;
        assert_int_equal(call(ctx, &out, &a, which % CALLS), KN_OK);
        assert_int_equal(kn_ctx_counters(ctx).allocations, before);
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(affine_maps),     cmocka_unit_test(projection),
        cmocka_unit_test(antiderivatives), cmocka_unit_test(integral_of_a_constant),
        cmocka_unit_test(gradients),       cmocka_unit_test(mirrors_and_permutations),
        cmocka_unit_test(failures),        cmocka_unit_test(out_of_memory),
        cmocka_unit_test(steady_state),
    };
    return cmocka_run_group_tests_name("bezier/calculus", tests, NULL, NULL);
}
