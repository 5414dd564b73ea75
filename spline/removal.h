// SPDX-License-Identifier: Apache-2.0
// Removing knots along one variable, with the coefficients as rows.
#ifndef SPLINE_REMOVAL_H
#define SPLINE_REMOVAL_H

#include "spline/internal.h"

// A spline seen along one variable: row i holds what belongs to coefficient i, `lines` points of ncomp components.
typedef struct kn_rows {
    int count, degree, ncomp;
    bool rational;
    size_t lines;
    double *knots; // count + degree + 1
    double *row;   // count rows of lines * ncomp numbers
} kn_rows;

// Copies of the knots and coefficients of s along var, in scratch.
kn_status kn_rows_of(kn_ctx *ctx, kn_rows *rows, const kn_spline *s, int var);
// The way back: s, of the same shape but for var, gets these rows in scratch.
kn_status kn_rows_to(kn_ctx *ctx, kn_spline *s, int var, const kn_rows *rows);
// Removes interior knots as kn_spline_remove_knots says, those at `only` alone unless that is NaN. *error as there.
// In place.
kn_status kn_rows_remove(kn_ctx *ctx, const char *call, kn_rows *rows, double *error, double tolerance, double only);
// KN_OK, or KN_EDOMAIN: a tolerance that is negative or no number.
kn_status kn_spline_expect_tolerance(kn_ctx *ctx, const char *call, double tolerance);

// *bound >= |f - g| over the whole domain, and local[i], i < f's count, the same where B-spline i of f is not zero
// (NULL: not wanted), for g on some of f's knots: Euclidean norm of the difference of values, projected when
// rational. INFINITY where a weight is not positive. KN_ENOMEM.
kn_status kn_rows_distance(kn_ctx *ctx, double *bound, double *local, const kn_rows *f, const kn_rows *g);

#endif
