// SPDX-License-Identifier: Apache-2.0
// Patches that cross knot lines of S, or ends of its domain that cut them off, and not along parameter lines of their
// own.
#include "job/border.h"
#include "job/cross.h"

// What is left of the part between the ends, by the way that was chosen.
static kn_status make(kn_ctx *ctx, bool *crossed, kn_crossing *x)
{
    bool one_box = x->n[0] == 0 && x->n[1] == 0, trims = x->plan->job->options.crossing == KN_CROSSING_TRIM;
    return x->d->nvars == 2 && (one_box || trims) ? kn_cross_trim(ctx, crossed, x) : kn_cross_fit(ctx, crossed, x);
}

// The same of what goes into the trimmed base.
static kn_status make_trimmed(kn_ctx *ctx, bool *crossed, kn_crossing *x, kn_job_leaf *part)
{
    kn_job_regions regions = {0};
    bool fit;
    kn_status status = kn_crossing_pieces(ctx, &fit, x);
    if (status != KN_OK || !fit) return status;
    status = kn_job_border_cut(ctx, &regions, x, &part->trim);
    *crossed = true;
    for (int i = 0; status == KN_OK && *crossed && i < regions.n; i++) {
        kn_trim_clear(ctx, &part->trim);
        part->trim = regions.list[i];
        regions.list[i] = (kn_trim){0};
        status = make(ctx, crossed, x);
    }
    kn_job_regions_clear(ctx, &regions);
    return status;
}

kn_status kn_job_cross(kn_ctx *ctx, bool *crossed, kn_job_cell_plan *plan, const kn_job_leaf *leaf,
                       const kn_job_place *place, const kn_bezier *d)
{
    kn_crossing x;
    bool few, any = true, fits = true;
    kn_job_crossing way = plan->job->options.crossing;
    kn_job_leaf part = *leaf; // with what the tile's own trim, and the ends, leave of it
    *crossed = false;
    kn_crossing_init(&few, &x, plan, &part, place, d);
    if (!few) return KN_OK;
    if (d->nvars == 1) return kn_cross_curve(ctx, crossed, &x);
    bool one_box = x.n[0] == 0 && x.n[1] == 0, clipped = kn_cross_is_clipped(&x); // one box: exact, nothing to cut
    if (way == KN_CROSSING_REFUSE && !(one_box && clipped)) return KN_OK;
    kn_status status = KN_OK;
    if (kn_job_is_trimmed(plan, leaf)) status = kn_job_leaf_trim(ctx, &part.trim, &any, plan, leaf);
    if (status == KN_OK && any && clipped) status = kn_cross_clip(ctx, &fits, &any, &part.trim, &x);
    kn_answer border = KN_YES;
    if (status == KN_OK && any) status = kn_job_border_of_patch(ctx, &border, plan, place, d);
    if (status == KN_OK && !any)
        *crossed = true;
    else if (status == KN_OK && fits)
        status = border == KN_UNKNOWN ? make_trimmed(ctx, crossed, &x, &part) : make(ctx, crossed, &x);
    kn_trim_clear(ctx, &part.trim);
    return status;
}
