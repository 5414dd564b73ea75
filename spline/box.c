// SPDX-License-Identifier: Apache-2.0
// The box of the control points, which contains the spline by the convex hull property.
#include "spline/internal.h"
#include "kernel/context.h"

kn_status kn_spline_box(kn_ctx *ctx, double *lo, double *hi, const kn_spline *s)
{
    kn_status status = kn_spline_expect(ctx, "spline_box", s, 0);
    if (status != KN_OK) return status;
    size_t n = kn_spline_count(s);
    int dim = kn_spline_dim(s);
    const double *weight = s->rational ? s->coef + (size_t)dim * n : NULL;
    for (size_t i = 0; weight && i < n; i++)
        if (!(weight[i] > 0.0))
            return kn_fail(ctx, KN_EDOMAIN, "spline_box: control point %zu: weight %g", i, weight[i]);
    for (int c = 0; c < dim; c++)
        for (size_t i = 0; i < n; i++) {
            double x = s->coef[(size_t)c * n + i];
            if (weight) x /= weight[i];
            if (i == 0 || x < lo[c]) lo[c] = x;
            if (i == 0 || x > hi[c]) hi[c] = x;
        }
    return KN_OK;
}
