// SPDX-License-Identifier: Apache-2.0
// Degree reduction of splines along one variable.
#ifndef SPLINE_REDUCTION_H
#define SPLINE_REDUCTION_H

#include "spline/internal.h"

// s (arrays in scratch or borrowed) gets degree q in var, below its own; *same is cleared unless elevation gives the
// old knots and coefficients again, bit for bit.
kn_status kn_spline_reduce_axis(kn_ctx *ctx, kn_spline *s, bool *same, int var, int q);
// *error >= |low - a| over the domain, of values, rounding included; INFINITY where weights are not positive.
kn_status kn_spline_reduction_error(kn_ctx *ctx, double *error, const kn_spline *a, const kn_spline *low);

#endif
