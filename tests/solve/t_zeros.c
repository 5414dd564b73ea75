// SPDX-License-Identifier: Apache-2.0
// Systems with known zeros, exactly: all found, each once, certified where they are regular.
#include "tests/support/support.h"

#include <knurl/solve.h>

#include <math.h>

// Three times (16 x - a)(16 x - b)(16 x - c) in Bernstein form of degree 3: integers. Power coefficients p_k give
// c_i = sum_k C(i,k) / C(3,k) p_k.
static void cubic(double out[4], const int *root)
{
    double e1 = root[0] + root[1] + root[2], e3 = (double)root[0] * root[1] * root[2];
    double e2 = (double)root[0] * root[1] + (double)root[0] * root[2] + (double)root[1] * root[2];
    double p[4] = {-e3, 16.0 * e2, -256.0 * e1, 4096.0};
    for (int i = 0; i < 4; i++)
        out[i] = 3.0 * p[0] + i * p[1] + (i == 3 ? 3.0 : i == 2 ? 1.0 : 0.0) * p[2] + (i == 3) * 3.0 * p[3];
}

// f = M (p(x), q(y) [, r(z)]): zeros on the grid of the roots, whatever the regular matrix M.
typedef struct grid_case {
    int n, root[3][3];
    double coef[3 * 64];
} grid_case;

static void make_grid(grid_case *g, test_rng *rng, int n, bool repeated)
{
    double one[3][4], m[9];
    int size = n == 2 ? 16 : 64;
    g->n = n;
    for (int d = 0; d < n; d++) {
        for (int k = 0; k < 3; k++)
            g->root[d][k] = test_int(rng, 0, 3) == 0 ? test_int(rng, -9, 25) : test_int(rng, 0, 16);
        while (!repeated &&
               (g->root[d][0] == g->root[d][1] || g->root[d][1] == g->root[d][2] || g->root[d][0] == g->root[d][2]))
            for (int k = 0; k < 3; k++) g->root[d][k] = test_int(rng, -4, 20);
        cubic(one[d], g->root[d]);
    }
    for (int i = 0; i < n; i++)
        for (int d = 0; d < n; d++) m[i * n + d] = i == d ? 3.0 + i : test_int(rng, -1, 1); // dominant diagonal
    for (int i = 0; i < n; i++)
        for (int j = 0; j < size; j++) {
            int index[3] = {n == 2 ? j / 4 : j / 16, n == 2 ? j % 4 : j / 4 % 4, j % 4};
            g->coef[i * size + j] = 0.0;
            for (int d = 0; d < n; d++) g->coef[i * size + j] += m[i * n + d] * one[d][index[d]];
        }
}

// The exact zeros in the closed domain, and how many boxes of each kind hold each.
// width: of the boxes that are certain. p' >= 48 at a root, and the largest coefficients are below 4 3 25^3: rounding
// of k u moves a root by 4000 k u, and Krawczyk's kappa <= 0.8, two sides and the inverse's rows make that 80000 k u.
static void check_grid(const grid_case *g, const kn_root *roots, size_t nroots, double width, int *zeros, int *unique)
{
    int total = 1;
    for (int d = 0; d < g->n; d++) total *= 3;
    *zeros = 0;
    for (int k = 0; k < total; k++) {
        int digit[3] = {k % 3, k / 3 % 3, k / 9}, holds = 0;
        double at[3];
        bool inside = true, again = false;
        for (int d = 0; d < g->n; d++) {
            at[d] = g->root[d][digit[d]] / 16.0;
            inside = inside && at[d] >= 0.0 && at[d] <= 1.0;
            for (int e = 0; e < digit[d]; e++) again = again || g->root[d][e] == g->root[d][digit[d]];
        }
        for (size_t i = 0; i < nroots; i++) {
            bool in = true;
            for (int d = 0; d < g->n; d++) in = in && roots[i].lo[d] <= at[d] && at[d] <= roots[i].hi[d];
            holds += in;
            if (in && !inside) assert_true(roots[i].at_edge);
        }
        if (inside && !again) *zeros += 1;
        if (inside) assert_int_equal(holds, 1);
    }
    *unique = 0;
    for (size_t i = 0; i < nroots; i++) {
        *unique += roots[i].kind == KN_ROOT_UNIQUE;
        for (int d = 0; d < g->n; d++) {
            assert_true(roots[i].lo[d] <= roots[i].at[d] && roots[i].at[d] <= roots[i].hi[d]);
            assert_true(roots[i].at[d] >= 0.0 && roots[i].at[d] <= 1.0);
            if (roots[i].kind == KN_ROOT_UNIQUE) assert_true(roots[i].hi[d] - roots[i].lo[d] < width);
        }
    }
}

