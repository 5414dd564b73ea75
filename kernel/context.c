// SPDX-License-Identifier: Apache-2.0
// The context: allocator, counters, the first error, log and progress, scratch memory.
#include "kernel/context.h"
#include "kernel/worker.h"

#include <stdalign.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// What a worker shares with the context it works for. Atomic, because blocks move between threads: what one
// worker allocates another may free.
typedef struct counts {
    atomic_size_t live_blocks, live_bytes, peak_bytes, allocations;
} counts;

// Before each block: its size, in as much room as keeps the block aligned for any type.
typedef union header {
    size_t bytes;
    max_align_t align;
} header;

enum { SCRATCH_ALIGN = 64, SCRATCH_FIRST = 1 << 14, MESSAGE_SIZE = 512 };

// A piece of the arena. Pieces form a list in the order of use; those after the current one are empty.
typedef struct chunk {
    struct chunk *next;
    size_t size, used; // bytes from base
    unsigned char *base;
} chunk;

struct kn_ctx {
    kn_ctx_options options;
    counts *counts; // &own, or the parent's
    counts own;
    chunk *first, *current;
    size_t scratch_size;
    kn_status status;
    const char *file;
    int line;
    char message[MESSAGE_SIZE];
};

// ---- creation ----
static void *default_allocate(void *user, size_t bytes)
{
    (void)user;
    return malloc(bytes);
}

static void *default_resize(void *user, void *block, size_t bytes)
{
    (void)user;
    return realloc(block, bytes);
}

static void default_release(void *user, void *block)
{
    (void)user;
    free(block);
}

kn_ctx_options kn_ctx_defaults(void)
{
    return (kn_ctx_options){0};
}

static kn_ctx *make_context(const kn_ctx_options *options)
{
    kn_ctx *ctx = options->allocator.allocate(options->allocator.user, sizeof *ctx);
    if (!ctx) return NULL;
    memset(ctx, 0, sizeof *ctx);
    ctx->options = *options;
    ctx->counts = &ctx->own;
    return ctx;
}

kn_status kn_ctx_create(kn_ctx **out, const kn_ctx_options *options)
{
    kn_ctx_options o = options ? *options : kn_ctx_defaults();
    int given = (o.allocator.allocate != NULL) + (o.allocator.resize != NULL) + (o.allocator.release != NULL);
    if ((given != 0 && given != 3) || o.threads < 0) return KN_EDOMAIN;
    if (given == 0) o.allocator = (kn_allocator){default_allocate, default_resize, default_release, NULL};
    if (o.threads == 0) {
        long online = sysconf(_SC_NPROCESSORS_ONLN);
        o.threads = online < 1 ? 1 : online > 1024 ? 1024 : (int)online;
    }
    kn_ctx *ctx = make_context(&o);
    if (!ctx) return KN_ENOMEM;
    *out = ctx;
    return KN_OK;
}

kn_ctx *kn_worker_create(kn_ctx *parent)
{
    kn_ctx_options o = {.allocator = parent->options.allocator, .threads = 1};
    kn_ctx *worker = make_context(&o);
    if (!worker) {
        (void)kn_fail(parent, KN_ENOMEM, "no memory for the context of a thread");
        return NULL;
    }
    worker->counts = parent->counts;
    return worker;
}

void kn_ctx_destroy(kn_ctx *ctx)
{
    if (!ctx) return;
    for (chunk *c = ctx->first, *next; c; c = next) {
        next = c->next;
        kn_free(ctx, c);
    }
    kn_allocator a = ctx->options.allocator;
    a.release(a.user, ctx);
}

int kn_ctx_threads(const kn_ctx *ctx)
{
    return ctx->options.threads;
}

// ---- errors ----
kn_status kn_fail_at(kn_ctx *ctx, kn_status status, const char *file, int line, const char *format, ...)
{
    if (ctx->status != KN_OK || status == KN_OK) return status;
    ctx->status = status;
    ctx->file = file;
    ctx->line = line;
    va_list args;
    va_start(args, format);
    (void)vsnprintf(ctx->message, sizeof ctx->message, format, args);
    va_end(args);
    return status;
}

kn_status kn_worker_report(kn_ctx *ctx, const kn_ctx *worker, kn_status status)
{
    if (worker->status == KN_OK) return kn_fail(ctx, status, "%s", kn_status_name(status));
    return kn_fail_at(ctx, status, worker->file, worker->line, "%s", worker->message);
}

kn_status kn_ctx_error(const kn_ctx *ctx)
{
    return ctx->status;
}

const char *kn_ctx_message(const kn_ctx *ctx)
{
    return ctx->message;
}

const char *kn_ctx_error_file(const kn_ctx *ctx)
{
    return ctx->file;
}

int kn_ctx_error_line(const kn_ctx *ctx)
{
    return ctx->line;
}

void kn_ctx_clear_error(kn_ctx *ctx)
{
    ctx->status = KN_OK;
    ctx->file = NULL;
    ctx->line = 0;
    ctx->message[0] = '\0';
}

// ---- callbacks ----
void kn_log(kn_ctx *ctx, kn_log_level level, const char *format, ...)
{
    if (!ctx->options.log) return;
    char text[MESSAGE_SIZE];
    va_list args;
    va_start(args, format);
    (void)vsnprintf(text, sizeof text, format, args);
    va_end(args);
    ctx->options.log(ctx->options.user, level, text);
}

kn_status kn_progress(kn_ctx *ctx, const char *stage, double fraction)
{
    if (!ctx->options.progress || !ctx->options.progress(ctx->options.user, stage, fraction)) return KN_OK;
    return kn_fail(ctx, KN_ECANCELLED, "cancelled in stage \"%s\"", stage);
}

