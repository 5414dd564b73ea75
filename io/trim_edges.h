// SPDX-License-Identifier: Apache-2.0
// Inside io: the curves of a trimmed patch as writers of CAD files need them, in the plane and in space over the same
// domain, by which keys they meet others, and which holes are in which outer loops.
#ifndef IO_TRIM_EDGES_H
#define IO_TRIM_EDGES_H

#include "io/patch_net.h"

// Of an edge that the patch's bounds tell, the curves are those, and only edges of the same number meet it. Else, along
// an edge of the square, the curve in space is the patch's own, restricted, so that neighbours which end there alike
// have the same one. Elsewhere it is a cubic for each segment of the trim (subdivided where it bends), which has the
// patch's points and derivatives along the trim at the ends: of fourth order, and C0 where the polyline has corners.
typedef struct kn_trim_edge {
    kn_patch_curve plane; // z = 0
    kn_patch_curve space;
    bool against;      // the loop runs against the curves
    bool collapsed;    // it is a point, and no edge
    kn_brep_edge edge; // of others: all but the pcurve
    bool turned;       // its key runs against the curves
    double at[2][3];   // its vertices, mm, in the direction of its key
    int line;          // on which points the polyline of the trim's curve has that tell inside from outside
    int nline;
} kn_trim_edge;

typedef struct kn_trim_loop {
    int first, last; // edges first .. last - 1
    bool outer;      // the holes in it follow
} kn_trim_loop;

typedef struct kn_trim_edges {
    kn_trim_edge *edge; // one for each curve of the trim
    kn_trim_loop *loop; // those that have an edge
    int nloops;
    kn_brep_key (*pair)[2]; // of vertices that are one, because a curve between them is a point
    int npairs;
    double (*line)[2];
} kn_trim_edges;

// In scratch. net: the patch's. fails: KN_EDOMAIN bounds that do not fit the trim; KN_EUNDEFINED as kn_patch_curve_load;
// KN_ENOMEM.
KN_CHECKED kn_status kn_trim_edges_load(kn_ctx *ctx, kn_trim_edges *out, const kn_patch *patch,
                                        const kn_patch_net *net, double mm, const char *format);

#endif
