// SPDX-License-Identifier: Apache-2.0
// Polynomials over the rationals: integers over one denominator, products by FLINT.
#include "tests/oracle/exact.h"

#include <math.h>

#include <flint/fmpz_poly.h>

// ---- storage ----
exact exact_new(void)
{
    exact a = {0};
    a.num = _fmpz_vec_init(1);
    fmpz_init_set_ui(a.den, 1);
    return a;
}

size_t exact_count(const exact *a)
{
    size_t n = 1;
    for (int d = 0; d < a->nvars; d++) n *= (size_t)a->degree[d] + 1;
    return n;
}

void exact_free(exact *a)
{
    _fmpz_vec_clear(a->num, (slong)exact_count(a));
    fmpz_clear(a->den);
    *a = (exact){0};
}

void exact_swap(exact *a, exact *b)
{
    exact t = *a;
    *a = *b, *b = t;
}

void exact_shape(exact *out, int nvars, const int *degree)
{
    exact a = {.nvars = nvars};
    for (int d = 0; d < nvars; d++) a.degree[d] = degree[d];
    a.num = _fmpz_vec_init((slong)exact_count(&a));
    fmpz_init_set_ui(a.den, 1);
    exact_swap(out, &a);
    exact_free(&a);
}

void exact_copy(exact *out, const exact *a)
{
    if (out == a) return;
    exact_shape(out, a->nvars, a->degree);
    _fmpz_vec_set(out->num, a->num, (slong)exact_count(a));
    fmpz_set(out->den, a->den);
}

// x = m 2^e, m an integer below 2^53 in size.
static int split_double(fmpz_t m, double x)
{
    int e;
    assert_true(isfinite(x));
    fmpz_set_d(m, ldexp(frexp(x, &e), 53));
    return e - 53;
}

void fmpq_of_double(fmpq_t out, double x)
{
    fmpz_t one;
    fmpz_init_set_ui(one, 1);
    int e = split_double(fmpq_numref(out), x);
    if (e >= 0) fmpz_mul_2exp(fmpq_numref(out), fmpq_numref(out), (ulong)e);
    fmpz_mul_2exp(fmpq_denref(out), one, e < 0 ? (ulong)-e : 0);
    fmpq_canonicalise(out);
    fmpz_clear(one);
}

void exact_of_array(exact *out, int nvars, const int *degree, const double *array, bool absolute)
{
    exact_shape(out, nvars, degree);
    size_t n = exact_count(out);
    int least = 0; // the denominator is 2^-least
    for (size_t i = 0; i < n; i++) {
        int e;
        frexp(array[i], &e);
        if (array[i] != 0.0 && e - 53 < least) least = e - 53;
    }
    for (size_t i = 0; i < n; i++) {
        if (array[i] == 0.0) continue;
        int e = split_double(out->num + i, absolute ? fabs(array[i]) : array[i]);
        fmpz_mul_2exp(out->num + i, out->num + i, (ulong)(e - least));
    }
    fmpz_mul_2exp(out->den, out->den, (ulong)-least);
}

void exact_of_fractions(exact *out, int nvars, const int *degree, const fmpq *array)
{
    exact a = exact_new();
    fmpz_t rise;
    fmpz_init(rise);
    exact_shape(&a, nvars, degree);
    size_t n = exact_count(&a);
    for (size_t i = 0; i < n; i++) fmpz_lcm(a.den, a.den, fmpq_denref(array + i));
    for (size_t i = 0; i < n; i++) {
        fmpz_divexact(rise, a.den, fmpq_denref(array + i));
        fmpz_mul(a.num + i, fmpq_numref(array + i), rise);
    }
    exact_swap(out, &a);
    exact_free(&a), fmpz_clear(rise);
}

void exact_constant(exact *out, int nvars, double value)
{
    const int degree[KN_MAX_VARS] = {0};
    exact_of_array(out, nvars, degree, &value, false);
}

void exact_get(fmpq_t out, const exact *a, size_t i)
{
    fmpq_set_fmpz_frac(out, a->num + i, a->den);
}

void exact_set(exact *a, size_t i, const fmpq_t value)
{
    size_t n = exact_count(a);
    fmpz_t g, rise;
    fmpz_init(g), fmpz_init(rise);
    fmpz_gcd(g, a->den, fmpq_denref(value));
    fmpz_divexact(rise, fmpq_denref(value), g);
    if (!fmpz_is_one(rise)) {
        _fmpz_vec_scalar_mul_fmpz(a->num, a->num, (slong)n, rise);
        fmpz_mul(a->den, a->den, rise);
    }
    fmpz_divexact(rise, a->den, fmpq_denref(value));
    fmpz_mul(a->num + i, fmpq_numref(value), rise);
    fmpz_clear(g), fmpz_clear(rise);
}

