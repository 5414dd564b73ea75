// SPDX-License-Identifier: Apache-2.0
// Clamped knots with equal spans.
#include <math.h>

#include "fit/internal.h"
#include "kernel/context.h"
#include "spline/internal.h"

kn_status kn_fit_uniform_knots(kn_ctx *ctx, double *knots, int degree, int count, double lo, double hi)
{
    kn_status status = kn_spline_shape(ctx, "fit_uniform_knots", 1, 1, false, &degree, &count);
    if (status != KN_OK) return status;
    int spans = count - degree;
    double step = (hi - lo) / spans;
    if (!(step > 0.0) || !isfinite(hi - lo) || lo + step == lo || hi - step == hi)
        return kn_fail(ctx, KN_EDOMAIN, "fit_uniform_knots: %d spans of [%g, %g]", spans, lo, hi);
    for (int i = 0; i <= count + degree; i++) {
        int k = i - degree;
        knots[i] = k <= 0 ? lo : k >= spans ? hi : lo + (hi - lo) * ((double)k / spans);
    }
    return KN_OK;
}
