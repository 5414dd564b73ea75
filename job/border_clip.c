// SPDX-License-Identifier: Apache-2.0
// What the border of a trimmed base leaves of the parts of a tile.
#include "job/border.h"
#include "job/cross.h"

#include <math.h>

bool kn_job_clips_trims(const kn_job *job)
{
    return job->borders && job->options.trimmed != KN_TRIMMED_KEEP;
}

bool kn_job_border_is_whole(const kn_job_cell_plan *plan)
{
    const kn_job_surface *s = &plan->job->surfaces[plan->surface];
    size_t i = s->first_cell + (size_t)plan->cell[0] * (size_t)s->cells[1] + (size_t)plan->cell[1];
    return plan->job->borders->whole[i / 64] >> i % 64 & 1;
}

kn_status kn_job_border_of_box(kn_ctx *ctx, kn_answer *out, const kn_job *job, int surface, const double lo[2],
                               const double hi[2])
{
    const double middle[2] = {0.5 * (lo[0] + hi[0]), 0.5 * (lo[1] + hi[1])};
    *out = KN_UNKNOWN;
    if (kn_job_border_touches(job, surface, lo, hi)) return KN_OK;
    return kn_job_border_side(ctx, out, job, surface, middle);
}

kn_status kn_job_border_of_patch(kn_ctx *ctx, kn_answer *out, const kn_job_cell_plan *plan, const kn_job_place *place,
                                 const kn_bezier *d)
{
    const kn_job *job = plan->job;
    *out = KN_YES;
    if (!kn_job_clips_trims(job) || kn_job_border_is_whole(plan) || !kn_job_is_bordered(job, place->surface))
        return KN_OK;
    if (d->nvars == 3 && job->options.trimmed == KN_TRIMMED_TAPER) return KN_OK; // flat there
    double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
    size_t n = kn_bezier_count(d);
    for (size_t i = 0; i < 2 * n; i++) {
        lo[i / n] = fmin(lo[i / n], place->cell[i / n] + d->coef[i]);
        hi[i / n] = fmax(hi[i / n], place->cell[i / n] + d->coef[i]);
    }
    return kn_job_border_of_box(ctx, out, job, place->surface, lo, hi);
}

static kn_status refuse(kn_ctx *ctx, const kn_job_cell_plan *plan, const kn_job_leaf *leaf)
{
    const kn_job_patch *p = kn_job_leaf_patch(plan, leaf);
    const kn_job_surface *s = &plan->job->surfaces[plan->surface];
    return kn_fail(
        ctx, KN_EDOMAIN,
        "job: volume %d of tile part \"%s\" crosses the border of surface %d in cell %d,%d: volumes cannot be "
        "trimmed: a tile of its outside (knurl convert TILE -o OUTSIDE.step) can, --trimmed keep keeps it whole",
        p->patch, plan->job->tile.parts[p->part].name, s->origin, s->origin_cell[0] + plan->cell[0],
        s->origin_cell[1] + plan->cell[1]);
}

// The leaf's piece with its coefficients, as x has it.
static kn_status begin(kn_ctx *ctx, kn_crossing *x, kn_job_cell_plan *plan, kn_job_leaf *leaf,
                       const kn_job_place *place, const kn_bezier *d)
{
    bool few, outline = plan->pieces.outline;
    const kn_job_piece *p = &plan->pieces.list[leaf->piece];
    const double lo[2] = {p->lo[0], p->lo[1]}, hi[2] = {p->hi[0], p->hi[1]};
    kn_crossing_init(&few, x, plan, leaf, place, d);
    plan->pieces.outline = false;
    kn_status status = kn_job_pieces_get(ctx, &leaf->piece, &plan->pieces, place, lo, hi);
    plan->pieces.outline = outline;
    x->n[0] = x->n[1] = 0;
    x->piece[0][0] = leaf->piece;
    return status;
}

kn_status kn_job_clip_leaf(kn_ctx *ctx, kn_job_cell_plan *plan, kn_job_leaf *leaf, const kn_job_place *place,
                           const kn_bezier *d)
{
    kn_crossing x;
    kn_job_regions regions = {0};
    if (d->nvars == 3) return refuse(ctx, plan, leaf);
    kn_status status = begin(ctx, &x, plan, leaf, place, d);
    if (status == KN_OK) status = kn_job_border_cut(ctx, &regions, &x, &leaf->trim);
    for (int i = 0; status == KN_OK && i < regions.n; i++) {
        kn_job_leaf part = *leaf;
        part.trim = regions.list[i];
        regions.list[i] = (kn_trim){0};
        status = kn_job_add_leaf(ctx, plan, &part);
        kn_trim_clear(ctx, &part.trim);
    }
    kn_job_regions_clear(ctx, &regions);
    return status;
}
