// SPDX-License-Identifier: Apache-2.0
// Contexts that count and fail.
#include "tests/support/support.h"

#include <stdlib.h>

static bool fails(test_memory *memory)
{
    size_t call = atomic_fetch_add(&memory->calls, 1);
    if (call == memory->fail_at) atomic_store(&memory->failed, true);
    return call == memory->fail_at;
}

static void *allocate(void *user, size_t bytes)
{
    test_memory *memory = user;
    void *block = fails(memory) ? NULL : malloc(bytes ? bytes : 1);
    if (block) atomic_fetch_add(&memory->live, 1);
    return block;
}

static void *resize(void *user, void *block, size_t bytes)
{
    assert_non_null(block);
    return fails(user) ? NULL : realloc(block, bytes ? bytes : 1);
}

static void release(void *user, void *block)
{
    test_memory *memory = user;
    if (block) atomic_fetch_sub(&memory->live, 1);
    free(block);
}

kn_allocator test_allocator(test_memory *memory)
{
    return (kn_allocator){.allocate = allocate, .resize = resize, .release = release, .user = memory};
}

kn_ctx *test_ctx(test_memory *memory, int threads)
{
    kn_ctx *ctx = NULL;
    kn_ctx_options options = kn_ctx_defaults();
    options.allocator = test_allocator(memory);
    options.threads = threads;
    assert_int_equal(kn_ctx_create(&ctx, &options), KN_OK);
    assert_non_null(ctx);
    return ctx;
}

void test_ctx_end(kn_ctx *ctx, test_memory *memory)
{
    kn_ctx_destroy(ctx);
    size_t left = atomic_load(&memory->live);
    if (left) fail_msg("%zu blocks were never released", left);
}

// One run with allocation k failing; false when the call never got that far.
static bool fail_once(test_call call, void *user, size_t k)
{
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    memory.fail_at = atomic_load(&memory.calls) + k;
    kn_status status = call(ctx, user);
    bool failed = atomic_load(&memory.failed);
    kn_status expected = failed ? KN_ENOMEM : KN_OK, recorded = kn_ctx_error(ctx);
    if (status != expected)
        fail_msg("allocation %zu %s: %s (\"%s\"), not %s", k, failed ? "failed" : "was not reached",
                 kn_status_name(status), kn_ctx_message(ctx), kn_status_name(expected));
    if (recorded != expected)
        fail_msg("allocation %zu: the context holds %s, not %s", k, kn_status_name(recorded),
                 kn_status_name(expected));
    kn_ctx_destroy(ctx);
    size_t left = atomic_load(&memory.live);
    if (left)
        fail_msg("allocation %zu %s: %zu blocks were never released", k, failed ? "failed" : "not reached", left);
    return failed;
}

void test_allocation_failures(test_call call, void *user)
{
    size_t k = 0;
    while (fail_once(call, user, k)) {
        k++;
        if (k > 100000) fail_msg("still failing after %zu allocations", k);
    }
    if (k == 0) fail_msg("the call allocates nothing, so that nothing was tested");
}
