// SPDX-License-Identifier: Apache-2.0
#include "tests/support/sink_world.h"

#include "kernel/parallel.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void sink_world_make(sink_world *w, sink_open open, const char *file, int threads)
{
    *w = (sink_world){.memory = TEST_MEMORY_INIT, .open = open, .report = test_report(SINK_PATCHES, 4, 3)};
    w->ctx = test_ctx(&w->memory, threads);
    test_rng rng = test_random(8);
    test_tile_make(&w->tile, 2);
    for (int i = 0; i < SINK_PATCHES; i++) {
        test_patch(w->ctx, &w->patch[i], &rng, 1 + i % 4, 3, i % 5 == 4, i, 0.1);
        w->patch[i].id = (kn_patch_id){.cell = {i, 2}, .part = i % 3 == 1, .patch = i};
        w->patch[i].look = i % 3 == 1;
    }
    test_tmp_path(w->path, file);
}

void sink_world_clear(sink_world *w)
{
    for (int i = 0; i < SINK_PATCHES; i++) kn_bezier_clear(w->ctx, &w->patch[i].bezier);
    remove(w->path);
    test_ctx_end(w->ctx, &w->memory);
}

void sink_world_cube(sink_world *w)
{
    static const int corner[6][4] = {{0, 1, 2, 3}, {4, 6, 5, 7}, {0, 4, 1, 5},
                                     {2, 3, 6, 7}, {0, 2, 4, 6}, {1, 5, 3, 7}}; // bit by bit
    for (int f = 0; f < 6; f++) {
        kn_bezier *b = &w->patch[f].bezier;
        kn_bezier_clear(w->ctx, b);
        assert_int_equal(kn_bezier_init(w->ctx, b, 2, 3, false, (int[]){1, 1}), KN_OK);
        for (int k = 0; k < 4; k++)
            for (int c = 0; c < 3; c++) b->coef[4 * c + k] = (corner[f][k] >> c & 1) ? 10.0 : 0.0;
        w->patch[f].look = w->patch[f].id.part = f == 5;
    }
}

char *sink_world_write(sink_world *w, const void *options, size_t n, size_t block)
{
    kn_sink sink;
    assert_int_equal(w->open(w->ctx, &sink, w->path, options), KN_OK);
    assert_int_equal(test_feed(w->ctx, &sink, &w->tile.tile, &w->report, w->patch, n, block), KN_OK);
    size_t bytes = 0;
    char *text = test_read_file(w->path, &bytes);
    assert_non_null(text);
    assert_int_equal(sink.bytes(sink.user), bytes);
    kn_sink_close(w->ctx, &sink);
    return text;
}

// ---- threads: the pipeline that jobs use ----
typedef struct feed {
    const kn_sink *sink;
    const kn_patch *patches;
} feed;

static kn_status pipe_work(kn_ctx *worker, void *user, size_t index, void **product)
{
    feed *f = user;
    kn_patch_block block = {index, 1, f->patches + index};
    return f->sink->work(worker, f->sink->user, &block, product);
}

static kn_status pipe_commit(kn_ctx *ctx, void *user, size_t index, void *product)
{
    feed *f = user;
    kn_patch_block block = {index, 1, f->patches + index};
    return f->sink->commit(ctx, f->sink->user, &block, product);
}

static void pipe_drop(kn_ctx *ctx, void *user, void *product)
{
    feed *f = user;
    f->sink->discard(ctx, f->sink->user, product);
}

