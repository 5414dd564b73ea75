// SPDX-License-Identifier: Apache-2.0
// Curves, volumes and meshes of a tile in the files of sinks.
#include "tests/support/scene.h"
#include "tests/support/support.h"

#include <knurl/io.h>
#include <knurl/step.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Parts "wire": a curve; "bar": a box over the whole of u; "gem": a triangle as a mesh, when asked for.
static kn_job *make_job(kn_ctx *ctx, bool volume, bool mesh, bool rational)
{
    static const double line[6] = {0.25, 0.25, 0, 0.75, 0.5, 1};
    static double position[9] = {0.25, 0.75, 0, 0.5, 0.75, 0, 0.5, 0.875, 0.5};
    static uint32_t triangle[3] = {0, 1, 2};
    const kn_mesh gem = {.nvertices = 3, .ntriangles = 1, .position = position, .triangle = triangle};
    double box[24];
    for (int i = 0; i < 8; i++)
        box[3 * i] = i >> 2 & 1, box[3 * i + 1] = 0.25 + 0.5 * (i >> 1 & 1), box[3 * i + 2] = i & 1;
    kn_spline s = {0}, base = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    kn_job_options o = kn_job_defaults();
    o.count[0] = 3, o.count[1] = 2, o.height = 0.1, o.mesh_tol = 1;
    assert_int_equal(kn_tile_init(ctx, &tile, "kinds", 3), KN_OK);
    strcpy(tile.parts[0].name, "wire"), strcpy(tile.parts[1].name, "bar"), strcpy(tile.parts[2].name, "gem");
    scene_multilinear(ctx, &s, 1, line);
    assert_int_equal(kn_tile_add(ctx, &tile, 0, &s), KN_OK);
    scene_multilinear(ctx, &s, 3, box);
    if (volume) assert_int_equal(kn_tile_add(ctx, &tile, 1, &s), KN_OK);
    if (mesh) assert_int_equal(kn_tile_set_mesh(ctx, &tile, 2, &gem), KN_OK);
    rational ? scene_torus(ctx, &base) : scene_bicubic(ctx, &base, 0.2);
    if (kn_job_create(ctx, &job, &base, 1, &tile, &o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &base), kn_tile_clear(ctx, &tile);
    return job;
}

static size_t count_of(const char *text, const char *what)
{
    size_t n = 0;
    for (const char *at = text; (at = strstr(at, what)); at += strlen(what)) n++;
    return n;
}

static void curves_and_volumes_in_step(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "kinds.step");
    for (int k = 0; k < 4; k++) {
        bool volume = k < 2, rational = k % 2 == 1;
        kn_job *job = make_job(ctx, volume, false, rational);
        kn_sink sink = {0};
        assert_int_equal(kn_step_sink(ctx, &sink, path, NULL), KN_OK);
        if (kn_job_run(ctx, job, &sink, 1) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
        kn_sink_close(ctx, &sink);
        char *text = test_read_file(path, NULL);
        assert_non_null(text);
        // a box has six faces, less the two ends, which neighbours hide but at the ends of the two rows
        assert_int_equal(count_of(text, "=ADVANCED_FACE("), volume ? 6 * 4 + 2 * 2 : 0);
        assert_int_equal(count_of(text, "OPEN_SHELL("), 0);
        assert_int_equal(count_of(text, "=MANIFOLD_SOLID_BREP("), volume ? 2 : 0); // one for each row
        const char *set = strstr(text, "GEOMETRIC_CURVE_SET('wire',(");
        assert_non_null(set);
        char *list = strndup(set, (size_t)(strchr(set, ';') - set));
        assert_int_equal(count_of(list, "#"), 6);
        // what the set names is a curve, and is there
        for (const char *at = list; (at = strchr(at, '#')); at++) {
            char entity[32];
            (void)snprintf(entity, sizeof entity, "\n#%ld=", strtol(at + 1, NULL, 10));
            const char *curve = strstr(text, entity);
            assert_non_null(curve);
            assert_non_null(strstr(curve, "B_SPLINE_CURVE"));
            assert_true(strstr(curve, "B_SPLINE_CURVE") < strchr(curve, ';'));
        }
        assert_int_equal(count_of(text, volume ? "=SHAPE_REPRESENTATION("
                                               : "=GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION("),
                         1);
        free(list), free(text);
        kn_job_destroy(ctx, job);
    }
    test_ctx_end(ctx, &memory);
}

static void meshes_are_no_step(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "mesh.step");
    kn_job *job = make_job(ctx, true, true, false);
    kn_sink sink = {0};
    kn_model model = {0};
    assert_int_equal(kn_step_sink(ctx, &sink, path, NULL), KN_OK);
    assert_int_equal(kn_job_run(ctx, job, &sink, 1), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "6 of the patches are meshes"));
    kn_sink_close(ctx, &sink);
    assert_null(test_read_file(path, NULL));
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_collect_sink(ctx, &sink, &model), KN_OK);
    assert_int_equal(kn_job_run(ctx, job, &sink, 1), KN_EDOMAIN);
    kn_sink_close(ctx, &sink);
    assert_int_equal(model.nsplines, 0);
    kn_job_destroy(ctx, job);
    test_ctx_end(ctx, &memory);
}

static void all_kinds_in_obj_and_stl(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    size_t bytes = 0;
    kn_job *job = make_job(ctx, true, true, false);
    kn_sink sinks[2] = {{0}};
    test_tmp_path(path, "kinds.obj");
    assert_int_equal(kn_obj_sink(ctx, &sinks[0], path), KN_OK);
    char stl[TEST_PATH_BYTES];
    test_tmp_path(stl, "kinds.stl");
    assert_int_equal(kn_stl_sink(ctx, &sinks[1], stl), KN_OK);
    assert_int_equal(kn_job_run(ctx, job, sinks, 2), KN_OK);
    for (int k = 0; k < 2; k++) kn_sink_close(ctx, &sinks[k]);
    char *text = test_read_file(path, NULL);
    assert_int_equal(count_of(text, "\nl -"), 6);
    // 28 faces of two triangles or more and six meshes of one or more
    size_t faces = count_of(text, "\nf ");
    assert_true(faces >= 28 * 2 + 6);
    free(text);
    unsigned char *data = (unsigned char *)test_read_file(stl, &bytes);
    assert_int_equal(data[80] | data[81] << 8 | data[82] << 16, faces); // none is degenerate here
    free(data);
    kn_job_destroy(ctx, job);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(curves_and_volumes_in_step),
                                       cmocka_unit_test(meshes_are_no_step),
                                       cmocka_unit_test(all_kinds_in_obj_and_stl)};
    return cmocka_run_group_tests_name("io/model_sinks", tests, NULL, NULL);
}
