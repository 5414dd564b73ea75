// SPDX-License-Identifier: Apache-2.0
// Inside knurl: a whole file as bytes.
#ifndef IO_IN_FILE_H
#define IO_IN_FILE_H

#include <knurl/base.h>

// *text: the file's *bytes bytes, no zero byte added, never NULL; freed with kn_free.
// fails: KN_EIO with the system's reason (also when path is a folder), KN_ENOMEM; out unchanged.
KN_CHECKED kn_status kn_in_read(kn_ctx *ctx, char **text, size_t *bytes, const char *path);

#endif