// ---- memory ----
static void count_block(counts *c, size_t blocks, size_t bytes)
{
    atomic_fetch_add_explicit(&c->live_blocks, blocks, memory_order_relaxed);
    atomic_fetch_add_explicit(&c->allocations, 1, memory_order_relaxed);
    size_t live = atomic_fetch_add_explicit(&c->live_bytes, bytes, memory_order_relaxed) + bytes;
    size_t peak = atomic_load_explicit(&c->peak_bytes, memory_order_relaxed);
    while (peak < live && !atomic_compare_exchange_weak_explicit(&c->peak_bytes, &peak, live, memory_order_relaxed,
                                                                 memory_order_relaxed)) {
    }
}

// count * size plus the room for a header; false when it overflows.
static bool block_bytes(size_t *bytes, size_t count, size_t size)
{
    if (size && count > (PTRDIFF_MAX - sizeof(header)) / size) return false;
    *bytes = count * size;
    return true;
}

void *kn_alloc(kn_ctx *ctx, size_t count, size_t size)
{
    const kn_allocator *a = &ctx->options.allocator;
    size_t bytes;
    header *h = block_bytes(&bytes, count, size) ? a->allocate(a->user, bytes + sizeof *h) : NULL;
    if (!h) {
        (void)kn_fail(ctx, KN_ENOMEM, "no memory for %zu x %zu bytes", count, size);
        return NULL;
    }
    h->bytes = bytes;
    count_block(ctx->counts, 1, bytes);
    return h + 1;
}

void *kn_alloc_zero(kn_ctx *ctx, size_t count, size_t size)
{
    void *block = kn_alloc(ctx, count, size);
    if (block) memset(block, 0, count * size);
    return block;
}

void *kn_resize(kn_ctx *ctx, void *block, size_t count, size_t size)
{
    if (!block) return kn_alloc(ctx, count, size);
    const kn_allocator *a = &ctx->options.allocator;
    header *h = (header *)block - 1;
    size_t before = h->bytes, bytes;
    h = block_bytes(&bytes, count, size) ? a->resize(a->user, h, bytes + sizeof *h) : NULL;
    if (!h) {
        (void)kn_fail(ctx, KN_ENOMEM, "no memory for %zu x %zu bytes", count, size);
        return NULL;
    }
    h->bytes = bytes;
    count_block(ctx->counts, 0, bytes - before); // shrinking: modulo 2^64, as unsigned sums are
    return h + 1;
}

kn_status kn_make_room(kn_ctx *ctx, void **block, size_t *room, size_t need, size_t size)
{
    if (need <= *room) return KN_OK;
    size_t wanted = 2 * *room > need ? 2 * *room : need + 16;
    void *more = kn_resize(ctx, *block, wanted, size);
    if (!more) return KN_ENOMEM;
    *block = more, *room = wanted;
    return KN_OK;
}

void kn_free(kn_ctx *ctx, void *block)
{
    if (!block) return;
    header *h = (header *)block - 1;
    atomic_fetch_sub_explicit(&ctx->counts->live_blocks, 1, memory_order_relaxed);
    atomic_fetch_sub_explicit(&ctx->counts->live_bytes, h->bytes, memory_order_relaxed);
    ctx->options.allocator.release(ctx->options.allocator.user, h);
}

kn_counters kn_ctx_counters(const kn_ctx *ctx)
{
    const counts *c = ctx->counts;
    return (kn_counters){.live_blocks = atomic_load(&c->live_blocks),
                         .live_bytes = atomic_load(&c->live_bytes),
                         .peak_bytes = atomic_load(&c->peak_bytes),
                         .allocations = atomic_load(&c->allocations)};
}

// ---- scratch ----
kn_mark kn_scratch_mark(kn_ctx *ctx)
{
    return (kn_mark){ctx->current, ctx->current ? ctx->current->used : 0};
}

void kn_scratch_release(kn_ctx *ctx, kn_mark mark)
{
    ctx->current = mark.block ? mark.block : ctx->first;
    if (ctx->current) ctx->current->used = mark.used;
}

// A new piece behind the current one, as large as all before it together, so that there are never many.
static chunk *add_chunk(kn_ctx *ctx, size_t bytes)
{
    size_t size = ctx->scratch_size > SCRATCH_FIRST ? ctx->scratch_size : SCRATCH_FIRST;
    if (size < bytes) size = bytes;
    chunk *c = kn_alloc(ctx, 1, sizeof *c + SCRATCH_ALIGN + size);
    if (!c) return NULL;
    uintptr_t past = (uintptr_t)(c + 1) % SCRATCH_ALIGN;
    c->base = (unsigned char *)(c + 1) + (past ? SCRATCH_ALIGN - past : 0);
    c->size = size;
    c->used = 0;
    chunk **link = ctx->current ? &ctx->current->next : &ctx->first;
    c->next = *link;
    *link = c;
    ctx->scratch_size += size;
    return c;
}

void *kn_scratch(kn_ctx *ctx, size_t count, size_t size)
{
    size_t bytes;
    if (!block_bytes(&bytes, count, size) || bytes > PTRDIFF_MAX - 4096) {
        (void)kn_fail(ctx, KN_ENOMEM, "no memory for %zu x %zu bytes", count, size);
        return NULL;
    }
    bytes = (bytes + SCRATCH_ALIGN - 1) / SCRATCH_ALIGN * SCRATCH_ALIGN;
    chunk *c = ctx->current;
    if (!c || c->size - c->used < bytes) {
        c = c ? c->next : ctx->first;
        if (c) c->used = 0;
        if (!c || c->size < bytes) c = add_chunk(ctx, bytes);
        if (!c) return NULL;
        ctx->current = c;
    }
    void *block = c->base + c->used;
    c->used += bytes;
    return block;
}
