// SPDX-License-Identifier: Apache-2.0
// Knot removal, exact and within a tolerance, and merging.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kernel/knots.h"
#include "tests/spline/oracle.h"
#include "tests/support/support.h"

static void assert_numbers(const double *a, const double *b, size_t n)
{
    for (size_t i = 0; i < n; i++) assert_true(a[i] == b[i]);
}

static void assert_equal(const kn_spline *a, const kn_spline *b)
{
    assert_int_equal(a->nvars, b->nvars);
    assert_int_equal(a->ncomp, b->ncomp);
    assert_true(a->rational == b->rational);
    for (int d = 0; d < a->nvars; d++) {
        assert_int_equal(a->degree[d], b->degree[d]);
        assert_int_equal(a->count[d], b->count[d]);
        assert_numbers(a->knots[d], b->knots[d], (size_t)(a->count[d] + a->degree[d] + 1));
    }
    assert_numbers(a->coef, b->coef, kn_spline_count(a) * (size_t)a->ncomp);
}

// Knots 0 1 2 .. at multiplicity degree - 1 (1 for degrees below 2): differences of up to `degree` neighbours that are
// not 0 are 1 or 2, so that all weights are dyadic. Coefficients are integers.
static void dyadic(kn_ctx *ctx, kn_spline *s, test_rng *rng, int nvars, int ncomp, bool rational)
{
    double knots[3][64], coef[4096];
    const double *const k[] = {knots[0], knots[1], knots[2]};
    int degree[3], count[3];
    for (int d = 0; d < nvars; d++) {
        int p = degree[d] = test_int(rng, 0, nvars > 1 ? 3 : 5), n = 0, times = p < 2 ? 1 : p - 1;
        for (int b = 0; b <= 4; b++)
            for (int i = b == 0 || b == 4 ? p + 1 : times; i > 0; i--) knots[d][n++] = b;
        count[d] = n - p - 1;
    }
    for (int i = 0; i < 4096; i++) coef[i] = test_int(rng, 1, 50);
    assert_int_equal(kn_spline_init(ctx, s, nvars, ncomp, rational, degree, count, k, coef), KN_OK);
}

static void insertion_is_undone(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = test_scale(60); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3), var = test_int(&rng, 0, nvars - 1), n = 0;
        kn_spline s, t = {0}, lean = {0};
        bool rational = test_int(&rng, 0, 1);
        dyadic(ctx, &s, &rng, nvars, test_int(&rng, 2, 3), rational);
        // the integers need not be removable: what can be removed of s itself goes first
        double knots[16], error = -1;
        assert_int_equal(kn_spline_remove_knots(ctx, &lean, &error, &s, var, 0), KN_OK);
        assert_true(error == 0);
        for (int i = 0; i < 4; i++)
            for (int k = test_int(&rng, -1, s.degree[var] < 3 ? s.degree[var] + 1 : 3); k > 0; k--)
                knots[n++] = i + 0.25 * test_int(&rng, 1, 3);
        for (int i = 0; i < n; i++)
            for (int k = i + 1, same = 1; k < n; k++)
                if (knots[k] == knots[i] && ++same > s.degree[var] + 1) knots[k--] = knots[--n];
        assert_int_equal(kn_spline_insert_knots(ctx, &t, &s, var, knots, n), KN_OK);
        assert_int_equal(kn_spline_remove_knots(ctx, &t, &error, &t, var, 0), KN_OK); // in place
        assert_true(error == 0);
        assert_equal(&t, &lean);
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &t);
        kn_spline_clear(ctx, &lean);
    }
    test_ctx_end(ctx, &memory);
}

