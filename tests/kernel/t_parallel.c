// SPDX-License-Identifier: Apache-2.0
// Threads: the same results and the same errors for every number of them.
#include "kernel/context.h"
#include "kernel/parallel.h"
#include "tests/support/support.h"

#include <pthread.h>
#include <string.h>
#include <time.h>

enum { MANY = 300 };

typedef struct job {
    double result[MANY];
    atomic_int runs[MANY];
    size_t fail_from; // this index and all above fail
    atomic_size_t started;
} job;

// Some work that takes scratch and depends on the index alone.
static kn_status task(kn_ctx *worker, void *user, size_t index)
{
    job *j = user;
    atomic_fetch_add(&j->started, 1);
    if (kn_ctx_threads(worker) != 1) return kn_fail(worker, KN_EDOMAIN, "a worker with threads of its own");
    if (index >= j->fail_from) return kn_fail(worker, KN_EUNDEFINED, "index %zu", index);
    kn_mark mark = kn_scratch_mark(worker);
    size_t n = index % 17 * 50 + 1;
    double *work = kn_scratch(worker, n, sizeof *work), sum = 0.0;
    if (!work) return KN_ENOMEM;
    for (size_t i = 0; i < n; i++) work[i] = 1.0 / (double)(index + i + 1);
    for (size_t i = 0; i < n; i++) sum += work[i];
    j->result[index] = sum;
    atomic_fetch_add(&j->runs[index], 1);
    kn_scratch_release(worker, mark);
    return KN_OK;
}

static void every_index_once(void **state)
{
    (void)state;
    static job one, many;
    for (int threads = 1; threads <= 8; threads *= 2) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, threads);
        memset(&many, 0, sizeof many);
        many.fail_from = SIZE_MAX;
        assert_int_equal(kn_parallel(ctx, MANY, task, &many, "test"), KN_OK);
        for (int i = 0; i < MANY; i++) assert_int_equal(many.runs[i], 1);
        if (threads == 1) memcpy(one.result, many.result, sizeof one.result);
        assert_memory_equal(one.result, many.result, sizeof one.result);
        assert_int_equal(kn_ctx_counters(ctx).live_blocks, 0);
        assert_int_equal(kn_ctx_counters(ctx).live_bytes, 0);
        assert_int_equal(kn_parallel(ctx, 0, task, &many, NULL), KN_OK);
        assert_int_equal(kn_parallel(ctx, 1, task, &many, NULL), KN_OK); // fewer indices than threads
        test_ctx_end(ctx, &memory);
    }
}

static void lowest_error(void **state)
{
    (void)state;
    static job j;
    for (int repeat = test_scale(10); repeat > 0; repeat--)
        for (int threads = 1; threads <= 4; threads *= 2) {
            test_memory memory = TEST_MEMORY_INIT;
            kn_ctx *ctx = test_ctx(&memory, threads);
            memset(&j, 0, sizeof j);
            j.fail_from = 37;
            assert_int_equal(kn_parallel(ctx, MANY, task, &j, NULL), KN_EUNDEFINED);
            assert_int_equal(kn_ctx_error(ctx), KN_EUNDEFINED);
            assert_string_equal(kn_ctx_message(ctx), "index 37");
            assert_non_null(strstr(kn_ctx_error_file(ctx), "t_parallel.c"));
            assert_true(kn_ctx_error_line(ctx) > 0);
            for (int i = 0; i < 37; i++) assert_int_equal(j.runs[i], 1);
            assert_true(j.started <= 37 + (size_t)threads); // no new index after a failure
            assert_int_equal(kn_ctx_counters(ctx).live_blocks, 0);
            test_ctx_end(ctx, &memory);
        }
}

// A task that fails without saying why still leaves its status.
static kn_status mute(kn_ctx *worker, void *user, size_t index)
{
    (void)worker;
    (void)user;
    return index == 3 ? KN_EUNDECIDED : KN_OK;
}

