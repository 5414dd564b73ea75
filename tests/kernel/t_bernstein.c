// SPDX-License-Identifier: Apache-2.0
// Binomials and the Bernstein kernels on raw arrays.
#include "kernel/bernstein.h"
#include "kernel/binomial.h"
#include "tests/support/support.h"

#include <float.h>
#include <math.h>
#include <string.h>

// All of them up to the highest degree, against Pascal's rule in integers.
static void binomials(void **state)
{
    (void)state;
    long long row[KN_MAX_DEGREE + 2] = {1};
    for (int n = 0; n <= KN_MAX_DEGREE; n++) {
        double all[KN_MAX_DEGREE + 1];
        kn_binomial_row(all, n);
        for (int k = 0; k <= n; k++) {
            assert_true(row[k] < 1LL << 53);
            assert_true(kn_binomial(n, k) == (double)row[k]);
            assert_true(all[k] == (double)row[k]);
        }
        assert_true(kn_binomial(n, -1) == 0.0 && kn_binomial(n, n + 1) == 0.0);
        for (int k = n + 1; k > 0; k--) row[k] += row[k - 1];
    }
}

// Each value carries a relative error of gamma(3n) at most: three roundings a step, and no subtraction in [0,1].
static void basis_keeps_its_bound(void **state)
{
    (void)state;
    test_rng rng = test_random(1);
    for (int n = 0; n <= KN_MAX_DEGREE; n++) {
        double basis[KN_MAX_DEGREE + 1], t = test_uniform(&rng, 0.0, 1.0), u = DBL_EPSILON / 2;
        double bound = 3 * n * u / (1 - 3 * n * u);
        kn_bernstein_basis(basis, n, t);
        for (int i = 0; i <= n; i++) {
            long double exact = (long double)kn_binomial(n, i) * powl(t, i) * powl(1.0L - t, n - i);
            // powl may be wrong by some 2^-62 relative
            assert_true(fabsl(basis[i] - exact) <= (bound + 0x1p-60L) * exact);
        }
        kn_bernstein_basis(basis, n, 0.0);
        for (int i = 0; i <= n; i++) assert_true(basis[i] == (i == 0));
        kn_bernstein_basis(basis, n, 1.0);
        for (int i = 0; i <= n; i++) assert_true(basis[i] == (i == n));
    }
}

static void fill(double *a, size_t n, test_rng *rng)
{
    for (size_t i = 0; i < n; i++) a[i] = test_int(rng, -9, 9);
}

