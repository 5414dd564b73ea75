// SPDX-License-Identifier: Apache-2.0
// Jobs that must fail, sinks that fail, cancelling, and running out of memory.
#include "tests/support/support.h"

#include "tests/support/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static kn_status create(kn_ctx *ctx, const kn_spline *s, int n, const kn_tile *tile, const kn_job_options *o)
{
    kn_job *job = NULL;
    kn_ctx_clear_error(ctx);
    kn_status status = kn_job_create(ctx, &job, s, n, tile, o);
    assert_true((status == KN_OK) == (job != NULL));
    assert_int_equal(kn_ctx_error(ctx), status);
    kn_job_destroy(ctx, job);
    return status;
}

static void bad_options(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    kn_tile tile = {0};
    scene_bicubic(ctx, &s, 0.01);
    scene_dome(ctx, &tile);
    const kn_job_options good = {.count = {1, 1}, .normal_tol = 1e-2};
    assert_int_equal(create(ctx, &s, 1, &tile, &good), KN_OK);
    for (int wrong = 0; wrong < 14; wrong++) {
        kn_job_options o = good;
        kn_status want = KN_EDOMAIN;
        if (wrong == 0) o.size[0] = -1;
        if (wrong == 1) o.size[1] = NAN;
        if (wrong == 2) o.height = INFINITY;
        if (wrong == 3) o.offset = NAN;
        if (wrong == 4) o.count[0] = -1;
        if (wrong == 5) o.normal_tol = -1e-6;
        if (wrong == 6) o.mesh_tol = INFINITY;
        if (wrong == 7) o.max_degree = -1;
        if (wrong == 8) o.max_degree = KN_MAX_DEGREE + 1, want = KN_ELIMIT;
        if (wrong == 9) o.count[1] = 1000000000, want = KN_ELIMIT;
        if (wrong == 10) o.count[0] = o.count[1] = 60000, want = KN_ELIMIT;
        if (wrong == 11) o.count[0] = 0, o.size[0] = 1e-12, want = KN_ELIMIT;
        if (wrong == 12) o.max_degree = 11; // biquadratic tile: 2 (3 + 3 + 1) = 14
        if (wrong == 13) o.max_degree = 13;
        assert_int_equal(create(ctx, &s, 1, &tile, &o), want);
        if (wrong >= 12) assert_non_null(strstr(kn_ctx_message(ctx), "--max-degree 14"));
    }
    kn_job_options o = good;
    o.max_degree = 14;
    assert_int_equal(create(ctx, &s, 1, &tile, &o), KN_OK);
    assert_int_equal(create(ctx, &s, 1, &tile, NULL), KN_OK);
    kn_spline_clear(ctx, &s), kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

static void bad_operands(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    kn_spline s = {0}, knotty = {0}, line = {0};
    kn_tile tile = {0}, empty = {0}, diamond = {0};
    scene_bicubic(ctx, &s, 0.01), scene_spline(ctx, &knotty);
    scene_dome(ctx, &tile), scene_diamond(ctx, &diamond);
    const kn_job_options o = {.count = {4, 4}, .normal_tol = 1e-2};
    assert_int_equal(create(ctx, &s, 0, &tile, &o), KN_EDOMAIN);
    assert_int_equal(kn_tile_init(ctx, &empty, "", 1), KN_OK);
    assert_int_equal(create(ctx, &s, 1, &empty, &o), KN_EDOMAIN);
    // it crosses knot lines, and no line of its own parameters is there
    assert_int_equal(create(ctx, &knotty, 1, &diamond, &o), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "knot line"));
    const int degree = 1, count = 2;
    const double knots[] = {0, 0, 1, 1}, *k = knots;
    assert_int_equal(kn_spline_init(ctx, &line, 1, 3, false, &degree, &count, &k, NULL), KN_OK);
    assert_int_equal(create(ctx, &line, 1, &tile, &o), KN_EDOMAIN);
    double keep = s.coef[5];
    s.coef[5] = NAN;
    assert_int_equal(create(ctx, &s, 1, &tile, &o), KN_EDOMAIN);
    s.coef[5] = keep;
    double *u = &tile.parts[0].splines[0].coef[0], inside = *u;
    for (int i = 0; i < 4; i++) { // lines that nobody can count
        *u = (const double[]){1e6, -1e6, 258.0, -257.0}[i];
        assert_int_equal(create(ctx, &s, 1, &tile, &o), KN_ELIMIT);
    }
    *u = inside;
    for (int i = 0; i < 48; i++) s.coef[i] = 1; // a point
    assert_int_equal(create(ctx, &s, 1, &tile, &o), KN_EDOMAIN);

    kn_job *job = NULL;
    kn_bezier d = {0};
    scene_result r;
    kn_sink sink = scene_sink(&r);
    assert_int_equal(
        kn_job_create(ctx, &job, &knotty, 1, &tile, &(kn_job_options){.count = {4, 4}, .normal_tol = 1e-2}), KN_OK);
    const kn_patch_id bad[] = {{-1, {0, 0}, 0, 0, 0, 0, 0}, {1, {0, 0}, 0, 0, 0, 0, 0}, {0, {4, 0}, 0, 0, 0, 0, 0},
                               {0, {0, -1}, 0, 0, 0, 0, 0}, {0, {0, 0}, 1, 0, 0, 0, 0}, {0, {0, 0}, 0, 4, 0, 0, 0},
                               {0, {0, 0}, 0, 0, -1, 0, 0}, {0, {0, 0}, 0, 0, 99, 0, 0}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(kn_job_source(ctx, &d, NULL, job, &bad[i]), KN_EDOMAIN);
    assert_null(d.coef);
    kn_sink_close(ctx, &sink);
    assert_int_equal(kn_job_run(ctx, job, &sink, 1), KN_EDOMAIN); // closed
    kn_job_destroy(ctx, job);
    kn_job_destroy(ctx, NULL);
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &knotty), kn_spline_clear(ctx, &line);
    kn_tile_clear(ctx, &tile), kn_tile_clear(ctx, &empty), kn_tile_clear(ctx, &diamond);
    test_ctx_end(ctx, &memory);
}

