// SPDX-License-Identifier: Apache-2.0
// Boxes, oriented boxes and Lipschitz bounds against exact arithmetic: never violated, over all kinds of coefficients;
// boxes over parts contain the exact coefficients there, and are wider by no more than twice the bound that is stated.
#include "tests/oracle/exact.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <flint/flint.h>

typedef struct world {
    test_memory memory;
    kn_ctx *ctx;
    test_rng rng;
    exact part[3]; // two components and the weight
    fmpq_t x, y, bound;
    long cases;
} world;

static void begin(world *w, uint64_t salt)
{
    *w = (world){.memory = TEST_MEMORY_INIT, .rng = test_random(salt)};
    w->ctx = test_ctx(&w->memory, 1);
    for (int i = 0; i < 3; i++) w->part[i] = exact_new();
    fmpq_init(w->x), fmpq_init(w->y), fmpq_init(w->bound);
}

static void end(world *w, const char *what, long least)
{
    printf("# %s: %ld cases, none outside\n", what, w->cases);
    assert_true(w->cases >= test_scale((int)least));
    for (int i = 0; i < 3; i++) exact_free(&w->part[i]);
    fmpq_clear(w->x), fmpq_clear(w->y), fmpq_clear(w->bound);
    test_ctx_end(w->ctx, &w->memory);
}

// lo <= num / den <= hi for den > 0.
static void assert_inside(world *w, double lo, const fmpq_t num, const fmpq_t den, double hi)
{
    double side[2] = {lo, hi};
    for (int i = 0; i < 2; i++) {
        if (!isfinite(side[i])) continue; // never the wrong infinity: the other side would fail
        fmpq_of_double(w->bound, side[i]);
        fmpq_mul(w->bound, w->bound, den);
        int order = fmpq_cmp(w->bound, num);
        if (i == 0 ? order > 0 : order < 0) fail_msg("case %ld lies outside [%.17g, %.17g]", w->cases, lo, hi);
    }
    assert_true(lo < INFINITY && hi > -INFINITY);
    w->cases++;
}

static void random_interval(world *w, double *lo, double *hi, int kind)
{
    double a = test_uniform(&w->rng, 0, 1), b = test_uniform(&w->rng, 0, 1);
    *lo = fmin(a, b), *hi = fmax(a, b);
    if (kind == 1) *hi = *lo + 1e-9 * (1.0 - *lo);
    if (kind == 2) *hi = *lo;
    if (kind == 3) *lo = -0.5 * *lo, *hi = 1.0 + 0.5 * *hi;
    if (kind == 4) *lo = 0.0;
    if (kind == 5) *lo = 0.0, *hi = 1.0;
}

// A random piece of two components, its exact components and weight (1 when polynomial).
static kn_bezier random_piece(world *w, int most_vars, int most_degree)
{
    int nvars = test_int(&w->rng, 1, most_vars), degree[2];
    bool rational = test_int(&w->rng, 0, 1);
    kn_bezier a;
    for (int d = 0; d < nvars; d++) degree[d] = test_int(&w->rng, 1, nvars > 1 ? most_degree / 2 : most_degree);
    exact_random_bezier(w->ctx, &a, &w->rng, nvars, 2 + rational, rational, degree,
                        (exact_kind)test_int(&w->rng, 0, EXACT_KINDS - 1));
    for (int c = 0; c <= 2; c++) exact_of_bezier(&w->part[c], &a, c, false);
    return a;
}

static void boxes(void **state)
{
    (void)state;
    world w;
    begin(&w, 1);
    for (int round = test_scale(1100); round > 0; round--) {
        kn_bezier a = random_piece(&w, 2, 4);
        for (int kind = 0; kind < 6; kind++) {
            double lo[2], hi[2], least[2], most[2], at[2];
            for (int d = 0; d < a.nvars; d++) random_interval(&w, &lo[d], &hi[d], kind == 3 && a.rational ? 0 : kind);
            assert_int_equal(kn_bezier_box(w.ctx, least, most, &a, lo, hi), KN_OK);
            for (int i = 0; i < 8; i++) {
                for (int d = 0; d < a.nvars; d++) {
                    double x = test_uniform(&w.rng, lo[d], hi[d]);
                    at[d] = i == 0 ? lo[d] : i == 1 ? hi[d] : fmin(fmax(x, lo[d]), hi[d]);
                }
                exact_value(w.y, &w.part[2], at);
                for (int c = 0; c < 2; c++) {
                    exact_value(w.x, &w.part[c], at);
                    assert_inside(&w, least[c], w.x, w.y, most[c]);
                }
            }
        }
        kn_bezier_clear(w.ctx, &a);
    }
    end(&w, "boxes", 100000);
}

