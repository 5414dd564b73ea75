// SPDX-License-Identifier: Apache-2.0
// Cells of one size on a surface whose parameterization stretches: even lines, free corners, rows of different counts,
// heights that follow the stretch, and how even the result is.
#ifndef KNURL_CELLS_H
#define KNURL_CELLS_H

#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

// ---- how even are cells? ----

// Of one quantity over all cells.
enum { KN_CELLS_BINS = 24 };
typedef struct kn_cells_range {
    double min, mean, max;
    size_t histogram[KN_CELLS_BINS]; // over [0, 3 mean), more goes into the last bin
} kn_cells_range;
typedef struct kn_cells_spread {
    size_t cells;
    kn_cells_range width, height,
        area; // of the images of cells on S: mean of opposite sides; integral of |S_u x S_v|
} kn_cells_spread;
// Over the cells between lines (NULL: the knots) of a surface.
KN_API KN_CHECKED kn_status kn_cells_measure(kn_ctx *ctx, kn_cells_spread *out, const kn_spline *surface,
                                             const double *const lines[2], const int nlines[2]);

// ---- even lines: a cell stays a rectangle of (u,v), so no degree grows ----

// lines[0 .. count]: from one end of the domain to the other, all knots of S among them, placed so that cells are as
// even as lines of one variable can make them: equal shares of the mean length of S along var, knot spans rounded.
// fails: KN_EDOMAIN count below the knot spans.
KN_API KN_CHECKED kn_status kn_cells_even_lines(kn_ctx *ctx, double **lines, const kn_spline *surface, int var,
                                                int count);

// ---- rows of different counts ----

// The surface cut across variable 1 into bands, each with its own number of cells along variable 0, so that cells stay
// near size[0] x size[1]: a cone. From band to band counts change by what the lengths ask for.
typedef struct kn_cells_band {
    double lo, hi; // in variable 1
    int count[2];  // cells of the band
} kn_cells_band;
KN_API KN_CHECKED kn_status kn_cells_bands(kn_ctx *ctx, kn_cells_band **bands, int *nbands, const kn_spline *surface,
                                           const double size[2]);

// ---- free corners ----

typedef struct kn_cells_relax_options {
    bool closed[2];   // corners of the two ends move together
    bool fixed_edges; // corners on the edges of the domain stay where even lines put them (to match a neighbour)
    int iterations;   // 0: 200
} kn_cells_relax_options;
// map: (s,t) in [0,count[0]] x [0,count[1]] -> (u,v), bilinear in each cell (degree 1, simple knots at integers), onto
// S's domain and nowhere folded (certified), of least isometric distortion of S(map) for square cells.
KN_API KN_CHECKED kn_status kn_cells_relax(kn_ctx *ctx, kn_spline *map, const kn_spline *surface, const int count[2],
                                           const kn_cells_relax_options *options);
// out = S(map) exactly, by composition cell by cell: degree p + q of S in both variables, C0 at the cell lines.
// fails: KN_EDOMAIN a cell that crosses a knot line of S (kn_cells_fit is for these).
KN_API KN_CHECKED kn_status kn_cells_compose(kn_ctx *ctx, kn_spline *out, const kn_spline *surface,
                                             const kn_spline *map);
// out ~ S(map): bicubic over the cells (more spans where the tolerance asks for them), *error a certified bound of the
// distance |out - S(map)|.
// fails: KN_EUNDECIDED tolerance not met.
KN_API KN_CHECKED kn_status kn_cells_fit(kn_ctx *ctx, kn_spline *out, double *error, const kn_spline *surface,
                                         const kn_spline *map, double tolerance);

// ---- height by stretch ----

// out: one component over S's domain, a spline near the local stretch sqrt(|S_u x S_v| du dv / mean), du x dv the cell
// at hand between the lines: with it as kn_shell_options.thickness tiles keep their proportions. *error: certified bound
// of the relative difference.
KN_API KN_CHECKED kn_status kn_cells_stretch(kn_ctx *ctx, kn_spline *out, double *error, const kn_spline *surface,
                                             const double *const lines[2], const int nlines[2], double tolerance);

#ifdef __cplusplus
}
#endif
#endif
