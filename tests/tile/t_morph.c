// SPDX-License-Identifier: Apache-2.0
// Tiles that turn into others.
#include "tests/support/support.h"

#include "tests/support/scene.h"

#include <math.h>
#include <string.h>

// At morph t every point is (1 - t) a + t b, of splines of other degrees, knots and domains.
static void between(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int nvars = 1; nvars <= 3; nvars++) {
        kn_tile a = {0}, b = {0}, m = {0};
        assert_int_equal(kn_tile_init(ctx, &a, "thorn", 1), KN_OK);
        assert_int_equal(kn_tile_init(ctx, &b, "flower", 1), KN_OK);
        const int p[2][3] = {{3, 1, 2}, {2, 2, 1}}, n[2][3] = {{5, 3, 3}, {4, 3, 2}};
        for (int k = 0; k < 2; k++) {
            kn_spline s = {0};
            test_random_spline(ctx, &s, &rng, nvars, 3, false, p[k], n[k], 5);
            if (nvars == 3) // right-handed: near to the identity
                for (size_t i = 0, c = kn_spline_count(&s); i < c; i++) {
                    size_t at[3] = {i / ((size_t)n[k][1] * (size_t)n[k][2]), i / (size_t)n[k][2] % (size_t)n[k][1],
                                    i % (size_t)n[k][2]};
                    for (size_t d = 0; d < 3; d++) s.coef[d * c + i] = 20 * (double)at[d] + s.coef[d * c + i];
                }
            assert_int_equal(kn_tile_add(ctx, k == 0 ? &a : &b, 0, &s), KN_OK);
            kn_spline_clear(ctx, &s);
        }
        assert_int_equal(kn_tile_morph(ctx, &m, &a, &b), KN_OK);
        assert_string_equal(m.name, "thorn to flower");
        assert_int_equal(m.nparameters, 1);
        assert_string_equal(m.parameters[0].name, "morph");
        for (int step = 0; step <= 4; step++) {
            double t = 0.25 * step, at[3], x[3], y[3], z[3];
            kn_tile now = {0};
            assert_int_equal(kn_tile_vary(ctx, &now, &m, &t), KN_OK);
            for (int i = 0; i < 20; i++) {
                double ends[2][3];
                for (int d = 0; d < nvars; d++) {
                    at[d] = test_uniform(&rng, 0, 1);
                    for (int k = 0; k < 2; k++) {
                        double lo, hi;
                        kn_spline_domain(&(k == 0 ? &a : &b)->parts[0].splines[0], d, &lo, &hi);
                        ends[k][d] = lo + at[d] * (hi - lo);
                    }
                }
                assert_int_equal(kn_spline_eval(ctx, x, &a.parts[0].splines[0], ends[0]), KN_OK);
                assert_int_equal(kn_spline_eval(ctx, y, &b.parts[0].splines[0], ends[1]), KN_OK);
                assert_int_equal(kn_spline_eval(ctx, z, &now.parts[0].splines[0], at), KN_OK);
                // values up to 65, slopes up to 65 * 2 * 3 * 5 times the rounding of parameters, and gamma(100)
                for (int c = 0; c < 3; c++) assert_true(fabs(z[c] - ((1 - t) * x[c] + t * y[c])) <= 1e-11);
            }
            kn_tile_clear(ctx, &now);
        }
        kn_tile_clear(ctx, &a), kn_tile_clear(ctx, &b), kn_tile_clear(ctx, &m);
    }
    test_ctx_end(ctx, &memory);
}

// det of the corners over all triangles, a sixth of it the volume.
static double six_volumes(const kn_mesh *m)
{
    double sum = 0;
    for (size_t i = 0; i < m->ntriangles; i++) {
        const double *p[3];
        for (int k = 0; k < 3; k++) p[k] = m->position + 3 * (size_t)m->triangle[3 * i + (size_t)k];
        for (int c = 0; c < 3; c++)
            sum += p[0][c] * (p[1][(c + 1) % 3] * p[2][(c + 2) % 3] - p[1][(c + 2) % 3] * p[2][(c + 1) % 3]);
    }
    return sum;
}

