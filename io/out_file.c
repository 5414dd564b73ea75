// SPDX-License-Identifier: Apache-2.0
// An output file that appears under its name whole, or not at all.
#include "io/out_file.h"
#include "io/io_error.h"
#include "kernel/context.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { SUFFIX_BYTES = 24, TEMPORARIES = 10000 };

struct kn_out_file {
    FILE *stream;    // NULL once closed
    char *path;      // the name that was asked for
    char *temporary; // the name that is there until commit; "" when writing to path directly
    size_t bytes;
    bool kept; // kn_out_save: a later run goes on with it
    kn_filter filter;
    void *filtering; // its state; NULL: no filter
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
        file->stream = fopen(file->temporary, "w+bx"); // read again by kn_out_append
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

kn_status kn_out_open_beside(kn_ctx *ctx, kn_out_file **out, const kn_out_file *main, const char *suffix)
{
    size_t length = strlen(main->path), more = strlen(suffix);
    if (main->temporary[0] != '\0') {
        char *path = kn_alloc_zero(ctx, length + more + 1, 1);
        if (path == NULL) return KN_ENOMEM;
        memcpy(path, main->path, length);
        memcpy(path + length, suffix, more);
        kn_status status = kn_out_open(ctx, out, path);
        kn_free(ctx, path);
        return status;
    }
    kn_out_file *file = kn_alloc_zero(ctx, 1, sizeof *file); // beside a pipe there is no place
    if (file == NULL) return KN_ENOMEM;
    file->path = kn_alloc_zero(ctx, length + 1, 1);
    file->temporary = kn_alloc_zero(ctx, 1, 1);
    kn_status status = KN_ENOMEM;
    if (file->path != NULL && file->temporary != NULL) {
        memcpy(file->path, main->path, length);
        errno = 0;
        file->stream = tmpfile();
        status = file->stream != NULL ? KN_OK : kn_fail_io(ctx, file->path, "cannot create a file for", errno);
    }
    if (status == KN_OK)
        *out = file;
    else
        kn_out_close(ctx, file);
    return status;
}

kn_status kn_out_append(kn_ctx *ctx, kn_out_file *to, kn_out_file *from)
{
    enum { PART = 1 << 16 };
    size_t left = from->bytes;
    char *part = kn_alloc(ctx, PART, 1);
    if (part == NULL) return KN_ENOMEM;
    errno = 0;
    kn_status status = KN_OK;
    if (fflush(from->stream) != 0 || fseek(from->stream, 0, SEEK_SET) != 0)
        status = kn_fail_io(ctx, from->path, "cannot write", errno);
    while (status == KN_OK && left > 0) {
        size_t bytes = left < PART ? left : PART;
        if (fread(part, 1, bytes, from->stream) != bytes)
            status = kn_fail_io(ctx, from->path, "cannot read again", errno);
        else
            status = kn_out_write(ctx, to, part, bytes);
        left -= bytes;
    }
    if (status == KN_OK) from->kept = false;
    kn_free(ctx, part);
    return status;
}

static kn_status write_bytes(kn_ctx *ctx, void *to, const void *data, size_t bytes)
{
    kn_out_file *file = to;
    errno = 0;
    if (bytes > 0 && fwrite(data, 1, bytes, file->stream) != bytes)
        return kn_fail_io(ctx, file->path, "cannot write", errno);
    file->bytes += bytes;
    return KN_OK;
}

kn_status kn_out_write(kn_ctx *ctx, kn_out_file *file, const void *data, size_t bytes)
{
    if (file->filtering) return file->filter.put(ctx, file->filtering, data, bytes, false, write_bytes, file);
    return write_bytes(ctx, file, data, bytes);
}

kn_status kn_out_set_filter(kn_ctx *ctx, kn_out_file *file, const kn_filter *filter)
{
    file->filter = *filter;
    return filter->begin(ctx, &file->filtering, filter->level);
}

kn_status kn_out_flush(kn_ctx *ctx, kn_out_file *file, kn_text *text)
{
    kn_status status = text->failed ? KN_ENOMEM : kn_out_write(ctx, file, text->data, text->bytes);
    text->bytes = text->line = 0;
    return status;
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
    if (file->filtering) {
        kn_status status = file->filter.put(ctx, file->filtering, "", 0, true, write_bytes, file);
        if (status != KN_OK) return status;
    }
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

kn_status kn_out_save(kn_ctx *ctx, kn_out_file *file, kn_state *state)
{
    if (file->temporary[0] == '\0' || file->filtering)
        return kn_fail(ctx, KN_EDOMAIN, "%s: what is written %s cannot be gone on with", file->path,
                       file->filtering ? "through a filter" : "directly");
    errno = 0;
    if (fflush(file->stream) != 0 || fsync(fileno(file->stream)) != 0)
        return kn_fail_io(ctx, file->path, "cannot write", errno);
    file->kept = true;
    kn_state_put(state, &file->bytes, sizeof file->bytes);
    kn_state_put_block(state, file->temporary, strlen(file->temporary) + 1);
    return state->failed ? KN_ENOMEM : KN_OK;
}

void kn_out_forget(kn_out_file *file)
{
    file->kept = false;
}

// The temporary name of this path with another number: nothing else may be cut.
static bool is_ours(const kn_out_file *file, const char *name, size_t bytes)
{
    size_t length = strlen(file->path);
    return bytes > length + 5 && bytes <= length + SUFFIX_BYTES && name[bytes - 1] == '\0' &&
           strlen(name) + 1 == bytes && memcmp(name, file->path, length) == 0 &&
           memcmp(name + length, ".tmp-", 5) == 0 && strspn(name + length + 5, "0123456789") == bytes - length - 6;
}

kn_status kn_out_restore(kn_ctx *ctx, kn_out_file *file, kn_state_reader *state)
{
    size_t size, bytes = 0;
    struct stat there;
    const char *name = kn_state_take(state, &size, sizeof size) ? kn_state_take_block(state, &bytes) : NULL;
    if (name == NULL || file->temporary[0] == '\0' || !is_ours(file, name, bytes))
        return kn_fail(ctx, KN_EDOMAIN, "%s: the interrupted run wrote another file", file->path);
    errno = ENOENT; // this handle's own name was free: that of the interrupted run is gone
    FILE *stream = strcmp(name, file->temporary) != 0 ? fopen(name, "r+b") : NULL;
    if (stream == NULL) return kn_fail_io(ctx, name, "cannot go on with", errno);
    bool enough = fstat(fileno(stream), &there) == 0 && (uint64_t)there.st_size >= size;
    bool ready = enough && ftruncate(fileno(stream), (off_t)size) == 0 && fseek(stream, 0, SEEK_END) == 0;
    if (!ready) {
        int error = errno;
        (void)fclose(stream);
        if (enough) return kn_fail_io(ctx, name, "cannot go on with", error);
        return kn_fail(ctx, KN_EDOMAIN, "%s: shorter than the interrupted run left it", name);
    }
    (void)fclose(file->stream);
    remove(file->temporary);
    file->stream = stream;
    memcpy(file->temporary, name, bytes);
    file->bytes = size;
    file->kept = true;
    return KN_OK;
}

void kn_out_close(kn_ctx *ctx, kn_out_file *file)
{
    if (file == NULL) return;
    if (file->filtering) file->filter.end(ctx, file->filtering);
    if (file->stream != NULL) fclose(file->stream); // abandoned: its errors no longer matter
    if (!file->kept && file->temporary != NULL && file->temporary[0] != '\0') remove(file->temporary);
    kn_free(ctx, file->path);
    kn_free(ctx, file->temporary);
    kn_free(ctx, file);
}
