// SPDX-License-Identifier: Apache-2.0
// The built-in floors, lattices and creatures, by what is proved of any tile: that they join, cover, face outwards
// and turn into each other. tests/io/t_tiles.c has the others.
#include "tests/support/support.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include <knurl/io.h>

typedef struct expected {
    const char *name;
    int parts, order[2];
    size_t open;
    bool covering;
    double shadow, volume; // area seen from above with sign, and the volume under or in it; NAN: not asked
} expected;

// cross: three struts of 1/4 x 1/4 that share a cube.
static const expected TILES[] = {
    {"fishbone", 2, {0, 0}, 0, true, 1, NAN},   {"leather", 1, {1, 1}, 0, true, 1, NAN},
    {"cross", 1, {2, 2}, 0, false, 0, 0.15625}, {"octet", 2, {0, 0}, 0, false, 0, NAN},
    {"gyroid", 1, {0, 0}, 48, false, NAN, NAN}, {"frame", 1, {2, 2}, 0, false, 0, NAN},
    {"flower", 1, {2, 2}, 0, true, 1, NAN},     {"bird", 1, {2, 2}, 0, false, 0, NAN},
    {"fish", 1, {2, 2}, 0, false, 0, NAN},      {"birdfish", 1, {2, 2}, 0, false, 0, NAN},
    {"ant", 2, {2, 2}, 0, false, 0, NAN},
};
enum { NTILES = sizeof TILES / sizeof *TILES };

static void at_values(kn_ctx *ctx, kn_tile *out, const char *name, int at_target)
{
    kn_tile tile;
    double values[8];
    assert_int_equal(kn_builtin_tile(ctx, &tile, name), KN_OK);
    assert_true(tile.nparameters <= 8);
    for (int k = 0; k < tile.nparameters; k++)
        values[k] = k == at_target ? tile.parameters[k].target : tile.parameters[k].value;
    assert_int_equal(kn_tile_vary(ctx, out, &tile, values), KN_OK);
    kn_tile_clear(ctx, &tile);
}

static void the_list_has_them(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    int count = kn_builtin_tile_count();
    for (int i = 0; i < NTILES; i++) {
        kn_tile tile;
        bool listed = false;
        for (int k = 0; k < count; k++) listed = listed || strcmp(kn_builtin_tile_name(k), TILES[i].name) == 0;
        assert_true(listed);
        assert_int_equal(kn_builtin_tile(ctx, &tile, TILES[i].name), KN_OK);
        assert_int_equal(kn_tile_check(ctx, &tile), KN_OK);
        assert_int_equal(tile.nparts, TILES[i].parts);
        assert_true(tile.covering == TILES[i].covering && tile.about[0] && tile.aspect > 0);
        kn_tile_clear(ctx, &tile);
    }
    test_ctx_end(ctx, &memory);
}

// At their values, and with each parameter at its target.
static void they_join(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int i = 0; i < NTILES; i++) {
        kn_tile named;
        assert_int_equal(kn_builtin_tile(ctx, &named, TILES[i].name), KN_OK);
        for (int k = -1; k < named.nparameters; k++) {
            kn_tile tile;
            kn_tile_periodicity_report r;
            at_values(ctx, &tile, TILES[i].name, k);
            assert_int_equal(kn_tile_periodicity(ctx, &r, &tile, NULL), KN_OK);
            for (int d = 0; d < 2; d++) {
                if (k < 0) assert_int_equal(r.order[d], TILES[i].order[d]);
                assert_true(r.order[d] >= 0 && r.decided[d]);
            }
            assert_int_equal(r.open, TILES[i].open);
            assert_true(r.crowded == 0 && r.reversed == 0 && r.unchecked == 0);
            kn_tile_clear(ctx, &tile);
        }
        kn_tile_clear(ctx, &named);
    }
    test_ctx_end(ctx, &memory);
}

