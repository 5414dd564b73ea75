// SPDX-License-Identifier: Apache-2.0
// Determinants of pieces; storage: results use out's array again, repeated operations allocate nothing, in place
// gives the same bits; small products of every shape; non-finite coefficients pass through.
#include "bezier/shape.h"
#include "kernel/bernstein.h"
#include "kernel/convolve.h"
#include "kernel/convolve_small.h"
#include "tests/bezier/reference.h"

#include <float.h>
#include <math.h>
#include <string.h>

// det(a, b, c) in integers, each coefficient times the binomials of the result's degrees.
static void integer_determinant(long long *num, const int *degree, const kn_bezier *s)
{
    static const int perm[6][4] = {{0, 1, 2, 1},  {1, 2, 0, 1},  {2, 0, 1, 1},
                                   {0, 2, 1, -1}, {1, 0, 2, -1}, {2, 1, 0, -1}};
    int nvars = s[0].nvars, i[8], j[8], l[8], at[8];
    size_t n[3];
    for (int k = 0; k < 3; k++) n[k] = kn_bezier_count(&s[k]);
    for (size_t x = 0; x < n[0]; x++)
        for (size_t y = 0; y < n[1]; y++)
            for (size_t z = 0; z < n[2]; z++) {
                long long weight = 1, value = 0;
                ref_split(i, x, nvars, s[0].degree);
                ref_split(j, y, nvars, s[1].degree);
                ref_split(l, z, nvars, s[2].degree);
                for (int d = 0; d < nvars; d++) {
                    at[d] = i[d] + j[d] + l[d];
                    weight *= ref_binomial(s[0].degree[d], i[d]) * ref_binomial(s[1].degree[d], j[d]) *
                              ref_binomial(s[2].degree[d], l[d]);
                }
                for (int p = 0; p < 6; p++)
                    value += perm[p][3] * (long long)s[0].coef[(size_t)perm[p][0] * n[0] + x] *
                             (long long)s[1].coef[(size_t)perm[p][1] * n[1] + y] *
                             (long long)s[2].coef[(size_t)perm[p][2] * n[2] + z];
                num[ref_flat(at, nvars, degree)] += weight * value;
            }
}

// No coefficient is divided before the end: integers stay exact up to the last rounding, the weights too.
static void determinants(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = test_scale(60); round > 0; round--) {
        int nvars = test_int(&rng, 0, 3), degree[3][KN_MAX_VARS] = {{0}};
        kn_bezier s[3], det = {0}, w = {0}, copy = {0};
        bool rational[3];
        for (int i = 0; i < 3; i++) {
            rational[i] = test_int(&rng, 0, 3) == 0;
            for (int d = 0; d < nvars; d++) degree[i][d] = test_int(&rng, 0, 4 - nvars);
            test_random_bezier(ctx, &s[i], &rng, nvars, 3 + rational[i], rational[i], degree[i], 9);
        }
        assert_int_equal(kn_bezier_determinant(ctx, &det, &s[0], &s[1], &s[2]), KN_OK);
        bool any = rational[0] || rational[1] || rational[2];
        assert_int_equal(det.ncomp, 1 + any);
        assert_int_equal(det.rational, any);
        long long num[1024] = {0};
        size_t n = kn_bezier_count(&det);
        assert_true(n <= 1024);
        integer_determinant(num, det.degree, s);
        for (size_t i = 0; i < n; i++) assert_true(det.coef[i] == ref_quotient(num[i], i, nvars, det.degree));
        if (any) { // the product of the three weights, by other calls: two roundings of positive numbers
            kn_bezier one[3];
            for (int i = 0; i < 3; i++) {
                one[i] = (kn_bezier){0};
                assert_int_equal(kn_bezier_init(ctx, &one[i], nvars, 1, false, degree[i]), KN_OK);
                size_t m = kn_bezier_count(&s[i]);
                for (size_t k = 0; k < m; k++) one[i].coef[k] = rational[i] ? s[i].coef[3 * m + k] : 1.0;
            }
            assert_int_equal(kn_bezier_product(ctx, &w, &one[0], &one[1]), KN_OK);
            assert_int_equal(kn_bezier_product(ctx, &w, &w, &one[2]), KN_OK);
            for (size_t i = 0; i < n; i++) // gamma(T + 3 N) and gamma(T + N): far below 2^-45
                assert_true(fabs(det.coef[n + i] - w.coef[i]) <= 0x1p-45 * w.coef[i]);
            for (int i = 0; i < 3; i++) kn_bezier_clear(ctx, &one[i]);
        }
        for (int k = 0; k < 3; k++) {
            assert_int_equal(kn_bezier_copy(ctx, &copy, &s[k]), KN_OK);
            assert_int_equal(kn_bezier_determinant(ctx, &copy, k == 0 ? &copy : &s[0], k == 1 ? &copy : &s[1],
                                                   k == 2 ? &copy : &s[2]),
                             KN_OK);
            ref_assert_same(&copy, &det);
        }
        for (int i = 0; i < 3; i++) kn_bezier_clear(ctx, &s[i]);
        kn_bezier_clear(ctx, &det);
        kn_bezier_clear(ctx, &w);
        kn_bezier_clear(ctx, &copy);
    }
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int degree[2] = {20, 1};
    kn_bezier space, curve, plane, empty = {0}, out;
    ref_make_sentinel(ctx, &out);
    assert_int_equal(kn_bezier_init(ctx, &space, 2, 3, false, degree), KN_OK);
    assert_int_equal(kn_bezier_init(ctx, &curve, 1, 3, false, degree), KN_OK);
    assert_int_equal(kn_bezier_init(ctx, &plane, 2, 2, false, degree), KN_OK);
    assert_int_equal(kn_bezier_determinant(ctx, &out, &space, &space, &curve), KN_EDOMAIN);
    assert_int_equal(kn_bezier_determinant(ctx, &out, &curve, &space, &space), KN_EDOMAIN);
    assert_int_equal(kn_bezier_determinant(ctx, &out, &space, &plane, &space), KN_EDOMAIN);
    assert_int_equal(kn_bezier_determinant(ctx, &out, &space, &space, &empty), KN_EDOMAIN);
    assert_int_equal(kn_bezier_determinant(ctx, &out, &space, &space, &space), KN_ELIMIT); // degree 60
    assert_true(ref_is_sentinel(&out));
    kn_bezier_clear(ctx, &space);
    kn_bezier_clear(ctx, &curve);
    kn_bezier_clear(ctx, &plane);
    kn_bezier_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

