// SPDX-License-Identifier: Apache-2.0
// The degrees in which tile patches compose, counted by hand, and the same patches in full degrees.
#include "tests/support/scene.h"
#include "tests/support/support.h"

#include <math.h>

// T = S + w d with S of degrees (3,3) and d of (1,1): terms of degrees and power (3,3,0) and (1,1,1).
typedef struct shell {
    kn_spline s, d;
    kn_job_options options;
} shell;

static void shell_init(kn_ctx *ctx, shell *x)
{
    static const double knots[] = {0, 0, 1, 1}, coef[12] = {0.1, 0.2, 0, 0.3, 0, 0.1, -0.2, 0.1, 1, 1.2, 0.9, 1};
    const double *both[2] = {knots, knots};
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    *x = (shell){.options = kn_job_defaults()};
    scene_bicubic(ctx, &x->s, 0.2);
    assert_int_equal(kn_spline_init(ctx, &x->d, 2, 3, false, degree, count, both, coef), KN_OK);
    x->options.count[0] = 3, x->options.count[1] = 2;
    x->options.height = 0.4;
    x->options.max_degree = KN_MAX_DEGREE;
    x->options.direction = &x->d;
}

static void shell_clear(kn_ctx *ctx, shell *x)
{
    kn_spline_clear(ctx, &x->s), kn_spline_clear(ctx, &x->d);
}

// Control points u + i/2 and so on, of degrees (2,2): u along r, v along t, w as it is given.
static void add_flat(kn_ctx *ctx, kn_tile *tile, double u0, double u1, double v0, double v1, const double *w)
{
    double coef[27];
    for (int i = 0; i < 9; i++) {
        coef[i] = u0 + (i / 3) / 2.0 * (u1 - u0);
        coef[9 + i] = v0 + (i % 3) / 2.0 * (v1 - v0);
        coef[18 + i] = w[i];
    }
    scene_add_patch(ctx, tile, 2, 2, coef);
}

// Every patch has these degrees, and is the one that symbolic composition gives in the degrees of the tile: the
// matrix's least components differ from the tile's by 2^-48 of a cell at most, over which T changes by less than 8, and
// each control point has less than 100 roundings of numbers below 8.
static void expect(kn_ctx *ctx, const shell *x, const kn_tile *tile, int n, const int (*degree)[2])
{
    scene_result r[2];
    kn_bezier up = {0};
    for (int symbolic = 0; symbolic < 2; symbolic++) {
        kn_job *job = NULL;
        kn_job_options o = x->options;
        o.symbolic = symbolic != 0;
        assert_int_equal(kn_job_create(ctx, &job, &x->s, 1, tile, &o), KN_OK);
        scene_run(ctx, job, &r[symbolic]);
        kn_job_destroy(ctx, job);
    }
    assert_int_equal(r[0].count, r[1].count);
    assert_int_equal(r[0].count % (size_t)n, 0);
    for (size_t i = 0; i < r[0].count; i++) {
        const kn_bezier *a = &r[0].patches[i].bezier, *b = &r[1].patches[i].bezier;
        int k = r[0].patches[i].id.patch;
        for (int v = 0; v < 2; v++) assert_int_equal(a->degree[v], degree[k][v]);
        assert_int_equal(kn_bezier_elevate(ctx, &up, a, b->degree), KN_OK);
        double most = test_max_difference(up.coef, b->coef, 3 * kn_bezier_count(b));
        assert_true(most <= 3 * 8 * 0x1p-48 + 100 * 8 * 0x1p-53);
    }
    kn_bezier_clear(ctx, &up);
    for (int k = 0; k < 2; k++) scene_result_clear(&r[k]);
}

