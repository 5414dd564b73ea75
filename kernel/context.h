// SPDX-License-Identifier: Apache-2.0
// Inside knurl: errors, memory and threads of a context. Public meaning: include/knurl/base.h.
#ifndef KERNEL_CONTEXT_H
#define KERNEL_CONTEXT_H

#include <knurl/base.h>

// Records the first error (status, message, source place) and answers status, so that `return kn_fail(...)` reads
// well.
#define kn_fail(ctx, status, ...) kn_fail_at((ctx), (status), __FILE__, __LINE__, __VA_ARGS__)
kn_status kn_fail_at(kn_ctx *ctx, kn_status status, const char *file, int line, const char *format, ...)
    KN_PRINTF(5, 6);
void kn_log(kn_ctx *ctx, kn_log_level level, const char *format, ...) KN_PRINTF(3, 4);
// Reports progress; KN_ECANCELLED (recorded) when the callback asks to stop. Cheap enough for every block of work.
kn_status kn_progress(kn_ctx *ctx, const char *stage, double fraction);

// Results: count * size bytes, not cleared, never NULL for count 0; NULL (and KN_ENOMEM recorded) when there is no
// memory or the product overflows. Freed with kn_free (public, base.h), NULL is fine.
void *kn_alloc(kn_ctx *ctx, size_t count, size_t size);
void *kn_alloc_zero(kn_ctx *ctx, size_t count, size_t size);
// As realloc: NULL on failure, and block stays valid.
void *kn_resize(kn_ctx *ctx, void *block, size_t count, size_t size);
// Room in *block, which has *room elements of size bytes, for `need` of them at least and some to come.
kn_status kn_make_room(kn_ctx *ctx, void **block, size_t *room, size_t need, size_t size);

// Scratch: an arena for the duration of one public call. Mark, take, release to the mark (stack order). Released
// memory stays with the context, so that a steady state allocates nothing. 64-byte aligned. NULL as kn_alloc.
typedef struct kn_mark {
    void *block;
    size_t used;
} kn_mark;
kn_mark kn_scratch_mark(kn_ctx *ctx);
void *kn_scratch(kn_ctx *ctx, size_t count, size_t size);
void kn_scratch_release(kn_ctx *ctx, kn_mark mark);

#endif
