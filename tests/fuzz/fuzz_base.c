// SPDX-License-Identifier: Apache-2.0
// Fuzzes contexts, counts and names.
#include "tests/fuzz/feed.h"

#include <knurl/knurl.h>

static void nothing(void *user, kn_log_level level, const char *message)
{
    (void)user, (void)level, (void)message;
}

static void contexts(feed *f)
{
    kn_ctx_options options = kn_ctx_defaults();
    size_t live = 0;
    int given = feed_byte(f);
    if (given & 1) options.allocator.allocate = feed_allocate;
    if (given & 2) options.allocator.resize = feed_resize;
    if (given & 4) options.allocator.release = feed_release;
    options.allocator.user = &live;
    if (given & 8) options.log = nothing;
    options.threads = feed_wild(f, 0, 3);
    kn_ctx *ctx = NULL;
    kn_status status = kn_ctx_create(&ctx, &options);
    if ((status == KN_OK) != (ctx != NULL)) abort();
    if (ctx && (kn_ctx_threads(ctx) < 1 || kn_ctx_error(ctx) != KN_OK || *kn_ctx_message(ctx))) abort();
    if (ctx && (kn_ctx_error_file(ctx) || kn_ctx_error_line(ctx) != 0)) abort();
    if (ctx && kn_ctx_counters(ctx).live_blocks > 0 && kn_ctx_counters(ctx).live_bytes == 0) abort();
    kn_ctx_destroy(ctx);
    if (live != 0) abort();
}

static void names(feed *f)
{
    char name[9];
    for (size_t i = 0; i < sizeof name; i++) name[i] = (char)feed_byte(f);
    name[sizeof name - 1] = 0;
    if (!*kn_status_name((kn_status)feed_wild(f, 0, 12)) || !*kn_version()) abort();
    int count = kn_builtin_tile_count(), i = feed_wild(f, 0, count);
    const char *known = kn_builtin_tile_name(i);
    if ((known != NULL) != (i >= 0 && i < count)) abort();
    kn_tile tile = {0};
    if (kn_builtin_tile(f->ctx, &tile, known && feed_byte(f) % 2 ? known : name) == KN_OK) {
        if (kn_tile_check(f->ctx, &tile) != KN_OK) abort();
        kn_tile_clear(f->ctx, &tile);
    }
}

static void counts(feed *f)
{
    int nvars = feed_wild(f, 0, KN_MAX_VARS), order = feed_wild(f, 0, 12), index[KN_MAX_VARS] = {0}, sum = 0;
    int count = kn_derivative_count(nvars, order);
    if (count < 0) abort();
    if (nvars < 1 || nvars > KN_MAX_VARS || count == 0) return;
    for (int d = 0; d < nvars; d++) sum += index[d] = feed_int(f, 0, order - sum);
    int place = kn_derivative_index(nvars, index);
    if (place < 0 || place >= count) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    feed f = feed_begin(data, size);
    contexts(&f);
    counts(&f);
    names(&f);
    kn_free(f.ctx, NULL);
    kn_ctx_clear_error(f.ctx);
    feed_end(&f);
    return 0;
}