// Patch 0 is flat, patch 1 beside it has a bump of degree 2 along t: what they share is w's degree along t. Patch 2
// is alone, and has degree 2 in u along both variables.
static void patches_side_by_side(void **state)
{
    (void)state;
    static const double flat[9] = {0}, bump[9] = {0, 0, 0, 0, 0, 0, 0, 1, 0};
    static const double bent[27] = {.1,  .1, .1, .2, .25, .2, .3, .3, .3, .1, .1, .1, .15, .15,
                                    .15, .2, .2, .2, .5,  .5, .5, .5, .5, .5, .5, .5, .5};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    shell x;
    kn_tile tile = {0};
    shell_init(ctx, &x);
    assert_int_equal(kn_tile_init(ctx, &tile, "three", 1), KN_OK);
    add_flat(ctx, &tile, 0.25, 0.5, 0.25, 0.75, flat);
    add_flat(ctx, &tile, 0.5, 0.75, 0.25, 0.75, bump);
    scene_add_patch(ctx, &tile, 2, 2, bent);
    // S alone asks for 3 u + 3 v; d for u + v + w: of patch 1 and 0, along t, 1 + 2 only; of patch 2 along r 3 * 2 +
    // 3 * 1, along t 3 * 2
    static const int degree[3][2] = {{3, 3}, {3, 3}, {9, 6}};
    expect(ctx, &x, &tile, 3, degree);
    // T = S + w d + w^3 psi: the bump's w^3 counts along both variables of patch 1, and along t of patch 0
    kn_spline psi = {0};
    static const double knots[] = {0, 1}, coef[3] = {0.1, 0.2, 0.3};
    const double *both[2] = {knots, knots};
    const int none[2] = {0, 0}, one[2] = {1, 1};
    assert_int_equal(kn_spline_init(ctx, &psi, 2, 3, false, none, one, both, coef), KN_OK);
    x.options.attraction = &psi;
    x.options.attraction_power = 3;
    static const int attracted[3][2] = {{3, 6}, {6, 6}, {9, 6}};
    expect(ctx, &x, &tile, 3, attracted);
    kn_spline_clear(ctx, &psi);
    kn_tile_clear(ctx, &tile);
    shell_clear(ctx, &x);
    test_ctx_end(ctx, &memory);
}

// Over the line between cells patch 1 meets patch 0 of the next cell: its degree along t counts there, too.
static void neighbours_over_a_line(void **state)
{
    (void)state;
    static const double flat[9] = {0}, bump[9] = {0, 1, 0, 0, 1, 0, 0, 1, 0};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    shell x;
    kn_tile tile = {0};
    kn_spline psi = {0};
    static const double knots[] = {0, 1}, coef[3] = {0.1, 0.2, 0.3};
    const double *both[2] = {knots, knots};
    const int none[2] = {0, 0}, one[2] = {1, 1};
    shell_init(ctx, &x);
    assert_int_equal(kn_spline_init(ctx, &psi, 2, 3, false, none, one, both, coef), KN_OK);
    x.options.attraction = &psi;
    x.options.attraction_power = 3;
    assert_int_equal(kn_tile_init(ctx, &tile, "over", 1), KN_OK);
    add_flat(ctx, &tile, 0, 0.25, 0.25, 0.75, flat);
    add_flat(ctx, &tile, 0.75, 1, 0.25, 0.75, flat);
    add_flat(ctx, &tile, 0.25, 0.5, 0.25, 0.75, bump); // beside patch 0 in its place, but not in its height
    static const int apart[3][2] = {{3, 3}, {3, 3}, {3, 6}};
    expect(ctx, &x, &tile, 3, apart);
    static const double step[9] = {0, 1, 0, 0, 0.5, 0, 0, 0, 0}, back[9] = {0, 0, 0, 0, 0.5, 0, 0, 1, 0};
    kn_tile_clear(ctx, &tile);
    assert_int_equal(kn_tile_init(ctx, &tile, "over", 1), KN_OK);
    add_flat(ctx, &tile, 0, 0.25, 0.25, 0.75, step);
    add_flat(ctx, &tile, 0.75, 1, 0.25, 0.75, back);
    add_flat(ctx, &tile, 0.25, 0.5, 0.25, 0.75, flat); // shares an edge with patch 0 again, and so its degree along t
    static const int joined[3][2] = {{3, 6}, {3, 6}, {3, 6}};
    expect(ctx, &x, &tile, 3, joined);
    kn_spline_clear(ctx, &psi);
    kn_tile_clear(ctx, &tile);
    shell_clear(ctx, &x);
    test_ctx_end(ctx, &memory);
}

static double along_x(const void *user, const kn_place *p)
{
    (void)user;
    return 1 + 0.25 * p->point[0];
}

static void expect_degrees(kn_ctx *ctx, const shell *x, const kn_tile *tile, int r, int t)
{
    kn_job *job = NULL;
    scene_result all;
    assert_int_equal(kn_job_create(ctx, &job, &x->s, 1, tile, &x->options), KN_OK);
    scene_run(ctx, job, &all);
    for (size_t i = 0; i < all.count; i++) {
        assert_int_equal(all.patches[i].bezier.degree[0], r);
        assert_int_equal(all.patches[i].bezier.degree[1], t);
    }
    scene_result_clear(&all);
    kn_job_destroy(ctx, job);
}

