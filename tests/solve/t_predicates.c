// SPDX-License-Identifier: Apache-2.0
// Signs, monotony, vector functions that vanish nowhere: known answers, adversarial inputs, failures.
#include "tests/support/support.h"

#include <knurl/solve.h>

#include <math.h>

static kn_sign sign_of(kn_ctx *ctx, const kn_bezier *f, int depth)
{
    kn_sign sign = KN_SIGN_MIXED;
    assert_int_equal(kn_solve_sign(ctx, &sign, f, NULL, NULL, depth), KN_OK);
    return sign;
}

// (a x - b y + d)^2 + e in exact Bernstein coefficients of degree 2, 2.
static void square_of_line(double c[9], double a, double b, double d, double e)
{
    const double x[3] = {0.0, 0.5, 1.0}, xx[3] = {0.0, 0.0, 1.0};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            c[3 * i + j] = a * a * xx[i] + b * b * xx[j] + d * d - 2.0 * a * b * x[i] * x[j] + 2.0 * a * d * x[i] -
                           2.0 * b * d * x[j] + e;
}

static void sign_known(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    int decided = 0, n = test_scale(2000);
    for (int k = 0; k < n; k++) {
        double c[9], a = test_int(&rng, 1, 5), b = test_int(&rng, 1, 5), d = test_int(&rng, -4, 4);
        double e = ldexp(test_int(&rng, -1, 1), -test_int(&rng, 1, 40));
        bool meets = d <= b && d >= -a; // 0 = a x - b y + d for some x, y in [0,1]
        square_of_line(c, a, b, d, e);
        kn_bezier f = {.nvars = 2, .ncomp = 1, .degree = {2, 2}, .coef = c};
        kn_sign sign = sign_of(ctx, &f, 8);
        if (e > 0.0) assert_true(sign == KN_SIGN_POSITIVE || sign == KN_SIGN_UNKNOWN);
        if (e == 0.0 && meets) assert_int_equal(sign, KN_SIGN_UNKNOWN);
        if (!meets && e >= 0.0) assert_int_equal(sign, KN_SIGN_POSITIVE);
        if (e < 0.0 && meets) assert_true(sign == KN_SIGN_MIXED || sign == KN_SIGN_UNKNOWN);
        decided += sign != KN_SIGN_UNKNOWN;
    }
    assert_true(decided > n / 2); // those with e = 0, and thin ones, cannot be decided with 256 boxes
    test_ctx_end(ctx, &memory);
}

static void sign_small(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double c[4] = {1.0, -0.5, 1.0, 0.0};
    kn_bezier f = {.nvars = 1, .ncomp = 1, .degree = {2}, .coef = c}; // 1/4 at 1/2
    assert_int_equal(sign_of(ctx, &f, 0), KN_SIGN_UNKNOWN);
    assert_int_equal(sign_of(ctx, &f, 2), KN_SIGN_POSITIVE);
    c[1] = -1.5; // -1/4 at 1/2
    assert_int_equal(sign_of(ctx, &f, 1), KN_SIGN_MIXED);
    double lo = 0.0, hi = 0.125, end = 1.0;
    kn_sign sign = KN_SIGN_UNKNOWN;
    assert_int_equal(kn_solve_sign(ctx, &sign, &f, &lo, &hi, 4), KN_OK);
    assert_int_equal(sign, KN_SIGN_POSITIVE);
    assert_int_equal(kn_solve_sign(ctx, &sign, &f, &end, &end, 0), KN_OK); // one point
    assert_int_equal(sign, KN_SIGN_POSITIVE);
    c[1] = -1.0; // (1 - 2x)^2
    assert_int_equal(sign_of(ctx, &f, 100), KN_SIGN_UNKNOWN);
    c[1] = NAN;
    assert_int_equal(sign_of(ctx, &f, 10), KN_SIGN_UNKNOWN);
    f.degree[0] = 0; // constants
    c[0] = -0x1p-1074;
    assert_int_equal(sign_of(ctx, &f, 10), KN_SIGN_NEGATIVE);
    c[0] = 0.0;
    assert_int_equal(sign_of(ctx, &f, 10), KN_SIGN_UNKNOWN);
    f.nvars = 0;
    c[0] = 3.0;
    assert_int_equal(sign_of(ctx, &f, 10), KN_SIGN_POSITIVE);
    kn_bezier r = {.nvars = 1, .ncomp = 2, .rational = true, .degree = {1}, .coef = c}; // (1 - x ..) over weights
    c[0] = -1.0, c[1] = -2.0, c[2] = 1.0, c[3] = 2.0;
    assert_int_equal(sign_of(ctx, &r, 0), KN_SIGN_NEGATIVE);
    test_ctx_end(ctx, &memory);
}

