// SPDX-License-Identifier: Apache-2.0
// Small trims, and the same borders as dense polygons.
#ifndef TESTS_SUPPORT_TRIMS_H
#define TESTS_SUPPORT_TRIMS_H

#include <knurl/trim.h>

enum { TRIMS_DENSE = 96 }; // points along one curve

// ---- made piece by piece ----
// A Bezier curve of degree 3 at most, at the end of the trim; and the end of a loop of such.
void trims_add_curve(kn_ctx *ctx, kn_trim *trim, int degree, const double *x, const double *y);
void trims_end_loop(kn_ctx *ctx, kn_trim *trim);
void trims_add_box(kn_ctx *ctx, kn_trim *trim, double x0, double y0, double x1, double y1);
// A closed curve of four cubics, nearly an ellipse; a hole runs clockwise.
void trims_add_oval(kn_ctx *ctx, kn_trim *trim, double cx, double cy, double a, double b, bool hole);

// ---- whole ----
void trims_plate_with_hole(kn_ctx *ctx, kn_trim *trim);
void trims_disc(kn_ctx *ctx, kn_trim *trim);
// Three sides of the square, of which two in part, and a border from (1, 0.3) to (0, 0.8) that bends both ways.
void trims_bay(kn_ctx *ctx, kn_trim *trim);

// ---- measured ----
// Of trims of Bezier curves of degree 3 at most. points: of trims_dense, TRIMS_DENSE + 1 for each curve; free().
double *trims_dense(const kn_trim *trim);
bool trims_is_inside(const kn_trim *trim, const double *points, double x, double y);
// Distance of (u,v) from the region, its sides included, in the plane of (2 u, 3 v).
double trims_off(const kn_trim *trim, const double *points, double u, double v);
double trims_area(const kn_trim *trim);

#endif
