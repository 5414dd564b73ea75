// SPDX-License-Identifier: Apache-2.0
// kn_cells_relax: a known answer, energies that fall, folds, edges, held lines, and every failure.
#include "tests/cells/scene.h"
#include "tests/support/support.h"

#include "cells/relax.h"
#include <knurl/compose.h>
#include <knurl/construct.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double k1[] = {0, 0, 1, 1}, k2[] = {0, 0, 0, 1, 1, 1};
static const double origin[3] = {0}, axis[3] = {0, 0, 2};

// (u, v + c u v (1 - v), 0): the unit square, whose lines of constant v are not those of constant height.
static void sheared_square(kn_ctx *ctx, kn_spline *out, double c)
{
    const double *knots[2] = {k1, k2};
    const double coef[18] = {0, 0, 0, 1, 1, 1, 0, 0.5, 1, 0, 0.5 * (1 + c), 1, 0, 0, 0, 0, 0, 0};
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, (const int[]){1, 2}, (const int[]){2, 3}, knots, coef),
                     KN_OK);
}

// A height field that stretches.
static void hills(double p[3], double u, double v)
{
    p[0] = u + 0.3 * u * (1 - u) * v;
    p[1] = v * v + 0.2 * v + 0.1 * sin(4 * u) * v * (1 - v);
    p[2] = 0.2 * sin(5 * u) * cos(4 * v);
}

static void make(kn_ctx *ctx, kn_spline *out, int which)
{
    if (which == 0) sheared_square(ctx, out, 0.7);
    if (which == 1) scene_hills(ctx, out, hills);
    if (which == 2) assert_int_equal(kn_construct_cone(ctx, out, origin, axis, 1, 0.2), KN_OK);
    if (which == 3) assert_int_equal(kn_construct_sphere(ctx, out, origin, 1), KN_OK);
    if (which == 4) assert_int_equal(kn_construct_cone(ctx, out, origin, axis, 1, 0), KN_OK);
    if (which == 5) assert_int_equal(kn_construct_torus(ctx, out, origin, axis, 3, 1), KN_OK);
}
enum { SURFACES = 6 };

static kn_cells_relax_options options_for(int which)
{
    kn_cells_relax_options o = {.iterations = 0};
    o.closed[0] = which >= 2, o.closed[1] = which == 5;
    return o;
}

// The corners of a bilinear map, as an array of kn_corner_grid has them.
static double *corners_of(const kn_spline *map)
{
    size_t n = kn_spline_count(map);
    double *c = malloc(2 * n * sizeof *c);
    assert_non_null(c);
    for (size_t k = 0; k < n; k++) c[2 * k] = map->coef[k], c[2 * k + 1] = map->coef[n + k];
    return c;
}

// Where the answer is known: corner (i,j) at u = i/n, v + c u v (1 - v) = j/n, up to terms of second order: the
// energy sees parts of cells, whose middles a bilinear map in (u,v) does not take to the middles of squares, but off by the
// bend of S over a cell, of the size c/n^2. So corners are wrong by a multiple of that, for all n the same one, and
// areas, relative to 1/n^2, by one order less.
static void known_square(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0}, map = {0}, out = {0};
    const double c = 0.7;
    sheared_square(ctx, &s, c);
    for (int n = 6; n <= 24; n *= 2) {
        double worst = 0.0, area = 0.0;
        kn_cells_spread spread;
        assert_int_equal(kn_cells_relax(ctx, &map, &s, (const int[]){n, n}, NULL), KN_OK);
        assert_true(map.degree[0] == 1 && map.degree[1] == 1 && map.count[0] == n + 1 && map.ncomp == 2);
        double *at = corners_of(&map);
        for (int i = 0; i <= n; i++)
            for (int j = 0; j <= n; j++) {
                double u = (double)i / n, b = 1 + c * u, y = (double)j / n;
                double v = u > 0 ? (b - sqrt(b * b - 4 * c * u * y)) / (2 * c * u) : y;
                const double *k = at + 2 * (i * (n + 1) + j);
                worst = fmax(worst, fmax(fabs(k[0] - u), fabs(k[1] - v)));
            }
        assert_true(worst <= 1.5 * c / n / n);
        free(at);
        assert_int_equal(kn_cells_compose(ctx, &out, &s, &map), KN_OK);
        assert_int_equal(kn_cells_measure(ctx, &spread, &out, NULL, NULL), KN_OK);
        assert_true(spread.cells == (size_t)n * (size_t)n);
        area = spread.area.max / spread.area.min;
        assert_true(area >= 1 && area <= 1 + 0.5 * c / n);
    }
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map), kn_spline_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