typedef kn_status (*binary)(kn_ctx *, kn_bezier *, const kn_bezier *, const kn_bezier *);

static kn_status one_of(kn_ctx *ctx, int kind, kn_bezier *out, const kn_bezier *a, const kn_bezier *b)
{
    static const binary pairs[] = {kn_bezier_sum, kn_bezier_difference, kn_bezier_product, kn_bezier_dot,
                                   kn_bezier_cross};
    if (kind < 5) return pairs[kind](ctx, out, a, b);
    if (kind == 5) return kn_bezier_determinant(ctx, out, a, b, a);
    return kind == 6 ? kn_bezier_scale(ctx, out, b, 3.0) : kn_bezier_copy(ctx, out, a);
}

static void nothing_is_allocated_again(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    const int da[2] = {3, 4}, db[2] = {2, 5};
    for (int rational = 0; rational < 2; rational++) {
        kn_bezier a, b, out = {0};
        test_random_bezier(ctx, &a, &rng, 2, 3 + rational, rational, da, 9);
        test_random_bezier(ctx, &b, &rng, 2, 3, false, db, 9);
        for (int kind = 0; kind < 8; kind++) {
            size_t before = 0;
            for (int i = 0; i < 3; i++) {
                before = kn_ctx_counters(ctx).allocations;
                assert_int_equal(one_of(ctx, kind, &out, &a, &b), KN_OK);
            }
            assert_int_equal(kn_ctx_counters(ctx).allocations, before);
        }
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &b);
        kn_bezier_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

// out has as many numbers as the result and is an operand: its array is used, after it was read.
static void in_place_with_the_same_size(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    const int da[2] = {2, 3}, zero[2] = {0, 0};
    for (int kind = 0; kind < 8; kind++) {
        if (kind == 5 || kind == 3) continue; // of other sizes
        kn_bezier a, b, out = {0};
        test_random_bezier(ctx, &a, &rng, 2, 3, false, da, 9);
        test_random_bezier(ctx, &b, &rng, 2, 3, false, kind == 2 || kind == 4 ? zero : da, 9);
        assert_int_equal(one_of(ctx, kind, &out, &a, &b), KN_OK);
        const double *array = a.coef;
        assert_int_equal(one_of(ctx, kind, &a, &a, &b), KN_OK);
        assert_ptr_equal(array, a.coef);
        ref_assert_same(&out, &a);
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &b);
        kn_bezier_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

// The mechanism itself: kn_bezier_begin and kn_bezier_end in their four cases, kn_bezier_store in its.
static void storage(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int same = 0; same < 2; same++)
        for (int operand = 0; operand < 2; operand++) {
            kn_bezier out, c = {.nvars = 1, .ncomp = 1, .degree = {same ? 5 : 6}};
            assert_int_equal(kn_bezier_init(ctx, &out, 1, 2, false, (int[]){2}), KN_OK); // six numbers
            const double *array = out.coef;
            kn_mark mark = kn_scratch_mark(ctx);
            assert_int_equal(kn_bezier_begin(ctx, &c, &out, operand, "test"), KN_OK);
            assert_int_equal(c.coef == array, same && !operand);
            for (int i = 0; i <= c.degree[0]; i++) c.coef[i] = i;
            kn_bezier_end(ctx, &out, &c);
            kn_scratch_release(ctx, mark);
            assert_int_equal(out.coef == array, same);
            assert_int_equal(out.degree[0], same ? 5 : 6);
            for (int i = 0; i <= out.degree[0]; i++) assert_true(out.coef[i] == i);
            kn_bezier empty = {0};
            assert_int_equal(kn_bezier_store(ctx, &out, &out), KN_OK);
            assert_int_equal(kn_bezier_store(ctx, &out, &empty), KN_OK);
            assert_null(out.coef);
        }
    kn_bezier c = {.nvars = 1, .ncomp = 1, .degree = {KN_MAX_DEGREE + 1}}, out = {0};
    assert_int_equal(kn_bezier_begin(ctx, &c, &out, false, "test"), KN_ELIMIT);
    assert_int_equal(kn_bezier_scratch(ctx, &c, "test"), KN_ELIMIT);
    test_ctx_end(ctx, &memory);
}

// ---- small products, each shape of which may go its own way ----
enum { MOST = 10, MOST_RESULT = (2 * MOST - 1) * (2 * MOST - 1) };

// sums += sign * component ca of a * component cb of b, times the binomials of the result; -1: the constant 1.
static void add_product(double *sums, const kn_bezier *a, int ca, const kn_bezier *b, int cb, double sign)
{
    double x[MOST * MOST], y[MOST * MOST];
    size_t na = kn_bezier_count(a), nb = kn_bezier_count(b);
    kn_bernstein_weights(x, a->nvars, a->degree);
    kn_bernstein_weights(y, b->nvars, b->degree);
    for (size_t i = 0; i < na && ca >= 0; i++) x[i] *= a->coef[(size_t)ca * na + i];
    for (size_t i = 0; i < nb && cb >= 0; i++) y[i] *= b->coef[(size_t)cb * nb + i];
    kn_convolve_plain(sums, a->nvars, x, a->degree, y, b->degree, sign);
}

// Sums of integers are exact, and each is rounded once when it is divided.
static void assert_quotients(const kn_bezier *c, int comp, const double *sums)
{
    double weights[MOST_RESULT];
    size_t n = kn_bezier_count(c);
    kn_bernstein_weights(weights, c->nvars, c->degree);
    for (size_t i = 0; i < n; i++)
        if (c->coef[(size_t)comp * n + i] != sums[i] / weights[i])
            fail_msg("component %d, place %zu: %g, not %g (degrees .., %d)", comp, i, c->coef[(size_t)comp * n + i],
                     sums[i] / weights[i], c->degree[c->nvars - 1]);
}

// c_k and the sum of the absolute values of its terms, in long double.
static void exact_product(long double *c, long double *size, const kn_bezier *a, const kn_bezier *b)
{
    double wa[MOST * MOST], wb[MOST * MOST], wc[MOST_RESULT];
    int p = b->degree[0], q = b->degree[1], columns = a->degree[1] + q + 1;
    const int degree[2] = {a->degree[0] + p, columns - 1};
    kn_bernstein_weights(wa, 2, a->degree);
    kn_bernstein_weights(wb, 2, b->degree);
    kn_bernstein_weights(wc, 2, degree);
    for (int k = 0; k < (degree[0] + 1) * columns; k++) c[k] = size[k] = 0.0L;
    for (int i = 0, ij = 0; i <= a->degree[0]; i++)
        for (int j = 0; j <= a->degree[1]; j++, ij++)
            for (int k = 0, kl = 0; k <= p; k++)
                for (int l = 0; l <= q; l++, kl++) {
                    int at = (i + k) * columns + j + l;
                    long double term = (long double)(wa[ij] * wb[kl]) * a->coef[ij] * b->coef[kl] / wc[at];
                    c[at] += term, size[at] += fabsl(term);
                }
}

// gamma(n) <= (n + 1) u for these n. Small products sum rows, then the rows' sums (kernel/convolve_small.h); 6 are
// the scaled operands and the division. The other sum has T + 5 roundings.
static void check_bound(const kn_bezier *a, const kn_bezier *b, const kn_bezier *c)
{
    long double exact[MOST_RESULT], size[MOST_RESULT];
    int r = a->degree[0] < b->degree[0] ? a->degree[0] + 1 : b->degree[0] + 1;
    int t = a->degree[1] < b->degree[1] ? a->degree[1] + 1 : b->degree[1] + 1;
    bool small = kn_small_here();
    for (int d = 0; d < 2; d++) small = small && a->degree[d] < MOST - 1 && b->degree[d] < MOST - 1;
    long double bound = (long double)((small ? r + t : r * t) + 7) * (DBL_EPSILON / 2);
    bound += (long double)(r * t + 6) * LDBL_EPSILON;
    exact_product(exact, size, a, b);
    for (size_t i = 0; i < kn_bezier_count(c); i++)
        assert_true(fabsl((long double)c->coef[i] - exact[i]) <= bound * size[i]);
}

static void every_small_shape(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    double sums[MOST_RESULT];
    int round = 0;
    for (int shape = 0; shape < MOST * MOST * MOST * MOST; shape++) {
        const int da[2] = {shape % MOST, shape / MOST % MOST};
        const int db[2] = {shape / (MOST * MOST) % MOST, shape / (MOST * MOST * MOST)};
        kn_bezier a, b, c = {0};
        test_random_bezier(ctx, &a, &rng, 2, 1, false, da, 9);
        test_random_bezier(ctx, &b, &rng, 2, 1, false, db, 9);
        memset(sums, 0, sizeof sums);
        add_product(sums, &a, 0, &b, 0, 1.0);
        assert_int_equal(kn_bezier_product(ctx, &c, &a, &b), KN_OK);
        assert_true(c.nvars == 2 && c.degree[0] == da[0] + db[0] && c.degree[1] == da[1] + db[1]);
        assert_quotients(&c, 0, sums);
        bool square = da[0] == da[1] && da[0] == db[0] && db[0] == db[1];
        if (square || round++ % 5 == 0) {
            for (size_t i = 0; i < kn_bezier_count(&a); i++) a.coef[i] = test_uniform(&rng, -1, 1);
            for (size_t i = 0; i < kn_bezier_count(&b); i++) b.coef[i] = test_uniform(&rng, -1, 1);
            assert_int_equal(kn_bezier_product(ctx, &c, &a, &b), KN_OK); // into c's own array
            check_bound(&a, &b, &c);
            kn_bezier *to = round % 2 ? &a : &b;
            assert_int_equal(kn_bezier_product(ctx, to, &a, &b), KN_OK);
            ref_assert_same(to, &c);
        }
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &b);
        kn_bezier_clear(ctx, &c);
    }
    test_ctx_end(ctx, &memory);
}