static void monotone_known(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double c[6] = {0.0, 1.0, 3.0, 1.0, 1.0, 1.0};
    kn_bezier f = {.nvars = 1, .ncomp = 1, .degree = {2}, .coef = c};
    kn_sign sign = KN_SIGN_UNKNOWN;
    assert_int_equal(kn_solve_monotone(ctx, &sign, &f, 0, NULL, NULL, 0), KN_OK);
    assert_int_equal(sign, KN_SIGN_POSITIVE);
    c[2] = 0.5;
    assert_int_equal(kn_solve_monotone(ctx, &sign, &f, 0, NULL, NULL, 3), KN_OK);
    assert_int_equal(sign, KN_SIGN_MIXED);
    // x / (1 + x): N = 0, 1 and w = 1, 2: grows; (1 + 2x) / (1 + 2x): a constant
    double q[4] = {0.0, 1.0, 1.0, 2.0};
    kn_bezier r = {.nvars = 1, .ncomp = 2, .rational = true, .degree = {1}, .coef = q};
    assert_int_equal(kn_solve_monotone(ctx, &sign, &r, 0, NULL, NULL, 3), KN_OK);
    assert_int_equal(sign, KN_SIGN_POSITIVE);
    q[0] = 1.0, q[1] = 3.0, q[2] = 1.0, q[3] = 3.0;
    assert_int_equal(kn_solve_monotone(ctx, &sign, &r, 0, NULL, NULL, 9), KN_OK);
    assert_int_equal(sign, KN_SIGN_UNKNOWN);
    q[1] = 2.0; // (1 + x) / (1 + 2x): falls, in a part too
    double lo = 0.25, hi = 0.5;
    assert_int_equal(kn_solve_monotone(ctx, &sign, &r, 0, &lo, &hi, 3), KN_OK);
    assert_int_equal(sign, KN_SIGN_NEGATIVE);
    test_ctx_end(ctx, &memory);
}

