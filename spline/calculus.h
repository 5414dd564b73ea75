// SPDX-License-Identifier: Apache-2.0
// What gradient, divergence and bounds of splines share.
#ifndef SPLINE_CALCULUS_H
#define SPLINE_CALCULUS_H

#include "spline/internal.h"

// In place, new arrays in scratch: the derivative of every component in var, degree[var] > 0. error: gamma(4)|c_k|.
kn_status kn_spline_differentiate_in_scratch(kn_ctx *ctx, kn_spline *s, int var);
// The grid on which all first partials of a lie at a's degrees: interior knots once more often, at most degree + 1
// times. *to = a's shape with these knots; coefficients NULL; all in scratch.
kn_status kn_spline_partial_knots(kn_ctx *ctx, kn_spline *to, const kn_spline *a);
// out = the derivative of component comp of a in var on that grid; kn_spline_count(grid) numbers. Takes scratch.
kn_status kn_spline_partial(kn_ctx *ctx, double *out, const kn_spline *a, int comp, int var, const kn_spline *grid);

#endif
