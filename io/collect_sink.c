// SPDX-License-Identifier: Apache-2.0
// A sink that keeps patches as splines, as they are: a base for another job.
#include <knurl/io.h>

#include "kernel/context.h"

typedef struct collect {
    kn_model *to; // the caller's
    kn_model made;
    int room;
} collect;

static kn_status collect_begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    (void)tile, (void)user;
    if (report->meshes > 0)
        return kn_fail(ctx, KN_EDOMAIN, "collect: %zu of the patches are meshes, and no splines", report->meshes);
    return KN_OK;
}

// A reversed one is run through the other way, so that its own normal looks outside again.
static kn_status add(kn_ctx *ctx, collect *c, const kn_patch *patch)
{
    if (patch->mesh || patch->trim)
        return kn_fail(ctx, KN_EDOMAIN, "collect: a patch of surface %d, cell %d,%d is no spline as a whole",
                       patch->id.surface, patch->id.cell[0], patch->id.cell[1]);
    if (c->made.nsplines == c->room) {
        int room = c->room > 0 ? 2 * c->room : 16;
        kn_spline *list = kn_resize(ctx, c->made.splines, (size_t)room, sizeof *list);
        if (!list) return KN_ENOMEM;
        c->made.splines = list;
        c->room = room;
    }
    kn_spline s = {0};
    kn_status status = patch->spline ? kn_spline_copy(ctx, &s, patch->spline)
                                     : kn_spline_of_bezier(ctx, &s, &patch->bezier);
    if (status == KN_OK && patch->reversed && s.nvars == 2) status = kn_spline_reverse(ctx, &s, &s, 0);
    if (status == KN_OK)
        c->made.splines[c->made.nsplines++] = s;
    else
        kn_spline_clear(ctx, &s);
    return status;
}

static kn_status collect_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)product;
    kn_status status = KN_OK;
    for (size_t i = 0; status == KN_OK && i < block->count; i++) status = add(ctx, user, &block->patches[i]);
    return status;
}

static kn_status collect_end(kn_ctx *ctx, void *user)
{
    collect *c = user;
    kn_model_clear(ctx, c->to);
    *c->to = c->made;
    c->made = (kn_model){0};
    c->room = 0;
    return KN_OK;
}

static void collect_close(kn_ctx *ctx, void *user)
{
    collect *c = user;
    kn_model_clear(ctx, &c->made);
    kn_free(ctx, c);
}

kn_status kn_collect_sink(kn_ctx *ctx, kn_sink *out, kn_model *model)
{
    collect *c = kn_alloc_zero(ctx, 1, sizeof *c);
    if (!c) return KN_ENOMEM;
    c->to = model;
    *out = (kn_sink){
        .user = c, .begin = collect_begin, .commit = collect_commit, .end = collect_end, .close = collect_close};
    return KN_OK;
}