// Components, weights, curves; sums of products by dot and cross.
static void small_components(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    double sums[MOST_RESULT];
    kn_bezier c = {0};
    for (int round = test_scale(600); round > 0; round--) {
        int nvars = test_int(&rng, 1, 2), na = test_int(&rng, 1, 2) == 1 ? 1 : 3,
            nb = test_int(&rng, 1, 2) == 1 ? 1 : 3;
        bool ra = test_int(&rng, 0, 2) == 0, rb = test_int(&rng, 0, 2) == 0;
        int da[2], db[2];
        for (int d = 0; d < 2; d++) da[d] = test_int(&rng, 0, MOST - 1), db[d] = test_int(&rng, 0, MOST - 1);
        kn_bezier a, b;
        test_random_bezier(ctx, &a, &rng, nvars, na + ra, ra, da, 9);
        test_random_bezier(ctx, &b, &rng, nvars, nb + rb, rb, db, 9);
        int dim = na > nb ? na : nb;
        for (int kind = 0; kind < 3; kind++) {
            if (kind > 0 && na != nb) continue;
            if (kind == 2 && na != 3) continue;
            kn_status status = kind == 0   ? kn_bezier_product(ctx, &c, &a, &b)
                               : kind == 1 ? kn_bezier_dot(ctx, &c, &a, &b)
                                           : kn_bezier_cross(ctx, &c, &a, &b);
            assert_int_equal(status, KN_OK);
            assert_int_equal(c.rational, ra || rb);
            assert_int_equal(kn_bezier_dim(&c), kind == 1 ? 1 : dim);
            for (int k = 0; k < c.ncomp; k++) {
                memset(sums, 0, sizeof sums);
                if (k == kn_bezier_dim(&c)) {
                    add_product(sums, &a, ra ? na : -1, &b, rb ? nb : -1, 1.0);
                } else if (kind == 0) {
                    add_product(sums, &a, na > 1 ? k : 0, &b, nb > 1 ? k : 0, 1.0);
                } else if (kind == 1) {
                    for (int i = 0; i < dim; i++) add_product(sums, &a, i, &b, i, 1.0);
                } else {
                    add_product(sums, &a, (k + 1) % 3, &b, (k + 2) % 3, 1.0);
                    add_product(sums, &a, (k + 2) % 3, &b, (k + 1) % 3, -1.0);
                }
                assert_quotients(&c, k, sums);
            }
        }
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &b);
    }
    kn_bezier_clear(ctx, &c);
    test_ctx_end(ctx, &memory);
}