// Knots anywhere, at any scale: insertion rounds by gamma(6 p + 1) of 9 times the scale, so that within 1e-12 of it all
// that was put there can go again. Spans of 1e-7 beside those of 1, and knots at which there is a jump, are among them.
static void rounded_insertion_is_undone(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    for (int round = test_scale(60); round > 0; round--) {
        int p = test_int(&rng, 1, 4), count = p + 1 + test_int(&rng, 0, 8);
        double scale = ldexp(1, test_int(&rng, -300, 300)), knots[8], error = -1;
        kn_spline s, jump = {0}, t = {0};
        test_random_spline(ctx, &s, &rng, 1, 2, false, &p, &count, 9);
        for (int i = 0; i < 2 * count; i++) s.coef[i] *= scale;
        double lo, hi, at;
        kn_spline_domain(&s, 0, &lo, &hi);
        at = 0.5 * (lo + hi);
        int have = 0;
        for (int i = 0; i < count + p + 1; i++) have += s.knots[0][i] == at;
        for (int i = 0; i < p + 1 - have; i++) knots[i] = at;
        assert_int_equal(kn_spline_insert_knots(ctx, &jump, &s, 0, knots, p + 1 - have), KN_OK);
        for (int i = 0; i < jump.count[0]; i++) // a jump in the middle
            if (jump.knots[0][i] >= at) jump.coef[i] += 50 * scale;
        int plain = jump.count[0];
        for (int i = 0; i < 8; i++) knots[i] = test_uniform(&rng, lo + 1e-3, hi - 1e-3);
        knots[6] = knots[7] + 1e-7, knots[5] = knots[4];
        assert_int_equal(kn_spline_insert_knots(ctx, &t, &jump, 0, knots, 8), KN_OK);
        assert_int_equal(kn_spline_remove_knots(ctx, &t, &error, &t, 0, 1e-12 * 59 * scale), KN_OK);
        assert_true(error <= 1e-12 * 59 * scale && t.count[0] <= plain);
        int times = 0;
        for (int i = 0; i < t.count[0] + p + 1; i++) times += t.knots[0][i] == at;
        assert_int_equal(times, p + 1); // the jump stays
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &jump);
        kn_spline_clear(ctx, &t);
    }
    test_ctx_end(ctx, &memory);
}

// A parabola over four spans: its three interior knots go, and f(x,y) = xy, 3 - (x + y)/2 is left.
static void knots_that_mean_nothing(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double k[] = {0, 0, 0, 1, 1, 1, 2, 3, 3, 4, 4, 4};
    const double *const knots[] = {k};
    double coef[18];
    for (int i = 0; i < 9; i++) coef[i] = k[i + 1] * k[i + 2], coef[9 + i] = 3 - (k[i + 1] + k[i + 2]) / 2;
    kn_spline s, t = {0};
    assert_int_equal(kn_spline_init(ctx, &s, 1, 2, false, (int[]){2}, (int[]){9}, knots, coef), KN_OK);
    assert_int_equal(kn_spline_remove_knots(ctx, &t, NULL, &s, 0, 0), KN_OK);
    assert_int_equal(t.count[0], 3);
    assert_numbers(t.coef, (double[]){0, 0, 16, 3, 1, -1}, 6);
    for (int i = 3; i < 9; i++) s.coef[i] += 1; // a jump at 1
    assert_int_equal(kn_spline_remove_knots(ctx, &t, NULL, &s, 0, 0), KN_OK);
    assert_int_equal(t.count[0], 6);
    assert_numbers(t.knots[0], (double[]){0, 0, 0, 1, 1, 1}, 6);
    double error;
    assert_int_equal(kn_spline_remove_knots(ctx, &t, &error, &s, 0, 0.75), KN_OK); // it moves by 1/2 on both sides
    assert_true(error <= 0.75 && error >= 0.5);
    assert_true(t.count[0] < 6);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &t);
    test_ctx_end(ctx, &memory);
}

// A smooth function's spline with far too many knots, uneven, some of them double, at any scale.
static void smooth(kn_ctx *ctx, kn_spline *s, test_rng *rng, int nvars, bool rational, double scale)
{
    double knots[2][128], coef[8192];
    const double *const k[] = {knots[0], knots[1]};
    int degree[2], count[2] = {1, 1};
    for (int d = 0; d < nvars; d++) {
        int p = degree[d] = test_int(rng, 1, 4), spans = nvars > 1 ? 8 : 60, m = 0;
        double at = 0;
        for (int i = 0; i <= p; i++) knots[d][m++] = 0;
        for (int i = 1; i < spans; i++) {
            at += test_int(rng, 0, 9) == 0 ? 1e-7 : test_uniform(rng, 0.5, 1.5);
            knots[d][m++] = at;
            if (p > 1 && test_int(rng, 0, 9) == 0) knots[d][m++] = at;
        }
        for (int i = 0; i <= p; i++) knots[d][m++] = at + 1;
        count[d] = m - p - 1;
    }
    int total = count[0] * count[1], comps = 2 + rational;
    double phase = test_uniform(rng, 0, 6);
    for (int i = 0; i < total; i++) {
        double u = 0, v = 0;
        int iu = nvars > 1 ? i / count[1] : i, iv = nvars > 1 ? i % count[1] : 0;
        for (int q = 1; q <= degree[0]; q++) u += knots[0][iu + q] / degree[0];
        for (int q = 1; nvars > 1 && q <= degree[1]; q++) v += knots[1][iv + q] / degree[1];
        double w = rational ? 1.5 + cos(u / 9 + v / 7) : 1;
        coef[i] = scale * w * (u + v), coef[total + i] = scale * w * sin(u / 6 + v / 5 + phase);
        if (rational) coef[2 * total + i] = w;
    }
    assert_int_equal(kn_spline_init(ctx, s, nvars, comps, rational, degree, count, k, coef), KN_OK);
}

