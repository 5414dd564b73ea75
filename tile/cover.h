// SPDX-License-Identifier: Apache-2.0
// Inside tile: parts of patches over a box of the (u,v) plane, and whether they cover it.
#ifndef TILE_COVER_H
#define TILE_COVER_H

#include "tile/net.h"

// Part [i, i + 1] x [j, j + 1] / 2^level of a piece moved by whole cells. coef: u, then v, in scratch; those of each
// are wrong by its `error` at most.
typedef struct kn_tile_bit {
    int piece, cell[2];
    uint32_t index[2];
    double *coef, error[2], lo[2], hi[2];
} kn_tile_bit;

// Whether the bits, all of one level, cover the open box [lo, hi] certainly. They are those that meet it.
kn_status kn_tile_covers_box(kn_ctx *ctx, bool *yes, const kn_tile_net *net, const kn_tile_bit *bits, int n,
                             int level, const double lo[2], const double hi[2]);
// Four bits of the next level; their coefficients in scratch.
kn_status kn_tile_quarter(kn_ctx *ctx, kn_tile_bit out[4], const kn_tile_net *net, const kn_tile_bit *bit);
// lo and hi from the coefficients and their error.
void kn_tile_bound(kn_tile_bit *bit, const kn_tile_net *net);

#endif