// A task that recovers: what it recorded belongs to no failure.
static kn_status recovers(kn_ctx *worker, void *user, size_t index)
{
    (void)user;
    if (index < 3) (void)kn_fail(worker, KN_EIO, "recovered from");
    return index == 3 ? kn_fail(worker, KN_EDOMAIN, "the real one") : KN_OK;
}

static void errors_belong_to_their_index(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    assert_int_equal(kn_parallel(ctx, 5, mute, NULL, NULL), KN_EUNDECIDED);
    assert_int_equal(kn_ctx_error(ctx), KN_EUNDECIDED);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_parallel(ctx, 5, recovers, NULL, NULL), KN_EDOMAIN);
    assert_string_equal(kn_ctx_message(ctx), "the real one");
    test_ctx_end(ctx, &memory);
}

typedef struct watcher {
    int calls, stop_at;
    double last;
} watcher;

static int watch(void *user, const char *stage, double fraction)
{
    watcher *w = user;
    assert_string_equal(stage, "cells");
    assert_true(fraction > 0.0 && fraction <= 1.0 && fraction >= w->last);
    w->last = fraction;
    return ++w->calls == w->stop_at;
}

static kn_ctx *watched(test_memory *memory, watcher *w, int threads)
{
    kn_ctx_options o = {.allocator = test_allocator(memory), .progress = watch, .user = w, .threads = threads};
    kn_ctx *ctx = NULL;
    assert_int_equal(kn_ctx_create(&ctx, &o), KN_OK);
    return ctx;
}

static void cancelling(void **state)
{
    (void)state;
    static job j;
    for (int threads = 1; threads <= 4; threads *= 2) {
        test_memory memory = TEST_MEMORY_INIT;
        watcher w = {.stop_at = 1};
        kn_ctx *ctx = watched(&memory, &w, threads);
        memset(&j, 0, sizeof j);
        j.fail_from = SIZE_MAX;
        kn_status status = kn_parallel(ctx, MANY, task, &j, "cells");
        // With several threads the others may have done all before the calling one had its first turn.
        assert_int_equal(status, w.calls ? KN_ECANCELLED : KN_OK);
        assert_int_equal(kn_ctx_error(ctx), status);
        if (threads == 1) assert_int_equal(j.started, 1);
        test_ctx_end(ctx, &memory);
    }
    test_memory memory = TEST_MEMORY_INIT;
    watcher w = {0};
    kn_ctx *ctx = watched(&memory, &w, 1);
    assert_int_equal(kn_parallel(ctx, MANY, task, &j, "cells"), KN_OK);
    assert_int_equal(w.calls, MANY);
    assert_true(w.last == 1.0);
    test_ctx_end(ctx, &memory);
}

// ---- pipeline ----
typedef struct flow {
    size_t committed[MANY], ncommitted;
    atomic_size_t live, most, dropped;
    size_t fail_work, fail_commit;
} flow;

static kn_status make(kn_ctx *worker, void *user, size_t index, void **product)
{
    flow *f = user;
    if (index >= f->fail_work) return kn_fail(worker, KN_EUNDEFINED, "work %zu", index);
    size_t *p = kn_alloc(worker, 1, sizeof *p);
    if (!p) return KN_ENOMEM;
    *p = index * index;
    *product = p;
    size_t live = atomic_fetch_add(&f->live, 1) + 1, most = atomic_load(&f->most);
    while (most < live && !atomic_compare_exchange_weak(&f->most, &most, live)) {
    }
    return KN_OK;
}

static kn_status keep(kn_ctx *ctx, void *user, size_t index, void *product)
{
    flow *f = user;
    size_t value = *(size_t *)product;
    atomic_fetch_sub(&f->live, 1);
    kn_free(ctx, product); // consumed, also when the commit fails
    if (index == f->fail_commit) return kn_fail(ctx, KN_EIO, "commit %zu", index);
    assert_int_equal(value, index * index);
    f->committed[f->ncommitted++] = index;
    return KN_OK;
}

static void discard(kn_ctx *ctx, void *user, void *product)
{
    flow *f = user;
    atomic_fetch_sub(&f->live, 1);
    atomic_fetch_add(&f->dropped, 1);
    kn_free(ctx, product);
}

