// SPDX-License-Identifier: Apache-2.0
// A trimmed patch of an IGES file: its surface, and the curves of its loops in the plane and in space.
#include "iges/write.h"

#include "io/trim_edges.h"
#include "kernel/context.h"

// Loops of a trim as trimmed surfaces need them: each outer one with the holes in it.
typedef struct loops {
    const kn_trim *trim;
    const kn_trim_edge *edges;
    int *outer; // the outer loop of each, itself where it is one
} loops;

static int first_of(const kn_trim *trim, int loop)
{
    return loop > 0 ? trim->loop_end[loop - 1] : 0;
}

// Whether the ray from p upwards in the second variable meets loop's polylines an odd number of times.
static bool contains(const loops *l, int loop, const double *p)
{
    bool inside = false;
    for (int k = first_of(l->trim, loop); k < l->trim->loop_end[loop]; k++)
        for (int i = 0; i + 1 < l->edges[k].plane.axis.n; i++) {
            const double *a = l->edges[k].plane.point + 4 * i, *b = a + 4;
            if ((a[0] > p[0]) == (b[0] > p[0])) continue;
            if (a[1] + (p[0] - a[0]) / (b[0] - a[0]) * (b[1] - a[1]) > p[1]) inside = !inside;
        }
    return inside;
}

// The smallest outer loop that a hole is in; the first outer one where rounding hides that.
static void assign(loops *l)
{
    const kn_trim *trim = l->trim;
    for (int i = 0; i < trim->nloops; i++) {
        double least = 0.0;
        l->outer[i] = i;
        if (kn_trim_edges_area(l->edges, first_of(trim, i), trim->loop_end[i]) > 0.0) continue;
        l->outer[i] = -1;
        for (int k = 0; k < trim->nloops; k++) {
            double area = kn_trim_edges_area(l->edges, first_of(trim, k), trim->loop_end[k]);
            if (!(area > 0.0)) continue;
            bool in = contains(l, k, l->edges[first_of(trim, i)].plane.point);
            if (l->outer[i] >= 0 && !(in && (least == 0.0 || area < least))) continue;
            l->outer[i] = k;
            least = in ? area : 0.0;
        }
    }
}

// ---- lists ----

static kn_status add_loop(kn_iges_written *w, kn_iges_loop loop)
{
    if (w->nloops == w->loop_room) {
        size_t room = w->loop_room > 0 ? 2 * w->loop_room : 16;
        kn_iges_loop *more = kn_resize(w->text.ctx, w->loops, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        w->loops = more, w->loop_room = room;
    }
    w->loops[w->nloops++] = loop;
    return KN_OK;
}

static kn_status add_lines(kn_iges_written *w, uint32_t lines)
{
    if (w->nlines == w->line_room) {
        size_t room = w->line_room > 0 ? 2 * w->line_room : 64;
        uint32_t *more = kn_resize(w->text.ctx, w->lines, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        w->lines = more, w->line_room = room;
    }
    w->lines[w->nlines++] = lines;
    return KN_OK;
}

// ---- text ----

// The same curve in the plane of (t,r), in scratch.
static kn_status swap_plane(kn_ctx *ctx, kn_trim_edge *e)
{
    int n = e->plane.axis.n;
    double *p = kn_scratch(ctx, (size_t)n, 4 * sizeof *p);
    if (!p) return KN_ENOMEM;
    for (int k = 0; k < n; k++) {
        const double *from = e->plane.point + 4 * k;
        p[4 * k] = from[1], p[4 * k + 1] = from[0], p[4 * k + 2] = from[2], p[4 * k + 3] = from[3];
    }
    e->plane.point = p;
    return KN_OK;
}

// Curves that are points are left out: there is nothing of them in space. turned: all run the other way.
static kn_status put_loop(kn_iges_written *w, kn_iges_item *item, const loops *l, int loop, bool turned)
{
    int first = first_of(l->trim, loop), n = l->trim->loop_end[loop] - first;
    kn_iges_loop out = {.outer = l->outer[loop] == loop};
    kn_status status = KN_OK;
    for (int space = 0; space < 2; space++)
        for (int k = 0; k < n && status == KN_OK; k++) {
            const kn_trim_edge *e = &l->edges[first + (turned ? n - 1 - k : k)];
            size_t begin = w->text.bytes;
            if (e->collapsed) continue;
            kn_iges_put_curve(&w->text, space ? &e->space : &e->plane, turned, false, !space);
            status = add_lines(w, kn_iges_count_lines(&w->text, begin));
            out.curves += (uint32_t)space;
        }
    if (status == KN_OK && out.curves > 0) {
        status = add_loop(w, out);
        item->nloops++;
    }
    return status;
}

static kn_status put_loops(kn_iges_written *w, kn_iges_item *item, const loops *l, bool turned)
{
    kn_status status = KN_OK;
    for (int i = 0; i < l->trim->nloops && status == KN_OK; i++) {
        if (l->outer[i] != i) continue;
        status = put_loop(w, item, l, i, turned);
        for (int k = 0; k < l->trim->nloops && status == KN_OK; k++)
            if (k != i && l->outer[k] == i) status = put_loop(w, item, l, k, turned);
    }
    return status;
}

kn_status kn_iges_put_trimmed(kn_iges_written *w, const kn_patch *patch, double mm)
{
    kn_ctx *ctx = w->text.ctx;
    const kn_trim *trim = patch->trim;
    kn_iges_item *item = &w->items[w->nitems];
    *item = (kn_iges_item){
        .kind = KN_IGES_TRIMMED, .look = patch->look, .id = patch->id, .reversed = patch->reversed};
    item->begin = w->text.bytes, item->loops = w->nloops, item->lines = w->nlines;
    kn_patch_net net;
    kn_trim_edge *edges = NULL;
    kn_mark mark = kn_scratch_mark(ctx);
    loops l = {.trim = trim, .outer = kn_scratch(ctx, (size_t)trim->nloops, sizeof *l.outer)};
    kn_status status = l.outer ? kn_patch_net_load(ctx, &net, patch, mm, "IGES") : KN_ENOMEM;
    if (status == KN_OK) status = kn_trim_edges(ctx, &edges, patch, &net, mm, "IGES");
    if (status == KN_OK) {
        l.edges = edges;
        assign(&l);
        kn_iges_put_surface(&w->text, &net, patch->reversed);
        item->surface_lines = kn_iges_count_lines(&w->text, item->begin);
    }
    for (int k = 0; k < trim->ncurves && status == KN_OK && patch->reversed; k++) status = swap_plane(ctx, &edges[k]);
    if (status == KN_OK) {
        status = put_loops(w, item, &l, patch->reversed);
        w->nitems++;
    }
    kn_scratch_release(ctx, mark);
    return status == KN_OK && w->text.failed ? KN_ENOMEM : status;
}
