// SPDX-License-Identifier: Apache-2.0
// The context: options, errors, callbacks, memory, counters, scratch.
#include "kernel/context.h"
#include "tests/support/support.h"

#include <string.h>

static void names(void **state)
{
    (void)state;
    assert_string_equal(kn_status_name(KN_OK), "KN_OK");
    assert_string_equal(kn_status_name(KN_ENOMEM), "KN_ENOMEM");
    assert_string_equal(kn_status_name(KN_EDOMAIN), "KN_EDOMAIN");
    assert_string_equal(kn_status_name(KN_ELIMIT), "KN_ELIMIT");
    assert_string_equal(kn_status_name(KN_EUNDEFINED), "KN_EUNDEFINED");
    assert_string_equal(kn_status_name(KN_EUNDECIDED), "KN_EUNDECIDED");
    assert_string_equal(kn_status_name(KN_EPARSE), "KN_EPARSE");
    assert_string_equal(kn_status_name(KN_EIO), "KN_EIO");
    assert_string_equal(kn_status_name(KN_ECANCELLED), "KN_ECANCELLED");
    assert_string_equal(kn_status_name(KN_ENOTBUILT), "KN_ENOTBUILT");
    assert_string_equal(kn_status_name((kn_status)(KN_ENOTBUILT + 1)), "KN_?");
    assert_string_equal(kn_version(), KN_VERSION_STRING);
}

static void options(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = NULL;
    kn_ctx_options o = kn_ctx_defaults();
    o.threads = -1;
    assert_int_equal(kn_ctx_create(&ctx, &o), KN_EDOMAIN);
    o = kn_ctx_defaults();
    o.allocator = test_allocator(&memory);
    o.allocator.release = NULL; // two of three
    assert_int_equal(kn_ctx_create(&ctx, &o), KN_EDOMAIN);
    o.allocator = test_allocator(&memory);
    memory.fail_at = 0;
    assert_int_equal(kn_ctx_create(&ctx, &o), KN_ENOMEM);
    assert_null(ctx);
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK); // malloc, and all processors
    assert_true(kn_ctx_threads(ctx) >= 1);
    void *block = kn_alloc(ctx, 10, 10);
    assert_non_null(block);
    block = kn_resize(ctx, block, 1000, 10);
    assert_non_null(block);
    kn_free(ctx, block);
    kn_ctx_destroy(ctx);
    kn_ctx_destroy(NULL);
}

static void errors(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 3);
    assert_int_equal(kn_ctx_threads(ctx), 3);
    assert_int_equal(kn_ctx_error(ctx), KN_OK);
    assert_string_equal(kn_ctx_message(ctx), "");
    assert_null(kn_ctx_error_file(ctx));
    assert_int_equal(kn_ctx_error_line(ctx), 0);
    int line = __LINE__ + 1;
    assert_int_equal(kn_fail(ctx, KN_EDOMAIN, "degree %d", 7), KN_EDOMAIN);
    assert_int_equal(kn_fail(ctx, KN_ELIMIT, "a later one"), KN_ELIMIT); // answered, not kept
    assert_int_equal(kn_ctx_error(ctx), KN_EDOMAIN);
    assert_string_equal(kn_ctx_message(ctx), "degree 7");
    assert_non_null(strstr(kn_ctx_error_file(ctx), "t_context.c"));
    assert_int_equal(kn_ctx_error_line(ctx), line);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_ctx_error(ctx), KN_OK);
    assert_string_equal(kn_ctx_message(ctx), "");
    assert_null(kn_ctx_error_file(ctx));
    char text[2000]; // longer than any buffer: cut, not overrun
    memset(text, 'x', sizeof text - 1);
    text[sizeof text - 1] = '\0';
    assert_int_equal(kn_fail(ctx, KN_EIO, "%s", text), KN_EIO);
    size_t kept = strlen(kn_ctx_message(ctx));
    assert_true(kept >= 200 && kept < sizeof text - 1);
    assert_int_equal(strncmp(kn_ctx_message(ctx), text, kept), 0);
    test_ctx_end(ctx, &memory);
}

typedef struct heard {
    int logs, reports, stop_at;
    kn_log_level level;
    char text[64];
    double fraction;
} heard;

static void on_log(void *user, kn_log_level level, const char *message)
{
    heard *h = user;
    h->logs++;
    h->level = level;
    strncpy(h->text, message, sizeof h->text - 1);
}

static int on_progress(void *user, const char *stage, double fraction)
{
    heard *h = user;
    assert_string_equal(stage, "cells");
    h->fraction = fraction;
    return ++h->reports == h->stop_at;
}

static void callbacks(void **state)
{
    (void)state;
    heard h = {.stop_at = 2};
    kn_ctx_options o = {.log = on_log, .progress = on_progress, .user = &h, .threads = 1};
    kn_ctx *ctx = NULL;
    assert_int_equal(kn_ctx_create(&ctx, &o), KN_OK);
    kn_log(ctx, KN_LOG_WARNING, "%d faces", 12);
    assert_int_equal(h.logs, 1);
    assert_int_equal(h.level, KN_LOG_WARNING);
    assert_string_equal(h.text, "12 faces");
    assert_int_equal(kn_progress(ctx, "cells", 0.25), KN_OK);
    assert_true(h.fraction == 0.25);
    assert_int_equal(kn_ctx_error(ctx), KN_OK);
    assert_int_equal(kn_progress(ctx, "cells", 0.5), KN_ECANCELLED);
    assert_int_equal(kn_ctx_error(ctx), KN_ECANCELLED);
    kn_ctx_destroy(ctx);
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK); // silent without callbacks
    kn_log(ctx, KN_LOG_INFO, "nobody listens");
    assert_int_equal(kn_progress(ctx, "cells", 1.0), KN_OK);
    kn_ctx_destroy(ctx);
}

