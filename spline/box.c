// SPDX-License-Identifier: Apache-2.0
// The box of the control points, which contains the spline by the convex hull property.
#include "bezier/bounds.h"
#include "spline/internal.h"

kn_status kn_spline_box(kn_ctx *ctx, double *lo, double *hi, const kn_spline *s)
{
    kn_status status = kn_spline_expect(ctx, "spline_box", s, 0);
    if (status != KN_OK) return status;
    kn_hull hull = {.n = kn_spline_count(s), .coef = s->coef};
    return kn_hull_box(ctx, "spline_box", lo, hi, &hull, kn_spline_dim(s), s->rational);
}
