// SPDX-License-Identifier: Apache-2.0
// Random splines for the oracle's tests, and sums of them as piecewise polynomials.
#include "tests/oracle/spline_cases.h"

#include <math.h>

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
        for (int kind = 0; kind < EXACT_KINDS; kind++)
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
