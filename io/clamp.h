// SPDX-License-Identifier: Apache-2.0
// Inside io: the clamped form of a spline variable.
#ifndef IO_CLAMP_H
#define IO_CLAMP_H

#include <knurl/base.h>

// One variable of a coefficient array seen as (outer, count, inner), with count + degree + 1 knots, not decreasing,
// knots[degree] < knots[count], no value more than degree + 1 times. knots and coef are blocks of kn_alloc, and are
// exchanged for larger ones.
typedef struct kn_axis {
    int degree, count;
    size_t outer, inner;
    double *knots, *coef;
} kn_axis;

bool kn_axis_clamped(const kn_axis *axis);
// The same function over [knots[degree], knots[count]] with each end degree + 1 times in the knots, by knot insertion
// at the ends; what lies outside is dropped. fails: KN_ENOMEM; *axis is still the same function, perhaps with more
// knots.
KN_CHECKED kn_status kn_axis_clamp(kn_ctx *ctx, kn_axis *axis);

#endif
