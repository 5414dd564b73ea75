// SPDX-License-Identifier: Apache-2.0
// Tiles: textures over the unit cell of the (u,v) plane.
#ifndef KNURL_TILE_H
#define KNURL_TILE_H

#include <knurl/mesh.h>
#include <knurl/spline.h>
#include <knurl/trim.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { KN_NAME_BYTES = 64 };

typedef struct kn_material {
    double base_color[3]; // linear RGB in [0,1]
    double metallic, roughness;
} kn_material;

// A named part of a tile: curves, surfaces (oriented outwards by r x t) and volumes (right-handed) of three components
// (u, v, w), polynomial, and a triangle mesh of (u, v, w), in any mixture.
typedef struct kn_tile_part {
    char name[KN_NAME_BYTES];
    kn_material material;
    kn_spline *splines; // of one, two or three variables
    kn_trim *trims;     // of each spline, empty unless it is a trimmed surface; NULL: none is
    int nsplines;
    kn_mesh mesh; // empty: none
    // Where parameter k of the tile, at its target, puts spline i: targets[k * nsplines + i], of the same degrees and
    // knots, or empty where it changes nothing; and the mesh's vertices: mesh_targets[k], 3 numbers each, or NULL.
    // NULL: no parameter changes the part.
    kn_spline *targets;
    double **mesh_targets;
} kn_tile_part;

// A number by which a tile can be varied (a blend shape): control points are P + sum over parameters of
// (x - value) / (target - value) (P at the target - P).
typedef struct kn_tile_parameter {
    char name[KN_NAME_BYTES];
    double value;  // at which the tile is as its parts say
    double target; // at which it is as their targets say; not `value`
    double lo, hi; // what makes sense
} kn_tile_parameter;

// A texture over the unit cell of (u,v); w in [0,1] spans the height. Surfaces may reach into neighbouring cells.
typedef struct kn_tile {
    char name[KN_NAME_BYTES];
    char about[2 * KN_NAME_BYTES]; // one line for a listing
    bool covering; // it covers the cell and replaces the base (definition 3 of the source); else casual
    double aspect; // height of w = 1 over the cell's width at which the tile looks as it was modelled
    kn_tile_part *parts;
    int nparts;
    kn_tile_parameter *parameters;
    int nparameters;
} kn_tile;

// A tile of nparts >= 1 empty parts. Everything in a tile belongs to it; out is overwritten, kn_tile_clear ends it.
// fails: KN_EDOMAIN nparts, KN_ELIMIT a name of KN_NAME_BYTES or more, KN_ENOMEM; out unchanged.
KN_API KN_CHECKED kn_status kn_tile_init(kn_ctx *ctx, kn_tile *out, const char *name, int nparts);
KN_API void kn_tile_clear(kn_ctx *ctx, kn_tile *tile);
// Appends a copy of the surface to a part. fails: KN_EDOMAIN no such part, KN_ENOMEM; the tile is then unchanged.
KN_API KN_CHECKED kn_status kn_tile_add(kn_ctx *ctx, kn_tile *tile, int part, const kn_spline *surface);
// KN_OK, or KN_EDOMAIN: the message names the part and the surface that is no polynomial (u,v,w) surface, not finite
// or of zero area (all coefficients of its r x t within their rounding of zero); or an aspect that is negative or not
// finite, or no surface at all. Also what kn_spline_check finds, and KN_ENOMEM.
KN_API KN_CHECKED kn_status kn_tile_check(kn_ctx *ctx, const kn_tile *tile);
// Quarter turns of the (u,v) cell about its centre, counterclockwise, any number: (u,v) -> (1-v, u), one rounding
// each. fails: KN_EDOMAIN a surface that is no polynomial (u,v,w) surface; the tile is then unchanged. Allocates
// nothing.
KN_API KN_CHECKED kn_status kn_tile_rotate(kn_ctx *ctx, kn_tile *tile, int quarter_turns);

#ifdef __cplusplus
}
#endif
#endif
