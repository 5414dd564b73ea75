// SPDX-License-Identifier: Apache-2.0
// Splines: values, derivatives at points and as splines, antiderivatives, integrals: within the bounds that spline.h
// states.
#include "tests/oracle/spline_cases.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <flint/flint.h>

// ---- sums of absolute values, by the definition of the bounds ----
// |c| along var: what kn_spline_derivative's numbers become when the two terms of each difference are added; knots and
// degree one less. Lines of one variable, in rationals.
typedef struct line {
    int p, n;
    const double *t; // n + p + 1 knots
    fmpq *c;
} line;

static void difference_sums(line *a)
{
    fmpq_t h, x;
    fmpq_init(h), fmpq_init(x);
    for (int i = 0; i + 1 < a->n; i++) {
        fmpq_add(a->c + i, a->c + i, a->c + i + 1);
        fmpq_of_double(h, a->t[i + a->p + 1]);
        fmpq_of_double(x, a->t[i + 1]);
        fmpq_sub(h, h, x);
        fmpq_set_si(x, a->p, 1);
        fmpq_mul(a->c + i, a->c + i, x);
        if (fmpq_is_zero(h)) // no such coefficient
            fmpq_zero(a->c + i);
        else
            fmpq_div(a->c + i, a->c + i, h);
    }
    a->t++, a->n--, a->p--;
}

// sum_k c_k N_k(at) of a line by de Boor's algorithm, at inside the domain.
static void de_boor(fmpq_t out, const line *a, double at)
{
    int s = a->n - 1, p = a->p;
    fmpq d[KN_MAX_DEGREE + 1];
    fmpq_t lo, hi, x, u;
    fmpq_init(lo), fmpq_init(hi), fmpq_init(x), fmpq_init(u);
    fmpq_of_double(x, at);
    while (s > p && !(a->t[s] <= at && a->t[s] < a->t[s + 1])) s--;
    for (int k = 0; k <= p; k++) fmpq_init(d + k), fmpq_set(d + k, a->c + s - p + k);
    for (int m = p; m > 0; m--)
        for (int k = 0; k < m; k++) {
            int i = s - m + 1 + k;
            fmpq_of_double(lo, a->t[i]), fmpq_of_double(hi, a->t[i + m]);
            fmpq_sub(hi, hi, lo), fmpq_sub(u, x, lo);
            fmpq_div(u, u, hi); // d_k (1 - u) + d_k+1 u
            fmpq_sub(hi, d + k + 1, d + k);
            fmpq_addmul(d + k, hi, u);
        }
    fmpq_set(out, d);
    for (int k = 0; k <= p; k++) fmpq_clear(d + k);
    fmpq_clear(lo), fmpq_clear(hi), fmpq_clear(x), fmpq_clear(u);
}

// The sum of absolute values in the derivative order[] at a point, one variable after the other.
static void size_at(fmpq_t out, const kn_spline *s, const double *at, const int *order)
{
    size_t n = kn_spline_count(s);
    fmpq *c = _fmpq_vec_init((slong)n);
    for (size_t i = 0; i < n; i++) fmpq_of_double(c + i, fabs(s->coef[i]));
    for (int d = s->nvars - 1; d >= 0; d--) {
        size_t m = (size_t)s->count[d];
        n /= m;
        for (size_t i = 0; i < n; i++) {
            fmpq_t value;
            line a = {s->degree[d], s->count[d], s->knots[d], c + i * m};
            fmpq_init(value);
            for (int k = 0; k < order[d] && a.p > 0; k++) difference_sums(&a);
            if (order[d] <= s->degree[d]) de_boor(value, &a, at[d]);
            fmpq_swap(c + i, value);
            fmpq_clear(value);
        }
    }
    fmpq_set(out, c);
    _fmpq_vec_clear(c, (slong)kn_spline_count(s));
}

