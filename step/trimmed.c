// SPDX-License-Identifier: Apache-2.0
// A trimmed patch as an ADVANCED_FACE: each curve of the trim is an edge with a curve in space and one in the plane
// of the surface's parameters (SURFACE_CURVE, PCURVE), both over the same knots.
//
// Along an edge of the square the curve in space is the patch's own, restricted. Elsewhere it is a cubic for each
// segment of the trim (subdivided where it bends), which has the patch's points and derivatives along the trim at the
// ends: of fourth order, and C0 where the polyline has corners.
#include "step/face.h"
#include "kernel/context.h"

#include <math.h>
#include <string.h>

enum {
    FACE_NUMBERS = 3, // after the plain face's: context, outer loop and bound come from the curves' own
    CURVE_NUMBERS =
        9, // vertex, curves in space and plane, representation, pcurve, surface curve, edge, oriented edge
    LOOP_NUMBERS = 2,
};

// One curve of the trim, sampled: n points in the plane, of degree 1 there; n - 1 cubics in space, or one of the
// degree of the patch's edge.
typedef struct edge {
    double (*plane)[2];
    double *space; // x, y, z, weight
    int n, points, degree;
    bool collapsed;
    uint32_t first;
    int vertex; // of the curve whose first point is its start
} edge;

typedef struct trimmed {
    kn_text *text;
    const kn_patch *patch;
    const kn_bezier *surface; // in mm
    kn_step_net net;
    edge *edges;
} trimmed;

static bool on_border(const kn_spline *c, int *var)
{
    int n = c->count[0];
    for (int v = 0; v < 2; v++) {
        double at = c->coef[(1 - v) * n];
        bool all = c->degree[0] == 1 && n == 2 && (at == 0.0 || at == 1.0);
        if (!all || c->coef[(1 - v) * n + 1] != at) continue;
        *var = v;
        return true;
    }
    return false;
}

// Points of a trim curve: those of a polyline are its own; of others, per span.
static int plane_points(const kn_spline *c)
{
    return c->degree[0] == 1 ? c->count[0] : 1 + 8 * kn_spline_spans(c, 0);
}

static int space_points(const kn_patch *patch, const kn_spline *c)
{
    int v;
    return on_border(c, &v) ? patch->bezier.degree[v] + 1 : 3 * (plane_points(c) - 1) + 1;
}

// ---- geometry ----

static kn_status sample_plane(kn_ctx *ctx, edge *e, const kn_spline *c)
{
    int n = c->count[0];
    if (c->degree[0] == 1) {
        for (int k = 0; k < n; k++) e->plane[k][0] = c->coef[k], e->plane[k][1] = c->coef[n + k];
        return KN_OK;
    }
    double lo, hi;
    kn_spline_domain(c, 0, &lo, &hi);
    kn_status status = KN_OK;
    for (int k = 0; status == KN_OK && k < e->n; k++) {
        double at = k + 1 == e->n ? hi : lo + (hi - lo) * k / (e->n - 1);
        status = kn_spline_eval(ctx, e->plane[k], c, &at);
    }
    e->plane[0][0] = c->coef[0], e->plane[0][1] = c->coef[n];
    e->plane[e->n - 1][0] = c->coef[n - 1], e->plane[e->n - 1][1] = c->coef[2 * n - 1];
    return status;
}

// Control points j = 0 .. 3 of the cubic over segment k.
static kn_status add_cubic(kn_ctx *ctx, const trimmed *t, edge *e, int k)
{
    double from[9], to[9], d[2];
    kn_status status = kn_bezier_derivatives(ctx, from, t->surface, e->plane[k], 1);
    if (status == KN_OK) status = kn_bezier_derivatives(ctx, to, t->surface, e->plane[k + 1], 1);
    if (status != KN_OK) return status;
    for (int c = 0; c < 2; c++) d[c] = e->plane[k + 1][c] - e->plane[k][c];
    double *p = e->space + 12 * k;
    for (int c = 0; c < 3; c++) {
        p[c] = from[c];
        p[4 + c] = from[c] + (from[3 + c] * d[0] + from[6 + c] * d[1]) / 3.0;
        p[8 + c] = to[c] - (to[3 + c] * d[0] + to[6 + c] * d[1]) / 3.0;
        p[12 + c] = to[c];
    }
    for (int j = 0; j < 4; j++) p[4 * j + 3] = 1.0;
    return KN_OK;
}

