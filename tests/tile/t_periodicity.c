// SPDX-License-Identifier: Apache-2.0
// Periodicity of tiles: orders of known functions, tiles broken on purpose, rounding, and all kinds of parts.
#include "tests/support/support.h"

#include "tests/support/scene.h"

#include <knurl/io.h>
#include <math.h>
#include <string.h>

// w(u) over the cell as one piece of degrees (n, 1), from its Bernstein coefficients.
static void add_graph(kn_ctx *ctx, kn_tile *tile, int n, const double *w, double u0, double u1)
{
    int degree[2] = {n, 1};
    kn_bezier b;
    kn_spline s = {0};
    assert_int_equal(kn_bezier_init(ctx, &b, 2, 3, false, degree), KN_OK);
    for (int i = 0; i <= n; i++)
        for (int j = 0; j < 2; j++) {
            b.coef[2 * i + j] = u0 + (u1 - u0) * i / n;
            b.coef[2 * (n + 1) + 2 * i + j] = j;
            b.coef[4 * (n + 1) + 2 * i + j] = w[i];
        }
    assert_int_equal(kn_spline_of_bezier(ctx, &s, &b), KN_OK);
    assert_int_equal(kn_tile_add(ctx, tile, 0, &s), KN_OK);
    kn_spline_clear(ctx, &s);
    kn_bezier_clear(ctx, &b);
}

// bump at its parameters' values, without parameters, so that its parts may be cut about.
static void load_bump(kn_ctx *ctx, kn_tile *out)
{
    kn_tile tile;
    double values[8];
    assert_int_equal(kn_builtin_tile(ctx, &tile, "bump"), KN_OK);
    assert_true(tile.nparameters <= 8);
    for (int k = 0; k < tile.nparameters; k++) values[k] = tile.parameters[k].value;
    assert_int_equal(kn_tile_vary(ctx, out, &tile, values), KN_OK);
    kn_tile_clear(ctx, &tile);
}

static kn_tile_periodicity_report check(kn_ctx *ctx, const kn_tile *tile)
{
    kn_tile_periodicity_report r;
    assert_int_equal(kn_tile_periodicity(ctx, &r, tile, NULL), KN_OK);
    return r;
}

static kn_tile_periodicity_report check_graph(kn_ctx *ctx, int n, const double *w)
{
    kn_tile tile;
    assert_int_equal(kn_tile_init(ctx, &tile, "graph", 1), KN_OK);
    add_graph(ctx, &tile, n, w, 0, 1);
    kn_tile_periodicity_report r = check(ctx, &tile);
    kn_tile_clear(ctx, &tile);
    return r;
}

