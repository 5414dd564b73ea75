// SPDX-License-Identifier: Apache-2.0
// Inside cad: whether two faces go on into one another over an edge.
#ifndef CAD_JOIN_H
#define CAD_JOIN_H

#include <knurl/cad.h>

// Parameters and weights this near are one.
#define KN_CAD_SAME 1e-8

// Sides of a surface: 0 and 1 at the ends of u, along v; 2 and 3 at the ends of v.
typedef struct kn_cad_match {
    int side[2];   // of each face; -1: the edge is none
    bool reversed; // the sides run in opposite directions
    double angle;
    const char *why; // they do not match; NULL: they do
} kn_cad_match;

// ---- join_match.c ----
kn_status kn_cad_match_edge(kn_ctx *ctx, kn_cad_match *out, const kn_cad *cad, int edge,
                            const kn_cad_join_options *options);
// The curve along a side, over [0,1].
kn_status kn_cad_side_curve(kn_ctx *ctx, kn_spline *out, const kn_spline *surface, int side);

#endif
