// SPDX-License-Identifier: Apache-2.0
// One patch of a STEP file: its points, its surface, the curves of its edges on the same control points, and by which
// keys its edges meet others.
#include "step/face.h"
#include "step/write.h"
#include "kernel/context.h"

#include <math.h>
#include <string.h>

// Corners of the square where edge e starts and ends.
static const int edge_ends[4][2] = {{0, 1}, {1, 2}, {3, 2}, {0, 3}};

// ---- text ----

void kn_step_put_points(kn_text *text, const kn_patch_net *f)
{
    for (int k = 0; k < f->n; k++) kn_step_put_point(text, (uint32_t)k, f->point + 4 * k, 3);
}

// A list of lists of point numbers or of weights.
static void put_net(kn_text *text, const kn_patch_net *f, bool weights)
{
    int nt = f->axis[1].n;
    kn_text_char(text, '(');
    for (int k = 0; k < f->n; k++) {
        if (k > 0) kn_text_comma(text);
        if (k % nt == 0) kn_text_char(text, '(');
        if (weights)
            kn_text_step_real(text, f->point[4 * k + 3]);
        else
            kn_text_relative(text, (uint32_t)k);
        if (k % nt == nt - 1) kn_text_char(text, ')');
    }
    kn_text_char(text, ')');
}

// The attributes of B_SPLINE_SURFACE and of B_SPLINE_SURFACE_WITH_KNOTS, which the rational form lists apart.
static void put_surface_shape(kn_text *text, const kn_patch_net *f)
{
    kn_text_integer(text, (uint64_t)f->axis[0].degree);
    kn_text_char(text, ',');
    kn_text_integer(text, (uint64_t)f->axis[1].degree);
    kn_text_char(text, ',');
    put_net(text, f, false);
    kn_text_put(text, ",.UNSPECIFIED.,");
    kn_step_put_logical(text, f->closed[0]);
    kn_text_char(text, ',');
    kn_step_put_logical(text, f->closed[1]);
    kn_text_put(text, ",.F.");
}

static void put_surface_knots(kn_text *text, const kn_patch_net *f)
{
    for (int v = 0; v < 2; v++) kn_step_put_times(text, &f->axis[v], false), kn_text_char(text, ',');
    for (int v = 0; v < 2; v++) kn_step_put_breaks(text, &f->axis[v], false), kn_text_char(text, ',');
    kn_text_put(text, ".UNSPECIFIED.");
}

void kn_step_put_surface(kn_text *text, const kn_patch_net *f)
{
    kn_step_put_relative(text, (uint32_t)f->n);
    kn_text_put(text, f->rational ? "(BOUNDED_SURFACE()B_SPLINE_SURFACE(" : "B_SPLINE_SURFACE_WITH_KNOTS('',");
    put_surface_shape(text, f);
    kn_text_put(text, f->rational ? ")B_SPLINE_SURFACE_WITH_KNOTS(" : ",");
    put_surface_knots(text, f);
    if (f->rational) {
        kn_text_char(text, ')');
        kn_text_newline(text);
        kn_text_put(text, "GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_SURFACE(");
        put_net(text, f, true);
        kn_text_put(text, ")REPRESENTATION_ITEM('')SURFACE()");
    }
    kn_text_put(text, ");");
    kn_text_newline(text);
}

// ---- edges ----

// Those that are no points. e: which of the four each is.
static void take_edges(kn_step_item *item, const kn_patch_net *f, int e[4])
{
    memcpy(item->pair, f->pair, sizeof item->pair);
    item->npairs = f->npairs;
    for (int k = 0; k < 4; k++) {
        const kn_patch_side *s = &f->side[k];
        if (s->collapsed) continue;
        e[item->nedges] = k;
        kn_step_edge *edge = &item->edge[item->nedges++];
        *edge = (kn_step_edge){.edge = s->edge, .along = s->along, .corners = true};
        for (int i = 0; i < 2; i++) edge->corner[i] = (uint32_t)s->corner[i];
    }
}

// Points that edges have of their own come after the surface; the next number that is free.
static uint32_t number_edges(kn_patch_net *f, bool own[4])
{
    int next = f->n + 1;
    for (int e = 0; e < 4; e++) {
        kn_patch_curve *line = &f->side[e].line;
        own[e] = line->first < 0;
        if (!own[e]) continue;
        line->first = next, line->by = 1;
        next += line->axis.n;
    }
    return (uint32_t)next;
}

static bool same_point(const kn_patch_net *f, const double *a, const double *b)
{
    for (int c = 0; c < 3; c++)
        if (fabs(a[c] - b[c]) > f->same) return false;
    return true;
}

