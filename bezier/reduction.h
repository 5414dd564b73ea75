// SPDX-License-Identifier: Apache-2.0
// Degree reduction of pieces along one variable.
#ifndef BEZIER_REDUCTION_H
#define BEZIER_REDUCTION_H

#include "bezier/shape.h"

// *c (in scratch) = a with degree m in var; *exact is cleared unless the elevation of *c is a in exact arithmetic.
kn_status kn_bezier_reduce_axis(kn_ctx *ctx, kn_bezier *c, bool *exact, const kn_bezier *a, int var, int m);
// *error >= |low - a| over [0,1]^nvars, of values, rounding included; INFINITY where weights are not positive.
kn_status kn_bezier_reduction_error(kn_ctx *ctx, double *error, const kn_bezier *a, const kn_bezier *low);

#endif
