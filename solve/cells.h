// SPDX-License-Identifier: Apache-2.0
// Bezier pieces of splines on raw arrays, one at a time: what a cell needs, and no more.
#ifndef SOLVE_CELLS_H
#define SOLVE_CELLS_H

#include "solve/search.h"

// matrix (degree + 1)^2: the coefficients over [a,b], a part of a span, from the control points span - degree ..
// span.
void kn_extraction(double *matrix, const double *knots, int degree, int span, double a, double b);
// The prod_d (degree[d] + 1) control points of a component that act on a box of spans.
void kn_window(double *out, const kn_spline *s, int comp, const int *span);
// Applies one such matrix along each variable, in place; work: as many numbers as coef. error is raised by the
// rounding, gamma(6p + 1) for each variable; an identity costs and rounds nothing.
void kn_extract(double *coef, double *error, const int *degree, int nvars, const double *const *matrix, double *work);
// In place: degrees `to`. coef and work have room for the higher degrees.
void kn_raise(double *coef, double *error, int nvars, const int *from, const int *to, double *work);
// A break of full multiplicity: the pieces beside it need not agree.
bool kn_may_jump(const kn_spline *s);
// The cells of nf splines over one domain on which no control points exclude a common zero. Equations are scaled by
// powers of two, so that their largest control points lie in [1/2, 1). error: of the control points of each equation;
// NULL: none.
// residual: what counts as 0 of a scaled equation, where there are more of them than unknowns.
// fails:  as kn_solve_zeros.
kn_status kn_cells_of_splines(kn_ctx *ctx, kn_cells *cells, const kn_spline *f, int nf, const double *error,
                              double residual);
// The common zeros of functions that have such errors.
kn_status kn_zeros_within(kn_ctx *ctx, kn_root **roots, size_t *nroots, kn_solve_report *report, const kn_spline *f,
                          int nf, const double *error, const kn_solve_options *options);
// Where a(x) = b(y), of equal dimension: roots in the variables of a, then those of b.
kn_status kn_meet(kn_ctx *ctx, const char *what, kn_root **roots, size_t *nroots, kn_solve_report *report,
                  const kn_spline *a, const kn_spline *b, const kn_solve_options *options);

#endif