static void grids(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(11);
    size_t boxes = 0, zeros_all = 0;
    for (int k = test_scale(400); k > 0; k--) {
        grid_case g;
        make_grid(&g, &rng, k % 8 == 0 ? 3 : 2, false);
        kn_bezier f = {.nvars = g.n, .ncomp = g.n, .degree = {3, 3, 3}, .coef = g.coef};
        kn_root *roots = NULL;
        kn_solve_report report;
        size_t nroots = 0;
        int zeros = 0, unique = 0;
        assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &nroots, &report, &f, 1, NULL), KN_OK);
        check_grid(&g, roots, nroots, 8e4 * 2.0 * 0x1p-53, &zeros, &unique);
        assert_int_equal(unique, zeros);
        assert_int_equal(nroots, zeros);
        assert_int_equal(report.possible, 0);
        assert_false(report.curve_like || report.limited);
        boxes += report.boxes, zeros_all += nroots;
        kn_free(ctx, roots);
    }
    print_message("# %zu zeros, %zu boxes\n", zeros_all, boxes);
    test_ctx_end(ctx, &memory);
}

// Multiple roots: covered, never called unique.
static void repeated(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(12);
    for (int k = test_scale(20); k > 0; k--) {
        grid_case g;
        make_grid(&g, &rng, 2, true);
        g.root[0][1] = g.root[0][0];
        double one[2][4];
        for (int d = 0; d < 2; d++) cubic(one[d], g.root[d]);
        for (int j = 0; j < 16; j++)
            g.coef[j] = one[0][j / 4] + one[1][j % 4], g.coef[16 + j] = one[0][j / 4] - one[1][j % 4];
        kn_bezier f = {.nvars = 2, .ncomp = 2, .degree = {3, 3}, .coef = g.coef};
        kn_root *roots = NULL;
        size_t nroots = 0;
        kn_solve_report report;
        int zeros = 0, unique = 0;
        assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &nroots, &report, &f, 1, NULL), KN_OK);
        check_grid(&g, roots, nroots, 8e4 * 2.0 * 0x1p-53, &zeros, &unique);
        for (size_t i = 0; i < nroots; i++) {
            bool twice = false;
            double x = g.root[0][0] / 16.0;
            twice = roots[i].lo[0] <= x && x <= roots[i].hi[0];
            if (twice) assert_int_equal(roots[i].kind, KN_ROOT_POSSIBLE);
        }
        assert_false(report.curve_like);
        kn_free(ctx, roots);
    }
    test_ctx_end(ctx, &memory);
}

// Knots through the zeros, and anywhere: each zero once all the same.
static void seams(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(13);
    int certain = 0, all = 0;
    for (int k = test_scale(100); k > 0; k--) {
        grid_case g;
        make_grid(&g, &rng, 2, false);
        kn_bezier f = {.nvars = 2, .ncomp = 2, .degree = {3, 3}, .coef = g.coef};
        kn_spline s = {0};
        assert_int_equal(kn_spline_of_bezier(ctx, &s, &f), KN_OK);
        for (int d = 0; d < 2; d++) {
            double knots[3] = {g.root[d][0] / 16.0, test_int(&rng, 1, 31) / 32.0, g.root[d][1] / 16.0};
            for (int i = 0; i < 3; i++)
                if (knots[i] > 0.0 && knots[i] < 1.0)
                    assert_int_equal(kn_spline_insert_knots(ctx, &s, &s, d, &knots[i], 1), KN_OK);
        }
        kn_root *roots = NULL;
        size_t nroots = 0;
        int zeros = 0, unique = 0;
        assert_int_equal(kn_solve_zeros(ctx, &roots, &nroots, NULL, &s, 1, NULL), KN_OK);
        check_grid(&g, roots, nroots, 8e4 * 2.0 * 38.0 * 0x1p-53, &zeros, &unique); // two variables of degree 3
        assert_int_equal(nroots, zeros);
        certain += unique, all += zeros;
        kn_free(ctx, roots);
        kn_spline_clear(ctx, &s);
    }
    print_message("# %d of %d zeros on knots certified\n", certain, all);
    assert_true(certain > all - all / 50);
    test_ctx_end(ctx, &memory);
}

