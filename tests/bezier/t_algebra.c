// SPDX-License-Identifier: Apache-2.0
// Sum, difference, scale, product, dot, cross, components: coefficients against integer convolutions, with ==.
#include "tests/bezier/reference.h"

typedef kn_status (*operation)(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b);

static void assert_component(const kn_bezier *c, int comp, const long long *num)
{
    size_t n = kn_bezier_count(c);
    for (size_t i = 0; i < n; i++) {
        double expected = ref_quotient(num[i], i, c->nvars, c->degree), got = c->coef[(size_t)comp * n + i];
        if (got != expected) fail_msg("component %d, coefficient %zu: %.17g, not %.17g", comp, i, got, expected);
    }
}

static int weight_of(const kn_bezier *x)
{
    return x->rational ? x->ncomp - 1 : -1;
}

// The weight of a product, when it is rational: the product of the weights.
static void assert_weight(const kn_bezier *c, const kn_bezier *a, const kn_bezier *b)
{
    long long num[4096] = {0};
    assert_int_equal(c->rational, a->rational || b->rational);
    if (!c->rational) return;
    assert_true(kn_bezier_count(c) <= 4096);
    ref_convolve(num, c->degree, a, weight_of(a), b, weight_of(b), 1);
    assert_component(c, c->ncomp - 1, num);
}

static void assert_product(const kn_bezier *c, const kn_bezier *a, const kn_bezier *b)
{
    int da = kn_bezier_dim(a), db = kn_bezier_dim(b), dim = da > db ? da : db;
    assert_int_equal(kn_bezier_dim(c), dim);
    for (int i = 0; i < dim; i++) {
        long long num[4096] = {0};
        ref_convolve(num, c->degree, a, da > 1 ? i : 0, b, db > 1 ? i : 0, 1);
        assert_component(c, i, num);
    }
    assert_weight(c, a, b);
}

static void assert_dot(const kn_bezier *c, const kn_bezier *a, const kn_bezier *b)
{
    long long num[4096] = {0};
    assert_int_equal(kn_bezier_dim(c), 1);
    for (int i = 0; i < kn_bezier_dim(a); i++) ref_convolve(num, c->degree, a, i, b, i, 1);
    assert_component(c, 0, num);
    assert_weight(c, a, b);
}

static void assert_cross(const kn_bezier *c, const kn_bezier *a, const kn_bezier *b)
{
    static const int of[3][2] = {{1, 2}, {2, 0}, {0, 1}};
    assert_int_equal(kn_bezier_dim(c), 3);
    for (int i = 0; i < 3; i++) {
        long long num[4096] = {0};
        ref_convolve(num, c->degree, a, of[i][0], b, of[i][1], 1);
        ref_convolve(num, c->degree, a, of[i][1], b, of[i][0], -1);
        assert_component(c, i, num);
    }
    assert_weight(c, a, b);
}

static void assert_rational_sum(const kn_bezier *c, const kn_bezier *a, const kn_bezier *b, int sign)
{
    assert_int_equal(kn_bezier_dim(c), kn_bezier_dim(a));
    for (int i = 0; i < kn_bezier_dim(c); i++) {
        long long num[4096] = {0};
        ref_convolve(num, c->degree, a, i, b, weight_of(b), 1);
        ref_convolve(num, c->degree, a, weight_of(a), b, i, sign);
        assert_component(c, i, num);
    }
    assert_weight(c, a, b);
}

// out may be a or b: the same coefficients must come out.
static void assert_in_place(kn_ctx *ctx, operation op, const kn_bezier *a, const kn_bezier *b, const kn_bezier *c)
{
    kn_bezier x = {0}, y = {0};
    assert_int_equal(kn_bezier_copy(ctx, &x, a), KN_OK);
    assert_int_equal(kn_bezier_copy(ctx, &y, b), KN_OK);
    assert_int_equal(op(ctx, &x, &x, b), KN_OK);
    assert_int_equal(op(ctx, &y, a, &y), KN_OK);
    ref_assert_same(&x, c);
    ref_assert_same(&y, c);
    assert_int_equal(op(ctx, &x, a, a), KN_OK);
    assert_int_equal(kn_bezier_copy(ctx, &y, a), KN_OK);
    assert_int_equal(op(ctx, &y, &y, &y), KN_OK);
    ref_assert_same(&x, &y);
    kn_bezier_clear(ctx, &x);
    kn_bezier_clear(ctx, &y);
}

typedef void (*checker)(const kn_bezier *c, const kn_bezier *a, const kn_bezier *b);