void exact_abs(exact *a)
{
    size_t n = exact_count(a);
    for (size_t i = 0; i < n; i++) fmpz_abs(a->num + i, a->num + i);
}

// Divides by what numerators and denominator share.
static void reduce(exact *a)
{
    fmpz_t g;
    fmpz_init(g);
    slong n = (slong)exact_count(a);
    _fmpz_vec_content(g, a->num, n);
    fmpz_gcd(g, g, a->den);
    if (!fmpz_is_one(g)) {
        _fmpz_vec_scalar_divexact_fmpz(a->num, a->num, n, g);
        fmpz_divexact(a->den, a->den, g);
    }
    fmpz_clear(g);
}

// ---- lines along a variable ----
typedef struct axis {
    size_t outer, n, inner;
} axis;

static axis axis_of(const exact *a, int var)
{
    axis x = {1, (size_t)a->degree[var] + 1, 1};
    for (int d = 0; d < var; d++) x.outer *= (size_t)a->degree[d] + 1;
    for (int d = var + 1; d < a->nvars; d++) x.inner *= (size_t)a->degree[d] + 1;
    return x;
}

// out = a in an array of other degrees: zeros where a has none; numbers beyond are left out.
static void reshape(exact *out, const exact *a, const int *degree)
{
    exact b = exact_new();
    int index[KN_MAX_VARS] = {0};
    exact_shape(&b, a->nvars, degree);
    size_t n = exact_count(a);
    for (size_t i = 0; i < n; i++) {
        size_t place = 0;
        bool inside = true;
        for (int d = 0; d < a->nvars; d++) {
            inside &= index[d] <= degree[d];
            place = place * ((size_t)degree[d] + 1) + (size_t)index[d];
        }
        if (inside) fmpz_set(b.num + place, a->num + i);
        for (int d = a->nvars - 1; d >= 0 && ++index[d] > a->degree[d]; d--) index[d] = 0;
    }
    fmpz_set(b.den, a->den);
    exact_swap(out, &b);
    exact_free(&b);
}

// ---- the two bases: a_k = C(n,k) (difference k of b at 0), so b_j = sum_k C(j,k) a_k / C(n,k) ----
static void line_to_power(fmpz *b, size_t n, size_t step)
{
    fmpz_t c;
    fmpz_init(c);
    for (size_t r = 1; r <= n; r++)
        for (size_t i = n; i >= r; i--) fmpz_sub(b + i * step, b + i * step, b + (i - 1) * step);
    for (size_t k = 0; k <= n; k++) {
        fmpz_bin_uiui(c, n, k);
        fmpz_mul(b + k * step, b + k * step, c);
    }
    fmpz_clear(c);
}

static void line_to_bernstein(fmpz *a, size_t n, size_t step, const fmpz_t multiple)
{
    fmpz_t c;
    fmpz_init(c);
    for (size_t k = 0; k <= n; k++) {
        fmpz_bin_uiui(c, n, k);
        fmpz_divexact(c, multiple, c);
        fmpz_mul(a + k * step, a + k * step, c);
    }
    for (size_t r = n; r >= 1; r--)
        for (size_t i = r; i <= n; i++) fmpz_add(a + i * step, a + i * step, a + (i - 1) * step);
    fmpz_clear(c);
}

void exact_power(exact *a)
{
    for (int d = 0; d < a->nvars; d++) {
        axis x = axis_of(a, d);
        for (size_t o = 0; o < x.outer; o++)
            for (size_t j = 0; j < x.inner; j++) line_to_power(a->num + o * x.n * x.inner + j, x.n - 1, x.inner);
    }
    reduce(a);
}

void exact_bernstein(exact *out, const exact *a, const int *degree)
{
    fmpz_t multiple, c;
    fmpz_init(multiple), fmpz_init(c);
    for (int d = 0; d < a->nvars; d++) assert_true(a->degree[d] <= degree[d]);
    reshape(out, a, degree);
    for (int d = 0; d < out->nvars; d++) {
        axis x = axis_of(out, d);
        fmpz_one(multiple);
        for (size_t k = 0; k < x.n; k++) {
            fmpz_bin_uiui(c, x.n - 1, k);
            fmpz_lcm(multiple, multiple, c);
        }
        for (size_t o = 0; o < x.outer; o++)
            for (size_t j = 0; j < x.inner; j++)
                line_to_bernstein(out->num + o * x.n * x.inner + j, x.n - 1, x.inner, multiple);
        fmpz_mul(out->den, out->den, multiple);
    }
    reduce(out);
    fmpz_clear(multiple), fmpz_clear(c);
}

