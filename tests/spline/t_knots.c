// SPDX-License-Identifier: Apache-2.0
// Knot insertion, subdivision, restriction, and Bezier pieces there and back.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/spline/oracle.h"
#include "tests/support/support.h"

static kn_spline curve(kn_ctx *ctx, int degree, int count, const double *knots, const double *coef)
{
    kn_spline s;
    const double *const k[] = {knots};
    assert_int_equal(kn_spline_init(ctx, &s, 1, 1, false, &degree, &count, k, coef), KN_OK);
    return s;
}

static void assert_numbers(const double *a, const double *b, int n)
{
    for (int i = 0; i < n; i++) assert_true(a[i] == b[i]);
}

static kn_spline random_any(kn_ctx *ctx, test_rng *rng, int nvars)
{
    int degree[KN_MAX_VARS], count[KN_MAX_VARS];
    for (int d = 0; d < nvars; d++) {
        degree[d] = test_int(rng, 0, nvars > 2 ? 3 : 5);
        count[d] = degree[d] + 1 + test_int(rng, 0, nvars > 2 ? 3 : 6);
    }
    kn_spline s;
    bool rational = test_int(rng, 0, 1);
    test_random_spline(ctx, &s, rng, nvars, test_int(rng, 2, 4), rational, degree, count, 9);
    return s;
}

// A map of one variable has terms of at most 5 p + 2 roundings, and sums p + 1 of them.
static int map_operations(const kn_spline *s)
{
    int n = 1;
    for (int d = 0; d < s->nvars; d++) n += 6 * s->degree[d] + 3;
    return n;
}

// Midpoints into a quadratic: Chaikin's corner cutting, 3/4 1/4, exact in doubles; at the clamped ends 1/2 1/2.
static void chaikin(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 0, 1, 2, 3, 4, 4, 4}, coef[] = {8, -16, 24, 0, 40, -8};
    const double middle[] = {3.5, 0.5, 2.5, 1.5};
    const double to[] = {0, 0, 0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4, 4, 4};
    const double expected[] = {8, -4, -6, 14, 18, 6, 10, 30, 16, -8};
    kn_spline s = curve(ctx, 2, 6, knots, coef);
    assert_int_equal(kn_spline_insert_knots(ctx, &s, &s, 0, middle, 4), KN_OK); // in place
    assert_int_equal(s.count[0], 10);
    assert_numbers(s.knots[0], to, 13);
    assert_numbers(s.coef, expected, 10);
    assert_int_equal(kn_spline_insert_knots(ctx, &s, &s, 0, NULL, 0), KN_OK);
    assert_numbers(s.coef, expected, 10);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void insertion_keeps_the_function(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = test_scale(20); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3), var = test_int(&rng, 0, nvars - 1);
        kn_spline s = random_any(ctx, &rng, nvars), t = {0};
        double lo, hi, knots[6];
        kn_spline_domain(&s, var, &lo, &hi);
        int n = test_int(&rng, 1, 6);
        for (int i = 0; i < n; i++) knots[i] = test_uniform(&rng, lo + 1e-3, hi - 1e-3);
        if (s.degree[var] > 0 && n > 1) knots[1] = knots[0];
        assert_int_equal(kn_spline_insert_knots(ctx, &t, &s, var, knots, n), KN_OK);
        assert_int_equal(kn_spline_check(ctx, &t), KN_OK);
        assert_int_equal(t.count[var], s.count[var] + n);
        oracle_assert_same(&s, &t, 1, 5, 0.0, map_operations(&s));
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &t);
    }
    test_ctx_end(ctx, &memory);
}