static void try_pair(operation op, checker check, test_rng *rng, int nvars, int da, int db, int which)
{
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    int na[KN_MAX_VARS], nb[KN_MAX_VARS];
    bool ra = which & 1, rb = which & 2;
    kn_bezier a, b, c = {0};
    ref_random_degrees(rng, na, nvars);
    ref_random_degrees(rng, nb, nvars);
    test_random_bezier(ctx, &a, rng, nvars, da + ra, ra, na, 9);
    test_random_bezier(ctx, &b, rng, nvars, db + rb, rb, nb, 9);
    assert_int_equal(op(ctx, &c, &a, &b), KN_OK);
    for (int d = 0; d < nvars; d++) assert_int_equal(c.degree[d], na[d] + nb[d]);
    check(&c, &a, &b);
    if (da == db) assert_in_place(ctx, op, &a, &b, &c);
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &b);
    kn_bezier_clear(ctx, &c);
    test_ctx_end(ctx, &memory);
}

static void products(void **state)
{
    (void)state;
    test_rng rng = test_random(1);
    for (int n = test_scale(3); n > 0; n--)
        for (int nvars = 0; nvars <= 4; nvars++)
            for (int which = 0; which < 4; which++) {
                try_pair(kn_bezier_product, assert_product, &rng, nvars, 2, 2, which);
                try_pair(kn_bezier_product, assert_product, &rng, nvars, 1, 3, which);
                try_pair(kn_bezier_product, assert_product, &rng, nvars, 3, 1, which);
            }
}

static void dots_and_crosses(void **state)
{
    (void)state;
    test_rng rng = test_random(2);
    for (int n = test_scale(3); n > 0; n--)
        for (int nvars = 0; nvars <= 4; nvars++)
            for (int which = 0; which < 4; which++) {
                int dim = test_int(&rng, 1, 4);
                try_pair(kn_bezier_dot, assert_dot, &rng, nvars, dim, dim, which);
                try_pair(kn_bezier_cross, assert_cross, &rng, nvars, 3, 3, which);
            }
}

static void check_sum(const kn_bezier *c, const kn_bezier *a, const kn_bezier *b)
{
    assert_rational_sum(c, a, b, 1);
}

static void check_difference(const kn_bezier *c, const kn_bezier *a, const kn_bezier *b)
{
    assert_rational_sum(c, a, b, -1);
}

static void rational_sums(void **state)
{
    (void)state;
    test_rng rng = test_random(3);
    for (int n = test_scale(3); n > 0; n--)
        for (int nvars = 1; nvars <= 4; nvars++)
            for (int which = 1; which < 4; which++) {
                try_pair(kn_bezier_sum, check_sum, &rng, nvars, 2, 2, which);
                try_pair(kn_bezier_difference, check_difference, &rng, nvars, 2, 2, which);
            }
}

// Coefficients are multiples of what raising the degree divides by, so that the sum is exact; then values agree.
static void polynomial_sums(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    for (int n = test_scale(60); n > 0; n--) {
        int nvars = test_int(&rng, 1, 4), na[4], nb[4], most[4];
        kn_bezier a, b, s = {0}, d = {0};
        ref_random_degrees(&rng, na, nvars);
        ref_random_degrees(&rng, nb, nvars);
        for (int v = 0; v < nvars; v++) most[v] = na[v] > nb[v] ? na[v] : nb[v];
        test_random_bezier(ctx, &a, &rng, nvars, 2, false, na, 9);
        test_random_bezier(ctx, &b, &rng, nvars, 2, false, nb, 9);
        assert_int_equal(kn_bezier_scale(ctx, &a, &a, ref_multiple(nvars, most)), KN_OK);
        assert_int_equal(kn_bezier_scale(ctx, &b, &b, ref_multiple(nvars, most)), KN_OK);
        assert_int_equal(kn_bezier_sum(ctx, &s, &a, &b), KN_OK);
        assert_int_equal(kn_bezier_difference(ctx, &d, &a, &b), KN_OK);
        assert_memory_equal(s.degree, most, (size_t)nvars * sizeof(int));
        double at[4], va[2], vb[2], vs[2], vd[2];
        ref_random_point(&rng, at, nvars);
        ref_value(va, &a, at);
        ref_value(vb, &b, at);
        ref_value(vs, &s, at);
        ref_value(vd, &d, at);
        for (int c = 0; c < 2; c++) {
            assert_true(vs[c] == va[c] + vb[c]);
            assert_true(vd[c] == va[c] - vb[c]);
        }
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &b);
        kn_bezier_clear(ctx, &s);
        kn_bezier_clear(ctx, &d);
    }
    test_ctx_end(ctx, &memory);
}