// The way from an end of an edge to its next control point that is another point. False: that is not the next one, or
// far nearer than others are: the curve starts slowly.
static bool leave(double way[3], const kn_patch_net *f, const kn_patch_curve *line, bool from_end)
{
    int n = line->axis.n, first = n;
    double length = 0.0, step = 0.0;
    for (int k = 1; k < n; k++) {
        const double *from = line->point + (from_end ? n - k : k - 1) * line->step;
        const double *to = line->point + (from_end ? n - 1 - k : k) * line->step;
        double square = 0.0;
        for (int c = 0; c < 3; c++) square += (to[c] - from[c]) * (to[c] - from[c]);
        length += sqrt(square);
        if (k == 1) step = sqrt(square);
        const double *start = line->point + (from_end ? n - 1 : 0) * line->step;
        if (first < n || same_point(f, start, to)) continue;
        first = k;
        for (int c = 0; c < 3; c++) way[c] = to[c] - start[c];
    }
    return first == 1 && step * (n - 1) > 0.05 * length;
}

// Programs find the curves of edges in the parameters of a surface by projection, which is ill-conditioned where an edge
// is a point, where one leaves a corner slowly, and where two leave it in nearly one line (within 0.1 radians).
static bool ill_conditioned(const kn_step_item *item, const kn_patch_net *f)
{
    bool ill = item->nedges < 4;
    for (int k = 0; k < 4 && !ill; k++) {
        double a[3], b[3], c[3], aa = 0.0, bb = 0.0, cc = 0.0;
        ill = !leave(a, f, &f->side[k >= 2 ? 2 : 0].line, k == 1 || k == 2) ||
              !leave(b, f, &f->side[k == 1 || k == 2 ? 1 : 3].line, k >= 2);
        if (ill) break;
        for (int i = 0; i < 3; i++) {
            c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
            aa += a[i] * a[i], bb += b[i] * b[i], cc += c[i] * c[i];
        }
        ill = !(cc > 0.01 * aa * bb);
    }
    return ill;
}

void kn_step_put_plane_context(kn_text *text, uint32_t number)
{
    kn_step_put_form(text, number,
                     "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()"
                     "REPRESENTATION_CONTEXT('2D SPACE',''));",
                     NULL);
}

// Four corners, then of each edge a line along its side of the square, whose parameter is that of the curve in space;
// numbers from `first` on, of which it answers the next free one.
static uint32_t put_plane_curves(kn_text *text, kn_step_item *item, const kn_patch_net *f, const int edge[4],
                                 uint32_t first)
{
    uint32_t context = first + 4, next = first + 5;
    for (int k = 0; k < 4; k++) {
        const double at[2] = {k == 1 || k == 2 ? 1.0 : 0.0, k >= 2 ? 1.0 : 0.0};
        kn_step_put_point(text, first + (uint32_t)k, at, 2);
    }
    kn_step_put_plane_context(text, context);
    for (int i = 0; i < item->nedges; i++, next += 3) {
        int e = edge[i], turned = f->side[e].turned;
        int from = edge_ends[e][turned], to = edge_ends[e][!turned];
        kn_step_put_form(text, next,
                         "B_SPLINE_CURVE_WITH_KNOTS('',1,(#,#),.UNSPECIFIED.,.F.,.F.,(2,2),(0.,1.),.UNSPECIFIED.);",
                         (uint32_t[]){first + (uint32_t)from, first + (uint32_t)to});
        kn_step_put_form(text, next + 1, "DEFINITIONAL_REPRESENTATION('',(#),#);", (uint32_t[]){next, context});
        kn_step_put_form(text, next + 2, "PCURVE('',#,#);", (uint32_t[]){(uint32_t)f->n, next + 1});
        item->edge[i].pcurve = next + 2;
    }
    return next;
}

kn_status kn_step_put_face(kn_text *text, kn_step_item *item, kn_step_lists *lists, const kn_patch *patch, double mm)
{
    *item = (kn_step_item){
        .kind = KN_STEP_FACE, .look = patch->look, .id = patch->id, .group = patch->body, .body = -1};
    item->reversed = patch->reversed, item->exact = patch->exact;
    if (patch->trim && patch->trim->nloops > 0) return kn_step_put_trimmed(text, item, lists, patch, mm);
    kn_patch_net f;
    bool own[4];
    int side[4];
    kn_mark mark = kn_scratch_mark(text->ctx);
    kn_status status = kn_patch_net_load(text->ctx, &f, patch, mm, "STEP");
    if (status == KN_OK) {
        item->numbers = number_edges(&f, own), item->main = (uint32_t)f.n;
        take_edges(item, &f, side);
        kn_step_put_points(text, &f);
        kn_step_put_surface(text, &f);
        if (item->nedges > 0 && ill_conditioned(item, &f))
            item->numbers = put_plane_curves(text, item, &f, side, item->numbers);
        item->text_end = text->bytes;
        for (int k = 0; k < item->nedges; k++) {
            const kn_patch_side *s = &f.side[side[k]];
            kn_step_edge *e = &item->edge[k];
            e->begin = text->bytes;
            if (own[side[k]]) kn_step_put_line_points(text, &s->line, 3);
            e->curve_begin = text->bytes;
            kn_step_put_line(text, &s->line, s->turned, kn_brep_same(s->edge.vertex[0], s->edge.vertex[1]));
            e->curve_end = text->bytes;
        }
    }
    kn_scratch_release(text->ctx, mark);
    return status == KN_OK && text->failed ? KN_ENOMEM : status;
}
