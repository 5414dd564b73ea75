// SPDX-License-Identifier: Apache-2.0
// Inside fold: the partials of T over a domain H made of boxes of one or two charts, as vectors that bound them.
#ifndef FOLD_MEET_SLOPES_H
#define FOLD_MEET_SLOPES_H

#include "fold/meet.h"

// Vectors whose means, each component within the error, are what column `column` of DT is on some part of H.
typedef struct kn_meet_vectors {
    struct kn_meet_vectors *next;
    int column;
    size_t n;
    double *x; // three arrays of n
    double error[3], size[3];
} kn_meet_vectors;

typedef struct kn_meet_hull {
    kn_meet *m;
    kn_meet_vectors *list;
    double jump;
    bool fits; // false: H cannot be treated
} kn_meet_hull;

// A box of one chart as part of H. The derivative in its variable d times scale[d] is one in variable column[d] of
// H.
typedef struct kn_meet_part {
    int chart, column[3];
    double lo[3], hi[3], scale[3];
    int pole, pole_end; // the variable that runs away from a pole, -1: none
    double across[2];   // y at lo and hi of the other variable
    // The variable that runs away from an edge that is one point, on the base or for each height, -1: none. T_u, u
    // the other one, is then given divided by the distance. fan: in variables that spread from the tip.
    int tip, tip_end;
    bool fan;
    double lift; // the distance from an apex is v + lift w
    // H may count a variable at another rate on each knot interval, so that |T_d| is about 1 on all of them: where it
    // is free to, rate[d] for the intervals from first[d] on, 0: not known yet.
    bool free[2];
    int first[2];
    double rate[2][KN_MEET_MOST];
} kn_meet_part;

// ---- meet_slopes.c ----
// Adds the partials over the part to the list, in scratch, and what T jumps inside it to the jump.
kn_status kn_meet_add_part(kn_meet_hull *h, kn_meet_part *p);

// ---- meet_wedge.c ----
// *apart: across the glue, whose bases' edges alone are the same, two boxes at the edge have only places of the edge
// in common, each with itself. Left as it is where that is not known.
kn_status kn_meet_wedge(kn_meet *m, bool *apart, const kn_meet_node *a, const kn_meet_node *b, const kn_meet_glue *g,
                        int first);

#endif
