// SPDX-License-Identifier: Apache-2.0
// Certified signs and monotony against exact root counts: no wrong definite answer, and few undecided ones.
#include "tests/oracle/roots.h"
#include "tests/support/support.h"

#include <knurl/solve.h>

#include <math.h>

enum { DEGREE = 7, CASES = 100000 };

typedef struct tally {
    int all, undecided;
} tally;

// Integers; random doubles; (x - r)^2 (..) with rounded coefficients: roots that only just are or are not there; a
// positive function moved down to a hair above or below its minimum; tiny and huge ones.
static void fill(double *c, int n, test_rng *rng, int kind)
{
    for (int i = 0; i <= n; i++) c[i] = kind == 0 ? test_int(rng, -4, 9) : test_uniform(rng, -1.0, 3.0);
    if (kind == 2 && n >= 2) {
        double r = test_uniform(rng, 0.1, 0.9), low[3] = {r * r, -r * (1.0 - r), (1.0 - r) * (1.0 - r)};
        for (int i = 0; i <= n; i++) { // elevated
            c[i] = 0.0;
            for (int k = 0; k <= 2; k++) {
                double w = k == 1 ? 2.0 * i * (n - i) : k == 0 ? (n - i) * (n - i - 1.0) : i * (i - 1.0);
                c[i] += w * low[k] / (n * (n - 1.0));
            }
        }
        double lift = ldexp((double)test_int(rng, -2, 2), -test_int(rng, 20, 60));
        for (int i = 0; i <= n; i++) c[i] += lift;
    }
    if (kind == 3)
        for (int i = 0; i <= n; i++) c[i] = ldexp(c[i], i % 2 ? -400 : -390);
    if (kind == 4)
        for (int i = 0; i <= n; i++) c[i] = ldexp(c[i], 900);
    if (test_int(rng, 0, 9) == 0) c[0] = 0.0;
}

static void judge(kn_sign sign, const fmpz_poly_t p, int n, tally *t)
{
    t->all++;
    t->undecided += sign == KN_SIGN_UNKNOWN;
    if (roots_zero(p)) {
        assert_int_equal(sign, KN_SIGN_UNKNOWN);
        t->undecided--; // no other answer is right
        return;
    }
    roots_facts f = roots_look(p, n);
    bool touches = f.inside > 0 || f.left > 0 || f.right > 0;
    if (sign == KN_SIGN_MIXED) assert_true(f.odd > 0);
    if (sign == KN_SIGN_POSITIVE) assert_true(!touches && f.start > 0);
    if (sign == KN_SIGN_NEGATIVE) assert_true(!touches && f.start < 0);
    if (f.odd == 0 && touches) t->undecided -= sign == KN_SIGN_UNKNOWN; // touches zero: likewise
}

static void signs(void **state)
{
    (void)state;
    kn_ctx *ctx = NULL;
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK);
    test_rng rng = test_random(101);
    tally t = {0};
    fmpz_poly_t p;
    fmpz_poly_init(p);
    for (int k = test_scale(CASES); k > 0; k--) {
        double coef[DEGREE + 1];
        int n = test_int(&rng, 0, DEGREE), a = test_int(&rng, 0, 31), b = test_int(&rng, a + 1, 32);
        kn_bezier f = {.nvars = 1, .ncomp = 1, .degree = {n}, .coef = coef};
        kn_sign sign = KN_SIGN_MIXED;
        fill(coef, n, &rng, k % 5);
        roots_of_array(p, coef, n);
        double lo = a / 32.0, hi = b / 32.0;
        bool whole = k % 3 == 0;
        assert_int_equal(kn_solve_sign(ctx, &sign, &f, whole ? NULL : &lo, whole ? NULL : &hi, 60), KN_OK);
        if (!whole) roots_restrict(p, n, (unsigned long)a, (unsigned long)b, 32);
        judge(sign, p, n, &t);
    }
    fmpz_poly_clear(p);
    kn_ctx_destroy(ctx);
    print_message("# signs: %d cases, %d undecided\n", t.all, t.undecided);
    assert_true(t.undecided < t.all / 20); // a fifth are made to be within rounding of touching zero: 3 % are left
}

// f' has the coefficients n (c_(i+1) - c_i), here exact integers.
static void monotony(void **state)
{
    (void)state;
    kn_ctx *ctx = NULL;
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK);
    test_rng rng = test_random(102);
    tally t = {0};
    fmpz_poly_t p;
    fmpz_poly_init(p);
    for (int k = test_scale(20000); k > 0; k--) {
        double coef[DEGREE + 1], diff[DEGREE + 1];
        int n = test_int(&rng, 1, DEGREE);
        kn_bezier f = {.nvars = 1, .ncomp = 1, .degree = {n}, .coef = coef};
        kn_sign sign = KN_SIGN_MIXED;
        for (int i = 0; i <= n; i++) coef[i] = test_int(&rng, 0, 9) + 2 * i;
        for (int i = 0; i < n; i++) diff[i] = coef[i + 1] - coef[i];
        roots_of_array(p, diff, n - 1);
        assert_int_equal(kn_solve_monotone(ctx, &sign, &f, 0, NULL, NULL, 60), KN_OK);
        judge(sign, p, n - 1, &t);
    }
    fmpz_poly_clear(p);
    kn_ctx_destroy(ctx);
    print_message("# monotony: %d cases, %d undecided\n", t.all, t.undecided);
    assert_true(t.undecided < t.all / 50);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(signs), cmocka_unit_test(monotony)};
    return cmocka_run_group_tests_name("oracle/solve_signs", tests, NULL, NULL);
}