static kn_status add_border(kn_ctx *ctx, const trimmed *t, edge *e, int v)
{
    kn_bezier part = {0};
    double lo[2], hi[2];
    for (int c = 0; c < 2; c++) lo[c] = e->plane[0][c], hi[c] = e->plane[1][c];
    bool upper = lo[1 - v] == 1.0;
    lo[1 - v] = 0.0, hi[1 - v] = 1.0;
    kn_status status = kn_bezier_restrict(ctx, &part, t->surface, lo, hi); // lo > hi runs it backwards
    size_t n = status == KN_OK ? kn_bezier_count(&part) : 0;
    int m = part.degree[1] + 1;
    for (int k = 0; status == KN_OK && k < e->points; k++) {
        int across = upper ? part.degree[1 - v] : 0;
        size_t at = (size_t)(v == 0 ? k * m + across : across * m + k);
        double weight = part.rational ? part.coef[3 * n + at] : 1.0;
        for (size_t c = 0; c < 3; c++) e->space[4 * (size_t)k + c] = part.coef[c * n + at] / weight;
        e->space[4 * k + 3] = weight;
    }
    kn_bezier_clear(ctx, &part);
    return status;
}

static kn_status make_edge(kn_ctx *ctx, trimmed *t, edge *e, const kn_spline *c)
{
    int v = 0;
    bool border = on_border(c, &v);
    e->n = plane_points(c);
    e->points = space_points(t->patch, c);
    e->degree = border ? e->points - 1 : 3;
    e->plane = kn_scratch(ctx, (size_t)e->n, sizeof *e->plane);
    e->space = kn_scratch(ctx, (size_t)e->points, 4 * sizeof *e->space);
    if (!e->plane || !e->space) return KN_ENOMEM;
    kn_status status = sample_plane(ctx, e, c);
    if (border && status == KN_OK) status = add_border(ctx, t, e, v);
    for (int k = 0; !border && status == KN_OK && k + 1 < e->n; k++) status = add_cubic(ctx, t, e, k);
    e->collapsed = true;
    for (int k = 1; k < e->points; k++)
        for (int x = 0; x < 3; x++)
            e->collapsed = e->collapsed && fabs(e->space[4 * k + x] - e->space[x]) <= t->net.same;
    return status;
}

// A curve that is a point has no edge; its start is then that of the next one.
static void join_vertices(trimmed *t)
{
    const kn_trim *trim = t->patch->trim;
    for (int i = 0, first = 0; i < trim->nloops; first = trim->loop_end[i++]) {
        int n = trim->loop_end[i] - first;
        for (int k = 0; k < n; k++) {
            int at = k, steps = 0;
            while (t->edges[first + at].collapsed && steps++ < n) at = (at + 1) % n;
            t->edges[first + k].vertex = first + at;
        }
    }
}

// ---- text ----

static void put_point(kn_text *text, uint32_t number, const double *p, int dim)
{
    kn_step_put_relative(text, number);
    kn_text_put(text, "CARTESIAN_POINT('',(");
    for (int c = 0; c < dim; c++) {
        if (c > 0) kn_text_char(text, ',');
        kn_text_step_real(text, p[c]);
    }
    kn_text_put(text, "));");
    kn_text_newline(text);
}

static void put_list(kn_text *text, uint32_t first, int n)
{
    kn_text_char(text, '(');
    for (int k = 0; k < n; k++) {
        if (k > 0) kn_text_comma(text);
        kn_text_relative(text, first + (uint32_t)k);
    }
    kn_text_char(text, ')');
}

// Knots 0 .. spans, degree + 1 of them at the ends and degree between: pieces that meet.
static void put_knots(kn_text *text, int degree, int spans)
{
    kn_text_char(text, '(');
    for (int k = 0; k <= spans; k++) {
        if (k > 0) kn_text_comma(text);
        kn_text_integer(text, (uint64_t)(k == 0 || k == spans ? degree + 1 : degree));
    }
    kn_text_put(text, "),(");
    for (int k = 0; k <= spans; k++) {
        if (k > 0) kn_text_comma(text);
        kn_text_step_real(text, k);
    }
    kn_text_put(text, "),.UNSPECIFIED.");
}

