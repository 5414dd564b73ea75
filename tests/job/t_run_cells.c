// SPDX-License-Identifier: Apache-2.0
// Some cells of a job alone: the patches that the whole job gives for them, and no others.
#include "tests/support/scene.h"
#include "tests/support/support.h"

#include <knurl/io.h>

#include <math.h>
#include <string.h>

static bool same_id(const kn_patch_id *a, const kn_patch_id *b)
{
    return a->surface == b->surface && a->cell[0] == b->cell[0] && a->cell[1] == b->cell[1] && a->part == b->part &&
           a->patch == b->patch && a->piece == b->piece && a->instance == b->instance;
}

static const kn_patch *find(const scene_result *r, const kn_patch_id *id)
{
    for (size_t i = 0; i < r->count; i++)
        if (same_id(&r->patches[i].id, id)) return &r->patches[i];
    return NULL;
}

static void run_ranges(kn_ctx *ctx, const kn_job *job, const kn_cell_range *ranges, size_t n, scene_result *r)
{
    kn_sink sink = scene_sink(r);
    assert_int_equal(kn_job_run_cells(ctx, job, ranges, n, &sink, 1), KN_OK);
    kn_sink_close(ctx, &sink);
}

// All patches of the part are those of the whole, bit for bit; and every cell that was asked for is there. Cells with
// plans of their own may bring neighbours.
static void check_part(const kn_job *job, const scene_result *all, const scene_result *part,
                       const kn_cell_range *ranges, size_t n, bool neighbours)
{
    size_t wanted = 0;
    for (size_t i = 0; i < part->count; i++) {
        const kn_patch *p = &part->patches[i], *q = find(all, &p->id);
        assert_non_null(q);
        assert_memory_equal(p->bezier.coef, q->bezier.coef,
                            (size_t)p->bezier.ncomp * kn_bezier_count(&p->bezier) * sizeof(double));
    }
    int columns = (int)kn_job_describe(job).cells; // of one row
    for (size_t i = 0; i < all->count; i++) {
        const int *cell = all->patches[i].id.cell;
        size_t at = (size_t)cell[0] * 4 + (size_t)cell[1];
        bool asked = false;
        for (size_t k = 0; k < n; k++)
            asked = asked || (at >= ranges[k].first && at - ranges[k].first < ranges[k].count);
        wanted += asked;
        if (asked) assert_non_null(find(part, &all->patches[i].id));
    }
    assert_int_equal(columns, 20);
    assert_true(neighbours ? part->count >= wanted : part->count == wanted);
}

static void try_job(const kn_job_options *o, bool neighbours)
{
    static const kn_cell_range ranges[] = {{0, 1}, {3, 2}, {5, 1}, {11, 4}, {19, 1}};
    for (int threads = 1; threads < 3; threads++) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, threads);
        kn_spline s = {0};
        kn_tile tile = {0};
        kn_job *job = NULL;
        scene_result all, part;
        scene_bicubic(ctx, &s, 0.02);
        assert_int_equal(kn_builtin_tile(ctx, &tile, "bump"), KN_OK);
        assert_int_equal(kn_job_create(ctx, &job, &s, 1, &tile, o), KN_OK);
        scene_run(ctx, job, &all);
        for (size_t n = 0; n <= 5; n++) {
            run_ranges(ctx, job, ranges, n, &part);
            check_part(job, &all, &part, ranges, n, neighbours);
            scene_result_clear(&part);
        }
        scene_result_clear(&all);
        kn_job_destroy(ctx, job);
        kn_tile_clear(ctx, &tile);
        kn_spline_clear(ctx, &s);
        test_ctx_end(ctx, &memory);
    }
}

static double half(const void *user, const kn_place *place)
{
    (void)user;
    return 0.5 + place->uv[0];
}

static void shared_plans(void **state)
{
    (void)state;
    try_job(&(kn_job_options){.count = {5, 4}, .height = 0.1, .normal_tol = 1e-2}, false);
}

static void own_plans(void **state)
{
    (void)state;
    const kn_job_vary vary = {"height", {half, NULL, 0}};
    try_job(&(kn_job_options){.count = {5, 4}, .height = 0.1, .normal_tol = 1e-2, .vary = &vary, .nvary = 1}, true);
}

static void refusals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    kn_sink sink;
    scene_bicubic(ctx, &s, 0.02);
    scene_dome(ctx, &tile);
    const kn_job_options o = {.count = {5, 4}, .normal_tol = 1e-2};
    assert_int_equal(kn_job_create(ctx, &job, &s, 1, &tile, &o), KN_OK);
    assert_int_equal(kn_null_sink(ctx, &sink), KN_OK);
    const kn_cell_range bad[][2] = {{{0, 0}, {1, 1}},       {{3, 1}, {2, 1}},  {{3, 2}, {4, 1}},
                                    {{0, 1}, {20, 1}},      {{0, 1}, {19, 2}}, {{0, 1}, {SIZE_MAX, 1}},
                                    {{0, 1}, {2, SIZE_MAX}}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        kn_ctx_clear_error(ctx);
        assert_int_equal(kn_job_run_cells(ctx, job, bad[i], 2, &sink, 1), KN_EDOMAIN);
    }
    kn_sink_close(ctx, &sink);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(shared_plans), cmocka_unit_test(own_plans),
                                       cmocka_unit_test(refusals)};
    return cmocka_run_group_tests_name("job/run_cells", tests, NULL, NULL);
}