static void insertion_refuses(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 0, 1, 2, 2, 2}, coef[] = {1, 2, 3, 4};
    kn_spline s = curve(ctx, 2, 4, knots, coef), out = {0}, empty = {0};
    const double bad[] = {0, 2, -1, 3, NAN, INFINITY};
    for (int i = 0; i < 6; i++) assert_int_equal(kn_spline_insert_knots(ctx, &out, &s, 0, bad + i, 1), KN_EDOMAIN);
    assert_int_equal(kn_spline_insert_knots(ctx, &out, &s, 0, (double[]){1, 1, 1}, 3), KN_EDOMAIN); // 4 times
    assert_int_equal(kn_spline_insert_knots(ctx, &out, &s, 1, (double[]){1}, 1), KN_EDOMAIN);
    assert_int_equal(kn_spline_insert_knots(ctx, &out, &s, -1, (double[]){1}, 1), KN_EDOMAIN);
    assert_int_equal(kn_spline_insert_knots(ctx, &out, &s, 0, NULL, -1), KN_EDOMAIN);
    assert_int_equal(kn_spline_insert_knots(ctx, &out, &empty, 0, NULL, 0), KN_EDOMAIN);
    assert_int_equal(kn_spline_insert_knots(ctx, &out, &s, 0, NULL, 1 << 29), KN_ELIMIT);
    assert_int_equal(out.nvars, 0);
    assert_int_equal(kn_spline_insert_knots(ctx, &out, &s, 0, (double[]){1, 1}, 2), KN_OK); // 3 = degree + 1 times
    assert_int_equal(out.count[0], 6);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

// The pieces of u^2 with a knot at 1: polar forms at (a,a) (a,b) (b,b), exact; the common coefficient is one number.
static void exact_pieces(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 0, 1, 2, 2, 2}, coef[] = {0, 0, 2, 4};
    const double left[] = {0, 0, 1}, right[] = {1, 2, 4};
    kn_spline s = curve(ctx, 2, 4, knots, coef);
    kn_bezier *pieces;
    size_t n;
    assert_int_equal(kn_spline_to_bezier(ctx, &pieces, &n, &s), KN_OK);
    assert_int_equal(n, 2);
    assert_numbers(pieces[0].coef, left, 3);
    assert_numbers(pieces[1].coef, right, 3);
    for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

typedef struct grid {
    int n[KN_MAX_VARS], continuity[KN_MAX_VARS];
    double breaks[KN_MAX_VARS][16];
    const double *at[KN_MAX_VARS];
} grid;

// The breaks of s, and the lowest continuity in each variable.
static void grid_of(grid *g, const kn_spline *s)
{
    for (int d = 0; d < s->nvars; d++) {
        g->n[d] = 0, g->continuity[d] = s->degree[d] - 1, g->at[d] = g->breaks[d];
        int last = s->count[d] + s->degree[d], run = 1;
        for (int i = 0; i <= last; i++, run++) {
            if (i < last && s->knots[d][i] == s->knots[d][i + 1]) continue;
            bool inside = s->knots[d][i] > s->knots[d][0] && s->knots[d][i] < s->knots[d][last];
            if (inside && s->degree[d] - run < g->continuity[d]) g->continuity[d] = s->degree[d] - run;
            g->breaks[d][g->n[d]++] = s->knots[d][i];
            run = 0;
        }
    }
}

