// SPDX-License-Identifier: Apache-2.0
// Inside tile: the Bezier pieces of a tile and which of their edges are one.
#ifndef TILE_NET_H
#define TILE_NET_H

#include "kernel/context.h"

#include <knurl/tile.h>

// A surface: a piece of a spline, a face of a volume that no other face meets, or a triangle: a bilinear piece whose
// edge r = 0 is one point.
typedef struct kn_tile_piece {
    kn_tile_edge place; // place.edge -1
    kn_bezier surface;
    bool inwards; // r x t points into the volume whose face it is
} kn_tile_piece;

// Side 2 var + end of piece i is sides[4 i + 2 var + end]; it runs with the other variable.
typedef struct kn_tile_side {
    int mate;      // a side; -1: none
    int nmates;    // how many there are
    int offset[2]; // cells by which the mate is moved to lie here
    bool reversed; // it runs the other way
    bool point;    // all of one control point
} kn_tile_side;

// End e of curve i is tips[2 i + e].
typedef struct kn_tile_curve {
    kn_tile_edge place;
    kn_bezier curve;
} kn_tile_curve;

typedef struct kn_tile_net {
    kn_tile_piece *pieces;
    kn_tile_curve *curves;
    kn_tile_side *sides, *tips; // tips: reversed and point are not used
    int npieces, ncurves, piece_room, curve_room;
    // Faces of volumes that have no mate and lie in a line u = integer [0] or v = integer [1]: the first one.
    kn_tile_edge torn[2];
    size_t ntorn[2], nfaces[3]; // pairs of faces that are one, by direction as kn_tile_periodicity_report's joints
    size_t unchecked;
} kn_tile_net;

enum { KN_TILE_SIDE_POINTS = KN_MAX_DEGREE + 1, KN_TILE_MAX_CELLS = 1 << 20 };

kn_status kn_tile_net_make(kn_ctx *ctx, kn_tile_net *out, const kn_tile *tile, double tolerance);
void kn_tile_net_clear(kn_ctx *ctx, kn_tile_net *net);
kn_status kn_tile_net_add(kn_ctx *ctx, kn_tile_net *net, kn_tile_piece *piece); // takes the surface
// The control points of a side, run along it; their number.
int kn_tile_side_points(double (*out)[3], const kn_tile_net *net, int side);
// Whether a joint's two pieces face the same way there.
bool kn_tile_side_agrees(const kn_tile_net *net, int side);
// The largest distance between a side and another one moved by offset, by their control points, rounding included; at
// which of n parameters k / (n - 1) it occurs.
double kn_tile_side_distance(const kn_tile_net *net, int a, int b, const int offset[2], bool reversed, double *at);
// Whether a point, or all of n points, lie in one line coordinate c = integer.
bool kn_tile_in_line(const double (*points)[3], int n, int c, double tolerance);
// The whole numbers by which b is nearest to a in u and in v; false when they are beyond KN_TILE_MAX_CELLS.
bool kn_tile_offset(int offset[2], const double a[3], const double b[3]);

// ---- faces.c ----
// Adds the faces of the volumes' pieces that no other face meets.
kn_status kn_tile_net_faces(kn_ctx *ctx, kn_tile_net *net, const kn_tile_piece *volumes, int n, double tolerance);

// ---- places.c ----
// Points by where they are, u and v up to whole numbers: a hash of boxes of 2^-16.
typedef struct kn_tile_places {
    const double (*points)[3];
    int *head, *next;
    size_t nheads, visits, most; // visits: compared so far; most: KN_ELIMIT beyond
} kn_tile_places;
kn_status kn_tile_places_make(kn_ctx *ctx, kn_tile_places *out, const double (*points)[3], int n);
void kn_tile_places_clear(kn_ctx *ctx, kn_tile_places *places);
// All points within about `reach` of point i, itself among them, and perhaps others: `visit` is called for each.
// fails: what visit answers, or KN_ELIMIT.
kn_status kn_tile_places_near(kn_ctx *ctx, kn_tile_places *places, const double point[3], double reach,
                              kn_status (*visit)(void *user, int j), void *user);

// ---- mates.c ----
// sides[].mate and tips[].mate of all.
kn_status kn_tile_net_join(kn_ctx *ctx, kn_tile_net *net, double tolerance);

// ---- joint.c ----
typedef struct kn_tile_joint {
    int order;    // that is proved: 0, 1 or 2
    bool decided; // the next one is refuted, or not asked for
    double at, amount;
} kn_tile_joint;
kn_status kn_tile_joint_order(kn_ctx *ctx, kn_tile_joint *out, const kn_tile_net *net, int side, double angle,
                              int most);

// ---- tip.c ----
kn_tile_joint kn_tile_tip_order(const kn_tile_net *net, int tip, double angle, int most);

#endif
