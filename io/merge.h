// SPDX-License-Identifier: Apache-2.0
// Inside io: patches that lie side by side in a grid, and the one surface that takes their place.
#ifndef IO_MERGE_H
#define IO_MERGE_H

#include <knurl/io.h>

#include "io/brep.h"

// Sides of a patch, counterclockwise: t = 0, r = 1, t = 1, r = 0. In the grid it is turned by `turn` quarters: its
// side (i + turn) % 4 is the grid's side i.
typedef struct kn_merge_item {
    kn_patch patch;    // its bezier empty, its spline and edge these
    kn_spline surface; // over [0,1]^2
    kn_spline edge[4]; // by kn_patch.edge; empty: the ends of surface
    kn_brep_key side[4];
    int next[4], next_side[4]; // the item at the other side of it, and which of its sides that is; -1: none
    enum { KN_SEAM_UNKNOWN, KN_SEAM_SMOOTH, KN_SEAM_SHARP } seam[4]; // with next[], as samples have it
    int turn;
    bool done;
} kn_merge_item;

// A surface in the place of a grid of items.
typedef struct kn_merged {
    kn_spline surface, edge[4];
    double error, angle;                 // certified; of normals along the outer edges
    int unknown_angles, singular_angles; // of the four, as kn_fit_limited has them
    int columns, rows, continuity[2];
} kn_merged;
// turned (empty) = the item's surface as it lies in the grid. KN_ENOMEM.
kn_status kn_merge_turn(kn_ctx *ctx, kn_spline *turned, const kn_merge_item *item);
// The surface of columns x rows items, list[row * columns + column]. *good: within the limits' tolerance and angle;
// else *out is empty.
kn_status kn_merge_surface(kn_ctx *ctx, kn_merged *out, bool *good, const kn_merge_item *items, const int *list,
                           int columns, int rows, const kn_merge_options *limits);

#endif
