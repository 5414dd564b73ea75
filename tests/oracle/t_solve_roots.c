// SPDX-License-Identifier: Apache-2.0
// Roots of one variable against exact counts: no wrong certain root, none lost, and few undecided.
#include "tests/oracle/roots.h"
#include "tests/support/support.h"

#include <knurl/solve.h>

#include <math.h>

enum { DEGREE = 20, CASES = 100000 };

typedef struct tally {
    int cases, roots, possible, exact;
    double widest;
} tally;

static void solve(kn_ctx *ctx, const double *coef, int n, kn_root **roots, size_t *count)
{
    double knots[2 * (DEGREE + 1)];
    for (int i = 0; i < 2 * (n + 1); i++) knots[i] = i > n;
    kn_spline f = {.nvars = 1, .ncomp = 1, .degree = {n}, .count = {n + 1}, .knots = {knots}};
    double own[DEGREE + 1];
    for (int i = 0; i <= n; i++) own[i] = coef[i];
    f.coef = own;
    assert_int_equal(kn_solve_roots(ctx, roots, count, NULL, &f, NULL), KN_OK);
}

// Every certain box holds exactly one exact root; together the boxes hold all.
// thorough: box by box; else by their number, when all are certain.
static void judge(kn_ctx *ctx, const double *coef, int n, tally *t, bool thorough)
{
    kn_root *roots = NULL;
    size_t count = 0;
    fmpz_poly_t p;
    fmpz_poly_init(p);
    roots_of_array(p, coef, n);
    solve(ctx, coef, n, &roots, &count);
    t->cases++;
    if (!roots_zero(p)) {
        roots_facts f = roots_look(p, n);
        int total = f.inside + (f.left > 0) + (f.right > 0), held = 0;
        for (size_t i = 0; i < count; i++) {
            const kn_root *r = &roots[i];
            bool count_it = thorough || r->kind == KN_ROOT_POSSIBLE;
            int in = !count_it ? 1 : roots_between(coef, n, fmax(r->lo[0], 0.0), fmin(r->hi[0], 1.0));
            if (r->kind == KN_ROOT_UNIQUE) assert_int_equal(in, 1);
            if (r->least > 0) assert_true(in > 0);
            if (r->most >= 0) assert_true(in <= r->most);
            if (i > 0) assert_true(roots[i - 1].hi[0] <= r->lo[0]);
            if (r->kind == KN_ROOT_UNIQUE)
                t->widest = fmax(t->widest, (r->hi[0] - r->lo[0]) / fmax(r->at[0], 1e-300));
            held += in;
            t->roots += in;
            t->possible += r->kind == KN_ROOT_POSSIBLE;
            t->exact += r->lo[0] == r->hi[0];
        }
        bool exact = f.left == 0 || (count > 0 && roots[0].hi[0] == 0.0 && roots[0].least == f.left);
        if (f.left > 0) assert_true(roots[0].lo[0] == 0.0 && (exact || roots[0].kind == KN_ROOT_POSSIBLE));
        assert_int_equal(held, total);
    } else {
        assert_true(count == 1 && roots[0].kind == KN_ROOT_POSSIBLE);
    }
    kn_free(ctx, roots);
    fmpz_poly_clear(p);
}

static void report(const char *what, tally *t, double undecided)
{
    print_message("# %s: %d polynomials, %d roots, %d exact, %d undecided, widest certain box %.2g of the root\n",
                  what, t->cases, t->roots, t->exact, t->possible, t->widest);
    assert_true(t->possible <= undecided * t->cases);
}

static void random_cases(void **state)
{
    (void)state;
    kn_ctx *ctx = NULL;
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK);
    test_rng rng = test_random(201);
    tally t = {0};
    for (int k = test_scale(CASES); k > 0; k--) {
        double c[DEGREE + 1];
        int n = k % 200 == 0 ? test_int(&rng, 6, 12) : test_int(&rng, 0, 4), kind = k % 4;
        for (int i = 0; i <= n; i++) c[i] = kind < 2 ? test_int(&rng, -3, 3) : test_uniform(&rng, -1.0, 1.0);
        if (kind == 3)
            for (int i = 0; i <= n; i++) c[i] = ldexp(c[i], test_int(&rng, -20, 20));
        judge(ctx, c, n, &t, k % 16 == 0);
    }
    report("random", &t, 1e-3);
    kn_ctx_destroy(ctx);
}

// Coefficients of prod (x - r_i) in Bernstein form, rounded: each factor is one convolution.
static void product(double *c, const double *root, int n)
{
    c[0] = 1.0;
    for (int k = 0; k < n; k++) {
        double low = -root[k], high = 1.0 - root[k];
        for (int i = k + 1; i >= 0; i--)
            c[i] = ((i <= k ? c[i] * (k + 1 - i) * low : 0.0) + (i > 0 ? c[i - 1] * i * high : 0.0)) / (k + 1);
    }
}

// Clusters 2^-1 .. 2^-60 wide, double and triple roots, roots at 0 and 1 and next to them; Wilkinson's polynomial.
static void clusters(void **state)
{
    (void)state;
    kn_ctx *ctx = NULL;
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK);
    test_rng rng = test_random(202);
    tally t = {0}, w = {0};
    for (int k = test_scale(1500); k > 0; k--) {
        double root[6], c[7];
        int n = test_int(&rng, 2, 6);
        root[0] = test_int(&rng, 0, 2) == 0 ? test_int(&rng, 0, 4) / 4.0 : test_uniform(&rng, 0.0, 1.0);
        for (int i = 1; i < n; i++)
            root[i] = i < 3 ? root[0] + test_int(&rng, -2, 2) * ldexp(1.0, -test_int(&rng, 1, 60))
                            : test_uniform(&rng, -0.5, 1.5);
        product(c, root, n);
        judge(ctx, c, n, &t, true);
    }
    report("clusters", &t, 0.2);
    double root[DEGREE], c[DEGREE + 1];
    for (int n = 2; n <= DEGREE; n++)
        for (int shift = 0; shift < 3; shift++) { // i / (n + 1), and with the first or the last on the boundary
            for (int i = 0; i < n; i++)
                root[i] = shift == 0 ? (i + 1.0) / (n + 1.0) : shift == 1 ? (double)i / n : (i + 1.0) / n;
            product(c, root, n);
            judge(ctx, c, n, &w, true);
        }
    report("Wilkinson", &w, 0.0);
    kn_ctx_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(random_cases), cmocka_unit_test(clusters)};
    return cmocka_run_group_tests_name("oracle/solve_roots", tests, NULL, NULL);
}