static void value_at(fmpq_t out, const kn_spline *s, const double *at, const int *order)
{
    exact p = exact_new();
    exact_of_spline(&p, s, 0, at, false);
    for (int d = 0; d < s->nvars; d++)
        for (int k = 0; k < order[d]; k++) exact_derivative(&p, &p, d);
    exact_value(out, &p, at);
    exact_free(&p);
}

static void random_point(spline_world *w, double *at, const kn_spline *a)
{
    for (int d = 0; d < a->nvars; d++) {
        double lo, hi;
        kn_spline_domain(a, d, &lo, &hi);
        at[d] = test_uniform(&w->rng, lo, hi);
    }
}

static int value_roundings(const kn_spline *a)
{
    int n = 0;
    for (int d = 0; d < a->nvars; d++) n += 6 * a->degree[d] + 1;
    return n;
}

enum { POINTS = 6 };

static void value(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *a)
{
    static const int none[3] = {0};
    double at[3 * POINTS], out;
    (void)kind;
    for (int k = 0; k < POINTS; k++) {
        random_point(w, at, a);
        assert_int_equal(kn_spline_eval(w->ctx, &out, a, at), KN_OK);
        value_at(w->x, a, at, none);
        size_at(w->s, a, at, none);
        exact_judge_one(judge, out, w->x, w->s, value_roundings(a));
    }
}

static void derivative(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *a)
{
    double at[3], out[40];
    int order = test_int(&w->rng, 1, 3);
    (void)kind;
    random_point(w, at, a);
    assert_int_equal(kn_spline_derivatives(w->ctx, out, a, at, order), KN_OK);
    for (int k = 0; k < 6; k++) {
        int index[KN_MAX_VARS] = {0}, left = order;
        for (int d = 0; d < a->nvars; d++) left -= index[d] = test_int(&w->rng, 0, left);
        value_at(w->x, a, at, index);
        size_at(w->s, a, at, index);
        int taken = 0; // each order saves a rounding
        for (int d = 0; d < a->nvars; d++) taken += index[d] <= a->degree[d] ? index[d] : 0;
        exact_judge_one(judge, out[kn_derivative_index(a->nvars, index)], w->x, w->s, value_roundings(a) - taken);
    }
}

// max |c| over the control points that act: in the header's bound for batches.
static void most_acting(fmpq_t out, const kn_spline *s, const double *at)
{
    size_t n = kn_spline_count(s);
    double most = 0.0;
    for (size_t i = 0; i < n; i++) {
        size_t rest = i;
        bool acts = true;
        for (int d = s->nvars - 1; d >= 0; d--) {
            size_t k = rest % (size_t)s->count[d];
            rest /= (size_t)s->count[d];
            acts &= s->knots[d][k] <= at[d] && at[d] <= s->knots[d][k + (size_t)s->degree[d] + 1];
        }
        if (acts) most = fmax(most, fabs(s->coef[i]));
    }
    fmpq_of_double(out, most);
}

static void batch(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *a)
{
    static const int none[3] = {0};
    double at[3 * POINTS], out[POINTS];
    int roundings = 0;
    (void)kind;
    for (int k = 0; k < POINTS; k++) random_point(w, at + k * a->nvars, a);
    for (int d = 0; d < a->nvars; d++) roundings += 17 * a->degree[d] + 3;
    assert_int_equal(kn_spline_eval_batch(w->ctx, out, a, POINTS, at), KN_OK);
    for (int k = 0; k < POINTS; k++) {
        value_at(w->x, a, at + k * a->nvars, none);
        most_acting(w->s, a, at + k * a->nvars);
        exact_judge_one(judge, out[k], w->x, w->s, roundings);
    }
}

static void run(uint64_t salt, const char *name, spline_case body, double slack)
{
    spline_world w;
    spline_begin(&w, salt);
    exact_judge_t judge = {.name = name};
    spline_for_all(&w, &judge, body);
    exact_judge_end(&judge, slack);
    spline_end(&w);
}

static void values(void **state)
{
    (void)state;
    run(1, "spline_eval", value, 100.0);
}

static void derivatives(void **state)
{
    (void)state;
    run(2, "spline_derivatives", derivative, 100.0);
}

