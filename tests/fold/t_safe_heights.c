// SPDX-License-Identifier: Apache-2.0
// Safe heights against closed forms, and against principal radii of curvature computed in long double.
#include "tests/support/surfaces.h"

#include <knurl/construct.h>
#include <knurl/fold.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

static kn_shell *create(kn_ctx *ctx, const kn_spline *s, const kn_shell_options *o)
{
    kn_shell *shell = NULL;
    if (kn_shell_create(ctx, &shell, s, o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return shell;
}

static kn_fold_heights overall(kn_ctx *ctx, const kn_shell *shell)
{
    kn_fold_heights h;
    if (kn_fold_safe_heights(ctx, NULL, &h, shell) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return h;
}

// Within 1 % below the truth, which is that of the exact normal: `fit` is what the fitted n may change.
static void near_below(double height, double truth, double fit)
{
    if (!(height <= truth * (1.0 + fit) && height >= 0.99 * truth * (1.0 - fit)))
        fail_msg("%.9g is not within 1 %% below %.9g", height, truth);
}

// ---- closed forms ----

// n within e = 1e-6 on spans of d = 1/32 and more: by Markov's inequality its derivatives are within 2 p^2 e / d =
// 1e-3 for p = 4, beside the |n_u| = 2 pi of a circle over [0,1]: heights are within 2e-4 of themselves. Where two
// radii agree (a sphere) J has a double root, which moves by the square root of twice the share 2^-20, 1.4e-3.
static const double fit = 2e-4, fit_double = 2e-3;

static void torus(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double center[3] = {1, 2, 3}, axis[3] = {0, 0, 1};
    kn_shell_options o = {.normal_tol = 1e-6};
    kn_spline s = {0}, turned = {0};
    assert_int_equal(kn_construct_torus(ctx, &s, center, axis, 3.0, 0.8), KN_OK);
    kn_shell *shell = create(ctx, &s, &o);
    int count[2];
    kn_shell_cells(shell, count);
    assert_true(count[0] == 4 && count[1] == 4);
    kn_fold_heights cell[16], all = overall(ctx, shell);
    // Outside: the hole closes at its axis. Inside: the tube's centre line.
    near_below(all.above, 3.0 - 0.8, fit);
    near_below(all.below, 0.8, fit);
    assert_true(all.above_most >= all.above && all.below_most >= all.below);
    assert_true(fabs(all.where_above[1] - 0.5) < 0.02); // v = 1/2: the inner equator
    assert_int_equal(kn_fold_safe_heights(ctx, cell, NULL, shell), KN_OK);
    for (int c = 0; c < 16; c++) {
        // Quarters of the tube from the outermost point on: outside 0 and 3, inside 1 and 2.
        bool inner = c % 4 == 1 || c % 4 == 2;
        near_below(cell[c].below, 0.8, fit);
        if (inner)
            near_below(cell[c].above, 2.2, fit);
        else
            assert_true(cell[c].above > 100.0); // the principal radius grows beyond all bounds at the crest
    }
    kn_shell_destroy(ctx, shell);
    // Turned around, n points inwards: above and below change places.
    assert_int_equal(kn_spline_reverse(ctx, &turned, &s, 0), KN_OK);
    shell = create(ctx, &turned, &o);
    all = overall(ctx, shell);
    near_below(all.above, 0.8, fit);
    near_below(all.below, 2.2, fit);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &turned);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void cylinder_sphere_and_plane(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double base[3] = {0, 0, 0}, axis[3] = {0, 0, 5};
    kn_shell_options o = {.normal_tol = 1e-6};
    for (int reversed = 0; reversed < 2; reversed++) {
        kn_spline s = {0};
        assert_int_equal(kn_construct_cylinder(ctx, &s, base, axis, 0.5), KN_OK);
        if (reversed) assert_int_equal(kn_spline_reverse(ctx, &s, &s, 1), KN_OK);
        kn_shell *shell = create(ctx, &s, &o);
        kn_fold_heights h = overall(ctx, shell);
        near_below(reversed ? h.above : h.below, 0.5, fit);
        assert_true((reversed ? h.below : h.above) > 1e3); // along the axis n is constant but for the fit
        kn_shell_destroy(ctx, shell);

        assert_int_equal(kn_construct_sphere(ctx, &s, base, 2.0), KN_OK);
        if (reversed) assert_int_equal(kn_spline_reverse(ctx, &s, &s, 1), KN_OK);
        shell = create(ctx, &s, &o);
        h = overall(ctx, shell);
        near_below(reversed ? h.above : h.below, 2.0, fit_double); // poles included
        assert_true((reversed ? h.below : h.above) > 1e3);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    kn_spline s;
    make_plane(ctx, &s);
    kn_shell *shell = create(ctx, &s, &o);
    kn_fold_heights h = overall(ctx, shell);
    assert_true(h.above > 1e10 && h.below > 1e10);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// ---- principal curvatures in long double ----

// Derivative `order` of B-spline i of degree p on knot span `span`, at t, by the recurrences.
static long double b_spline(const double *k, int p, int i, int span, long double t, int order)
{
    if (p == 0) return order == 0 && i == span ? 1.0L : 0.0L;
    long double a = (long double)k[i + p] - k[i], b = (long double)k[i + p + 1] - k[i + 1];
    long double left = a > 0 ? b_spline(k, p - 1, i, span, t, order > 0 ? order - 1 : 0) / a : 0.0L;
    long double right = b > 0 ? b_spline(k, p - 1, i + 1, span, t, order > 0 ? order - 1 : 0) / b : 0.0L;
    return order > 0 ? p * (left - right) : left * (t - k[i]) + right * (k[i + p + 1] - t);
}

static long double dot(const long double *a, const long double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// The values and derivatives of the B-splines of one variable that act at a place.
typedef struct place {
    long double at, basis[3][8];
} place;

static place place_at(const kn_spline *s, int v, int span, long double at)
{
    place p = {.at = at};
    for (int q = 0; q < 3; q++)
        for (int i = 0; i <= s->degree[v]; i++)
            p.basis[q][i] = b_spline(s->knots[v], s->degree[v], span - s->degree[v] + i, span, at, q);
    return p;
}

// S_u, S_v, S_uu, S_uv, S_vv. Of P/W from P = W S by Leibniz.
static void derivatives(long double d[5][3], const kn_spline *s, const int span[2], const place *u, const place *v)
{
    static const int order[6][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}};
    static const int part[6][2] = {{0, 0}, {0, 0}, {0, 0}, {1, 1}, {1, 2}, {2, 2}}; // one derivative each
    long double p[6][4] = {{0}};
    size_t count = kn_spline_count(s), dim = s->rational ? 4 : 3;
    for (int i = 0; i <= s->degree[0]; i++)
        for (int j = 0; j <= s->degree[1]; j++) {
            size_t k = (size_t)(span[0] - s->degree[0] + i) * (size_t)s->count[1] +
                       (size_t)(span[1] - s->degree[1] + j);
            for (int m = s->rational ? 0 : 1; m < 6; m++)
                for (size_t c = 0; c < dim; c++)
                    p[m][c] += u->basis[order[m][0]][i] * v->basis[order[m][1]][j] * s->coef[c * count + k];
        }
    for (int c = 0; c < 3; c++) {
        if (s->rational) p[0][c] /= p[0][3];
        for (int m = 1; m < 6 && s->rational; m++) {
            const int *q = part[m];
            if (m > 2) p[m][c] -= p[q[0]][3] * p[q[1]][c] + p[q[1]][3] * p[q[0]][c];
            p[m][c] = (p[m][c] - p[m][3] * p[0][c]) / p[0][3];
        }
        for (int m = 0; m < 5; m++) d[m][c] = p[m + 1][c];
    }
}

// The heights above and below at which J vanishes at one place: 1/k for the largest and least principal curvatures k
// of each sign (J = J0 (1 - k1 w)(1 - k2 w), k > 0 where S bends towards n).
static void radii(long double out[2], const kn_spline *s, const int span[2], const place *u, const place *v)
{
    long double d[5][3], n[3];
    derivatives(d, s, span, u, v);
    for (int c = 0; c < 3; c++) n[c] = d[0][(c + 1) % 3] * d[1][(c + 2) % 3] - d[0][(c + 2) % 3] * d[1][(c + 1) % 3];
    long double length = sqrtl(dot(n, n));
    long double e = dot(d[0], d[0]), f = dot(d[0], d[1]), g = dot(d[1], d[1]);
    long double l = dot(d[2], n) / length, m = dot(d[3], n) / length, o = dot(d[4], n) / length;
    long double mean = (e * o - 2 * f * m + g * l) / (2 * (e * g - f * f)), gauss = (l * o - m * m) / (e * g - f * f);
    long double root = sqrtl(fmaxl(0.0L, mean * mean - gauss)), most = mean + root, least = mean - root;
    out[0] = most > 0 ? 1 / most : INFINITY;
    out[1] = least < 0 ? -1 / least : INFINITY;
}

typedef struct minimum {
    long double value;
    place at[2];
} minimum;

// Steps towards lower values, halved where none leads there, down to 1e-5 of the span: near a minimum of a smooth
// function that leaves a multiple of 1e-10.
static void descend(minimum *m, const kn_spline *s, const int span[2], int side)
{
    long double step = 0.1L, r[2];
    while (step > 1e-5L) {
        bool better = false;
        for (int k = 0; k < 4; k++) {
            int v = k / 2;
            long double lo = s->knots[v][span[v]], hi = s->knots[v][span[v] + 1];
            place now[2] = {m->at[0], m->at[1]};
            long double to = now[v].at + (k % 2 ? step : -step) * (hi - lo);
            if (to < lo || to > hi) continue;
            now[v] = place_at(s, v, span[v], to);
            radii(r, s, span, &now[0], &now[1]);
            if (!(r[side] < m->value)) continue;
            *m = (minimum){r[side], {now[0], now[1]}};
            better = true;
        }
        if (!better) step /= 2;
    }
}

// The least on both sides over one knot span: samples, then steps from the best few of them.
static void least_radii(minimum out[2], const kn_spline *s, const int span[2])
{
    enum { GRID = 10, STARTS = 3 };
    minimum best[2][STARTS];
    place at[2][GRID + 1];
    long double r[2];
    for (int v = 0; v < 2; v++)
        for (int k = 0; k <= GRID; k++) {
            long double lo = s->knots[v][span[v]], width = s->knots[v][span[v] + 1] - lo;
            at[v][k] = place_at(s, v, span[v], k == GRID ? lo + width : lo + width * k / GRID);
        }
    for (int b = 0; b < 2 * STARTS; b++) best[b / STARTS][b % STARTS] = (minimum){INFINITY, {at[0][0], at[1][0]}};
    for (int k = 0; k < (GRID + 1) * (GRID + 1); k++) {
        const place *u = &at[0][k / (GRID + 1)], *v = &at[1][k % (GRID + 1)];
        radii(r, s, span, u, v);
        for (int side = 0; side < 2; side++) {
            int b = STARTS - 1;
            if (!(r[side] < best[side][b].value)) continue;
            for (; b > 0 && r[side] < best[side][b - 1].value; b--) best[side][b] = best[side][b - 1];
            best[side][b] = (minimum){r[side], {*u, *v}};
        }
    }
    for (int side = 0; side < 2; side++) {
        out[side] = best[side][0];
        for (int b = 0; b < STARTS; b++) {
            if (best[side][b].value < 4.0L) descend(&best[side][b], s, span, side);
            if (best[side][b].value < out[side].value) out[side] = best[side][b];
        }
    }
}

// Height fields over a bent grid, of degrees 2 to 4, with simple and double knots. Rational ones have degrees 2 and
// 3, and weights in [1/2, 2].
static void make_random(kn_ctx *ctx, kn_spline *out, test_rng *rng, bool rational)
{
    int degree[2], count[2];
    double knots[2][16], coef[4 * 64];
    const double *k[2] = {knots[0], knots[1]};
    for (int v = 0; v < 2; v++) {
        degree[v] = test_int(rng, 2, rational ? 3 : 4);
        count[v] = degree[v] + 1 + test_int(rng, 0, rational ? 1 : 2);
        double at = 0.0;
        for (int i = 0; i <= count[v] + degree[v]; i++) {
            if (i > degree[v] && i <= count[v]) at += test_uniform(rng, 0.7, 1.3);
            knots[v][i] = at;
        }
        if (degree[v] > 2 && count[v] == degree[v] + 3 && test_int(rng, 0, 3) == 0)
            knots[v][degree[v] + 2] = knots[v][degree[v] + 1];
    }
    int n = count[0] * count[1];
    for (int i = 0; i < n; i++) {
        coef[i] = i / count[1] + test_uniform(rng, -0.15, 0.15);
        coef[n + i] = i % count[1] + test_uniform(rng, -0.15, 0.15);
        coef[2 * n + i] = test_uniform(rng, -0.6, 0.6);
        coef[3 * n + i] = rational ? exp2(test_uniform(rng, -1.0, 1.0)) : 1.0;
        for (int c = 0; c < 3; c++) coef[c * n + i] *= coef[3 * n + i];
    }
    assert_int_equal(kn_spline_init(ctx, out, 2, rational ? 4 : 3, rational, degree, count, k, coef), KN_OK);
}

// The knot span (index of its first knot) of cell i.
static int span_of(const kn_spline *s, int v, int i)
{
    const double *t = s->knots[v];
    for (int k = s->degree[v]; k < s->count[v]; k++)
        if (t[k] < t[k + 1] && i-- == 0) return k;
    return -1;
}

static void random_surfaces(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    test_rng rng = test_random(40);
    kn_shell_options o = {.normal_tol = 1e-5};
    int compared = 0, surfaces = test_scale(40);
    for (int k = 0; k < surfaces; k++) {
        kn_spline s;
        make_random(ctx, &s, &rng, k % 5 == 4);
        kn_shell *shell = create(ctx, &s, &o);
        int count[2];
        kn_shell_cells(shell, count);
        kn_fold_heights cell[16], all;
        assert_true(count[0] * count[1] <= 16);
        assert_int_equal(kn_fold_safe_heights(ctx, cell, &all, shell), KN_OK);
        double least[2] = {INFINITY, INFINITY};
        for (int c = 0; c < count[0] * count[1]; c++) {
            const int span[2] = {span_of(&s, 0, c / count[1]), span_of(&s, 1, c % count[1])};
            minimum truths[2];
            least_radii(truths, &s, span);
            for (int side = 0; side < 2; side++) {
                double truth = (double)truths[side].value, h = side ? cell[c].below : cell[c].above;
                least[side] = fmin(least[side], h);
                // By Markov again, p = 4, d = 1/4: n_u within 1.3e-3, beside the |n_u| of about |S_u| / truth.
                double off = 1e-3 + 1e-3 * truth;
                if (truth > 3.0)
                    assert_true(h > 3.0); // flat: what limits T there is n's error as much as curvature
                else
                    near_below(h, truth, off), compared++;
            }
        }
        assert_true(all.above == least[0] && all.below == least[1]);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    assert_true(compared > 4 * surfaces);
    test_ctx_end(ctx, &memory);
}

// ---- guarantees ----

// det of T's own matrix in long double.
static long double direct_jacobian(const kn_shell *shell, double u, double v, double w)
{
    long double p[3], j[2][3], cross[3], n[9], c[3];
    direct_surface(p, j[0], j[1], cross, kn_shell_surface(shell), u, v);
    direct_spline(n, kn_shell_normal(shell), u, v);
    for (int d = 0; d < 2; d++)
        for (int k = 0; k < 3; k++) j[d][k] += w * n[3 * (d + 1) + k];
    for (int k = 0; k < 3; k++) c[k] = j[0][(k + 1) % 3] * j[1][(k + 2) % 3] - j[0][(k + 2) % 3] * j[1][(k + 1) % 3];
    return dot(c, n);
}

// Below the heights J is positive at every sample; above the most that could be safe it is not, next to the place.
static void samples_agree(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(41);
    for (int k = 1; k < SURFACE_CASES; k++) {
        kn_spline s;
        surface_cases[k].make(ctx, &s);
        kn_shell_options o = {.normal_tol = 1e-3};
        kn_shell *shell = create(ctx, &s, &o);
        kn_fold_heights h = overall(ctx, shell);
        double lo[2], hi[2];
        for (int v = 0; v < 2; v++) kn_spline_domain(&s, v, &lo[v], &hi[v]);
        for (int i = 0; i < test_scale(2000); i++) {
            // Away from poles, where J is 0 with S_u.
            double u = test_uniform(&rng, lo[0], hi[0]), v = test_uniform(&rng, lo[1] + 1e-6, hi[1] - 1e-6);
            double w = i % 2 ? fmin(h.above, 100.0) : -fmin(h.below, 100.0);
            if (i % 4 < 2) w *= test_uniform(&rng, 0.0, 1.0);
            if (!(direct_jacobian(shell, u, v, w) > 0.0L))
                fail_msg("%s: J is not positive at (%.17g, %.17g, %.17g)", surface_cases[k].name, u, v, w);
        }
        if (h.below_most < 100.0 && strcmp(surface_cases[k].name, "sphere") != 0) {
            double u = h.where_below[0], v = h.where_below[1];
            assert_true(direct_jacobian(shell, u, v, -1.001 * h.below_most) < 0.0L ||
                        direct_jacobian(shell, fmax(lo[0], u - 1e-9), fmax(lo[1], v - 1e-9), -1.001 * h.below_most) <
                            0.0L);
        }
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// Every patch of the teapot, the lid's pole included: positive heights on both sides, the same for any threads.
static void teapot(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1), *two = test_ctx(&memory, 3);
    kn_shell_options o = {.normal_tol = 1e-3};
    for (int k = 0; k < TEAPOT_PATCHES; k++) {
        kn_spline s;
        if (!make_teapot(ctx, &s, k)) skip();
        kn_shell *shell = create(ctx, &s, &o);
        kn_fold_heights h = overall(ctx, shell), again = overall(two, shell);
        assert_true(h.above > 0.01 && h.below > 0.001);
        assert_true(h.above >= 0.99 * h.above_most && h.below >= 0.99 * h.below_most);
        assert_memory_equal(&h, &again, sizeof h);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &s);
    }
    kn_ctx_destroy(two);
    test_ctx_end(ctx, &memory);
}

// ---- other kinds ----

// A cylinder of radius 1 whose heights count in thicknesses h(v) = 1/2 + v: J is 0 where 1 - h w is.
static void thickness(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double base[3] = {0, 0, 0}, axis[3] = {0, 0, 1}, ku[4] = {0, 0, 1, 1}, coef[4] = {0.5, 1.5, 0.5, 1.5};
    const double *knots[2] = {ku, ku};
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    kn_spline s = {0}, h = {0};
    assert_int_equal(kn_construct_cylinder(ctx, &s, base, axis, 1.0), KN_OK);
    assert_int_equal(kn_spline_init(ctx, &h, 2, 1, false, degree, count, knots, coef), KN_OK);
    kn_shell_options o = {.normal_tol = 1e-6, .thickness = &h};
    kn_shell *shell = create(ctx, &s, &o);
    kn_fold_heights all = overall(ctx, shell);
    near_below(all.below, 1.0 / 1.5, fit);
    assert_true(fabs(all.where_below[1] - 1.0) < 0.02);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &h);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static kn_fold_heights attracted(kn_ctx *ctx, const double field[12], int power)
{
    const double k[4] = {0, 0, 1, 1}, plane[12] = {0, 0, 1, 1, 0, 1, 0, 1, 0, 0, 0, 0};
    const double *knots[2] = {k, k};
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    kn_spline s = {0}, psi = {0};
    assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, degree, count, knots, plane), KN_OK);
    assert_int_equal(kn_spline_init(ctx, &psi, 2, 3, false, degree, count, knots, field), KN_OK);
    kn_shell_options o = {.attraction = &psi, .attraction_power = power};
    kn_shell *shell = create(ctx, &s, &o);
    kn_fold_heights h = overall(ctx, shell);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &psi);
    kn_spline_clear(ctx, &s);
    return h;
}

// Over the unit square with psi = (u - 1/2, 0, 0) w^k: T = (u + w^k (u - 1/2), v, w) has det 1 + w^k, without a zero
// above, and for even k none below; with psi turned it is 1 - w^k, zero at 1 and for even k at -1. No power of w but
// these two occurs: psi's other components are 0, and v does not change it.
static void attraction(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int sign = -1; sign <= 1; sign += 2)
        for (int power = 1; power <= 12; power++) {
            double field[12] = {-0.5 * sign, -0.5 * sign, 0.5 * sign, 0.5 * sign};
            kn_fold_heights h = attracted(ctx, field, power);
            bool above = sign < 0, below = power % 2 == 0 ? sign < 0 : sign > 0;
            if (above) near_below(h.above, 1.0, 1e-5);
            if (below) near_below(h.below, 1.0, 1e-5);
            if (!above) assert_true(h.above == INFINITY && h.above_most == INFINITY);
            if (!below) assert_true(h.below == INFINITY && h.below_most == INFINITY);
        }
    // A constant psi = (a, b, 1/50): det = 1 + k w^(k-1) / 50; its zero, below and for even k, at (50 / k)^(1 / (k -
    // 1)). n_u is 0 but for the fit's rounding, some 1e-13, which limits w alone.
    for (int power = 2; power <= 12; power++) {
        const double wind[12] = {0.3, 0.3, 0.3, 0.3, 0.1, 0.1, 0.1, 0.1, 0.02, 0.02, 0.02, 0.02};
        kn_fold_heights h = attracted(ctx, wind, power);
        assert_true(h.above > 1e9 && h.above_most == INFINITY);
        if (power % 2 == 0)
            near_below(h.below, pow(50.0 / power, 1.0 / (power - 1)), 1e-5);
        else
            assert_true(h.below > 1e9 && h.below_most == INFINITY);
    }
    // psi = (1,2,3) u / 10: det = 1 + w^7 / 10 + 21/10 w^6 u, where w^13 (psi_u x S_v) . psi is 0 by cancellation
    // alone: J_13 within some 1e-14 outweighs J_7 from about 100 on. No limit all the same.
    const double slanted[12] = {0, 0, 0.1, 0.1, 0, 0, 0.2, 0.2, 0, 0, 0.3, 0.3};
    kn_fold_heights h = attracted(ctx, slanted, 7);
    assert_true(h.above > 30.0 && h.above_most == INFINITY);
    test_ctx_end(ctx, &memory);
}

// (u, v, w - w^2 / 2) over [0,1]^2 x [0,2]: det 1 - w, zero at 1; in one span of w and in four. Left-handed: 0.
static void volumes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double k[4] = {0, 0, 1, 1}, kw[6] = {0, 0, 0, 2, 2, 2}, height[3] = {0, 1, 0}, more[3] = {0.5, 1.25, 1.5};
    const double *knots[3] = {k, k, kw};
    const int degree[3] = {1, 1, 2}, count[3] = {2, 2, 3};
    for (int round = 0; round < 4; round++) {
        kn_spline volume = {0};
        kn_shell *shell = NULL;
        double coef[36];
        for (int i = 0; i < 12; i++) {
            coef[i] = i / 6;
            coef[12 + i] = i / 3 % 2;
            coef[24 + i] = (round == 2 ? -1.0 : 1.0) * height[i % 3];
        }
        assert_int_equal(kn_spline_init(ctx, &volume, 3, 3, false, degree, count, knots, coef), KN_OK);
        if (round == 1) assert_int_equal(kn_spline_insert_knots(ctx, &volume, &volume, 2, more, 3), KN_OK);
        if (round == 3) { // half of it: no zero
            const double lo[3] = {0, 0, 0}, hi[3] = {1, 1, 0.875};
            assert_int_equal(kn_spline_restrict(ctx, &volume, &volume, lo, hi), KN_OK);
        }
        assert_int_equal(kn_shell_from_volume(ctx, &shell, &volume, NULL), KN_OK);
        kn_fold_heights h = overall(ctx, shell);
        assert_true(h.below == INFINITY);
        if (round < 2) near_below(h.above, 1.0, 1e-5);
        if (round == 2) assert_true(h.above == 0.0 && h.above_most == 0.0);
        if (round == 3) assert_true(h.above == INFINITY);
        kn_shell_destroy(ctx, shell);
        kn_spline_clear(ctx, &volume);
    }
    test_ctx_end(ctx, &memory);
}

// A cone of slope 45 degrees: above, the offset of the apex opens a cap; below it folds at once.
static void apex(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double base[3] = {0, 0, 0}, axis[3] = {0, 0, 1};
    kn_shell_options o = {.normal_tol = 1e-6};
    kn_spline s = {0};
    assert_int_equal(kn_construct_cone(ctx, &s, base, axis, 1.0, 0.0), KN_OK);
    kn_shell *shell = create(ctx, &s, &o);
    kn_fold_heights h = overall(ctx, shell);
    assert_true(h.above > 1e3);
    assert_true(h.below == 0.0 && fabs(h.where_below[1] - 1.0) < 1e-12);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

typedef struct held {
    kn_shell *shell;
} held;

static kn_status compute(kn_ctx *ctx, void *user)
{
    const held *h = user;
    kn_fold_heights all = {7, 7, 7, 7, {7, 7}, {7, 7}}, cell[4] = {{7, 7, 7, 7, {7, 7}, {7, 7}}};
    kn_status status = kn_fold_safe_heights(ctx, cell, &all, h->shell);
    if (status != KN_OK) assert_true(all.above == 7 && all.where_below[1] == 7 && cell[0].below == 7);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    held h = {0};
    make_cylinder(ctx, &s);
    kn_shell_options o = {.normal_tol = 0.05};
    h.shell = create(ctx, &s, &o);
    test_allocation_failures(compute, &h);
    kn_shell_destroy(ctx, h.shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(torus),
        cmocka_unit_test(cylinder_sphere_and_plane),
        cmocka_unit_test(random_surfaces),
        cmocka_unit_test(samples_agree),
        cmocka_unit_test(teapot),
        cmocka_unit_test(thickness),
        cmocka_unit_test(attraction),
        cmocka_unit_test(volumes),
        cmocka_unit_test(apex),
        cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests_name("fold/safe_heights", tests, NULL, NULL);
}
