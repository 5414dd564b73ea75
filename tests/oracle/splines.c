// SPDX-License-Identifier: Apache-2.0
// Splines as exact polynomials on boxes of spans, and back by dual functionals.
#include "tests/oracle/exact.h"

#include <stdlib.h>

#include <flint/fmpq_poly.h>

// The last span that begins at or before `at`, the last one of all at the end of the domain, the first one before it.
static int span_of(const kn_spline *s, int var, double at)
{
    const double *t = s->knots[var];
    int i = s->count[var] - 1;
    while (i > s->degree[var] && !(t[i] <= at && t[i] < t[i + 1])) i--;
    return at >= t[s->count[var]] ? s->count[var] - 1 : i;
}

// sum += (sign (t - knot) / (b - a)) from, nothing when b = a.
static void add_ramp(fmpq_poly_t sum, const fmpq_poly_t from, double knot, double a, double b, bool down)
{
    if (a == b) return;
    fmpq_t x, y;
    fmpq_poly_t ramp;
    fmpq_init(x), fmpq_init(y), fmpq_poly_init(ramp);
    fmpq_of_double(x, a), fmpq_of_double(y, b);
    fmpq_sub(y, y, x); // b - a
    fmpq_of_double(x, knot);
    fmpq_neg(x, x);
    fmpq_poly_set_coeff_fmpq(ramp, 0, x);
    fmpq_poly_set_coeff_si(ramp, 1, 1);
    fmpq_poly_scalar_div_fmpq(ramp, ramp, y);
    if (down) fmpq_poly_neg(ramp, ramp);
    fmpq_poly_mul(ramp, ramp, from);
    fmpq_poly_add(sum, sum, ramp);
    fmpq_clear(x), fmpq_clear(y), fmpq_poly_clear(ramp);
}

// N_i,m = (t - t_i)/(t_i+m - t_i) N_i,m-1 + (t_i+m+1 - t)/(t_i+m+1 - t_i+1) N_i+1,m-1 (Cox, de Boor), as
// polynomials on the span s: entry k of basis is N_(s-m+k),m.
static void basis_polynomials(fmpq_poly_t *basis, const double *t, int p, int s)
{
    fmpq_poly_t *next = calloc((size_t)p + 1, sizeof *next);
    assert_non_null(next);
    for (int k = 0; k <= p; k++) fmpq_poly_init(next[k]), fmpq_poly_zero(basis[k]);
    fmpq_poly_one(basis[0]);
    for (int m = 1; m <= p; m++) {
        for (int k = 0; k <= m; k++) {
            int i = s - m + k;
            fmpq_poly_zero(next[k]);
            if (k > 0) add_ramp(next[k], basis[k - 1], t[i], t[i], t[i + m], false);
            if (k < m) add_ramp(next[k], basis[k], t[i + m + 1], t[i + 1], t[i + m + 1], true);
        }
        for (int k = 0; k <= m; k++) fmpq_poly_swap(basis[k], next[k]);
    }
    for (int k = 0; k <= p; k++) fmpq_poly_clear(next[k]);
    free(next);
}

void exact_basis(exact *out, int *first, const kn_spline *s, int var, double at)
{
    int p = s->degree[var], span = span_of(s, var, at);
    const int square[2] = {p, p};
    fmpq_poly_t *basis = calloc((size_t)p + 1, sizeof *basis);
    assert_non_null(basis);
    for (int k = 0; k <= p; k++) fmpq_poly_init(basis[k]);
    basis_polynomials(basis, s->knots[var], p, span);
    fmpq *all = _fmpq_vec_init((p + 1) * (p + 1));
    for (int k = 0; k <= p; k++)
        for (int j = 0; j <= p; j++) fmpq_poly_get_coeff_fmpq(all + j * (p + 1) + k, basis[k], j);
    exact_of_fractions(out, 2, square, all);
    _fmpq_vec_clear(all, (p + 1) * (p + 1));
    *first = span - p;
    for (int k = 0; k <= p; k++) fmpq_poly_clear(basis[k]);
    free(basis);
}