// One piece whose right end meets its own left end: orders and amounts by hand.
static void orders_of_known_functions(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    // u (1 - u): slopes 1 and -1, a right angle.
    kn_tile_periodicity_report r = check_graph(ctx, 2, (double[]){0, 0.5, 0});
    assert_true(r.order[0] == 0 && r.decided[0] && r.order[1] == 2 && r.joints[0] == 1 && r.joints[1] == 1);
    assert_true(fabs(r.first[0].amount - acos(0.0)) < 1e-12);
    assert_true(r.open == 0 && r.crowded == 0 && r.reversed == 0 && r.unchecked == 0 && r.joints[2] == 0);
    // u - 3 u^2 + 2 u^3: slope 1, second derivatives -6 and 6. Along (1, 0, 1) the normal curvature is w'' / 2^(3/2).
    r = check_graph(ctx, 3, (double[]){0, 1.0 / 3, -1.0 / 3, 0});
    assert_true(r.order[0] == 1 && r.decided[0]);
    assert_true(fabs(r.first[0].amount - 12 / sqrt(8)) < 1e-9);
    // u^2 (1 - u)^2: slope 0, second derivatives 2.
    r = check_graph(ctx, 4, (double[]){0, 0, 1.0 / 6, 0, 0});
    assert_true(r.order[0] == 2 && r.decided[0]);
    // A step: no mates in u, and the distance is its height.
    r = check_graph(ctx, 1, (double[]){0, 0.25});
    assert_true(r.order[0] == -1 && r.decided[0] && r.order[1] == 2 && r.open == 2);
    assert_true(fabs(r.first[0].amount - 0.25) < 1e-12 && r.first[0].mate.part == 0);
    // A fold: both sides of the joint on one side of the line u = 0.
    kn_tile tile;
    assert_int_equal(kn_tile_init(ctx, &tile, "fold", 1), KN_OK);
    add_graph(ctx, &tile, 1, (double[]){0, 0}, 0, 0.5);
    add_graph(ctx, &tile, 2, (double[]){0, 0, 1}, 0, 0.5);
    r = check(ctx, &tile);
    assert_true(r.order[2] == 0 && r.decided[2] && r.reversed == 1 &&
                fabs(r.first[2].amount - 2 * acos(0.0)) < 1e-12);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

// Two pieces of different degree that meet in one line: raised to one degree their edges are one.
static void degrees_may_differ(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile;
    assert_int_equal(kn_tile_init(ctx, &tile, "two", 1), KN_OK);
    add_graph(ctx, &tile, 1, (double[]){0, 0}, 0, 0.5);
    add_graph(ctx, &tile, 3, (double[]){0, 0, 0, 0}, 0.5, 1);
    const int higher[2] = {3, 4};
    assert_int_equal(kn_spline_elevate(ctx, &tile.parts[0].splines[1], &tile.parts[0].splines[1], higher), KN_OK);
    kn_tile_periodicity_report r = check(ctx, &tile);
    assert_true(r.order[0] == 2 && r.order[1] == 2 && r.order[2] == 2 && r.open == 0);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

// docs/tiles.md says what each tile is.
static void built_in_tiles(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        int u, v;
    } expected[] = {{"chain", 2, 2}, {"scale", 0, 1}, {"thorn", 2, 2}, {"knurl", 0, 0}, {"bump", 2, 2}};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        kn_tile tile;
        assert_int_equal(kn_builtin_tile(ctx, &tile, expected[i].name), KN_OK);
        kn_tile_periodicity_report r = check(ctx, &tile);
        assert_true(r.decided[0] && r.decided[1] && r.decided[2]);
        assert_int_equal(r.order[0], expected[i].u);
        assert_int_equal(r.order[1], expected[i].v);
        assert_true(r.open == 0 && r.crowded == 0 && r.reversed == 0);
        kn_tile_clear(ctx, &tile);
    }
    test_ctx_end(ctx, &memory);
}

