// SPDX-License-Identifier: Apache-2.0
// Files that the build puts into the library as constant bytes (tools/embed.sh): the built-in tiles.
#ifndef IO_EMBEDDED_H
#define IO_EMBEDDED_H

#include <stddef.h>

// path is relative to data/tiles, "chain/link.g2" for example. A zero byte follows bytes[size - 1].
typedef struct kn_embedded_file {
    const char *path;
    const char *bytes;
    size_t size;
} kn_embedded_file;

// In the order of their paths, byte by byte; the entry after the last has path NULL.
extern const kn_embedded_file kn_embedded_files[];
extern const size_t kn_embedded_file_count;

#endif