// An infinite coefficient: what has it in its sum is not finite; all else is as it was with a number there, or NaN.
static void not_finite(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(6);
    kn_bezier c = {0}, with = {0};
    for (int round = test_scale(150); round > 0; round--) {
        int da[2], db[2];
        for (int d = 0; d < 2; d++) da[d] = test_int(&rng, 0, MOST - 1), db[d] = test_int(&rng, 0, MOST - 1);
        if (round % 2) da[0] = da[1] = db[0] = db[1] = round / 2 % MOST;
        kn_bezier a, b;
        test_random_bezier(ctx, &a, &rng, 2, 1, false, da, 9);
        test_random_bezier(ctx, &b, &rng, 2, 1, false, db, 9);
        assert_int_equal(kn_bezier_product(ctx, &c, &a, &b), KN_OK);
        int i = test_int(&rng, 0, da[0]), j = test_int(&rng, 0, da[1]);
        a.coef[i * (da[1] + 1) + j] = round % 3 ? INFINITY : NAN;
        assert_int_equal(kn_bezier_product(ctx, &with, &a, &b), KN_OK);
        for (int k = 0, at = 0; k <= c.degree[0]; k++)
            for (int l = 0; l <= c.degree[1]; l++, at++) {
                bool meets = k >= i && k - i <= db[0] && l >= j && l - j <= db[1];
                double x = with.coef[at];
                assert_true(meets ? !isfinite(x) : isnan(x) || x == c.coef[at]);
            }
        kn_bezier_clear(ctx, &a);
        kn_bezier_clear(ctx, &b);
    }
    kn_bezier_clear(ctx, &c);
    kn_bezier_clear(ctx, &with);
    test_ctx_end(ctx, &memory);
}

