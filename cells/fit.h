// SPDX-License-Identifier: Apache-2.0
// Inside cells: a spline that stands for S(map), and the bound of its distance.
#ifndef CELLS_FIT_H
#define CELLS_FIT_H

#include <knurl/cells.h>

// Surface, map and fit as pieces over their knot spans; brk: the distinct knots, last variable fastest.
typedef struct kn_piece_grid {
    kn_bezier *piece;
    size_t npieces;
    double *brk[2]; // in scratch
    int n[2];       // spans
} kn_piece_grid;
kn_status kn_piece_grid_init(kn_ctx *ctx, kn_piece_grid *g, const kn_spline *s);
void kn_piece_grid_clear(kn_ctx *ctx, kn_piece_grid *g);
// Whether the derivatives of a surface in variable d agree on both sides of knot line i, 0: of the seam, whatever the
// knots say.
kn_status kn_piece_grid_is_c1(kn_ctx *ctx, bool *yes, const kn_piece_grid *s, int d, int i);

// What is fitted, and on which lines.
typedef struct kn_cells_target {
    const kn_spline *surface, *map;
    kn_piece_grid s, m; // their pieces
    int n[2];           // cells
    double *lines[2];   // distinct knots of map, in scratch
    int *smooth[2];     // how often S(map) is differentiable across each, 2 at most; of a seam: at both ends
    bool closed[2];     // the two edges across this variable are one, and S(map) goes on over it
} kn_cells_target;
// ---- fit_lines.c ----
kn_status kn_cells_target_init(kn_ctx *ctx, kn_cells_target *f, const kn_spline *surface, const kn_spline *map);
void kn_cells_target_clear(kn_ctx *ctx, kn_cells_target *f);

// ---- fit_bound.c ----
// *bound >= |fit - S(map)| over the whole domain, rounding included; INFINITY where none was found. fit: on the knots
// of map. sampled: a distance that occurs, 0 for none.
kn_status kn_cells_fit_bound(kn_ctx *ctx, double *bound, const kn_spline *fit, const kn_piece_grid *surface,
                             const kn_piece_grid *map, double sampled);

#endif