// Equations of different degrees on different knots: p(x) (1 + y) and q(y) (2 - x).
static void separate(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(15);
    for (int k = test_scale(60); k > 0; k--) {
        grid_case g;
        kn_spline f[2] = {{0}, {0}};
        kn_root *roots = NULL;
        size_t nroots = 0;
        int zeros = 0, unique = 0;
        make_grid(&g, &rng, 2, false);
        for (int i = 0; i < 2; i++) {
            double one[4], c[8];
            cubic(one, g.root[i]);
            for (int j = 0; j < 8; j++) c[j] = i == 0 ? one[j / 2] * (1 + j % 2) : one[j % 4] * (2 - j / 4);
            kn_bezier b = {.nvars = 2, .ncomp = 1, .degree = {i == 0 ? 3 : 1, i == 0 ? 1 : 3}, .coef = c};
            assert_int_equal(kn_spline_of_bezier(ctx, &f[i], &b), KN_OK);
            for (int d = 0; d < 2; d++) {
                double knot = test_int(&rng, 1, 15) / 16.0;
                assert_int_equal(kn_spline_insert_knots(ctx, &f[i], &f[i], d, &knot, 1), KN_OK);
            }
        }
        assert_int_equal(kn_solve_zeros(ctx, &roots, &nroots, NULL, f, 2, NULL), KN_OK);
        check_grid(&g, roots, nroots, 8e4 * 2.0 * 64.0 * 0x1p-53, &zeros, &unique); // raised degrees, too
        assert_int_equal(nroots, zeros);
        assert_int_equal(unique, zeros);
        kn_free(ctx, roots);
        for (int i = 0; i < 2; i++) kn_spline_clear(ctx, &f[i]);
    }
    test_ctx_end(ctx, &memory);
}

// Random systems: the sum of the signs of det J over all zeros is the number of turns of f along the boundary
// (Poincare and Bohl). The turns are counted by 4 x 512 samples, where no step turns by more than 1/2.
static bool turns(const kn_bezier *f, kn_ctx *ctx, int *out)
{
    double last[2] = {0}, angle = 0.0;
    for (int i = 0; i <= 2048; i++) {
        double t = (i % 512) / 512.0, at[2], v[2];
        int side = i / 512 % 4;
        at[0] = side == 0 ? t : side == 1 ? 1.0 : side == 2 ? 1.0 - t : 0.0;
        at[1] = side == 0 ? 0.0 : side == 1 ? t : side == 2 ? 1.0 : 1.0 - t;
        assert_int_equal(kn_bezier_eval(ctx, v, f, at), KN_OK);
        double step = i > 0 ? atan2(last[0] * v[1] - last[1] * v[0], last[0] * v[0] + last[1] * v[1]) : 0.0;
        if (fabs(step) > 0.5) return false;
        angle += step;
        last[0] = v[0], last[1] = v[1];
    }
    *out = (int)lround(angle / (2.0 * acos(-1.0)));
    return true;
}

