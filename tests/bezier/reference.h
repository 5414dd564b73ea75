// SPDX-License-Identifier: Apache-2.0
// An independent way to the values of pieces, for tests: the definition, term by term, in integers and long double.
//
// With integer coefficients and parameters that are small multiples of 1/4 every number below is exact, and so is
// everything that the library computes without dividing: tests compare with ==.
#ifndef TESTS_BEZIER_REFERENCE_H
#define TESTS_BEZIER_REFERENCE_H

#include "tests/support/support.h"

// C(n, k) by Pascal's rule, row by row.
static inline long long ref_binomial(int n, int k)
{
    long long row[64] = {1};
    for (int m = 1; m <= n; m++)
        for (int j = m; j > 0; j--) row[j] += row[j - 1];
    return k < 0 || k > n ? 0 : row[k];
}

// The multi-index of coefficient `flat`, the last variable fastest.
static inline void ref_split(int *index, size_t flat, int nvars, const int *degree)
{
    for (int d = nvars - 1; d >= 0; d--) {
        index[d] = (int)(flat % ((size_t)degree[d] + 1));
        flat /= (size_t)degree[d] + 1;
    }
}

static inline size_t ref_flat(const int *index, int nvars, const int *degree)
{
    size_t flat = 0;
    for (int d = 0; d < nvars; d++) flat = flat * ((size_t)degree[d] + 1) + (size_t)index[d];
    return flat;
}

// Derivative number a of the Bernstein polynomial, from powers:
// B^n_i(t) = sum_j (-1)^(j-i) C(n,j) C(j,i) t^j.
static inline long double ref_basis(int n, int i, int a, double t)
{
    long double sum = 0.0L;
    for (int j = i > a ? i : a; j <= n; j++) {
        long double term = (long double)(ref_binomial(n, j) * ref_binomial(j, i)) * ((j - i) % 2 ? -1.0L : 1.0L);
        for (int m = 0; m < a; m++) term *= (long double)(j - m);
        for (int m = 0; m < j - a; m++) term *= (long double)t;
        sum += term;
    }
    return sum;
}

// The partial derivative a[] of every homogeneous component.
static inline void ref_partial(long double *out, const kn_bezier *b, const double *at, const int *a)
{
    size_t count = kn_bezier_count(b);
    int index[KN_MAX_VARS];
    for (int c = 0; c < b->ncomp; c++) out[c] = 0.0L;
    for (size_t i = 0; i < count; i++) {
        long double w = 1.0L;
        ref_split(index, i, b->nvars, b->degree);
        for (int d = 0; d < b->nvars; d++) w *= ref_basis(b->degree[d], index[d], a[d], at[d]);
        for (int c = 0; c < b->ncomp; c++) out[c] += w * (long double)b->coef[(size_t)c * count + i];
    }
}

static inline void ref_homogeneous(long double *out, const kn_bezier *b, const double *at)
{
    const int none[KN_MAX_VARS] = {0};
    ref_partial(out, b, at, none);
}

// The value: quotients by the weight are rounded once, to double.
static inline void ref_value(double *out, const kn_bezier *b, const double *at)
{
    long double h[KN_MAX_COMPS];
    ref_homogeneous(h, b, at);
    int dim = kn_bezier_dim(b);
    for (int c = 0; c < dim; c++) out[c] = b->rational ? (double)h[c] / (double)h[dim] : (double)h[c];
}

// Adds sign * (component ca of a) * (component cb of b) to num, in integers, each coefficient times the binomials of
// the product's degrees. Component -1 is the constant 1.
static inline void ref_convolve(long long *num, const int *degree, const kn_bezier *a, int ca, const kn_bezier *b,
                                int cb, int sign)
{
    size_t na = kn_bezier_count(a), nb = kn_bezier_count(b);
    int i[KN_MAX_VARS], j[KN_MAX_VARS], k[KN_MAX_VARS];
    for (size_t fi = 0; fi < na; fi++)
        for (size_t fj = 0; fj < nb; fj++) {
            long long term = sign;
            ref_split(i, fi, a->nvars, a->degree);
            ref_split(j, fj, b->nvars, b->degree);
            for (int d = 0; d < a->nvars; d++) {
                k[d] = i[d] + j[d];
                term *= ref_binomial(a->degree[d], i[d]) * ref_binomial(b->degree[d], j[d]);
            }
            if (ca >= 0) term *= (long long)a->coef[(size_t)ca * na + fi];
            if (cb >= 0) term *= (long long)b->coef[(size_t)cb * nb + fj];
            num[ref_flat(k, a->nvars, degree)] += term;
        }
}

// Divides by the binomials: exact integers on both sides, so one rounding.
static inline double ref_quotient(long long num, size_t flat, int nvars, const int *degree)
{
    int index[KN_MAX_VARS];
    long long den = 1;
    ref_split(index, flat, nvars, degree);
    for (int d = 0; d < nvars; d++) den *= ref_binomial(degree[d], index[d]);
    return (double)num / (double)den;
}

// A number that every C(degree[d], k) divides: coefficients that are multiples of it stay integers when the degree
// is raised to degree[].
static inline double ref_multiple(int nvars, const int *degree)
{
    long long all = 1;
    for (int d = 0; d < nvars; d++) {
        long long lcm = 1;
        for (int k = 0; k <= degree[d]; k++) {
            long long c = ref_binomial(degree[d], k), x = lcm, y = c;
            while (y) {
                long long r = x % y;
                x = y;
                y = r;
            }
            lcm = lcm / x * c;
        }
        all *= lcm;
    }
    return (double)all;
}

static inline void ref_random_degrees(test_rng *rng, int *degree, int nvars)
{
    static const int most[5] = {0, 5, 4, 3, 2};
    for (int d = 0; d < nvars; d++) degree[d] = test_int(rng, 0, most[nvars]);
}

// Multiples of 1/4 in [-1/2, 3/2]: on both sides of the unit interval and in it.
static inline void ref_random_point(test_rng *rng, double *at, int nvars)
{
    for (int d = 0; d < nvars; d++) at[d] = test_int(rng, -2, 6) / 4.0;
}

static inline void ref_assert_same(const kn_bezier *a, const kn_bezier *b)
{
    assert_int_equal(a->nvars, b->nvars);
    assert_int_equal(a->ncomp, b->ncomp);
    assert_int_equal(a->rational, b->rational);
    for (int d = 0; d < a->nvars; d++) assert_int_equal(a->degree[d], b->degree[d]);
    size_t n = (size_t)a->ncomp * kn_bezier_count(a);
    for (size_t i = 0; i < n; i++)
        if (a->coef[i] != b->coef[i]) fail_msg("coefficient %zu: %.17g and %.17g", i, a->coef[i], b->coef[i]);
}

// What out holds before a call that may fail, and the assertion that a failure left it alone.
static inline void ref_make_sentinel(kn_ctx *ctx, kn_bezier *out)
{
    const int degree[1] = {1};
    assert_int_equal(kn_bezier_init(ctx, out, 1, 1, false, degree), KN_OK);
    out->coef[0] = 17.0;
    out->coef[1] = -4.0;
}

static inline bool ref_is_sentinel(const kn_bezier *out)
{
    return out->nvars == 1 && out->ncomp == 1 && !out->rational && out->degree[0] == 1 && out->coef &&
           out->coef[0] == 17.0 && out->coef[1] == -4.0;
}

#endif
