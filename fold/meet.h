// SPDX-License-Identifier: Apache-2.0
// Inside fold: what the search for places with one image works on. Charts are shells cut into Bezier pieces, glues
// say which edges of charts are one, nodes are boxes of parameters with boxes around their images.
#ifndef FOLD_MEET_H
#define FOLD_MEET_H

#include "kernel/context.h"
#include "solve/net.h"

#include <knurl/fold.h>

enum { KN_MEET_MOST = 64 }; // pieces that are looked at together

// T of one shell over its (u,v) and the heights that matter.
typedef struct kn_meet_chart {
    kn_spline volume;
    int nbreaks[3];
    double *breaks[3];
    kn_bezier *pieces; // (nbreaks - 1) of them in each variable, the last variable fastest
    size_t npieces;
    double error[4];  // of every coefficient, component by component
    double *jump[2];  // how far the pieces on the two sides of a break differ; INFINITY: too far to be one
    bool pole[2][2];  // [variable][end]: one point for each height
    bool apex[2][2];  // one point on the base, and not elsewhere
    double base;      // the height of the base
    bool flat_weight; // the weight does not depend on w
} kn_meet_chart;

// Edge `end` of variable `var` of two charts: the same places. Parameters along it run from end to end, against each
// other when reversed; w of the second is flip (1 or -1) times that of the first.
typedef struct kn_meet_glue {
    int chart[2], var[2], end[2];
    bool reversed;
    double flip;
    double base; // bound of the distance between the two edges of the bases
    double jump; // of that between the two faces; INFINITY: the edges of the bases alone are the same
} kn_meet_glue;

typedef struct kn_meet_node {
    int chart;             // -1: a group of nodes
    int child[2];          // -1: none yet
    int region;            // of which it is a part
    int first[3], last[3]; // the pieces that its box meets
    double lo[3], hi[3];   // parameters
    double length[3];      // of the image along each variable, roughly
    int cut;               // the variable to divide
    double size;           // diameter of the box around the image
    kn_oriented_box box;
} kn_meet_node;

typedef struct kn_meet {
    kn_ctx *ctx;
    kn_meet_chart *charts;
    int ncharts;
    kn_meet_glue *glues;
    size_t nglues, room_glues;
    kn_meet_node *nodes;
    size_t nnodes, room_nodes;
    int root;
    kn_fold_region *regions;
    size_t nregions;
    double whole;      // diameter of all images
    double resolution; // places nearer than this, along the shells, are one
    size_t boxes, work;
    bool hollow;  // the last pair lies at the two sides of an edge that could not be certified to open
    int attempts; // at witnesses there, whatever the boxes say
} kn_meet;

// Coefficients of T over a box: three components, or four homogeneous ones, and the bounds of their errors.
typedef struct kn_meet_patch {
    kn_net net;
    bool rational;
    double *coef;
    double error[4];
} kn_meet_patch;

// ---- meet_charts.c ----
kn_status kn_meet_charts(kn_meet *m, const kn_shell *const *shells, int nshells);
void kn_meet_clear(kn_meet *m);
// T at a place of a chart; partials (NULL: not wanted) one after the other.
kn_status kn_meet_point(kn_meet *m, double point[3], double partials[9], int chart, const double uvw[3]);
// T over the part of a piece (its place among the pieces in each variable) in the box [lo,hi] of parameters, or a
// little more: *from, *to receive the box that it is. *out in scratch, which the caller releases.
kn_status kn_meet_restrict(kn_meet *m, kn_meet_patch *out, double from[3], double to[3], int chart, const int at[3],
                           const double lo[3], const double hi[3]);
// Range [first,last] of the pieces that overlap [lo,hi] in a variable.
void kn_meet_overlap(const kn_meet_chart *c, int var, double lo, double hi, int *first, int *last);

// ---- meet_glue.c ----
kn_status kn_meet_glues(kn_meet *m);

// ---- meet_tree.c ----
kn_status kn_meet_tree(kn_meet *m);
// Control points of T over a node, projected: three arrays of `room`.
typedef struct kn_meet_cloud {
    double *x;
    size_t room, n;
    double slack; // how far a point of T may be from the means of control points, in each component
    double error; // of the control points, relative
} kn_meet_cloud;
// *out in scratch, which the caller releases. Finds the node's lengths and where to cut it, too.
kn_status kn_meet_gather(kn_meet *m, kn_meet_cloud *out, kn_meet_node *node);
static inline bool kn_meet_is_piece(const kn_meet_node *n)
{
    return n->chart >= 0 && n->first[0] == n->last[0] && n->first[1] == n->last[1] && n->first[2] == n->last[2];
}
// Makes the two children of a node that has none yet.
kn_status kn_meet_split(kn_meet *m, int index);

// ---- meet_apart.c ----
// Whether the boxes, each taken `shrink` times as large, have a plane between them.
bool kn_meet_separate(const kn_oriented_box *a, const kn_oriented_box *b, double shrink);
// *apart: control points of the two nodes have a plane between them. Nodes of a few pieces alone are looked at.
kn_status kn_meet_plane(kn_meet *m, bool *apart, int a, int b);
// Two nodes that share a fibre (a corner of their (u,v), or a pole) or its point on the base (or an apex): *apart when
// a plane through it keeps all else of them apart.
kn_status kn_meet_fibre(kn_meet *m, bool *apart, int a, int b);

// ---- meet_local.c ----
// *injective: T has no two places with one image in the convex hull of both boxes (a may be b), in the parameters of
// one chart or of two glued ones.
kn_status kn_meet_injective(kn_meet *m, bool *injective, int a, int b);

// ---- meet_witness.c ----
// Tries to find two places with one image near the middles of two nodes.
kn_status kn_meet_witness(kn_meet *m, kn_fold_intersection *out, bool *found, int a, int b);

#endif
