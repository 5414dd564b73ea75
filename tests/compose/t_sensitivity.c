// SPDX-License-Identifier: Apache-2.0
// Sensitivities of compositions to the control points of either side.
#include "tests/support/support.h"

#include <knurl/compose.h>
#include <math.h>
#include <string.h>

static void make(kn_ctx *ctx, kn_bezier *out, test_rng *rng, int nvars, int ncomp, bool rational, int most)
{
    int degree[3];
    for (int d = 0; d < nvars; d++) degree[d] = test_int(rng, 0, most);
    test_random_bezier(ctx, out, rng, nvars, ncomp, rational, degree, 4);
}

static void random_index(int *index, size_t *place, const kn_bezier *b, test_rng *rng)
{
    *place = 0;
    for (int d = 0; d < b->nvars; d++) {
        index[d] = test_int(rng, 0, b->degree[d]);
        *place = *place * (size_t)(b->degree[d] + 1) + (size_t)index[d];
    }
}

// f is linear in outer's coefficients: with one of them larger by 1, polynomial pieces of small integers give
// W f' - W f = W d, W the binomials that every coefficient was divided by. Compared after multiplication by them,
// where all are integers below 2^53: rounding gives them back.
static void to_outer(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(41);
    for (int run = 0; run < test_scale(60); run++) {
        kn_bezier outer, inner, f = {0}, g = {0}, d = {0};
        int n = test_int(&rng, 1, 3), index[3];
        size_t place;
        make(ctx, &outer, &rng, n, 2, false, 2);
        make(ctx, &inner, &rng, test_int(&rng, 1, 2), n, false, 1);
        random_index(index, &place, &outer, &rng);
        assert_int_equal(kn_bezier_compose(ctx, &f, &outer, &inner), KN_OK);
        assert_int_equal(kn_bezier_compose_outer_sensitivity(ctx, &d, &outer, &inner, index), KN_OK);
        size_t count = kn_bezier_count(&f), last = (size_t)f.degree[f.nvars - 1] + 1;
        for (int c = 0; c < 2; c++) { // any component of that control point
            double *coef = &outer.coef[(size_t)c * kn_bezier_count(&outer) + place];
            *coef += 1;
            assert_int_equal(kn_bezier_compose(ctx, &g, &outer, &inner), KN_OK);
            *coef -= 1;
            assert_true(d.ncomp == 1 && !d.rational && kn_bezier_count(&d) == count);
            for (size_t i = 0; i < count; i++) {
                double w = 1;
                size_t k[2] = {i / last, i % last};
                for (int v = 0; v < 2; v++) { // of the last variable and the one before
                    int var = f.nvars - 2 + v, p = var < 0 ? 0 : f.degree[var];
                    for (size_t j = 1; j <= k[v]; j++) w = w * (double)(p - (int)k[v] + (int)j) / (double)j;
                }
                double x = round(w * g.coef[(size_t)c * count + i]), y = round(w * f.coef[(size_t)c * count + i]);
                assert_true(x - y == round(w * d.coef[i]));
            }
        }
        kn_bezier_clear(ctx, &outer), kn_bezier_clear(ctx, &inner);
        kn_bezier_clear(ctx, &f), kn_bezier_clear(ctx, &g), kn_bezier_clear(ctx, &d);
    }
    test_ctx_end(ctx, &memory);
}

// Values by the long way, in long double: Bernstein polynomials and their derivatives.
static long double bernstein(int p, int i, long double x)
{
    long double c = 1;
    if (i < 0 || i > p) return 0;
    for (int j = 1; j <= i; j++) c = c * (p - i + j) / j;
    return c * powl(x, i) * powl(1 - x, p - i);
}

// Homogeneous component comp at x, or its derivative in variable var (-1: none), of one coefficient or of all.
static long double sum(const kn_bezier *b, int comp, const long double *x, int var, ptrdiff_t only)
{
    size_t n = kn_bezier_count(b);
    long double all = 0;
    for (size_t k = 0; k < n; k++) {
        long double f = only >= 0         ? (long double)((size_t)only == k)
                        : comp < b->ncomp ? (long double)b->coef[(size_t)comp * n + k]
                                          : 1.0L;
        size_t rest = k;
        for (int d = b->nvars - 1; d >= 0; d--) {
            int p = b->degree[d], i = (int)(rest % (size_t)(p + 1));
            rest /= (size_t)(p + 1);
            f *= d == var ? p * (bernstein(p - 1, i - 1, x[d]) - bernstein(p - 1, i, x[d])) : bernstein(p, i, x[d]);
        }
        all += f;
    }
    return all;
}

