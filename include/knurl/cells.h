// SPDX-License-Identifier: Apache-2.0
// Cells of one size on a surface whose parameterization stretches: even lines, free corners, rows of different
// counts, heights that follow the stretch, and how even the result is.
#ifndef KNURL_CELLS_H
#define KNURL_CELLS_H

#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

// Common to all below: surfaces have two variables and dimension 3, polynomial or rational (else KN_EDOMAIN). Outputs
// are unchanged by a call that fails. All but what says so may fail with KN_ENOMEM and with what kn_spline_check
// finds.

// ---- how even are cells? ----

// Of one quantity over all cells.
enum { KN_CELLS_BINS = 24 };
typedef struct kn_cells_range {
    double min, mean, max;
    size_t histogram[KN_CELLS_BINS]; // over [0, 3 mean), more goes into the last bin
} kn_cells_range;
typedef struct kn_cells_spread {
    size_t cells;
    // Of the images of cells on S: the mean of the two sides along u, of those along v, and the integral of
    // |S_u x S_v|.
    kn_cells_range width, height, area;
} kn_cells_spread;
// The cells of one surface: between lines[d][0 .. nlines[d]-1]; NULL: the knots.
typedef struct kn_cells_grid {
    const kn_spline *surface;
    const double *lines[2];
    int nlines[2];
} kn_cells_grid;
// Over the cells between lines (NULL, or either of them NULL: the knots) of a surface.
// in:     at least two lines each way, increasing, within the domain; cells need not end at knots.
// fails:  KN_EDOMAIN lines, a cell whose size is not finite; KN_ECANCELLED.
// error:  that of quadrature, no bound: Gauss's rules of 12 (a cell as large as a knot span) to 4 points (of a
//         sixteenth or less) each way, between knots. On quarter circles below 1e-10, 1e-9 for
//         a cell that is a whole one.
// cost:   16 to 144 values of S with its partials a cell, 2 us for small cells of a bicubic; 8 bytes a cell.
KN_API KN_CHECKED kn_status kn_cells_measure(kn_ctx *ctx, kn_cells_spread *out, const kn_spline *surface,
                                             const double *const lines[2], const int nlines[2]);
// Over the cells of several surfaces together. fails: also ngrids < 1.
KN_API KN_CHECKED kn_status kn_cells_measure_all(kn_ctx *ctx, kn_cells_spread *out, const kn_cells_grid *grids,
                                                 int ngrids);

// length[i], for each knot span of var: of the curve of S along var at the other parameter.
// fails:  KN_EDOMAIN var, at.
// error:  that of Gauss's rule of 8 points on quarters of spans. cost: 32 values a span.
KN_API KN_CHECKED kn_status kn_cells_span_lengths(kn_ctx *ctx, double *length, const kn_spline *surface, int var,
                                                  double at);

// ---- lines of one variable: a cell stays a rectangle of (u,v), so no degree grows ----

// *lines, count + 1 of them for kn_free: from one end of the domain to the other, all knots of S among them. A knot
// span gets cells in proportion to its size, but at least one; equal steps inside each.
// fails:  KN_EDOMAIN var, count below the knot spans.
// error:  a line between knots a < b is a + (b - a) (j / parts), three roundings.
KN_API KN_CHECKED kn_status kn_cells_uniform_lines(kn_ctx *ctx, double **lines, const kn_spline *surface, int var,
                                                   int count);
// The same, size and steps in length: with L(t) the length of S along var from the domain's start to t, averaged over
// the other variable, a knot span gets cells in proportion to its part of L, and inside it lines are at equal steps
// of L. So cells are as even as lines of one variable make them. A tile is only stretched, each cell by its own
// factors: what is C0 on equal cells stays so, and what is G1 where it crosses a line at right angles or lies flat
// there (its tangent plane contains the direction across the line); otherwise slopes on both sides differ as the
// widths do.
// fails:  KN_EDOMAIN var, count below the knot spans, no length, or lines so near that they fall together.
// error:  that of L: Gauss's rule of 10 points on eighths of each knot span and its interpolant in between, inverted
//         until steps are below 1e-15 of a span. Measured against closed forms: lines within 1e-12 of the domain.
// cost:   80 times 2 to 8 values for each box of knots; about 100 ns a line.
KN_API KN_CHECKED kn_status kn_cells_even_lines(kn_ctx *ctx, double **lines, const kn_spline *surface, int var,
                                                int count);
