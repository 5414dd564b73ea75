// SPDX-License-Identifier: Apache-2.0
#include "tests/support/support.h"

#if KN_WITH_OCCT
#include "tests/bridges/occt_trip.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void trip_start(trip *t, const char *file, int nparts)
{
    *t = (trip){.memory = TEST_MEMORY_INIT};
    t->ctx = test_ctx(&t->memory, 1);
    t->rng = test_random(4242);
    test_tile_make(&t->tile, nparts);
    test_tmp_path(t->path, file);
}

void trip_end(trip *t)
{
    kn_occt_close(t->ctx, t->model);
    for (size_t i = 0; i < t->count; i++) kn_bezier_clear(t->ctx, &t->patch[i].bezier);
    remove(t->path);
    test_ctx_end(t->ctx, &t->memory);
}

kn_patch *trip_add(trip *t, int m, int n, bool rational)
{
    assert_true(t->count < sizeof t->patch / sizeof *t->patch);
    kn_patch *patch = &t->patch[t->count];
    test_patch(t->ctx, patch, &t->rng, m, n, rational, 1.25 * (double)t->count, 0.1);
    patch->id = (kn_patch_id){.surface = 2, .cell = {(int)t->count, 7}, .patch = 12};
    t->count++;
    return patch;
}

void trip_add_cuts(trip *t, kn_trim *side, int n)
{
    // a circle, and lines that bend from one edge to the opposite one
    static const double square[3] = {0.25, -0.25, 0.25}, bent[3] = {-0.4, 0.1, 0.45};
    const kn_trim whole = {0};
    for (int k = 0; k < n; k++) {
        kn_bezier f = {0};
        kn_trim_cut_report report;
        assert_int_equal(kn_bezier_init(t->ctx, &f, 2, 1, false, (int[]){2, 2}), KN_OK);
        for (int i = 0; i < 9; i++)
            f.coef[i] = k == 0 ? square[i / 3] + square[i % 3] - 0.1
                               : bent[i / 3] + test_uniform(&t->rng, -0.08, 0.08);
        assert_int_equal(kn_trim_cut(t->ctx, &side[2 * k], &side[2 * k + 1], &report, &whole, &f, 1e-3), KN_OK);
        assert_true(report.below && report.above);
        for (int i = 0; i < 2; i++) {
            kn_patch *patch = trip_add(t, 2 + k, 3, k % 2 == 1);
            patch->trim = &side[2 * k + i];
            patch->reversed = k == 3;
        }
        kn_bezier_clear(t->ctx, &f);
    }
}

static int larger(int a, int b)
{
    return a > b ? a : b;
}

void trip_write(trip *t, kn_sink *sink, size_t block)
{
    kn_job_report report = test_report(t->count, 0, 0);
    for (size_t i = 0; i < t->count; i++) {
        const kn_spline s = kn_patch_spline(&t->patch[i]);
        const kn_trim *trim = t->patch[i].trim;
        size_t spans = 0, curves = trim ? (size_t)trim->ncurves : 0;
        for (int d = 0; d < 2; d++) report.degree[d] = larger(report.degree[d], s.degree[d]);
        for (size_t k = 0; k < curves; k++) spans += (size_t)kn_spline_spans(&trim->curves[k], 0);
        if (curves > report.trim_curves) report.trim_curves = curves;
        if (spans > report.trim_spans) report.trim_spans = spans;
    }
    assert_int_equal(test_feed(t->ctx, sink, &t->tile.tile, &report, t->patch, t->count, block), KN_OK);
    kn_sink_close(t->ctx, sink);
}

void trip_read(trip *t)
{
    bool iges = strcmp(t->path + strlen(t->path) - 4, ".igs") == 0;
    kn_status status = iges ? kn_occt_open_iges(t->ctx, &t->model, t->path)
                            : kn_occt_open_step(t->ctx, &t->model, t->path);
    if (status == KN_OK) status = kn_occt_check(t->ctx, &t->report, t->model);
    assert_string_equal(kn_ctx_message(t->ctx), "");
    assert_int_equal(status, KN_OK);
    assert_true(t->report.unit_mm == 1.0); // whatever the model's own unit is, millimetres are written
    assert_int_equal(t->report.faces, t->count);
    assert_int_equal(t->report.first_invalid, -1);
    assert_int_equal(t->report.valid_faces, t->count);
    assert_true(t->report.valid);
}

// Both sides evaluate the same control points by convex combinations of de Boor's kind: each level rounds by at most
// gamma(3) of the largest coordinate, over degree levels in each variable, and the projection of a rational point
// adds a few more. 1e-12 of the largest coordinate is far above that for degree 25.
void trip_expect_points(trip *t, double unit_mm)
{
    for (size_t i = 0; i < t->count; i++)
        for (int k = 0; k < 20; k++) {
            double at[2] = {test_uniform(&t->rng, 0.0, 1.0), test_uniform(&t->rng, 0.0, 1.0)}, ours[3], theirs[3];
            const kn_spline s = kn_patch_spline(&t->patch[i]);
            assert_int_equal(kn_spline_eval(t->ctx, ours, &s, at), KN_OK);
            assert_int_equal(kn_occt_eval(t->ctx, theirs, NULL, t->model, (int)i, at[0], at[1]), KN_OK);
            for (int c = 0; c < 3; c++) ours[c] *= unit_mm;
            double size = fabs(ours[0]) + fabs(ours[1]) + fabs(ours[2]) + unit_mm;
            assert_true(test_max_difference(ours, theirs, 3) <= 1e-12 * size);
        }
}
#endif
