// SPDX-License-Identifier: Apache-2.0
// What the trim of a tile's surface leaves of one part of one of its Bezier patches.
#include "job/internal.h"

#include <math.h>

// The Bezier patch numbered `index` of the surface, as a box of [0,1]^2.
static void patch_box(double lo[2], double hi[2], const kn_spline *s, int index)
{
    int along = kn_spline_spans(s, 1);
    const int at[2] = {index / along, index % along};
    for (int v = 0; v < 2; v++) {
        double a, b;
        int span = 0;
        kn_spline_domain(s, v, &a, &b);
        for (int k = s->degree[v]; k < s->count[v]; k++) {
            if (!(s->knots[v][k + 1] > s->knots[v][k])) continue;
            if (span++ != at[v]) continue;
            lo[v] = (s->knots[v][k] - a) / (b - a);
            hi[v] = s->knots[v][k + 1] == b ? 1.0 : (s->knots[v][k + 1] - a) / (b - a);
        }
    }
}

static int patches_of(const kn_spline *s)
{
    int n = 1;
    for (int v = 0; v < s->nvars; v++) n *= kn_spline_spans(s, v);
    return n;
}

bool kn_job_is_trimmed(const kn_job_cell_plan *plan, const kn_job_leaf *leaf)
{
    const kn_job_patch *p = kn_job_leaf_patch(plan, leaf);
    const kn_tile_part *part = &plan->job->tile.parts[p->part];
    return part->trims && part->trims[p->spline].nloops > 0;
}

kn_status kn_job_leaf_trim(kn_ctx *ctx, kn_trim *out, bool *any, const kn_job_cell_plan *plan,
                           const kn_job_leaf *leaf)
{
    const kn_job_patch *p = kn_job_leaf_patch(plan, leaf);
    const kn_tile_part *part = &plan->job->tile.parts[p->part];
    int index = p->patch;
    double lo[2], hi[2];
    for (int s = 0; s < p->spline; s++) index -= patches_of(&part->splines[s]);
    patch_box(lo, hi, &part->splines[p->spline], index);
    for (int v = 0; v < 2; v++) {
        const kn_job_rect *rect = &leaf->key.rect;
        double step = ldexp(p->hi[v] - p->lo[v], -rect->level[v]), width = hi[v] - lo[v];
        double from = p->lo[v] + step * rect->index[v], to = from + step;
        hi[v] = to == 1.0 ? hi[v] : lo[v] + width * to;
        lo[v] = lo[v] + width * from;
    }
    return kn_trim_restrict(ctx, out, any, &part->trims[p->spline], lo, hi);
}