// (outer, n + 1, inner) against one line at a time; and in place where the header allows it.
static void axes(void **state)
{
    (void)state;
    enum { OUTER = 3, N = 4, INNER = 5, SIZE = OUTER * (N + 1) * INNER };
    test_rng rng = test_random(2);
    double a[SIZE], b[SIZE], left[SIZE], right[SIZE], basis[N + 1], value[OUTER * INNER];
    double raised[OUTER * (N + 3) * INNER], diff[OUTER * N * INNER];
    fill(a, SIZE, &rng);
    for (int i = 0; i < SIZE; i++) a[i] *= 60.0; // so that raising the degree to 6 stays in integers
    kn_bernstein_basis(basis, N, 0.25);
    kn_bernstein_contract(value, a, OUTER, N + 1, INNER, basis);
    kn_bernstein_split(left, right, a, OUTER, N, INNER, 0.25);
    kn_bernstein_elevate(raised, a, OUTER, N, N + 2, INNER);
    kn_bernstein_differentiate(diff, a, OUTER, N, INNER);
    for (int o = 0; o < OUTER; o++)
        for (int j = 0; j < INNER; j++) {
            double line[N + 1], sum = 0.0, l[N + 1], r[N + 1], e[N + 3], d[N];
            for (int i = 0; i <= N; i++) line[i] = a[(o * (N + 1) + i) * INNER + j];
            for (int i = 0; i <= N; i++) sum += basis[i] * line[i];
            assert_true(value[o * INNER + j] == sum);
            kn_bernstein_split(l, r, line, 1, N, 1, 0.25);
            kn_bernstein_elevate(e, line, 1, N, N + 2, 1);
            kn_bernstein_differentiate(d, line, 1, N, 1);
            assert_true(l[N] == sum && r[0] == sum && l[0] == line[0] && r[N] == line[N]);
            for (int i = 0; i <= N; i++) {
                assert_true(left[(o * (N + 1) + i) * INNER + j] == l[i]);
                assert_true(right[(o * (N + 1) + i) * INNER + j] == r[i]);
            }
            // two steps of c_k = (k b_(k-1) + (m-k) b_k) / m
            double one[N + 2];
            for (int k = 0; k <= N + 1; k++)
                one[k] = ((k ? k * line[k - 1] : 0.0) + (k <= N ? (N + 1 - k) * line[k] : 0.0)) / (N + 1);
            for (int k = 0; k <= N + 2; k++) {
                double two = ((k ? k * one[k - 1] : 0.0) + (k <= N + 1 ? (N + 2 - k) * one[k] : 0.0)) / (N + 2);
                assert_true(e[k] == two);
                assert_true(raised[(o * (N + 3) + k) * INNER + j] == two);
            }
            for (int k = 0; k < N; k++) {
                assert_true(d[k] == N * (line[k + 1] - line[k]));
                assert_true(diff[(o * N + k) * INNER + j] == d[k]);
            }
        }
    memcpy(b, a, sizeof a);
    kn_bernstein_split(b, right, b, OUTER, N, INNER, 0.25); // left is in
    assert_memory_equal(b, left, sizeof b);
    memcpy(b, a, sizeof a);
    kn_bernstein_split(left, b, b, OUTER, N, INNER, 0.25); // right is in
    assert_memory_equal(b, right, sizeof b);
    memcpy(b, a, sizeof a);
    kn_bernstein_differentiate(b, b, OUTER, N, INNER);
    assert_memory_equal(b, diff, sizeof diff);
    memcpy(b, a, sizeof a);
    kn_bernstein_contract(b, b, OUTER, N + 1, INNER, basis);
    assert_memory_equal(b, value, sizeof value);
    kn_bernstein_differentiate(b, a, OUTER, 0, INNER); // degree 0: zero, of degree 0
    for (int i = 0; i < OUTER * INNER; i++) assert_true(b[i] == 0.0);
}

// Rows of the restriction sum to 1, are non-negative within [0,1], and equal the two halves of de Casteljau.
static void restrictions(void **state)
{
    (void)state;
    enum { N = 6 };
    test_rng rng = test_random(3);
    double matrix[(N + 1) * (N + 1)], line[N + 1], got[N + 1], left[N + 1], right[N + 1];
    fill(line, N + 1, &rng);
    for (int quarter = -2; quarter <= 6; quarter++) {
        double t = quarter / 4.0;
        kn_bernstein_split(left, right, line, 1, N, 1, t);
        kn_bernstein_restriction(matrix, N, 0.0, t);
        kn_bernstein_transform(got, line, 1, N + 1, N + 1, 1, matrix);
        for (int i = 0; i <= N; i++) assert_true(got[i] == left[i]);
        kn_bernstein_restriction(matrix, N, t, 1.0);
        kn_bernstein_transform(got, line, 1, N + 1, N + 1, 1, matrix);
        for (int i = 0; i <= N; i++) assert_true(got[i] == right[i]);
        kn_bernstein_restriction(matrix, N, t, 0.5);
        for (int i = 0; i <= N; i++) {
            double sum = 0.0;
            for (int j = 0; j <= N; j++) {
                sum += matrix[i * (N + 1) + j];
                if (t >= 0.0 && t <= 1.0) assert_true(matrix[i * (N + 1) + j] >= 0.0);
            }
            assert_true(sum == 1.0);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(binomials), cmocka_unit_test(basis_keeps_its_bound),
                                       cmocka_unit_test(axes), cmocka_unit_test(restrictions)};
    return cmocka_run_group_tests_name("kernel/bernstein", tests, NULL, NULL);
}
