// SPDX-License-Identifier: Apache-2.0
// Several jobs into one set of sinks, and a job over what another one has composed.
#include "tests/support/scene.h"
#include "tests/support/support.h"

#include <knurl/io.h>

#include <float.h>
#include <math.h>
#include <string.h>

static void bilinear(kn_ctx *ctx, kn_spline *out, const double *corner)
{
    const int degree[2] = {1, 1};
    kn_bezier b = {0};
    assert_int_equal(kn_bezier_init(ctx, &b, 2, 3, false, degree), KN_OK);
    for (size_t i = 0; i < 4; i++)
        for (size_t c = 0; c < 3; c++) b.coef[c * 4 + i] = corner[3 * i + c];
    assert_int_equal(kn_spline_of_bezier(ctx, out, &b), KN_OK);
    kn_bezier_clear(ctx, &b);
}

// A roof over the cell, with its ridge along v: two bilinear sheets.
static void make_roof(kn_ctx *ctx, kn_tile *out)
{
    static const double half[2][12] = {{0, 0, 0, 0, 1, 0, 0.5, 0, 1, 0.5, 1, 1},
                                       {0.5, 0, 1, 0.5, 1, 1, 1, 0, 0, 1, 1, 0}};
    assert_int_equal(kn_tile_init(ctx, out, "roof", 1), KN_OK);
    strcpy(out->parts[0].name, "roof");
    for (int k = 0; k < 2; k++) {
        kn_spline s = {0};
        bilinear(ctx, &s, half[k]);
        assert_int_equal(kn_tile_add(ctx, out, 0, &s), KN_OK);
        kn_spline_clear(ctx, &s);
    }
}

