// SPDX-License-Identifier: Apache-2.0
// Splines in the making: chains of maps along variables that allocate nothing but what the result needs.
//
// A view is a kn_spline whose arrays belong to an operand or lie in scratch; it is never cleared. An operation starts
// with the operand itself as view, maps it variable by variable, and stores it in the end.
#ifndef SPLINE_VIEW_H
#define SPLINE_VIEW_H

#include "spline/internal.h"

// Room for a band with terms[] in scratch.
kn_status kn_view_band(kn_ctx *ctx, kn_band *band, int rows, int width);
// The view's coefficients become band's map of them, in new scratch; knots (rows + degree + 1, kept, not copied) take
// the place of var's. KN_ELIMIT as kn_spline_shape.
kn_status kn_view_map(kn_ctx *ctx, kn_spline *view, int var, int degree, double *knots, const kn_band *band);
// The view on the knots `to` of var, rows + degree + 1 of them, which it keeps (kn_band_refine).
kn_status kn_view_refine(kn_ctx *ctx, kn_spline *view, int var, double *to, int rows);
// The view with this degree in var, each knot as much more often (kn_band_elevate).
kn_status kn_view_elevate(kn_ctx *ctx, kn_spline *view, int var, int degree);
// The view with the knots of var and those of the sorted list `more` (clamped alike), each as often as either has it.
kn_status kn_view_union(kn_ctx *ctx, kn_spline *view, int var, const double *more, int n);
// out = the view, in out's own arrays where they have the right sizes. The view may use arrays of out, each in its
// own place. out is unchanged on failure.
kn_status kn_view_store(kn_ctx *ctx, kn_spline *out, const kn_spline *view);

#endif
