// SPDX-License-Identifier: Apache-2.0
// One patch as an ADVANCED_FACE: its surface, its boundary curves on the same control points, its loop.
#include "io/step_face.h"
#include "io/step_write.h"
#include "kernel/context.h"

#include <math.h>
#include <stdio.h>

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

uint64_t kn_step_face(const kn_bezier *b, uint64_t first)
{
    return first + kn_bezier_count(b) + KN_STEP_FACE_NUMBERS - 1;
}

uint64_t kn_step_number(const kn_step_net *f, int offset)
{
    return f->first + (uint64_t)(f->n + offset);
}

// Control point k of edge e, as an index into the net.
static int edge_point(const kn_step_net *f, int e, int k)
{
    switch (e) {
    case 0: return k * f->nt;
    case 1: return (f->nr - 1) * f->nt + k;
    case 2: return k * f->nt + f->nt - 1;
    default: return k;
    }
}

static int edge_length(const kn_step_net *f, int e)
{
    return e % 2 == 0 ? f->nr : f->nt;
}

static int corner_point(const kn_step_net *f, int corner)
{
    int r = corner == 1 || corner == 2 ? f->nr - 1 : 0, t = corner >= 2 ? f->nt - 1 : 0;
    return r * f->nt + t;
}

static bool same_point(const kn_step_net *f, int a, int b)
{
    for (int c = 0; c < 3; c++)
        if (fabs(f->point[4 * a + c] - f->point[4 * b + c]) > f->same) return false;
    return true;
}

// Scaled and projected points; *largest receives the largest coordinate.
kn_status kn_step_load(kn_ctx *ctx, double *point, double *largest, const kn_bezier *b, double mm)
{
    size_t n = kn_bezier_count(b);
    bool good = true;
    *largest = 0.0;
    for (size_t k = 0; k < n && good; k++) {
        double weight = b->rational ? b->coef[3 * n + k] : 1.0;
        good = weight > 0.0 && isfinite(weight);
        for (size_t c = 0; c < 3 && good; c++) {
            double x = b->coef[c * n + k] / weight * mm;
            point[4 * k + c] = x;
            good = isfinite(x);
            *largest = fmax(*largest, fabs(x));
        }
        point[4 * k + 3] = weight;
    }
    return good ? KN_OK : kn_fail(ctx, KN_EUNDEFINED, "STEP: a control point of a patch is not finite");
}

bool kn_step_weights_differ(const kn_bezier *b)
{
    size_t n = kn_bezier_count(b);
    for (size_t k = 1; k < n && b->rational; k++)
        if (b->coef[3 * n + k] != b->coef[3 * n]) return true;
    return false;
}

void kn_step_find_topology(kn_step_net *f)
{
    for (int c = 0; c < 4; c++) {
        f->vertex[c] = 0;
        while (!same_point(f, corner_point(f, c), corner_point(f, f->vertex[c]))) f->vertex[c]++;
    }
    for (int e = 0; e < 4; e++) {
        bool collapsed = true, seam = e >= 2;
        for (int k = 0; k < edge_length(f, e); k++) {
            collapsed = collapsed && same_point(f, edge_point(f, e, 0), edge_point(f, e, k));
            seam = seam && same_point(f, edge_point(f, e, k), edge_point(f, e - 2, k));
        }
        f->collapsed[e] = collapsed;
        f->curve[e] = seam ? e - 2 : e;
    }
}

void kn_step_put_points(kn_text *text, const kn_step_net *f)
{
    for (int k = 0; k < f->n; k++) {
        kn_step_put_number(text, f->first + (uint64_t)k);
        kn_text_put(text, "CARTESIAN_POINT('',(");
        for (int c = 0; c < 3; c++) {
            if (c > 0) kn_text_char(text, ',');
            kn_text_step_real(text, f->point[4 * k + c]);
        }
        kn_text_put(text, "));");
        kn_text_newline(text);
    }
}

// A list, or a list of lists, of point numbers or of weights.
static void put_net(kn_text *text, const kn_step_net *f, bool weights)
{
    kn_text_char(text, '(');
    for (int k = 0; k < f->n; k++) {
        if (k > 0) kn_text_comma(text);
        if (k % f->nt == 0) kn_text_char(text, '(');
        if (weights)
            kn_text_step_real(text, f->point[4 * k + 3]);
        else
            kn_text_reference(text, f->first + (uint64_t)k);
        if (k % f->nt == f->nt - 1) kn_text_char(text, ')');
    }
    kn_text_char(text, ')');
}

