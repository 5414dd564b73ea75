// SPDX-License-Identifier: Apache-2.0
// Inside knurl: an output file that appears under its name whole, or not at all.
#ifndef IO_OUT_FILE_H
#define IO_OUT_FILE_H

#include <knurl/io.h>

#include "io/state.h"
#include "io/text_buffer.h"

// Bytes go to a new file beside path ("path.tmp-0" or the first number that is free); commit gives it the name, abort
// removes it. So a reader never sees half a file, and what was there before survives every failure. A path that is
// there already and is neither file nor folder (a pipe, /dev/null) is written to directly: renaming would replace it.
typedef struct kn_out_file kn_out_file;

// fails: KN_EIO (no such folder, no permission, path is a folder), KN_ENOMEM; *out unchanged.
KN_CHECKED kn_status kn_out_open(kn_ctx *ctx, kn_out_file **out, const char *path);
// From now on all bytes go through the filter, which is copied, on their way to the file: neither kn_out_rewrite,
// kn_out_append from it nor kn_out_save then. fails: what its begin answers.
KN_CHECKED kn_status kn_out_set_filter(kn_ctx *ctx, kn_out_file *file, const kn_filter *filter);
// A second one for the same output, "path" and the suffix, for what cannot be told before the rest is known. Where
// path is written to directly, a file without a name. fails: as kn_out_open.
KN_CHECKED kn_status kn_out_open_beside(kn_ctx *ctx, kn_out_file **out, const kn_out_file *main, const char *suffix);
// Appends all that was written to `from`, which can then only be closed, and is removed. fails: KN_EIO, KN_ENOMEM.
KN_CHECKED kn_status kn_out_append(kn_ctx *ctx, kn_out_file *to, kn_out_file *from);
// Appends. fails: KN_EIO with the system's reason (a full disk, a limit).
KN_CHECKED kn_status kn_out_write(kn_ctx *ctx, kn_out_file *file, const void *data, size_t bytes);
// Appends a text, and empties it. fails: also KN_ENOMEM (the text has failed).
KN_CHECKED kn_status kn_out_flush(kn_ctx *ctx, kn_out_file *file, kn_text *text);
// Overwrites bytes that were written before, at offset from the start; the place of the next append is unchanged.
KN_CHECKED kn_status kn_out_rewrite(kn_ctx *ctx, kn_out_file *file, size_t offset, const void *data, size_t bytes);
// Bytes that the file has so far; still known after commit.
size_t kn_out_bytes(const kn_out_file *file);
// Everything to the disk's care, every error looked at, then the rename. Afterwards only kn_out_bytes and
// kn_out_close may be called. fails: KN_EIO; the file is removed by kn_out_close.
KN_CHECKED kn_status kn_out_commit(kn_ctx *ctx, kn_out_file *file);
// What is written so far goes to the disk, and stays there when the file is closed without a commit; state receives
// what kn_out_restore needs. fails: KN_EIO, KN_EDOMAIN a path that is written to directly, a
// filter.
KN_CHECKED kn_status kn_out_save(kn_ctx *ctx, kn_out_file *file, kn_state *state);
// Goes on with the bytes that were there at kn_out_save: what was written after it is cut off, and what this handle
// has written is forgotten. fails: KN_EIO, KN_EDOMAIN a state of another path, a file that is shorter; file
// unchanged.
KN_CHECKED kn_status kn_out_restore(kn_ctx *ctx, kn_out_file *file, kn_state_reader *state);
// Takes kn_out_save back: nobody can go on with what is written so far.
void kn_out_forget(kn_out_file *file);
// Frees the handle, and removes the file unless it was committed or saved. NULL is fine.
void kn_out_close(kn_ctx *ctx, kn_out_file *file);

#endif
