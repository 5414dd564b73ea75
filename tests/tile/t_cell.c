// SPDX-License-Identifier: Apache-2.0
// kn_tile_set_cell: a tile in coordinates of its own.
#include "tests/support/support.h"

#include <knurl/tile.h>

#include <math.h>
#include <string.h>

static const double at[12] = {2, 2, 6, 6, 1, 3, 1, 3, 0, 1, 2, 4}; // u, v, w of a bilinear patch

static void make_patch(kn_ctx *ctx, kn_spline *out, double lift)
{
    static const double knots[] = {0, 0, 1, 1};
    double coef[12];
    for (int i = 0; i < 12; i++) coef[i] = at[i] + (i < 8 ? 0 : lift);
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, (const int[]){1, 1}, (const int[]){2, 2},
                                    (const double *const[]){knots, knots}, coef),
                     KN_OK);
}

// A patch and a triangle, and a parameter that lifts both.
static void make_tile(kn_ctx *ctx, kn_tile *tile)
{
    double position[9] = {2, 1, 0, 6, 1, 4, 2, 3, 2}, normal[9] = {0, 0, 1, 0.6, 0, 0.8, 0, 0, 1}, moved[9];
    uint32_t triangle[3] = {0, 1, 2};
    kn_mesh mesh = {.nvertices = 3, .ntriangles = 1, .position = position, .normal = normal, .triangle = triangle};
    kn_spline patch = {0}, target = {0};
    make_patch(ctx, &patch, 0);
    make_patch(ctx, &target, 2);
    for (int i = 0; i < 9; i++) moved[i] = position[i] + (i % 3 == 2 ? 2 : 0);
    assert_int_equal(kn_tile_init(ctx, tile, "t", 1), KN_OK);
    assert_int_equal(kn_tile_add(ctx, tile, 0, &patch), KN_OK);
    assert_int_equal(kn_tile_set_mesh(ctx, tile, 0, &mesh), KN_OK);
    assert_int_equal(kn_tile_add_parameter(ctx, tile, "lift", 0, 1, 0, 1), KN_OK);
    assert_int_equal(kn_tile_set_target(ctx, tile, 0, 0, 0, &target), KN_OK);
    assert_int_equal(kn_tile_set_mesh_target(ctx, tile, 0, 0, moved), KN_OK);
    kn_spline_clear(ctx, &patch);
    kn_spline_clear(ctx, &target);
}

// Widths and the height are powers of two: every quotient is exact.
static void everything_moves(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile = {0};
    make_tile(ctx, &tile);
    size_t before = atomic_load(&memory.calls);
    assert_int_equal(kn_tile_set_cell(ctx, &tile, (const double[]){2, 1, 6, 3}, 4), KN_OK);
    assert_int_equal(atomic_load(&memory.calls), before); // it allocates nothing
    const kn_tile_part *part = &tile.parts[0];
    for (int i = 0; i < 4; i++) {
        assert_true(part->splines[0].coef[i] == (at[i] - 2) / 4);
        assert_true(part->splines[0].coef[4 + i] == (at[4 + i] - 1) / 2);
        assert_true(part->splines[0].coef[8 + i] == at[8 + i] / 4);
        assert_true(part->targets[0].coef[8 + i] == (at[8 + i] + 2) / 4);
    }
    static const double expected[9] = {0, 0, 0, 1, 0, 1, 0, 1, 0.5};
    assert_memory_equal(part->mesh.position, expected, sizeof expected);
    for (int i = 0; i < 3; i++) assert_true(part->mesh_targets[0][3 * i + 2] == expected[3 * i + 2] + 0.5);
    // The normal stays at right angles to what was: (0.6, 0, 0.8) . (4, 0, -3) = 0, and (4, 0, -3) -> (1, 0, -0.75).
    const double *n = part->mesh.normal + 3;
    assert_true(fabs(n[0] - 0.75 * n[2]) <= 1e-15 && fabs(n[0] * n[0] + n[2] * n[2] - 1) <= 1e-15 && n[1] == 0);
    assert_true(fabs(tile.aspect - 4 / sqrt(8)) <= 1e-15);
    assert_int_equal(kn_tile_check(ctx, &tile), KN_OK);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

static void what_makes_no_sense_changes_nothing(void **state)
{
    (void)state;
    static const double cells[][5] = {{0, 0, 0, 1, 1},   {0, 1, 1, 1, 1},          {1, 0, 0, 1, 1},
                                      {0, 0, 1, 1, 0},   {0, 0, 1, 1, -1},         {0, 0, 1, NAN, 1},
                                      {0, 0, 1, 1, NAN}, {-1e308, 0, 1e308, 1, 1}, {0, 0, 1, 1, INFINITY}};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile = {0};
    make_tile(ctx, &tile);
    double aspect = tile.aspect;
    for (size_t i = 0; i < sizeof cells / sizeof *cells; i++)
        assert_int_equal(kn_tile_set_cell(ctx, &tile, cells[i], cells[i][4]), KN_EDOMAIN);
    tile.parts[0].splines[0].rational = true; // no values (u, v, w) any more
    assert_int_equal(kn_tile_set_cell(ctx, &tile, (const double[]){0, 0, 2, 2}, 2), KN_EDOMAIN);
    tile.parts[0].splines[0].rational = false;
    assert_memory_equal(tile.parts[0].splines[0].coef, at, sizeof at);
    assert_true(tile.aspect == aspect);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(everything_moves),
        cmocka_unit_test(what_makes_no_sense_changes_nothing),
    };
    return cmocka_run_group_tests_name("tile/cell", tests, NULL, NULL);
}