static void put_edge_list(kn_text *text, const kn_step_net *f, int e, bool weights)
{
    kn_text_char(text, '(');
    for (int k = 0; k < edge_length(f, e); k++) {
        int at = edge_point(f, e, k);
        if (k > 0) kn_text_comma(text);
        if (weights)
            kn_text_step_real(text, f->point[4 * at + 3]);
        else
            kn_text_reference(text, f->first + (uint64_t)at);
    }
    kn_text_char(text, ')');
}

void kn_step_put_logical(kn_text *text, bool value)
{
    kn_text_put(text, value ? ".T." : ".F.");
}

static void put_multiplicity(kn_text *text, int n)
{
    kn_text_char(text, '(');
    kn_text_integer(text, (uint64_t)n);
    kn_text_char(text, ',');
    kn_text_integer(text, (uint64_t)n);
    kn_text_char(text, ')');
}

// The attributes of B_SPLINE_SURFACE and of B_SPLINE_SURFACE_WITH_KNOTS, which the rational form lists apart.
static void put_surface_shape(kn_text *text, const kn_step_net *f)
{
    kn_text_integer(text, (uint64_t)(f->nr - 1));
    kn_text_char(text, ',');
    kn_text_integer(text, (uint64_t)(f->nt - 1));
    kn_text_char(text, ',');
    put_net(text, f, false);
    kn_text_put(text, ",.UNSPECIFIED.,");
    kn_step_put_logical(text, f->curve[3] != 3); // closed in r: the edges r = 0 and r = 1 coincide
    kn_text_char(text, ',');
    kn_step_put_logical(text, f->curve[2] != 2);
    kn_text_put(text, ",.F.");
}

static void put_surface_knots(kn_text *text, const kn_step_net *f)
{
    put_multiplicity(text, f->nr);
    kn_text_char(text, ',');
    put_multiplicity(text, f->nt);
    kn_text_put(text, ",(0.,1.),(0.,1.),.UNSPECIFIED.");
}

