// SPDX-License-Identifier: Apache-2.0
// Patches that cross knot lines of S, and not along parameter lines of their own.
#include "job/cross.h"

kn_status kn_job_cross(kn_ctx *ctx, bool *crossed, kn_job_cell_plan *plan, const kn_job_leaf *leaf,
                       const kn_job_place *place, const kn_bezier *d)
{
    kn_crossing x;
    bool few;
    kn_job_crossing way = plan->job->options.crossing;
    *crossed = false;
    kn_crossing_init(&few, &x, plan, leaf, place, d);
    if (!few) return KN_OK;
    if (d->nvars == 1) return kn_cross_curve(ctx, crossed, &x);
    if (d->nvars != 2 || way == KN_CROSSING_REFUSE) return KN_OK;
    bool one_box = x.n[0] == 0 && x.n[1] == 0; // exact, and nothing to trim
    return one_box || way == KN_CROSSING_TRIM ? kn_cross_trim(ctx, crossed, &x) : kn_cross_fit(ctx, crossed, &x);
}