static void put_space_curve(const trimmed *t, const edge *e, uint32_t number, uint32_t points)
{
    kn_text *text = t->text;
    bool rational = false;
    for (int k = 1; k < e->points; k++) rational = rational || e->space[4 * k + 3] != e->space[3];
    int spans = (e->points - 1) / e->degree;
    kn_step_put_relative(text, number);
    kn_text_put(text, rational ? "(BOUNDED_CURVE()B_SPLINE_CURVE(" : "B_SPLINE_CURVE_WITH_KNOTS('',");
    kn_text_integer(text, (uint64_t)e->degree);
    kn_text_char(text, ',');
    put_list(text, points, e->points);
    kn_text_put(text, rational ? ",.UNSPECIFIED.,.F.,.F.)B_SPLINE_CURVE_WITH_KNOTS(" : ",.UNSPECIFIED.,.F.,.F.,");
    put_knots(text, e->degree, spans);
    if (rational) {
        kn_text_put(text, ")CURVE()GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_CURVE((");
        for (int k = 0; k < e->points; k++) {
            if (k > 0) kn_text_comma(text);
            kn_text_step_real(text, e->space[4 * k + 3]);
        }
        kn_text_put(text, "))REPRESENTATION_ITEM('')");
    }
    kn_text_put(text, ");");
    kn_text_newline(text);
}

// Its number and the form, whose every '#' is the next one of the references.
static void put_form(kn_text *text, uint32_t number, const char *form, const uint32_t *references)
{
    kn_step_put_relative(text, number);
    for (; *form; form++) {
        if (*form == '#')
            kn_text_relative(text, *references++);
        else
            kn_text_char(text, *form);
    }
    kn_text_newline(text);
}

// first + 0 vertex, 1 curve in space, 2 curve in the plane, 3 representation, 4 pcurve, 5 surface curve, 6 edge,
// 7 oriented edge; then the points.
static void put_edge(const trimmed *t, const edge *e, uint32_t from, uint32_t to, uint32_t context)
{
    kn_text *text = t->text;
    uint32_t f = e->first, points = f + CURVE_NUMBERS, plane = points + (uint32_t)e->points;
    for (int k = 0; k < e->points; k++) put_point(text, points + (uint32_t)k, e->space + 4 * k, 3);
    for (int k = 0; k < e->n; k++) put_point(text, plane + (uint32_t)k, e->plane[k], 2);
    put_form(text, f, "VERTEX_POINT('',#);", (uint32_t[]){points});
    put_space_curve(t, e, f + 1, points);
    kn_step_put_relative(text, f + 2);
    kn_text_put(text, "B_SPLINE_CURVE_WITH_KNOTS('',1,");
    put_list(text, plane, e->n);
    kn_text_put(text, ",.UNSPECIFIED.,.F.,.F.,");
    put_knots(text, 1, e->n - 1);
    kn_text_put(text, ");");
    kn_text_newline(text);
    put_form(text, f + 3, "DEFINITIONAL_REPRESENTATION('',(#),#);", (uint32_t[]){f + 2, context});
    put_form(text, f + 4, "PCURVE('',#,#);", (uint32_t[]){(uint32_t)t->net.n, f + 3});
    put_form(text, f + 5, "SURFACE_CURVE('',#,(#),.CURVE_3D.);", (uint32_t[]){f + 1, f + 4});
    put_form(text, f + 6, "EDGE_CURVE('',#,#,#,.T.);", (uint32_t[]){from, to, f + 5});
    put_form(text, f + 7, "ORIENTED_EDGE('',*,*,#,.T.);", (uint32_t[]){f + 6});
}

static double area_of(const trimmed *t, int first, int last)
{
    double sum = 0.0;
    for (int k = first; k < last; k++)
        for (int i = 0; i + 1 < t->edges[k].n; i++) {
            const double *p = t->edges[k].plane[i], *q = t->edges[k].plane[i + 1];
            sum += p[0] * q[1] - p[1] * q[0];
        }
    return sum;
}