void exact_of_bezier(exact *out, const kn_bezier *b, int comp, bool absolute)
{
    if (comp == b->ncomp) {
        exact_constant(out, b->nvars, 1.0);
        return;
    }
    exact_of_array(out, b->nvars, b->degree, b->coef + (size_t)comp * kn_bezier_count(b), absolute);
    exact_power(out);
}

// ---- algebra ----
// With the strides of the product, indices add without carry: one product of polynomials in one variable.
void exact_mul(exact *out, const exact *a, const exact *b)
{
    int degree[KN_MAX_VARS];
    assert_int_equal(a->nvars, b->nvars);
    for (int d = 0; d < a->nvars; d++) degree[d] = a->degree[d] + b->degree[d];
    exact x = exact_new(), y = exact_new(), c = exact_new();
    reshape(&x, a, degree);
    reshape(&y, b, degree);
    exact_shape(&c, a->nvars, degree);
    slong n = (slong)exact_count(&c), na = n, nb = n;
    while (na > 1 && fmpz_is_zero(x.num + na - 1)) na--;
    while (nb > 1 && fmpz_is_zero(y.num + nb - 1)) nb--;
    if (na >= nb)
        _fmpz_poly_mul(c.num, x.num, na, y.num, nb);
    else
        _fmpz_poly_mul(c.num, y.num, nb, x.num, na);
    fmpz_mul(c.den, a->den, b->den);
    reduce(&c);
    exact_swap(out, &c);
    exact_free(&x), exact_free(&y), exact_free(&c);
}

static void add(exact *out, const exact *a, const exact *b, bool minus)
{
    int degree[KN_MAX_VARS];
    assert_int_equal(a->nvars, b->nvars);
    for (int d = 0; d < a->nvars; d++) degree[d] = a->degree[d] > b->degree[d] ? a->degree[d] : b->degree[d];
    exact x = exact_new(), y = exact_new();
    reshape(&x, a, degree);
    reshape(&y, b, degree);
    slong n = (slong)exact_count(&x);
    _fmpz_vec_scalar_mul_fmpz(x.num, x.num, n, y.den);
    if (minus)
        _fmpz_vec_scalar_submul_fmpz(x.num, y.num, n, x.den);
    else
        _fmpz_vec_scalar_addmul_fmpz(x.num, y.num, n, x.den);
    fmpz_mul(x.den, x.den, y.den);
    reduce(&x);
    exact_swap(out, &x);
    exact_free(&x), exact_free(&y);
}

void exact_add(exact *out, const exact *a, const exact *b)
{
    add(out, a, b, false);
}

void exact_sub(exact *out, const exact *a, const exact *b)
{
    add(out, a, b, true);
}

void exact_scale(exact *out, const exact *a, const fmpq_t factor)
{
    exact_copy(out, a);
    _fmpz_vec_scalar_mul_fmpz(out->num, out->num, (slong)exact_count(out), fmpq_numref(factor));
    fmpz_mul(out->den, out->den, fmpq_denref(factor));
    reduce(out);
}

void exact_derivative(exact *out, const exact *a, int var)
{
    exact b = exact_new();
    exact_copy(&b, a);
    axis x = axis_of(&b, var);
    for (size_t o = 0; o < x.outer; o++)
        for (size_t k = 0; k < x.n; k++)
            for (size_t j = 0; j < x.inner; j++) {
                fmpz *to = b.num + (o * x.n + k) * x.inner + j;
                if (k + 1 < x.n)
                    fmpz_mul_ui(to, to + x.inner, k + 1);
                else
                    fmpz_zero(to);
            }
    int degree[KN_MAX_VARS];
    for (int d = 0; d < a->nvars; d++) degree[d] = a->degree[d];
    if (degree[var] > 0) degree[var]--;
    reshape(out, &b, degree);
    exact_free(&b);
}

void exact_antiderivative(exact *out, const exact *a, int var)
{
    int degree[KN_MAX_VARS];
    for (int d = 0; d < a->nvars; d++) degree[d] = a->degree[d] + (d == var);
    exact b = exact_new();
    reshape(&b, a, degree);
    axis x = axis_of(&b, var);
    fmpz_t all, part;
    fmpz_init_set_ui(all, 1), fmpz_init(part);
    for (size_t k = 1; k < x.n; k++) {
        fmpz_set_ui(part, k);
        fmpz_lcm(all, all, part);
    }
    for (size_t o = 0; o < x.outer; o++)
        for (size_t k = x.n; k-- > 0;)
            for (size_t j = 0; j < x.inner; j++) {
                fmpz *to = b.num + (o * x.n + k) * x.inner + j;
                if (k == 0) {
                    fmpz_zero(to);
                    continue;
                }
                fmpz_divexact_ui(part, all, k);
                fmpz_mul(to, to - x.inner, part);
            }
    fmpz_mul(b.den, b.den, all);
    reduce(&b);
    exact_swap(out, &b);
    exact_free(&b), fmpz_clear(all), fmpz_clear(part);
}

