// SPDX-License-Identifier: Apache-2.0
// Inside mesh: triangles over a trimmed region of the plane.
#ifndef MESH_TRIMMED_H
#define MESH_TRIMMED_H

#include "kernel/context.h"

#include <knurl/mesh.h>

// Points in the plane in closed loops, the region to the left. Loop i: points loop_end[i - 1] .. loop_end[i] - 1.
typedef struct kn_outline {
    double (*at)[2];
    int n, room;
    int *loop_end;
    int nloops;
} kn_outline;
typedef struct kn_triangles {
    int (*corner)[3];
    int n, room;
} kn_triangles;

// ---- outline.c ---- A trim's loops as points, at steps of the grid or less: along edges of the square at the
// grid's lines, on other curves at places that depend on the curve and the segments alone, whichever way it runs. On
// failure *out may hold a part; kn_outline_clear it in any case.
kn_status kn_outline_sample(kn_ctx *ctx, kn_outline *out, const kn_trim *trim, const int segments[2]);
kn_status kn_outline_add(kn_ctx *ctx, kn_outline *out, const double at[2]);
void kn_outline_clear(kn_ctx *ctx, kn_outline *outline);
// Whether loops wind around the point; in doubles.
bool kn_outline_contains(const kn_outline *outline, double r, double t);

// ---- polygon.c ----
// Twice the signed area of the triangle, 0 where rounding hides its sign.
double kn_turn(const double *a, const double *b, const double *c);
// Triangles that fill the region, all of whose points are corners; appended. KN_EUNDECIDED: loops cross.
kn_status kn_outline_triangulate(kn_ctx *ctx, kn_triangles *out, const kn_outline *outline);

#endif
