// SPDX-License-Identifier: Apache-2.0
// Inside cells: a grid of cell corners on a surface, its distortion, and the search for less of it.
#ifndef CELLS_RELAX_H
#define CELLS_RELAX_H

#include <knurl/cells.h>

enum { KN_LINE_FREE, KN_LINE_HELD, KN_LINE_KINK };

// (n[0] + 1) x (n[1] + 1) corners, the last variable fastest, two numbers (u, v) each: corner (i,j) at
// corners[2 * (i * (n[1] + 1) + j)].
typedef struct kn_corner_grid {
    const kn_spline *surface;
    int n[2];
    bool closed[2];
    // held[d][i]: line i of variable d is a knot of S: its corners keep their place in variable d. The ends are not
    // held, but never leave the ends. KN_LINE_KINK: S is not C1 there, of the ends: not over the seam.
    char *held[2];
    bool fixed[2][2]; // corners on this edge do not move at all
    double *corners;
    double size[2]; // of the cell that all of them should be, along both variables
    double area;    // how much areas count beside shapes
} kn_corner_grid;

static inline size_t kn_corner_count(const kn_corner_grid *g)
{
    return (size_t)(g->n[0] + 1) * (size_t)(g->n[1] + 1);
}
// Whether corner (i,j) may move in variable d.
bool kn_corner_moves(const kn_corner_grid *g, int i, int j, int d);

// ---- relax_start.c ----
// Corners, held lines (in scratch) and the size of cells from lines that are given; NULL: even ones.
kn_status kn_relax_start(kn_ctx *ctx, kn_corner_grid *g, const double *const given[2], bool all_knots);

// ---- relax_energy.c ----
// Whether all cells of these corners are bilinear maps without a fold, certified.
bool kn_corners_unfolded(const kn_corner_grid *g, const double *corners);
// The mean distortion of cells with these corners, INFINITY where a cell has no area; gradient: two numbers a corner,
// what may not move 0, and what moves together counted at the lower end. room: kn_relax_room numbers.
kn_status kn_relax_energy(kn_ctx *ctx, double *energy, double *gradient, const kn_corner_grid *g,
                          const double *corners, double *room);
size_t kn_relax_room(const kn_corner_grid *g);

// ---- relax_search.c ----
// Moves g->corners downhill.
kn_status kn_relax_search(kn_ctx *ctx, kn_corner_grid *g, int iterations);

// ---- relax_smooth.c ----
// *map = the bicubic C2 spline through the corners, or through corners that are moved back to `start` until it has no
// fold. fails: KN_EUNDECIDED it has one even then.
kn_status kn_relax_smooth(kn_ctx *ctx, kn_spline *map, const kn_corner_grid *g, const double *start);

#endif
