// SPDX-License-Identifier: Apache-2.0
// One patch of a STEP file: its points, its surface, the curves of its edges on the same control points, and by which
// keys its edges meet others.
#include "step/face.h"
#include "step/write.h"
#include "kernel/context.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

// Corners: (r,t) = (0,0), (1,0), (1,1), (0,1), counterclockwise. Edge e runs from corner to corner with increasing r
// or t, and the loop runs along it forwards or backwards.
//     edge 0: t = 0, edge 1: r = 1, edge 2: t = 1 (backwards), edge 3: r = 0 (backwards)
static const int edge_start[4] = {0, 1, 3, 0}, edge_end[4] = {1, 2, 2, 3};
static const bool edge_forward[4] = {true, true, false, false};

// Points closer than this are one point to the programs that read the file.
static const double same_mm = 1e-7;

double kn_step_same(double largest)
{
    return fmax(same_mm, 1e-12 * largest); // far above the rounding of a composition
}

// ---- the net ----

// Control point k of edge e.
static int edge_point(const kn_step_net *f, int e, int k)
{
    int nr = f->axis[0].n, nt = f->axis[1].n;
    switch (e) {
    case 0: return k * nt;
    case 1: return (nr - 1) * nt + k;
    case 2: return k * nt + nt - 1;
    default: return k;
    }
}

static int edge_length(const kn_step_net *f, int e)
{
    return f->axis[e % 2].n;
}

static int corner_point(const kn_step_net *f, int corner)
{
    int nr = f->axis[0].n, nt = f->axis[1].n;
    return (corner == 1 || corner == 2 ? nr - 1 : 0) * nt + (corner >= 2 ? nt - 1 : 0);
}

static bool same_point(const kn_step_net *f, const double *a, const double *b)
{
    for (int c = 0; c < 3; c++)
        if (fabs(a[c] - b[c]) > f->same) return false;
    return true;
}

// Which of kn_patch.edge edge e is.
static const int fitted[4] = {2, 1, 3, 0};

kn_status kn_step_edge_spline(kn_ctx *ctx, kn_spline *out, const kn_patch *patch, int e)
{
    if (patch->edge) return kn_spline_copy(ctx, out, &patch->edge[fitted[e]]);
    kn_spline s = kn_patch_spline(patch);
    return kn_spline_isoparametric(ctx, out, &s, 1 - e % 2, e == 1 || e == 2 ? 1.0 : 0.0);
}

static bool same_line(const kn_step_line *a, const kn_step_line *b)
{
    const kn_step_axis *x = &a->axis, *y = &b->axis;
    if (x->n != y->n || x->degree != y->degree || x->nbreaks != y->nbreaks || a->rational != b->rational)
        return false;
    for (int k = 0; k < x->nbreaks; k++)
        if (x->breaks[k] != y->breaks[k] || x->times[k] != y->times[k]) return false;
    for (int k = 0; k < x->n; k++)
        for (int c = 0; c < (a->rational ? 4 : 3); c++)
            if (a->point[k * a->step + c] != b->point[k * b->step + c]) return false;
    return true;
}

// The end of the surface itself, on its points; equal weights are left out.
static void end_line(kn_step_line *line, const kn_step_net *f, int e)
{
    int first = edge_point(f, e, 0), n = edge_length(f, e), next = n > 1 ? edge_point(f, e, 1) - first : 0;
    *line = (kn_step_line){.axis = f->axis[e % 2], .point = f->point + 4 * first, .step = 4 * (ptrdiff_t)next};
    line->first = (uint32_t)first, line->next = (uint32_t)next;
    for (int k = 1; k < n; k++) line->rational = line->rational || line->point[k * line->step + 3] != line->point[3];
}

kn_status kn_step_load(kn_ctx *ctx, kn_step_net *net, const kn_patch *patch, double mm)
{
    kn_spline s = kn_patch_spline(patch);
    double *point = NULL, largest = 0.0;
    *net = (kn_step_net){.n = (int)kn_spline_count(&s)};
    kn_status status = KN_OK;
    for (int v = 0; v < 2 && status == KN_OK; v++) status = kn_step_load_axis(ctx, &net->axis[v], &s, v);
    if (status == KN_OK) status = kn_step_load_points(ctx, &point, &net->rational, &largest, &s, mm, "patch");
    if (status != KN_OK) return status;
    net->point = point;
    net->same = kn_step_same(largest);
    net->numbers = (uint32_t)net->n + 1;
    for (int e = 0; e < 4 && status == KN_OK; e++) {
        kn_step_line own;
        end_line(&net->line[e], net, e);
        if (!patch->edge) continue;
        status = kn_step_load_line(ctx, &own, &patch->edge[fitted[e]], mm, net->numbers);
        if (status != KN_OK || same_line(&own, &net->line[e])) continue;
        net->line[e] = own;
        net->numbers += (uint32_t)own.axis.n;
    }
    return status;
}

