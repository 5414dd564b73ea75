// SPDX-License-Identifier: Apache-2.0
// Inside io: the curves of a trimmed patch as writers of CAD files need them, in the plane and in space over the same
// knots.
#ifndef IO_TRIM_EDGES_H
#define IO_TRIM_EDGES_H

#include "io/patch_net.h"

// Along an edge of the square the curve in space is the patch's own, restricted. Elsewhere it is a cubic for each
// segment of the trim (subdivided where it bends), which has the patch's points and derivatives along the trim at the
// ends: of fourth order, and C0 where the polyline has corners.
typedef struct kn_trim_edge {
    kn_patch_curve plane; // of degree 1 over the knots 0 .. n - 1; z = 0
    kn_patch_curve space;
    bool collapsed;
    int start; // the curve whose first point is its start: one that is no point
} kn_trim_edge;

// One for each curve of patch->trim, in scratch. net: the patch's.
KN_CHECKED kn_status kn_trim_edges(kn_ctx *ctx, kn_trim_edge **out, const kn_patch *patch, const kn_patch_net *net,
                                   double mm, const char *format);
// Twice the area inside the polylines of curves first .. last - 1: above 0 for outer loops.
double kn_trim_edges_area(const kn_trim_edge *edges, int first, int last);

#endif