// The derivative that the search follows, against differences of the energy along random directions.
static void gradients(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(41);
    kn_spline s = {0};
    scene_hills(ctx, &s, hills);
    enum { N = 5, ALL = 2 * (N + 1) * (N + 1) };
    char held[2][N + 1] = {{0}};
    held[0][2] = 1;
    double corners[ALL], gradient[ALL], moved[ALL], direction[ALL], ignored[ALL], e, up, down;
    kn_corner_grid g = {.surface = &s, .n = {N, N}, .held = {held[0], held[1]}, .corners = corners, .area = 4};
    g.size[0] = 0.2, g.size[1] = 0.25;
    double *room = malloc(kn_relax_room(&g) * sizeof *room);
    assert_non_null(room);
    for (int k = 0; k < ALL; k += 2) {
        int i = k / 2 / (N + 1), j = k / 2 % (N + 1);
        corners[k] = (double)i / N + (kn_corner_moves(&g, i, j, 0) ? test_uniform(&rng, -0.05, 0.05) : 0);
        corners[k + 1] = (double)j / N + (kn_corner_moves(&g, i, j, 1) ? test_uniform(&rng, -0.05, 0.05) : 0);
    }
    assert_int_equal(kn_relax_energy(ctx, &e, gradient, &g, corners, room), KN_OK);
    for (int round = 0; round < 20; round++) {
        double slope = 0.0, step = 1e-6;
        for (int k = 0; k < ALL; k++) {
            bool moves = kn_corner_moves(&g, k / 2 / (N + 1), k / 2 % (N + 1), k % 2);
            direction[k] = moves ? test_uniform(&rng, -1, 1) : 0.0;
            slope += direction[k] * gradient[k];
            assert_true(moves || gradient[k] == 0);
        }
        for (int k = 0; k < ALL; k++) moved[k] = corners[k] + step * direction[k];
        assert_int_equal(kn_relax_energy(ctx, &up, ignored, &g, moved, room), KN_OK);
        for (int k = 0; k < ALL; k++) moved[k] = corners[k] - step * direction[k];
        assert_int_equal(kn_relax_energy(ctx, &down, ignored, &g, moved, room), KN_OK);
        // third derivatives about (5 n)^3 times the energy times step^2, and rounding of the energy over the step
        assert_true(fabs((up - down) / (2 * step) - slope) <= 1e-5 * (fabs(slope) + e));
    }
    free(room);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// cross products of all four corners of all cells, in long double, which holds products of differences of doubles
static bool unfolded_directly(const double *at, const int n[2])
{
    for (int i = 0; i < n[0]; i++)
        for (int j = 0; j < n[1]; j++) {
            const int ring[4][2] = {{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}};
            for (int k = 0; k < 4; k++) {
                const double *a = at + 2 * (ring[k][0] * (n[1] + 1) + ring[k][1]);
                const double *b = at + 2 * (ring[(k + 1) % 4][0] * (n[1] + 1) + ring[(k + 1) % 4][1]);
                const double *c = at + 2 * (ring[(k + 3) % 4][0] * (n[1] + 1) + ring[(k + 3) % 4][1]);
                long double x = ((long double)b[0] - a[0]) * ((long double)c[1] - a[1]);
                if (!(x - ((long double)b[1] - a[1]) * ((long double)c[0] - a[0]) > 0)) return false;
            }
        }
    return true;
}

static double energy_of(kn_ctx *ctx, const kn_spline *s, const kn_spline *map, const kn_corner_grid *like)
{
    double *at = corners_of(map), e;
    kn_corner_grid g = *like;
    double *room = malloc((kn_relax_room(&g) + 2 * kn_corner_count(&g)) * sizeof *room);
    assert_non_null(room);
    g.surface = s;
    assert_int_equal(kn_relax_energy(ctx, &e, room, &g, at, room + 2 * kn_corner_count(&g)), KN_OK);
    free(at), free(room);
    return e;
}

// More iterations never give more energy, nothing folds, edges and held lines stay.
static void falls(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int n[2] = {12, 10};
    for (int which = 0; which < SURFACES; which++) {
        kn_spline s = {0}, map = {0}, again = {0};
        char held[2][13] = {{0}};
        make(ctx, &s, which);
        kn_cells_relax_options o = options_for(which);
        kn_corner_grid g = {.n = {n[0], n[1]}, .closed = {o.closed[0], o.closed[1]}, .area = 4};
        g.held[0] = held[0], g.held[1] = held[1], g.size[0] = g.size[1] = 0.3;
        double before = INFINITY, *first = NULL;
        for (int k = 1; k <= 64; k *= 4) {
            o.iterations = k;
            assert_int_equal(kn_cells_relax(ctx, &map, &s, n, &o), KN_OK);
            double *at = corners_of(&map);
            assert_true(unfolded_directly(at, n));
            // the search's own size of cells is not ours: 0.3 is near it, and what it gains it gains here
            double e = energy_of(ctx, &s, &map, &g);
            assert_true(isfinite(e) && e <= before * 1.02);
            before = fmin(e, before);
            for (int i = 0; i <= n[0]; i++)
                for (int j = 0; j <= n[1]; j++) {
                    const double *c = at + 2 * (i * (n[1] + 1) + j);
                    if (i == 0 || i == n[0]) assert_true(c[0] == (i == 0 ? 0 : 1));
                    if (j == 0 || j == n[1]) assert_true(c[1] == (j == 0 ? 0 : 1));
                    if (o.closed[0] && i == n[0]) assert_true(c[1] == at[2 * j + 1]);
                    if (o.closed[1] && j == n[1]) assert_true(c[0] == at[2 * i * (n[1] + 1)]);
                }
            for (int q = 1; which >= 2 && q < 4; q++) { // the quarters of the circle are lines still
                int line = -1;
                for (int i = 0; i <= n[0]; i++)
                    if (at[2 * i * (n[1] + 1)] == q / 4.0) line = i;
                assert_true(line > 0);
                for (int j = 0; j <= n[1]; j++) assert_true(at[2 * (line * (n[1] + 1) + j)] == q / 4.0);
            }
            free(first);
            first = at;
        }
        assert_int_equal(kn_cells_relax(ctx, &again, &s, n, &o), KN_OK);
        assert_memory_equal(again.coef, map.coef, 2 * kn_spline_count(&map) * sizeof *map.coef);
        free(first);
        kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map), kn_spline_clear(ctx, &again);
    }
    test_ctx_end(ctx, &memory);
}