static kn_status call(kn_ctx *ctx, void *user)
{
    int kind = *(const int *)user;
    const int da[2] = {1, 2}, db[2] = {2, 1};
    kn_bezier a = {0}, b = {0}, out = {0};
    kn_status status = kn_bezier_init(ctx, &a, 2, 4, true, da);
    if (status == KN_OK) status = kn_bezier_init(ctx, &b, 2, 3, false, db);
    for (int pass = 0; pass < 2 && status == KN_OK; pass++) {
        kn_bezier *to = pass ? &b : &out, before = *to;
        status = one_of(ctx, kind, to, &a, &b);
        if (status != KN_OK) assert_memory_equal(&before, to, sizeof before);
    }
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &b);
    kn_bezier_clear(ctx, &out);
    return status;
}

static void out_of_memory(void **state)
{
    (void)state;
    for (int kind = 0; kind < 8; kind++) test_allocation_failures(call, &kind);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(determinants),
        cmocka_unit_test(failures),
        cmocka_unit_test(nothing_is_allocated_again),
        cmocka_unit_test(in_place_with_the_same_size),
        cmocka_unit_test(storage),
        cmocka_unit_test(every_small_shape),
        cmocka_unit_test(small_components),
        cmocka_unit_test(not_finite),
        cmocka_unit_test(out_of_memory),
    };
    return cmocka_run_group_tests_name("bezier/product", tests, NULL, NULL);
}
