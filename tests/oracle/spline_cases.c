// SPDX-License-Identifier: Apache-2.0
// Random splines for the oracle's tests, and sums of them as piecewise polynomials.
#include "tests/oracle/spline_cases.h"

#include <math.h>
#include <stdlib.h>

#include <flint/fmpq_vec.h>

// Degrees, and interior knots in each variable.
typedef struct shape {
    int nvars, degree[3], interior, rounds;
} shape;

static const shape SHAPES[] = {
    {1, {0}, 4, 1},  {1, {1}, 5, 1},    {1, {3}, 8, 3},    {1, {5}, 6, 2},
    {1, {12}, 3, 1}, {2, {3, 3}, 3, 1}, {2, {2, 4}, 2, 1}, {3, {2, 1, 2}, 1, 1},
};
enum { NSHAPES = sizeof SHAPES / sizeof *SHAPES };

void spline_begin(spline_world *w, uint64_t salt)
{
    *w = (spline_world){
        .memory = TEST_MEMORY_INIT, .rng = test_random(salt), .value = exact_new(), .size = exact_new()};
    w->ctx = test_ctx(&w->memory, 1);
    fmpq_init(w->x), fmpq_init(w->s);
}

void spline_end(spline_world *w)
{
    exact_free(&w->value), exact_free(&w->size);
    fmpq_clear(w->x), fmpq_clear(w->s);
    test_ctx_end(w->ctx, &w->memory);
}

void spline_for_all(spline_world *w, exact_judge_t *judge, spline_case body)
{
    for (int i = 0; i < NSHAPES; i++)
        for (exact_kind kind = EXACT_INTEGERS; kind < EXACT_KINDS; kind++)
            for (int round = test_scale(SHAPES[i].rounds); round > 0; round--) {
                const shape *s = &SHAPES[i];
                kn_spline a;
                int count[3];
                for (int d = 0; d < 3; d++) count[d] = s->degree[d] + 1 + s->interior;
                exact_random_spline(w->ctx, &a, &w->rng, s->nvars, 1, false, s->degree, count, kind);
                for (int d = 0; d < s->nvars && kind == EXACT_UNIFORM; d++) // knots apart by anything
                    for (int k = 0, n = count[d] + s->degree[d] + 1; k < n; k++)
                        a.knots[d][k] = sqrt(a.knots[d][k] + 0.01);
                body(w, judge, kind, &a);
                kn_spline_clear(w->ctx, &a);
            }
}

static void one_piece(exact *out, const spline_sum *f, int i, const double *at)
{
    fmpq_t x;
    fmpq_init(x);
    fmpq_set_si(x, f->absolute && f->times[i] > 0 ? f->times[i] : 1, 1);
    exact_of_spline(out, f->s[i], 0, at, f->absolute);
    exact_scale(out, out, x);
    fmpq_clear(x);
}

static void sum_piece(exact *out, const double *at, void *user)
{
    const spline_sum *f = user;
    one_piece(out, f, 0, at);
    if (!f->s[1]) return;
    exact b = exact_new();
    one_piece(&b, f, 1, at);
    (f->minus ? exact_sub : exact_add)(out, out, &b);
    exact_free(&b);
}

void spline_judge_sum(spline_world *w, exact_judge_t *judge, const kn_spline *r, spline_sum f, const int *roundings,
                      int all)
{
    exact_spline_coefs(&w->value, r, sum_piece, &f);
    f.absolute = true, f.minus = false;
    exact_spline_coefs(&w->size, r, sum_piece, &f);
    exact_judge(judge, r->coef, &w->value, &w->size, roundings, all);
}