static kn_pipeline pipeline_of(flow *f)
{
    memset(f, 0, sizeof *f);
    f->fail_work = f->fail_commit = SIZE_MAX;
    return (kn_pipeline){.user = f, .work = make, .commit = keep, .drop = discard};
}

static void commits_in_order(void **state)
{
    (void)state;
    static flow f;
    static const size_t aheads[] = {0, 1, 2, 5, MANY + 7};
    for (int threads = 1; threads <= 4; threads *= 2)
        for (size_t a = 0; a < 5; a++) {
            test_memory memory = TEST_MEMORY_INIT;
            watcher w = {0};
            kn_ctx *ctx = watched(&memory, &w, threads);
            kn_pipeline p = pipeline_of(&f);
            assert_int_equal(kn_pipeline_run(ctx, &p, MANY, aheads[a], "cells"), KN_OK);
            assert_int_equal(f.ncommitted, MANY);
            for (size_t i = 0; i < MANY; i++) assert_int_equal(f.committed[i], i);
            assert_true(f.most <= (aheads[a] ? aheads[a] : 1));
            assert_int_equal(f.dropped, 0);
            assert_int_equal(w.calls, MANY);
            assert_int_equal(kn_pipeline_run(ctx, &p, 0, 1, NULL), KN_OK);
            assert_int_equal(kn_ctx_counters(ctx).live_blocks, 0);
            test_ctx_end(ctx, &memory);
        }
}

// Whatever the number of threads: all below the failing index is committed, nothing from there on, and all that was
// made is dropped.
static void pipeline_failures(void **state)
{
    (void)state;
    static flow f;
    for (int repeat = test_scale(5); repeat > 0; repeat--)
        for (int threads = 1; threads <= 4; threads *= 2)
            for (int which = 0; which < 3; which++) {
                test_memory memory = TEST_MEMORY_INIT;
                watcher w = {.stop_at = which == 2 ? 41 : 0};
                kn_ctx *ctx = watched(&memory, &w, threads);
                kn_pipeline p = pipeline_of(&f);
                if (which == 0) f.fail_work = 41;
                if (which == 1) f.fail_commit = 41;
                static const kn_status expected[3] = {KN_EUNDEFINED, KN_EIO, KN_ECANCELLED};
                assert_int_equal(kn_pipeline_run(ctx, &p, MANY, 6, "cells"), expected[which]);
                assert_int_equal(kn_ctx_error(ctx), expected[which]);
                if (which == 0) assert_string_equal(kn_ctx_message(ctx), "work 41");
                if (which == 1) assert_string_equal(kn_ctx_message(ctx), "commit 41");
                assert_int_equal(f.ncommitted, 41);
                assert_int_equal(f.live, 0);
                assert_int_equal(kn_ctx_counters(ctx).live_blocks, 0);
                test_ctx_end(ctx, &memory);
            }
}

// ---- what happens when threads do meet: made to happen, by indices that wait for each other ----
static void pause_ms(int ms)
{
    struct timespec t = {.tv_nsec = 1000000L * ms};
    (void)nanosleep(&t, NULL);
}

// Not for ever: where the system gives no second thread the test fails rather than hangs.
static void wait_for(atomic_bool *flag)
{
    for (int i = 0; i < 5000 && !atomic_load(flag); i++) pause_ms(1);
}

typedef struct meeting {
    atomic_bool started[2], finished;
    pthread_t caller;
    bool fail_first;
    size_t committed, dropped;
} meeting;

// Index 1 fails at once, index 0 after it: 0 is reported.
static kn_status late_failure(kn_ctx *worker, void *user, size_t index)
{
    meeting *m = user;
    if (index == 1) m->started[1] = true;
    if (index == 0) wait_for(&m->started[1]);
    return kn_fail(worker, KN_EDOMAIN, "index %zu", index);
}

static void lowest_error_though_later(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    meeting m = {0};
    assert_int_equal(kn_parallel(ctx, 2, late_failure, &m, NULL), KN_EDOMAIN);
    assert_string_equal(kn_ctx_message(ctx), "index 0");
    test_ctx_end(ctx, &memory);
}

