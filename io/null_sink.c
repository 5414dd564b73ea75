// SPDX-License-Identifier: Apache-2.0
// A sink that only counts.
#include <knurl/io.h>

#include "kernel/context.h"

#include <string.h>

static kn_status null_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)ctx;
    (void)product;
    size_t *bytes = user;
    for (size_t i = 0; i < block->count; i++) {
        const kn_spline s = kn_patch_spline(&block->patches[i]);
        if (s.nvars > 0) *bytes += kn_spline_count(&s) * (size_t)s.ncomp * sizeof *s.coef;
    }
    return KN_OK;
}

static void null_close(kn_ctx *ctx, void *user)
{
    kn_free(ctx, user);
}

static size_t null_bytes(const void *user)
{
    const size_t *bytes = user;
    return *bytes;
}

static kn_status null_save(kn_ctx *ctx, void *user, unsigned char **data, size_t *bytes)
{
    unsigned char *copy = kn_alloc(ctx, sizeof(size_t), 1);
    if (copy == NULL) return KN_ENOMEM;
    memcpy(copy, user, sizeof(size_t));
    *data = copy;
    *bytes = sizeof(size_t);
    return KN_OK;
}

static kn_status null_restore(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report,
                              const unsigned char *data, size_t bytes)
{
    (void)tile, (void)report;
    if (bytes != sizeof(size_t)) return kn_fail(ctx, KN_EDOMAIN, "the interrupted run had another sink");
    memcpy(user, data, bytes);
    return KN_OK;
}

kn_status kn_null_sink(kn_ctx *ctx, kn_sink *out)
{
    size_t *bytes = kn_alloc_zero(ctx, 1, sizeof *bytes);
    if (bytes == NULL) return KN_ENOMEM;
    *out = (kn_sink){.user = bytes,
                     .commit = null_commit,
                     .close = null_close,
                     .bytes = null_bytes,
                     .save = null_save,
                     .restore = null_restore};
    return KN_OK;
}