static void batches(void **state)
{
    (void)state;
    run(3, "spline_eval_batch", batch, 0.0);
}

// ---- derivatives and antiderivatives as splines ----
typedef struct change {
    const kn_spline *s;
    int var;
} change;

static void derivative_piece(exact *out, const double *at, void *user)
{
    const change *f = user;
    exact_of_spline(out, f->s, 0, at, false);
    exact_derivative(out, out, f->var);
}

// Lines along var of an array of a's counts: sums for differences.
static void derivative_sizes(exact *out, const kn_spline *a, int var, const kn_spline *r)
{
    int shape[KN_MAX_VARS];
    for (int d = 0; d < r->nvars; d++) shape[d] = r->count[d] - 1;
    exact_shape(out, r->nvars, shape);
    size_t inner = 1, outer = 1, n = (size_t)a->count[var], rows = (size_t)r->count[var];
    for (int d = var + 1; d < a->nvars; d++) inner *= (size_t)a->count[d];
    for (int d = 0; d < var; d++) outer *= (size_t)a->count[d];
    fmpq *c = _fmpq_vec_init((slong)n);
    for (size_t o = 0; o < outer; o++)
        for (size_t j = 0; j < inner; j++) {
            line l = {a->degree[var], a->count[var], a->knots[var], c};
            for (size_t i = 0; i < n; i++) fmpq_of_double(c + i, fabs(a->coef[(o * n + i) * inner + j]));
            difference_sums(&l);
            size_t row = 0;
            for (size_t i = 0; i + 1 < n; i++) // coefficients over empty intervals do not exist
                if (a->knots[var][i + 1] < a->knots[var][i + (size_t)a->degree[var] + 1])
                    exact_set(out, (o * rows + row++) * inner + j, c + i);
            assert_int_equal(row, rows);
        }
    _fmpq_vec_clear(c, (slong)n);
}

static void differentiate(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *a)
{
    kn_spline r = {0};
    int var = test_int(&w->rng, 0, a->nvars - 1);
    change f = {a, var};
    (void)kind;
    if (a->degree[var] == 0) return;
    assert_int_equal(kn_spline_derivative(w->ctx, &r, a, var), KN_OK);
    exact_spline_coefs(&w->value, &r, derivative_piece, &f);
    derivative_sizes(&w->size, a, var, &r);
    exact_judge(judge, r.coef, &w->value, &w->size, NULL, 4);
    kn_spline_clear(w->ctx, &r);
}

static void derivative_splines(void **state)
{
    (void)state;
    run(4, "spline_derivative", differentiate, 100.0);
}

// The integral of the spline over the box: piece by piece, by antiderivatives of polynomials.
static void integral_of(fmpq_t out, const kn_spline *s, int var, double *lo, double *hi)
{
    if (var < s->nvars) {
        const double *t = s->knots[var];
        for (int k = s->degree[var]; k < s->count[var]; k++)
            if (t[k] < t[k + 1]) {
                lo[var] = t[k], hi[var] = t[k + 1];
                integral_of(out, s, var + 1, lo, hi);
            }
        return;
    }
    exact p = exact_new();
    fmpq_t x;
    fmpq_init(x);
    exact_of_spline(&p, s, 0, lo, false);
    for (int d = 0; d < s->nvars; d++) exact_antiderivative(&p, &p, d);
    double at[3];
    for (int corner = 0; corner < 1 << s->nvars; corner++) {
        int low = 0;
        for (int d = 0; d < s->nvars; d++) {
            at[d] = corner >> d & 1 ? lo[d] : hi[d];
            low += corner >> d & 1;
        }
        exact_value(x, &p, at);
        if (low % 2) fmpq_neg(x, x);
        fmpq_add(out, out, x);
    }
    exact_free(&p), fmpq_clear(x);
}

