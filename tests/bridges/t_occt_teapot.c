// SPDX-License-Identifier: Apache-2.0
// The chain teapot through a STEP file: Open CASCADE finds every face valid, and its points are T(D(r,t)) as computed
// from the surface's control points alone, in long double.
#include "tests/support/support.h"

#include <knurl/io.h>
#include <knurl/step.h>

#if KN_WITH_OCCT
#include "bridges/occt/occt_check.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

enum { SURFACES = 32 };

// Every patch's identity, in the order in which the STEP sink saw it.
typedef struct record {
    kn_patch_id *id;
    bool *exact;
    size_t count, room;
} record;

static kn_status record_begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    (void)ctx;
    (void)tile;
    record *r = user;
    r->room = report->patches;
    r->id = test_calloc(r->room, sizeof *r->id);
    r->exact = test_calloc(r->room, sizeof *r->exact);
    return KN_OK;
}

static kn_status record_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)ctx;
    (void)product;
    record *r = user;
    assert_int_equal(block->first, r->count);
    assert_true(r->count + block->count <= r->room);
    for (size_t i = 0; i < block->count; i++) {
        r->id[r->count] = block->patches[i].id;
        r->exact[r->count++] = block->patches[i].exact;
    }
    return KN_OK;
}

typedef struct scene {
    test_memory memory;
    kn_ctx *ctx;
    test_rng rng;
    kn_model base;
    kn_tile tile;
    kn_job *job;
    kn_job_report report;
    record record;
    kn_occt_model *model;
    char path[TEST_PATH_BYTES];
} scene;

static void scene_make(scene *s, const int *surface, int nsurfaces, double normal_tol)
{
    *s = (scene){.memory = TEST_MEMORY_INIT};
    s->ctx = test_ctx(&s->memory, 0);
    s->rng = test_random(77);
    test_tmp_path(s->path, "teapot.step");
    assert_int_equal(kn_read_bpt(s->ctx, &s->base, "data/teapot.bpt"), KN_OK);
    assert_int_equal(kn_builtin_tile(s->ctx, &s->tile, "chain"), KN_OK);
    kn_spline chosen[SURFACES];
    for (int i = 0; i < nsurfaces; i++) chosen[i] = s->base.splines[surface[i]];
    kn_job_options options = {.count = {1, 1}, .normal_tol = normal_tol};
    kn_status status = kn_job_create(s->ctx, &s->job, chosen, nsurfaces, &s->tile, &options);
    assert_string_equal(kn_ctx_message(s->ctx), "");
    assert_int_equal(status, KN_OK);
    s->report = kn_job_describe(s->job);
    kn_sink sinks[2] = {{0}, {.user = &s->record, .begin = record_begin, .commit = record_commit}};
    assert_int_equal(kn_step_sink(s->ctx, &sinks[0], s->path, NULL), KN_OK);
    assert_int_equal(kn_job_run(s->ctx, s->job, sinks, 2), KN_OK);
    kn_sink_close(s->ctx, &sinks[0]);
    assert_int_equal(s->record.count, s->report.patches);
    assert_int_equal(kn_occt_open_step(s->ctx, &s->model, s->path), KN_OK);
}

static void scene_clear(scene *s)
{
    kn_occt_close(s->ctx, s->model);
    test_free(s->record.id);
    test_free(s->record.exact);
    kn_job_destroy(s->ctx, s->job);
    kn_tile_clear(s->ctx, &s->tile);
    kn_model_clear(s->ctx, &s->base);
    remove(s->path);
    test_ctx_end(s->ctx, &s->memory);
}

static void expect_valid(const scene *s)
{
    kn_occt_report found;
    assert_int_equal(kn_occt_check(s->ctx, &found, s->model), KN_OK);
    assert_int_equal(found.faces, s->report.patches);
    assert_int_equal(found.first_invalid, -1);
    assert_int_equal(found.valid_faces, s->report.patches);
    assert_int_equal(found.ncolours, s->tile.nparts);
    assert_true(found.unit_mm == 1.0);
    // the file itself announces 1e-3 mm
    assert_true(found.max_tolerance <= 1e-3);
}

// ---- T, from the definition ----

// One component of a bicubic piece and its two derivatives at (u,v), anywhere, by de Casteljau in v and then in u.
static void bicubic(long double out[3], const double *p, long double u, long double v)
{
    long double row[4], slope[4];
    for (int i = 0; i < 4; i++) {
        long double a[4] = {p[4 * i], p[4 * i + 1], p[4 * i + 2], p[4 * i + 3]};
        for (int level = 3; level > 1; level--)
            for (int j = 0; j < level; j++) a[j] += v * (a[j + 1] - a[j]);
        row[i] = a[0] + v * (a[1] - a[0]);
        slope[i] = 3.0L * (a[1] - a[0]);
    }
    for (int level = 3; level > 1; level--)
        for (int j = 0; j < level; j++) {
            row[j] += u * (row[j + 1] - row[j]);
            slope[j] += u * (slope[j + 1] - slope[j]);
        }
    out[0] = row[0] + u * (row[1] - row[0]);
    out[1] = 3.0L * (row[1] - row[0]);
    slope[0] += u * (slope[1] - slope[0]);
    slope[1] += u * (slope[2] - slope[1]);
    out[2] = slope[0];
}

