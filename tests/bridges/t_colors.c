// SPDX-License-Identifier: Apache-2.0
// Colours by a field in files, as Open CASCADE and a glTF reader find them.
#include "tests/support/support.h"

#include "bridges/occt/occt_check.h"
#include "bridges/tinygltf/gltf.h"
#include "tests/support/scene.h"

#include <knurl/io.h>
#include <knurl/step.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { N = 8, STEPS = 4 };

static const double palette[STEPS][3] = {{0, 0, 0.5}, {0.25, 0.5, 0}, {0.75, 1, 0.25}, {1, 0.125, 0}};

static double along_u(const void *user, const kn_place *place)
{
    (void)user;
    return place->uv[0];
}

// N x N cells of a dome over [0,1]^2 (from above), two columns in each colour.
static void write_both(kn_ctx *ctx, const char *step, const char *gltf)
{
    static const double knots[4] = {0, 0, 1, 1}, coef[12] = {0, 0, 1, 1, 0, 1, 0, 1, 0, 0, 0, 0};
    const double *const both[2] = {knots, knots};
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    const kn_job_color color = {NULL, {along_u, NULL, 0}, palette, STEPS, STEPS};
    const kn_job_options o = {.count = {N, N}, .height = 0.01, .color = &color, .ncolor = 1};
    kn_spline base = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    kn_sink sinks[2] = {{0}};
    scene_dome(ctx, &tile);
    assert_int_equal(kn_spline_init(ctx, &base, 2, 3, false, degree, count, both, coef), KN_OK);
    if (kn_job_create(ctx, &job, &base, 1, &tile, &o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    assert_int_equal(kn_step_sink(ctx, &sinks[0], step, NULL), KN_OK);
    assert_int_equal(kn_gltf_sink(ctx, &sinks[1], gltf, NULL), KN_OK);
    if (kn_job_run(ctx, job, sinks, 2) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    for (int i = 0; i < 2; i++) kn_sink_close(ctx, &sinks[i]);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &base);
}

static void find_in_step(kn_ctx *ctx, const char *path)
{
    kn_occt_model *model = NULL;
    kn_occt_report report;
    assert_int_equal(kn_occt_open_step(ctx, &model, path), KN_OK);
    assert_int_equal(kn_occt_check(ctx, &report, model), KN_OK);
    assert_int_equal(report.faces, 4 * N * N);
    assert_int_equal(report.valid_faces, report.faces);
    assert_int_equal(report.ncolours, STEPS);
    for (int k = 0; k < STEPS; k++) { // each of them, in whatever order: digits as in t_occt_step.c
        int found = 0;
        for (int i = 0; i < STEPS; i++) found += test_max_difference(report.colour[i], palette[k], 3) <= 2e-4;
        assert_int_equal(found, 1);
    }
    for (int i = 0; i < report.faces; i++) { // s0 cI,J NAME.STEP PATCH: the column is in the name, and so is its step
        char name[128];
        int column = -1, row = -1, step = -1;
        assert_int_equal(kn_occt_face_name(ctx, name, sizeof name, model, i), KN_OK);
        const char *dot = strrchr(name, '.');
        assert_true(dot && sscanf(name, "s0 c%d,%d", &column, &row) == 2 && sscanf(dot, ".%d ", &step) == 1);
        assert_int_equal(step, column / (N / STEPS));
        double point[3];
        assert_int_equal(kn_occt_eval(ctx, point, NULL, model, i, 0.5, 0.5), KN_OK);
        assert_true(point[0] * N > column && point[0] * N < column + 1);
    }
    kn_occt_close(ctx, model);
}

static void find_in_gltf(kn_ctx *ctx, const char *path)
{
    kn_scene scene = {0};
    assert_int_equal(kn_gltf_read(ctx, &scene, path), KN_OK);
    assert_int_equal(scene.nitems, STEPS);
    for (int k = 0; k < STEPS; k++) { // in the order of steps; metres
        const kn_scene_item *item = &scene.items[k];
        assert_memory_equal(item->material.base_color, palette[k], sizeof palette[k]);
        assert_true(item->mesh.ntriangles > 0);
        double lo = INFINITY, hi = -INFINITY;
        for (size_t i = 0; i < item->mesh.nvertices; i++) {
            lo = fmin(lo, 1e3 * item->mesh.position[3 * i]);
            hi = fmax(hi, 1e3 * item->mesh.position[3 * i]);
        }
        // the rounding of float32, of 1e-3 and of the products
        assert_true(fabs(lo - (double)k / STEPS) <= 2e-7 && fabs(hi - (k + 1.0) / STEPS) <= 2e-7);
    }
    kn_scene_clear(ctx, &scene);
}

static void read_back(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    char step[TEST_PATH_BYTES], gltf[TEST_PATH_BYTES];
    test_tmp_path(step, "colors.step");
    test_tmp_path(gltf, "colors.glb");
    write_both(ctx, step, gltf);
    find_in_step(ctx, step);
    find_in_gltf(ctx, gltf);
    remove(step);
    remove(gltf);
    test_ctx_end(ctx, &memory);
}

// Colours that no cell has are meshes without triangles: left out, also of meshes that move.
static void empty_meshes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "empty.glb");
    double position[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, normal[9] = {0, 0, 1, 0, 0, 1, 0, 0, 1};
    uint32_t triangle[3] = {0, 1, 2};
    const kn_mesh one = {
        .nvertices = 3, .ntriangles = 1, .position = position, .normal = normal, .triangle = triangle};
    kn_scene_item first[2] = {{.material = {{1, 0, 0}, 0, 1}}, {.mesh = one, .material = {{0, 1, 0}, 0, 1}}};
    kn_scene_item second[2] = {first[0], first[1]};
    const kn_scene frames[2] = {{first, 2}, {second, 2}};
    kn_scene found = {0};
    assert_int_equal(kn_gltf_write_frames(ctx, path, frames, 2, 1.0, NULL), KN_OK);
    assert_int_equal(kn_gltf_read(ctx, &found, path), KN_OK);
    assert_int_equal(found.nitems, 1);
    assert_true(found.items[0].material.base_color[1] == 1 && found.items[0].mesh.ntriangles == 1);
    kn_scene_clear(ctx, &found);
    remove(path);
    second[0].mesh = one; // it comes later
    assert_int_equal(kn_gltf_write_frames(ctx, path, frames, 2, 1.0, NULL), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "mesh 0 is empty"));
    kn_ctx_clear_error(ctx);
    second[0] = first[0], second[1].mesh = (kn_mesh){0}; // or goes
    assert_int_equal(kn_gltf_write_frames(ctx, path, frames, 2, 1.0, NULL), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(read_back), cmocka_unit_test(empty_meshes)};
    return cmocka_run_group_tests_name("bridges/colors", tests, NULL, NULL);
}