// lo = P/Q, hi - lo = R/Q: a_j (P/Q + R/Q x)^j, all over Q^n; a Taylor shift by P of a_j Q^(n-j), then x -> R x.
void exact_substitute(exact *out, const exact *a, int var, double lo, double hi)
{
    fmpq_t p, r;
    fmpz_t q, shift, power;
    fmpq_init(p), fmpq_init(r), fmpz_init(q), fmpz_init(shift), fmpz_init(power);
    fmpq_of_double(p, lo), fmpq_of_double(r, hi);
    fmpq_sub(r, r, p);
    fmpz_lcm(q, fmpq_denref(p), fmpq_denref(r));
    fmpz_divexact(shift, q, fmpq_denref(p));
    fmpz_mul(shift, shift, fmpq_numref(p));
    exact_copy(out, a);
    axis x = axis_of(out, var);
    for (size_t o = 0; o < x.outer; o++)
        for (size_t j = 0; j < x.inner; j++) {
            fmpz *line = out->num + o * x.n * x.inner + j;
            fmpz_one(power);
            for (size_t k = x.n; k-- > 0; fmpz_mul(power, power, q))
                fmpz_mul(line + k * x.inner, line + k * x.inner, power);
            for (size_t i = 0; i + 1 < x.n; i++)
                for (size_t k = x.n - 1; k-- > i;) fmpz_addmul(line + k * x.inner, line + (k + 1) * x.inner, shift);
        }
    fmpz_pow_ui(power, q, x.n - 1);
    fmpz_mul(out->den, out->den, power);
    fmpz_divexact(q, q, fmpq_denref(r));
    fmpz_mul(q, q, fmpq_numref(r)); // R
    fmpz_one(power);
    for (size_t k = 0; k < x.n; k++, fmpz_mul(power, power, q))
        for (size_t o = 0; o < x.outer; o++)
            _fmpz_vec_scalar_mul_fmpz(out->num + (o * x.n + k) * x.inner, out->num + (o * x.n + k) * x.inner,
                                      (slong)x.inner, power);
    reduce(out);
    fmpq_clear(p), fmpq_clear(r), fmpz_clear(q), fmpz_clear(shift), fmpz_clear(power);
}

void exact_divide_power(exact *out, const exact *a, int var, int k)
{
    int degree[KN_MAX_VARS];
    for (int d = 0; d < a->nvars; d++) degree[d] = a->degree[d] - (d == var ? k : 0);
    exact b = exact_new();
    exact_shape(&b, a->nvars, degree);
    axis from = axis_of(a, var), to = axis_of(&b, var);
    for (size_t o = 0; o < from.outer; o++) {
        for (size_t i = 0; i < (size_t)k * from.inner; i++)
            assert_true(fmpz_is_zero(a->num + o * from.n * from.inner + i));
        _fmpz_vec_set(b.num + o * to.n * to.inner, a->num + (o * from.n + (size_t)k) * from.inner,
                      (slong)(to.n * to.inner));
    }
    fmpz_set(b.den, a->den);
    exact_swap(out, &b);
    exact_free(&b);
}

// out = a without its last variable, which is put at `at`.
static void fix_last(exact *out, const exact *a, double at)
{
    fmpq_t p;
    fmpq_init(p);
    fmpq_of_double(p, at);
    axis x = axis_of(a, a->nvars - 1);
    exact b = exact_new();
    exact_shape(&b, a->nvars - 1, a->degree);
    fmpz_t power;
    fmpz_init(power);
    for (size_t o = 0; o < x.outer; o++) { // Horner: sum_j a_j P^j Q^(n-j)
        fmpz_one(power);
        fmpz_set(b.num + o, a->num + o * x.n + x.n - 1);
        for (size_t k = x.n - 1; k-- > 0;) {
            fmpz_mul(power, power, fmpq_denref(p));
            fmpz_mul(b.num + o, b.num + o, fmpq_numref(p));
            fmpz_addmul(b.num + o, a->num + o * x.n + k, power);
        }
    }
    fmpz_pow_ui(power, fmpq_denref(p), x.n - 1);
    fmpz_mul(b.den, a->den, power);
    exact_swap(out, &b);
    exact_free(&b), fmpz_clear(power), fmpq_clear(p);
}