// Each piece against the oracle at random points of its box; the faces of neighbours bit for bit.
static void pieces_have_the_values(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    for (int round = test_scale(20); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3);
        kn_spline s = random_any(ctx, &rng, nvars), p = {0};
        kn_bezier *pieces;
        size_t n, total = 1;
        grid g;
        grid_of(&g, &s);
        for (int d = 0; d < nvars; d++) total *= (size_t)g.n[d] - 1;
        assert_int_equal(kn_spline_to_bezier(ctx, &pieces, &n, &s), KN_OK);
        assert_int_equal(n, total);
        for (size_t i = 0; i < n; i++) {
            size_t rest = i;
            double at[3], unit[3];
            for (int d = nvars - 1; d >= 0; d--) {
                size_t k = rest % ((size_t)g.n[d] - 1);
                rest /= (size_t)g.n[d] - 1;
                unit[d] = test_int(&rng, 0, 8) / 8.0; // exact on integer knots
                at[d] = g.breaks[d][k] + unit[d] * (g.breaks[d][k + 1] - g.breaks[d][k]);
                if (unit[d] == 1.0) unit[d] = 0.875, at[d] -= 0.125 * (g.breaks[d][k + 1] - g.breaks[d][k]);
            }
            long double a[4], b[4], size[4];
            assert_int_equal(kn_spline_of_bezier(ctx, &p, &pieces[i]), KN_OK);
            oracle_homogeneous(a, size, &s, at, NULL, NULL);
            oracle_homogeneous(b, NULL, &p, unit, NULL, NULL);
            for (int c = 0; c < s.ncomp; c++)
                assert_true(fabsl(a[c] - b[c]) <= oracle_gamma(map_operations(&s)) * size[c]);
            kn_spline_clear(ctx, &p);
        }
        for (size_t i = 0; nvars == 1 && g.continuity[0] >= 0 && i + 1 < n; i++)
            for (int c = 0; c < s.ncomp; c++) {
                size_t m = kn_bezier_count(&pieces[i]);
                assert_memory_equal(&pieces[i].coef[((size_t)c + 1) * m - 1], &pieces[i + 1].coef[(size_t)c * m],
                                    sizeof(double));
            }
        for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
        kn_free(ctx, pieces);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// Faces of neighbours in a surface: the last row of one is the first row of the next, bit for bit, both ways.
static void shared_edges(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double k[] = {0, 0, 0, 0, 0.1, 0.7, 0.7, 1.3, 3, 3, 3, 3};
    const double *const knots[] = {k, k};
    double coef[64];
    for (int i = 0; i < 64; i++) coef[i] = sin(i * i + 0.3);
    kn_spline s;
    kn_bezier *b;
    size_t n;
    assert_int_equal(kn_spline_init(ctx, &s, 2, 1, false, (int[]){3, 3}, (int[]){8, 8}, knots, coef), KN_OK);
    assert_int_equal(kn_spline_to_bezier(ctx, &b, &n, &s), KN_OK);
    assert_int_equal(n, 16);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 3; j++)
            for (int q = 0; q < 4; q++) {
                assert_true(b[4 * i + j].coef[4 * q + 3] == b[4 * i + j + 1].coef[4 * q]); // along v
                assert_true(b[4 * j + i].coef[12 + q] == b[4 * j + 4 + i].coef[q]);        // along u
            }
    for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &b[i]);
    kn_free(ctx, b);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// to_bezier, then from_bezier at the lowest continuity of each variable: the same function. A coefficient's arguments
// lie within one span of the piece that serves best, and integer spans have lengths 1 .. 3 here, so that each of the
// p levels multiplies by at most |x| + |1-x| <= 1 + 2 * 3 = 7 where all p arguments lie outside; the best piece has
// at least half of them inside: amplification at most 7^(p/2) < 4^p.
static void there_and_back(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    for (int round = test_scale(20); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3);
        kn_spline s = random_any(ctx, &rng, nvars), t = {0};
        kn_bezier *pieces;
        size_t n;
        grid g;
        grid_of(&g, &s);
        assert_int_equal(kn_spline_to_bezier(ctx, &pieces, &n, &s), KN_OK);
        assert_int_equal(kn_spline_from_bezier(ctx, &t, pieces, g.n, g.at, g.continuity), KN_OK);
        if (!s.rational) assert_int_equal(kn_spline_check(ctx, &t), KN_OK);
        double amplify = 1;
        for (int d = 0; d < nvars; d++) amplify *= pow(4.0, s.degree[d]);
        oracle_assert_same(&s, &t, 2, 5, 0.0, (int)(2 * map_operations(&s) * amplify));
        for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
        kn_free(ctx, pieces);
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &t);
    }
    test_ctx_end(ctx, &memory);
}