// What is wanted: areas of cells come out more even than between even lines, by the quadrature of kn_cells_measure.
static void evener(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const int n[2] = {12, 12};
    for (int which = 0; which < SURFACES; which++) {
        kn_spline s = {0}, map = {0}, out = {0};
        kn_cells_spread even, free_corners;
        double *lines[2];
        make(ctx, &s, which);
        kn_cells_relax_options o = options_for(which);
        o.all_knots = true;
        for (int d = 0; d < 2; d++) assert_int_equal(kn_cells_even_lines(ctx, &lines[d], &s, d, n[d]), KN_OK);
        assert_int_equal(kn_cells_measure(ctx, &even, &s, (const double *const[]){lines[0], lines[1]},
                                          (const int[]){n[0] + 1, n[1] + 1}),
                         KN_OK);
        assert_int_equal(kn_cells_relax(ctx, &map, &s, n, &o), KN_OK);
        assert_int_equal(kn_cells_compose(ctx, &out, &s, &map), KN_OK);
        assert_int_equal(kn_cells_measure(ctx, &free_corners, &out, NULL, NULL), KN_OK);
        assert_true(free_corners.cells == even.cells);
        assert_true(fabs(free_corners.area.mean - even.area.mean) <= 1e-9 * even.area.mean); // the same surface
        assert_true(free_corners.area.max / free_corners.area.min < even.area.max / even.area.min);
        for (int d = 0; d < 2; d++) kn_free(ctx, lines[d]);
        kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map), kn_spline_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

// fixed: corners on the edges are where even lines put them, bit for bit; fewer cells than knot spans.
static void fixed(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0}, map = {0};
    double *lines[2];
    const int n[2] = {9, 7};
    scene_hills(ctx, &s, hills);
    const kn_cells_relax_options o = {.fixed = {{true, true}, {true, true}}};
    assert_int_equal(kn_cells_relax(ctx, &map, &s, n, &o), KN_OK);
    for (int d = 0; d < 2; d++) assert_int_equal(kn_cells_even_lines(ctx, &lines[d], &s, d, n[d]), KN_OK);
    double *at = corners_of(&map);
    bool moved = false;
    for (int i = 0; i <= n[0]; i++)
        for (int j = 0; j <= n[1]; j++) {
            const double *c = at + 2 * (i * (n[1] + 1) + j);
            bool same = c[0] == lines[0][i] && c[1] == lines[1][j];
            if (i == 0 || j == 0 || i == n[0] || j == n[1])
                assert_true(same);
            else
                moved = moved || !same;
        }
    assert_true(moved);
    assert_int_equal(kn_cells_relax(ctx, &map, &s, (const int[]){3, 2}, NULL), KN_OK);
    assert_true(map.count[0] == 4 && map.count[1] == 3);
    free(at);
    at = corners_of(&map);
    assert_true(unfolded_directly(at, (const int[]){3, 2}));
    free(at);
    assert_int_equal(kn_cells_relax(ctx, &map, &s, (const int[]){1, 1}, NULL), KN_OK);
    const double corners[8] = {0, 0, 1, 1, 0, 1, 0, 1};
    assert_memory_equal(map.coef, corners, sizeof corners);
    for (int d = 0; d < 2; d++) kn_free(ctx, lines[d]);
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map);
    test_ctx_end(ctx, &memory);
}

