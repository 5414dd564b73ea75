// SPDX-License-Identifier: Apache-2.0
// A trimmed patch as an ADVANCED_FACE: each curve of the trim is an edge with a curve in space and one in the plane
// of the surface's parameters (SURFACE_CURVE, PCURVE), both over the same knots.
#include "io/trim_edges.h"
#include "step/face.h"
#include "kernel/context.h"

enum {
    FACE_NUMBERS = 3, // after the plain face's: context, outer loop and bound come from the curves' own
    CURVE_NUMBERS =
        9, // vertex, curves in space and plane, representation, pcurve, surface curve, edge, oriented edge
    LOOP_NUMBERS = 2,
};

typedef struct trimmed {
    kn_text *text;
    const kn_patch *patch;
    kn_patch_net net;
    kn_trim_edge *edges;
    uint32_t *first; // number of each edge
} trimmed;

// ---- text ----

// first + 0 vertex, 1 curve in space, 2 curve in the plane, 3 representation, 4 pcurve, 5 surface curve, 6 edge,
// 7 oriented edge; then the points.
static void put_edge(const trimmed *t, int at, uint32_t from, uint32_t to, uint32_t context)
{
    kn_text *text = t->text;
    uint32_t f = t->first[at], points = f + CURVE_NUMBERS;
    kn_patch_curve space = t->edges[at].space, plane = t->edges[at].plane;
    space.first = (int)points, plane.first = space.first + space.axis.n, space.by = plane.by = 1;
    kn_step_put_line_points(text, &space, 3);
    kn_step_put_line_points(text, &plane, 2);
    kn_step_put_form(text, f, "VERTEX_POINT('',#);", (uint32_t[]){points});
    kn_step_put_relative(text, f + 1);
    kn_step_put_line(text, &space, false, false);
    kn_step_put_relative(text, f + 2);
    kn_step_put_line(text, &plane, false, false);
    kn_step_put_form(text, f + 3, "DEFINITIONAL_REPRESENTATION('',(#),#);", (uint32_t[]){f + 2, context});
    kn_step_put_form(text, f + 4, "PCURVE('',#,#);", (uint32_t[]){(uint32_t)t->net.n, f + 3});
    kn_step_put_form(text, f + 5, "SURFACE_CURVE('',#,(#),.CURVE_3D.);", (uint32_t[]){f + 1, f + 4});
    kn_step_put_form(text, f + 6, "EDGE_CURVE('',#,#,#,.T.);", (uint32_t[]){from, to, f + 5});
    kn_step_put_form(text, f + 7, "ORIENTED_EDGE('',*,*,#,.T.);", (uint32_t[]){f + 6});
}

// bound: the number of the loop's FACE_BOUND; the loop is the next one.
static void put_loop(const trimmed *t, int first, int last, uint32_t context, uint32_t bound)
{
    kn_text *text = t->text;
    int n = last - first;
    for (int k = 0; k < n; k++) {
        const kn_trim_edge *e = &t->edges[first + k], *then = &t->edges[first + (k + 1) % n];
        if (!e->collapsed) put_edge(t, first + k, t->first[e->start], t->first[then->start], context);
    }
    bool written = false;
    kn_step_put_relative(text, bound + 1);
    kn_text_put(text, "EDGE_LOOP('',(");
    for (int k = first; k < last; k++) {
        if (t->edges[k].collapsed) continue;
        if (written) kn_text_comma(text);
        kn_text_relative(text, t->first[k] + 7);
        written = true;
    }
    kn_text_put(text, "));");
    kn_text_newline(text);
    kn_step_put_form(text, bound,
                     kn_trim_edges_area(t->edges, first, last) > 0.0
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
        t->first[k] = next;
        next += CURVE_NUMBERS + (uint32_t)t->edges[k].space.axis.n + (uint32_t)t->edges[k].plane.axis.n;
    }
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
    trimmed t = {.text = text, .patch = patch};
    kn_mark mark = kn_scratch_mark(ctx);
    t.first = kn_scratch(ctx, (size_t)patch->trim->ncurves, sizeof *t.first);
    kn_status status = t.first ? kn_patch_net_load(ctx, &t.net, patch, mm, "STEP") : KN_ENOMEM;
    if (status == KN_OK) status = kn_trim_edges(ctx, &t.edges, patch, &t.net, mm, "STEP");
    if (status == KN_OK) {
        item->kind = KN_STEP_TRIMMED;
        item->numbers = put_all(&t, naming, part);
        item->main = (uint32_t)t.net.n + KN_STEP_FACE_NUMBERS - 1;
        item->text_end = text->bytes;
    }
    kn_scratch_release(ctx, mark);
    return status == KN_OK && text->failed ? KN_ENOMEM : status;
}