static kn_job *make_job(kn_ctx *ctx, const kn_spline *base, int n, const kn_tile *tile, const kn_spline *direction,
                        int count, double height)
{
    kn_job *job = NULL;
    kn_job_options o = kn_job_defaults();
    o.count[0] = o.count[1] = count;
    o.height = height;
    o.direction = direction;
    o.spacing = KN_CELLS_UNIFORM;
    if (kn_job_create(ctx, &job, base, n, tile, &o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return job;
}

// What a sink has seen of begin.
typedef struct seen {
    scene_result result;
    int nparts;
    char name[3][KN_NAME_BYTES];
    kn_job_report report;
} seen;
static kn_status note_begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    (void)ctx;
    seen *s = user; // whose first member is what scene's sink has
    s->result.begun++;
    s->nparts = tile->nparts;
    for (int p = 0; p < tile->nparts && p < 3; p++) memcpy(s->name[p], tile->parts[p].name, KN_NAME_BYTES);
    s->report = *report;
    return KN_OK;
}

static void layers_in_one_run(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    kn_spline base[2] = {{0}};
    kn_tile roof = {0}, strip = {0};
    scene_bicubic(ctx, &base[0], 0.3), scene_torus(ctx, &base[1]);
    make_roof(ctx, &roof), scene_strip(ctx, &strip);
    kn_job *jobs[3] = {make_job(ctx, &base[0], 1, &roof, NULL, 3, 0.1),
                       make_job(ctx, &base[1], 1, &strip, NULL, 2, 0.1),
                       make_job(ctx, &base[0], 1, &roof, NULL, 2, -0.1)};
    const kn_job *const layers[3] = {jobs[0], jobs[1], jobs[2]};
    seen all = {0};
    scene_result one[3];
    kn_sink sink = scene_sink(&all.result);
    sink.begin = note_begin;
    assert_int_equal(kn_job_run_layers(ctx, layers, 3, &sink, 1), KN_OK);
    kn_sink_close(ctx, &sink);
    assert_true(all.result.begun == 1 && all.result.ended == 1);
    assert_int_equal(all.nparts, 3);
    assert_string_equal(all.name[0], "roof");
    assert_string_not_equal(all.name[2], "roof"); // taken
    size_t at = 0;
    for (int k = 0; k < 3; k++) {
        scene_run(ctx, jobs[k], &one[k]);
        for (size_t i = 0; i < one[k].count; i++, at++) {
            const kn_patch *p = &all.result.patches[at], *q = &one[k].patches[i];
            assert_true(p->id.layer == k && p->id.part == k && q->id.layer == 0 && q->id.part == 0);
            assert_int_equal(p->id.patch, q->id.patch);
            assert_memory_equal(p->bezier.coef, q->bezier.coef,
                                (size_t)q->bezier.ncomp * kn_bezier_count(&q->bezier) * sizeof(double));
        }
        scene_result_clear(&one[k]);
    }
    assert_int_equal(at, all.result.count);
    assert_int_equal(all.report.patches, at);
    assert_int_equal(kn_job_describe_layers(layers, 3).cells, 9 + 4 + 4);
    assert_int_equal(kn_job_run_layers(ctx, layers, 0, &sink, 1), KN_EDOMAIN);
    assert_int_equal(kn_job_run_layers(ctx, layers, 1, &sink, 1), KN_EDOMAIN); // closed
    scene_result_clear(&all.result);
    for (int k = 0; k < 3; k++) kn_job_destroy(ctx, jobs[k]);
    for (int k = 0; k < 2; k++) kn_spline_clear(ctx, &base[k]);
    kn_tile_clear(ctx, &roof), kn_tile_clear(ctx, &strip);
    test_ctx_end(ctx, &memory);
}

// T1 = (u, v, u v / 2) + w (0, 0, 1) over [0,1]^2.
static void direct(long double out[3], long double u, long double v, long double w)
{
    out[0] = u, out[1] = v, out[2] = u * v / 2 + w;
}

// (u, v, w) of the tile patch behind a composed one, in the parameters of the base.
static void source(kn_ctx *ctx, long double out[3], int *surface, const kn_job *job, const kn_patch_id *id, double r,
                   double t)
{
    kn_bezier d = {0};
    kn_patch_place place;
    const double at[2] = {r, t};
    double uvw[3];
    assert_int_equal(kn_job_source(ctx, &d, &place, job, id), KN_OK);
    assert_int_equal(kn_bezier_eval(ctx, uvw, &d, at), KN_OK);
    for (int k = 0; k < 2; k++) out[k] = scene_parameter(job, place.surface, k, place.cell[k] + (long double)uvw[k]);
    out[2] = uvw[2];
    *surface = kn_job_origin(job, place.surface, NULL);
    kn_bezier_clear(ctx, &d);
}

// A roof over every cell of a roof over every cell of a twisted sheet: T2(D2) with T2's base T1(D1), both evaluated
// by themselves in long double. Sizes are about 1, degrees 4 and 4: rounding of two compositions, gamma(200) or so.
static void two_levels_deep(void **state)
{
    (void)state;
    static const double corner[12] = {0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0.5};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    kn_spline base = {0}, up = {0};
    kn_tile roof = {0};
    kn_model first = {0};
    kn_sink sink = {0};
    scene_result one = {0}, two = {0};
    static const double vertical[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    bilinear(ctx, &base, corner), bilinear(ctx, &up, vertical);
    make_roof(ctx, &roof);
    kn_job *lower = make_job(ctx, &base, 1, &roof, &up, 2, 0.25), *upper;
    assert_int_equal(kn_collect_sink(ctx, &sink, &first), KN_OK);
    assert_int_equal(kn_job_run(ctx, lower, &sink, 1), KN_OK);
    kn_sink_close(ctx, &sink);
    scene_run(ctx, lower, &one);
    assert_int_equal(first.nsplines, 8);
    upper = make_job(ctx, first.splines, first.nsplines, &roof, &up, 2, 0.0625);
    scene_run(ctx, upper, &two);
    assert_int_equal(two.count, 8 * 4 * 2);
    kn_job_report report = kn_job_describe(upper);
    assert_int_equal(report.exact_patches, report.patches);
    for (size_t i = 0; i < two.count; i++)
        for (int k = 0; k < 9; k++) {
            const double at[2] = {k / 3 / 2.0, k % 3 / 2.0};
            double got[3];
            long double inner[3], outer[3], want[3];
            int surface, whole;
            source(ctx, outer, &surface, upper, &two.patches[i].id, at[0], at[1]);
            source(ctx, inner, &whole, lower, &one.patches[surface].id, (double)outer[0], (double)outer[1]);
            direct(want, inner[0], inner[1], inner[2] + outer[2]); // up is the same at both levels
            assert_int_equal(kn_bezier_eval(ctx, got, &two.patches[i].bezier, at), KN_OK);
            for (int c = 0; c < 3; c++) assert_true(fabsl(got[c] - want[c]) <= 200 * DBL_EPSILON);
        }
    scene_result_clear(&one), scene_result_clear(&two);
    kn_job_destroy(ctx, lower), kn_job_destroy(ctx, upper);
    kn_model_clear(ctx, &first), kn_tile_clear(ctx, &roof);
    kn_spline_clear(ctx, &base), kn_spline_clear(ctx, &up);
    test_ctx_end(ctx, &memory);
}

static kn_status run_call(kn_ctx *ctx, void *user)
{
    const kn_job *const layers[2] = {user, user};
    kn_model model = {0};
    kn_sink sink = {0};
    kn_status status = kn_collect_sink(ctx, &sink, &model);
    if (status == KN_OK) status = kn_job_run_layers(ctx, layers, 2, &sink, 1);
    assert_true((status == KN_OK) == (model.nsplines > 0));
    kn_sink_close(ctx, &sink);
    kn_model_clear(ctx, &model);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static const double flat[12] = {0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0},
                        up[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    kn_spline base = {0}, direction = {0};
    kn_tile roof = {0};
    bilinear(ctx, &base, flat), bilinear(ctx, &direction, up), make_roof(ctx, &roof);
    kn_job *job = make_job(ctx, &base, 1, &roof, &direction, 1, 0.1);
    kn_spline_clear(ctx, &direction);
    test_allocation_failures(run_call, job);
    kn_job_destroy(ctx, job);
    kn_spline_clear(ctx, &base), kn_tile_clear(ctx, &roof);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(layers_in_one_run), cmocka_unit_test(two_levels_deep),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("job/layers", tests, NULL, NULL);
}