// Of a polynomial piece: the exact Bernstein coefficients lie in the box, and the box's ends beyond the extreme ones by
// at most twice gamma(sum_d (5 n_d + 2) + 4) max_k sum_j M_kj |p_j| (once for the rounding that the box covers, once for
// that which happened), and an ulp. The bound must not be slack against what happened either: within 100 in the median.
static void widths(void **state)
{
    (void)state;
    world w;
    begin(&w, 2);
    exact size = exact_new();
    exact_judge_t judge = {.name = "restriction in a box"};
    for (int round = test_scale(300); round > 0; round--) {
        kn_bezier a, piece = {0};
        int nvars = test_int(&w.rng, 1, 2), degree[2], roundings = 4;
        double lo[2], hi[2], least, most, extreme[2] = {INFINITY, -INFINITY}, top = 0.0;
        for (int d = 0; d < nvars; d++) degree[d] = test_int(&w.rng, 1, nvars > 1 ? 3 : 6);
        exact_random_bezier(w.ctx, &a, &w.rng, nvars, 1, false, degree, (exact_kind)(round % EXACT_KINDS));
        exact_of_bezier(&w.part[0], &a, 0, false);
        exact_of_bezier(&size, &a, 0, true);
        for (int d = 0; d < nvars; d++) {
            random_interval(&w, &lo[d], &hi[d], round % 2);
            exact_substitute(&w.part[0], &w.part[0], d, lo[d], hi[d]);
            exact_substitute(&size, &size, d, lo[d], hi[d]);
            roundings += 5 * degree[d] + 2;
        }
        exact_bernstein(&w.part[0], &w.part[0], degree);
        exact_bernstein(&size, &size, degree);
        assert_int_equal(kn_bezier_box(w.ctx, &least, &most, &a, lo, hi), KN_OK);
        assert_int_equal(kn_bezier_restrict(w.ctx, &piece, &a, lo, hi), KN_OK);
        exact_judge(&judge, piece.coef, &w.part[0], &size, NULL, roundings);
        fmpq_one(w.y);
        for (size_t i = 0; i < exact_count(&w.part[0]); i++) {
            exact_get(w.x, &w.part[0], i);
            assert_inside(&w, least, w.x, w.y, most);
            extreme[0] = fmin(extreme[0], fmpq_get_d(w.x)), extreme[1] = fmax(extreme[1], fmpq_get_d(w.x));
            exact_get(w.x, &size, i);
            top = fmax(top, fmpq_get_d(w.x));
        }
        double slack = 2.0 * (roundings + 4) * DBL_EPSILON / 2 * top;
        assert_true(extreme[0] - least <= slack + 4 * DBL_EPSILON * fabs(least));
        assert_true(most - extreme[1] <= slack + 4 * DBL_EPSILON * fabs(most));
        kn_bezier_clear(w.ctx, &a);
        kn_bezier_clear(w.ctx, &piece);
    }
    exact_free(&size);
    exact_judge_end(&judge, 100.0);
    end(&w, "exact coefficients in boxes", 1000);
}

// |f'|^2 <= bound^2, f' of two components: for rationals ((N' w - w' N)_0^2 + ()_1^2) <= bound^2 w^4.
static void assert_slope(world *w, double bound, exact *const *part, exact *const *slope, const double *at)
{
    fmpq_t v[3], d[3], sum, t;
    fmpq_init(sum), fmpq_init(t);
    for (int c = 0; c < 3; c++) {
        fmpq_init(v[c]), fmpq_init(d[c]);
        exact_value(v[c], part[c], at);
        exact_value(d[c], slope[c], at);
    }
    for (int c = 0; c < 2; c++) {
        fmpq_mul(t, d[c], v[2]);
        fmpq_submul(t, d[2], v[c]);
        fmpq_addmul(sum, t, t);
    }
    fmpq_of_double(t, bound);
    for (int i = 0; i < 2; i++) fmpq_mul(t, t, v[2]);
    fmpq_mul(t, t, t);
    if (fmpq_cmp(sum, t) > 0) fail_msg("case %ld is steeper than %.17g", w->cases, bound);
    for (int c = 0; c < 3; c++) fmpq_clear(v[c]), fmpq_clear(d[c]);
    fmpq_clear(sum), fmpq_clear(t);
    w->cases++;
}

