// SPDX-License-Identifier: Apache-2.0
// Inside knurl: colours for other programs.
#ifndef IO_COLOR_H
#define IO_COLOR_H

// Colours are linear inside knurl; those of most files are sRGB (IEC 61966-2-1), from 0 to 1. Four digits are more than
// a screen shows, and hide how the last bits of pow differ between C libraries.
double kn_color_srgb(double linear);
// The same as 0 .. 255.
int kn_color_srgb_byte(double linear);

#endif