// One direction of a surface; reversed: the others run against it.
typedef struct kn_cells_along {
    const kn_spline *surface;
    int var;
    bool reversed;
} kn_cells_along;
// Even lines for n >= 1 directions together, so that cells meet on edges that surfaces share: L is the sum of theirs,
// and lines lie at the same places of each member's knot spans (bit for bit on equal knots, in the same direction).
// in:     the same knots, scaled to [0,1] and reversed as said, within 1e-6 (else KN_EDOMAIN).
// out:    lines[0 .. n-1], each as above.
KN_API KN_CHECKED kn_status kn_cells_shared_lines(kn_ctx *ctx, double **lines, const kn_cells_along *along, int n,
                                                  int count);

// ---- rows of different counts ----

// A band of rows across variable 1 that has its own number of cells along variable 0: where S narrows, as a cone.
typedef struct kn_cells_band {
    double lo, hi; // in variable 1
    int count[2];  // cells of the band
} kn_cells_band;
// *bands, *nbands of them for kn_free, from one end of variable 1 to the other: cells near size[0] x size[1]. Rows
// are those of kn_cells_even_lines; in a band the lengths of rows along variable 0 differ by at most a factor 3/2,
// and its count is the nearest to their geometric mean over size[0], or up to 15 % off where that suits the knot
// spans, so that widths are within 1.23 (1.42) of size[0], but for the rounding of small counts and where knot spans
// ask for more cells. At the border of two bands cells do not meet:
// tiles end there.
// in:     sizes positive and finite.
// fails:  KN_EDOMAIN sizes; KN_ELIMIT more than 65536 cells each way; and as kn_cells_even_lines.
// error:  as kn_cells_measure. cost: of the lines, and some us a row and knot span.
KN_API KN_CHECKED kn_status kn_cells_bands(kn_ctx *ctx, kn_cells_band **bands, int *nbands, const kn_spline *surface,
                                           const double size[2]);
// Bands of n >= 1 surfaces side by side, along[i].var 1 and as for kn_cells_shared_lines: the same rows and borders
// for all, each with its own counts. *bands: *nbands for each surface, one surface after the other, each in the order
// of its own variable 1.
KN_API KN_CHECKED kn_status kn_cells_shared_bands(kn_ctx *ctx, kn_cells_band **bands, int *nbands,
                                                  const kn_cells_along *along, int n, const double size[2]);

// ---- free corners ----

// Zero means the default in every field.
typedef struct kn_cells_relax_options {
    // Where corners begin: count[d] + 1 increasing numbers from one end of the domain to the other. NULL: even lines.
    const double *lines[2];
    bool fixed[2][2]; // [variable][end]: corners on that edge stay where the lines put them, to match a neighbour
    bool closed[2];   // corners of the two ends move together
    bool all_knots;   // lines stay on all knots of S, not only where it is C1 at most: for kn_cells_compose
    bool smooth;      // map: bicubic and C2, so that nothing has a kink at lines of cells but where S has one
    double area;      // how much even areas count beside even shapes, which count 1; 0: 4
    int iterations;   // 0: 200
} kn_cells_relax_options;
// map: (s,t) in [0,count[0]] x [0,count[1]] -> (u,v), bilinear in each cell (degree 1, simple knots at integers), or
// smooth (degree 3, the same knots), onto S's domain and nowhere folded (certified), whose cells are as nearly
// rectangles of one size on S as a search finds.
// in:     count[d] >= 1, and more than the knots whose lines are held, which lines given have to contain. options
//         NULL: the defaults.
// out:    corners on the edges of the domain stay on them, and its own four corners where they are. Lines of cells
//         stay on knots at which S is C1 at most (kinks, the quarters of circles), corners slide along them. The cell
//         that all should be has the mean area, and the proportion of the mean lengths of S both ways over the
//         counts. The energy of the corners is that of the lines at most. smooth: through the corners, which are
//         moved back to the lines as far as it takes to have no fold; C0 at knots where S is not C1; over the seam of
//         a closed variable it goes on as smoothly. The same bits every time.
// fails:  KN_EDOMAIN count, lines, options, a surface without area; KN_EUNDECIDED lines so near that a cell is not
//         certain to be without a fold at the start, or that no smooth map is; KN_ELIMIT, KN_ECANCELLED.
// cost:   about 1 us a cell and iteration; it ends when four in turn gain less than 1e-5 of the energy each. 40 x 40
//         cells of a patch of the teapot: 0.09 to 0.28 s, smooth.
// source: the exponentiated Hencky strain energy: Neff, Ghiba & Lankeit, J. Elasticity 121 (2015); L-BFGS: Nocedal &
//         Wright, Numerical Optimization, chapter 7.
KN_API KN_CHECKED kn_status kn_cells_relax(kn_ctx *ctx, kn_spline *map, const kn_spline *surface, const int count[2],
                                           const kn_cells_relax_options *options);
