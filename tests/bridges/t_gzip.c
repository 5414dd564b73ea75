// SPDX-License-Identifier: Apache-2.0
// Compressed STEP files: what gzip and our own reader find in them, damaged ones, and bounds.
#include "tests/support/patches.h"

#include <knurl/step.h>

#if KN_WITH_ZLIB
#include "bridges/zlib/gzip.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATCHES = 40 };

typedef struct world {
    test_memory memory;
    kn_ctx *ctx;
    test_tile tile;
    kn_patch patch[PATCHES];
    char path[TEST_PATH_BYTES], packed[TEST_PATH_BYTES], out[TEST_PATH_BYTES];
} world;

static void world_make(world *w)
{
    *w = (world){.memory = TEST_MEMORY_INIT};
    w->ctx = test_ctx(&w->memory, 1);
    test_rng rng = test_random(8);
    test_tile_make(&w->tile, 1);
    for (int i = 0; i < PATCHES; i++) test_patch(w->ctx, &w->patch[i], &rng, 9, 9, false, i, 0.1);
    test_tmp_path(w->path, "plain.step");
    test_tmp_path(w->packed, "packed.stpz");
    test_tmp_path(w->out, "again.step");
}

static void world_clear(world *w)
{
    for (int i = 0; i < PATCHES; i++) kn_bezier_clear(w->ctx, &w->patch[i].bezier);
    remove(w->path), remove(w->packed), remove(w->out);
    test_ctx_end(w->ctx, &w->memory);
}

static kn_status write_file(kn_ctx *ctx, const world *w, const char *path, const kn_filter *filter, size_t *bytes)
{
    kn_sink sink;
    kn_job_report report = test_report(PATCHES, 9, 9);
    kn_status status = kn_step_sink(ctx, &sink, path, &(kn_step_options){.filter = filter});
    if (status != KN_OK) return status;
    status = test_feed(ctx, &sink, &w->tile.tile, &report, w->patch, PATCHES, 8);
    *bytes = sink.bytes(sink.user);
    kn_sink_close(ctx, &sink);
    return status;
}

static void there_and_back(void **state)
{
    (void)state;
    world w;
    world_make(&w);
    size_t plain = 0, packed = 0, bytes = 0, again = 0;
    char command[2 * TEST_PATH_BYTES];
    assert_int_equal(write_file(w.ctx, &w, w.path, NULL, &plain), KN_OK);
    for (int level = 0; level < 10; level += 9) {
        kn_filter filter = kn_gzip_filter(level);
        assert_int_equal(write_file(w.ctx, &w, w.packed, &filter, &packed), KN_OK);
        char *text = test_read_file(w.packed, &bytes);
        assert_non_null(text);
        assert_int_equal(bytes, packed); // what the sink says is what the file has
        assert_true(packed < 2 * plain / 3);
        assert_true(kn_gzip_is(w.packed) && !kn_gzip_is(w.path));
        snprintf(command, sizeof command, "gzip -t -S .stpz '%.480s'", w.packed);
        assert_int_equal(system(command), 0);
        assert_int_equal(kn_gunzip_file(w.ctx, w.out, w.packed, plain), KN_OK);
        char *one = test_read_file(w.path, NULL), *two = test_read_file(w.out, &again);
        assert_int_equal(again, plain);
        assert_string_equal(one, two);
        free(text), free(one), free(two);
    }
    world_clear(&w);
}

static void damage(void **state)
{
    (void)state;
    world w;
    world_make(&w);
    size_t plain = 0, packed = 0, bytes = 0;
    kn_filter filter = kn_gzip_filter(1);
    assert_int_equal(write_file(w.ctx, &w, w.packed, &filter, &plain), KN_OK);
    char *text = test_read_file(w.packed, &packed);
    assert_non_null(text);
    assert_int_equal(kn_gunzip_file(w.ctx, w.out, "/nowhere/x.stpz", 1 << 20), KN_EIO);
    kn_ctx_clear_error(w.ctx);
    assert_int_equal(kn_gunzip_file(w.ctx, w.out, w.packed, 1000), KN_ELIMIT); // a bomb is one byte too many
    kn_ctx_clear_error(w.ctx);
    static const size_t cuts[] = {0, 1, 9, 10, 1000};
    for (size_t i = 0; i < sizeof cuts / sizeof *cuts; i++) {
        test_write_file(w.packed, text, cuts[i]);
        assert_int_equal(kn_gunzip_file(w.ctx, w.out, w.packed, SIZE_MAX), KN_EPARSE);
        assert_non_null(strstr(kn_ctx_message(w.ctx), "packed.stpz"));
        kn_ctx_clear_error(w.ctx);
        assert_null(test_read_file(w.out, NULL));
    }
    text[packed - 6] ^= 1; // the check sum
    test_write_file(w.packed, text, packed);
    assert_int_equal(kn_gunzip_file(w.ctx, w.out, w.packed, SIZE_MAX), KN_EPARSE);
    kn_ctx_clear_error(w.ctx);
    text[packed - 6] ^= 1;
    char *twice = malloc(2 * packed); // two members are one file
    assert_non_null(twice);
    memcpy(twice, text, packed), memcpy(twice + packed, text, packed);
    test_write_file(w.packed, twice, 2 * packed);
    assert_int_equal(kn_gunzip_file(w.ctx, w.out, w.packed, SIZE_MAX), KN_OK);
    free(test_read_file(w.out, &bytes));
    free(twice);
    test_write_file(w.packed, text, packed);
    assert_int_equal(kn_gunzip_file(w.ctx, w.out, w.packed, bytes / 2), KN_OK);
    assert_int_equal(kn_gunzip_file(w.ctx, w.out, w.packed, bytes / 2 - 1), KN_ELIMIT);
    free(text);
    world_clear(&w);
}

// It cannot be gone on with, and says so.
static void no_journal(void **state)
{
    (void)state;
    world w;
    world_make(&w);
    kn_sink sink;
    kn_filter filter = kn_gzip_filter(0);
    kn_job_report report = test_report(PATCHES, 9, 9);
    unsigned char *data = NULL;
    size_t bytes = 0;
    assert_int_equal(kn_step_sink(w.ctx, &sink, w.packed, &(kn_step_options){.filter = &filter}), KN_OK);
    assert_int_equal(sink.begin(w.ctx, sink.user, &w.tile.tile, &report), KN_OK);
    assert_int_equal(sink.save(w.ctx, sink.user, &data, &bytes), KN_EDOMAIN);
    kn_sink_close(w.ctx, &sink);
    assert_null(test_read_file(w.packed, NULL));
    world_clear(&w);
}

static kn_status pack_and_unpack(kn_ctx *ctx, void *user)
{
    const world *w = user;
    size_t bytes;
    kn_filter filter = kn_gzip_filter(1);
    kn_status status = write_file(ctx, w, w->packed, &filter, &bytes);
    return status == KN_OK ? kn_gunzip_file(ctx, w->out, w->packed, SIZE_MAX) : status;
}

static void without_memory(void **state)
{
    (void)state;
    world w;
    world_make(&w);
    test_allocation_failures(pack_and_unpack, &w);
    world_clear(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(there_and_back),
        cmocka_unit_test(damage),
        cmocka_unit_test(no_journal),
        cmocka_unit_test(without_memory),
    };
    return cmocka_run_group_tests_name("bridges/gzip", tests, NULL, NULL);
}
#else
static void without_zlib(void **state)
{
    (void)state;
    skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(without_zlib)};
    return cmocka_run_group_tests_name("bridges/gzip", tests, NULL, NULL);
}
#endif