// count x count cells of a flat square, each with `sheets` bilinear patches of one control polygon.
static kn_job *small_job(kn_ctx *ctx, int count, int sheets, kn_status *status)
{
    const int degree[2] = {1, 1}, points[2] = {2, 2};
    const double knots[] = {0, 0, 1, 1}, *k[2] = {knots, knots};
    const double coef[12] = {0, 0, 1, 1, 0, 1, 0, 1, 0, 0, 0, 0};
    const double sheet[12] = {0, 0, 0.5, 0.5, 0, 1, 0, 1, 0, 0.5, 0.5, 1};
    kn_spline s = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    *status = kn_spline_init(ctx, &s, 2, 3, false, degree, points, k, sheet);
    if (*status == KN_OK) *status = kn_tile_init(ctx, &tile, "sheet", 1);
    for (int i = 0; *status == KN_OK && i < sheets; i++) *status = kn_tile_add(ctx, &tile, 0, &s);
    if (*status == KN_OK) memcpy(s.coef, coef, sizeof coef);
    kn_job_options o = {.count = {count, count}, .height = 0.1, .normal_tol = 1e-2};
    if (*status == KN_OK) *status = kn_job_create(ctx, &job, &s, 1, &tile, &o);
    assert_true((*status == KN_OK) == (job != NULL));
    kn_spline_clear(ctx, &s);
    kn_tile_clear(ctx, &tile);
    return job;
}

// ---- sinks that fail ----
enum { AT_BEGIN, AT_WORK, AT_COMMIT, AT_END, NOWHERE };
typedef struct failing {
    int where;
    size_t after; // blocks
    size_t made, committed, discarded, ended;
} failing;