// out = S(map) exactly, by composition cell by cell: degree m (p + q), m the map's, p and q those of S, in both
// variables, C0 at the lines of a bilinear map.
// in:     map: polynomial, two components inside the domain of S, as kn_cells_relax gives it.
// out:    over the map's domain; rational if S is. May be an operand.
// fails:  KN_EDOMAIN the map, a cell that crosses a knot line of S (kn_cells_fit is for these; the message names it);
//         KN_ELIMIT m (p + q) above KN_MAX_DEGREE.
// error:  and cost: as kn_spline_compose.
KN_API KN_CHECKED kn_status kn_cells_compose(kn_ctx *ctx, kn_spline *out, const kn_spline *surface,
                                             const kn_spline *map);
typedef struct kn_cells_fit_options {
    double tolerance; // a length > 0
    double at_most;   // what *error may come to where degrees end before the tolerance is met; 0: the tolerance
    int degree_sum;   // of both degrees at most, 6 or more; 0: 14
} kn_cells_fit_options;
// out ~ S(map), one polynomial for each cell, of degrees 3 to 7, the least found by raising one after the other; the
// knots are the map's, so that cell lines may be its lines.
// in:     as kn_cells_compose; cells may cross knot lines of S, which does not jump (else KN_EDOMAIN).
// out:    interpolates S(map), as smooth across a line as that is, up to C2; an edge depends on S(map) on that edge
//         alone. *error >= |out - S(map)| over the whole domain, rounding included, and <= tolerance (or at_most).
//         NULL: not wanted. out may be an operand.
// fails:  KN_EDOMAIN also options; KN_EUNDECIDED the tolerance is not met in the degrees allowed, or it is below
//         about 1e-12 of the coordinates; KN_ECANCELLED, KN_ELIMIT.
// error:  *error: from coefficients of the difference with each polynomial of S that occurs in a cell; 1.2 to 2 times
//         the largest distance found by sampling.
// cost:   about 50 us a cell for each bound, more for cells that cross knot lines, and few bounds: 40 x 40 cells of a
//         patch of the teapot to 1e-5: 0.05 to 0.17 s.
KN_API KN_CHECKED kn_status kn_cells_fit(kn_ctx *ctx, kn_spline *out, double *error, const kn_spline *surface,
                                         const kn_spline *map, const kn_cells_fit_options *options);

// ---- height by stretch ----

typedef struct kn_cells_stretch_options {
    double mean;      // area of a cell where h is 1; 0: the mean of all cells
    int degree;       // of h, 1 to 3; 0: the lowest of them that meets the tolerance
    double tolerance; // of *error; 0: 0.05, or none where a degree is given
} kn_cells_stretch_options;
// out = h, one component over S's domain, positive, near the local stretch
//     t = ((a^2 + e^2) / (1 + e^2))^(1/4),  a = |S_u x S_v| du dv / mean,  e = 1/16,
// which is sqrt(a) but for small a: at a pole, where a is 0, heights end at a quarter. du(u) and dv(v) are the sizes
// of the cells, linear between lines and at a line the mean of the two cells there. With h as
// kn_shell_options.thickness tiles keep their proportions.
// in:     lines over the whole domain, every knot of S among them. options NULL: zeros.
// out:    degree 1 .. 3 in both variables, its knots the lines, each once; interpolates t at Greville's sites.
//         *error bounds |h - t| / t, rounding included.
// fails:  KN_EDOMAIN lines, options, no area; KN_EUNDECIDED tolerance not met, as where S has a crease or is scaled
//         so that its products overflow; KN_ELIMIT a polynomial S of degree above 13, a rational one of above 7;
//         KN_ECANCELLED.
// error:  *error. cost: about 40 us a cell of a bicubic S, for each degree that is tried.
KN_API KN_CHECKED kn_status kn_cells_stretch(kn_ctx *ctx, kn_spline *out, double *error, const kn_spline *surface,
                                             const double *const lines[2], const int nlines[2],
                                             const kn_cells_stretch_options *options);

#ifdef __cplusplus
}
#endif
#endif
