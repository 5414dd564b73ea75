// SPDX-License-Identifier: Apache-2.0
// PNG pictures through libpng.
#ifndef BRIDGES_PNG_H
#define BRIDGES_PNG_H

#include <knurl/base.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { KN_PNG_MAX_SIDE = 1 << 16 }; // pixels

// Writes path as a PNG of 8 bits a channel, marked sRGB; it appears under its name whole or not at all.
// in:    pixels row by row from the top, channels (3: RGB, 4: RGBA, not premultiplied) bytes each.
// fails: KN_EDOMAIN width or height below 1, channels not 3 or 4; KN_ELIMIT a side above KN_PNG_MAX_SIDE; KN_EIO;
//        KN_ENOMEM.
// cost:  one row of memory and zlib's.
// source: ISO/IEC 15948:2004, Portable Network Graphics.
KN_API KN_CHECKED kn_status kn_png_write(kn_ctx *ctx, const char *path, const uint8_t *pixels, int width, int height,
                                         int channels);

#ifdef __cplusplus
}
#endif
#endif