static void random_systems(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(14);
    int used = 0, possible = 0, found = 0, n = test_scale(300);
    for (int k = 0; k < n; k++) {
        const int degree[2] = {test_int(&rng, 1, 4), test_int(&rng, 1, 4)};
        kn_bezier f = {0};
        kn_root *roots = NULL;
        kn_solve_report report;
        size_t nroots = 0;
        int sum = 0, number = 0;
        test_random_bezier(ctx, &f, &rng, 2, 2, false, degree, 9);
        for (size_t i = 0; i < 2 * kn_bezier_count(&f); i++) f.coef[i] += test_uniform(&rng, -0.4, 0.4);
        assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &nroots, &report, &f, 1, NULL), KN_OK);
        bool clean = report.possible == 0;
        for (size_t i = 0; i < nroots; i++) {
            double d[6];
            assert_int_equal(kn_bezier_derivatives(ctx, d, &f, roots[i].at, 1), KN_OK);
            assert_true(fabs(d[0]) < 1e-13 * 10.0 && fabs(d[1]) < 1e-13 * 10.0);
            sum += d[2] * d[5] - d[3] * d[4] > 0.0 ? 1 : -1;
            clean = clean && !roots[i].at_edge;
        }
        possible += report.possible > 0, found += (int)nroots;
        if (clean && turns(&f, ctx, &number)) {
            assert_int_equal(sum, number);
            used++;
        }
        kn_free(ctx, roots);
        kn_bezier_clear(ctx, &f);
    }
    print_message("# %d random systems, %d zeros, %d with undecided ones, %d sums compared\n", n, found, possible,
                  used);
    assert_true(possible < n / 50 && used > n / 2);
    test_ctx_end(ctx, &memory);
}

// Points where a curve touches itself, zeros that are a curve, equations that say nothing, too few and too many ones.
static void degenerate(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_root *roots = NULL;
    kn_solve_report report;
    size_t n = 0;
    double same[8] = {0.0, -1.0, 1.0, 0.0, 0.0, -3.0, 3.0, 0.0}; // x - y, twice
    kn_bezier f = {.nvars = 2, .ncomp = 2, .degree = {1, 1}, .coef = same};
    for (int ncomp = 2; ncomp > 0; ncomp--) { // and once
        f.ncomp = ncomp;
        assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &n, &report, &f, 1, NULL), KN_OK);
        assert_true(report.curve_like && n > 100 && !report.limited);
        for (int i = 0; i <= 100; i++) { // covered
            bool in = false;
            for (size_t k = 0; k < n; k++)
                in = in ||
                     (roots[k].lo[0] <= i / 100.0 && i / 100.0 <= roots[k].hi[0] && roots[k].lo[1] <= i / 100.0 &&
                      i / 100.0 <= roots[k].hi[1] && roots[k].hi[1] - roots[k].lo[1] < 0.01);
            assert_true(in);
        }
        kn_free(ctx, roots);
    }
    double level[4] = {-0.25, -0.25, 0.75, 0.75}; // x - 1/4: boxes of full height, for y does not matter
    f.coef = level;
    assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &n, &report, &f, 1, NULL), KN_OK);
    bool covered = false;
    for (size_t i = 0; i < n; i++) {
        assert_true(roots[i].lo[1] == 0.0 && roots[i].hi[1] == 1.0 && roots[i].hi[0] - roots[i].lo[0] < 1e-12);
        covered = covered || (roots[i].lo[0] <= 0.25 && 0.25 <= roots[i].hi[0]);
    }
    assert_true(report.curve_like && covered);
    kn_free(ctx, roots);
    double none[4] = {0.0, 0.0, 0.0, 0.0};
    kn_bezier zero = {.nvars = 2, .ncomp = 1, .degree = {1, 1}, .coef = none}, pair[2] = {zero, zero};
    assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &n, &report, pair, 2, NULL), KN_OK);
    assert_int_equal(n, 1); // everything: nothing would be gained by dividing it
    assert_int_equal(roots[0].kind, KN_ROOT_POSSIBLE);
    assert_true(roots[0].lo[1] == 0.0 && roots[0].hi[1] == 1.0);
    kn_free(ctx, roots);
    // x = 1/4, y = 3/4 and a third equation that agrees, or does not
    double three[12] = {-0.25, -0.25, 0.75, 0.75, -0.75, 0.25, -0.75, 0.25, -1.0, 0.0, 0.0, 1.0};
    kn_bezier over = {.nvars = 2, .ncomp = 3, .degree = {1, 1}, .coef = three};
    assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &n, &report, &over, 1, NULL), KN_OK);
    assert_int_equal(n, 1);
    assert_int_equal(roots[0].kind, KN_ROOT_POSSIBLE);
    assert_true(fabs(roots[0].at[0] - 0.25) < 1e-11 && fabs(roots[0].at[1] - 0.75) < 1e-11);
    assert_int_equal(report.possible, 1);
    kn_free(ctx, roots);
    for (int i = 8; i < 12; i++) three[i] += 1e-10;
    assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &n, NULL, &over, 1, NULL), KN_OK);
    assert_int_equal(n, 0);
    kn_free(ctx, roots);
    const kn_solve_options loose = {.residual = 1e-9};
    assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &n, NULL, &over, 1, &loose), KN_OK);
    assert_int_equal(n, 1);
    kn_free(ctx, roots);
    test_ctx_end(ctx, &memory);
}