static void sheets_cover(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int i = 0; i < NTILES; i++) {
        kn_tile tile;
        kn_tile_coverage_report r;
        const kn_tile_coverage_options rough = {.depth = 4};
        assert_int_equal(kn_builtin_tile(ctx, &tile, TILES[i].name), KN_OK);
        if (TILES[i].covering) {
            assert_int_equal(kn_tile_coverage(ctx, &r, &tile, &rough), KN_OK);
            assert_true(r.covers == KN_YES && r.boxes == 0);
            kn_tile_coverage_clear(ctx, &r);
        }
        kn_tile_clear(ctx, &tile);
    }
    test_ctx_end(ctx, &memory);
}

// Integrals of du dv and w du dv over a surface's pieces, exact with three Gauss points for degrees up to 5.
static void add_surface(kn_ctx *ctx, double sums[2], const kn_spline *s)
{
    const double x[3] = {0.5 - sqrt(0.15), 0.5, 0.5 + sqrt(0.15)}, weight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    kn_bezier *list = NULL;
    size_t n = 0;
    assert_int_equal(kn_spline_to_bezier(ctx, &list, &n, s), KN_OK);
    for (size_t k = 0; k < n; k++) {
        for (int i = 0; i < 9; i++) {
            double at[2] = {x[i / 3], x[i % 3]}, d[9];
            assert_int_equal(kn_bezier_derivatives(ctx, d, &list[k], at, 1), KN_OK);
            double cross = (d[3] * d[7] - d[4] * d[6]) * weight[i / 3] * weight[i % 3];
            sums[0] += cross, sums[1] += cross * d[2];
        }
        kn_bezier_clear(ctx, &list[k]);
    }
    kn_free(ctx, list);
}

// The determinant of the derivatives of a trilinear piece at its eight corners: positive at all, and, as it is of
// degree 2 in each variable, their mean is the volume only of parallelepipeds, which these are.
static double volume_of(kn_ctx *ctx, const kn_spline *s)
{
    double sum = 0;
    for (int k = 0; k < 8; k++) {
        double at[3] = {k >> 2, k >> 1 & 1, k & 1}, d[12];
        assert_int_equal(kn_spline_derivatives(ctx, d, s, at, 1), KN_OK);
        const double *a = d + 3, *b = d + 6, *c = d + 9;
        double det = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                     a[2] * (b[0] * c[1] - b[1] * c[0]);
        assert_true(det > 0);
        sum += det / 8;
    }
    return sum;
}

// A closed body has no shadow with sign, and its volume is positive only if it faces outwards. Sums of at most 500
// pieces of 9 terms of size at most 1.
static void bodies_face_outwards(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int i = 0; i < NTILES; i++) {
        kn_tile tile;
        double sums[2] = {0, 0}, volume = 0;
        assert_int_equal(kn_builtin_tile(ctx, &tile, TILES[i].name), KN_OK);
        for (int p = 0; p < tile.nparts; p++)
            for (int s = 0; s < tile.parts[p].nsplines; s++) {
                const kn_spline *spline = &tile.parts[p].splines[s];
                double one[2] = {0, 0};
                if (spline->nvars == 3)
                    volume += volume_of(ctx, spline);
                else
                    add_surface(ctx, one, spline);
                if (strcmp(TILES[i].name, "ant") == 0) assert_true(one[1] > 0); // each for itself
                sums[0] += one[0], sums[1] += one[1];
            }
        if (!isnan(TILES[i].shadow)) assert_true(fabs(sums[0] - TILES[i].shadow) < 500 * 9 * 20 * DBL_EPSILON);
        if (!isnan(TILES[i].volume)) assert_true(fabs(volume - TILES[i].volume) < 1e-14);
        if (volume == 0 && !isnan(TILES[i].shadow)) assert_true(sums[1] > 0.005 && sums[1] < 0.98);
        if (strcmp(TILES[i].name, "octet") == 0) {
            // With r = 3/64, in units of the aspect 5/4: six dodecahedra of 16 r^3, and 28 struts from face to face,
            // a face's area 2 sqrt(2) r^2 times its distance from the other one, sqrt(1/2) - 2 sqrt(2) r.
            const double r = 0.046875;
            double exact = (6 * 16 * r * r * r + 28 * 2 * sqrt(2) * r * r * (sqrt(0.5) - 2 * sqrt(2) * r)) / 1.25;
            assert_true(fabs(volume - exact) < 2e-3 * exact); // control points are on a grid of 2^-12
        }
        kn_tile_clear(ctx, &tile);
    }
    test_ctx_end(ctx, &memory);
}

