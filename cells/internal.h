// SPDX-License-Identifier: Apache-2.0
// Inside cells: quadrature, and lines in knot spans.
#ifndef CELLS_INTERNAL_H
#define CELLS_INTERNAL_H

#include <knurl/cells.h>

#include <math.h>

enum { KN_CELLS_POINTS = 12 }; // the most of a rule

// KN_OK for a surface in space that kn_spline_check accepts.
kn_status kn_cells_expect(kn_ctx *ctx, const char *call, const kn_spline *surface);
// KN_OK for n >= 2 finite increasing lines within the domain of variable var; all of it when `whole`.
kn_status kn_cells_expect_lines(kn_ctx *ctx, const char *call, const kn_spline *surface, int var, const double *lines,
                                int n, bool whole);
// KN_OK for a variable of the surface and a count of cells no smaller than its knot spans.
kn_status kn_cells_expect_count(kn_ctx *ctx, const char *call, const kn_spline *surface, int var, int count);
// KN_OK for a polynomial map of two variables, all of whose coefficients lie in the domain of the surface.
kn_status kn_cells_expect_map(kn_ctx *ctx, const char *call, const kn_spline *surface, const kn_spline *map);

// Abscissae and weights of Gauss's rule of m <= KN_CELLS_POINTS points on [0,1].
void kn_cells_gauss(double *x, double *w, int m);

// parts[i] >= 1 of spans, in proportion to sums[i + 1] - sums[i] >= 0, `count` >= spans together.
void kn_cells_share(int *parts, const double *sums, int spans, int count);

// The distinct knots of variable var, *n of them, in scratch; NULL: no memory.
double *kn_cells_breaks(kn_ctx *ctx, int *n, const kn_spline *surface, int var);

static inline double kn_cells_norm(const double *a)
{
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

// |a x b|
static inline double kn_cells_area(const double *a, const double *b)
{
    const double cross[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    return kn_cells_norm(cross);
}

#endif