// A tetrahedron becomes an octahedron: at the ends the volumes are theirs, between tiles are what they should be.
static void solids(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static double four[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static uint32_t sides[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    static double six[18] = {1, 0.5, 0.5, 0, 0.5, 0.5, 0.5, 1, 0.5, 0.5, 0, 0.5, 0.5, 0.5, 1, 0.5, 0.5, 0};
    static uint32_t eight[24] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    const kn_mesh meshes[2] = {{.nvertices = 4, .ntriangles = 4, .position = four, .triangle = sides},
                               {.nvertices = 6, .ntriangles = 8, .position = six, .triangle = eight}};
    kn_tile a = {0}, b = {0}, m = {0}, *tiles[2] = {&a, &b};
    for (int k = 0; k < 2; k++) {
        assert_int_equal(kn_tile_init(ctx, tiles[k], "solid", 1), KN_OK);
        assert_int_equal(kn_tile_set_mesh(ctx, tiles[k], 0, &meshes[k]), KN_OK);
    }
    assert_int_equal(kn_tile_morph(ctx, &m, &a, &b), KN_OK);
    for (int step = 0; step <= 4; step++) {
        double t = 0.25 * step;
        kn_tile now = {0};
        assert_int_equal(kn_tile_vary(ctx, &now, &m, &t), KN_OK);
        assert_int_equal(kn_tile_check(ctx, &now), KN_OK);
        // some 40 triangles, each of 20 roundings of numbers up to 1
        if (step == 0) assert_true(fabs(six_volumes(&now.parts[0].mesh) - 1) <= 1e-12);
        if (step == 4) assert_true(fabs(six_volumes(&now.parts[0].mesh) - 1) <= 1e-12); // 6 * 4/3 / 8
        kn_tile_clear(ctx, &now);
    }
    for (int k = 0; k < 2; k++) kn_tile_clear(ctx, tiles[k]);
    kn_tile_clear(ctx, &m);
    test_ctx_end(ctx, &memory);
}

static void refuses(kn_ctx *ctx, const kn_tile *a, const kn_tile *b, const char *says)
{
    kn_tile m = {.nparts = 77};
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_tile_morph(ctx, &m, a, b), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), says));
    assert_int_equal(m.nparts, 77);
}

static void refusals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile dome = {0}, strip = {0}, curve = {0}, two = {0};
    scene_dome(ctx, &dome), scene_strip(ctx, &strip);
    assert_int_equal(kn_tile_init(ctx, &curve, "curve", 1), KN_OK);
    assert_int_equal(kn_tile_init(ctx, &two, "two", 2), KN_OK);
    kn_spline line = {0};
    const double knots[4] = {0, 0, 1, 1}, *ks[1] = {knots}, coef[6] = {0, 1, 0, 1, 0, 1};
    const int one = 1, n = 2;
    assert_int_equal(kn_spline_init(ctx, &line, 1, 3, false, &one, &n, ks, coef), KN_OK);
    assert_int_equal(kn_tile_add(ctx, &curve, 0, &line), KN_OK);
    for (int p = 0; p < 2; p++) assert_int_equal(kn_tile_add(ctx, &two, p, &line), KN_OK);
    refuses(ctx, &dome, &strip, "has 4 splines");
    refuses(ctx, &strip, &curve, "is a surface, and of part \"\" a curve");
    refuses(ctx, &two, &curve, "has 2 parts");
    static double position[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static uint32_t triangle[3] = {0, 1, 2};
    const kn_mesh mesh = {.nvertices = 3, .ntriangles = 1, .position = position, .triangle = triangle};
    kn_tile with = {0}, m = {0};
    assert_int_equal(kn_tile_copy(ctx, &with, &curve), KN_OK);
    assert_int_equal(kn_tile_set_mesh(ctx, &with, 0, &mesh), KN_OK);
    refuses(ctx, &with, &curve, "has a mesh");
    assert_int_equal(kn_tile_morph(ctx, &m, &with, &with), KN_OK);
    assert_non_null(m.parts[0].mesh_targets[0]);
    kn_tile_clear(ctx, &m), kn_tile_clear(ctx, &with);
    kn_spline_clear(ctx, &line);
    kn_tile_clear(ctx, &dome), kn_tile_clear(ctx, &strip), kn_tile_clear(ctx, &curve), kn_tile_clear(ctx, &two);
    test_ctx_end(ctx, &memory);
}

static kn_status morph_call(kn_ctx *ctx, void *user)
{
    kn_tile m = {0};
    kn_status status = kn_tile_morph(ctx, &m, user, user);
    assert_true((status == KN_OK) == (m.parts != NULL));
    kn_tile_clear(ctx, &m);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile = {0};
    scene_strip(ctx, &tile);
    test_allocation_failures(morph_call, &tile);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(between), cmocka_unit_test(solids),
                                       cmocka_unit_test(refusals), cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("tile/morph", tests, NULL, NULL);
}