static void within_a_tolerance(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    enum { ROUNDS = 40 };
    double slack[ROUNDS];
    int n = 0;
    for (int round = 0; round < ROUNDS; round++) {
        const double scales[] = {1, 1, 1e150, 1e-120};
        double scale = scales[round % 4], tolerance = scale * pow(10, test_uniform(&rng, -6, -1)), error = -1;
        kn_spline s, t = {0};
        smooth(ctx, &s, &rng, test_int(&rng, 1, 2), round % 3 == 0, scale);
        assert_int_equal(kn_spline_remove_knots(ctx, &t, &error, &s, 0, tolerance), KN_OK);
        assert_int_equal(kn_spline_check(ctx, &t), KN_OK);
        assert_true(error >= 0 && error <= tolerance);
        double true_error = oracle_sampled_distance(&s, &t, &rng, 400);
        assert_true(true_error <= error);
        if (true_error > 0) slack[n++] = error / true_error;
        double again;
        kn_spline u = {0};
        assert_int_equal(kn_spline_remove_knots(ctx, &u, &again, &s, 0, INFINITY), KN_OK); // all may go
        assert_true(oracle_sampled_distance(&s, &u, &rng, 50) <= again);
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &t);
        kn_spline_clear(ctx, &u);
    }
    qsort(slack, (size_t)n, sizeof *slack, kn_knots_by_value);
    assert_true(n > ROUNDS / 2);
    printf("# bound / largest sample: median %.2f\n", slack[n / 2]);
    assert_true(slack[n / 2] <= 100);
    test_ctx_end(ctx, &memory);
}

// sin(t/6) over [0,60] by cubics: the error of a spline on even knots is about h^4 / (384 6^4), so that 1e-3 needs
// h = 4.7, 16 coefficients; greedy removal from h = 1/2 may take a few more.
static void few_knots_are_left(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double k[127], coef[123], error;
    for (int i = 0; i < 127; i++) k[i] = i < 4 ? 0 : i > 122 ? 60 : (i - 3) / 2.0;
    for (int i = 0; i < 123; i++) coef[i] = sin((k[i + 1] + k[i + 2] + k[i + 3]) / 18);
    kn_spline s;
    assert_int_equal(kn_spline_init(ctx, &s, 1, 1, false, (int[]){3}, (int[]){123}, (const double *const[]){k}, coef),
                     KN_OK);
    assert_int_equal(kn_spline_remove_knots(ctx, &s, &error, &s, 0, 1e-3), KN_OK);
    printf("# %d of 123 coefficients kept\n", s.count[0]);
    assert_true(error <= 1e-3 && s.count[0] <= 30);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void removal_refuses(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s, out = {0};
    double error = 7;
    const double k[] = {0, 0, 1, 2, 2};
    const double *const knots[] = {k};
    assert_int_equal(kn_spline_init(ctx, &s, 1, 2, true, (int[]){1}, (int[]){3}, knots, (double[]){1, 2, 5, 1, 0, 1}),
                     KN_OK);
    assert_int_equal(kn_spline_remove_knots(ctx, &out, &error, &s, 1, 0), KN_EDOMAIN);
    assert_int_equal(kn_spline_remove_knots(ctx, &out, &error, &s, 0, -1), KN_EDOMAIN);
    assert_int_equal(kn_spline_remove_knots(ctx, &out, &error, &s, 0, NAN), KN_EDOMAIN);
    assert_int_equal(kn_spline_remove_knots(ctx, &out, &error, &s, 0, 1), KN_EDOMAIN); // a weight 0
    assert_int_equal(kn_spline_remove_knots(ctx, &out, &error, &(kn_spline){0}, 0, 1), KN_EDOMAIN);
    assert_true(out.nvars == 0 && error == 7);
    assert_int_equal(kn_spline_remove_knots(ctx, &out, &error, &s, 0, 0), KN_OK); // exactly: weights do not matter
    assert_true(out.count[0] == 3 && error == 0);
    s.coef[1] = NAN, s.coef[4] = 1; // nothing is removed that cannot be bounded
    assert_int_equal(kn_spline_remove_knots(ctx, &out, &error, &s, 0, 1e300), KN_OK);
    assert_true(out.count[0] == 3 && error == 0);
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

// Cut at a knot or between knots, and put together again: the same bits.
static void halves_become_one(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    for (int round = test_scale(60); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3), var = test_int(&rng, 0, nvars - 1);
        kn_spline s, lean = {0}, left = {0}, right = {0};
        bool rational = test_int(&rng, 0, 1);
        double error = -1, at = test_int(&rng, 1, 15) / 4.0;
        dyadic(ctx, &s, &rng, nvars, test_int(&rng, 2, 3), rational);
        assert_int_equal(kn_spline_subdivide(ctx, &left, &right, &s, var, at), KN_OK);
        bool jump = s.degree[var] == 0 && at == floor(at);
        assert_int_equal(kn_spline_merge(ctx, &left, &error, &left, &right, var, 0), KN_OK); // out is an operand
        assert_true(error == 0);
        assert_int_equal(kn_spline_check(ctx, &left), KN_OK);
        if (!jump) { // of the knots of s itself at this place some may go
            assert_int_equal(kn_spline_remove_knots(ctx, &lean, NULL, &s, var, 0), KN_OK);
            assert_int_equal(kn_spline_remove_knots(ctx, &left, NULL, &left, var, 0), KN_OK);
            assert_equal(&left, &lean);
        }
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &lean);
        kn_spline_clear(ctx, &left);
        kn_spline_clear(ctx, &right);
    }
    test_ctx_end(ctx, &memory);
}

