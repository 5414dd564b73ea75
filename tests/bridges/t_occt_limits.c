// SPDX-License-Identifier: Apache-2.0
// What Open CASCADE finds in STEP files of limited degree, and of merged faces: a closed body stays one.
#include "tests/support/surfaces.h"

#include <knurl/io.h>
#include <knurl/step.h>

#if KN_WITH_OCCT
#include "bridges/occt/occt_check.h"

#include <math.h>
#include <stdio.h>

// A texture all over a torus, which closes both ways, into a file behind the limit, and what OCCT makes of it.
static kn_occt_report trip(kn_ctx *ctx, const char *tile_name, const kn_limit_options *limits, double merge,
                           kn_limit_summary *sum, kn_merge_summary *merged)
{
    kn_spline base = {0};
    kn_tile tile;
    kn_job *job = NULL;
    kn_occt_model *model = NULL;
    kn_occt_report report;
    char path[TEST_PATH_BYTES];
    kn_sink step, few, limited;
    test_tmp_path(path, "limits.step");
    make_torus(ctx, &base);
    assert_int_equal(kn_builtin_tile(ctx, &tile, tile_name), KN_OK);
    kn_job_options o = {.count = {4, 4}, .height = 0.1, .normal_tol = 1e-3, .max_degree = KN_MAX_DEGREE};
    assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_OK);
    assert_int_equal(kn_step_sink(ctx, &step, path, NULL), KN_OK);
    few = step;
    if (merge > 0.0)
        assert_int_equal(
            kn_merge_sink(ctx, &few, &step, 1, &(kn_merge_options){.tolerance = merge, .cells = 2}, merged), KN_OK);
    assert_int_equal(kn_limit_sink(ctx, &limited, &few, 1, limits, sum), KN_OK);
    assert_int_equal(kn_job_run(ctx, job, &limited, 1), KN_OK);
    kn_sink_close(ctx, &limited);
    assert_int_equal(kn_occt_open_step(ctx, &model, path), KN_OK);
    assert_int_equal(kn_occt_check(ctx, &report, model), KN_OK);
    kn_occt_close(ctx, model);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &base);
    remove(path);
    return report;
}

static void closed_bodies_stay(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static const kn_limit_options limits[2] = {{3, 1e-2, 0.0}, {6, 1e-3, 0.0}};
    double volume = 0.0;
    for (int i = 0; i < 2; i++) {
        kn_limit_summary sum;
        kn_occt_report r = trip(ctx, "bump", &limits[i], 0.0, &sum, NULL);
        assert_true(sum.limited > 0);
        assert_int_equal(r.faces, sum.limited + sum.exact);
        assert_true(r.valid && r.first_invalid == -1 && r.valid_faces == r.faces);
        assert_int_equal(r.free_edges, 0);
        assert_true(r.solids == 1 && r.closed_shells == 1);
        assert_true(r.max_degree <= limits[i].max_degree && r.max_tolerance < 1e-6);
        // Both volumes are off by no more than the error times the area, which OCCT has.
        if (i > 0) assert_true(fabs(r.volume - volume) <= (limits[0].tolerance + limits[1].tolerance) * 1.1 * r.area);
        volume = r.volume;
    }
    test_ctx_end(ctx, &memory);
}

static void merged_faces_are_valid(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_limit_summary sum;
    kn_merge_summary merged;
    kn_occt_report r = trip(ctx, "bump", &(kn_limit_options){.max_degree = 11, .tolerance = 1e-3}, 1e-3, &sum,
                            &merged);
    assert_int_equal(r.faces, merged.faces);
    assert_true(merged.faces < merged.patches / 4 && merged.error <= 1e-3);
    assert_true(r.first_invalid == -1 && r.valid_faces == r.faces);
    assert_true(r.max_tolerance <= 5e-3); // ends of surfaces are within the two tolerances of the edges
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_bodies_stay),
        cmocka_unit_test(merged_faces_are_valid),
    };
    return cmocka_run_group_tests_name("bridges/occt_limits", tests, NULL, NULL);
}
#else
static void without_occt(void **state)
{
    (void)state;
    skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(without_occt)};
    return cmocka_run_group_tests_name("bridges/occt_limits", tests, NULL, NULL);
}
#endif
