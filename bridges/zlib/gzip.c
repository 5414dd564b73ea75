// SPDX-License-Identifier: Apache-2.0
// gzip through zlib.
#include "bridges/zlib/gzip.h"

#include "io/io_error.h"
#include "io/out_file.h"
#include "kernel/context.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <zlib.h>

enum { WINDOW = 15 + 16, MEMORY = 8, PART = 1 << 15, MOST_PUT = 1 << 30 }; // 16: gzip's header and trailer

static voidpf take(voidpf ctx, uInt count, uInt size)
{
    return kn_alloc(ctx, count, size);
}

static void give(voidpf ctx, voidpf block)
{
    kn_free(ctx, block);
}

// ---- compressing ----

typedef struct gzip {
    z_stream z;
    unsigned char out[PART];
} gzip;

static kn_status gzip_begin(kn_ctx *ctx, void **state, int level)
{
    gzip *g = kn_alloc_zero(ctx, 1, sizeof *g);
    if (!g) return KN_ENOMEM;
    g->z.zalloc = take, g->z.zfree = give, g->z.opaque = ctx;
    if (deflateInit2(&g->z, level, Z_DEFLATED, WINDOW, MEMORY, Z_DEFAULT_STRATEGY) != Z_OK) {
        kn_free(ctx, g);
        return KN_ENOMEM;
    }
    *state = g;
    return KN_OK;
}

static kn_status gzip_put(kn_ctx *ctx, void *state, const void *data, size_t bytes, bool last,
                          kn_status (*write)(kn_ctx *ctx, void *to, const void *data, size_t bytes), void *to)
{
    gzip *g = state;
    kn_status status = KN_OK;
    int answer = Z_OK;
    const unsigned char *at = data;
    do {
        uInt part = bytes < MOST_PUT ? (uInt)bytes : MOST_PUT;
        int flush = last && part == bytes ? Z_FINISH : Z_NO_FLUSH;
        memcpy(&g->z.next_in, &at, sizeof at); // zlib reads it, whatever its type says
        g->z.avail_in = part;
        do {
            g->z.next_out = g->out, g->z.avail_out = PART;
            answer = deflate(&g->z, flush);
            status = write(ctx, to, g->out, PART - g->z.avail_out);
        } while (status == KN_OK && answer == Z_OK && (g->z.avail_out == 0 || g->z.avail_in > 0));
        if (status == KN_OK && answer != Z_OK && answer != Z_STREAM_END && answer != Z_BUF_ERROR)
            status = kn_fail(ctx, KN_EUNDEFINED, "gzip: zlib gave up: %s", g->z.msg ? g->z.msg : zError(answer));
        at += part, bytes -= part;
    } while (status == KN_OK && bytes > 0);
    return status;
}

static void gzip_end(kn_ctx *ctx, void *state)
{
    gzip *g = state;
    if (!g) return;
    g->z.opaque = ctx;
    (void)deflateEnd(&g->z);
    kn_free(ctx, g);
}

kn_filter kn_gzip_filter(int level)
{
    return (kn_filter){gzip_begin, gzip_put, gzip_end, level >= 1 && level <= 9 ? level : 6};
}

// ---- the other way ----

bool kn_gzip_is(const char *path)
{
    unsigned char first[2] = {0, 0};
    FILE *file = fopen(path, "rb");
    if (!file) return false;
    bool is = fread(first, 1, 2, file) == 2 && first[0] == 0x1f && first[1] == 0x8b;
    fclose(file);
    return is;
}

typedef struct gunzip {
    z_stream z;
    const char *path;
    FILE *from;
    kn_out_file *to;
    size_t most;
    unsigned char in[PART], out[PART];
} gunzip;

static kn_status bad(kn_ctx *ctx, const gunzip *g, const char *what)
{
    return kn_fail(ctx, KN_EPARSE, "%s: %s", g->path, what);
}

// Reads more where all that was read is used. *more: there is something.
static kn_status fill(kn_ctx *ctx, gunzip *g, bool *more)
{
    if (g->z.avail_in == 0) {
        errno = 0;
        size_t n = fread(g->in, 1, PART, g->from);
        if (ferror(g->from)) return kn_fail_io(ctx, g->path, "cannot read", errno);
        g->z.next_in = g->in, g->z.avail_in = (uInt)n;
    }
    *more = g->z.avail_in > 0;
    return KN_OK;
}

// One member after the other.
static kn_status inflate_all(kn_ctx *ctx, gunzip *g)
{
    bool more = false, inside = true;
    kn_status status = KN_OK;
    while (status == KN_OK) {
        status = fill(ctx, g, &more);
        if (status != KN_OK) return status;
        if (!more) return inside ? bad(ctx, g, "a gzip file that is cut off") : KN_OK;
        if (!inside) inflateReset(&g->z);
        inside = true;
        g->z.next_out = g->out, g->z.avail_out = PART;
        int answer = inflate(&g->z, Z_NO_FLUSH);
        if (answer == Z_MEM_ERROR) return KN_ENOMEM;
        if (answer != Z_OK && answer != Z_STREAM_END && answer != Z_BUF_ERROR)
            return bad(ctx, g, g->z.msg ? g->z.msg : "no gzip file");
        inside = answer != Z_STREAM_END;
        size_t bytes = PART - g->z.avail_out;
        if (bytes > g->most - kn_out_bytes(g->to))
            return kn_fail(ctx, KN_ELIMIT, "%s: unpacked it has more than %zu bytes", g->path, g->most);
        status = kn_out_write(ctx, g->to, g->out, bytes);
        if (status == KN_OK) status = kn_progress(ctx, "unpacking", 0.0);
    }
    return status;
}

kn_status kn_gunzip_file(kn_ctx *ctx, const char *to, const char *from, size_t most)
{
    gunzip *g = kn_alloc_zero(ctx, 1, sizeof *g);
    if (!g) return KN_ENOMEM;
    g->path = from, g->most = most;
    g->z.zalloc = take, g->z.zfree = give, g->z.opaque = ctx;
    errno = 0;
    g->from = fopen(from, "rb");
    kn_status status = g->from ? KN_OK : kn_fail_io(ctx, from, "cannot open", errno);
    bool ready = status == KN_OK && inflateInit2(&g->z, WINDOW) == Z_OK;
    if (status == KN_OK && !ready) status = KN_ENOMEM;
    if (status == KN_OK) status = kn_out_open(ctx, &g->to, to);
    if (status == KN_OK) status = inflate_all(ctx, g);
    if (status == KN_OK) status = kn_out_commit(ctx, g->to);
    if (ready) inflateEnd(&g->z);
    if (g->from) fclose(g->from);
    kn_out_close(ctx, g->to);
    kn_free(ctx, g);
    return status;
}
