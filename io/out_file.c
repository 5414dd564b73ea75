// SPDX-License-Identifier: Apache-2.0
// An output file that appears under its name whole, or not at all.
#include "io/out_file.h"
#include "io/io_error.h"
#include "kernel/context.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

enum { SUFFIX_BYTES = 24, TEMPORARIES = 10000 };

struct kn_out_file {
    FILE *stream;    // NULL once closed
    char *path;      // the name that was asked for
    char *temporary; // the name that is there until commit; "" when writing to path directly
    size_t bytes;
};

// A name that nobody uses: "x" makes fopen create the file or fail, so two writers never share one.
static kn_status open_temporary(kn_ctx *ctx, kn_out_file *file)
{
    size_t length = strlen(file->path);
    memcpy(file->temporary, file->path, length);
    int error = EEXIST;
    for (int i = 0; i < TEMPORARIES && error == EEXIST; i++) {
        snprintf(file->temporary + length, SUFFIX_BYTES, ".tmp-%d", i);
        errno = 0;
        file->stream = fopen(file->temporary, "wbx");
        if (file->stream != NULL) return KN_OK;
        error = errno;
    }
    file->temporary[0] = '\0'; // not ours to remove
    return kn_fail_io(ctx, file->path, "cannot create", error);
}

static kn_status open_stream(kn_ctx *ctx, kn_out_file *file)
{
    struct stat there;
    if (file->path[0] == '\0') return kn_fail_io(ctx, "\"\"", "cannot create", ENOENT);
    bool exists = stat(file->path, &there) == 0;
    if (exists && S_ISDIR(there.st_mode)) return kn_fail_io(ctx, file->path, "cannot create", EISDIR);
    if (!exists || S_ISREG(there.st_mode)) return open_temporary(ctx, file);
    file->temporary[0] = '\0';
    file->stream = fopen(file->path, "wb");
    return file->stream != NULL ? KN_OK : kn_fail_io(ctx, file->path, "cannot open", errno);
}

kn_status kn_out_open(kn_ctx *ctx, kn_out_file **out, const char *path)
{
    size_t length = strlen(path);
    kn_out_file *file = kn_alloc_zero(ctx, 1, sizeof *file);
    if (file == NULL) return KN_ENOMEM;
    file->path = kn_alloc_zero(ctx, length + 1, 1);
    file->temporary = kn_alloc_zero(ctx, length + SUFFIX_BYTES, 1);
    kn_status status = KN_ENOMEM;
    if (file->path != NULL && file->temporary != NULL) {
        memcpy(file->path, path, length);
        status = open_stream(ctx, file);
    }
    if (status == KN_OK)
        *out = file;
    else
        kn_out_close(ctx, file);
    return status;
}

kn_status kn_out_write(kn_ctx *ctx, kn_out_file *file, const void *data, size_t bytes)
{
    errno = 0;
    if (bytes > 0 && fwrite(data, 1, bytes, file->stream) != bytes)
        return kn_fail_io(ctx, file->path, "cannot write", errno);
    file->bytes += bytes;
    return KN_OK;
}

kn_status kn_out_rewrite(kn_ctx *ctx, kn_out_file *file, size_t offset, const void *data, size_t bytes)
{
    errno = 0;
    if (fseek(file->stream, (long)offset, SEEK_SET) != 0 || fwrite(data, 1, bytes, file->stream) != bytes ||
        fseek(file->stream, 0, SEEK_END) != 0)
        return kn_fail_io(ctx, file->path, "cannot write", errno);
    return KN_OK;
}

size_t kn_out_bytes(const kn_out_file *file)
{
    return file->bytes;
}

kn_status kn_out_commit(kn_ctx *ctx, kn_out_file *file)
{
    errno = 0;
    bool flushed = fflush(file->stream) == 0 && !ferror(file->stream);
    int error = errno;
    bool closed = fclose(file->stream) == 0;
    if (flushed && !closed) error = errno;
    file->stream = NULL;
    if (!flushed || !closed) return kn_fail_io(ctx, file->path, "cannot write", error);
    if (file->temporary[0] == '\0') return KN_OK;
    if (rename(file->temporary, file->path) != 0) return kn_fail_io(ctx, file->path, "cannot rename to", errno);
    file->temporary[0] = '\0';
    return KN_OK;
}

void kn_out_close(kn_ctx *ctx, kn_out_file *file)
{
    if (file == NULL) return;
    if (file->stream != NULL) fclose(file->stream); // abandoned: its errors no longer matter
    if (file->temporary != NULL && file->temporary[0] != '\0') remove(file->temporary);
    kn_free(ctx, file->path);
    kn_free(ctx, file->temporary);
    kn_free(ctx, file);
}
