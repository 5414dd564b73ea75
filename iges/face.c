// SPDX-License-Identifier: Apache-2.0
// One patch of an IGES file that is not trimmed, and curves: parameters of what refers to nothing.
#include "iges/write.h"

#include "kernel/context.h"

#include <string.h>

static void put_knots(kn_text *text, const kn_patch_axis *x, bool turned)
{
    for (int k = 0; k < x->nbreaks; k++) {
        int times = x->times[turned ? x->nbreaks - 1 - k : k];
        for (int i = 0; i < times; i++) kn_iges_put_real(text, kn_patch_knot(x, k, turned));
    }
}

static void put_ends(kn_text *text, const kn_patch_axis *x)
{
    kn_iges_put_real(text, x->breaks[0]);
    kn_iges_put_real(text, x->breaks[x->nbreaks - 1]);
}

// 128: upper indices, degrees, closed, polynomial, periodic; knots; weights and points, the first variable fastest.
// Turned round, t is the first variable: the normal looks to the other side.
void kn_iges_put_surface(kn_text *text, const kn_patch_net *f, bool turned)
{
    int nt = f->axis[1].n, var[2] = {turned, !turned}; // which variable comes first, and which then
    int n[2] = {f->axis[var[0]].n, f->axis[var[1]].n}, step[2] = {turned ? 1 : nt, turned ? nt : 1};
    kn_iges_put_integer(text, 128);
    for (int v = 0; v < 2; v++) kn_iges_put_integer(text, (uint64_t)n[v] - 1);
    for (int v = 0; v < 2; v++) kn_iges_put_integer(text, (uint64_t)f->axis[var[v]].degree);
    for (int v = 0; v < 2; v++) kn_iges_put_integer(text, f->closed[var[v]]);
    kn_iges_put_integer(text, !f->rational);
    for (int v = 0; v < 2; v++) kn_iges_put_integer(text, 0);
    for (int v = 0; v < 2; v++) put_knots(text, &f->axis[var[v]], false);
    for (int j = 0; j < n[1]; j++)
        for (int i = 0; i < n[0]; i++) {
            const double *p = f->point + 4 * (i * step[0] + j * step[1]);
            kn_iges_put_real(text, f->rational ? p[3] : 1.0);
        }
    for (int j = 0; j < n[1]; j++)
        for (int i = 0; i < n[0]; i++) {
            const double *p = f->point + 4 * (i * step[0] + j * step[1]);
            for (int c = 0; c < 3; c++) kn_iges_put_real(text, p[c]);
        }
    for (int v = 0; v < 2; v++) put_ends(text, &f->axis[var[v]]);
    kn_iges_end(text);
}

// 126: upper index, degree, planar, closed, polynomial, periodic; knots; weights; points; ends; normal where planar.
void kn_iges_put_curve(kn_text *text, const kn_patch_curve *line, bool turned, bool closed, bool plane)
{
    const kn_patch_axis *x = &line->axis;
    const double *first = line->point + (turned ? (x->n - 1) * line->step : 0);
    ptrdiff_t step = turned ? -line->step : line->step;
    kn_iges_put_integer(text, 126);
    kn_iges_put_integer(text, (uint64_t)x->n - 1);
    kn_iges_put_integer(text, (uint64_t)x->degree);
    kn_iges_put_integer(text, plane);
    kn_iges_put_integer(text, closed);
    kn_iges_put_integer(text, !line->rational);
    kn_iges_put_integer(text, 0);
    put_knots(text, x, turned);
    for (int k = 0; k < x->n; k++) kn_iges_put_real(text, line->rational ? first[k * step + 3] : 1.0);
    for (int k = 0; k < x->n; k++)
        for (int c = 0; c < 3; c++) kn_iges_put_real(text, first[k * step + c]);
    put_ends(text, x);
    for (int c = 0; c < 3; c++) kn_iges_put_real(text, plane && c == 2 ? 1.0 : 0.0);
    kn_iges_end(text);
}

// Of one edge, in the direction of its key.
static void put_edge(kn_text *text, kn_iges_item *item, const kn_patch_net *f, const kn_patch_side *s)
{
    kn_iges_edge *e = &item->edge[item->nedges++];
    *e = (kn_iges_edge){.edge = s->edge, .along = s->along};
    for (int k = 0; k < 2; k++) memcpy(e->vertex[k], f->point + 4 * s->corner[k], sizeof e->vertex[k]);
    size_t begin = text->bytes;
    kn_iges_put_curve(text, &s->line, s->turned, kn_brep_same(s->edge.vertex[0], s->edge.vertex[1]), false);
    e->lines = kn_iges_count_lines(text, begin);
}

kn_status kn_iges_put_face(kn_iges_written *w, const kn_patch *patch, double mm, bool edges)
{
    kn_text *text = &w->text;
    kn_iges_item *item = &w->items[w->nitems];
    *item = (kn_iges_item){.kind = KN_IGES_FACE,
                           .look = patch->look,
                           .id = patch->id,
                           .group = patch->body,
                           .body = -1,
                           .exact = patch->exact};
    item->reversed = patch->reversed;
    item->begin = text->bytes;
    kn_patch_net f;
    kn_mark mark = kn_scratch_mark(text->ctx);
    kn_status status = kn_patch_net_load(text->ctx, &f, patch, mm, "IGES");
    if (status == KN_OK) {
        kn_iges_put_surface(text, &f, !edges && patch->reversed);
        item->surface_lines = kn_iges_count_lines(text, item->begin);
        for (int e = 0; e < 4 && edges; e++)
            if (!f.side[e].collapsed) put_edge(text, item, &f, &f.side[e]);
        memcpy(item->pair, f.pair, sizeof item->pair);
        item->npairs = f.npairs;
        w->nitems++;
    }
    kn_scratch_release(text->ctx, mark);
    return status == KN_OK && text->failed ? KN_ENOMEM : status;
}

kn_status kn_iges_put_line(kn_iges_written *w, const kn_patch *patch, double mm)
{
    kn_text *text = &w->text;
    kn_ctx *ctx = text->ctx;
    kn_iges_item *item = &w->items[w->nitems];
    kn_spline s = kn_patch_spline(patch);
    kn_patch_curve line = {0};
    *item = (kn_iges_item){.kind = KN_IGES_CURVE,
                           .look = patch->look,
                           .id = patch->id,
                           .body = -1,
                           .exact = patch->exact,
                           .begin = text->bytes};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_patch_curve_load(ctx, &line, &s, 0, mm, "IGES");
    if (status == KN_OK) {
        kn_iges_put_curve(text, &line, false, false, false);
        item->surface_lines = kn_iges_count_lines(text, item->begin);
        w->nitems++;
    }
    kn_scratch_release(ctx, mark);
    return status == KN_OK && text->failed ? KN_ENOMEM : status;
}