static void same(const kn_tile *a, const kn_tile *b)
{
    assert_int_equal(a->nparts, b->nparts);
    for (int p = 0; p < a->nparts; p++) {
        assert_int_equal(a->parts[p].nsplines, b->parts[p].nsplines);
        for (int s = 0; s < a->parts[p].nsplines; s++) {
            const kn_spline *x = &a->parts[p].splines[s], *y = &b->parts[p].splines[s];
            for (int d = 0; d < 2; d++) {
                assert_int_equal(x->degree[d], y->degree[d]);
                assert_int_equal(x->count[d], y->count[d]);
                assert_memory_equal(x->knots[d], y->knots[d],
                                    (size_t)(x->count[d] + x->degree[d] + 1) * sizeof(double));
            }
            size_t n = 3 * kn_spline_count(x);
            for (size_t k = 0; k < n; k++) assert_true(x->coef[k] == y->coef[k]);
        }
    }
}

// flower without bloom is the thorn; birdfish is the bird and becomes the fish. Coordinates are short binary
// fractions, so that the blend is exact at its ends.
static void they_turn_into_each_other(void **state)
{
    (void)state;
    static const struct {
        const char *from, *to;
        int at_target;
    } list[] = {{"flower", "thorn", 0}, {"birdfish", "bird", -1}, {"birdfish", "fish", 0}};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        kn_tile a, b;
        at_values(ctx, &a, list[i].from, list[i].at_target);
        at_values(ctx, &b, list[i].to, -1);
        same(&a, &b);
        kn_tile_clear(ctx, &a);
        kn_tile_clear(ctx, &b);
    }
    test_ctx_end(ctx, &memory);
}

// The lowest points of the ant are its feet: six of the legs come down to the base, bodies and feelers do not.
static void the_ant_stands(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile;
    assert_int_equal(kn_builtin_tile(ctx, &tile, "ant"), KN_OK);
    int feet = 0;
    for (int p = 0; p < tile.nparts; p++)
        for (int s = 0; s < tile.parts[p].nsplines; s++) {
            double lowest = 1;
            for (int k = 0; k <= 40; k++)
                for (int j = 0; j <= 40; j++) {
                    const kn_spline *spline = &tile.parts[p].splines[s];
                    double lo[2], hi[2], at[2], x[3];
                    for (int d = 0; d < 2; d++) kn_spline_domain(spline, d, &lo[d], &hi[d]);
                    at[0] = lo[0] + (hi[0] - lo[0]) * k / 40, at[1] = lo[1] + (hi[1] - lo[1]) * j / 40;
                    assert_int_equal(kn_spline_eval(ctx, x, spline, at), KN_OK);
                    lowest = fmin(lowest, x[2]);
                }
            bool stands = lowest < 0.03;
            assert_true(lowest > -0.01 && (stands || lowest > 0.05));
            assert_true(!stands || p == 1);
            feet += stands;
        }
    assert_int_equal(feet, 6);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_list_has_them),
        cmocka_unit_test(they_join),
        cmocka_unit_test(sheets_cover),
        cmocka_unit_test(bodies_face_outwards),
        cmocka_unit_test(they_turn_into_each_other),
        cmocka_unit_test(the_ant_stands),
    };
    return cmocka_run_group_tests_name("io/tile_bodies", tests, NULL, NULL);
}