// Vectors: curves on the unit circle never vanish; x - y, x + y - 1 do; a corner that is 0.
static void nonzero_known(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_answer answer = KN_UNKNOWN;
    double circle[9] = {1.0, 0.0, -2.0, 0.0, 2.0, 0.0, 1.0, 0.0, 2.0}; // a half, weights 1, 0, 2
    kn_bezier arc = {.nvars = 1, .ncomp = 2, .degree = {2}, .coef = circle};
    assert_int_equal(kn_solve_nonzero(ctx, &answer, &arc, NULL, NULL, 6), KN_OK);
    assert_int_equal(answer, KN_YES);
    double lines[8] = {0.0, -1.0, 1.0, 0.0, -1.0, 0.0, 0.0, 1.0};
    kn_bezier cross = {.nvars = 2, .ncomp = 2, .degree = {1, 1}, .coef = lines};
    assert_int_equal(kn_solve_nonzero(ctx, &answer, &cross, NULL, NULL, 20), KN_OK);
    assert_int_equal(answer, KN_UNKNOWN);
    const double lo[2] = {0.6, 0.0}, hi[2] = {1.0, 1.0};
    assert_int_equal(kn_solve_nonzero(ctx, &answer, &cross, lo, hi, 6), KN_OK);
    assert_int_equal(answer, KN_YES);
    lines[4] = 0.0;
    assert_int_equal(kn_solve_nonzero(ctx, &answer, &cross, NULL, NULL, 6), KN_OK);
    assert_int_equal(answer, KN_NO);
    kn_bezier one = {.nvars = 1, .ncomp = 1, .degree = {1}, .coef = circle + 1};
    circle[1] = -1.0, circle[2] = 2.0;
    assert_int_equal(kn_solve_nonzero(ctx, &answer, &one, NULL, NULL, 0), KN_OK);
    assert_int_equal(answer, KN_NO);
    circle[1] = 1.0;
    assert_int_equal(kn_solve_nonzero(ctx, &answer, &one, NULL, NULL, 0), KN_OK);
    assert_int_equal(answer, KN_YES);
    // Three components, a hull that comes within 1e-9 of 0 and is seen from one side alone
    test_rng rng = test_random(3);
    for (int k = test_scale(200); k > 0; k--) {
        double c[12], v[3];
        for (int i = 0; i < 3; i++) v[i] = test_uniform(&rng, -1.0, 1.0);
        for (int i = 0; i < 4; i++) {
            double dot = 0.0, vv = 0.0, up = i == 0 ? 1e-9 : test_uniform(&rng, 1e-9, 1.0);
            for (int j = 0; j < 3; j++) c[4 * j + i] = test_uniform(&rng, -1.0, 1.0);
            for (int j = 0; j < 3; j++) dot += c[4 * j + i] * v[j], vv += v[j] * v[j];
            for (int j = 0; j < 3; j++) c[4 * j + i] += (up - dot / vv) * v[j]; // v.c = up v.v
        }
        kn_bezier f = {.nvars = 2, .ncomp = 3, .degree = {1, 1}, .coef = c};
        assert_int_equal(kn_solve_nonzero(ctx, &answer, &f, NULL, NULL, 30), KN_OK);
        assert_int_not_equal(answer, KN_NO);
    }
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double c[6] = {1.0, 1.0, 1.0, 1.0, 1.0, 0.0};
    kn_bezier f = {.nvars = 1, .ncomp = 1, .degree = {2}, .coef = c}, empty = {0}, vector = f, weights = f;
    vector.ncomp = 2;
    weights.ncomp = 2, weights.rational = true;
    kn_sign sign = KN_SIGN_MIXED;
    kn_answer answer = KN_NO;
    double lo = 0.5, hi = 0.25, far = 1.5, nan = NAN;
    assert_int_equal(kn_solve_sign(ctx, &sign, &empty, NULL, NULL, 1), KN_EDOMAIN);
    assert_int_equal(kn_solve_sign(ctx, &sign, &vector, NULL, NULL, 1), KN_EDOMAIN);
    assert_int_equal(kn_solve_sign(ctx, &sign, &weights, NULL, NULL, 1), KN_EDOMAIN); // a weight of 0
    assert_int_equal(kn_solve_sign(ctx, &sign, &f, &lo, &hi, 1), KN_EDOMAIN);
    assert_int_equal(kn_solve_sign(ctx, &sign, &f, &lo, &far, 1), KN_EDOMAIN);
    assert_int_equal(kn_solve_sign(ctx, &sign, &f, &nan, &hi, 1), KN_EDOMAIN);
    assert_int_equal(kn_solve_sign(ctx, &sign, &f, &lo, NULL, 1), KN_EDOMAIN);
    assert_int_equal(kn_solve_sign(ctx, &sign, &f, NULL, NULL, -1), KN_EDOMAIN);
    assert_int_equal(kn_solve_sign(ctx, &sign, &f, NULL, NULL, KN_SOLVE_MAX_DEPTH + 1), KN_EDOMAIN);
    assert_int_equal(kn_solve_monotone(ctx, &sign, &vector, 0, NULL, NULL, 1), KN_EDOMAIN);
    assert_int_equal(kn_solve_monotone(ctx, &sign, &f, 1, NULL, NULL, 1), KN_EDOMAIN);
    assert_int_equal(kn_solve_monotone(ctx, &sign, &empty, 0, NULL, NULL, 1), KN_EDOMAIN);
    assert_int_equal(kn_solve_nonzero(ctx, &answer, &weights, NULL, NULL, 1), KN_EDOMAIN);
    assert_int_equal(sign, KN_SIGN_MIXED);
    assert_int_equal(answer, KN_NO);
    f.degree[0] = KN_MAX_DEGREE + 1;
    assert_int_equal(kn_solve_sign(ctx, &sign, &f, NULL, NULL, 1), KN_EDOMAIN);
    double high[2 * (KN_MAX_DEGREE + 1)];
    for (int i = 0; i < 2 * (KN_MAX_DEGREE + 1); i++) high[i] = 1.0;
    kn_bezier tall = {.nvars = 1, .ncomp = 2, .rational = true, .degree = {KN_MAX_DEGREE}, .coef = high};
    assert_int_equal(kn_solve_monotone(ctx, &sign, &tall, 0, NULL, NULL, 1), KN_ELIMIT);
    test_ctx_end(ctx, &memory);
}

static kn_status all_three(kn_ctx *ctx, void *user)
{
    double c[4] = {1.0, -0.5, 1.0, 3.0}, lo = 0.0, hi = 0.75;
    kn_bezier f = {.nvars = 1, .ncomp = 1, .degree = {3}, .coef = c},
              g = {.nvars = 1, .ncomp = 2, .degree = {1}, .coef = c};
    kn_sign sign = KN_SIGN_UNKNOWN;
    kn_answer answer = KN_UNKNOWN;
    (void)user;
    kn_status status = kn_solve_sign(ctx, &sign, &f, &lo, &hi, 8);
    if (status == KN_OK) status = kn_solve_monotone(ctx, &sign, &f, 0, NULL, NULL, 8);
    if (status == KN_OK) status = kn_solve_nonzero(ctx, &answer, &g, NULL, NULL, 8);
    return status;
}

static void allocation(void **state)
{
    (void)state;
    test_allocation_failures(all_three, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(sign_known),     cmocka_unit_test(sign_small),
                                       cmocka_unit_test(monotone_known), cmocka_unit_test(nonzero_known),
                                       cmocka_unit_test(failures),       cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("solve/predicates", tests, NULL, NULL);
}
