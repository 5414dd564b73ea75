// SPDX-License-Identifier: Apache-2.0
// Layers of a textured object, from the cells near each alone: the same contours as from all cells at once, closed,
// and where the shell says they are.
#include "tests/support/scene.h"
#include "tests/support/support.h"

#include <knurl/construct.h>
#include <knurl/io.h>
#include <knurl/slice.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

// All contours of all layers, as sorted segments.
typedef struct segment {
    double z, a[2], b[2];
} segment;
typedef struct heap {
    segment *list;
    size_t n, room, layers, nopen, nloops;
    double gap, area[64];
} heap;

static kn_status collect(kn_ctx *ctx, void *user, const kn_slice *layer)
{
    (void)ctx;
    heap *h = user;
    assert_int_equal(layer->index, h->layers);
    h->nopen += layer->nopen, h->nloops += layer->nloops, h->gap = fmax(h->gap, layer->gap);
    for (size_t l = 0; l < layer->nloops; l++) {
        const kn_slice_loop *loop = &layer->loops[l];
        for (size_t i = 0; i + !loop->closed < loop->npoints; i++) {
            if (h->n == h->room) {
                h->room = 2 * h->room + 256;
                h->list = realloc(h->list, h->room * sizeof *h->list);
                assert_non_null(h->list);
            }
            segment *s = &h->list[h->n++];
            s->z = layer->z;
            memcpy(s->a, loop->points + 2 * i, sizeof s->a);
            memcpy(s->b, loop->points + 2 * ((i + 1) % loop->npoints), sizeof s->b);
            h->area[layer->index % 64] += 0.5 * (s->a[0] * s->b[1] - s->b[0] * s->a[1]);
        }
    }
    h->layers++;
    return KN_OK;
}

static int by_bytes(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(segment));
}

// A vase without ends, closed around: a cylinder about z.
static void vase(kn_ctx *ctx, kn_spline *out)
{
    const double base[3] = {0, 0, 0}, axis[3] = {0, 0, 6};
    assert_int_equal(kn_construct_cylinder(ctx, out, base, axis, 2.0), KN_OK);
}

static void same_as_all_at_once(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    kn_spline base = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    heap by_layer = {0}, at_once = {0};
    kn_slice_job_report report;
    vase(ctx, &base);
    assert_int_equal(kn_builtin_tile(ctx, &tile, "bump"), KN_OK);
    kn_job_options o = {.count = {8, 6}, .height = 0.2, .normal_tol = 1e-3, .max_degree = 40};
    assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_OK);
    kn_slice_options s = {.first = 0.111, .step = 0.6, .count = 10, .tol = 1e-3};
    const kn_job *jobs[] = {job};
    assert_int_equal(kn_slice_job(ctx, jobs, 1, &s, collect, &by_layer, &report), KN_OK);
    kn_sink sink;
    assert_int_equal(kn_slice_sink(ctx, &sink, &s, collect, &at_once), KN_OK);
    assert_int_equal(kn_job_run(ctx, job, &sink, 1), KN_OK);
    kn_sink_close(ctx, &sink);

    assert_int_equal(by_layer.layers, 10);
    assert_int_equal(at_once.layers, 10);
    assert_int_equal(by_layer.nloops, 10); // one around the vase in each
    assert_int_equal(by_layer.nopen, 0);
    assert_true(by_layer.gap <=
                1e-2); // what ends are joined over: the two sides of a seam agree to the normal's tolerance
    assert_int_equal(by_layer.n, at_once.n);
    qsort(by_layer.list, by_layer.n, sizeof(segment), by_bytes);
    qsort(at_once.list, at_once.n, sizeof(segment), by_bytes);
    assert_memory_equal(by_layer.list, at_once.list, by_layer.n * sizeof(segment));
    for (int k = 0; k < 10; k++) // between the bare vase and one that is thicker by the height all around
        assert_true(by_layer.area[k] > 3.14159 * 4.0 - 0.1 && by_layer.area[k] < 3.1416 * 2.2 * 2.2 + 0.1);
    free(by_layer.list), free(at_once.list);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &base);
    test_ctx_end(ctx, &memory);
}

// With many cells only those near a layer are composed.
static void only_cells_near(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline base = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    heap got = {0};
    kn_slice_job_report report;
    vase(ctx, &base);
    assert_int_equal(kn_builtin_tile(ctx, &tile, "knurl"), KN_OK);
    kn_job_options o = {.count = {60, 120}, .height = 0.05, .normal_tol = 1e-2, .max_degree = 40};
    assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_OK);
    kn_slice_options s = {.first = 3.01, .step = 1.0, .count = 1, .tol = 0.05};
    const kn_job *jobs[] = {job};
    assert_int_equal(kn_slice_job(ctx, jobs, 1, &s, collect, &got, &report), KN_OK);
    assert_int_equal(report.groups, 1);
    assert_true(report.cells >= 60 && report.cells <= 4 * 60); // the row that it cuts and its neighbours
    assert_int_equal(got.nloops, 1);
    assert_int_equal(got.nopen, 0);
    free(got.list);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &base);
    test_ctx_end(ctx, &memory);
}

static kn_status ignore(kn_ctx *ctx, void *user, const kn_slice *layer)
{
    (void)ctx, (void)user, (void)layer;
    return KN_OK;
}

static kn_status call(kn_ctx *ctx, void *user)
{
    kn_spline base = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    const double origin[3] = {0, 0, 0}, axis[3] = {0, 0, 1};
    kn_status status = kn_construct_cylinder(ctx, &base, origin, axis, 1.0);
    if (status == KN_OK) status = kn_builtin_tile(ctx, &tile, "knurl");
    kn_job_options o = {.count = {4, 1}, .height = 0.05, .normal_tol = 0.1, .max_degree = 40};
    if (status == KN_OK) status = kn_job_create(ctx, &job, &base, 1, &tile, &o);
    const kn_job *jobs[] = {job};
    if (status == KN_OK) status = kn_slice_job(ctx, jobs, 1, user, ignore, NULL, NULL);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &base);
    return status;
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_slice_options s = {.first = 0.5, .step = 1.0, .count = 1, .tol = 0.1}, bad = s;
    bad.step = 0;
    assert_int_equal(kn_slice_job(ctx, NULL, 0, &s, ignore, NULL, NULL), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(call(ctx, &bad), KN_EDOMAIN);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(same_as_all_at_once), cmocka_unit_test(only_cells_near),
                                       cmocka_unit_test(failures)};
    return cmocka_run_group_tests_name("slice/job", tests, NULL, NULL);
}
