// SPDX-License-Identifier: Apache-2.0
// gzip files (RFC 1952) through zlib: what writers put out compressed, and files made whole again.
#ifndef BRIDGES_ZLIB_GZIP_H
#define BRIDGES_ZLIB_GZIP_H

#include <knurl/io.h>

#ifdef __cplusplus
extern "C" {
#endif

// A filter for writers whose files are then those of gzip -n: equal bytes give equal files. level: 1 (fast) .. 9; 0:
// 6.
kn_filter kn_gzip_filter(int level);

// Whether a file begins as those of gzip do.
bool kn_gzip_is(const char *path);
// Writes what the gzip file `from` holds to the new file `to`, all members one after the other, with 96 KB of memory.
// fails: KN_EIO, KN_EPARSE (no gzip file, damaged, cut off; the message says which), KN_ELIMIT (more
//        than `most` bytes), KN_ENOMEM; `to` is not there then.
KN_CHECKED kn_status kn_gunzip_file(kn_ctx *ctx, const char *to, const char *from, size_t most);

#ifdef __cplusplus
}
#endif
#endif