// ---- text ----

void kn_step_put_points(kn_text *text, const kn_step_net *f)
{
    for (int k = 0; k < f->n; k++) kn_step_put_point(text, (uint32_t)k, f->point + 4 * k, 3);
}

// A list of lists of point numbers or of weights.
static void put_net(kn_text *text, const kn_step_net *f, bool weights)
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
static void put_surface_shape(kn_text *text, const kn_step_net *f)
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

static void put_surface_knots(kn_text *text, const kn_step_net *f)
{
    for (int v = 0; v < 2; v++) kn_step_put_times(text, &f->axis[v], false), kn_text_char(text, ',');
    for (int v = 0; v < 2; v++) kn_step_put_breaks(text, &f->axis[v], false), kn_text_char(text, ',');
    kn_text_put(text, ".UNSPECIFIED.");
}

void kn_step_put_surface(kn_text *text, const kn_step_net *f)
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

static kn_brep_key corner_key(const kn_step_net *f, int corner)
{
    bool turned;
    return kn_brep_hash(&turned, f->point + 4 * corner_point(f, corner), 3, 1, 1, 0);
}

static bool equal_keys(kn_brep_key a, kn_brep_key b)
{
    return a.a == b.a && a.b == b.b;
}

// Keys of edges, which are points, which vertices are one therefore, and whether the surface is closed.
static void find_edges(kn_step_item *item, kn_step_net *f, bool turned[4])
{
    kn_brep_key key[4];
    for (int e = 0; e < 4; e++) {
        const kn_step_line *line = &f->line[e];
        bool point = true;
        key[e] = kn_step_line_key(&turned[e], line);
        for (int k = 1; k < line->axis.n; k++)
            point = point && same_point(f, line->point, line->point + k * line->step);
        kn_brep_key start = corner_key(f, edge_start[e]), end = corner_key(f, edge_end[e]);
        if (point) {
            if (equal_keys(start, end)) continue;
            item->pair[item->npairs][0] = start, item->pair[item->npairs++][1] = end;
            continue;
        }
        int at = item->nedges++, from = turned[e] ? edge_end[e] : edge_start[e];
        int to = turned[e] ? edge_start[e] : edge_end[e];
        item->edge[at] = e;
        item->along[at] = edge_forward[e] != turned[e];
        item->edges[at] = (kn_brep_edge){.key = key[e], .forward = item->along[at] != item->reversed};
        item->edges[at].vertex[0] = turned[e] ? end : start, item->edges[at].vertex[1] = turned[e] ? start : end;
        item->corner[at][0] = (uint32_t)corner_point(f, from), item->corner[at][1] = (uint32_t)corner_point(f, to);
    }
    for (int v = 0; v < 2; v++) // closed in r: the edges r = 0 and r = 1 are one
        f->closed[v] = equal_keys(key[v == 0 ? 3 : 0], key[v == 0 ? 1 : 2]) &&
                       turned[v == 0 ? 3 : 0] == turned[v == 0 ? 1 : 2];
}

void kn_step_name(char name[KN_STEP_NAME_BYTES], const kn_step_naming *naming, const kn_patch_id *id,
                  const char *part, bool face, bool exact)
{
    size_t room = (size_t)KN_STEP_NAME_BYTES;
    const char *surface = id->surface >= 0 && id->surface < naming->nsurfaces ? naming->surfaces[id->surface] : "";
    int n = surface[0] ? snprintf(name, room, "%.*s", KN_NAME_BYTES - 1, surface)
                       : snprintf(name, room, "s%d", id->surface);
    n += snprintf(name + n, room - (size_t)n, " c%d,%d %.*s", id->cell[0], id->cell[1], KN_NAME_BYTES - 1, part);
    if (!face) return;
    n += snprintf(name + n, room - (size_t)n, " %d", id->patch);
    if (id->piece > 0) n += snprintf(name + n, room - (size_t)n, ".%d", id->piece);
    if (naming->mark && !exact) snprintf(name + n, room - (size_t)n, " ~");
}