// bump's border is where its tiling is G2: nine patches, 3 x 3, control points [c][i][j] of 3 x 3 each.
static void what_is_broken_is_named(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile;
    load_bump(ctx, &tile);
    double *w = tile.parts[0].splines[1].coef + 18; // patch 1: u in [0, 1/4], v in [1/4, 3/4]
    // A control point on u = 0: no mate; the nearest is patch 7's edge u = 1, control points are 1/8 apart.
    w[1] += 0.125;
    kn_tile_periodicity_report r = check(ctx, &tile);
    assert_int_equal(r.order[0], -1);
    assert_int_equal(r.open, 2);
    assert_true(r.first[0].edge.spline == 1 && r.first[0].edge.edge == 0);
    assert_true(r.first[0].mate.spline == 7 && r.first[0].mate.edge == 1);
    assert_true(r.first[0].offset[0] == -1 && r.first[0].offset[1] == 0 && r.first[0].at == 0.5);
    assert_true(fabs(r.first[0].amount - 0.125) < 1e-12);
    assert_int_equal(r.order[1], 2);
    w[1] -= 0.125;
    // The point beside it, an eighth of a cell away: slopes change by 2 * 1/2 of its move over a quarter.
    w[4] += 1e-3 / 4;
    r = check(ctx, &tile);
    assert_true(r.order[0] == 0 && r.decided[0] && r.open == 0);
    assert_true(r.first[0].edge.spline == 1 && r.first[0].mate.spline == 7);
    assert_true(r.first[0].at == 0.5 && fabs(r.first[0].amount - 1e-3) < 1e-8); // atan(1e-3) = 1e-3 - 3e-10
    w[4] -= 1e-3 / 4;
    // Noise of rounding size changes nothing.
    test_rng rng = test_random(5);
    for (int s = 0; s < 9; s++)
        for (int k = 0; k < 27; k++) tile.parts[0].splines[s].coef[k] += test_uniform(&rng, -1e-15, 1e-15);
    r = check(ctx, &tile);
    assert_true(r.order[0] == 2 && r.order[1] == 2 && r.open == 0 && r.decided[0] && r.decided[1]);
    // A hole in the middle, whose place in the list patch 8 takes: the border joins as before, four edges are open.
    kn_spline_swap(&tile.parts[0].splines[4], &tile.parts[0].splines[8]);
    kn_spline_clear(ctx, &tile.parts[0].splines[--tile.parts[0].nsplines]);
    r = check(ctx, &tile);
    assert_true(r.order[0] == 2 && r.order[1] == 2);
    assert_int_equal(r.open, 4);
    // Patch 7 beside it goes too, u in [3/4, 1], v in [1/4, 3/4]: the hole reaches the border.
    kn_spline_clear(ctx, &tile.parts[0].splines[--tile.parts[0].nsplines]);
    r = check(ctx, &tile);
    assert_true(r.order[0] == -1 && r.order[1] == 2);
    assert_int_equal(r.open, 6);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

// A strip that reaches over its neighbours: nothing is cut, its four edges are open; another one in a line between
// cells would be.
static void what_stands_alone_is_periodic(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile;
    scene_strip(ctx, &tile);
    kn_tile_periodicity_report r = check(ctx, &tile);
    assert_true(r.order[0] == 2 && r.order[1] == 2 && r.joints[0] == 0 && r.open == 4);
    assert_int_equal(r.open_edges[3].edge, 3);
    kn_tile_clear(ctx, &tile);
    assert_int_equal(kn_tile_init(ctx, &tile, "shelf", 1), KN_OK);
    add_graph(ctx, &tile, 1, (double[]){0, 0}, 0, 0.75);
    r = check(ctx, &tile);
    assert_true(r.order[0] == -1 && r.order[1] == 2 && r.open == 2 && r.first[0].edge.edge == 0);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

static void add_curve(kn_ctx *ctx, kn_tile *tile, int n, const double (*p)[3])
{
    kn_bezier b;
    kn_spline s = {0};
    assert_int_equal(kn_bezier_init(ctx, &b, 1, 3, false, &n), KN_OK);
    for (int i = 0; i <= n; i++)
        for (int c = 0; c < 3; c++) b.coef[c * (n + 1) + i] = p[i][c];
    assert_int_equal(kn_spline_of_bezier(ctx, &s, &b), KN_OK);
    assert_int_equal(kn_tile_add(ctx, tile, 0, &s), KN_OK);
    kn_spline_clear(ctx, &s);
    kn_bezier_clear(ctx, &b);
}

// Curves from u = 0 to u = 1 that meet their own copies.
static void curves(void **state)
{
    (void)state;
    static const double bend[3][3] = {{0, 0.5, 0}, {0.5, 0.5, 0.5}, {1, 0.5, 0}},
                        wave[4][3] = {{0, 0.5, 0}, {1. / 3, 0.5, 1. / 3}, {2. / 3, 0.5, -1. / 3}, {1, 0.5, 0}},
                        line[2][3] = {{0, 0.25, 0.5}, {1, 0.25, 0.5}}, hair[2][3] = {{0.5, 0.5, 0}, {0.7, 0.5, 1}},
                        cut[2][3] = {{0.5, 0.5, 0}, {0.75, 1, 1}};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const struct {
        const double (*p)[3];
        int n, u, v;
        double amount; // the slopes' and curvatures' as in orders_of_known_functions
    } list[] = {{bend, 2, 0, 2, acos(0.0)},
                {wave, 3, 1, 2, 12 / sqrt(8)},
                {line, 1, 2, 2, 0},
                {hair, 1, 2, 2, 0},
                {cut, 1, 2, -1, 0}};
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        kn_tile tile;
        assert_int_equal(kn_tile_init(ctx, &tile, "curve", 1), KN_OK);
        add_curve(ctx, &tile, list[i].n, list[i].p);
        kn_tile_periodicity_report r = check(ctx, &tile);
        assert_int_equal(r.order[0], list[i].u);
        assert_int_equal(r.order[1], list[i].v);
        if (list[i].u < 2) assert_true(r.decided[0] && fabs(r.first[0].amount - list[i].amount) < 1e-9);
        kn_tile_clear(ctx, &tile);
    }
    test_ctx_end(ctx, &memory);
}

// A box as a trilinear volume; sheared by `shift` at u1 in w.
static void add_box(kn_ctx *ctx, kn_tile *tile, const double lo[3], const double hi[3], double shift)
{
    const int degree[3] = {1, 1, 1};
    kn_bezier b;
    kn_spline s = {0};
    assert_int_equal(kn_bezier_init(ctx, &b, 3, 3, false, degree), KN_OK);
    for (int k = 0; k < 8; k++)
        for (int c = 0; c < 3; c++)
            b.coef[8 * c + k] = (k >> (2 - c) & 1 ? hi : lo)[c] + (c == 2 && k >> 2 ? shift : 0);
    assert_int_equal(kn_spline_of_bezier(ctx, &s, &b), KN_OK);
    assert_int_equal(kn_tile_add(ctx, tile, 0, &s), KN_OK);
    kn_spline_clear(ctx, &s);
    kn_bezier_clear(ctx, &b);
}

static void volumes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile;
    // A beam along u, of two boxes: its ends join, and so do the four faces round them; nothing crosses v.
    assert_int_equal(kn_tile_init(ctx, &tile, "beam", 1), KN_OK);
    add_box(ctx, &tile, (double[]){0, 0.25, 0}, (double[]){0.5, 0.75, 1}, 0);
    add_box(ctx, &tile, (double[]){0.5, 0.25, 0}, (double[]){1, 0.75, 1}, 0);
    kn_tile_periodicity_report r = check(ctx, &tile);
    assert_true(r.order[0] == 2 && r.order[1] == 2 && r.open == 0 && r.reversed == 0);
    assert_true(r.joints[0] == 1 + 4 && r.joints[1] == 0 && r.joints[2] == 1 + 4 + 8);
    assert_true(r.order[2] == 0 && fabs(r.first[2].amount - acos(0.0)) < 1e-12); // edges along the beam
    kn_tile_clear(ctx, &tile);
    // Sheared, so that its ends miss each other.
    assert_int_equal(kn_tile_init(ctx, &tile, "beam", 1), KN_OK);
    add_box(ctx, &tile, (double[]){0, 0.25, 0}, (double[]){1, 0.75, 1}, 0.125);
    r = check(ctx, &tile);
    assert_true(r.order[0] == -1 && r.first[0].edge.face == 0 && r.first[0].edge.edge == -1);
    kn_tile_clear(ctx, &tile);
    // A roof: the ends join, the top has a ridge there.
    assert_int_equal(kn_tile_init(ctx, &tile, "roof", 1), KN_OK);
    add_box(ctx, &tile, (double[]){0, 0.25, 0}, (double[]){0.5, 0.75, 1}, 0.5);
    add_box(ctx, &tile, (double[]){0.5, 0.25, 0.5}, (double[]){1, 0.75, 1.5}, -0.5);
    r = check(ctx, &tile);
    assert_true(r.order[0] == 0 && r.decided[0] && fabs(r.first[0].amount - acos(0.0)) < 1e-12);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

// Two triangles over the cell; their border edges are each other's mates.
static void meshes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double position[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    uint32_t triangle[6] = {0, 1, 2, 0, 2, 3};
    kn_mesh mesh = {.nvertices = 4, .ntriangles = 2, .position = position, .triangle = triangle};
    kn_tile tile;
    assert_int_equal(kn_tile_init(ctx, &tile, "mesh", 1), KN_OK);
    tile.parts[0].mesh = mesh;
    kn_tile_periodicity_report r = check(ctx, &tile);
    assert_true(r.order[0] == 2 && r.order[1] == 2 && r.order[2] == 2 && r.open == 0 && r.reversed == 0);
    assert_true(r.joints[0] == 1 && r.joints[1] == 1 && r.joints[2] == 1);
    position[5] = 0.25; // vertex 1: edges at v = 0 and u = 1 are off by it
    r = check(ctx, &tile);
    assert_true(r.order[0] == -1 && r.order[1] == -1 && r.open == 4);
    assert_true(r.first[0].edge.spline == -1 && fabs(r.first[0].amount - 0.25) < 1e-12);
    position[2] = position[8] = position[11] = 0.25; // all vertices: flat again
    assert_int_equal(check(ctx, &tile).order[0], 2);
    triangle[3] = 2, triangle[4] = 0; // the second one faces down
    r = check(ctx, &tile);
    assert_true(r.reversed == 3 && r.open == 0);
    tile.parts[0].mesh = (kn_mesh){0};
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile;
    kn_tile_periodicity_report r, before;
    memset(&r, 7, sizeof r);
    before = r;
    scene_strip(ctx, &tile);
    const kn_tile_periodicity_options bad[] = {{.tolerance = -1}, {.tolerance = 1e-5}, {.tolerance = NAN},
                                               {.angle = 1e-12},  {.angle = 1},        {.max_order = 3},
                                               {.max_order = -1}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(kn_tile_periodicity(ctx, &r, &tile, &bad[i]), KN_EDOMAIN);
    kn_tile_periodicity_options c0 = kn_tile_periodicity_defaults();
    c0.max_order = 1;
    kn_tile_periodicity_report one;
    assert_int_equal(kn_tile_periodicity(ctx, &one, &tile, &c0), KN_OK);
    assert_int_equal(one.order[0], 1);
    tile.parts[0].splines[0].coef[0] = INFINITY;
    assert_int_equal(kn_tile_periodicity(ctx, &r, &tile, NULL), KN_EDOMAIN);
    tile.parts[0].splines[0].ncomp = 2;
    assert_int_equal(kn_tile_periodicity(ctx, &r, &tile, NULL), KN_EDOMAIN);
    tile.parts[0].splines[0].ncomp = 3;
    kn_tile_clear(ctx, &tile);
    assert_int_equal(kn_tile_init(ctx, &tile, "empty", 1), KN_OK);
    assert_int_equal(kn_tile_periodicity(ctx, &r, &tile, NULL), KN_EDOMAIN);
    kn_tile_clear(ctx, &tile);
    assert_memory_equal(&r, &before, sizeof r);
    test_ctx_end(ctx, &memory);
}

// Eight hundred triangles in one place: comparing all with all is refused.
static void a_heap_of_edges(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double position[9] = {0, 0, 0, 0.5, 0, 0, 0, 0.5, 0};
    uint32_t triangle[2400];
    for (uint32_t k = 0; k < 2400; k++) triangle[k] = k % 3;
    kn_tile tile;
    kn_tile_periodicity_report r = {.open = 77};
    assert_int_equal(kn_tile_init(ctx, &tile, "heap", 1), KN_OK);
    tile.parts[0].mesh = (kn_mesh){.nvertices = 3, .ntriangles = 800, .position = position, .triangle = triangle};
    assert_int_equal(kn_tile_periodicity(ctx, &r, &tile, NULL), KN_ELIMIT);
    assert_int_equal(r.open, 77);
    tile.parts[0].mesh = (kn_mesh){0};
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

static int stop(void *user, const char *stage, double fraction)
{
    (void)user, (void)stage, (void)fraction;
    return 1;
}

static void cancelled(void **state)
{
    (void)state;
    kn_ctx *ctx = NULL;
    kn_ctx_options options = {.progress = stop, .threads = 1};
    assert_int_equal(kn_ctx_create(&ctx, &options), KN_OK);
    kn_tile tile;
    kn_tile_periodicity_report r;
    scene_strip(ctx, &tile);
    assert_int_equal(kn_tile_periodicity(ctx, &r, &tile, NULL), KN_ECANCELLED);
    kn_tile_clear(ctx, &tile);
    kn_ctx_destroy(ctx);
}

static kn_status periodicity_call(kn_ctx *ctx, void *user)
{
    kn_tile_periodicity_report r = {.open = 77};
    kn_status status = kn_tile_periodicity(ctx, &r, user, NULL);
    if (status != KN_OK) assert_int_equal(r.open, 77);
    return status;
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile;
    assert_int_equal(kn_tile_init(ctx, &tile, "all", 1), KN_OK);
    add_graph(ctx, &tile, 2, (double[]){0, 0, 0}, 0, 1);
    add_box(ctx, &tile, (double[]){0.25, 0.25, 0}, (double[]){0.5, 0.75, 1}, 0);
    add_curve(ctx, &tile, 1, (const double[2][3]){{0, 0.25, 0.5}, {1, 0.25, 0.5}});
    test_allocation_failures(periodicity_call, &tile);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orders_of_known_functions),
        cmocka_unit_test(degrees_may_differ),
        cmocka_unit_test(built_in_tiles),
        cmocka_unit_test(what_is_broken_is_named),
        cmocka_unit_test(what_stands_alone_is_periodic),
        cmocka_unit_test(curves),
        cmocka_unit_test(volumes),
        cmocka_unit_test(meshes),
        cmocka_unit_test(failures),
        cmocka_unit_test(a_heap_of_edges),
        cmocka_unit_test(cancelled),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests_name("tile/periodicity", tests, NULL, NULL);
}