// A kink of S, at which the speed jumps as well: the line stays on it, and the smooth map has its own kink there, so
// that cells on both sides are of one height: 1 in [0,1] and 3 in [1,2] share 8 rows as 2 and 6.
static void kink(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double k[] = {0, 0, 1, 2, 2}, *knots[2] = {k1, k};
    const double coef[18] = {0, 0, 0, 1, 1, 1, 0, 1, 1, 0, 1, 1, 0, 0, 3, 0, 0, 3};
    kn_spline s = {0}, map = {0};
    assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, (const int[]){1, 1}, (const int[]){2, 3}, knots, coef),
                     KN_OK);
    const kn_cells_relax_options o = {.smooth = true};
    assert_int_equal(kn_cells_relax(ctx, &map, &s, (const int[]){4, 8}, &o), KN_OK);
    for (int j = 0; j <= 80; j++) {
        double at[2] = {1.3, j / 10.0}, uv[2];
        assert_int_equal(kn_spline_eval(ctx, uv, &map, at), KN_OK);
        double want = at[1] <= 2 ? at[1] / 2 : 1 + (at[1] - 2) / 6;
        assert_true(fabs(uv[1] - want) <= 1e-12 && fabs(uv[0] - at[0] / 4) <= 1e-12); // no strain: even lines stay
    }
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map);
    test_ctx_end(ctx, &memory);
}

// Lines of the caller's: three edges stay on them, corners of the fourth slide.
static void given(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0}, map = {0};
    const double lines[2][6] = {{0, 0.1, 0.3, 0.6, 0.8, 1}, {0, 0.3, 0.4, 0.6, 1}};
    const int n[2] = {5, 4};
    scene_hills(ctx, &s, hills);
    const kn_cells_relax_options o = {.lines = {lines[0], lines[1]}, .fixed = {{true, false}, {true, true}}};
    assert_int_equal(kn_cells_relax(ctx, &map, &s, n, &o), KN_OK);
    double *at = corners_of(&map);
    for (int i = 0; i <= n[0]; i++)
        for (int j = 0; j <= n[1]; j++) {
            const double *c = at + 2 * (i * (n[1] + 1) + j);
            bool same = c[0] == lines[0][i] && c[1] == lines[1][j];
            if (i == 0 || j == 0 || j == n[1])
                assert_true(same);
            else
                assert_true(!same && (i < n[0] || c[0] == 1));
        }
    free(at);
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map);
    test_ctx_end(ctx, &memory);
}