// Simple knots 0 1 2 ... and a quadratic with even coefficients: every step is exact, and the coefficients return.
static void exact_return(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double k[] = {0, 0, 0, 1, 2, 3, 4, 4, 4}, breaks[] = {0, 1, 2, 3, 4};
    const double *const knots[] = {k, k}, *const b[] = {breaks, breaks};
    double coef[72];
    for (int i = 0; i < 72; i++) coef[i] = 4 * ((i * i * 7) % 23 - 11);
    kn_spline s, t = {0};
    kn_bezier *pieces;
    size_t n;
    assert_int_equal(kn_spline_init(ctx, &s, 2, 2, false, (int[]){2, 2}, (int[]){6, 6}, knots, coef), KN_OK);
    assert_int_equal(kn_spline_to_bezier(ctx, &pieces, &n, &s), KN_OK);
    assert_int_equal(kn_spline_from_bezier(ctx, &t, pieces, (int[]){5, 5}, b, (int[]){1, 1}), KN_OK);
    assert_int_equal(t.count[0], 6);
    assert_numbers(t.knots[1], k, 9);
    assert_numbers(t.coef, coef, 72);
    kn_spline_clear(ctx, &t);
    assert_int_equal(kn_spline_from_bezier(ctx, &t, pieces, (int[]){5, 5}, b, (int[]){0, -1}), KN_OK);
    assert_int_equal(t.count[0], 9); // 4 pieces of degree 2, shared ends
    assert_int_equal(t.count[1], 12);
    // where pieces disagree the lower one counts
    pieces[4].coef[0] += 1000;
    kn_spline_clear(ctx, &t);
    assert_int_equal(kn_spline_from_bezier(ctx, &t, pieces, (int[]){5, 5}, b, (int[]){0, 0}), KN_OK);
    assert_true(t.coef[2 * 9] == pieces[0].coef[6]);
    for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &t);
    test_ctx_end(ctx, &memory);
}

static void from_bezier_refuses(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_bezier p[2] = {{0}};
    kn_spline out = {0};
    const double good[] = {0, 1, 2}, same[] = {0, 1, 1}, nan[] = {0, NAN, 2}, inf[] = {0, 1, INFINITY};
    const double *const at[] = {good}, *const bad[][1] = {{same}, {nan}, {inf}};
    int n = 3, one = 1, c = 1, minus = -2, two = 2;
    assert_int_equal(kn_spline_from_bezier(ctx, &out, p, &n, at, &c), KN_EDOMAIN); // an empty piece
    assert_int_equal(kn_bezier_init(ctx, &p[0], 1, 1, false, &two), KN_OK);
    assert_int_equal(kn_spline_from_bezier(ctx, &out, p, &n, at, &c), KN_EDOMAIN); // the second one is empty
    assert_int_equal(kn_bezier_init(ctx, &p[1], 1, 1, false, &one), KN_OK);
    assert_int_equal(kn_spline_from_bezier(ctx, &out, p, &n, at, &c), KN_EDOMAIN); // other degree
    kn_bezier_clear(ctx, &p[1]);
    assert_int_equal(kn_bezier_init(ctx, &p[1], 1, 1, false, &two), KN_OK);
    assert_int_equal(kn_spline_from_bezier(ctx, &out, p, &one, at, &c), KN_EDOMAIN);
    assert_int_equal(kn_spline_from_bezier(ctx, &out, p, &n, at, &minus), KN_EDOMAIN);
    assert_int_equal(kn_spline_from_bezier(ctx, &out, p, &n, at, &two), KN_EDOMAIN);
    for (int i = 0; i < 3; i++) assert_int_equal(kn_spline_from_bezier(ctx, &out, p, &n, bad[i], &c), KN_EDOMAIN);
    assert_int_equal(kn_spline_from_bezier(ctx, &out, p, (int[]){1 << 30}, at, &c), KN_ELIMIT);
    assert_int_equal(out.nvars, 0);
    assert_int_equal(kn_spline_from_bezier(ctx, &out, p, &n, at, &c), KN_OK);
    assert_int_equal(kn_spline_to_bezier(ctx, &(kn_bezier *){NULL}, &(size_t){0}, &(kn_spline){0}), KN_EDOMAIN);
    kn_spline_clear(ctx, &out);
    kn_bezier constant = {0};
    assert_int_equal(kn_spline_of_bezier(ctx, &out, &constant), KN_OK); // empty to empty
    assert_int_equal(out.nvars, 0);
    assert_int_equal(kn_bezier_init(ctx, &constant, 0, 1, false, NULL), KN_OK);
    assert_int_equal(kn_spline_of_bezier(ctx, &out, &constant), KN_EDOMAIN);
    kn_bezier_clear(ctx, &constant);
    kn_bezier_clear(ctx, &p[0]);
    kn_bezier_clear(ctx, &p[1]);
    test_ctx_end(ctx, &memory);
}

