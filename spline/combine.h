// SPDX-License-Identifier: Apache-2.0
// Operations on two or three splines: their common domain, their common pieces, and formulas of products on them.
#ifndef SPLINE_COMBINE_H
#define SPLINE_COMBINE_H

#include "bezier/combine.h"
#include "spline/internal.h"

// [lo,hi], nvars numbers each: the intersection of the n domains. KN_EDOMAIN (recorded) for an empty spline, other
// variables, or an intersection without interior.
kn_status kn_spline_overlap(kn_ctx *ctx, const char *call, double *lo, double *hi, const kn_spline *const *list,
                            int n);
// out = the formula of two or three splines (as many as it has) on the intersection of their domains, on the minimal
// knots. Dimensions are checked already; all else is checked here.
kn_status kn_spline_multiply(kn_ctx *ctx, const char *call, kn_spline *out, const kn_spline *const *operands,
                             const kn_formula *f);
// out = a + sign b (kn_spline_sum).
kn_status kn_spline_add(kn_ctx *ctx, const char *call, kn_spline *out, const kn_spline *a, const kn_spline *b,
                        double sign);

// Knots of variable var for pieces of [lo,hi], in scratch: the breaks of all splines there and the least continuity
// that they have at each; grid->times receives the continuity.
kn_status kn_spline_common_breaks(kn_ctx *ctx, kn_grid *grid, int var, const kn_spline *const *list, int n, double lo,
                                  double hi);

#endif