// Equal weights: the weight and the degrees stay, the numerators add up.
static void sums_over_one_weight(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    const int degree[2] = {3, 2};
    kn_bezier a, b, s = {0};
    test_random_bezier(ctx, &a, &rng, 2, 3, true, degree, 9);
    test_random_bezier(ctx, &b, &rng, 2, 3, true, degree, 9);
    size_t n = kn_bezier_count(&a);
    for (size_t i = 0; i < n; i++) b.coef[2 * n + i] = a.coef[2 * n + i];
    assert_int_equal(kn_bezier_sum(ctx, &s, &a, &b), KN_OK);
    assert_memory_equal(s.degree, degree, sizeof degree);
    for (size_t i = 0; i < 2 * n; i++) assert_true(s.coef[i] == a.coef[i] + b.coef[i]);
    for (size_t i = 2 * n; i < 3 * n; i++) assert_true(s.coef[i] == a.coef[i]);
    assert_int_equal(kn_bezier_difference(ctx, &s, &s, &b), KN_OK);
    ref_assert_same(&s, &a);
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &b);
    kn_bezier_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void scales_and_components(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(6);
    const int degree[2] = {2, 1};
    kn_bezier a, c = {0};
    test_random_bezier(ctx, &a, &rng, 2, 4, true, degree, 9);
    assert_int_equal(kn_bezier_scale(ctx, &c, &a, -3.0), KN_OK);
    for (size_t i = 0; i < 24; i++) assert_true(c.coef[i] == (i < 18 ? -3.0 : 1.0) * a.coef[i]);
    assert_int_equal(kn_bezier_components(ctx, &c, &a, 1, 3), KN_OK);
    assert_int_equal(c.ncomp, 3);
    assert_false(c.rational);
    assert_memory_equal(c.coef, a.coef + 6, 18 * sizeof *c.coef);
    assert_int_equal(kn_bezier_components(ctx, &c, &c, 0, 1), KN_OK); // in place
    assert_memory_equal(c.coef, a.coef + 6, 6 * sizeof *c.coef);
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &c);
    test_ctx_end(ctx, &memory);
}

// The product of constant-1 pieces of degree 28 is the constant 1 of degree 56: C(56,k) = sum C(28,i) C(28,k-i), and
// all of it stays below 2^53. With signs the sums stay below it too.
static void highest_degree(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(7);
    const int degree[1] = {28}, over[1] = {29};
    kn_bezier a, b, c = {0};
    test_random_bezier(ctx, &a, &rng, 1, 1, false, degree, 1);
    test_random_bezier(ctx, &b, &rng, 1, 1, false, degree, 1);
    assert_int_equal(kn_bezier_product(ctx, &c, &a, &b), KN_OK);
    assert_product(&c, &a, &b);
    for (int i = 0; i <= 28; i++) a.coef[i] = b.coef[i] = 1.0;
    assert_int_equal(kn_bezier_product(ctx, &c, &a, &b), KN_OK);
    for (int i = 0; i <= 56; i++) assert_true(c.coef[i] == 1.0);
    kn_bezier_clear(ctx, &b);
    assert_int_equal(kn_bezier_init(ctx, &b, 1, 1, false, over), KN_OK);
    assert_int_equal(kn_bezier_product(ctx, &c, &a, &b), KN_ELIMIT);
    assert_int_equal(kn_ctx_error(ctx), KN_ELIMIT);
    assert_int_equal(c.degree[0], 56);
    assert_true(c.coef[56] == 1.0);
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &b);
    kn_bezier_clear(ctx, &c);
    test_ctx_end(ctx, &memory);
}

