// SPDX-License-Identifier: Apache-2.0
// A trimmed patch: its points and surface, for each curve of the trim one in space and one in the plane of the surface's
// parameters (PCURVE), both over the same domain, and by which keys these meet others.
#include "io/trim_edges.h"
#include "step/face.h"
#include "kernel/context.h"

#include <string.h>

// Room for all that one trim may have.
static kn_status reserve(kn_ctx *ctx, kn_step_lists *l, const kn_trim_edges *t, const kn_trim *trim)
{
    void *loops = l->loops, *edges = l->edges, *pairs = l->pairs;
    kn_status status = kn_make_room(ctx, &loops, &l->loop_room, l->nloops + (size_t)t->nloops, sizeof *l->loops);
    if (status == KN_OK)
        status = kn_make_room(ctx, &edges, &l->edge_room, l->nedges + (size_t)trim->ncurves, sizeof *l->edges);
    if (status == KN_OK)
        status = kn_make_room(ctx, &pairs, &l->pair_room, l->npairs + KN_BREP_PAIRS, sizeof *l->pairs);
    l->loops = loops, l->edges = edges, l->pairs = pairs;
    return status;
}

// In the order of the loops.
static void take_edges(kn_step_item *item, kn_step_lists *l, const kn_trim_edges *t)
{
    item->loops = l->nloops, item->nloops = (size_t)t->nloops;
    item->edges = l->nedges, item->pairs = l->npairs, item->npairs = t->npairs;
    for (int i = 0; i < t->nloops; i++) {
        const kn_trim_loop *loop = &t->loop[i];
        kn_step_loop *out = &l->loops[l->nloops++];
        *out = (kn_step_loop){.outer = loop->outer};
        for (int k = loop->first; k < loop->last; k++) {
            const kn_trim_edge *e = &t->edge[k];
            if (e->collapsed) continue;
            l->edges[l->nedges] = (kn_step_edge){.edge = e->edge, .along = e->against == e->turned};
            memcpy(l->edges[l->nedges].at, e->at, sizeof e->at);
            l->nedges++, out->nedges++;
        }
    }
    size_t pairs = t->npairs < KN_BREP_PAIRS ? (size_t)t->npairs : KN_BREP_PAIRS;
    memcpy(l->pairs + l->npairs, t->pair, pairs * sizeof *t->pair);
    l->npairs += pairs;
}

// The curve in the plane of the parameters, in the direction of its key: numbers from `next` on, of which it answers the
// next free one.
static uint32_t put_plane(kn_text *text, kn_step_edge *out, const kn_trim_edge *e, uint32_t surface, uint32_t context,
                          uint32_t next)
{
    kn_patch_curve plane = e->plane;
    plane.first = (int)next, plane.by = 1;
    kn_step_put_line_points(text, &plane, 2);
    next += (uint32_t)plane.axis.n;
    kn_step_put_relative(text, next);
    kn_step_put_line(text, &plane, e->turned, false);
    kn_step_put_form(text, next + 1, "DEFINITIONAL_REPRESENTATION('',(#),#);", (uint32_t[]){next, context});
    kn_step_put_form(text, next + 2, "PCURVE('',#,#);", (uint32_t[]){surface, next + 1});
    out->pcurve = next + 2;
    return next + 3;
}

static void put_all(kn_text *text, kn_step_item *item, kn_step_edge *out, const kn_trim_edges *t,
                    const kn_patch_net *net)
{
    uint32_t surface = (uint32_t)net->n, context = surface + 1, next = context + 1;
    kn_step_put_points(text, net);
    kn_step_put_surface(text, net);
    kn_step_put_plane_context(text, context);
    kn_step_edge *to = out;
    for (int i = 0; i < t->nloops; i++)
        for (int k = t->loop[i].first; k < t->loop[i].last; k++)
            if (!t->edge[k].collapsed) next = put_plane(text, to++, &t->edge[k], surface, context, next);
    item->text_end = text->bytes;
    to = out;
    for (int i = 0; i < t->nloops; i++)
        for (int k = t->loop[i].first; k < t->loop[i].last; k++) {
            const kn_trim_edge *e = &t->edge[k];
            if (e->collapsed) continue;
            kn_patch_curve space = e->space;
            space.first = (int)next, space.by = 1;
            next += (uint32_t)space.axis.n;
            to->begin = text->bytes;
            kn_step_put_line_points(text, &space, 3);
            to->curve_begin = text->bytes;
            kn_step_put_line(text, &space, e->turned, kn_brep_same(e->edge.vertex[0], e->edge.vertex[1]));
            to->curve_end = text->bytes;
            to++;
        }
    item->numbers = next, item->main = surface;
}

kn_status kn_step_put_trimmed(kn_text *text, kn_step_item *item, kn_step_lists *lists, const kn_patch *patch,
                              double mm)
{
    kn_ctx *ctx = text->ctx;
    kn_patch_net net;
    kn_trim_edges t;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_patch_net_load(ctx, &net, patch, mm, "STEP");
    if (status == KN_OK) status = kn_trim_edges_load(ctx, &t, patch, &net, mm, "STEP");
    if (status == KN_OK) status = reserve(ctx, lists, &t, patch->trim);
    if (status == KN_OK) {
        item->kind = KN_STEP_TRIMMED;
        if (patch->bounds) item->body = patch->bounds->body, item->shell = patch->bounds->shell;
        take_edges(item, lists, &t);
        put_all(text, item, lists->edges + item->edges, &t, &net);
    }
    kn_scratch_release(ctx, mark);
    return status == KN_OK && text->failed ? KN_ENOMEM : status;
}
