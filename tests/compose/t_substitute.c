// SPDX-License-Identifier: Apache-2.0
// kn_bezier_substitute, kn_spline_substitute: one variable replaced by a function of it. Coefficients against exact
// arithmetic: tests/oracle/t_compose.c.
#include "tests/support/support.h"

#include <knurl/compose.h>
#include <math.h>
#include <string.h>

// x = t^2 in the second variable of a bilinear function, by hand; in place; x = t leaves everything as it is.
static void by_hand(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double square[] = {0, 0, 1}, same[] = {0, 1}, half[] = {2, 1, 3, 2}; // (2 + t)/(3 - t)
    kn_bezier g = {.nvars = 1, .ncomp = 1, .degree = {2}, .coef = square}, a = {0}, out = {0};
    const int degree[2] = {1, 1};
    assert_int_equal(kn_bezier_init(ctx, &a, 2, 1, false, degree), KN_OK);
    const double coef[4] = {1, 2, 4, 8};
    memcpy(a.coef, coef, sizeof coef);
    assert_int_equal(kn_bezier_substitute(ctx, &out, &a, 1, &g), KN_OK);
    assert_true(out.degree[0] == 1 && out.degree[1] == 2 && !out.rational);
    const double want[6] = {1, 1, 2, 4, 4, 8};
    assert_memory_equal(out.coef, want, sizeof want);
    g.degree[0] = 1, g.coef = same;
    assert_int_equal(kn_bezier_substitute(ctx, &out, &out, 1, &g), KN_OK);
    assert_memory_equal(out.coef, want, sizeof want);
    // x + 1 with x = (2 + t)/(3 - t), numerators 2, 3 and weights 3, 2
    half[1] = 3;
    half[2] = 3, half[3] = 2;
    double line[] = {1, 2};
    kn_bezier b = {.nvars = 1, .ncomp = 1, .degree = {1}, .coef = line};
    g = (kn_bezier){.nvars = 1, .ncomp = 2, .rational = true, .degree = {1}, .coef = half};
    assert_int_equal(kn_bezier_substitute(ctx, &out, &b, 0, &g), KN_OK);
    assert_true(out.rational && out.ncomp == 2 && out.degree[0] == 1);
    assert_true(out.coef[0] == 5 && out.coef[1] == 5 && out.coef[2] == 3 && out.coef[3] == 2);
    kn_bezier_clear(ctx, &a), kn_bezier_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

static void pieces_fail(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double c[64] = {0};
    kn_bezier a = {.nvars = 2, .ncomp = 1, .degree = {8, 2}, .coef = c}, out = {0}, empty = {0};
    kn_bezier g = {.nvars = 1, .ncomp = 1, .degree = {8}, .coef = c};
    kn_bezier pair = {.nvars = 1, .ncomp = 2, .degree = {1}, .coef = c};
    assert_int_equal(kn_bezier_substitute(ctx, &out, &a, 2, &g), KN_EDOMAIN);
    assert_int_equal(kn_bezier_substitute(ctx, &out, &a, -1, &g), KN_EDOMAIN);
    assert_int_equal(kn_bezier_substitute(ctx, &out, &a, 0, &pair), KN_EDOMAIN);
    assert_int_equal(kn_bezier_substitute(ctx, &out, &a, 0, &a), KN_EDOMAIN);
    assert_int_equal(kn_bezier_substitute(ctx, &out, &empty, 0, &g), KN_EDOMAIN);
    assert_int_equal(kn_bezier_substitute(ctx, &out, &a, 0, &empty), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_bezier_substitute(ctx, &out, &a, 0, &g), KN_ELIMIT);
    assert_non_null(strstr(kn_ctx_message(ctx), "degree 64"));
    assert_null(out.coef);
    test_ctx_end(ctx, &memory);
}

static void make_spline(kn_ctx *ctx, kn_spline *out, test_rng *rng, int nvars, int ncomp, bool rational, double lo,
                        double hi)
{
    int degree[3], count[3];
    for (int d = 0; d < nvars; d++) degree[d] = test_int(rng, 1, 3), count[d] = degree[d] + 1 + test_int(rng, 0, 3);
    test_random_spline(ctx, out, rng, nvars, ncomp, rational, degree, count, 5);
    size_t n = kn_spline_count(out);
    for (size_t i = 0; i < n; i++)
        for (int c = 0; c < kn_spline_dim(out); c++)
            out->coef[(size_t)c * n + i] = (rational ? out->coef[(size_t)(ncomp - 1) * n + i] : 1.0) *
                                           test_uniform(rng, lo, hi);
}

// Values against those of the operands. Every break is made C0 in a, so that J = 1 (docs/numerics.md, kn_spline): less
// than 400 roundings in a coefficient, and as many times the slope, below 2^5, in the parameter.
static void splines_match_evaluation(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(31);
    for (int run = 0; run < test_scale(24); run++) {
        int nvars = test_int(&rng, 1, 3), var = test_int(&rng, 0, nvars - 1);
        bool rational[2] = {run & 1, run & 2};
        kn_spline a = {0}, g = {0}, out = {0};
        make_spline(ctx, &a, &rng, nvars, 2 + rational[0], rational[0], -1, 1);
        double lo, hi, extra[16];
        kn_spline_domain(&a, var, &lo, &hi);
        make_spline(ctx, &g, &rng, 1, 1 + rational[1], rational[1], lo, hi);
        for (int pass = 0; pass < 2; pass++) { // knots of both to multiplicity = degree
            kn_spline *s = pass ? &g : &a;
            int v = pass ? 0 : var, n = 0;
            for (int i = s->degree[v] + 1; i < s->count[v]; i++) {
                int have = 0;
                for (int k = 0; k < s->count[v] + s->degree[v] + 1; k++) have += s->knots[v][k] == s->knots[v][i];
                if (s->knots[v][i - 1] < s->knots[v][i])
                    for (; have < s->degree[v]; have++) extra[n++] = s->knots[v][i];
            }
            assert_int_equal(kn_spline_insert_knots(ctx, s, s, v, extra, n), KN_OK);
        }
        assert_int_equal(kn_spline_substitute(ctx, &out, &a, var, &g), KN_OK);
        if (!out.rational) assert_int_equal(kn_spline_check(ctx, &out), KN_OK); // weights: positive values only
        assert_int_equal(out.rational, rational[0] || rational[1]);
        for (int d = 0; d < nvars; d++)
            if (d != var) assert_memory_equal(out.knots[d], a.knots[d], (size_t)(a.count[d] + a.degree[d] + 1) * 8);
        for (int k = 0; k < 20; k++) {
            double t[3], x[3], want[2], got[2], from, to;
            for (int d = 0; d < nvars; d++) {
                kn_spline_domain(&out, d, &from, &to);
                t[d] = x[d] = test_uniform(&rng, from, to);
            }
            assert_int_equal(kn_spline_eval(ctx, &x[var], &g, &t[var]), KN_OK);
            assert_int_equal(kn_spline_eval(ctx, want, &a, x), KN_OK);
            assert_int_equal(kn_spline_eval(ctx, got, &out, t), KN_OK);
            assert_true(test_max_difference(want, got, 2) <= 400 * 32 * 0x1p-53);
        }
        kn_spline_clear(ctx, &a), kn_spline_clear(ctx, &g), kn_spline_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

// A C1 quadratic on 0, 1, 2, 3 in the first variable with x = 3 - 2t over [0, 3/2]: the coefficients from behind, on
// the knots 0, 1/2, 1, 3/2, and the second variable bit for bit.
static void spline_by_hand(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 0, 1, 2, 3, 3, 3}, other[] = {0, 0, 5, 5}, line[] = {0, 0, 1.5, 1.5};
    const double *two[2] = {knots, other}, *one[1] = {line}, ends[] = {3, 0};
    const int degree[2] = {2, 1}, count[2] = {5, 2};
    double coef[10];
    for (int i = 0; i < 10; i++) coef[i] = i * i - 3 * i;
    kn_spline a = {0}, g = {0};
    assert_int_equal(kn_spline_init(ctx, &a, 2, 1, false, degree, count, two, coef), KN_OK);
    assert_int_equal(kn_spline_init(ctx, &g, 1, 1, false, degree + 1, count + 1, one, ends), KN_OK);
    assert_int_equal(kn_spline_substitute(ctx, &a, &a, 0, &g), KN_OK);
    assert_true(a.count[0] == 5 && a.count[1] == 2);
    for (int i = 0; i < 8; i++) assert_true(a.knots[0][i] == knots[i] / 2);
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < 2; j++) assert_true(a.coef[2 * i + j] == coef[2 * (4 - i) + j]);
    kn_spline_clear(ctx, &a), kn_spline_clear(ctx, &g);
    test_ctx_end(ctx, &memory);
}

// Constants: a jump from 1/2 to 5/2 in degree 0 picks two values of a, at degree 0.
static void steps(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 1, 2, 3, 3}, breaks[] = {0, 1, 2}, coef[] = {1, 4, -2, 8}, x[] = {0.5, 2.5};
    const double *list[2] = {knots, breaks};
    const int degree[2] = {1, 0}, count[2] = {4, 2};
    kn_spline a = {0}, g = {0}, out = {0};
    assert_int_equal(kn_spline_init(ctx, &a, 1, 1, false, degree, count, list, coef), KN_OK);
    assert_int_equal(kn_spline_init(ctx, &g, 1, 1, false, degree + 1, count + 1, list + 1, x), KN_OK);
    assert_int_equal(kn_spline_substitute(ctx, &out, &a, 0, &g), KN_OK);
    assert_true(out.degree[0] == 0 && out.count[0] == 2 && out.knots[0][1] == 1);
    assert_true(out.coef[0] == 2.5 && out.coef[1] == 3);
    assert_int_equal(kn_spline_compose(ctx, &out, &a, &g), KN_OK);
    assert_true(out.count[0] == 2 && out.coef[0] == 2.5 && out.coef[1] == 3);
    kn_spline_clear(ctx, &a), kn_spline_clear(ctx, &g), kn_spline_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

static void splines_fail(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(32);
    kn_spline a = {0}, g = {0}, pair = {0}, out = {0}, empty = {0};
    make_spline(ctx, &a, &rng, 2, 1, false, 0, 1);
    make_spline(ctx, &pair, &rng, 1, 2, false, 0, 1);
    kn_bezier high = {0};
    const int degree = 56;
    assert_int_equal(kn_bezier_init(ctx, &high, 1, 1, false, &degree), KN_OK);
    assert_int_equal(kn_spline_of_bezier(ctx, &g, &high), KN_OK);
    assert_int_equal(kn_spline_substitute(ctx, &out, &a, 2, &g), KN_EDOMAIN);
    assert_int_equal(kn_spline_substitute(ctx, &out, &a, 0, &pair), KN_EDOMAIN);
    assert_int_equal(kn_spline_substitute(ctx, &out, &a, 0, &a), KN_EDOMAIN);
    assert_int_equal(kn_spline_substitute(ctx, &out, &empty, 0, &g), KN_EDOMAIN);
    assert_int_equal(kn_spline_substitute(ctx, &out, &a, 0, &empty), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_spline_substitute(ctx, &out, &g, 0, &g), KN_ELIMIT);
    assert_non_null(strstr(kn_ctx_message(ctx), "degree 3136"));
    assert_int_equal(out.nvars, 0);
    kn_bezier_clear(ctx, &high);
    kn_spline_clear(ctx, &a), kn_spline_clear(ctx, &g), kn_spline_clear(ctx, &pair);
    test_ctx_end(ctx, &memory);
}

static kn_status piece_call(kn_ctx *ctx, void *user)
{
    double c[] = {1, 2, 3, 4, 5, 6}, x[] = {0, 1, 1, 2};
    kn_bezier a = {.nvars = 2, .ncomp = 1, .degree = {1, 2}, .coef = c}, out = {0};
    kn_bezier g = {.nvars = 1, .ncomp = 2, .rational = true, .degree = {1}, .coef = x};
    (void)user;
    kn_status status = kn_bezier_substitute(ctx, &out, &a, 1, &g);
    assert_true((status == KN_OK) == (out.coef != NULL));
    kn_bezier_clear(ctx, &out);
    return status;
}

static kn_status spline_call(kn_ctx *ctx, void *user)
{
    const double knots[] = {0, 0, 1, 2, 2}, coef[] = {1, 2, 5}, line[] = {0, 0, 1, 1}, x[] = {0, 2, 1, 1};
    const double *list[2] = {knots, line};
    const int one = 1, count[2] = {3, 2};
    kn_spline a = {0}, g = {0}, out = {0};
    (void)user;
    kn_status status = kn_spline_init(ctx, &a, 1, 1, false, &one, count, list, coef);
    if (status == KN_OK) status = kn_spline_init(ctx, &g, 1, 2, true, &one, count + 1, list + 1, x);
    if (status == KN_OK) status = kn_spline_substitute(ctx, &out, &a, 0, &g);
    assert_true((status == KN_OK) == (out.coef != NULL));
    kn_spline_clear(ctx, &a), kn_spline_clear(ctx, &g), kn_spline_clear(ctx, &out);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_allocation_failures(piece_call, NULL);
    test_allocation_failures(spline_call, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(by_hand),
                                       cmocka_unit_test(pieces_fail),
                                       cmocka_unit_test(spline_by_hand),
                                       cmocka_unit_test(splines_match_evaluation),
                                       cmocka_unit_test(steps),
                                       cmocka_unit_test(splines_fail),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("compose/substitute", tests, NULL, NULL);
}