static void blocks_are_counted(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double *a = kn_alloc(ctx, 100, sizeof *a);
    assert_non_null(a);
    for (int i = 0; i < 100; i++) a[i] = i;
    kn_counters c = kn_ctx_counters(ctx);
    assert_int_equal(c.live_blocks, 1);
    assert_int_equal(c.live_bytes, 800);
    a = kn_resize(ctx, a, 300, sizeof *a);
    assert_non_null(a);
    for (int i = 0; i < 100; i++) assert_true(a[i] == i);
    unsigned char *z = kn_alloc_zero(ctx, 50, 1);
    assert_non_null(z);
    for (int i = 0; i < 50; i++) assert_int_equal(z[i], 0);
    void *none = kn_alloc(ctx, 0, 8); // never NULL
    assert_non_null(none);
    c = kn_ctx_counters(ctx);
    assert_int_equal(c.live_blocks, 3);
    assert_int_equal(c.live_bytes, 2450);
    assert_int_equal(c.peak_bytes, 2450);
    assert_int_equal(c.allocations, 4);
    a = kn_resize(ctx, a, 10, sizeof *a);
    assert_int_equal(kn_ctx_counters(ctx).live_bytes, 130);
    for (int i = 0; i < 10; i++) assert_true(a[i] == i);
    void *grown = kn_resize(ctx, NULL, 2, 8);
    assert_non_null(grown);
    kn_free(ctx, a);
    kn_free(ctx, z);
    kn_free(ctx, none);
    kn_free(ctx, grown);
    kn_free(ctx, NULL);
    c = kn_ctx_counters(ctx);
    assert_int_equal(c.live_blocks, 0);
    assert_int_equal(c.live_bytes, 0);
    assert_int_equal(c.peak_bytes, 2450);
    test_ctx_end(ctx, &memory);
}

static void impossible_sizes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double *a = kn_alloc(ctx, 1, sizeof *a);
    assert_non_null(a);
    *a = 3.0;
    size_t calls = memory.calls;
    assert_null(kn_alloc(ctx, SIZE_MAX / 4, 8));
    assert_int_equal(kn_ctx_error(ctx), KN_ENOMEM);
    assert_null(kn_alloc(ctx, SIZE_MAX, 1));
    assert_null(kn_alloc_zero(ctx, SIZE_MAX, SIZE_MAX));
    assert_null(kn_resize(ctx, a, SIZE_MAX / 2, 2));
    assert_null(kn_scratch(ctx, SIZE_MAX, 1));
    assert_null(kn_scratch(ctx, SIZE_MAX / 8, 8));
    assert_int_equal(memory.calls, calls); // refused before the allocator is asked
    assert_true(*a == 3.0);
    kn_free(ctx, a);
    test_ctx_end(ctx, &memory);
}

// The same work again takes nothing from the allocator; blocks are aligned and do not overlap.
static void use_scratch(kn_ctx *ctx, int depth)
{
    kn_mark mark = kn_scratch_mark(ctx);
    unsigned char *block[20];
    size_t size[20];
    for (int i = 0; i < 20; i++) {
        size[i] = (size_t)(i * i * i * 7 % 5000) * (size_t)(depth + 1);
        block[i] = kn_scratch(ctx, size[i], 1);
        assert_non_null(block[i]);
        assert_int_equal((uintptr_t)block[i] % 64, 0);
        memset(block[i], i, size[i]);
    }
    if (depth > 0) use_scratch(ctx, depth - 1);
    for (int i = 0; i < 20; i++)
        for (size_t k = 0; k < size[i]; k++)
            if (block[i][k] != i) fail_msg("block %d overwritten at %zu", i, k);
    kn_scratch_release(ctx, mark);
}

static void scratch(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    use_scratch(ctx, 3);
    size_t allocations = kn_ctx_counters(ctx).allocations;
    assert_true(allocations > 0 && allocations < 12);
    for (int i = 0; i < 5; i++) use_scratch(ctx, i % 4);
    assert_int_equal(kn_ctx_counters(ctx).allocations, allocations);
    kn_mark mark = kn_scratch_mark(ctx); // after a release everything is there again, from the start
    void *first = kn_scratch(ctx, 8, 8);
    kn_scratch_release(ctx, mark);
    assert_ptr_equal(kn_scratch(ctx, 4, 8), first);
    kn_scratch_release(ctx, mark);
    test_ctx_end(ctx, &memory);
}

static kn_status take_scratch(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_mark mark = kn_scratch_mark(ctx);
    void *a = kn_scratch(ctx, 1000, 8);
    void *b = a ? kn_scratch(ctx, 100000, 8) : NULL; // a second piece of the arena
    void *c = b ? kn_alloc_zero(ctx, 10, 8) : NULL;
    void *d = c ? kn_resize(ctx, c, 1000, 8) : NULL;
    kn_free(ctx, d ? d : c); // after a failed resize the old block is still ours
    kn_scratch_release(ctx, mark);
    return d ? KN_OK : KN_ENOMEM;
}

static void out_of_memory(void **state)
{
    (void)state;
    test_allocation_failures(take_scratch, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(names),
                                       cmocka_unit_test(options),
                                       cmocka_unit_test(errors),
                                       cmocka_unit_test(callbacks),
                                       cmocka_unit_test(blocks_are_counted),
                                       cmocka_unit_test(impossible_sizes),
                                       cmocka_unit_test(scratch),
                                       cmocka_unit_test(out_of_memory)};
    return cmocka_run_group_tests_name("kernel/context", tests, NULL, NULL);
}
