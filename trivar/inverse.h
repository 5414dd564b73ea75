// SPDX-License-Identifier: Apache-2.0
// What the inverse of a shell holds: T cut into leaves on which Newton's method is safe, and their boxes in space.
#ifndef TRIVAR_INVERSE_H
#define TRIVAR_INVERSE_H

#include "solve/search.h"

#include <knurl/shell.h>

enum { KN_LEAF_NODE = 4 }; // leaves of one node of the hierarchy, at most

// One piece of T over a box of (u,v,w): its coefficients are those of its number. Its points x satisfy
// least <= to x <= most: a parallelepiped that T's middle is nearly mapped to a box by.
typedef struct kn_leaf {
    double lo[3], hi[3];             // in (u,v,w)
    double space_lo[3], space_hi[3]; // in space
    double to[9], least[3], most[3];
} kn_leaf;

// Leaves order[first .. first + count - 1], or two nodes: the next one and `other`.
typedef struct kn_leaf_node {
    double lo[3], hi[3];
    size_t first, count, other;
} kn_leaf_node;

// An end of variable var at which T does not depend on the other variable: T = axis(w) there. One for each of T's
// pieces along that end.
typedef struct kn_pole {
    int var, end;
    double lo[3], hi[3]; // the part of the domain that no leaf covers: next to the end
    kn_bezier axis;      // of w over its interval, homogeneous when T is rational
    kn_bezier slope;     // of the other variable and w: the derivative of T's homogeneous coordinates along var,
                         // inwards
    double space_lo[3], space_hi[3]; // of the axis, reach included
    double error;                    // of the coefficients of T beside it
    double reach;                    // bound of |T - axis|
    double slope_error;              // of slope's coefficients, and of its change across the part
} kn_pole;

struct kn_shell_inverse {
    double scale;   // a power of two: all below is in these units of length
    bool rational;  // leaves hold three coordinates, or four homogeneous ones
    bool jumps;     // T need not be continuous
    bool closed[2]; // the ends across this variable coincide, w by w
    int depth;      // halvings of a brick, at most
    kn_net net;     // of the leaves, ncomp 3 or 4
    double lo[3], hi[3];
    size_t nleaves, room, nnodes, npoles, pole_room;
    kn_leaf *leaf;
    double *coef;  // net.ncomp * net.count for each leaf
    double *error; // net.ncomp for each leaf
    size_t *order;
    kn_leaf_node *node;
    kn_pole *pole;
};

// out[3 count] = P - p W, and its errors: the coordinates of one piece, coef and error being its own.
void kn_leaf_shift(double *out, double *out_error, const kn_net *net, const double *coef, const double *error,
                   const double point[3]);

// ---- leaves.c ----
// A Bezier piece of T over the box [lo,hi] of (u,v,w).
typedef struct kn_brick {
    const double *coef; // net.ncomp * net.count numbers
    double error[4], lo[3], hi[3];
    bool pole[2][2]; // [variable][end]: T does not depend on the other variable there
} kn_brick;
// Adds the leaves of one brick to the inverse, and what is next to its poles.
kn_status kn_leaves_add(kn_ctx *ctx, kn_shell_inverse *inverse, const kn_brick *brick);

#endif
