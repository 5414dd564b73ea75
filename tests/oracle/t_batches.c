// SPDX-License-Identifier: Apache-2.0
// Batches with partials and grids, polynomial and rational, of splines and of pieces: within the bounds that spline.h
// and bezier.h state.
#include "tests/oracle/exact.h"

#include <math.h>

#include <flint/flint.h>

enum { POINTS = 12, MOST_VARS = 3, DIM = 2 };

// What a bound is made of: n of gamma(n), and over the control points that act at a point the largest |P| and the
// ratio q of the weights.
typedef struct sizes {
    int n;
    double most, ratio;
} sizes;

typedef struct world {
    test_memory memory;
    kn_ctx *ctx;
    test_rng rng;
    exact_judge_t values, partials;
} world;

static double gamma_of(int n)
{
    return n * 0x1p-53 / (1.0 - n * 0x1p-53);
}

// Over all control points that act at `at`, component comp.
static sizes sizes_of(const kn_spline *s, const double *at, int comp, int n)
{
    size_t all = kn_spline_count(s);
    double most = 0.0, least_weight = INFINITY, most_weight = 0.0;
    for (size_t i = 0; i < all; i++) {
        size_t rest = i;
        bool acts = true;
        for (int d = s->nvars - 1; d >= 0; d--) {
            size_t k = rest % (size_t)s->count[d];
            rest /= (size_t)s->count[d];
            acts &= s->knots[d][k] <= at[d] && at[d] <= s->knots[d][k + (size_t)s->degree[d] + 1];
        }
        double w = s->rational ? s->coef[(size_t)kn_spline_dim(s) * all + i] : 1.0;
        if (!acts) continue;
        most = fmax(most, fabs(s->coef[(size_t)comp * all + i]) / w);
        least_weight = fmin(least_weight, w), most_weight = fmax(most_weight, w);
    }
    return (sizes){n, most, most_weight / least_weight};
}

// Length of the span at `at`.
static double span_length(const kn_spline *s, int d, double at)
{
    int k = s->degree[d];
    while (k + 1 < s->count[d] && s->knots[d][k + 1] <= at) k++;
    while (s->knots[d][k] == s->knots[d][k + 1]) k--; // the end of the domain
    return s->knots[d][k + 1] - s->knots[d][k];
}

// Partial `var` (-1: the value) of component comp, exactly.
static void exact_result(fmpq_t out, const kn_spline *s, const double *at, int comp, int var)
{
    exact a = exact_new(), w = exact_new();
    fmpq_t n, dn, v, dv;
    fmpq_init(n), fmpq_init(dn), fmpq_init(v), fmpq_init(dv);
    exact_of_spline(&a, s, comp, at, false);
    exact_of_spline(&w, s, kn_spline_dim(s), at, false);
    exact_value(n, &a, at), exact_value(v, &w, at);
    fmpq_div(out, n, v);
    if (var >= 0) { // (N' - (N / w) w') / w
        exact_derivative(&a, &a, var), exact_derivative(&w, &w, var);
        exact_value(dn, &a, at), exact_value(dv, &w, at);
        fmpq_mul(dv, out, dv);
        fmpq_sub(dn, dn, dv);
        fmpq_div(out, dn, v);
    }
    fmpq_clear(n), fmpq_clear(dn), fmpq_clear(v), fmpq_clear(dv);
    exact_free(&a), exact_free(&w);
}

// The bounds of the headers; 2^-40 more for the roundings in here.
static void judge(world *w, const kn_spline *s, const double *at, int comp, int var, double computed, int n)
{
    sizes z = sizes_of(s, at, comp, n);
    double bound = gamma_of(n);
    if (s->rational) assert_true(gamma_of(n + 2) * z.ratio <= 0.25);
    if (s->rational && var < 0) bound = 3 * gamma_of(n + 2) * z.ratio;
    if (s->rational && var >= 0) bound = 12 * gamma_of(n + 4) * z.ratio * z.ratio;
    if (var >= 0) bound *= 2 * s->degree[var] / span_length(s, var, at[var]);
    fmpq_t value, limit;
    fmpq_init(value), fmpq_init(limit);
    exact_result(value, s, at, comp, var);
    fmpq_of_double(limit, bound * z.most * (1.0 + 0x1p-40));
    exact_judge_bound(var < 0 ? &w->values : &w->partials, computed, value, limit);
    fmpq_clear(value), fmpq_clear(limit);
}

static void check_points(world *w, const kn_spline *s, const double *at, const double *out, int n)
{
    int vars = s->nvars, dim = kn_spline_dim(s);
    for (int i = 0; i < POINTS; i++)
        for (int k = 0; k <= vars; k++)
            for (int c = 0; c < dim; c++)
                judge(w, s, at + i * vars, c, k - 1, out[(i * (1 + vars) + k) * dim + c], n);
}