// A circle and a line that misses it, touches it, or cuts it, by 1e-14 .. 1e-6; scales far from 1.
static void near_misses(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int k = -45; k <= 45; k++) {
        if (k == -1) continue; // touches the other side
        double lift = k == 0 ? 0.0 : ldexp(k < 0 ? -1.0 : 1.0, -(k < 0 ? -k : k)), scale = ldexp(1.0, 10 * k);
        double c[18]; // (2x-1)^2 + (2y-1)^2 - 1/4 and y - 3/4 - lift
        const double q[3] = {1.0, -1.0, 1.0}, y[3] = {0.0, 0.5, 1.0};
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                c[3 * i + j] = (q[i] + q[j] - 0.25) * scale;
                c[9 + 3 * i + j] = (y[j] - 0.75 - lift) * scale;
            }
        kn_bezier f = {.nvars = 2, .ncomp = 2, .degree = {2, 2}, .coef = c};
        kn_root *roots = NULL;
        size_t n = 0;
        kn_solve_report report;
        assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &n, &report, &f, 1, NULL), KN_OK);
        assert_false(report.curve_like || report.limited);
        bool inside = lift > -0.5 && 0.75 + lift >= 0.0 && 0.75 + lift <= 1.0;
        double half = sqrt(fmax(0.0, 0.0625 - (0.25 + lift) * (0.25 + lift)));
        if (lift > 0.0 || !inside) {
            if (lift > 1e-12 || !inside) assert_int_equal(n, 0);
        } else if (lift < -1e-12) {
            assert_int_equal(n, 2);
            assert_int_equal(report.possible, 0);
            assert_true(fabs(roots[0].at[0] - (0.5 - half)) < 1e-8 && fabs(roots[1].at[0] - (0.5 + half)) < 1e-8);
        } else {
            assert_true(n == 1 || n == 2);
            for (size_t i = 0; i < n; i++) assert_true(fabs(roots[i].at[0] - 0.5) < 1e-5);
        }
        for (size_t i = 0; i < n && lift == 0.0; i++) assert_int_equal(roots[i].kind, KN_ROOT_POSSIBLE);
        kn_free(ctx, roots);
    }
    test_ctx_end(ctx, &memory);
}

