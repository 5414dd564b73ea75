// SPDX-License-Identifier: Apache-2.0
// Bernstein form along one axis, and products in any number of variables.
#include "kernel/bernstein.h"
#include "kernel/binomial.h"

#include <assert.h>
#include <knurl/base.h>
#include <string.h>

// The basis functions of degree k at t, in place of those of degree k - 1:
// B^k_i = (1-t) B^(k-1)_i + t B^(k-1)_(i-1), only sums of non-negative numbers for t in [0,1].
static void raise_basis(double *basis, int k, double t)
{
    double s = 1.0 - t;
    basis[k] = t * basis[k - 1];
    for (int i = k - 1; i > 0; i--) basis[i] = s * basis[i] + t * basis[i - 1];
    basis[0] *= s;
}

void kn_bernstein_basis(double *basis, int n, double t)
{
    basis[0] = 1.0;
    for (int k = 1; k <= n; k++) raise_basis(basis, k, t);
}

void kn_bernstein_contract(double *out, const double *in, size_t outer, int m, size_t inner, const double *basis)
{
    size_t stride = (size_t)m * inner;
    for (size_t o = 0; o < outer; o++, in += stride, out += inner)
        for (size_t j = 0; j < inner; j++) {
            double sum = basis[0] * in[j];
            for (int i = 1; i < m; i++) sum += basis[i] * in[(size_t)i * inner + j];
            out[j] = sum;
        }
}

// After step k the first k entries hold left's coefficients and the last k right's: both live in one triangle.
void kn_bernstein_split(double *left, double *right, const double *in, size_t outer, int n, size_t inner, double t)
{
    double s = 1.0 - t;
    size_t stride = (size_t)(n + 1) * inner;
    for (size_t o = 0; o < outer; o++, in += stride, left += stride, right += stride)
        for (size_t j = 0; j < inner; j++) {
            double p[KN_MAX_DEGREE + 1];
            for (int i = 0; i <= n; i++) p[i] = in[(size_t)i * inner + j];
            for (int k = 0; k <= n; k++) {
                left[(size_t)k * inner + j] = p[0];
                right[(size_t)(n - k) * inner + j] = p[n - k];
                for (int i = 0; i < n - k; i++) p[i] = s * p[i] + t * p[i + 1];
            }
        }
}

// C(N,k) c_k = sum_i C(n,i) C(N-n,k-i) b_i, which is the product with the constant 1 of degree N - n.
// For one step this is c_k = (k b_(k-1) + (N-k) b_k) / N.
void kn_bernstein_elevate(double *out, const double *in, size_t outer, int n, int to, size_t inner)
{
    assert(n <= to && to <= KN_MAX_DEGREE);
    enum { MOST = (KN_MAX_DEGREE / 2 + 1) * (KN_MAX_DEGREE - KN_MAX_DEGREE / 2 + 1) };
    double bn[KN_MAX_DEGREE + 1], br[KN_MAX_DEGREE + 1], bt[KN_MAX_DEGREE + 1], weights[MOST];
    size_t m = (size_t)n + 1, r = (size_t)(to - n) + 1, stride = ((size_t)to + 1) * inner;
    kn_binomial_row(bn, n);
    kn_binomial_row(br, to - n);
    kn_binomial_row(bt, to);
    for (size_t i = 0; i < m; i++)
        for (size_t k = 0; k < r; k++) weights[i * r + k] = bn[i] * br[k];
    for (size_t o = 0; o < outer; o++, in += m * inner, out += stride) {
        for (size_t j = 0; j < stride; j++) out[j] = 0.0;
        for (size_t i = 0; i < m; i++)
            if (inner == 1)
                for (size_t k = 0; k < r; k++) out[i + k] += weights[i * r + k] * in[i];
            else
                for (size_t k = 0; k < r; k++)
                    for (size_t j = 0; j < inner; j++)
                        out[(i + k) * inner + j] += weights[i * r + k] * in[i * inner + j];
        for (int k = 0; k <= to; k++)
            for (size_t j = 0; j < inner; j++) out[(size_t)k * inner + j] /= bt[k];
    }
}

void kn_bernstein_power(double *out, int power, int n, double lo, double hi)
{
    for (int j = 0; j <= n; j++) {
        out[j] = 0.0;
        for (int i = 0; i <= power; i++) {
            double product = kn_binomial(j, i) * kn_binomial(n - j, power - i);
            if (product == 0.0) continue;
            for (int k = 0; k < power; k++) product *= k < i ? hi : lo;
            out[j] += product;
        }
        out[j] /= kn_binomial(n, power);
    }
}

void kn_bernstein_differentiate(double *out, const double *in, size_t outer, int n, size_t inner)
{
    if (n == 0) {
        memset(out, 0, outer * inner * sizeof *out);
        return;
    }
    size_t stride = (size_t)(n + 1) * inner, to = (size_t)n * inner;
    for (size_t o = 0; o < outer; o++, in += stride, out += to)
        for (size_t j = 0; j < to; j++) out[j] = n * (in[j + inner] - in[j]);
}

size_t kn_bernstein_count(int nvars, const int *degree)
{
    size_t count = 1;
    for (int d = 0; d < nvars; d++) count *= (size_t)degree[d] + 1;
    return count;
}