// Index 0 waits until another thread has index 1. Threads other than the calling one are slow, so that it must wait
// for them; and there are more of them than there is room for products, so that they wait too.
static kn_status slow_make(kn_ctx *worker, void *user, size_t index, void **product)
{
    meeting *m = user;
    *product = m;
    if (index < 2) m->started[index] = true;
    if (index == 0) wait_for(&m->started[1]);
    if (index == 0 && m->fail_first) wait_for(&m->finished);
    if (index == 0 && m->fail_first) return kn_fail(worker, KN_EDOMAIN, "index 0");
    if (!pthread_equal(pthread_self(), m->caller)) pause_ms(2);
    if (index == 1) m->finished = true;
    return KN_OK;
}

static kn_status count_commit(kn_ctx *ctx, void *user, size_t index, void *product)
{
    meeting *m = user;
    (void)ctx;
    assert_ptr_equal(product, m);
    assert_int_equal(index, m->committed);
    m->committed++;
    return KN_OK;
}

static void count_drop(kn_ctx *ctx, void *user, void *product)
{
    meeting *m = user;
    (void)ctx;
    assert_ptr_equal(product, m);
    m->dropped++;
}

static void threads_wait_for_each_other(void **state)
{
    (void)state;
    for (int fail_first = 0; fail_first < 2; fail_first++) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 3);
        meeting m = {.caller = pthread_self(), .fail_first = fail_first != 0};
        kn_pipeline p = {.user = &m, .work = slow_make, .commit = count_commit, .drop = count_drop};
        kn_status status = kn_pipeline_run(ctx, &p, 12, 3 - (size_t)fail_first, NULL);
        assert_int_equal(status, fail_first ? KN_EDOMAIN : KN_OK);
        assert_int_equal(m.committed, fail_first ? 0 : 12);
        assert_int_equal(m.dropped, fail_first ? 1 : 0); // index 1 was made, and had no room beyond it
        test_ctx_end(ctx, &memory);
    }
}

static kn_status call_parallel(kn_ctx *ctx, void *user)
{
    memset(user, 0, sizeof(job));
    ((job *)user)->fail_from = SIZE_MAX;
    return kn_parallel(ctx, 4, task, user, NULL);
}

static kn_status call_pipeline(kn_ctx *ctx, void *user)
{
    kn_pipeline p = pipeline_of(user);
    return kn_pipeline_run(ctx, &p, 4, 2, NULL);
}

static void out_of_memory(void **state)
{
    (void)state;
    static job j;
    static flow f;
    test_allocation_failures(call_parallel, &j);
    test_allocation_failures(call_pipeline, &f);
    assert_int_equal(f.ncommitted, 4);
}

// With four threads: no context of a thread, no mutex and no product is left when memory runs out anywhere.
static void out_of_memory_in_threads(void **state)
{
    (void)state;
    static flow f;
    bool failed = true;
    for (size_t k = 0; failed; k++) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 4);
        memory.fail_at = memory.calls + k;
        kn_pipeline p = pipeline_of(&f);
        kn_status status = kn_pipeline_run(ctx, &p, 8, 4, NULL);
        failed = memory.failed;
        assert_int_equal(status, failed ? KN_ENOMEM : KN_OK);
        assert_int_equal(f.live, 0);
        test_ctx_end(ctx, &memory);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_index_once),
                                       cmocka_unit_test(lowest_error),
                                       cmocka_unit_test(errors_belong_to_their_index),
                                       cmocka_unit_test(cancelling),
                                       cmocka_unit_test(commits_in_order),
                                       cmocka_unit_test(pipeline_failures),
                                       cmocka_unit_test(lowest_error_though_later),
                                       cmocka_unit_test(threads_wait_for_each_other),
                                       cmocka_unit_test(out_of_memory),
                                       cmocka_unit_test(out_of_memory_in_threads)};
    return cmocka_run_group_tests_name("kernel/parallel", tests, NULL, NULL);
}