// N' w - w' N cancels most of what it is made of.
static void move_far_away(world *w, kn_bezier *a)
{
    size_t n = kn_bezier_count(a);
    for (size_t k = 0; k < 2 * n; k++) a->coef[k] = a->coef[2 * n + k % n] * (0x1p40 + test_uniform(&w->rng, -1, 1));
    for (int c = 0; c < 2; c++) exact_of_bezier(&w->part[c], a, c, false);
}

static void slopes(void **state)
{
    (void)state;
    world w;
    begin(&w, 3);
    exact s[3] = {exact_new(), exact_new(), exact_new()};
    for (int round = test_scale(1000); round > 0; round--) {
        kn_bezier a = random_piece(&w, 2, 4);
        double bound[2], at[2];
        if (a.rational && round % 2) move_far_away(&w, &a);
        assert_int_equal(kn_bezier_lipschitz(w.ctx, bound, &a), KN_OK);
        for (int v = 0; v < a.nvars; v++) {
            for (int c = 0; c < 3; c++) exact_derivative(&s[c], &w.part[c], v);
            for (int i = 0; i < 8; i++) {
                for (int d = 0; d < a.nvars; d++) at[d] = i < 4 ? (i >> d) % 2 : test_uniform(&w.rng, 0, 1);
                assert_slope(&w, bound[v], (exact *const[]){&w.part[0], &w.part[1], &w.part[2]},
                             (exact *const[]){&s[0], &s[1], &s[2]}, at);
            }
        }
        kn_bezier_clear(w.ctx, &a);
    }
    for (int c = 0; c < 3; c++) exact_free(&s[c]);
    end(&w, "slopes", 10000);
}

static void minor(fmpq_t out, const fmpq_t a, const fmpq_t b, const fmpq_t c, const fmpq_t d)
{
    fmpq_mul(out, a, d);
    fmpq_submul(out, b, c);
}

// A s = x - center by Cramer's rule, A the axes as stored: |s_i| <= half_i.
static void assert_in_box(world *w, const kn_oriented_box *box, fmpq_t *x)
{
    fmpq_t m[3][3], cof[3], det, sum, t;
    fmpq_init(det), fmpq_init(sum), fmpq_init(t);
    for (int i = 0; i < 3; i++) {
        fmpq_init(cof[i]);
        fmpq_of_double(t, box->center[i]);
        fmpq_sub(x[i], x[i], t);
        for (int j = 0; j < 3; j++) {
            fmpq_init(m[i][j]);
            fmpq_of_double(m[i][j], box->axis[i][j]); // rows are axes: s_i is the solution of the transposed system
        }
    }
    for (int i = 0; i < 3; i++) { // s_i = (x . (a_j x a_k)) / (a_i . (a_j x a_k))
        int j = (i + 1) % 3, k = (i + 2) % 3;
        fmpq_zero(det), fmpq_zero(sum);
        for (int c = 0; c < 3; c++) {
            int p = (c + 1) % 3, q = (c + 2) % 3;
            minor(cof[c], m[j][p], m[j][q], m[k][p], m[k][q]);
            fmpq_addmul(det, m[i][c], cof[c]);
            fmpq_addmul(sum, x[c], cof[c]);
        }
        fmpq_div(t, sum, det);
        fmpq_abs(t, t);
        fmpq_of_double(sum, box->half[i]);
        if (fmpq_cmp(t, sum) > 0) fail_msg("case %ld: outside along axis %d, half %.17g", w->cases, i, box->half[i]);
    }
    for (int i = 0; i < 3; i++) {
        fmpq_clear(cof[i]);
        for (int j = 0; j < 3; j++) fmpq_clear(m[i][j]);
    }
    fmpq_clear(det), fmpq_clear(sum), fmpq_clear(t);
    w->cases++;
}