// The smooth map: C2, onto the domain, through the corners, positive determinant at many places, held lines held.
static void smooth(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(42);
    const int n[2] = {12, 10};
    for (int which = 0; which < SURFACES; which++) {
        kn_spline s = {0}, map = {0}, flat = {0};
        make(ctx, &s, which);
        kn_cells_relax_options o = options_for(which);
        assert_int_equal(kn_cells_relax(ctx, &flat, &s, n, &o), KN_OK);
        o.smooth = true;
        assert_int_equal(kn_cells_relax(ctx, &map, &s, n, &o), KN_OK);
        assert_true(map.degree[0] == 3 && map.degree[1] == 3 && map.count[0] >= n[0] + 3);
        assert_int_equal(kn_spline_spans(&map, 0), n[0]);
        bool through = true;
        for (int i = 0; i <= n[0]; i++)
            for (int j = 0; j <= n[1]; j++) {
                double at[2] = {i, j}, a[2], b[2];
                assert_int_equal(kn_spline_eval(ctx, a, &map, at), KN_OK);
                assert_int_equal(kn_spline_eval(ctx, b, &flat, at), KN_OK);
                through = through && fabs(a[0] - b[0]) <= 1e-13 && fabs(a[1] - b[1]) <= 1e-13;
                for (int d = 0; d < 2; d++) // edges and, of circles, quarters: rounding of a cubic's interpolation
                    if (b[d] == 0 || b[d] == 1 || (d == 0 && which >= 2 && fmod(4 * b[d], 1) == 0))
                        assert_true(fabs(a[d] - b[d]) <= 1e-14);
            }
        assert_true(through || which == 1); // corners are moved back only where the spline through them folds
        for (int k = 0; k < 2000; k++) {
            double at[2] = {test_uniform(&rng, 0, n[0]), test_uniform(&rng, 0, n[1])}, p[6];
            assert_int_equal(kn_spline_derivatives(ctx, p, &map, at, 1), KN_OK);
            assert_true(p[2] * p[5] - p[3] * p[4] > 0);
            assert_true(p[0] >= -1e-15 && p[0] <= 1 + 1e-15 && p[1] >= -1e-15 && p[1] <= 1 + 1e-15);
        }
        if (o.closed[0]) // the derivatives at both ends of the seam; 20 cells further on corners count 0.27^20
            for (int k = 0; k < 20; k++) {
                double at[2] = {0, test_uniform(&rng, 0, n[1])}, a[6], b[6];
                assert_int_equal(kn_spline_derivatives(ctx, a, &map, at, 1), KN_OK);
                at[0] = n[0];
                assert_int_equal(kn_spline_derivatives(ctx, b, &map, at, 1), KN_OK);
                for (int c = 2; c < 6; c++) assert_true(fabs(a[c] - b[c]) <= 1e-12);
            }
        kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map), kn_spline_clear(ctx, &flat);
    }
    kn_spline s = {0}, map = {0};
    sheared_square(ctx, &s, 0.5);
    const kn_cells_relax_options o = {.smooth = true};
    for (int k = 1; k <= 4; k++) {
        assert_int_equal(kn_cells_relax(ctx, &map, &s, (const int[]){k, 5 - k}, &o), KN_OK);
        assert_true(map.degree[0] == 3 && map.degree[1] == 3);
        assert_int_equal(kn_spline_spans(&map, 0), k);
    }
    kn_spline_clear(ctx, &s);
    scene_hills(ctx, &s,
                hills); // few cells of uneven sizes: cubics through their corners fold, and control points do not
    for (int k = 1; k <= 4; k++) assert_int_equal(kn_cells_relax(ctx, &map, &s, (const int[]){3, k}, &o), KN_OK);
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map);
    test_ctx_end(ctx, &memory);
}

static int stop(void *user, const char *stage, double fraction)
{
    (void)user, (void)stage, (void)fraction;
    return 1;
}

