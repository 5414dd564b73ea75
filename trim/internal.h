// SPDX-License-Identifier: Apache-2.0
// Inside trim: the pieces of a boundary, and the lines that cut it.
#ifndef TRIM_INTERNAL_H
#define TRIM_INTERNAL_H

#include <knurl/trim.h>

// Below this parts of a cut are nothing.
#define KN_TRIM_SMALL 1e-12

// ---- check.c ----
// *area += the integral of x dy along the curve.
kn_status kn_trim_add_area(kn_ctx *ctx, double *area, const kn_spline *curve);

// ---- pieces.c ----
// First and last point of a curve; NULL: not wanted.
void kn_trim_ends(const kn_spline *curve, double start[2], double end[2]);
// A polyline through n >= 2 points, over [0, n - 1].
kn_status kn_trim_polyline(kn_ctx *ctx, kn_spline *out, const double *points, size_t n);

// A part of a region's boundary along which f does not change its sign.
typedef struct kn_trim_piece {
    kn_spline curve;
    int sign; // of f, -1 or 1
} kn_trim_piece;
typedef struct kn_trim_pieces {
    kn_trim_piece *list;
    int n, room;
    int *loop_end; // as kn_trim
    int nloops;
} kn_trim_pieces;
// ---- boundary.c ----
// The boundary of the region, cut at the roots of f. g: f without the factors that vanish along edges of the square.
kn_status kn_trim_boundary(kn_ctx *ctx, kn_trim_pieces *out, const kn_trim *trim, const kn_bezier *f,
                           const kn_bezier *g);
void kn_trim_pieces_clear(kn_ctx *ctx, kn_trim_pieces *pieces);

// ---- link.c ----
// A place where f changes its sign along the boundary.
typedef struct kn_trim_node {
    double at[2];
    int from, to; // the pieces that end and begin there
    bool enters;  // the line of zeros, run with f < 0 to its left, goes into the region here
    int other;    // the node at the other end of the line's part in the region
    int link;     // of links, from the one that enters to the other
    int curve;    // the line on which it lies, and where: segment + fraction
    double where;
} kn_trim_node;
// Parts of lines of zeros in the region, with f < 0 to their left: from node to node, and closed ones.
typedef struct kn_trim_links {
    kn_trim_node *nodes;
    int nnodes;
    kn_spline *curves; // those of the nodes first
    int ncurves, nlinks;
} kn_trim_links;
kn_status kn_trim_link(kn_ctx *ctx, kn_trim_links *out, const kn_trim_pieces *pieces, const kn_trim *trim,
                       const kn_bezier *g, double tol);
void kn_trim_links_clear(kn_ctx *ctx, kn_trim_links *links);

#endif
