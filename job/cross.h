// SPDX-License-Identifier: Apache-2.0
// Inside job: a patch over several knot boxes of S.
#ifndef JOB_CROSS_H
#define JOB_CROSS_H

#include "job/internal.h"

enum { KN_CROSS_LINES = 1 }; // knot lines that one patch crosses in each direction; with more it is bisected first

// One patch, or part of one, and the knot boxes that it meets: box (i, j) lies between lines i - 1 and i, j - 1 and
// j.
typedef struct kn_crossing {
    kn_job_cell_plan *plan;
    const kn_job_leaf *leaf;
    const kn_job_place *place;
    const kn_bezier *d;       // in the coordinates of the place's cell
    double lo[2], hi[2], top; // of u and v; max |w|
    int n[2];                 // lines
    double line[2][KN_CROSS_LINES];
    double end[2][2]; // of the domain, where D reaches over it and is cut off; infinite: none (kn_job_clip_ends)
    int piece[KN_CROSS_LINES + 1][KN_CROSS_LINES + 1]; // of plan->pieces
    int shift[KN_CROSS_LINES + 1][KN_CROSS_LINES + 1][2];
    double off; // of trims from lines, at most, in u or v
} kn_crossing;

// ---- cross_boxes.c ----
// *yes: there are few enough lines. Fills all but the pieces.
void kn_crossing_init(bool *yes, kn_crossing *x, kn_job_cell_plan *plan, const kn_job_leaf *leaf,
                      const kn_job_place *place, const kn_bezier *d);
// The piece of the shell over the part of the box (i, j) that d's box meets, and more. *fits: there is one, and d
// reaches not so far beyond it that rounding would matter.
kn_status kn_crossing_piece(kn_ctx *ctx, bool *fits, kn_crossing *x, int i, int j);
kn_status kn_crossing_pieces(kn_ctx *ctx, bool *fit, kn_crossing *x); // of all boxes
// The piece of box (i, j) as a function of (u, v) of the place's cell: from there to the box of the piece.
void kn_crossing_map(double origin[2], double width[2], const kn_crossing *x, int i, int j);

// ---- cross_gap.c ---- *gap >= the distance of T of the boxes on both sides of a line, for points within delta of
// the line in variable var (a power of two), and of w within x->top; rounding of the composition on both sides
// included. (i, j): the lower box.
kn_status kn_crossing_gap(kn_ctx *ctx, double *gap, const kn_crossing *x, int var, int i, int j, double delta);

// The same for the end of the domain at x->end[var][at]: how far T moves from there within delta. (i, j): the box.
kn_status kn_crossing_shift(kn_ctx *ctx, double *gap, const kn_crossing *x, int var, int at, int i, int j,
                            double delta);

// T of the box (i, j) moves by no more than *speed times the way in the (u,v) of the place's cell, over D's box there.
kn_status kn_crossing_speed(kn_ctx *ctx, double *speed, const kn_crossing *x, int i, int j);

// What rounding does to T(D), composed with the piece of box (i, j), and to its homogeneous coordinates.
double kn_crossing_rounding(const kn_crossing *x, int i, int j);

// ---- cross_clip.c ----
bool kn_cross_is_clipped(const kn_crossing *x);
// Cuts *trim, of D, at the ends of the domain, within crossing_tol. *any: there is something left. *fits: there are
// pieces, and the tolerance is met; else nothing else has changed.
kn_status kn_cross_clip(kn_ctx *ctx, bool *fits, bool *any, kn_trim *trim, kn_crossing *x);

// ---- cross_curve.c ----
// A curve of the tile: cut where it crosses.
kn_status kn_cross_curve(kn_ctx *ctx, bool *crossed, kn_crossing *x);
// ---- cross_trim.c ----
kn_status kn_cross_trim(kn_ctx *ctx, bool *crossed, kn_crossing *x);
// Cuts *rest at a line, to within delta of it: `below` gets what lies before it, *rest keeps the other part.
kn_status kn_cross_cut(kn_ctx *ctx, kn_trim *below, kn_trim *rest, kn_trim_cut_report *report, kn_crossing *x,
                       int var, double line, double delta);
// The same of a region along any line[0] u + line[1] v + line[2] = 0; x->off is left as it is. KN_EUNDECIDED:
// it cannot be done to within delta, or the cut touches the boundary.
kn_status kn_cross_cut_by(kn_ctx *ctx, kn_trim *below, kn_trim *above, kn_trim_cut_report *report,
                          const kn_crossing *x, const kn_trim *region, const double line[3], double delta);
// ---- cross_fit.c ----
// Chebyshev's extreme points in [0,1], symmetric and with both ends.
double kn_cross_site(int k, int degree);
kn_status kn_cross_fit(kn_ctx *ctx, bool *crossed, kn_crossing *x);

#endif