void kn_step_put_surface(kn_text *text, const kn_step_net *f)
{
    kn_step_put_number(text, kn_step_number(f, 0));
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

static void put_curve(kn_text *text, const kn_step_net *f, int e)
{
    bool closed = f->vertex[edge_start[e]] == f->vertex[edge_end[e]];
    kn_step_put_number(text, kn_step_number(f, 1 + e));
    kn_text_put(text, f->rational ? "(BOUNDED_CURVE()B_SPLINE_CURVE(" : "B_SPLINE_CURVE_WITH_KNOTS('',");
    kn_text_integer(text, (uint64_t)(edge_length(f, e) - 1));
    kn_text_char(text, ',');
    put_edge_list(text, f, e, false);
    kn_text_put(text, ",.UNSPECIFIED.,");
    kn_step_put_logical(text, closed);
    kn_text_put(text, f->rational ? ",.F.)B_SPLINE_CURVE_WITH_KNOTS(" : ",.F.,");
    put_multiplicity(text, edge_length(f, e));
    kn_text_put(text, ",(0.,1.),.UNSPECIFIED.");
    if (f->rational) {
        kn_text_char(text, ')');
        kn_text_newline(text);
        kn_text_put(text, "CURVE()GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_CURVE(");
        put_edge_list(text, f, e, true);
        kn_text_put(text, ")REPRESENTATION_ITEM('')");
    }
    kn_text_put(text, ");");
    kn_text_newline(text);
}

static void put_edge(kn_text *text, const kn_step_net *f, int e)
{
    kn_step_put_number(text, kn_step_number(f, 9 + e));
    kn_text_put(text, "EDGE_CURVE('',");
    kn_text_reference(text, kn_step_number(f, 5 + f->vertex[edge_start[e]]));
    kn_text_char(text, ',');
    kn_text_reference(text, kn_step_number(f, 5 + f->vertex[edge_end[e]]));
    kn_text_char(text, ',');
    kn_text_reference(text, kn_step_number(f, 1 + e));
    kn_text_put(text, ",.T.);");
    kn_text_newline(text);
}

static void put_vertex(kn_text *text, const kn_step_net *f, int corner)
{
    kn_step_put_number(text, kn_step_number(f, 5 + corner));
    kn_text_put(text, "VERTEX_POINT('',");
    kn_text_reference(text, f->first + (uint64_t)corner_point(f, corner));
    kn_text_put(text, ");");
    kn_text_newline(text);
}

static void put_oriented_edge(kn_text *text, const kn_step_net *f, int e)
{
    kn_step_put_number(text, kn_step_number(f, 13 + e));
    kn_text_put(text, "ORIENTED_EDGE('',*,*,");
    kn_text_reference(text, kn_step_number(f, 9 + f->curve[e]));
    kn_text_put(text, edge_forward[e] ? ",.T.);" : ",.F.);");
    kn_text_newline(text);
}

static void put_loop(kn_text *text, const kn_step_net *f)
{
    bool written = false;
    kn_step_put_number(text, kn_step_number(f, 17));
    kn_text_put(text, "EDGE_LOOP('',(");
    for (int e = 0; e < 4; e++) {
        if (f->collapsed[e]) continue;
        if (written) kn_text_char(text, ',');
        kn_text_reference(text, kn_step_number(f, 13 + e));
        written = true;
    }
    kn_text_put(text, "));");
    kn_text_newline(text);
}

// A patch like a balloon: its whole boundary is one point.
static void put_vertex_loop(kn_text *text, const kn_step_net *f)
{
    put_vertex(text, f, 0);
    kn_step_put_number(text, kn_step_number(f, 17));
    kn_text_put(text, "VERTEX_LOOP('',");
    kn_text_reference(text, kn_step_number(f, 5));
    kn_text_put(text, ");");
    kn_text_newline(text);
}

// Vertices and edges that are in use, then the edges in the order of the loop.
static void put_boundary(kn_text *text, const kn_step_net *f)
{
    bool used[4] = {false, false, false, false}, any = false;
    for (int e = 0; e < 4; e++) {
        if (f->collapsed[e]) continue;
        used[f->vertex[edge_start[e]]] = used[f->vertex[edge_end[e]]] = any = true;
    }
    if (!any) {
        put_vertex_loop(text, f);
        return;
    }
    for (int c = 0; c < 4; c++)
        if (used[c]) put_vertex(text, f, c);
    for (int e = 0; e < 4; e++) {
        if (f->collapsed[e]) continue;
        if (f->curve[e] == e) {
            put_curve(text, f, e);
            put_edge(text, f, e);
        }
        put_oriented_edge(text, f, e);
    }
    put_loop(text, f);
}

void kn_step_name(char name[KN_STEP_NAME_BYTES], const kn_patch_id *id, const char *part)
{
    int length = snprintf(name, (size_t)KN_STEP_NAME_BYTES, "s%d c%d,%d %s %d", id->surface, id->cell[0], id->cell[1],
                          part, id->patch);
    if (id->piece > 0 && length > 0 && (size_t)length < (size_t)KN_STEP_NAME_BYTES)
        snprintf(name + length, (size_t)KN_STEP_NAME_BYTES - (size_t)length, ".%d", id->piece);
}

// The loop runs counterclockwise about r x t. A reversed patch turns both the face and the loop over.
static void put_face(kn_text *text, const kn_step_net *f, const kn_patch_id *id, const char *part, bool reversed)
{
    char name[KN_STEP_NAME_BYTES];
    kn_step_name(name, id, part);
    kn_step_put_number(text, kn_step_number(f, 18));
    kn_text_put(text, "FACE_OUTER_BOUND('',");
    kn_text_reference(text, kn_step_number(f, 17));
    kn_text_char(text, ',');
    kn_step_put_logical(text, !reversed);
    kn_text_put(text, ");");
    kn_text_newline(text);
    kn_step_put_number(text, kn_step_number(f, 19));
    kn_text_put(text, "ADVANCED_FACE(");
    kn_text_step_string(text, name);
    kn_text_put(text, ",(");
    kn_text_reference(text, kn_step_number(f, 18));
    kn_text_put(text, "),");
    kn_text_reference(text, kn_step_number(f, 0));
    kn_text_char(text, ',');
    kn_step_put_logical(text, !reversed);
    kn_text_put(text, ");");
    kn_text_newline(text);
}

kn_status kn_step_put_face(kn_text *text, const kn_patch *patch, const char *part, uint64_t first, double mm)
{
    if (patch->trim) return kn_step_put_trimmed(text, patch, part, first, mm);
    const kn_bezier *b = &patch->bezier;
    kn_mark mark = kn_scratch_mark(text->ctx);
    double *point = kn_scratch(text->ctx, 4 * kn_bezier_count(b), sizeof *point), largest = 0.0;
    kn_status status = point != NULL ? kn_step_load(text->ctx, point, &largest, b, mm) : KN_ENOMEM;
    if (status == KN_OK) {
        kn_step_net f = {
            .nr = b->degree[0] + 1, .nt = b->degree[1] + 1, .rational = kn_step_weights_differ(b), .point = point};
        f.n = f.nr * f.nt;
        f.first = first;
        f.same = kn_step_same(largest);
        kn_step_find_topology(&f);
        kn_step_put_points(text, &f);
        kn_step_put_surface(text, &f);
        put_boundary(text, &f);
        put_face(text, &f, &patch->id, part, patch->reversed);
    }
    kn_scratch_release(text->ctx, mark);
    return status == KN_OK && text->failed ? KN_ENOMEM : status;
}
