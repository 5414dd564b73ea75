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

// One curve of the trim, sampled: n points in the plane, of degree 1 there, over the knots 0 .. n - 1; in space n - 1
// cubics over the same knots, or a part of the patch's edge.
typedef struct edge {
    double (*plane)[2];
    kn_step_line line;
    int n;
    bool collapsed;
    uint32_t first;
    int vertex; // of the curve whose first point is its start
} edge;

typedef struct trimmed {
    kn_text *text;
    const kn_patch *patch;
    double mm;
    kn_spline surface; // in mm
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
static kn_status add_cubic(kn_ctx *ctx, const trimmed *t, const edge *e, double *p, int k)
{
    double from[9], to[9], d[2];
    kn_status status = kn_spline_derivatives(ctx, from, &t->surface, e->plane[k], 1);
    if (status == KN_OK) status = kn_spline_derivatives(ctx, to, &t->surface, e->plane[k + 1], 1);
    if (status != KN_OK) return status;
    for (int c = 0; c < 2; c++) d[c] = e->plane[k + 1][c] - e->plane[k][c];
    for (int c = 0; c < 3; c++) {
        p[c] = from[c];
        p[4 + c] = from[c] + (from[3 + c] * d[0] + from[6 + c] * d[1]) / 3.0;
        p[8 + c] = to[c] - (to[3 + c] * d[0] + to[6 + c] * d[1]) / 3.0;
        p[12 + c] = to[c];
    }
    for (int j = 0; j < 4; j++) p[4 * j + 3] = 1.0;
    return KN_OK;
}

// Knots 0 .. spans, degree + 1 of them at the ends and degree between: pieces that meet.
static kn_status even_axis(kn_ctx *ctx, kn_step_axis *x, int degree, int spans)
{
    int *times = kn_scratch(ctx, (size_t)spans + 1, sizeof *times);
    double *breaks = kn_scratch(ctx, (size_t)spans + 1, sizeof *breaks);
    if (!times || !breaks) return KN_ENOMEM;
    for (int k = 0; k <= spans; k++) {
        times[k] = k == 0 || k == spans ? degree + 1 : degree;
        breaks[k] = k;
    }
    *x = (kn_step_axis){degree, degree * spans + 1, spans + 1, times, breaks};
    return KN_OK;
}

static kn_status add_cubics(kn_ctx *ctx, const trimmed *t, edge *e)
{
    int spans = e->n - 1;
    double *point = kn_scratch(ctx, 3 * (size_t)spans + 1, 4 * sizeof *point);
    kn_status status = point ? even_axis(ctx, &e->line.axis, 3, spans) : KN_ENOMEM;
    for (int k = 0; k < spans && status == KN_OK; k++) status = add_cubic(ctx, t, e, point + 12 * k, k);
    e->line.point = point, e->line.step = 4, e->line.own = true, e->line.next = 1;
    return status;
}

// Along the side of the square where variable v runs.
static kn_status add_border(kn_ctx *ctx, const trimmed *t, edge *e, int v)
{
    double from = e->plane[0][v], to = e->plane[1][v], lo = fmin(from, to), hi = fmax(from, to);
    bool upper = e->plane[0][1 - v] == 1.0;
    kn_spline part = {0};
    kn_status status = kn_step_edge_spline(ctx, &part, t->patch, v == 0 ? (upper ? 2 : 0) : (upper ? 1 : 3));
    if (status == KN_OK && (lo > 0.0 || hi < 1.0)) status = kn_spline_restrict(ctx, &part, &part, &lo, &hi);
    if (status == KN_OK && from > to) status = kn_spline_reverse(ctx, &part, &part, 0);
    if (status == KN_OK) status = kn_step_load_line(ctx, &e->line, &part, t->mm, 0);
    kn_spline_clear(ctx, &part);
    return status;
}

static kn_status make_edge(kn_ctx *ctx, const trimmed *t, edge *e, const kn_spline *c)
{
    int v = 0;
    e->n = plane_points(c);
    e->plane = kn_scratch(ctx, (size_t)e->n, sizeof *e->plane);
    if (!e->plane) return KN_ENOMEM;
    kn_status status = sample_plane(ctx, e, c);
    if (status == KN_OK) status = on_border(c, &v) ? add_border(ctx, t, e, v) : add_cubics(ctx, t, e);
    if (status != KN_OK) return status;
    e->collapsed = true;
    for (int k = 1; k < e->line.axis.n; k++)
        for (int x = 0; x < 3; x++)
            e->collapsed = e->collapsed && fabs(e->line.point[4 * k + x] - e->line.point[x]) <= t->net.same;
    return KN_OK;
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

static void put_list(kn_text *text, uint32_t first, int n)
{
    kn_text_char(text, '(');
    for (int k = 0; k < n; k++) {
        if (k > 0) kn_text_comma(text);
        kn_text_relative(text, first + (uint32_t)k);
    }
    kn_text_char(text, ')');
}

// A polyline over the knots 0 .. n - 1.
static void put_plane_curve(kn_text *text, const edge *e, uint32_t number, uint32_t points)
{
    kn_step_put_relative(text, number);
    kn_text_put(text, "B_SPLINE_CURVE_WITH_KNOTS('',1,");
    put_list(text, points, e->n);
    kn_text_put(text, ",.UNSPECIFIED.,.F.,.F.,(");
    for (int k = 0; k < e->n; k++) {
        if (k > 0) kn_text_comma(text);
        kn_text_char(text, k == 0 || k == e->n - 1 ? '2' : '1');
    }
    kn_text_put(text, "),(");
    for (int k = 0; k < e->n; k++) {
        if (k > 0) kn_text_comma(text);
        kn_text_step_real(text, k);
    }
    kn_text_put(text, "),.UNSPECIFIED.);");
    kn_text_newline(text);
}

// first + 0 vertex, 1 curve in space, 2 curve in the plane, 3 representation, 4 pcurve, 5 surface curve, 6 edge,
// 7 oriented edge; then the points.
static void put_edge(const trimmed *t, const edge *e, uint32_t from, uint32_t to, uint32_t context)
{
    kn_text *text = t->text;
    uint32_t f = e->first, points = f + CURVE_NUMBERS, plane = points + (uint32_t)e->line.axis.n;
    kn_step_line line = e->line;
    line.first = points;
    kn_step_put_line_points(text, &line);
    for (int k = 0; k < e->n; k++) kn_step_put_point(text, plane + (uint32_t)k, e->plane[k], 2);
    kn_step_put_form(text, f, "VERTEX_POINT('',#);", (uint32_t[]){points});
    kn_step_put_relative(text, f + 1);
    kn_step_put_line(text, &line, false, false);
    put_plane_curve(text, e, f + 2, plane);
    kn_step_put_form(text, f + 3, "DEFINITIONAL_REPRESENTATION('',(#),#);", (uint32_t[]){f + 2, context});
    kn_step_put_form(text, f + 4, "PCURVE('',#,#);", (uint32_t[]){(uint32_t)t->net.n, f + 3});
    kn_step_put_form(text, f + 5, "SURFACE_CURVE('',#,(#),.CURVE_3D.);", (uint32_t[]){f + 1, f + 4});
    kn_step_put_form(text, f + 6, "EDGE_CURVE('',#,#,#,.T.);", (uint32_t[]){from, to, f + 5});
    kn_step_put_form(text, f + 7, "ORIENTED_EDGE('',*,*,#,.T.);", (uint32_t[]){f + 6});
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
    kn_step_put_form(text, bound,
                     area_of(t, first, last) > 0.0
                         ? (t->patch->reversed ? "FACE_OUTER_BOUND('',#,.F.);" : "FACE_OUTER_BOUND('',#,.T.);")
                         : (t->patch->reversed ? "FACE_BOUND('',#,.F.);" : "FACE_BOUND('',#,.T.);"),
                     (uint32_t[]){bound + 1});
}

// ---- the face ----

static uint32_t put_all(trimmed *t, const kn_step_naming *naming, const char *part)
{
    kn_text *text = t->text;
    const kn_trim *trim = t->patch->trim;
    char name[KN_STEP_NAME_BYTES];
    uint32_t context = (uint32_t)t->net.n + KN_STEP_FACE_NUMBERS, bounds = context + FACE_NUMBERS;
    uint32_t next = bounds + LOOP_NUMBERS * (uint32_t)trim->nloops;
    for (int k = 0; k < trim->ncurves; k++) {
        t->edges[k].first = next;
        next += CURVE_NUMBERS + (uint32_t)t->edges[k].line.axis.n + (uint32_t)t->edges[k].n;
    }
    join_vertices(t);
    kn_step_put_points(text, &t->net);
    kn_step_put_surface(text, &t->net);
    kn_step_put_form(text, context,
                     "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()"
                     "REPRESENTATION_CONTEXT('2D SPACE',''));",
                     NULL);
    for (int i = 0, first = 0; i < trim->nloops; first = trim->loop_end[i++])
        put_loop(t, first, trim->loop_end[i], context, bounds + LOOP_NUMBERS * (uint32_t)i);
    kn_step_name(name, naming, &t->patch->id, part, true, t->patch->exact);
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

kn_status kn_step_put_trimmed(kn_text *text, kn_step_item *item, const kn_patch *patch, const kn_step_naming *naming,
                              const char *part, double mm)
{
    kn_ctx *ctx = text->ctx;
    trimmed t = {.text = text, .patch = patch, .mm = mm};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline s = kn_patch_spline(patch);
    t.edges = kn_scratch(ctx, (size_t)patch->trim->ncurves, sizeof *t.edges);
    kn_status status = t.edges ? kn_step_load(ctx, &t.net, patch, mm) : KN_ENOMEM;
    if (status == KN_OK) status = kn_spline_scale(ctx, &t.surface, &s, mm);
    if (status == KN_OK) memset(t.edges, 0, (size_t)patch->trim->ncurves * sizeof *t.edges);
    for (int k = 0; status == KN_OK && k < patch->trim->ncurves; k++)
        status = make_edge(ctx, &t, &t.edges[k], &patch->trim->curves[k]);
    if (status == KN_OK) {
        item->kind = KN_STEP_TRIMMED;
        item->numbers = put_all(&t, naming, part);
        item->main = (uint32_t)t.net.n + KN_STEP_FACE_NUMBERS - 1;
        item->text_end = text->bytes;
    }
    kn_spline_clear(ctx, &t.surface);
    kn_scratch_release(ctx, mark);
    return status == KN_OK && text->failed ? KN_ENOMEM : status;
}