static long double length(const long double a[3])
{
    return sqrtl(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

// S + w N/|N|, N = S_u x S_v. *loss: how much of N's relative precision cancellation costs (large beside a pole).
static void direct(long double out[3], long double *loss, const kn_spline *surface, long double u, long double v,
                   long double w)
{
    long double s[3][3], su[3], sv[3], n[3];
    for (int c = 0; c < 3; c++) {
        bicubic(s[c], surface->coef + 16 * c, u, v);
        su[c] = s[c][1], sv[c] = s[c][2];
    }
    for (int c = 0; c < 3; c++) n[c] = su[(c + 1) % 3] * sv[(c + 2) % 3] - su[(c + 2) % 3] * sv[(c + 1) % 3];
    *loss = length(su) * length(sv) / length(n);
    for (int c = 0; c < 3; c++) out[c] = s[c][0] + w * n[c] / length(n);
}

// A random point of face k: OCCT's point, and where D puts it.
static bool expect_point(scene *s, size_t k)
{
    const kn_patch_id *id = &s->record.id[k];
    double at[2] = {test_uniform(&s->rng, 0.0, 1.0), test_uniform(&s->rng, 0.0, 1.0)}, found[3], d[3], shown[3];
    kn_bezier source = {0};
    assert_int_equal(kn_occt_eval(s->ctx, found, NULL, s->model, (int)k, at[0], at[1]), KN_OK);
    kn_patch_place place;
    assert_int_equal(kn_job_source(s->ctx, &source, &place, s->job, id), KN_OK);
    assert_int_equal(kn_bezier_eval(s->ctx, d, &source, at), KN_OK);
    kn_bezier_clear(s->ctx, &source);
    const kn_shell *shell = kn_job_shell(s->job, place.surface);
    const double *lu = kn_job_lines(s->job, place.surface, 0) + place.cell[0];
    const double *lv = kn_job_lines(s->job, place.surface, 1) + place.cell[1];
    double u = lu[0] + d[0] * (lu[1] - lu[0]), v = lv[0] + d[1] * (lv[1] - lv[0]);

    long double expected[3], loss;
    direct(expected, &loss, kn_shell_surface(shell), u, v, d[2]);
    if (!(loss < 1e6L)) return false; // too close to a pole for this formula
    // |n - N/|N|| <= length_error + angle_error, times |w|. Rounding: the composed control points, OCCT's de Boor and
    // kn_bezier_eval each combine numbers up to the size of the model (5) over some 2 * 24 levels, and D reaches out
    // of its cell, where polynomials of degree 3 grow: 1e-12 is a thousand ulps of 5. Cancellation in N costs LDBL.
    double bound = (s->report.normal.length_error + s->report.normal.angle_error) * fabs(d[2]) + 1e-12 +
                   (double)(100.0L * LDBL_EPSILON * loss * fabsl((long double)d[2]));
    double distance = 0.0;
    for (int c = 0; c < 3; c++) distance = fmax(distance, (double)fabsl((long double)found[c] - expected[c]));
    assert_true(distance <= bound);

    if (s->record.exact[k]) { // no stand-in for n: the shell's own T up to rounding
        assert_int_equal(kn_shell_eval(s->ctx, shown, NULL, shell, u, v, d[2]), KN_OK);
        assert_true(test_max_difference(found, shown, 3) <= 1e-12);
    }
    return true;
}

static void expect_points(scene *s, int wanted)
{
    int checked = 0, tried = 0;
    for (; checked < wanted && tried < 2 * wanted; tried++) {
        size_t k = (size_t)test_int(&s->rng, 0, (int)s->record.count - 1);
        checked += expect_point(s, k);
    }
    assert_true(checked >= wanted);
}

// OCCT takes a minute for all of it: that waits for KN_TEST_SCALE. gcc's release build takes ten patches of all kinds;
// other builds, whose files are the same, one each of the body, the handle, the spout, the lid with its pole and the
// bottom.
static void teapot(void **state)
{
    (void)state;
#if defined NDEBUG && !defined __clang__
    int surface[SURFACES] = {0, 4, 8, 12, 14, 16, 18, 20, 24, 28}, n = 10;
#else
    int surface[SURFACES] = {4, 12, 16, 20, 28}, n = 5;
#endif
    if (test_scale(1) > 1)
        for (n = 0; n < SURFACES; n++) surface[n] = n;
    scene s;
    scene_make(&s, surface, n, 1e-3);
    expect_valid(&s);
    expect_points(&s, 2000);
    scene_clear(&s);
}

// The default tolerance, on a piece of the rim.
static void fine_normal(void **state)
{
    (void)state;
    const int surface[1] = {0};
    scene s;
    scene_make(&s, surface, 1, 1e-6);
    assert_true(s.report.normal.certified && s.report.normal.angle_error <= 1e-6);
    expect_valid(&s);
    expect_points(&s, 1000);
    scene_clear(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(fine_normal), cmocka_unit_test(teapot)};
    return cmocka_run_group_tests_name("bridges/occt_teapot", tests, NULL, NULL);
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
    return cmocka_run_group_tests_name("bridges/occt_teapot", tests, NULL, NULL);
}
#endif
