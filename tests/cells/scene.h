// SPDX-License-Identifier: Apache-2.0
// What tests of cells share.
#ifndef TESTS_CELLS_SCENE_H
#define TESTS_CELLS_SCENE_H

#include <knurl/cells.h>

// A bicubic over [0,1]^2 with simple knots at quarters, C2, whose control point (i,j) is at(i/6, j/6).
void scene_hills(kn_ctx *ctx, kn_spline *out, void (*at)(double p[3], double u, double v));

#endif