// Quotients of values against the formulas, in long double at a point: relative to 1 + |value|, data up to 4, weights
// from 1 to 4 and degrees up to 2 (doubled by quotients): errors stay below 2^14 roundings.
static void check(kn_ctx *ctx, const kn_bezier *d, const double *t, int c, long double want)
{
    double got[8];
    assert_int_equal(kn_bezier_eval(ctx, got, d, t), KN_OK);
    assert_true(fabsl(got[c] - want) <= 0x1p-39L * (1 + fabsl(want)));
}

static void rational_and_inner(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(42);
    for (int run = 0; run < test_scale(60); run++) {
        bool rational[2] = {run & 1, run & 2};
        kn_bezier outer, inner, d = {0};
        int n = test_int(&rng, 1, 2), index[3], vars = test_int(&rng, 1, 2);
        size_t place;
        make(ctx, &outer, &rng, n, 2 + rational[0], rational[0], 2);
        make(ctx, &inner, &rng, vars, n + rational[1], rational[1], 2);
        size_t count = kn_bezier_count(&inner);
        for (size_t i = 0; i < (size_t)n * count; i++) // inside the unit cell, away from zeros of outer's weight
            inner.coef[i] = test_uniform(&rng, 0, 1) * (rational[1] ? inner.coef[(size_t)n * count + i % count] : 1);
        double t[2] = {test_uniform(&rng, 0, 1), test_uniform(&rng, 0, 1)};
        long double at[2] = {t[0], t[1]}, x[3], w = sum(&inner, n, at, -1, -1);
        for (int k = 0; k < n; k++) x[k] = sum(&inner, k, at, -1, -1) / w;
        long double weight = sum(&outer, 2, x, -1, -1);
        if (!rational[0]) weight = 1;

        random_index(index, &place, &outer, &rng);
        assert_int_equal(kn_bezier_compose_outer_sensitivity(ctx, &d, &outer, &inner, index), KN_OK);
        check(ctx, &d, t, 0, sum(&outer, 0, x, -1, (ptrdiff_t)place) / weight);

        random_index(index, &place, &inner, &rng);
        for (int comp = 0; comp < inner.ncomp; comp++) {
            assert_int_equal(kn_bezier_compose_inner_sensitivity(ctx, &d, &outer, &inner, comp, index), KN_OK);
            assert_int_equal(kn_bezier_dim(&d), 2);
            for (int c = 0; c < 2; c++) {
                long double slope = 0, f = sum(&outer, c, x, -1, -1) / weight;
                for (int v = 0; v < n; v++) {
                    long double part = sum(&outer, c, x, v, -1);
                    if (rational[0]) part = (part - f * sum(&outer, 2, x, v, -1)) / weight;
                    slope += comp == n ? -x[v] * part : comp == v ? part : 0;
                }
                check(ctx, &d, t, c, slope * sum(&inner, 0, at, -1, (ptrdiff_t)place) / w);
            }
        }
        kn_bezier_clear(ctx, &outer), kn_bezier_clear(ctx, &inner), kn_bezier_clear(ctx, &d);
    }
    test_ctx_end(ctx, &memory);
}

