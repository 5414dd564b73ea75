// SPDX-License-Identifier: Apache-2.0
// The legend of a picture that shows numbers as colours, drawn with cairo.
#ifndef BRIDGES_LEGEND_H
#define BRIDGES_LEGEND_H

#include <knurl/base.h>

#ifdef __cplusplus
extern "C" {
#endif

// A number below the bar, or a mark above it.
typedef struct kn_legend_tick {
    double at; // 0 .. 1 along the bar
    const char *label;
} kn_legend_tick;

// Texts are UTF-8, on one line each; NULL: none.
typedef struct kn_legend {
    const char *title, *subtitle;
    const uint8_t *colors; // sRGB, 3 bytes each, from the bar's left end to its right one
    int ncolors;
    const kn_legend_tick *ticks;
    int nticks;
    const kn_legend_tick *mark; // NULL: none
} kn_legend;

enum { KN_LEGEND_MAX_SIDE = 1 << 14, KN_LEGEND_MIN_HEIGHT = 16 };

// Fills the band of `height` rows of rgb, width x height pixels of 3 bytes, sRGB, row by row: the title at the left, the
// bar of colours with its numbers at the right. What is too long for its place is drawn smaller.
// fails: KN_EDOMAIN sides, no colours, a place outside [0,1]; KN_ELIMIT a side above KN_LEGEND_MAX_SIDE; KN_ENOMEM;
//        rgb unchanged.
// cost:  4 bytes a pixel.
KN_API KN_CHECKED kn_status kn_legend_draw(kn_ctx *ctx, uint8_t *rgb, int width, int height, const kn_legend *legend);

#ifdef __cplusplus
}
#endif
#endif