static kn_status fail_begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    (void)ctx;
    assert_string_equal(tile->name, "sheet");
    assert_true(report->patches > 0);
    return ((failing *)user)->where == AT_BEGIN ? KN_EIO : KN_OK;
}

static kn_status fail_work(kn_ctx *worker, void *user, const kn_patch_block *block, void **product)
{
    (void)worker;
    failing *f = user;
    if (f->where == AT_WORK && block->first >= f->after) return KN_EIO;
    *product = malloc(1);
    assert_non_null(*product);
    f->made++; // one thread in this test
    return KN_OK;
}

static kn_status fail_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)ctx;
    failing *f = user;
    free(product);
    f->committed++;
    return f->where == AT_COMMIT && block->first >= f->after ? KN_EIO : KN_OK;
}

static void fail_discard(kn_ctx *ctx, void *user, void *product)
{
    (void)ctx;
    free(product);
    ((failing *)user)->discarded++;
}

static kn_status fail_end(kn_ctx *ctx, void *user)
{
    (void)ctx;
    failing *f = user;
    f->ended++;
    return f->where == AT_END ? KN_EIO : KN_OK;
}

static void failing_sinks(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_status status;
    kn_job *job = small_job(ctx, 16, 16, &status); // 4 blocks
    assert_int_equal(status, KN_OK);
    for (int where = AT_BEGIN; where <= NOWHERE; where++)
        for (int which = 0; which < 3; which++) {
            failing f[3] = {{.where = NOWHERE}, {.where = NOWHERE}, {.where = NOWHERE}};
            kn_sink sinks[3];
            for (int k = 0; k < 3; k++)
                sinks[k] = (kn_sink){.user = &f[k],
                                     .begin = fail_begin,
                                     .work = fail_work,
                                     .commit = fail_commit,
                                     .discard = fail_discard,
                                     .end = fail_end};
            f[which].where = where;
            f[which].after = 2000;
            assert_int_equal(kn_job_run(ctx, job, sinks, 3), where == NOWHERE ? KN_OK : KN_EIO);
            for (int k = 0; k < 3; k++) {
                assert_int_equal(f[k].made, f[k].committed + f[k].discarded); // every product went somewhere
                bool ended = where == NOWHERE || (where == AT_END && k <= which);
                assert_int_equal(f[k].ended, ended);
                if (where == AT_BEGIN) assert_int_equal(f[k].made, 0);
                if (where == AT_WORK || where == AT_COMMIT) assert_true(f[k].committed >= 1);
                kn_sink_close(ctx, &sinks[k]);
            }
        }
    kn_job_destroy(ctx, job);
    test_ctx_end(ctx, &memory);
}

// ---- cancelling ----
typedef struct canceller {
    const char *stage;
    int calls;
} canceller;

static int cancel(void *user, const char *stage, double fraction)
{
    canceller *c = user;
    assert_true(fraction >= 0 && fraction <= 1);
    if (strcmp(stage, c->stage) != 0) return 0;
    return ++c->calls >= 1;
}

static void cancelling(void **state)
{
    (void)state;
    const char *const stages[] = {"shell", "plan", "matrices", "compose"};
    for (int i = 0; i < 4; i++) {
        test_memory memory = TEST_MEMORY_INIT;
        canceller c = {stages[i], 0};
        kn_ctx_options options = {.allocator = test_allocator(&memory), .progress = cancel, .user = &c, .threads = 1};
        kn_ctx *ctx = NULL;
        assert_int_equal(kn_ctx_create(&ctx, &options), KN_OK);
        kn_status status;
        kn_job *job = small_job(ctx, 5, 2, &status);
        if (i < 2) assert_int_equal(status, KN_ECANCELLED);
        if (job) {
            scene_result r;
            kn_sink sink = scene_sink(&r);
            assert_int_equal(kn_job_run(ctx, job, &sink, 1), KN_ECANCELLED);
            assert_int_equal(r.ended, 0);
            kn_sink_close(ctx, &sink);
            scene_result_clear(&r);
        }
        assert_int_equal(kn_ctx_error(ctx), KN_ECANCELLED);
        assert_true(c.calls >= 1);
        kn_job_destroy(ctx, job);
        test_ctx_end(ctx, &memory);
    }
}