// The control points first[d] .. first[d] + degree[d] of a component, as they lie in a piece.
static void gather(double *to, const kn_spline *s, int comp, const int *first)
{
    size_t base = (size_t)comp * kn_spline_count(s);
    int index[KN_MAX_VARS] = {0}, d = 0;
    do {
        size_t place = 0;
        for (d = 0; d < s->nvars; d++) place = place * (size_t)s->count[d] + (size_t)(first[d] + index[d]);
        *to++ = s->coef[base + place];
        for (d = s->nvars - 1; d >= 0 && ++index[d] > s->degree[d]; d--) index[d] = 0;
    } while (d >= 0);
}

void exact_of_spline(exact *out, const kn_spline *s, int comp, const double *at, bool absolute)
{
    if (comp == s->ncomp) {
        exact_constant(out, s->nvars, 1.0);
        return;
    }
    int first[KN_MAX_VARS];
    exact basis[KN_MAX_VARS];
    size_t n = 1;
    for (int d = 0; d < s->nvars; d++) {
        basis[d] = exact_new();
        exact_basis(&basis[d], &first[d], s, d, at[d]);
        n *= (size_t)s->degree[d] + 1;
    }
    double *points = malloc(n * sizeof *points);
    assert_non_null(points);
    gather(points, s, comp, first);
    exact_of_array(out, s->nvars, s->degree, points, absolute);
    for (int d = 0; d < s->nvars; d++) {
        exact_map(out, out, d, &basis[d]);
        exact_free(&basis[d]);
    }
    free(points);
}

// Row j of the dual functional: t^k has the coefficient e_k(t_j+1 .. t_j+p) / C(p,k) (polar forms of powers).
static void dual(exact *out, const double *args, int p, int k_most)
{
    const int shape[2] = {0, k_most};
    fmpq_t *e = calloc((size_t)p + 1, sizeof *e), x, y;
    fmpz_t c;
    assert_non_null(e);
    fmpq_init(x), fmpq_init(y), fmpz_init(c);
    for (int k = 0; k <= p; k++) fmpq_init(e[k]);
    fmpq_one(e[0]);
    for (int i = 0; i < p; i++) {
        fmpq_of_double(x, args[i]);
        for (int k = i + 1; k > 0; k--) fmpq_addmul(e[k], e[k - 1], x);
    }
    exact_shape(out, 2, shape);
    for (int k = 0; k <= k_most; k++) {
        fmpz_bin_uiui(c, (ulong)p, (ulong)k);
        fmpq_div_fmpz(y, e[k], c);
        exact_set(out, (size_t)k, y);
    }
    for (int k = 0; k <= p; k++) fmpq_clear(e[k]);
    fmpq_clear(x), fmpq_clear(y), fmpz_clear(c);
    free(e);
}

void exact_spline_coefs(exact *out, const kn_spline *r, exact_piece f, void *user)
{
    int index[KN_MAX_VARS] = {0}, shape[KN_MAX_VARS], d;
    double at[KN_MAX_VARS], last[KN_MAX_VARS] = {0};
    exact piece = exact_new(), value = exact_new(), row = exact_new();
    size_t n = kn_spline_count(r);
    fmpq *all = _fmpq_vec_init((slong)n);
    for (d = 0; d < r->nvars; d++) shape[d] = r->count[d] - 1;
    for (size_t i = 0; i < n; i++) {
        bool same = i > 0;
        for (d = 0; d < r->nvars; d++) {
            int j = index[d];
            while (r->knots[d][j] == r->knots[d][j + 1]) j++; // the first span of the support
            at[d] = r->knots[d][j];
            same &= at[d] == last[d];
            last[d] = at[d];
        }
        if (!same) f(&piece, at, user);
        exact_copy(&value, &piece);
        for (d = 0; d < r->nvars; d++) {
            dual(&row, r->knots[d] + index[d] + 1, r->degree[d], value.degree[d]);
            exact_map(&value, &value, d, &row);
        }
        exact_get(all + i, &value, 0);
        for (d = r->nvars - 1; d >= 0 && ++index[d] > shape[d]; d--) index[d] = 0;
    }
    exact_of_fractions(out, r->nvars, shape, all);
    _fmpq_vec_clear(all, (slong)n);
    exact_free(&piece), exact_free(&value), exact_free(&row);
}
