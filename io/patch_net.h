// SPDX-License-Identifier: Apache-2.0
// Inside io: a surface patch as writers of CAD files need it: its points in millimetres, its knots, its four edges,
// and by which keys these meet others.
#ifndef IO_PATCH_NET_H
#define IO_PATCH_NET_H

#include <knurl/job.h>

#include "io/brep.h"

// One variable: distinct knots and how often each occurs.
typedef struct kn_patch_axis {
    int degree, n; // n control points
    int nbreaks;
    const int *times;
    const double *breaks;
} kn_patch_axis;

// A curve, an edge of a patch or by itself.
typedef struct kn_patch_curve {
    kn_patch_axis axis;
    const double *point; // of control point k at point + k * step: x, y, z in mm, weight
    ptrdiff_t step;
    bool rational;  // weights differ; else they are 1, or those that a patch has
    int first, by;  // which point of the patch control point k is: first + k * by; first -1: none
    double largest; // coordinate of a line that was loaded
} kn_patch_curve;

// Edge e runs from corner to corner with increasing r or t; corners: (r,t) = (0,0), (1,0), (1,1), (0,1).
//     edge 0: t = 0, edge 1: r = 1, edge 2: t = 1, edge 3: r = 0
// Counterclockwise the boundary runs along 0 and 1, and against 2 and 3.
typedef struct kn_patch_side {
    kn_patch_curve line;
    kn_brep_edge edge;
    bool turned;    // its key runs against it
    bool collapsed; // it is a point
    bool along;     // counterclockwise the boundary runs along its key
    int corner[2];  // points of the net where it starts and ends, in the direction of its key
} kn_patch_side;

typedef struct kn_patch_net {
    kn_patch_axis axis[2];
    int n; // control points, t fastest
    bool rational;
    const double *point; // n times x, y, z in mm, weight
    double same;         // points nearer than this are one
    bool closed[2];      // in each variable
    kn_patch_side side[4];
    kn_brep_key pair[4][2]; // of vertices that are one, because an edge between them is a point
    int npairs;
} kn_patch_net;

// Points nearer than this, in mm, are one point to the programs that read the file. largest: coordinate.
double kn_patch_same(double largest);
double kn_patch_knot(const kn_patch_axis *x, int k, bool turned); // turned: of the curve that runs the other way
// *axis of a spline's variable, in scratch.
KN_CHECKED kn_status kn_patch_axis_load(kn_ctx *ctx, kn_patch_axis *axis, const kn_spline *s, int var);
// *line: all control points of a spline, scaled and projected, and the axis of one variable, in scratch. format: for
// messages. fails: KN_EUNDEFINED (a weight that is not positive, a control point that is not finite), KN_ENOMEM.
KN_CHECKED kn_status kn_patch_curve_load(kn_ctx *ctx, kn_patch_curve *line, const kn_spline *s, int var, double mm,
                                         const char *format);
// By which both faces of an edge know it; *turned as kn_brep_hash.
kn_brep_key kn_patch_curve_key(bool *turned, const kn_patch_curve *line);
bool kn_patch_curve_collapsed(const kn_patch_curve *line, double same);
// *net of a surface patch, piece or spline, in scratch. fails: as kn_patch_curve_load.
KN_CHECKED kn_status kn_patch_net_load(kn_ctx *ctx, kn_patch_net *net, const kn_patch *patch, double mm,
                                       const char *format);
// out = edge e as a spline over [0,1], unscaled: initialised, overwritten.
KN_CHECKED kn_status kn_patch_side_spline(kn_ctx *ctx, kn_spline *out, const kn_patch *patch, int e);

#endif