// With an outer function of degree 1 in each variable f is linear in each component of inner: x y with x = (1, 3),
// y = (2, 5): d/dx_1 = B_1 y, and x of degree 2 by the chain rule: d/dx_0 of x^2 is 2 x B_0.
static void by_hand(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double xy[] = {0, 0, 0, 1}, line[] = {1, 3, 2, 5}, square[] = {0, 0, 1};
    kn_bezier outer = {.nvars = 2, .ncomp = 1, .degree = {1, 1}, .coef = xy}, out = {0};
    kn_bezier inner = {.nvars = 1, .ncomp = 2, .degree = {1}, .coef = line};
    int index = 1;
    assert_int_equal(kn_bezier_compose_inner_sensitivity(ctx, &out, &outer, &inner, 0, &index), KN_OK);
    assert_true(out.degree[0] == 2 && out.coef[0] == 0 && out.coef[1] == 1 && out.coef[2] == 5); // B_1 (2 .. 5)
    outer = (kn_bezier){.nvars = 1, .ncomp = 1, .degree = {2}, .coef = square};
    inner.ncomp = 1;
    index = 0;
    assert_int_equal(kn_bezier_compose_inner_sensitivity(ctx, &out, &outer, &inner, 0, &index), KN_OK);
    assert_true(out.degree[0] == 2 && out.coef[0] == 2 && out.coef[1] == 3 && out.coef[2] == 0); // B_0 (2 .. 6)
    kn_bezier_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double c[64] = {0};
    int low[2] = {-1, 0}, high[2] = {0, 2}, fine[2] = {0, 0};
    kn_bezier outer = {.nvars = 2, .ncomp = 1, .degree = {1, 1}, .coef = c}, out = {0}, empty = {0};
    kn_bezier inner = {.nvars = 1, .ncomp = 2, .degree = {1}, .coef = c}, one = inner, steep = inner;
    one.ncomp = 1;
    steep.degree[0] = 29;
    assert_int_equal(kn_bezier_compose_outer_sensitivity(ctx, &out, &outer, &inner, low), KN_EDOMAIN);
    assert_int_equal(kn_bezier_compose_outer_sensitivity(ctx, &out, &outer, &inner, high), KN_EDOMAIN);
    assert_int_equal(kn_bezier_compose_outer_sensitivity(ctx, &out, &outer, &one, fine), KN_EDOMAIN);
    assert_int_equal(kn_bezier_compose_outer_sensitivity(ctx, &out, &empty, &inner, fine), KN_EDOMAIN);
    assert_int_equal(kn_bezier_compose_outer_sensitivity(ctx, &out, &outer, &empty, fine), KN_EDOMAIN);
    assert_int_equal(kn_bezier_compose_outer_sensitivity(ctx, &out, &outer, &steep, fine), KN_ELIMIT);
    assert_int_equal(kn_bezier_compose_inner_sensitivity(ctx, &out, &outer, &inner, 0, low), KN_EDOMAIN);
    assert_int_equal(kn_bezier_compose_inner_sensitivity(ctx, &out, &outer, &inner, 2, fine), KN_EDOMAIN);
    assert_int_equal(kn_bezier_compose_inner_sensitivity(ctx, &out, &outer, &inner, -1, fine), KN_EDOMAIN);
    assert_int_equal(kn_bezier_compose_inner_sensitivity(ctx, &out, &outer, &one, 0, fine), KN_EDOMAIN);
    assert_int_equal(kn_bezier_compose_inner_sensitivity(ctx, &out, &empty, &inner, 0, fine), KN_EDOMAIN);
    assert_int_equal(kn_bezier_compose_inner_sensitivity(ctx, &out, &outer, &empty, 0, fine), KN_EDOMAIN);
    assert_int_equal(kn_bezier_compose_inner_sensitivity(ctx, &out, &outer, &steep, 0, fine), KN_ELIMIT);
    assert_null(out.coef);
    test_ctx_end(ctx, &memory);
}

static kn_status call(kn_ctx *ctx, void *user)
{
    double o[] = {1, 2, 3, 4, 5, 6, 7, 8, 1, 1, 2, 1}, i[] = {0, 1, 2, 1, 1, 2};
    int which = *(int *)user, index[2] = {1, 0};
    kn_bezier outer = {.nvars = 2, .ncomp = 3, .rational = true, .degree = {1, 1}, .coef = o}, out = {0};
    kn_bezier inner = {.nvars = 1, .ncomp = 3, .rational = true, .degree = {1}, .coef = i};
    kn_status status = which < 0 ? kn_bezier_compose_outer_sensitivity(ctx, &out, &outer, &inner, index)
                                 : kn_bezier_compose_inner_sensitivity(ctx, &out, &outer, &inner, which, index);
    assert_true((status == KN_OK) == (out.coef != NULL));
    kn_bezier_clear(ctx, &out);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    for (int which = -1; which < 3; which++) test_allocation_failures(call, &which);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(to_outer), cmocka_unit_test(rational_and_inner),
                                       cmocka_unit_test(by_hand), cmocka_unit_test(failures),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("compose/sensitivity", tests, NULL, NULL);
}