static void restrictions(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    for (int round = test_scale(30); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3);
        kn_spline s = random_any(ctx, &rng, nvars), t = {0};
        double lo[3], hi[3];
        for (int d = 0; d < nvars; d++) {
            double a, b;
            kn_spline_domain(&s, d, &a, &b);
            lo[d] = test_int(&rng, 0, 1) ? s.knots[d][test_int(&rng, 0, s.count[d] - 1)] : test_uniform(&rng, a, b);
            hi[d] = lo[d] + test_uniform(&rng, 0.1, 1.0) * (b - a);
            if (hi[d] > b) hi[d] = b;
            if (test_int(&rng, 0, 3) == 0) lo[d] -= 0.25;
            if (test_int(&rng, 0, 3) == 0 || lo[d] >= hi[d]) hi[d] += 0.25;
        }
        assert_int_equal(kn_spline_restrict(ctx, &t, &s, lo, hi), KN_OK);
        for (int d = 0; d < nvars; d++) {
            double a, b;
            kn_spline_domain(&t, d, &a, &b);
            assert_true(a == lo[d] && b == hi[d]);
        }
        // beyond the domain the absolute sums of t hide what cancelled on the way: by |x| + |1-x| <= 1 + 2/4 a level
        // on spans of length >= 1, both for the recurrence and for the arguments
        double amplify = 1;
        for (int d = 0; d < nvars; d++) amplify *= pow(3.0, s.degree[d]);
        oracle_assert_same(&t, &s, 3, 5, 0.0, (int)(map_operations(&s) * amplify));
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &t);
    }
    test_ctx_end(ctx, &memory);
}

