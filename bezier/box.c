// SPDX-License-Identifier: Apache-2.0
// The box of the coefficients, over the unit box or any other.
#include "bezier/bounds.h"

kn_status kn_bezier_box(kn_ctx *ctx, double *box_lo, double *box_hi, const kn_bezier *a, const double *lo,
                        const double *hi)
{
    kn_hull hull;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_bezier_hull(ctx, "box", &hull, a, lo, hi);
    if (status == KN_OK) status = kn_hull_box(ctx, "box", box_lo, box_hi, &hull, kn_bezier_dim(a), a->rational);
    kn_scratch_release(ctx, mark);
    return status;
}