// All control points: what they are in is convex, and so contains the piece. Every kind of coefficients, far away and
// nearly flat ones among them.
static void oriented_boxes(void **state)
{
    (void)state;
    world w;
    begin(&w, 4);
    fmpq_t x[3];
    for (int i = 0; i < 3; i++) fmpq_init(x[i]);
    for (int round = test_scale(1200); round > 0; round--) {
        int dim = test_int(&w.rng, 2, 3), nvars = test_int(&w.rng, 1, 2);
        bool rational = test_int(&w.rng, 0, 1), flat = test_int(&w.rng, 0, 1);
        kn_bezier a;
        kn_oriented_box box;
        exact_random_bezier(w.ctx, &a, &w.rng, nvars, dim + rational, rational, (int[]){3, 2},
                            (exact_kind)(round % EXACT_KINDS));
        size_t n = kn_bezier_count(&a);
        for (size_t k = 0; k < n && flat; k++) // on a line but for rounding
            for (size_t c = 1; c < (size_t)dim; c++) a.coef[c * n + k] = a.coef[k] * (0.1 + (double)c / 3);
        assert_int_equal(kn_bezier_oriented_box(w.ctx, &box, &a), KN_OK);
        for (size_t k = 0; k < n; k++) {
            fmpq_one(w.y);
            if (rational) fmpq_of_double(w.y, a.coef[(size_t)dim * n + k]);
            for (int i = 0; i < 3; i++) {
                fmpq_of_double(x[i], i < dim ? a.coef[(size_t)i * n + k] : 0.0);
                fmpq_div(x[i], x[i], w.y);
            }
            assert_in_box(&w, &box, x);
        }
        kn_bezier_clear(w.ctx, &a);
    }
    for (int i = 0; i < 3; i++) fmpq_clear(x[i]);
    end(&w, "points in oriented boxes", 5000);
}

// Boxes of splines over parts of the domain, and their Lipschitz bounds.
static void splines(void **state)
{
    (void)state;
    world w;
    begin(&w, 5);
    exact s[3] = {exact_new(), exact_new(), exact_new()};
    for (int round = test_scale(300); round > 0; round--) {
        int nvars = test_int(&w.rng, 1, 2), degree[2], count[2];
        bool rational = test_int(&w.rng, 0, 1);
        for (int d = 0; d < nvars; d++)
            degree[d] = test_int(&w.rng, 1, 3), count[d] = degree[d] + test_int(&w.rng, 1, 4);
        kn_spline a;
        exact_random_spline(w.ctx, &a, &w.rng, nvars, 2 + rational, rational, degree, count,
                            (exact_kind)test_int(&w.rng, 0, EXACT_KINDS - 1));
        double lo[2], hi[2], least[2], most[2], slope[2], at[2];
        for (int d = 0; d < nvars; d++) {
            double from, to, x, y;
            kn_spline_domain(&a, d, &from, &to);
            random_interval(&w, &x, &y, round % 3);
            lo[d] = from + x * (to - from);
            hi[d] = fmin(fmax(from + y * (to - from), lo[d]), to);
        }
        assert_int_equal(kn_spline_box_over(w.ctx, least, most, &a, lo, hi), KN_OK);
        assert_int_equal(kn_spline_lipschitz(w.ctx, slope, &a), KN_OK);
        for (int i = 0; i < 6; i++) {
            for (int d = 0; d < nvars; d++) {
                double x = test_uniform(&w.rng, lo[d], hi[d]);
                at[d] = i == 0 ? lo[d] : i == 1 ? hi[d] : fmin(fmax(x, lo[d]), hi[d]);
            }
            for (int c = 0; c < 3; c++) exact_of_spline(&w.part[c], &a, c, at, false);
            exact_value(w.y, &w.part[2], at);
            for (int c = 0; c < 2; c++) {
                exact_value(w.x, &w.part[c], at);
                assert_inside(&w, least[c], w.x, w.y, most[c]);
            }
            for (int v = 0; v < nvars; v++) {
                for (int c = 0; c < 3; c++) exact_derivative(&s[c], &w.part[c], v);
                assert_slope(&w, slope[v], (exact *const[]){&w.part[0], &w.part[1], &w.part[2]},
                             (exact *const[]){&s[0], &s[1], &s[2]}, at);
            }
        }
        kn_spline_clear(w.ctx, &a);
    }
    for (int c = 0; c < 3; c++) exact_free(&s[c]);
    end(&w, "values and slopes of splines", 5000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes),          cmocka_unit_test(widths),  cmocka_unit_test(slopes),
        cmocka_unit_test(oriented_boxes), cmocka_unit_test(splines),
    };
    int failed = cmocka_run_group_tests_name("oracle/bounds", tests, NULL, NULL);
    flint_cleanup();
    return failed;
}
