// SPDX-License-Identifier: Apache-2.0
// Coverage of tiles: shapes whose shadow is known, gaps as rectangles, what stays undecided.
#include "tests/support/support.h"

#include "tests/support/scene.h"

#include <knurl/io.h>
#include <math.h>
#include <string.h>

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

static kn_tile_coverage_report cover(kn_ctx *ctx, const kn_tile *tile, int depth)
{
    kn_tile_coverage_report r;
    kn_tile_coverage_options o = kn_tile_coverage_defaults();
    if (depth) o.depth = depth;
    assert_int_equal(kn_tile_coverage(ctx, &r, tile, &o), KN_OK);
    double gaps = 0;
    for (size_t i = 0; i < r.ngaps; i++) {
        const kn_tile_rect *a = &r.gaps[i];
        assert_true(a->lo[0] >= 0 && a->hi[0] <= 1 && a->lo[1] >= 0 && a->hi[1] <= 1);
        gaps += (a->hi[0] - a->lo[0]) * (a->hi[1] - a->lo[1]);
        for (size_t j = 0; j < i; j++) // no common interior
            assert_true(a->hi[0] <= r.gaps[j].lo[0] || r.gaps[j].hi[0] <= a->lo[0] || a->hi[1] <= r.gaps[j].lo[1] ||
                        r.gaps[j].hi[1] <= a->lo[1]);
    }
    assert_true(gaps == r.bare && r.covered + r.bare <= 1); // dyadic: exact
    return r;
}

// A bilinear patch with these corners: (r,t) = (0,0), (0,1), (1,0), (1,1).
static void add_patch(kn_ctx *ctx, kn_tile *tile, const double (*p)[3])
{
    static const int degree[2] = {1, 1};
    kn_bezier b;
    kn_spline s = {0};
    assert_int_equal(kn_bezier_init(ctx, &b, 2, 3, false, degree), KN_OK);
    for (int k = 0; k < 4; k++)
        for (int c = 0; c < 3; c++) b.coef[4 * c + k] = p[k][c];
    assert_int_equal(kn_spline_of_bezier(ctx, &s, &b), KN_OK);
    assert_int_equal(kn_tile_add(ctx, tile, 0, &s), KN_OK);
    kn_spline_clear(ctx, &s);
    kn_bezier_clear(ctx, &b);
}

static void add_rectangle(kn_ctx *ctx, kn_tile *tile, double u0, double v0, double u1, double v1)
{
    add_patch(ctx, tile, (const double[4][3]){{u0, v0, 0}, {u0, v1, 0.5}, {u1, v0, 0}, {u1, v1, 0.5}});
}

static void same_rect(const kn_tile_rect *r, double u0, double v0, double u1, double v1)
{
    assert_true(r->lo[0] == u0 && r->lo[1] == v0 && r->hi[0] == u1 && r->hi[1] == v1);
}

