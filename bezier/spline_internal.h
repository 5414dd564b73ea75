// SPDX-License-Identifier: Apache-2.0
// What the operations on kn_spline share: storage, and maps along one variable.
#ifndef BEZIER_SPLINE_INTERNAL_H
#define BEZIER_SPLINE_INTERNAL_H

#include <knurl/spline.h>

#include "kernel/knots.h"

// KN_OK when these numbers are a legal shape, else KN_EDOMAIN or KN_ELIMIT, recorded under the name of the call.
kn_status kn_spline_shape(kn_ctx *ctx, const char *call, int nvars, int ncomp, bool rational, const int *degree,
                          const int *count);
// *out = a spline of this (legal) shape with its arrays allocated and not filled.
kn_status kn_spline_alloc(kn_ctx *ctx, kn_spline *out, int nvars, int ncomp, bool rational, const int *degree,
                          const int *count);
// KN_OK when s is not empty and 0 <= var < nvars.
kn_status kn_spline_expect(kn_ctx *ctx, const char *call, const kn_spline *s, int var);
// The array of one component seen along var is (outer, count[var], inner).
size_t kn_spline_inner(const kn_spline *s, int var);
size_t kn_spline_outer(const kn_spline *s, int var); // components included

// Room for a band in scratch.
kn_status kn_spline_band(kn_ctx *ctx, kn_band *band, int rows, int width);
// Applies band along var in place; knots (band->rows + degree + 1) replace those of var. s is unchanged on failure.
kn_status kn_spline_map(kn_ctx *ctx, kn_spline *s, int var, int degree, const double *knots, const kn_band *band);
// In place: the same function on the knots `to` of var, rows + degree + 1 of them (kn_band_refine).
kn_status kn_spline_refine(kn_ctx *ctx, kn_spline *s, int var, const double *to, int rows);
// In place: every knot of var that lies on breaks gets multiplicity degree + 1. breaks contain the knots of var.
kn_status kn_spline_split_at(kn_ctx *ctx, kn_spline *s, int var, const double *breaks, int nbreaks);
// In place, the way back: var of s is split at breaks (kn_spline_split_at); break i keeps times[i] knots, the first
// and last degree + 1.
kn_status kn_spline_join(kn_ctx *ctx, kn_spline *s, int var, const double *breaks, const int *times, int nbreaks);

#endif