static void refused(kn_ctx *ctx, kn_status want, const kn_spline *s, const int n[2], const kn_cells_relax_options *o)
{
    kn_spline map = {0};
    assert_int_equal(kn_cells_relax(ctx, &map, s, n, o), want);
    assert_true(map.coef == NULL);
    assert_true(kn_ctx_error(ctx) == want && strlen(kn_ctx_message(ctx)) > 8);
    kn_ctx_clear_error(ctx);
}

static void fails(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0}, curve = {0}, cone = {0}, point = {0};
    const int n[2] = {4, 4};
    scene_hills(ctx, &s, hills);
    refused(ctx, KN_EDOMAIN, &s, (const int[]){0, 4}, NULL);
    refused(ctx, KN_EDOMAIN, &s, (const int[]){4, -1}, NULL);
    refused(ctx, KN_ELIMIT, &s, (const int[]){1 << 20, 1 << 20}, NULL);
    refused(ctx, KN_EDOMAIN, &s, n, &(kn_cells_relax_options){.iterations = -1});
    refused(ctx, KN_EDOMAIN, &s, n, &(kn_cells_relax_options){.area = -1});
    refused(ctx, KN_EDOMAIN, &s, n, &(kn_cells_relax_options){.area = NAN});
    refused(ctx, KN_EDOMAIN, &s, (const int[]){3, 3}, &(kn_cells_relax_options){.all_knots = true});
    const double few[5] = {0, 0.2, 0.4, 0.7, 1}, late[5] = {0.1, 0.2, 0.4, 0.7, 1}, back[5] = {0, 0.4, 0.2, 0.7, 1};
    refused(ctx, KN_EDOMAIN, &s, n, &(kn_cells_relax_options){.lines = {late, NULL}});
    refused(ctx, KN_EDOMAIN, &s, n, &(kn_cells_relax_options){.lines = {NULL, back}});
    refused(ctx, KN_EDOMAIN, &s, n, &(kn_cells_relax_options){.lines = {few, NULL}, .all_knots = true});
    assert_int_equal(kn_construct_line(ctx, &curve, 3, origin, axis), KN_OK);
    refused(ctx, KN_EDOMAIN, &curve, n, NULL);
    assert_int_equal(kn_construct_cone(ctx, &cone, origin, axis, 1, 0.5), KN_OK);
    refused(ctx, KN_EDOMAIN, &cone, (const int[]){3, 3}, NULL); // four quarters
    assert_int_equal(kn_spline_copy(ctx, &point, &s), KN_OK);
    memset(point.coef, 0, 3 * kn_spline_count(&point) * sizeof *point.coef);
    refused(ctx, KN_EDOMAIN, &point, n, NULL);
    kn_ctx *impatient;
    assert_int_equal(kn_ctx_create(&impatient, &(kn_ctx_options){.progress = stop}), KN_OK);
    refused(impatient, KN_ECANCELLED, &s, n, NULL);
    kn_ctx_destroy(impatient);
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &curve), kn_spline_clear(ctx, &cone), kn_spline_clear(ctx, &point);
    test_ctx_end(ctx, &memory);
}

static kn_status short_of_memory(kn_ctx *ctx, void *user)
{
    const kn_cells_relax_options *o = user;
    kn_spline s = {0}, map = {0};
    kn_status status = kn_construct_cone(ctx, &s, origin, axis, 1, 0.5);
    if (status == KN_OK) status = kn_cells_relax(ctx, &map, &s, (const int[]){4, 2}, o);
    assert_true((status == KN_OK) == (map.coef != NULL));
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map);
    return status;
}

static void memory_fails(void **state)
{
    (void)state;
    kn_cells_relax_options o = {.iterations = 2, .closed = {true, false}};
    test_allocation_failures(short_of_memory, &o);
    o.smooth = true;
    test_allocation_failures(short_of_memory, &o);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_square), cmocka_unit_test(gradients), cmocka_unit_test(falls),
        cmocka_unit_test(evener),       cmocka_unit_test(fixed),     cmocka_unit_test(given),
        cmocka_unit_test(kink),         cmocka_unit_test(smooth),    cmocka_unit_test(fails),
        cmocka_unit_test(memory_fails),
    };
    return cmocka_run_group_tests_name("cells/relax", tests, NULL, NULL);
}