// A parameter that moves u along t by degree 2: S asks for 3 * 2 + 3 there, varied or not. What moves by a field moves
// in the patch's degrees: u by degree 2 along r then, too. A height by a field does so with w alone.
static void tiles_that_vary(void **state)
{
    (void)state;
    static const double flat[9] = {0};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    shell x;
    kn_tile tile = {0};
    kn_spline target = {0};
    shell_init(ctx, &x);
    x.options.offset = 0.1;
    assert_int_equal(kn_tile_init(ctx, &tile, "pushed", 1), KN_OK);
    add_flat(ctx, &tile, 0.25, 0.5, 0.25, 0.75, flat);
    expect_degrees(ctx, &x, &tile, 3, 3);
    const kn_job_vary height = {"height", {along_x, NULL, KN_NEEDS_POINT}};
    x.options.vary = &height, x.options.nvary = 1;
    expect_degrees(ctx, &x, &tile, 3, 3); // u + v + w: 1 + 2 along each
    x.options.vary = NULL, x.options.nvary = 0;

    assert_int_equal(kn_spline_copy(ctx, &target, &tile.parts[0].splines[0]), KN_OK);
    for (int i = 0; i < 3; i++) target.coef[3 * i + 1] += 0.1;
    assert_int_equal(kn_tile_add_parameter(ctx, &tile, "push", 0, 1, -1, 1), KN_OK);
    assert_int_equal(kn_tile_set_target(ctx, &tile, 0, 0, 0, &target), KN_OK);
    expect_degrees(ctx, &x, &tile, 3, 9);
    const kn_job_vary push = {"push", {along_x, NULL, KN_NEEDS_POINT}};
    x.options.vary = &push, x.options.nvary = 1;
    expect_degrees(ctx, &x, &tile, 6, 9);
    kn_spline_clear(ctx, &target);
    kn_tile_clear(ctx, &tile);
    shell_clear(ctx, &x);
    test_ctx_end(ctx, &memory);
}

// At an angle u and v are mixed: both run along both variables; mirrored and staggered tiles are as they were.
static void tiles_at_an_angle(void **state)
{
    (void)state;
    static const double flat[9] = {0};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    shell x;
    kn_tile tile = {0};
    shell_init(ctx, &x);
    assert_int_equal(kn_tile_init(ctx, &tile, "turned", 1), KN_OK);
    add_flat(ctx, &tile, 0.375, 0.625, 0.375, 0.625, flat);
    x.options.placement.mirror[0] = true;
    expect_degrees(ctx, &x, &tile, 3, 3);
    x.options.placement.angle = 0.3;
    expect_degrees(ctx, &x, &tile, 6, 6);
    x.options.random.angle = 0.2, x.options.random.height = 0.1;
    expect_degrees(ctx, &x, &tile, 6, 6);
    kn_tile_clear(ctx, &tile);
    shell_clear(ctx, &x);
    test_ctx_end(ctx, &memory);
}

static void make_both(kn_ctx *safe, kn_spline *base, kn_tile *tile)
{
    scene_bicubic(safe, base, 0.2);
    scene_dome(safe, tile);
    kn_spline target = {0};
    assert_int_equal(kn_spline_copy(safe, &target, &tile->parts[0].splines[0]), KN_OK);
    target.coef[4] += 0.01;
    assert_int_equal(kn_tile_add_parameter(safe, tile, "push", 0, 1, -1, 1), KN_OK);
    assert_int_equal(kn_tile_set_target(safe, tile, 0, 0, 0, &target), KN_OK);
    kn_spline_clear(safe, &target);
}

static kn_status create(kn_ctx *ctx, void *user)
{
    return scene_try_job(ctx, make_both, user);
}

static void allocation_failures(void **state)
{
    (void)state;
    kn_job_options o = {.count = {1, 1}, .height = 0.1, .normal_tol = 1e-2};
    test_allocation_failures(create, &o);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(patches_side_by_side),
                                       cmocka_unit_test(neighbours_over_a_line), cmocka_unit_test(tiles_that_vary),
                                       cmocka_unit_test(tiles_at_an_angle), cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("job/least", tests, NULL, NULL);
}