static void refuse(kn_ctx *ctx, operation op, const kn_bezier *a, const kn_bezier *b, kn_status expected)
{
    kn_bezier out;
    ref_make_sentinel(ctx, &out);
    kn_ctx_clear_error(ctx);
    assert_int_equal(op(ctx, &out, a, b), expected);
    assert_int_equal(kn_ctx_error(ctx), expected);
    assert_true(kn_ctx_message(ctx)[0] != '\0');
    assert_true(ref_is_sentinel(&out));
    kn_bezier_clear(ctx, &out);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static const operation all[] = {kn_bezier_sum, kn_bezier_difference, kn_bezier_product, kn_bezier_dot,
                                    kn_bezier_cross};
    const int degree[2] = {1, 1};
    kn_bezier curve, surface, plane, wide, wide_rational, empty = {0}, out;
    assert_int_equal(kn_bezier_init(ctx, &curve, 1, 3, false, degree), KN_OK);
    assert_int_equal(kn_bezier_init(ctx, &surface, 2, 3, false, degree), KN_OK);
    assert_int_equal(kn_bezier_init(ctx, &plane, 2, 2, false, degree), KN_OK);
    assert_int_equal(kn_bezier_init(ctx, &wide, 2, KN_MAX_COMPS, false, degree), KN_OK);
    assert_int_equal(kn_bezier_init(ctx, &wide_rational, 2, 2, true, degree), KN_OK);
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        refuse(ctx, all[i], &curve, &surface, KN_EDOMAIN);
        refuse(ctx, all[i], &surface, &plane, KN_EDOMAIN);
        refuse(ctx, all[i], &empty, &surface, KN_EDOMAIN);
        refuse(ctx, all[i], &surface, &empty, KN_EDOMAIN);
    }
    refuse(ctx, kn_bezier_cross, &plane, &plane, KN_EDOMAIN);
    refuse(ctx, kn_bezier_product, &wide, &wide_rational, KN_ELIMIT); // 64 components and a weight
    ref_make_sentinel(ctx, &out);
    assert_int_equal(kn_bezier_scale(ctx, &out, &empty, 2.0), KN_EDOMAIN);
    assert_int_equal(kn_bezier_components(ctx, &out, &empty, 0, 1), KN_EDOMAIN);
    assert_int_equal(kn_bezier_components(ctx, &out, &curve, -1, 1), KN_EDOMAIN);
    assert_int_equal(kn_bezier_components(ctx, &out, &curve, 0, 0), KN_EDOMAIN);
    assert_int_equal(kn_bezier_components(ctx, &out, &curve, 1, 3), KN_EDOMAIN);
    assert_int_equal(kn_bezier_components(ctx, &out, &curve, 2147483647, 2), KN_EDOMAIN);
    assert_true(ref_is_sentinel(&out));
    kn_bezier_clear(ctx, &out);
    kn_bezier_clear(ctx, &curve);
    kn_bezier_clear(ctx, &surface);
    kn_bezier_clear(ctx, &plane);
    kn_bezier_clear(ctx, &wide);
    kn_bezier_clear(ctx, &wide_rational);
    test_ctx_end(ctx, &memory);
}

// A polynomial and a rational operand: the most components that a sum can have.
static void widest_sum(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int degree[1] = {1};
    kn_bezier a, b;
    assert_int_equal(kn_bezier_init(ctx, &a, 1, KN_MAX_COMPS - 1, false, degree), KN_OK);
    assert_int_equal(kn_bezier_init(ctx, &b, 1, KN_MAX_COMPS, true, degree), KN_OK);
    assert_int_equal(kn_bezier_sum(ctx, &a, &a, &b), KN_OK); // 63 and a weight fit
    assert_int_equal(a.ncomp, KN_MAX_COMPS);
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &b);
    test_ctx_end(ctx, &memory);
}

typedef struct memory_case {
    operation op;
    bool rational;
} memory_case;

static kn_status call_pair(kn_ctx *ctx, void *user)
{
    const memory_case *m = user;
    const int degree[2] = {1, 2};
    kn_bezier a = {0}, b = {0}, out = {0};
    kn_status status = kn_bezier_init(ctx, &a, 2, 3 + m->rational, m->rational, degree);
    if (status == KN_OK) status = kn_bezier_init(ctx, &b, 2, 3, false, degree);
    if (status == KN_OK) status = m->op(ctx, &b, &a, &b);
    if (status != KN_OK && b.coef) assert_true(b.ncomp == 3 && !b.rational && b.degree[1] == 2 && b.coef[0] == 0.0);
    if (status == KN_OK) status = kn_bezier_scale(ctx, &out, &b, 2.0);
    if (status == KN_OK) status = kn_bezier_components(ctx, &out, &a, 0, 1);
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &b);
    kn_bezier_clear(ctx, &out);
    return status;
}

static void out_of_memory(void **state)
{
    (void)state;
    static const operation all[] = {kn_bezier_sum, kn_bezier_difference, kn_bezier_product, kn_bezier_dot,
                                    kn_bezier_cross};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        for (int rational = 0; rational < 2; rational++) {
            memory_case m = {all[i], rational != 0};
            test_allocation_failures(call_pair, &m);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(products),
                                       cmocka_unit_test(dots_and_crosses),
                                       cmocka_unit_test(rational_sums),
                                       cmocka_unit_test(polynomial_sums),
                                       cmocka_unit_test(sums_over_one_weight),
                                       cmocka_unit_test(scales_and_components),
                                       cmocka_unit_test(highest_degree),
                                       cmocka_unit_test(failures),
                                       cmocka_unit_test(widest_sum),
                                       cmocka_unit_test(out_of_memory)};
    return cmocka_run_group_tests_name("bezier/algebra", tests, NULL, NULL);
}
