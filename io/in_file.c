// SPDX-License-Identifier: Apache-2.0
// A whole file as bytes.
#include "io/in_file.h"
#include "io/io_error.h"
#include "kernel/context.h"

#include <errno.h>
#include <stdio.h>

// Reads to the end by doubling, which serves pipes as well: their size is not known beforehand.
static kn_status read_stream(kn_ctx *ctx, char **text, size_t *bytes, FILE *stream, const char *path)
{
    size_t room = 1 << 16, used = 0;
    char *buffer = kn_alloc(ctx, room, 1);
    if (buffer == NULL) return KN_ENOMEM;
    kn_status status = KN_OK;
    while (status == KN_OK) {
        errno = 0;
        size_t got = fread(buffer + used, 1, room - used, stream);
        used += got;
        if (ferror(stream)) status = kn_fail_io(ctx, path, "cannot read", errno);
        if (status != KN_OK || feof(stream)) break;
        if (used < room) continue;
        char *larger = kn_resize(ctx, buffer, 2 * room, 1);
        if (larger == NULL)
            status = KN_ENOMEM;
        else
            buffer = larger, room *= 2;
    }
    if (status == KN_OK)
        *text = buffer, *bytes = used;
    else
        kn_free(ctx, buffer);
    return status;
}

kn_status kn_in_read(kn_ctx *ctx, char **text, size_t *bytes, const char *path)
{
    errno = 0;
    FILE *stream = fopen(path, "rb");
    if (stream == NULL) return kn_fail_io(ctx, path, "cannot open", errno);
    kn_status status = read_stream(ctx, text, bytes, stream, path);
    fclose(stream);
    return status;
}