// Variable by variable, from the back, so that expanding in place is safe.
void kn_bernstein_weights(double *weights, int nvars, const int *degree)
{
    size_t count = 1;
    weights[0] = 1.0;
    for (int d = 0; d < nvars; d++) {
        double row[KN_MAX_DEGREE + 1];
        size_t m = (size_t)degree[d] + 1;
        kn_binomial_row(row, degree[d]);
        for (size_t i = count; i-- > 0;)
            for (size_t k = m; k-- > 0;) weights[i * m + k] = weights[i] * row[k];
        count *= m;
    }
}

// Counts up the multi-index, last variable fastest, as coefficients lie.
void kn_bernstein_places(size_t *at, int nvars, const int *degree, const int *target)
{
    int index[KN_MAX_VARS] = {0};
    size_t step[KN_MAX_VARS], place = 0, count = kn_bernstein_count(nvars, degree);
    for (int d = 0; d < nvars; d++) {
        assert(degree[d] <= target[d]);
        step[d] = kn_bernstein_count(nvars - d - 1, target + d + 1);
    }
    for (size_t i = 0; i < count; i++) {
        at[i] = place;
        for (int d = nvars - 1; d >= 0; d--) {
            place += step[d];
            if (++index[d] <= degree[d]) break;
            place -= (size_t)(degree[d] + 1) * step[d];
            index[d] = 0;
        }
    }
}

// C(m+n,k) c_k = sum_(i+j=k) C(m,i) a_i C(n,j) b_j in each variable. In c's layout i_d + j_d never carries into the
// next variable, so the place of a product is the sum of the places, and along the last variable b's row of
// contiguous coefficients falls on contiguous ones of c.
void kn_bernstein_convolve(double *c, const double *a, const size_t *place_a, size_t na, const double *b,
                           const size_t *place_b, size_t nb, int row_b, double sign)
{
    size_t row = (size_t)row_b;
    for (size_t i = 0; i < na; i++) {
        double f = sign * a[i];
        for (size_t r = 0; r < nb; r += row) {
            double *restrict to = c + place_a[i] + place_b[r];
            const double *restrict from = b + r;
            for (size_t j = 0; j < row; j++) to[j] += f * from[j];
        }
    }
}

// f[lo^(n-i), hi^i] = sum_j sum_k B^(n-i)_(j-k)(lo) B^i_k(hi) p_j: the coefficients of the polynomial
// ((1-lo) + lo x)^(n-i) ((1-hi) + hi x)^i in x.
void kn_bernstein_restriction(double *matrix, int n, double lo, double hi)
{
    double all[(KN_MAX_DEGREE + 1) * (KN_MAX_DEGREE + 2) / 2], b[KN_MAX_DEGREE + 1], *a = all;
    a[0] = b[0] = 1.0;
    for (int k = 1; k <= n; a += k, k++) { // the basis functions of degree 0 .. n at lo, one after the other
        for (int i = 0; i < k; i++) a[k + i] = a[i];
        raise_basis(a + k, k, lo);
    }
    for (int i = 0; i <= n; a -= n - i, i++) {
        double *row = matrix + i * (n + 1);
        if (i > 0) raise_basis(b, i, hi);
        for (int j = 0; j <= n; j++) row[j] = 0.0;
        for (int k = 0; k <= i; k++)
            for (int j = 0; j <= n - i; j++) row[j + k] += a[j] * b[k];
    }
}

// out[j] = sum over k < n of x[k] v[k stride + j], in ascending order, for j < width: a constant where it is inlined.
static inline void some_sums(double *restrict out, const double *restrict x, const double *restrict v, size_t stride,
                             int n, int width)
{
    double s[8];
    for (int j = 0; j < width; j++) s[j] = x[0] * v[j];
    for (int k = 1; k < n; k++) {
        v += stride;
        for (int j = 0; j < width; j++) s[j] += x[k] * v[j];
    }
    for (int j = 0; j < width; j++) out[j] = s[j];
}

static inline void sums(double *restrict out, const double *restrict x, const double *restrict v, size_t stride,
                        int n, size_t width)
{
    size_t j = 0;
    for (; j + 8 <= width; j += 8) some_sums(out + j, x, v + j, stride, n, 8);
    for (; j + 4 <= width; j += 4) some_sums(out + j, x, v + j, stride, n, 4);
    for (; j < width; j++) some_sums(out + j, x, v + j, stride, n, 1);
}

void kn_bernstein_transform_rows(double *out, const double *in, size_t outer, int rows, int columns,
                                 const double *turned)
{
    size_t nrows = (size_t)rows, ncolumns = (size_t)columns;
    for (size_t o = 0; o < outer; o++) sums(out + o * nrows, in + o * ncolumns, turned, nrows, columns, nrows);
}

void kn_bernstein_transform(double *out, const double *in, size_t outer, int rows, int columns, size_t inner,
                            const double *matrix)
{
    enum { MOST = 256 }; // of the numbers of a matrix that is transposed
    size_t nrows = (size_t)rows, ncolumns = (size_t)columns;
    double turned[MOST];
    if (inner == 1 && outer > 1 && nrows * ncolumns <= MOST) { // several rows at a time, not several numbers of one
        for (size_t r = 0; r < nrows; r++)
            for (size_t k = 0; k < ncolumns; k++) turned[k * nrows + r] = matrix[r * ncolumns + k];
        kn_bernstein_transform_rows(out, in, outer, rows, columns, turned);
        return;
    }
    for (size_t o = 0; o < outer; o++, in += ncolumns * inner)
        for (size_t r = 0; r < nrows; r++, out += inner) sums(out, matrix + r * ncolumns, in, inner, columns, inner);
}