// bound: the number of the loop's FACE_BOUND; the loop is the next one.
static void put_loop(const trimmed *t, int first, int last, uint32_t context, uint32_t bound)
{
    kn_text *text = t->text;
    int n = last - first;
    for (int k = 0; k < n; k++) {
        const edge *e = &t->edges[first + k];
        uint32_t from = t->edges[e->vertex].first, to = t->edges[t->edges[first + (k + 1) % n].vertex].first;
        if (!e->collapsed) put_edge(t, e, from, to, context);
    }
    bool written = false;
    kn_step_put_relative(text, bound + 1);
    kn_text_put(text, "EDGE_LOOP('',(");
    for (int k = first; k < last; k++) {
        if (t->edges[k].collapsed) continue;
        if (written) kn_text_comma(text);
        kn_text_relative(text, t->edges[k].first + 7);
        written = true;
    }
    kn_text_put(text, "));");
    kn_text_newline(text);
    put_form(text, bound,
             area_of(t, first, last) > 0.0
                 ? (t->patch->reversed ? "FACE_OUTER_BOUND('',#,.F.);" : "FACE_OUTER_BOUND('',#,.T.);")
                 : (t->patch->reversed ? "FACE_BOUND('',#,.F.);" : "FACE_BOUND('',#,.T.);"),
             (uint32_t[]){bound + 1});
}

// ---- the face ----

static uint32_t put_all(trimmed *t, const char *part)
{
    kn_text *text = t->text;
    const kn_trim *trim = t->patch->trim;
    char name[KN_STEP_NAME_BYTES];
    uint32_t context = (uint32_t)t->net.n + KN_STEP_FACE_NUMBERS, bounds = context + FACE_NUMBERS;
    uint32_t next = bounds + LOOP_NUMBERS * (uint32_t)trim->nloops;
    for (int k = 0; k < trim->ncurves; k++) {
        t->edges[k].first = next;
        next += CURVE_NUMBERS + (uint32_t)t->edges[k].points + (uint32_t)t->edges[k].n;
    }
    join_vertices(t);
    kn_step_put_points(text, &t->net);
    kn_step_put_surface(text, &t->net);
    put_form(text, context,
             "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()"
             "REPRESENTATION_CONTEXT('2D SPACE',''));",
             NULL);
    for (int i = 0, first = 0; i < trim->nloops; first = trim->loop_end[i++])
        put_loop(t, first, trim->loop_end[i], context, bounds + LOOP_NUMBERS * (uint32_t)i);
    kn_step_name(name, &t->patch->id, part, true);
    kn_step_put_relative(text, (uint32_t)t->net.n + KN_STEP_FACE_NUMBERS - 1);
    kn_text_put(text, "ADVANCED_FACE(");
    kn_text_step_string(text, name);
    kn_text_put(text, ",(");
    for (int i = 0; i < trim->nloops; i++) {
        if (i > 0) kn_text_comma(text);
        kn_text_relative(text, bounds + LOOP_NUMBERS * (uint32_t)i);
    }
    kn_text_put(text, "),");
    kn_text_relative(text, (uint32_t)t->net.n);
    kn_text_put(text, t->patch->reversed ? ",.F.);" : ",.T.);");
    kn_text_newline(text);
    return next;
}

kn_status kn_step_put_trimmed(kn_text *text, kn_step_item *item, const kn_patch *patch, const char *part, double mm)
{
    kn_ctx *ctx = text->ctx;
    const kn_bezier *b = &patch->bezier;
    kn_bezier surface = {0};
    trimmed t = {.text = text, .patch = patch, .surface = &surface};
    kn_mark mark = kn_scratch_mark(ctx);
    t.edges = kn_scratch(ctx, (size_t)patch->trim->ncurves, sizeof *t.edges);
    kn_status status = t.edges ? kn_step_load(ctx, &t.net, patch, mm) : KN_ENOMEM;
    if (status == KN_OK) status = kn_bezier_scale(ctx, &surface, b, mm);
    if (status == KN_OK) memset(t.edges, 0, (size_t)patch->trim->ncurves * sizeof *t.edges);
    for (int k = 0; status == KN_OK && k < patch->trim->ncurves; k++)
        status = make_edge(ctx, &t, &t.edges[k], &patch->trim->curves[k]);
    if (status == KN_OK) {
        item->kind = KN_STEP_TRIMMED;
        item->numbers = put_all(&t, part);
        item->main = (uint32_t)t.net.n + KN_STEP_FACE_NUMBERS - 1;
        item->text_end = text->bytes;
    }
    kn_bezier_clear(ctx, &surface);
    kn_scratch_release(ctx, mark);
    return status == KN_OK && text->failed ? KN_ENOMEM : status;
}