void exact_value(fmpq_t out, const exact *a, const double *at)
{
    exact b = exact_new();
    exact_copy(&b, a);
    for (int d = a->nvars - 1; d >= 0; d--) fix_last(&b, &b, at[d]);
    exact_get(out, &b, 0);
    exact_free(&b);
}

// ---- composition: Horner in the first variable, whose coefficients are composed in the others ----
static void slice(exact *out, const exact *a, size_t k)
{
    exact b = exact_new();
    exact_shape(&b, a->nvars - 1, a->degree + 1);
    size_t n = exact_count(&b);
    _fmpz_vec_set(b.num, a->num + k * n, (slong)n);
    fmpz_set(b.den, a->den);
    exact_swap(out, &b);
    exact_free(&b);
}

void exact_compose(exact *out, const exact *outer, const exact *inner, const exact *weight)
{
    exact sum = exact_new(), part = exact_new(), power = exact_new(), one = exact_new();
    if (outer->nvars == 0) {
        fmpq_t c;
        fmpq_init(c);
        exact_get(c, outer, 0);
        exact_constant(&one, inner[0].nvars, 1.0);
        exact_scale(&sum, &one, c);
        fmpq_clear(c);
    } else {
        const exact *others = outer->nvars > 1 ? inner + 1 : inner; // only its number of variables is looked at
        exact_constant(&power, inner[0].nvars, 1.0);
        exact_constant(&sum, inner[0].nvars, 0.0);
        for (size_t k = (size_t)outer->degree[0] + 1; k-- > 0;) {
            if (k < (size_t)outer->degree[0]) exact_mul(&sum, &sum, inner);
            slice(&part, outer, k);
            exact_compose(&part, &part, others, weight);
            if (weight) exact_mul(&part, &part, &power);
            exact_add(&sum, &sum, &part);
            if (weight) exact_mul(&power, &power, weight);
        }
    }
    exact_swap(out, &sum);
    exact_free(&sum), exact_free(&part), exact_free(&power), exact_free(&one);
}

// ---- maps ----
void exact_map(exact *out, const exact *a, int var, const exact *matrix)
{
    assert_int_equal(matrix->degree[1], a->degree[var]);
    int degree[KN_MAX_VARS];
    for (int d = 0; d < a->nvars; d++) degree[d] = d == var ? matrix->degree[0] : a->degree[d];
    exact b = exact_new();
    exact_shape(&b, a->nvars, degree);
    axis x = axis_of(a, var);
    size_t rows = (size_t)matrix->degree[0] + 1;
    for (size_t o = 0; o < x.outer; o++)
        for (size_t r = 0; r < rows; r++)
            for (size_t k = 0; k < x.n; k++)
                _fmpz_vec_scalar_addmul_fmpz(b.num + (o * rows + r) * x.inner, a->num + (o * x.n + k) * x.inner,
                                             (slong)x.inner, matrix->num + r * x.n + k);
    fmpz_mul(b.den, a->den, matrix->den);
    reduce(&b);
    exact_swap(out, &b);
    exact_free(&b);
}

// Column j holds what becomes of the Bernstein polynomial j.
void exact_restriction_matrix(exact *out, int n, double lo, double hi)
{
    const int square[2] = {n, n};
    size_t m = (size_t)n + 1;
    exact all = exact_new(), column = exact_new();
    exact_shape(&all, 2, square); // row j: polynomial j, so that one substitution serves all
    for (size_t j = 0; j < m; j++) fmpz_one(all.num + j * m + j);
    exact id = exact_new();
    exact_copy(&id, &all);
    for (size_t j = 0; j < m; j++) line_to_power(id.num + j * m, m - 1, 1);
    exact_substitute(&id, &id, 1, lo, hi);
    fmpz_t multiple, c;
    fmpz_init_set_ui(multiple, 1), fmpz_init(c);
    for (size_t k = 0; k < m; k++) {
        fmpz_bin_uiui(c, m - 1, k);
        fmpz_lcm(multiple, multiple, c);
    }
    for (size_t j = 0; j < m; j++) line_to_bernstein(id.num + j * m, m - 1, 1, multiple);
    fmpz_mul(all.den, id.den, multiple);
    for (size_t j = 0; j < m; j++)
        for (size_t k = 0; k < m; k++) fmpz_set(all.num + k * m + j, id.num + j * m + k);
    reduce(&all);
    exact_swap(out, &all);
    exact_free(&all), exact_free(&id), exact_free(&column), fmpz_clear(multiple), fmpz_clear(c);
}