// sum |c_k| prod (t_k+p+1 - t_k)/(p + 1): the integral of |a|, whose B-splines are positive.
static void integral(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *a)
{
    kn_spline absolute = {0};
    double out, lo[3], hi[3];
    int roundings = 1;
    (void)kind;
    assert_int_equal(kn_spline_integral(w->ctx, &out, a), KN_OK);
    assert_int_equal(kn_spline_copy(w->ctx, &absolute, a), KN_OK);
    size_t n = kn_spline_count(a);
    for (size_t i = 0; i < n; i++) absolute.coef[i] = fabs(a->coef[i]);
    fmpq_zero(w->x), fmpq_zero(w->s);
    integral_of(w->x, a, 0, lo, hi);
    integral_of(w->s, &absolute, 0, lo, hi);
    for (int d = 0; d < a->nvars; d++) roundings += a->count[d] + 2;
    exact_judge_one(judge, out, w->x, w->s, roundings);
    kn_spline_clear(w->ctx, &absolute);
}

static void integrals(void **state)
{
    (void)state;
    run(5, "spline_integral", integral, 100.0);
}

// The integral of a curve from the start of its domain, on the piece that begins at `at`.
static void antiderivative_piece(exact *out, const double *at, void *user)
{
    const change *f = user;
    const double *t = f->s->knots[0];
    exact p = exact_new(), c = exact_new();
    fmpq_t sum, x;
    fmpq_init(sum), fmpq_init(x);
    for (int k = f->s->degree[0]; t[k] < at[0]; k++) {
        if (t[k] == t[k + 1]) continue;
        exact_of_spline(&p, f->s, 0, t + k, false);
        exact_antiderivative(&p, &p, 0);
        exact_value(x, &p, t + k + 1);
        fmpq_add(sum, sum, x);
        exact_value(x, &p, t + k);
        fmpq_sub(sum, sum, x);
    }
    exact_of_spline(&p, f->s, 0, at, false);
    exact_antiderivative(&p, &p, 0);
    exact_value(x, &p, at);
    fmpq_sub(sum, sum, x);
    exact_constant(&c, 1, 1.0);
    exact_scale(&c, &c, sum);
    exact_add(out, &p, &c);
    exact_free(&p), exact_free(&c), fmpq_clear(sum), fmpq_clear(x);
}

// gamma(k + 2) sum_(i<k) |c_i| (t_i+p+1 - t_i)/(p + 1).
static void integrate(spline_world *w, exact_judge_t *judge, exact_kind kind, const kn_spline *a)
{
    kn_spline r = {0};
    change f = {a, 0};
    (void)kind;
    if (a->nvars > 1) return;
    assert_int_equal(kn_spline_antiderivative(w->ctx, &r, a, 0), KN_OK);
    exact_spline_coefs(&w->value, &r, antiderivative_piece, &f);
    int p = a->degree[0];
    fmpq_t x, h;
    fmpq_init(x), fmpq_init(h);
    fmpq_zero(w->s);
    assert_true(r.coef[0] == 0.0);
    for (int k = 1; k < r.count[0]; k++) {
        fmpq_of_double(h, a->knots[0][k + p]), fmpq_of_double(x, a->knots[0][k - 1]);
        fmpq_sub(h, h, x);
        fmpq_div_fmpz(h, h, (fmpz_t){p + 1});
        fmpq_of_double(x, fabs(a->coef[k - 1]));
        fmpq_addmul(w->s, x, h);
        exact_get(w->x, &w->value, (size_t)k);
        exact_judge_one(judge, r.coef[k], w->x, w->s, k + 2);
    }
    fmpq_clear(x), fmpq_clear(h);
    kn_spline_clear(w->ctx, &r);
}

static void antiderivatives(void **state)
{
    (void)state;
    run(6, "spline_antiderivative", integrate, 100.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values),    cmocka_unit_test(derivatives),        cmocka_unit_test(batches),
        cmocka_unit_test(integrals), cmocka_unit_test(derivative_splines), cmocka_unit_test(antiderivatives),
    };
    int failed = cmocka_run_group_tests_name("oracle/spline_values", tests, NULL, NULL);
    flint_cleanup();
    return failed;
}