// ---- memory ----
static kn_status job_call(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_status status;
    kn_job *job = small_job(ctx, 1, 1, &status);
    kn_job_destroy(ctx, job);
    return status;
}

typedef struct running {
    const kn_job *job;
} running;

static kn_status run_call(kn_ctx *ctx, void *user)
{
    const running *w = user;
    scene_result r;
    kn_sink sink = scene_sink(&r);
    kn_status status = kn_job_run(ctx, w->job, &sink, 1);
    assert_int_equal(r.ended, status == KN_OK);
    kn_sink_close(ctx, &sink);
    scene_result_clear(&r);
    return status;
}

static kn_status source_call(kn_ctx *ctx, void *user)
{
    const running *w = user;
    kn_bezier d = {0};
    const kn_patch_id id = {0};
    kn_status status = kn_job_source(ctx, &d, NULL, w->job, &id);
    assert_true((status == KN_OK) == (d.coef != NULL));
    kn_bezier_clear(ctx, &d);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_allocation_failures(job_call, NULL);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_status status;
    kn_job *job = small_job(ctx, 1, 1, &status);
    assert_int_equal(status, KN_OK);
    running w = {job};
    test_allocation_failures(run_call, &w);
    test_allocation_failures(source_call, &w);
    kn_job_destroy(ctx, job);
    test_ctx_end(ctx, &memory);
}

// ---- memory does not grow with the result ----
static kn_status count_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)ctx, (void)product;
    *(size_t *)user += block->count;
    return KN_OK;
}

static void memory_is_bounded(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT, others = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2), *other = test_ctx(&others, 2);
    kn_status status;
    kn_job *job = small_job(ctx, 64, 16, &status);
    assert_int_equal(status, KN_OK);
    size_t count = 0;
    kn_sink sink = {.user = &count, .commit = count_commit};
    assert_int_equal(kn_job_run(other, job, &sink, 1), KN_OK); // counts what the run alone takes
    assert_int_equal(count, 65536);
    // At most five blocks of 2^18 numbers, with a tenth as much for the rest, and not the 39 MB of all patches.
    assert_int_equal(kn_job_describe(job).control_points, (size_t)65536 * 25);
    assert_true(kn_ctx_counters(other).peak_bytes < 5 * 11 * ((size_t)1 << 18) * sizeof(double) / 10 + 1000000);
    kn_job_destroy(ctx, job);
    test_ctx_end(ctx, &memory);
    test_ctx_end(other, &others);
}

// Planning keeps a few words for each cell, and not the keys of its patches until all cells are done.
static void planning_is_bounded(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    kn_status status;
    kn_job *job = small_job(ctx, 48, 192, &status);
    assert_int_equal(status, KN_OK);
    kn_counters c = kn_ctx_counters(ctx);
    // The keys of 2304 cells of 192 patches are 9 MB, of 128 cells at a time 0.5 MB; the rest is what the shell
    // takes: 48 x 48 pieces of n in scratch, once by each variable.
    assert_true(c.peak_bytes < c.live_bytes + 8000000);
    kn_job_destroy(ctx, job);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(bad_options),         cmocka_unit_test(bad_operands),
                                       cmocka_unit_test(failing_sinks),       cmocka_unit_test(cancelling),
                                       cmocka_unit_test(allocation_failures), cmocka_unit_test(memory_is_bounded),
                                       cmocka_unit_test(planning_is_bounded)};
    return cmocka_run_group_tests_name("job/run", tests, NULL, NULL);
}
