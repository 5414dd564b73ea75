// SPDX-License-Identifier: Apache-2.0
#include "tests/oracle/roots.h"

#include <flint/fmpz_poly_factor.h>

#include <math.h>

static void set_scaled(fmpz_t out, double x, int least)
{
    int e = 0;
    double m = frexp(x, &e);
    fmpz_set_d(out, ldexp(m, 53));
    if (x != 0.0) fmpz_mul_2exp(out, out, (unsigned long)(e - 53 - least));
}

void roots_of_array(fmpz_poly_t out, const double *coef, int n)
{
    int least = 0;
    bool any = false;
    for (int i = 0; i <= n; i++) {
        int e = 0;
        (void)frexp(coef[i], &e);
        if (coef[i] != 0.0 && (!any || e - 53 < least)) least = e - 53, any = true;
    }
    fmpz_poly_zero(out);
    fmpz_t x;
    fmpz_init(x);
    for (int i = 0; i <= n; i++) {
        set_scaled(x, coef[i], least);
        fmpz_poly_set_coeff_fmpz(out, i, x);
    }
    fmpz_clear(x);
}

// One corner cut after the other: p_i <- (q - t) p_i + t p_(i+1); all coefficients of a level share the factor
// q^level, which is put right at the end.
static void cut(fmpz_poly_t coef, int n, const fmpz_t t, const fmpz_t q, bool keep_right)
{
    fmpz *p = _fmpz_vec_init(n + 1), *out = _fmpz_vec_init(n + 1);
    fmpz_t s, f;
    fmpz_init(s);
    fmpz_init(f);
    fmpz_sub(s, q, t);
    for (int i = 0; i <= n; i++) fmpz_poly_get_coeff_fmpz(p + i, coef, i);
    for (int k = 0; k <= n; k++) {
        fmpz_pow_ui(f, q, (unsigned long)(n - k));
        int at = keep_right ? n - k : k;
        fmpz_mul(out + at, p + (keep_right ? n - k : 0), f);
        for (int i = 0; i < n - k; i++) {
            fmpz_mul(p + i, p + i, s);
            fmpz_addmul(p + i, p + i + 1, t);
        }
    }
    fmpz_poly_zero(coef);
    for (int i = 0; i <= n; i++) fmpz_poly_set_coeff_fmpz(coef, i, out + i);
    _fmpz_vec_clear(p, n + 1);
    _fmpz_vec_clear(out, n + 1);
    fmpz_clear(s);
    fmpz_clear(f);
}

static void restrict_to(fmpz_poly_t coef, int n, const fmpz_t a, const fmpz_t b, const fmpz_t q)
{
    cut(coef, n, b, q, false); // [0, b/q], then from a/b on
    if (!fmpz_is_zero(b)) cut(coef, n, a, b, true);
}

void roots_restrict(fmpz_poly_t coef, int n, unsigned long a, unsigned long b, unsigned long q)
{
    fmpz_t fa, fb, fq;
    fmpz_init_set_ui(fa, a);
    fmpz_init_set_ui(fb, b);
    fmpz_init_set_ui(fq, q);
    restrict_to(coef, n, fa, fb, fq);
    fmpz_clear(fa);
    fmpz_clear(fb);
    fmpz_clear(fq);
}

bool roots_zero(const fmpz_poly_t coef)
{
    return fmpz_poly_is_zero(coef);
}

// With x = t / (1 + t), (1 + t)^n f(x) = sum C(n,i) c_i t^i: the roots in (0,1) are its positive ones, zeros at the
// low end are roots at 0, and missing high coefficients roots at 1.
roots_facts roots_look(const fmpz_poly_t coef, int n)
{
    roots_facts facts = {0};
    fmpz_poly_t p;
    fmpz_poly_factor_t parts;
    fmpz_t c, b;
    fmpz_poly_init(p);
    fmpz_poly_factor_init(parts);
    fmpz_init(c);
    fmpz_init(b);
    for (int i = 0; i <= n; i++) {
        fmpz_poly_get_coeff_fmpz(c, coef, i);
        fmpz_bin_uiui(b, (unsigned long)n, (unsigned long)i);
        fmpz_mul(c, c, b);
        fmpz_poly_set_coeff_fmpz(p, i, c);
    }
    facts.right = n - (int)fmpz_poly_degree(p);
    while (fmpz_is_zero(fmpz_poly_get_coeff_ptr(p, facts.left))) facts.left++;
    fmpz_poly_shift_right(p, p, facts.left);
    facts.start = fmpz_sgn(fmpz_poly_get_coeff_ptr(p, 0));
    fmpz_poly_factor_squarefree(parts, p);
    for (slong i = 0; i < parts->num; i++) {
        slong negative = 0, positive = 0;
        _fmpz_poly_num_real_roots_sturm(&negative, &positive, parts->p[i].coeffs, parts->p[i].length);
        facts.inside += (int)positive;
        if (parts->exp[i] % 2 == 1) facts.odd += (int)positive;
    }
    fmpz_poly_clear(p);
    fmpz_poly_factor_clear(parts);
    fmpz_clear(c);
    fmpz_clear(b);
    return facts;
}

// a and b over one power of two.
static void restrict_doubles(fmpz_poly_t coef, int n, double a, double b)
{
    int ea = 0, eb = 0, least;
    (void)frexp(a, &ea);
    (void)frexp(b, &eb);
    least = (a != 0.0 && ea < eb ? ea : eb) - 53;
    if (least > 0) least = 0;
    fmpz_t fa, fb, fq;
    fmpz_init(fa);
    fmpz_init(fb);
    fmpz_init_set_ui(fq, 1);
    set_scaled(fa, a, least);
    set_scaled(fb, b, least);
    fmpz_mul_2exp(fq, fq, (unsigned long)-least);
    restrict_to(coef, n, fa, fb, fq);
    fmpz_clear(fa);
    fmpz_clear(fb);
    fmpz_clear(fq);
}

int roots_between(const double *coef, int n, double a, double b)
{
    fmpz_poly_t p;
    fmpz_poly_init(p);
    roots_of_array(p, coef, n);
    restrict_doubles(p, n, a, b);
    int count = -1;
    if (a == b) {
        count = roots_sign(coef, n, a) == 0;
    } else if (!roots_zero(p)) {
        roots_facts f = roots_look(p, n);
        count = f.inside + (f.left > 0) + (f.right > 0);
    }
    fmpz_poly_clear(p);
    return count;
}

int roots_sign(const double *coef, int n, double x)
{
    if (x == 0.0) return (coef[0] > 0.0) - (coef[0] < 0.0);
    fmpz_poly_t p;
    fmpz_poly_init(p);
    roots_of_array(p, coef, n);
    restrict_doubles(p, n, 0.0, x);
    int sign = fmpz_poly_degree(p) == n ? fmpz_sgn(fmpz_poly_get_coeff_ptr(p, n))
                                        : 0; // the last coefficient is the value
    fmpz_poly_clear(p);
    return sign;
}