void sink_world_equal_bytes(sink_open open, const char *file)
{
    sink_world w;
    sink_world_make(&w, open, file, 1);
    char *once = sink_world_write(&w, NULL, SINK_PATCHES, SINK_PATCHES);
    char *in_blocks = sink_world_write(&w, NULL, SINK_PATCHES, 5);
    assert_string_equal(once, in_blocks);
    free(in_blocks);
    sink_world_clear(&w);
    for (int threads = 1; threads <= 5; threads += 2) {
        sink_world_make(&w, open, file, threads);
        kn_sink sink;
        assert_int_equal(open(w.ctx, &sink, w.path, NULL), KN_OK);
        assert_int_equal(sink.begin(w.ctx, sink.user, &w.tile.tile, &w.report), KN_OK);
        feed f = {&sink, w.patch};
        kn_pipeline pipeline = {&f, pipe_work, pipe_commit, pipe_drop};
        assert_int_equal(kn_pipeline_run(w.ctx, &pipeline, SINK_PATCHES, 4, NULL), KN_OK);
        assert_int_equal(sink.end(w.ctx, sink.user), KN_OK);
        kn_sink_close(w.ctx, &sink);
        char *text = test_read_file(w.path, NULL);
        assert_non_null(text);
        assert_string_equal(text, once);
        free(text);
        sink_world_clear(&w);
    }
    free(once);
}

// ---- failures ----

void sink_world_expect_refused(sink_world *w, const kn_job_report *report, const kn_patch *patch, kn_status expected)
{
    kn_sink sink;
    char beside[TEST_PATH_BYTES + 32];
    assert_int_equal(w->open(w->ctx, &sink, w->path, NULL), KN_OK);
    assert_int_equal(test_feed(w->ctx, &sink, &w->tile.tile, report, patch, 1, 1), expected);
    assert_int_equal(kn_ctx_error(w->ctx), expected);
    kn_ctx_clear_error(w->ctx);
    kn_sink_close(w->ctx, &sink);
    assert_null(test_read_file(w->path, NULL));                      // nothing under that name
    snprintf(beside, sizeof beside, "%s.parameters.tmp-0", w->path); // of IGES
    assert_null(test_read_file(beside, NULL));
}

void sink_world_expect_refusals(sink_world *w)
{
    const kn_job_report report = test_report(1, 4, 3), small = test_report(1, 3, 3), none = test_report(0, 4, 3);
    kn_patch *patch = &w->patch[3];
    kn_sink sink;
    sink_world_expect_refused(w, &small, patch, KN_EDOMAIN); // degree 4 where 3 was announced
    sink_world_expect_refused(w, &none, patch, KN_EDOMAIN);
    patch->look = 2;
    sink_world_expect_refused(w, &report, patch, KN_EDOMAIN);
    patch->look = 0;
    double good = patch->bezier.coef[5];
    patch->bezier.coef[5] = NAN;
    sink_world_expect_refused(w, &report, patch, KN_EUNDEFINED);
    patch->bezier.coef[5] = -INFINITY;
    sink_world_expect_refused(w, &report, patch, KN_EUNDEFINED);
    patch->bezier.coef[5] = good;
    kn_bezier *rational = &w->patch[4].bezier;
    double *weight = &rational->coef[3 * kn_bezier_count(rational)], was = *weight;
    *weight = 0.0;
    sink_world_expect_refused(w, &report, &w->patch[4], KN_EUNDEFINED);
    *weight = was;
    assert_int_equal(w->open(w->ctx, &sink, "/nowhere/file", NULL), KN_EIO);
    kn_ctx_clear_error(w->ctx);
}

typedef struct starving {
    sink_world *w;
    const void *options;
} starving;

// Patches are made of memory that does not fail; the sink's does.
static kn_status feed_sink(kn_ctx *ctx, void *user)
{
    const starving *s = user;
    kn_sink sink;
    kn_status status = s->w->open(ctx, &sink, s->w->path, s->options);
    if (status != KN_OK) return status;
    status = test_feed(ctx, &sink, &s->w->tile.tile, &s->w->report, s->w->patch, SINK_PATCHES, 4);
    kn_sink_close(ctx, &sink);
    if (status != KN_OK) assert_null(test_read_file(s->w->path, NULL));
    return status;
}

void sink_world_starve(sink_world *w, const void *options)
{
    test_allocation_failures(feed_sink, &(starving){w, options});
}