// The way from an end of an edge to its next control point that is another point. False: that is not the next one, or
// far nearer than others are: the curve starts slowly.
static bool leave(double way[3], const kn_step_net *f, const kn_step_line *line, bool from_end)
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
static bool ill_conditioned(const kn_step_item *item, const kn_step_net *f)
{
    bool ill = item->nedges < 4;
    for (int k = 0; k < 4 && !ill; k++) {
        double a[3], b[3], c[3], aa = 0.0, bb = 0.0, cc = 0.0;
        ill = !leave(a, f, &f->line[k >= 2 ? 2 : 0], k == 1 || k == 2) ||
              !leave(b, f, &f->line[k == 1 || k == 2 ? 1 : 3], k >= 2);
        if (ill) break;
        for (int i = 0; i < 3; i++) {
            c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
            aa += a[i] * a[i], bb += b[i] * b[i], cc += c[i] * c[i];
        }
        ill = !(cc > 0.01 * aa * bb);
    }
    return ill;
}

// Four corners, then of each edge a line along its side of the square, whose parameter is that of the curve in space;
// numbers from `first` on, of which it answers the next free one.
static uint32_t put_plane_curves(kn_text *text, kn_step_item *item, const kn_step_net *f, const bool turned[4],
                                 uint32_t first)
{
    uint32_t context = first + 4, next = first + 5;
    for (int k = 0; k < 4; k++) {
        const double at[2] = {k == 1 || k == 2 ? 1.0 : 0.0, k >= 2 ? 1.0 : 0.0};
        kn_step_put_point(text, first + (uint32_t)k, at, 2);
    }
    kn_step_put_relative(text, context);
    kn_text_put(text, "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()"
                      "REPRESENTATION_CONTEXT('2D SPACE',''));");
    kn_text_newline(text);
    for (int i = 0; i < item->nedges; i++, next += 3) {
        int e = item->edge[i], from = turned[e] ? edge_end[e] : edge_start[e],
            to = turned[e] ? edge_start[e] : edge_end[e];
        kn_step_put_form(text, next,
                         "B_SPLINE_CURVE_WITH_KNOTS('',1,(#,#),.UNSPECIFIED.,.F.,.F.,(2,2),(0.,1.),.UNSPECIFIED.);",
                         (uint32_t[]){first + (uint32_t)from, first + (uint32_t)to});
        kn_step_put_form(text, next + 1, "DEFINITIONAL_REPRESENTATION('',(#),#);", (uint32_t[]){next, context});
        kn_step_put_form(text, next + 2, "PCURVE('',#,#);", (uint32_t[]){(uint32_t)f->n, next + 1});
        item->pcurve[i] = next + 2;
    }
    return next;
}

kn_status kn_step_put_face(kn_text *text, kn_step_item *item, const kn_patch *patch, const kn_step_naming *naming,
                           const char *part, double mm)
{
    *item = (kn_step_item){.kind = KN_STEP_FACE, .look = patch->look, .id = patch->id};
    item->reversed = patch->reversed, item->exact = patch->exact;
    if (patch->trim) return kn_step_put_trimmed(text, item, patch, naming, part, mm);
    kn_step_net f;
    bool turned[4];
    kn_mark mark = kn_scratch_mark(text->ctx);
    kn_status status = kn_step_load(text->ctx, &f, patch, mm);
    if (status == KN_OK) {
        find_edges(item, &f, turned);
        kn_step_put_points(text, &f);
        kn_step_put_surface(text, &f);
        item->numbers = f.numbers, item->main = (uint32_t)f.n;
        if (item->nedges > 0 && ill_conditioned(item, &f))
            item->numbers = put_plane_curves(text, item, &f, turned, f.numbers);
        item->text_end = text->bytes;
        for (int e = 0, at = 0; e < 4; e++) {
            bool used = at < item->nedges && item->edge[at] == e;
            const kn_brep_edge *b = &item->edges[at];
            at += used;
            if (used && f.line[e].own) kn_step_put_line_points(text, &f.line[e]);
            item->curve_begin[e] = text->bytes;
            if (used) kn_step_put_line(text, &f.line[e], turned[e], equal_keys(b->vertex[0], b->vertex[1]));
            item->curve_end[e] = text->bytes;
        }
    }
    kn_scratch_release(text->ctx, mark);
    return status == KN_OK && text->failed ? KN_ENOMEM : status;
}