static void check_grid(world *w, const kn_spline *s, double (*axis)[2], const double *out, int n)
{
    int dim = kn_spline_dim(s);
    for (int i = 0; i < 1 << s->nvars; i++) {
        double at[MOST_VARS];
        for (int d = 0; d < s->nvars; d++) at[d] = axis[d][i >> (s->nvars - 1 - d) & 1];
        for (int c = 0; c < dim; c++) judge(w, s, at, c, -1, out[i * dim + c], n);
    }
}

static void one_spline(world *w, const kn_spline *s)
{
    double at[POINTS * MOST_VARS], out[POINTS * (1 + MOST_VARS) * DIM], axis[MOST_VARS][2];
    const double *const axes[] = {axis[0], axis[1], axis[2]};
    int n = 0;
    for (int d = 0; d < s->nvars; d++) {
        double end = s->knots[d][s->count[d]];
        n += 17 * s->degree[d] + 3;
        for (int i = 0; i < POINTS; i++) at[i * s->nvars + d] = i ? test_uniform(&w->rng, 0, end) : end;
        axis[d][0] = test_uniform(&w->rng, 0, end), axis[d][1] = end;
    }
    assert_int_equal(kn_spline_eval_batch_partials(w->ctx, out, s, POINTS, at), KN_OK);
    check_points(w, s, at, out, n);
    assert_int_equal(kn_spline_eval_grid(w->ctx, out, s, (size_t[]){2, 2, 2}, axes), KN_OK);
    check_grid(w, s, axis, out, n);
}

// b as a spline of one span is what the oracle looks at.
static void one_piece(world *w, const kn_bezier *b)
{
    double at[POINTS * MOST_VARS], out[POINTS * (1 + MOST_VARS) * DIM], axis[MOST_VARS][2];
    const double *const axes[] = {axis[0], axis[1], axis[2]};
    kn_spline s = {0};
    int n = 0;
    assert_int_equal(kn_spline_of_bezier(w->ctx, &s, b), KN_OK);
    for (int d = 0; d < b->nvars; d++) {
        n += 3 * b->degree[d] + 2;
        for (int i = 0; i < POINTS; i++) at[i * b->nvars + d] = i ? test_uniform(&w->rng, 0, 1) : 1.0;
        axis[d][0] = test_uniform(&w->rng, 0, 1), axis[d][1] = 1.0;
    }
    assert_int_equal(kn_bezier_eval_batch_partials(w->ctx, out, b, POINTS, at), KN_OK);
    check_points(w, &s, at, out, n);
    assert_int_equal(kn_bezier_eval_grid(w->ctx, out, b, (size_t[]){2, 2, 2}, axes), KN_OK);
    check_grid(w, &s, axis, out, n);
    kn_spline_clear(w->ctx, &s);
}

static void run(bool rational, bool pieces, uint64_t salt)
{
    world w = {.memory = TEST_MEMORY_INIT, .rng = test_random(salt), .values = {.name = "batch"}};
    w.partials.name = "batch, partials";
    w.ctx = test_ctx(&w.memory, 1);
    for (int round = test_scale(18); round > 0; round--) {
        int nvars = 1 + round % MOST_VARS, degree[MOST_VARS], count[MOST_VARS];
        exact_kind kind = round % 2 ? EXACT_UNIFORM : EXACT_CANCEL;
        for (int d = 0; d < nvars; d++) {
            degree[d] = test_int(&w.rng, 0, nvars > 2 ? 2 : 4);
            count[d] = degree[d] + 1 + test_int(&w.rng, 0, nvars > 2 ? 1 : 5);
        }
        if (pieces) {
            kn_bezier b;
            exact_random_bezier(w.ctx, &b, &w.rng, nvars, DIM + rational, rational, degree, kind);
            one_piece(&w, &b);
            kn_bezier_clear(w.ctx, &b);
        } else {
            kn_spline s;
            exact_random_spline(w.ctx, &s, &w.rng, nvars, DIM + rational, rational, degree, count, kind);
            one_spline(&w, &s);
            kn_spline_clear(w.ctx, &s);
        }
    }
    exact_judge_end(&w.values, 0.0);
    exact_judge_end(&w.partials, 0.0);
    test_ctx_end(w.ctx, &w.memory);
    flint_cleanup();
}

static void splines(void **state)
{
    (void)state;
    run(false, false, 1);
}

static void rational_splines(void **state)
{
    (void)state;
    run(true, false, 2);
}

static void pieces(void **state)
{
    (void)state;
    run(false, true, 3);
}

static void rational_pieces(void **state)
{
    (void)state;
    run(true, true, 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(splines), cmocka_unit_test(rational_splines),
                                       cmocka_unit_test(pieces), cmocka_unit_test(rational_pieces)};
    return cmocka_run_group_tests_name("oracle/batches", tests, NULL, NULL);
}