static kn_spline line(kn_ctx *ctx, double lo, double hi, double from, double to)
{
    kn_spline s;
    const double k[] = {lo, lo, hi, hi};
    const double *const knots[] = {k};
    assert_int_equal(kn_spline_init(ctx, &s, 1, 1, false, (int[]){1}, (int[]){2}, knots, (double[]){from, to}),
                     KN_OK);
    return s;
}

static void merging_by_hand(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline a = line(ctx, 0, 1, 0, 2), b = line(ctx, 1, 3, 2, 6), c = line(ctx, 1, 2, 2, 9),
              d = line(ctx, 1, 2, 3, 4);
    kn_spline out = {0}, high = {0}, r;
    double error = -1;
    assert_int_equal(kn_spline_merge(ctx, &out, &error, &a, &b, 0, 0), KN_OK); // one line
    assert_numbers(out.knots[0], (double[]){0, 0, 3, 3}, 4);
    assert_numbers(out.coef, (double[]){0, 6}, 2);
    assert_int_equal(kn_spline_merge(ctx, &out, &error, &a, &c, 0, 0), KN_OK); // a corner
    assert_numbers(out.knots[0], (double[]){0, 0, 1, 2, 2}, 5);
    assert_numbers(out.coef, (double[]){0, 2, 9}, 3);
    assert_int_equal(kn_spline_merge(ctx, &out, &error, &a, &d, 0, 0), KN_OK); // a gap
    assert_numbers(out.knots[0], (double[]){0, 0, 1, 1, 2, 2}, 6);
    assert_numbers(out.coef, (double[]){0, 2, 3, 4}, 4);
    assert_true(error == 0);
    assert_int_equal(kn_spline_merge(ctx, &out, &error, &a, &d, 0, 0.625), KN_OK); // closed in the middle
    assert_numbers(out.coef, (double[]){0, 2.5, 4}, 3);
    assert_true(error >= 0.5 && error <= 0.5 * (1 + 0x1p-40));
    // degrees are brought together: the corner of a line and a parabola
    assert_int_equal(kn_spline_elevate(ctx, &high, &c, (int[]){3}), KN_OK);
    assert_int_equal(kn_spline_merge(ctx, &out, NULL, &a, &high, 0, 0), KN_OK);
    assert_int_equal(out.degree[0], 3);
    assert_int_equal(out.count[0], 7);
    // a polynomial before a rational one
    assert_int_equal(kn_spline_init(ctx, &r, 1, 2, true, (int[]){1}, (int[]){2}, (const double *const[]){c.knots[0]},
                                    (double[]){2, 8, 1, 2}),
                     KN_OK);
    assert_int_equal(kn_spline_merge(ctx, &out, &error, &a, &r, 0, 0), KN_OK);
    assert_true(out.rational && out.ncomp == 2 && out.count[0] == 3);
    assert_numbers(out.coef, (double[]){0, 2, 8, 1, 1, 2}, 6);
    kn_spline before = out;
    assert_int_equal(kn_spline_merge(ctx, &out, &error, &b, &a, 0, 0), KN_EDOMAIN); // the wrong way round
    assert_int_equal(kn_spline_merge(ctx, &out, &error, &a, &b, 1, 0), KN_EDOMAIN);
    assert_int_equal(kn_spline_merge(ctx, &out, &error, &a, &b, 0, -1), KN_EDOMAIN);
    assert_int_equal(kn_spline_merge(ctx, &out, &error, &a, &(kn_spline){0}, 0, 0), KN_EDOMAIN);
    assert_int_equal(kn_spline_merge(ctx, &out, &error, &(kn_spline){0}, &a, 0, 0), KN_EDOMAIN);
    r.rational = false; // two components
    assert_int_equal(kn_spline_merge(ctx, &out, &error, &a, &r, 0, 0), KN_EDOMAIN);
    assert_memory_equal(&before, &out, sizeof out);
    kn_spline *all[] = {&a, &b, &c, &d, &out, &high, &r};
    for (int i = 0; i < 7; i++) kn_spline_clear(ctx, all[i]);
    test_ctx_end(ctx, &memory);
}

