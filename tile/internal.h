// SPDX-License-Identifier: Apache-2.0
// Inside tile: what its operations share.
#ifndef TILE_INTERNAL_H
#define TILE_INTERNAL_H

#include "kernel/context.h"

#include <knurl/tile.h>

// A copy of n splines (some perhaps empty), in a new list; NULL: KN_ENOMEM recorded.
kn_spline *kn_tile_copy_splines(kn_ctx *ctx, const kn_spline *list, int n);
void kn_tile_free_splines(kn_ctx *ctx, kn_spline *list, int n);

// Whether b has the degrees and knots of a, and as many components: what a target must have.
bool kn_tile_same_kind(const kn_spline *a, const kn_spline *b);

kn_status kn_tile_check_spline(kn_ctx *ctx, const kn_tile_part *part, int spline);
kn_status kn_tile_check_mesh(kn_ctx *ctx, const kn_tile_part *part);
// The tile's parameters, and what its parts say of them.
kn_status kn_tile_check_parameters(kn_ctx *ctx, const kn_tile *tile);

#endif