// u^2 with knots at 1, 2, 3: over any box the coefficients are the polar form xy at neighbouring knots, exact.
static void exact_restrictions(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 0, 1, 2, 3, 4, 4, 4}, coef[] = {0, 0, 2, 6, 12, 16};
    kn_spline s = curve(ctx, 2, 6, knots, coef), t = {0}, u = {0}, empty = {0};
    double lo = -2, hi = 0.5;
    assert_int_equal(kn_spline_restrict(ctx, &t, &s, &lo, &hi), KN_OK);
    assert_int_equal(t.count[0], 3);
    assert_numbers(t.coef, (double[]){4, -1, 0.25}, 3);
    lo = 5, hi = 8;
    assert_int_equal(kn_spline_restrict(ctx, &t, &s, &lo, &hi), KN_OK); // over an old result
    assert_int_equal(t.count[0], 3);
    assert_numbers(t.coef, (double[]){25, 40, 64}, 3);
    lo = -1, hi = 8;
    assert_int_equal(kn_spline_restrict(ctx, &t, &s, &lo, &hi), KN_OK);
    assert_int_equal(t.count[0], 6);
    assert_numbers(t.knots[0], (double[]){-1, -1, -1, 1, 2, 3, 8, 8, 8}, 9);
    assert_numbers(t.coef, (double[]){1, -1, 2, 6, 24, 64}, 6);
    assert_int_equal(kn_spline_subdivide(ctx, &t, &u, &s, 0, 2.5), KN_OK);
    assert_numbers(t.knots[0], (double[]){0, 0, 0, 1, 2, 2.5, 2.5, 2.5}, 8);
    assert_numbers(t.coef, (double[]){0, 0, 2, 5, 6.25}, 5);
    assert_numbers(u.knots[0], (double[]){2.5, 2.5, 2.5, 3, 4, 4, 4}, 7);
    assert_numbers(u.coef, (double[]){6.25, 7.5, 12, 16}, 4);
    assert_int_equal(kn_spline_subdivide(ctx, &s, &u, &s, 0, 3.0), KN_OK); // at a knot, in place
    assert_numbers(s.coef, (double[]){0, 0, 2, 6, 9}, 5);
    assert_numbers(u.coef, (double[]){9, 12, 16}, 3);

    const double bad[][2] = {{1, 1}, {2, 1}, {NAN, 1}, {0, INFINITY}};
    for (int i = 0; i < 4; i++) assert_int_equal(kn_spline_restrict(ctx, &t, &s, &bad[i][0], &bad[i][1]), KN_EDOMAIN);
    assert_int_equal(kn_spline_restrict(ctx, &t, &empty, &lo, &hi), KN_EDOMAIN);
    assert_int_equal(kn_spline_subdivide(ctx, &t, &u, &s, 1, 1.0), KN_EDOMAIN);
    const double ends[] = {0, 3, -1, 5, NAN};
    for (int i = 0; i < 5; i++) assert_int_equal(kn_spline_subdivide(ctx, &t, &u, &s, 0, ends[i]), KN_EDOMAIN);
    assert_numbers(u.coef, (double[]){9, 12, 16}, 3);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &t);
    kn_spline_clear(ctx, &u);
    test_ctx_end(ctx, &memory);
}

// Too many coefficients are refused before anything is allocated, however much the call would need on the way.
static void limits_come_first(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    enum { COUNT = 64, MANY = 1 << 16 };
    double axis[COUNT + 2], *knots = calloc(MANY, sizeof *knots);
    const double *const k[] = {axis, axis, axis};
    kn_spline s, out = {0};
    assert_non_null(knots);
    for (int i = 0; i < COUNT + 2; i++) axis[i] = i < 1 ? 0 : i > COUNT ? COUNT - 1 : i - 1;
    for (int i = 0; i < MANY; i++) knots[i] = (i + 0.5) / MANY;
    assert_int_equal(kn_spline_init(ctx, &s, 3, 1, false, (int[]){1, 1, 1}, (int[]){COUNT, COUNT, COUNT}, k, NULL),
                     KN_OK);
    size_t before = kn_ctx_counters(ctx).allocations;
    assert_int_equal(kn_spline_insert_knots(ctx, &out, &s, 0, knots, MANY), KN_ELIMIT); // 2^12 (2^16 + 2^6)
    assert_int_equal(kn_spline_elevate(ctx, &out, &s, (int[]){20, 20, 20}), KN_ELIMIT); // more than 1200^3
    assert_int_equal(kn_ctx_counters(ctx).allocations, before);
    kn_spline_clear(ctx, &s);
    free(knots);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(limits_come_first),
        cmocka_unit_test(chaikin),
        cmocka_unit_test(insertion_keeps_the_function),
        cmocka_unit_test(insertion_refuses),
        cmocka_unit_test(exact_pieces),
        cmocka_unit_test(pieces_have_the_values),
        cmocka_unit_test(shared_edges),
        cmocka_unit_test(there_and_back),
        cmocka_unit_test(exact_return),
        cmocka_unit_test(from_bezier_refuses),
        cmocka_unit_test(restrictions),
        cmocka_unit_test(exact_restrictions),
    };
    return cmocka_run_group_tests_name("spline/knots", tests, NULL, NULL);
}