// Surfaces with other knots along the common edge.
static void merging_surfaces(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    for (int round = test_scale(20); round > 0; round--) {
        kn_spline s, left = {0}, right = {0}, both = {0};
        dyadic(ctx, &s, &rng, 2, 2, false);
        assert_int_equal(kn_spline_subdivide(ctx, &left, &right, &s, 0, 2.5), KN_OK);
        assert_int_equal(kn_spline_insert_knots(ctx, &left, &left, 1, (double[]){0.3}, 1), KN_OK);
        assert_int_equal(kn_spline_elevate(ctx, &right, &right, (int[]){s.degree[0], s.degree[1] + 1}), KN_OK);
        double error;
        assert_int_equal(kn_spline_merge(ctx, &both, &error, &left, &right, 0, 1e-9), KN_OK);
        assert_true(error <= 1e-9);
        assert_int_equal(both.count[0], s.count[0]); // all of the continuity there was
        // |error| is of the joining; what came before is of knot insertion and elevation, 60 roundings of 50
        double off = oracle_sampled_distance(&s, &both, &rng, 30);
        assert_true(off <= error + oracle_gamma(200) * 100);
        kn_spline_clear(ctx, &s);
        kn_spline_clear(ctx, &left);
        kn_spline_clear(ctx, &right);
        kn_spline_clear(ctx, &both);
    }
    test_ctx_end(ctx, &memory);
}

static kn_status in_little_memory(kn_ctx *ctx, void *user)
{
    int which = *(int *)user;
    kn_spline a = {0}, b = {0}, out = {0};
    double coef[18], error = 7;
    const double u[] = {0, 0, 0, 1, 2, 3, 3, 3}, v[] = {0, 0, 1, 1}, next[] = {3, 3, 4, 5, 5};
    for (int i = 0; i < 18; i++) coef[i] = i * i % 7 + 1;
    kn_status status = kn_spline_init(ctx, &a, 2, 1, false, (int[]){2, 1}, (int[]){5, 2},
                                      (const double *const[]){u, v}, coef);
    if (status == KN_OK)
        status = kn_spline_init(ctx, &b, 2, 2, true, (int[]){1, 1}, (int[]){3, 2}, (const double *const[]){next, v},
                                coef);
    for (int in_place = 0; in_place < 2 && status == KN_OK; in_place++) {
        kn_spline *to = in_place ? &a : &out, before = *to;
        status = which == 0 ? kn_spline_remove_knots(ctx, to, &error, &a, 0, 5)
                            : kn_spline_merge(ctx, to, &error, &a, &b, 0, 2);
        if (status != KN_OK) assert_memory_equal(&before, to, sizeof before);
        if (status != KN_OK && !in_place) assert_true(error == 7);
    }
    kn_spline_clear(ctx, &a);
    kn_spline_clear(ctx, &b);
    kn_spline_clear(ctx, &out);
    return status;
}

static void little_memory(void **state)
{
    (void)state;
    for (int which = 0; which < 2; which++) test_allocation_failures(in_little_memory, &which);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(insertion_is_undone),     cmocka_unit_test(rounded_insertion_is_undone),
        cmocka_unit_test(knots_that_mean_nothing), cmocka_unit_test(within_a_tolerance),
        cmocka_unit_test(few_knots_are_left),      cmocka_unit_test(removal_refuses),
        cmocka_unit_test(halves_become_one),       cmocka_unit_test(merging_by_hand),
        cmocka_unit_test(merging_surfaces),        cmocka_unit_test(little_memory),
    };
    return cmocka_run_group_tests_name("spline/remove_knots", tests, NULL, NULL);
}
