// SPDX-License-Identifier: Apache-2.0
// What the tests of writers share.
#include "tests/write/world.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void world_make(world *w, const char *name)
{
    *w = (world){.memory = TEST_MEMORY_INIT, .report = test_report(PATCHES, 4, 4)};
    w->ctx = test_ctx(&w->memory, 1);
    test_rng rng = test_random(41);
    test_tile_make(&w->tile, 3);
    for (int i = 0; i < 4; i++) {
        test_patch(w->ctx, &w->patch[i], &rng, 3, 2, i >= 2, i, 0.1);
        w->patch[i].reversed = i % 2;
    }
    const int degree[3] = {3, 2, 1}, count[3] = {6, 4, 3};
    for (int i = 4; i < PATCHES; i++) {
        int nvars = i == 4 ? 1 : i == 5 ? 2 : 3;
        bool rational = i % 2 == 0;
        test_random_spline(w->ctx, &w->spline[i], &rng, nvars, 3 + rational, rational, degree, count, 9);
        size_t n = kn_spline_count(&w->spline[i]);
        for (size_t k = 0; k < 3 * n; k++) w->spline[i].coef[k] /= 3.0; // not a number of a few digits
        w->patch[i] = (kn_patch){.spline = &w->spline[i], .reversed = i == 7, .segments = {2, 2, 2}};
    }
    for (int i = 0; i < PATCHES; i++) {
        w->patch[i].look = w->patch[i].id.part = i % 3;
        w->patch[i].id.patch = i;
    }
    test_tmp_path(w->path, name);
}

void world_clear(world *w)
{
    for (int i = 0; i < 4; i++) kn_bezier_clear(w->ctx, &w->patch[i].bezier);
    for (int i = 4; i < PATCHES; i++) kn_spline_clear(w->ctx, &w->spline[i]);
    remove(w->path);
    test_ctx_end(w->ctx, &w->memory);
}

char *world_write(world *w, make_sink make, int first, int count, size_t block, size_t *bytes)
{
    kn_sink sink = {0};
    assert_int_equal(make(w->ctx, &sink, w->path), KN_OK);
    if (test_feed(w->ctx, &sink, &w->tile.tile, &w->report, w->patch + first, (size_t)count, block) != KN_OK)
        fail_msg("%s", kn_ctx_message(w->ctx));
    size_t told = sink.bytes(sink.user), there = 0;
    kn_sink_close(w->ctx, &sink);
    char *text = test_read_file(w->path, &there);
    assert_non_null(text);
    assert_true(told >= there); // an OBJ has its materials besides
    if (bytes) *bytes = there;
    return text;
}

void world_refused(world *w, make_sink make, int first, int count, const char *why)
{
    kn_sink sink = {0};
    kn_ctx_clear_error(w->ctx);
    remove(w->path);
    assert_int_equal(make(w->ctx, &sink, w->path), KN_OK);
    assert_int_equal(test_feed(w->ctx, &sink, &w->tile.tile, &w->report, w->patch + first, (size_t)count, 2),
                     KN_EDOMAIN);
    if (!strstr(kn_ctx_message(w->ctx), why)) fail_msg("%s", kn_ctx_message(w->ctx));
    kn_sink_close(w->ctx, &sink);
    assert_null(test_read_file(w->path, NULL));
    kn_ctx_clear_error(w->ctx);
}

typedef struct trial {
    world *w;
    make_sink make;
    int first, count;
} trial;

static kn_status feed_sink(kn_ctx *ctx, void *user)
{
    trial *t = user;
    kn_sink sink = {0};
    kn_status status = t->make(ctx, &sink, t->w->path);
    if (status != KN_OK) return status;
    status = test_feed(ctx, &sink, &t->w->tile.tile, &t->w->report, t->w->patch + t->first, (size_t)t->count, 3);
    kn_sink_close(ctx, &sink);
    if (status != KN_OK) assert_null(test_read_file(t->w->path, NULL));
    remove(t->w->path);
    return status;
}

void world_without_memory(world *w, make_sink make, int first, int count)
{
    remove(w->path);
    test_allocation_failures(feed_sink, &(trial){w, make, first, count});
}

void world_spline(world *w, kn_spline *out, int patch)
{
    static const int order[3] = {1, 0, 2};
    kn_spline s = kn_patch_spline(&w->patch[patch]);
    *out = (kn_spline){0};
    if (w->patch[patch].reversed && s.nvars > 1)
        assert_int_equal(kn_spline_permute(w->ctx, out, &s, order), KN_OK);
    else
        assert_int_equal(kn_spline_copy(w->ctx, out, &s), KN_OK);
}

void world_make_trim(world *w, kn_trim *out)
{
    static const double points[3][6] = {{0, 1, 0, 0}, {1, 0.5, 0, 0, 0.75, 1}, {0, 0, 1, 0}};
    static const double line[4] = {0, 0, 1, 1}, arc[6] = {0, 0, 0, 1, 1, 1};
    static int ends[1] = {3};
    kn_spline curves[3] = {{0}};
    for (int i = 0; i < 3; i++) {
        const double *knots[1] = {i == 1 ? arc : line};
        int degree = i == 1 ? 2 : 1, count = degree + 1;
        assert_int_equal(kn_spline_init(w->ctx, &curves[i], 1, 2, false, &degree, &count, knots, points[i]), KN_OK);
    }
    const kn_trim trim = {.curves = curves, .ncurves = 3, .loop_end = ends, .nloops = 1};
    *out = (kn_trim){0};
    assert_int_equal(kn_trim_copy(w->ctx, out, &trim), KN_OK);
    assert_int_equal(kn_trim_check(w->ctx, out), KN_OK);
    for (int i = 0; i < 3; i++) kn_spline_clear(w->ctx, &curves[i]);
}