// The polar form of a Bezier piece over [lo,hi] at args: its weights, or those of the absolute values of its factors;
// the sum of their absolute values.
static double blossom(double *w, int p, double lo, double hi, const double *args, bool absolute)
{
    double sum = 0.0;
    w[0] = 1.0;
    for (int m = 1; m <= p; m++)
        for (int k = m; k >= 0; k--) {
            double down = (hi - args[m - 1]) / (hi - lo), up = (args[m - 1] - lo) / (hi - lo);
            if (absolute) down = fabs(down), up = fabs(up);
            w[k] = (k < m ? down * w[k] : 0.0) + (k > 0 ? up * w[k - 1] : 0.0);
        }
    for (int k = 0; k <= p; k++) sum += fabs(w[k]);
    return sum;
}

// Of the pieces in the support of coefficient j the first with the smallest sum, and its weights.
static void choose_piece(exact *row, double *from, double *to, const kn_spline *r, int var, int j)
{
    const double *t = r->knots[var];
    int p = r->degree[var], form[2] = {0, p};
    double w[KN_MAX_DEGREE + 2], best = INFINITY;
    for (int k = j; k <= j + p; k++) {
        double sum = t[k] < t[k + 1] ? blossom(w, p, t[k], t[k + 1], t + j + 1, false) : INFINITY;
        if (sum < best * (1.0 - 1e-9)) best = sum, *from = t[k], *to = t[k + 1];
    }
    blossom(w, p, *from, *to, t + j + 1, true);
    exact_of_array(row, 2, form, w, false);
}

static int times_among(const kn_spline *s, int var, double knot)
{
    int n = 0;
    for (int i = 0; i <= s->count[var] + s->degree[var]; i++) n += s->knots[var][i] == knot;
    return n;
}

// The most knots of s that are new among the arguments of a coefficient of the piece over [lo,hi], p - k times lo and
// k times hi.
static int fresh_knots(const kn_spline *s, int var, double lo, double hi)
{
    int p = s->degree[var], at_lo = times_among(s, var, lo), at_hi = times_among(s, var, hi), most = 0;
    for (int k = 0; k <= p; k++) {
        int fresh = (p - k > at_lo ? p - k - at_lo : 0) + (k > at_hi ? k - at_hi : 0);
        most = fresh > most ? fresh : most;
    }
    return most;
}

// Of coefficient j the maps to the piece from each operand of the term, and back: 6 x + 1 for x levels, 0 for none.
static int map_roundings(const kn_spline *r, int var, int j, const spline_term *term)
{
    double lo, hi;
    int n = 0, between = 0;
    exact row = exact_new();
    choose_piece(&row, &lo, &hi, r, var, j);
    exact_free(&row);
    for (int i = 0; i < 3 && term->s[i]; i++) {
        int fresh = fresh_knots(term->s[i], var, lo, hi);
        n += fresh > 0 ? 6 * fresh + 1 : 0;
    }
    for (int i = j + 1; i <= j + r->degree[var]; i++) between += r->knots[var][i] != lo && r->knots[var][i] != hi;
    return n + (between > 0 ? 6 * between + 1 : 0);
}

static int *all_roundings(const kn_spline *r, const spline_term *term, int more)
{
    size_t n = kn_spline_count(r);
    int *roundings = malloc(n * sizeof *roundings), index[KN_MAX_VARS] = {0}, *of[KN_MAX_VARS] = {NULL};
    assert_non_null(roundings);
    for (int d = 0; d < r->nvars; d++) {
        of[d] = malloc((size_t)r->count[d] * sizeof *of[d]);
        assert_non_null(of[d]);
        for (int j = 0; j < r->count[d]; j++) of[d][j] = map_roundings(r, d, j, term);
    }
    for (size_t i = 0; i < n; i++) {
        roundings[i] = more;
        for (int d = 0; d < r->nvars; d++) roundings[i] += of[d][index[d]];
        for (int d = r->nvars - 1; d >= 0 && ++index[d] >= r->count[d]; d--) index[d] = 0;
    }
    for (int d = 0; d < r->nvars; d++) free(of[d]);
    return roundings;
}