// Sheets without an open edge cover at once, by their area; chains have gaps, and their shadow is no less than that
// of the ring and no more than its square.
static void built_in_tiles(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static const char *const covering[] = {"scale", "thorn", "knurl", "bump"};
    kn_tile tile;
    for (size_t i = 0; i < sizeof covering / sizeof *covering; i++) {
        assert_int_equal(kn_builtin_tile(ctx, &tile, covering[i]), KN_OK);
        kn_tile_coverage_report r = cover(ctx, &tile, 0);
        assert_true(r.covers == KN_YES && r.covered == 1 && r.bare == 0 && r.ngaps == 0 && r.boxes == 0 && !r.gaps);
        kn_tile_clear(ctx, &tile);
    }
    assert_int_equal(kn_builtin_tile(ctx, &tile, "chain"), KN_OK);
    kn_tile_coverage_report r = cover(ctx, &tile, 7);
    assert_true(r.covers == KN_NO && r.ngaps > 0);
    assert_true(r.covered > 0.25 && r.bare > 0.15 && r.covered + r.bare > 0.8);
    kn_tile_coverage_clear(ctx, &r);
    assert_true(r.covers == KN_UNKNOWN && !r.gaps && r.ngaps == 0);
    kn_tile_coverage_clear(ctx, NULL);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

// Rectangles on dyadic lines: nothing is undecided.
static void rectangles_are_exact(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile;
    scene_strip(ctx, &tile); // over all u, v in [1/4, 3/4]
    kn_tile_coverage_report r = cover(ctx, &tile, 0);
    assert_true(r.covers == KN_NO && r.covered == 0.5 && r.bare == 0.5 && r.ngaps == 2);
    same_rect(&r.gaps[0], 0, 0, 1, 0.25);
    same_rect(&r.gaps[1], 0, 0.75, 1, 1);
    kn_tile_coverage_clear(ctx, &r);
    kn_tile_clear(ctx, &tile);

    assert_int_equal(kn_tile_init(ctx, &tile, "two", 1), KN_OK);
    add_rectangle(ctx, &tile, -0.25, 0.125, 0.25, 1.125); // over the border: of u it covers [0, 1/4] and [3/4, 1]
    add_rectangle(ctx, &tile, 0.75, 0.5, 0.25, 0.25);     // the rest of u, and of v a quarter; run backwards
    r = cover(ctx, &tile, 0);
    assert_true(r.covers == KN_NO && r.covered == 0.625 && r.bare == 0.375 && r.ngaps == 2);
    same_rect(&r.gaps[0], 0.25, 0, 0.75, 0.25);
    same_rect(&r.gaps[1], 0.25, 0.5, 0.75, 1);
    kn_tile_coverage_clear(ctx, &r);
    add_rectangle(ctx, &tile, 0.125, 0.5, 0.875, 1.25); // now all of it
    r = cover(ctx, &tile, 0);
    assert_true(r.covers == KN_YES && r.covered == 1 && r.boxes > 0);
    kn_tile_coverage_clear(ctx, &r);
    kn_tile_clear(ctx, &tile);

    load_bump(ctx, &tile);
    kn_spline_swap(&tile.parts[0].splines[4], &tile.parts[0].splines[8]);
    kn_spline_clear(ctx, &tile.parts[0].splines[--tile.parts[0].nsplines]);
    r = cover(ctx, &tile, 0); // a hole in the middle
    assert_true(r.covers == KN_NO && r.covered == 0.75 && r.ngaps == 1);
    same_rect(&r.gaps[0], 0.25, 0.25, 0.75, 0.75);
    kn_tile_coverage_clear(ctx, &r);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

// A bilinear square turned by 30 degrees: what is bare lies outside of all its copies, and areas enclose the true
// one.
static void oblique_outlines(void **state)
{
    (void)state;
    static const double p[4][3] = {{0.3, 0.1, 0}, {0.1, 0.5, 0.5}, {0.7, 0.3, 0}, {0.5, 0.7, 1}};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile;
    assert_int_equal(kn_tile_init(ctx, &tile, "square", 1), KN_OK);
    add_patch(ctx, &tile, p);
    double last = 1;
    for (int depth = 3; depth <= 9; depth += 2) {
        kn_tile_coverage_report r = cover(ctx, &tile, depth);
        assert_int_equal(r.covers, depth > 1 ? KN_NO : KN_UNKNOWN);
        assert_true(r.covered <= 0.2 && 1 - r.bare >= 0.2); // two sides of length sqrt(0.2)
        double undecided = 1 - r.covered - r.bare;
        // Along its outline, 4 sqrt(0.2) long: a box of side h, and one more on either side that the boxes of parts
        // of the patch reach into.
        assert_true(undecided < last && undecided < 4 * sqrt(0.2) * 1.5 * 4 * ldexp(1, -depth));
        last = undecided;
        for (size_t i = 0; i < r.ngaps; i++)
            for (int k = 0; k < 4; k++) {
                double u = k & 1 ? r.gaps[i].hi[0] : r.gaps[i].lo[0], v = k & 2 ? r.gaps[i].hi[1] : r.gaps[i].lo[1];
                double x = ((u - 0.3) * 2 + (v - 0.1)) * 2 / 2, y = (-(u - 0.3) + 2 * (v - 0.1)) * 2 / 2;
                assert_false(x > 1e-12 && x < 1 - 1e-12 && y > 1e-12 && y < 1 - 1e-12);
            }
        kn_tile_coverage_clear(ctx, &r);
    }
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

// A box as a volume, and the same as twelve triangles: upright walls and a floor that faces down beside a roof.
static void solids(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static const int degree[3] = {1, 1, 1};
    kn_tile tile;
    kn_bezier b;
    kn_spline s = {0};
    assert_int_equal(kn_bezier_init(ctx, &b, 3, 3, false, degree), KN_OK);
    double position[24];
    for (int k = 0; k < 8; k++)
        for (int c = 0; c < 3; c++) b.coef[8 * c + k] = position[3 * k + c] = k >> (2 - c) & 1 ? 0.75 : 0.25;
    assert_int_equal(kn_spline_of_bezier(ctx, &s, &b), KN_OK);
    assert_int_equal(kn_tile_init(ctx, &tile, "box", 1), KN_OK);
    assert_int_equal(kn_tile_add(ctx, &tile, 0, &s), KN_OK);
    kn_tile_coverage_report r = cover(ctx, &tile, 4);
    assert_true(r.covers == KN_NO && r.covered == 0.25 && r.bare == 0.75);
    kn_tile_coverage_clear(ctx, &r);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &s);
    kn_bezier_clear(ctx, &b);

    uint32_t triangle[] = {0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3, 0, 4, 5, 0, 5, 1,
                           2, 3, 7, 2, 7, 6, 0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5};
    kn_mesh mesh = {.nvertices = 8, .ntriangles = 12, .position = position, .triangle = triangle};
    assert_int_equal(kn_tile_init(ctx, &tile, "mesh", 1), KN_OK);
    tile.parts[0].mesh = mesh;
    kn_tile_periodicity_report p;
    assert_int_equal(kn_tile_periodicity(ctx, &p, &tile, NULL), KN_OK);
    assert_true(p.open == 0 && p.reversed == 0 && p.joints[2] == 18);
    r = cover(ctx, &tile, 8);
    // Where the two triangles of the roof have their collapsed edge, vertex 1, boxes may stay undecided.
    assert_true(r.covers == KN_NO && r.bare == 0.75 && r.covered > 0.25 - 0.001 && r.covered <= 0.25);
    kn_tile_coverage_clear(ctx, &r);
    for (int k = 0; k < 8; k++)
        for (int c = 0; c < 2; c++) position[3 * k + c] = position[3 * k + c] > 0.5 ? 1.25 : -0.25;
    r = cover(ctx, &tile, 8); // reaches over the whole cell and beyond
    assert_true(r.bare == 0 && r.covered > 0.99);
    kn_tile_coverage_clear(ctx, &r);
    tile.parts[0].mesh = (kn_mesh){0};
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

// A sheet that is folded back on itself covers where it does, though its signed area does not say so.
static void folds(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile;
    assert_int_equal(kn_tile_init(ctx, &tile, "fold", 1), KN_OK);
    add_patch(ctx, &tile, (const double[4][3]){{0, 0, 0}, {0, 1, 0}, {0.75, 0, 0}, {0.75, 1, 0}});
    add_patch(ctx, &tile, (const double[4][3]){{0.75, 0, 0}, {0.75, 1, 0}, {0, 0, 1}, {0, 1, 1}});
    kn_tile_coverage_report r = cover(ctx, &tile, 0);
    assert_true(r.covers == KN_NO && r.covered == 0.75 && r.ngaps == 1);
    same_rect(&r.gaps[0], 0.75, 0, 1, 1);
    kn_tile_coverage_clear(ctx, &r);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile;
    kn_tile_coverage_report r, before;
    memset(&r, 7, sizeof r);
    before = r;
    scene_diamond(ctx, &tile);
    const kn_tile_coverage_options bad[] = {{.tolerance = -1}, {.tolerance = 1e-5}, {.depth = 17}, {.depth = -1}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(kn_tile_coverage(ctx, &r, &tile, &bad[i]), KN_EDOMAIN);
    kn_tile_coverage_options few = {.max_boxes = 1}; // nothing is looked at but the cell itself
    kn_tile_coverage_report one;
    assert_int_equal(kn_tile_coverage(ctx, &one, &tile, &few), KN_OK);
    assert_true(one.boxes == 1 && one.covers != KN_YES);
    kn_tile_coverage_clear(ctx, &one);
    double *u = tile.parts[0].splines[0].coef, kept = u[0];
    u[0] = 4e6; // over millions of cells
    assert_int_equal(kn_tile_coverage(ctx, &r, &tile, NULL), KN_ELIMIT);
    u[0] = NAN;
    assert_int_equal(kn_tile_coverage(ctx, &r, &tile, NULL), KN_EDOMAIN);
    u[0] = kept;
    assert_memory_equal(&r, &before, sizeof r);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

static int stop(void *user, const char *stage, double fraction)
{
    (void)user, (void)fraction;
    return strcmp(stage, "coverage") == 0;
}

static void cancelled(void **state)
{
    (void)state;
    kn_ctx *ctx = NULL;
    kn_ctx_options options = {.progress = stop, .threads = 1};
    assert_int_equal(kn_ctx_create(&ctx, &options), KN_OK);
    kn_tile tile;
    kn_tile_coverage_report r;
    scene_strip(ctx, &tile);
    assert_int_equal(kn_tile_coverage(ctx, &r, &tile, NULL), KN_ECANCELLED);
    kn_tile_clear(ctx, &tile);
    kn_ctx_destroy(ctx);
}

static kn_status coverage_call(kn_ctx *ctx, void *user)
{
    kn_tile_coverage_report r = {.boxes = 77};
    kn_tile_coverage_options o = {.depth = 3};
    kn_status status = kn_tile_coverage(ctx, &r, user, &o);
    if (status != KN_OK) assert_int_equal(r.boxes, 77);
    kn_tile_coverage_clear(ctx, &r);
    return status;
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile;
    scene_strip(ctx, &tile);
    test_allocation_failures(coverage_call, &tile);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(built_in_tiles),
        cmocka_unit_test(rectangles_are_exact),
        cmocka_unit_test(oblique_outlines),
        cmocka_unit_test(solids),
        cmocka_unit_test(folds),
        cmocka_unit_test(failures),
        cmocka_unit_test(cancelled),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests_name("tile/coverage", tests, NULL, NULL);
}
