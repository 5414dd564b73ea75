// SPDX-License-Identifier: Apache-2.0
// A trimmed patch of an IGES file: its surface, and the curves of its loops in the plane and in space.
#include "iges/write.h"

#include "io/trim_edges.h"
#include "kernel/context.h"

#include <string.h>

// Room for all that one trim may have.
static kn_status reserve(kn_iges_written *w, const kn_trim_edges *t, const kn_trim *trim)
{
    kn_ctx *ctx = w->text.ctx;
    size_t n = (size_t)trim->ncurves;
    void *loops = w->loops, *lines = w->lines, *edges = w->edges, *pairs = w->pairs;
    kn_status status = kn_make_room(ctx, &loops, &w->loop_room, w->nloops + (size_t)t->nloops, sizeof *w->loops);
    if (status == KN_OK) status = kn_make_room(ctx, &lines, &w->line_room, w->nlines + 2 * n, sizeof *w->lines);
    if (status == KN_OK) status = kn_make_room(ctx, &edges, &w->edge_room, w->nedges + n, sizeof *w->edges);
    if (status == KN_OK)
        status = kn_make_room(ctx, &pairs, &w->pair_room, w->npairs + KN_BREP_PAIRS, sizeof *w->pairs);
    w->loops = loops, w->lines = lines, w->edges = edges, w->pairs = pairs;
    return status;
}

// The same curve in the plane of (t,r), in scratch.
static kn_status swap_plane(kn_ctx *ctx, kn_patch_curve *plane)
{
    int n = plane->axis.n;
    double *p = kn_scratch(ctx, (size_t)n, 4 * sizeof *p);
    if (!p) return KN_ENOMEM;
    for (int k = 0; k < n; k++) {
        const double *from = plane->point + k * plane->step;
        p[4 * k] = from[1], p[4 * k + 1] = from[0], p[4 * k + 2] = from[2], p[4 * k + 3] = from[3];
    }
    plane->point = p, plane->step = 4;
    return KN_OK;
}

// Without shells. Curves that are points are left out: there is nothing of them in space. back: the loop runs the other
// way.
static void put_loop(kn_iges_written *w, const kn_trim_edges *t, const kn_trim_loop *loop, bool back)
{
    int n = loop->last - loop->first;
    kn_iges_loop *out = &w->loops[w->nloops++];
    *out = (kn_iges_loop){.outer = loop->outer};
    for (int space = 0; space < 2; space++)
        for (int k = 0; k < n; k++) {
            const kn_trim_edge *e = &t->edge[loop->first + (back ? n - 1 - k : k)];
            size_t begin = w->text.bytes;
            if (e->collapsed) continue;
            kn_iges_put_curve(&w->text, space ? &e->space : &e->plane, back != e->against, false, !space);
            w->lines[w->nlines++] = kn_iges_count_lines(&w->text, begin);
            out->curves += (uint32_t)space;
        }
}

// With shells: each edge along its key in space, and along the loop in the plane.
static void put_edges(kn_iges_written *w, const kn_trim_edges *t, const kn_trim_loop *loop)
{
    kn_iges_loop *out = &w->loops[w->nloops++];
    *out = (kn_iges_loop){.outer = loop->outer};
    for (int k = loop->first; k < loop->last; k++) {
        const kn_trim_edge *e = &t->edge[k];
        if (e->collapsed) continue;
        kn_iges_edge *edge = &w->edges[w->nedges++];
        *edge = (kn_iges_edge){.edge = e->edge, .along = e->against == e->turned};
        memcpy(edge->vertex, e->at, sizeof edge->vertex);
        size_t begin = w->text.bytes;
        kn_iges_put_curve(&w->text, &e->plane, e->against, false, true);
        edge->plane_lines = kn_iges_count_lines(&w->text, begin);
        begin = w->text.bytes;
        kn_iges_put_curve(&w->text, &e->space, e->turned, kn_brep_same(e->edge.vertex[0], e->edge.vertex[1]), false);
        edge->lines = kn_iges_count_lines(&w->text, begin);
        out->curves++;
    }
}

static kn_status put_all(kn_iges_written *w, kn_iges_item *item, kn_trim_edges *t, const kn_patch *patch,
                         const kn_patch_net *net, bool edges)
{
    bool turned = patch->reversed && !edges; // a shell tells it of its face
    kn_status status = KN_OK;
    kn_iges_put_surface(&w->text, net, turned);
    item->surface_lines = kn_iges_count_lines(&w->text, item->begin);
    for (int k = 0; k < patch->trim->ncurves && status == KN_OK && turned; k++)
        status = swap_plane(w->text.ctx, &t->edge[k].plane);
    item->loops = w->nloops, item->nloops = (size_t)t->nloops, item->lines = w->nlines, item->edges = w->nedges;
    for (int i = 0; i < t->nloops && status == KN_OK; i++) {
        if (edges)
            put_edges(w, t, &t->loop[i]);
        else
            put_loop(w, t, &t->loop[i], turned);
    }
    size_t pairs = t->npairs < KN_BREP_PAIRS ? (size_t)t->npairs : KN_BREP_PAIRS;
    item->pairs = w->npairs, item->npairs = t->npairs;
    memcpy(w->pairs + w->npairs, t->pair, pairs * sizeof *t->pair);
    w->npairs += pairs;
    return status;
}

kn_status kn_iges_put_trimmed(kn_iges_written *w, const kn_patch *patch, double mm, bool edges)
{
    kn_ctx *ctx = w->text.ctx;
    kn_iges_item *item = &w->items[w->nitems];
    *item = (kn_iges_item){.kind = KN_IGES_TRIMMED,
                           .look = patch->look,
                           .id = patch->id,
                           .group = patch->body,
                           .body = -1,
                           .exact = patch->exact};
    item->reversed = patch->reversed, item->begin = w->text.bytes;
    if (patch->bounds) item->body = patch->bounds->body, item->shell = patch->bounds->shell;
    kn_patch_net net;
    kn_trim_edges t;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_patch_net_load(ctx, &net, patch, mm, "IGES");
    if (status == KN_OK) status = kn_trim_edges_load(ctx, &t, patch, &net, mm, "IGES");
    if (status == KN_OK) status = reserve(w, &t, patch->trim);
    if (status == KN_OK) status = put_all(w, item, &t, patch, &net, edges);
    if (status == KN_OK) w->nitems++;
    kn_scratch_release(ctx, mark);
    return status == KN_OK && w->text.failed ? KN_ENOMEM : status;
}
