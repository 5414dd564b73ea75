// SPDX-License-Identifier: Apache-2.0
// More maps of temporary splines whose arrays lie in scratch or are borrowed (spline/internal.h says how they live).
#ifndef SPLINE_IN_SCRATCH_H
#define SPLINE_IN_SCRATCH_H

#include "spline/internal.h"

// s with this degree, not below its own, in var, each knot as much more often.
kn_status kn_spline_elevate_in_scratch(kn_ctx *ctx, kn_spline *s, int var, int degree);
// The control points in var of s raised to this degree, INT_MAX for more.
int kn_spline_elevated_count(const kn_spline *s, int var, int degree);
// The map to `degree` > p of splines of degree p on knots, with its divisor; *to, in scratch, are the new knots.
kn_status kn_spline_elevation_band(kn_ctx *ctx, kn_band *band, double **to, double *knots, int p, int count,
                                   int degree);
// s with the knots of var and those of the sorted list `more`, none of them outside the domain, each as often as
// either has it. Nothing happens where s has them all.
kn_status kn_spline_unite_in_scratch(kn_ctx *ctx, kn_spline *s, int var, const double *more, int n);
// Variable var[i] of s[i], of one domain, gets one degree, the highest or `least`, and the union of all knots.
kn_status kn_spline_unite_all_in_scratch(kn_ctx *ctx, kn_spline *s, const int *var, int n, int least);
// s over [lo,hi] in var (kn_spline_restrict).
kn_status kn_spline_restrict_in_scratch(kn_ctx *ctx, kn_spline *s, int var, double lo, double hi);
// outs[i] = s[i] for all i < n, or none of them; as kn_spline_store. s[i] may borrow from any of the outs.
// Outs differ.
kn_status kn_spline_store_all(kn_ctx *ctx, kn_spline *const *outs, const kn_spline *s, int n);

#endif