static int cancel(void *user, const char *stage, double fraction)
{
    (void)user, (void)stage;
    assert_true(fraction >= 0.0 && fraction <= 1.0);
    return 1;
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double c[4] = {-1.0, 1.0, -1.0, 1.0};
    kn_bezier f = {.nvars = 1, .ncomp = 1, .degree = {1}, .coef = c},
              g = {.nvars = 2, .ncomp = 1, .degree = {1, 1}, .coef = c};
    kn_bezier both[2] = {f, g}, empty = {0};
    kn_root mine, *roots = &mine;
    size_t n = 77;
    assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &n, NULL, &f, 0, NULL), KN_EDOMAIN);
    assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &n, NULL, &empty, 1, NULL), KN_EDOMAIN);
    assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &n, NULL, both, 2, NULL), KN_EDOMAIN);
    const kn_solve_options bad[3] = {{.tolerance = -1.0}, {.residual = NAN}, {.max_depth = KN_SOLVE_MAX_DEPTH + 1}};
    for (int i = 0; i < 3; i++)
        assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &n, NULL, &f, 1, &bad[i]), KN_EDOMAIN);
    kn_spline pair[2] = {{0}, {0}};
    assert_int_equal(kn_spline_of_bezier(ctx, &pair[0], &f), KN_OK);
    assert_int_equal(kn_spline_copy(ctx, &pair[1], &pair[0]), KN_OK);
    pair[1].knots[0][2] = pair[1].knots[0][3] = 2.0;
    assert_int_equal(kn_solve_zeros(ctx, &roots, &n, NULL, pair, 2, NULL), KN_EDOMAIN);
    for (int i = 0; i < 2; i++) kn_spline_clear(ctx, &pair[i]);
    c[1] = NAN;
    assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &n, NULL, &f, 1, NULL), KN_EDOMAIN);
    int high[4] = {56, 56, 56, 56};
    kn_bezier wide[4];
    for (int i = 0; i < 4; i++) { // 57^4 coefficients together, times four, times 57
        int degree[5] = {0, 0, 0, 0, i == 0 ? 56 : 0};
        degree[i] = high[i];
        assert_int_equal(kn_bezier_init(ctx, &wide[i], 5, 1, false, degree), KN_OK);
    }
    assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &n, NULL, wide, 4, NULL), KN_ELIMIT);
    for (int i = 0; i < 4; i++) kn_bezier_clear(ctx, &wide[i]);
    assert_ptr_equal(roots, &mine);
    assert_int_equal(n, 77);
    test_ctx_end(ctx, &memory);

    kn_ctx_options options = kn_ctx_defaults();
    options.progress = cancel;
    assert_int_equal(kn_ctx_create(&ctx, &options), KN_OK);
    double same[8] = {0.0, -1.0, 1.0, 0.0, 0.0, -3.0, 3.0, 0.0};
    kn_bezier line = {.nvars = 2, .ncomp = 2, .degree = {1, 1}, .coef = same};
    assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &n, NULL, &line, 1, NULL), KN_ECANCELLED);
    test_rng rng = test_random(58); // boxes of many coefficients ask more often than every thousandth time
    kn_bezier large = {0};
    assert_int_equal(kn_bezier_init(ctx, &large, 4, 4, false, (const int[]){6, 6, 6, 6}), KN_OK);
    for (size_t i = 0; i < 4 * kn_bezier_count(&large); i++) large.coef[i] = test_uniform(&rng, -1.0, 1.0);
    const kn_solve_options few = {.max_boxes = 300};
    assert_int_equal(kn_solve_zeros_bezier(ctx, &roots, &n, NULL, &large, 1, &few), KN_ECANCELLED);
    kn_bezier_clear(ctx, &large);
    kn_ctx_destroy(ctx);
}

static kn_status two_zeros(kn_ctx *ctx, void *user)
{
    double c[18];
    const double q[3] = {1.0, -1.0, 1.0}, y[3] = {0.0, 0.5, 1.0};
    for (int i = 0; i < 9; i++) c[i] = q[i / 3] + q[i % 3] - 0.25, c[9 + i] = y[i % 3] - 0.6;
    kn_bezier f = {.nvars = 2, .ncomp = 2, .degree = {2, 2}, .coef = c};
    kn_root *roots = user;
    size_t n = 0;
    kn_status status = kn_solve_zeros_bezier(ctx, &roots, &n, NULL, &f, 1, NULL);
    if (status != KN_OK) assert_ptr_equal(roots, user);
    if (status == KN_OK) assert_int_equal(n, 2);
    if (status == KN_OK) kn_free(ctx, roots);
    return status;
}

static void allocation(void **state)
{
    (void)state;
    kn_root mine;
    test_allocation_failures(two_zeros, &mine);
    kn_solve_options o = kn_solve_defaults();
    assert_true(o.tolerance > 0.0 && o.residual > 0.0 && o.max_depth > 0 && o.max_boxes > 0 && o.max_undecided > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grids),       cmocka_unit_test(repeated),       cmocka_unit_test(seams),
        cmocka_unit_test(separate),    cmocka_unit_test(random_systems), cmocka_unit_test(degenerate),
        cmocka_unit_test(near_misses), cmocka_unit_test(failures),       cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("solve/zeros", tests, NULL, NULL);
}