void spline_join_sizes(exact *out, const kn_spline *r, exact_piece f, void *user)
{
    int index[KN_MAX_VARS] = {0}, size[KN_MAX_VARS], d;
    double at[KN_MAX_VARS], to[KN_MAX_VARS], last[KN_MAX_VARS] = {0};
    exact piece = exact_new(), value = exact_new(), row[KN_MAX_VARS];
    size_t n = kn_spline_count(r);
    fmpq *all = _fmpq_vec_init((slong)n);
    for (d = 0; d < r->nvars; d++) row[d] = exact_new(), size[d] = r->count[d] - 1;
    for (size_t i = 0; i < n; i++) {
        bool same = i > 0;
        for (d = 0; d < r->nvars; d++) {
            choose_piece(&row[d], &at[d], &to[d], r, d, index[d]);
            same &= at[d] == last[d];
            last[d] = at[d];
        }
        if (!same) {
            f(&piece, at, user);
            for (d = 0; d < r->nvars; d++) exact_substitute(&piece, &piece, d, at[d], to[d]);
            exact_bernstein(&piece, &piece, r->degree);
        }
        exact_copy(&value, &piece);
        for (d = 0; d < r->nvars; d++) exact_map(&value, &value, d, &row[d]);
        exact_get(all + i, &value, 0);
        for (d = r->nvars - 1; d >= 0 && ++index[d] > size[d]; d--) index[d] = 0;
    }
    exact_of_fractions(out, r->nvars, size, all);
    _fmpq_vec_clear(all, (slong)n);
    for (d = 0; d < r->nvars; d++) exact_free(&row[d]);
    exact_free(&piece), exact_free(&value);
}

int spline_fresh_arguments(const kn_spline *r, const kn_spline *a, int var)
{
    int most = 0;
    for (int j = 0; j < r->count[var]; j++) {
        const double *t = r->knots[var];
        int fresh = 0;
        for (int i = j + 1; i <= j + r->degree[var]; i++) {
            int times = 0, here = 0; // in a, and up to i
            for (int k = 0; k <= a->count[var] + a->degree[var]; k++) times += a->knots[var][k] == t[i];
            for (int k = j + 1; k <= i; k++) here += t[k] == t[i];
            fresh += here > times;
        }
        most = fresh > most ? fresh : most;
    }
    return most;
}

typedef struct formula {
    const spline_term *terms;
    int n;
    bool absolute;
} formula;

static void formula_piece(exact *out, const double *at, void *user)
{
    const formula *f = user;
    exact v = exact_new(), x = exact_new();
    int nvars = f->terms[0].s[0]->nvars;
    exact_constant(out, nvars, 0.0);
    for (int t = 0; t < f->n; t++) {
        const spline_term *term = &f->terms[t];
        exact_constant(&v, nvars, f->absolute ? 1.0 : term->sign);
        for (int i = 0; i < 3 && term->s[i]; i++) {
            exact_of_spline(&x, term->s[i], term->comp[i], at, f->absolute);
            exact_mul(&v, &v, &x);
        }
        exact_add(out, out, &v);
    }
    exact_free(&v), exact_free(&x);
}

void spline_exact_terms(exact *out, const kn_spline *r, const spline_term *terms, int nterms)
{
    formula f = {terms, nterms, false};
    exact_spline_coefs(out, r, formula_piece, &f);
}

void spline_judge_terms(spline_world *w, exact_judge_t *judge, const kn_spline *r, int comp, const spline_term *terms,
                        int nterms, int roundings)
{
    formula f = {terms, nterms, false};
    exact_spline_coefs(&w->value, r, formula_piece, &f);
    f.absolute = true;
    spline_join_sizes(&w->size, r, formula_piece, &f);
    int *all = all_roundings(r, terms, roundings);
    exact_judge(judge, r->coef + (size_t)comp * kn_spline_count(r), &w->value, &w->size, all, 0);
    free(all);
}
