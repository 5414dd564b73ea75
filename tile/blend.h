// SPDX-License-Identifier: Apache-2.0
// The one formula by which parameters change a tile.
#ifndef TILE_BLEND_H
#define TILE_BLEND_H

#include <knurl/tile.h>

// How much of (P at the target - P) a control point P takes at x: (x - value) / (target - value), x taken into
// [lo, hi] where lo < hi.
double kn_tile_blend(const kn_tile_parameter *parameter, double x);

#endif
