// SPDX-License-Identifier: Apache-2.0
// Models from CAD files: what is one, the way through bytes and back, and faces found in it.
#include "tests/support/support.h"

#include "kernel/context.h"

#include <knurl/cad.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FACES = 6, EDGES = 12, CORNERS = 8 };

// A face of the box [0,1] x [0,2] x [0,3]: P(u,v) = o + u a + v b, a x b outwards, over [0,2] x [1,2].
static const double corner[FACES][3][3] = {
    {{0, 0, 0}, {0, 2, 0}, {1, 0, 0}}, // z = 0
    {{0, 0, 3}, {1, 0, 0}, {0, 2, 0}}, // z = 3
    {{0, 0, 0}, {1, 0, 0}, {0, 0, 3}}, // y = 0
    {{0, 2, 0}, {0, 0, 3}, {1, 0, 0}}, // y = 2
    {{0, 0, 0}, {0, 0, 3}, {0, 2, 0}}, // x = 0
    {{1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, // x = 1
};

static void set_plane(kn_ctx *ctx, kn_cad_face *f, const double at[3][3])
{
    const double u[4] = {0, 0, 2, 2}, v[4] = {1, 1, 2, 2}, *knots[2] = {u, v};
    double coef[12];
    for (int k = 0; k < 4; k++)
        for (int c = 0; c < 3; c++) coef[4 * c + k] = at[0][c] + (k / 2) * at[1][c] + (k % 2) * at[2][c];
    assert_int_equal(kn_spline_init(ctx, &f->surface, 2, 3, false, (int[]){1, 1}, (int[]){2, 2}, knots, coef), KN_OK);
}

static const double sides[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};

static void place_of(double out[3], const double at[3][3], const double square[2])
{
    for (int c = 0; c < 3; c++) out[c] = at[0][c] + square[0] * at[1][c] + square[1] * at[2][c];
}

// The side's middle tells which edge it is: those of two faces are the same, in integers.
static void note_edge(kn_cad *cad, double (*middle)[3], int face, int side)
{
    double m[3];
    place_of(m, corner[face],
             (double[2]){0.5 * (sides[side][0] + sides[side + 1][0]), 0.5 * (sides[side][1] + sides[side + 1][1])});
    int e = 0;
    while (e < cad->nedges && (middle[e][0] != m[0] || middle[e][1] != m[1] || middle[e][2] != m[2])) e++;
    kn_cad_edge *edge = &cad->edges[e];
    if (e == cad->nedges) {
        memcpy(middle[e], m, sizeof m);
        *edge = (kn_cad_edge){.face = {face, -1}, .curve = {side, -1}};
        cad->nedges++;
    } else {
        edge->face[1] = face, edge->curve[1] = side;
        edge->angle = acos(0.0);
    }
    cad->faces[face].edge[side] = e;
}

static void *owned(kn_ctx *ctx, size_t n, size_t size)
{
    void *block = kn_alloc_zero(ctx, n, size);
    assert_non_null(block);
    return block;
}

// The number of a corner of the box.
static int corner_at(kn_cad *cad, const double x[3])
{
    int v = 0;
    while (v < cad->nvertices && memcmp(cad->vertices[v].at, x, sizeof cad->vertices[v].at) != 0) v++;
    assert_true(v < CORNERS);
    if (v == cad->nvertices) memcpy(cad->vertices[cad->nvertices++].at, x, sizeof cad->vertices[v].at);
    return v;
}

// The line of a side's edge, as the first face has it, and where the side has that line.
static void set_line(kn_ctx *ctx, kn_cad *cad, int face, int side)
{
    const double knots[4] = {2, 2, 5, 5}, *all = knots;
    kn_cad_edge *e = &cad->edges[cad->faces[face].edge[side]];
    kn_cad_use *use = &cad->faces[face].use[side];
    double end[2][3], line[6], plane[4];
    for (int k = 0; k < 2; k++) place_of(end[k], corner[face], sides[side + k]);
    if (e->line.nvars == 0) {
        for (int k = 0; k < 2; k++) e->vertex[k] = corner_at(cad, end[k]);
        for (int c = 0; c < 6; c++) line[c] = end[c % 2][c / 2];
        assert_int_equal(kn_spline_init(ctx, &e->line, 1, 3, false, (int[]){1}, (int[]){2}, &all, line), KN_OK);
    }
    use->against = corner_at(cad, end[0]) != e->vertex[0];
    for (int c = 0; c < 4; c++) plane[c] = sides[side + (c % 2 != use->against)][c / 2];
    assert_int_equal(kn_spline_init(ctx, &use->plane, 1, 2, false, (int[]){1}, (int[]){2}, &all, plane), KN_OK);
}

static void make_box(kn_ctx *ctx, kn_cad *cad)
{
    static const char *const names[FACES] = {"bottom", "top", "front", "back", "left", "right grip"};
    double middle[EDGES][3];
    *cad = (kn_cad){.faces = owned(ctx, FACES, sizeof *cad->faces),
                    .edges = owned(ctx, EDGES, sizeof *cad->edges),
                    .vertices = owned(ctx, CORNERS, sizeof *cad->vertices),
                    .bodies = owned(ctx, 1, sizeof *cad->bodies),
                    .nbodies = 1};
    cad->bodies[0] = (kn_cad_body){.name = "box", .solid = true, .instances = 2};
    for (int k = 0; k < 12; k++) cad->bodies[0].place[k] = 0.5 * k;
    for (int i = 0; i < FACES; i++) {
        kn_cad_face *f = &cad->faces[i];
        strcpy(f->name, names[i]);
        f->colored = i < 4;
        f->color[0] = i == 1 ? 1.0 : 0.0, f->color[1] = i == 2 ? 0.5 : 0.0;
        f->type = i == 5 ? KN_CAD_BSPLINE : KN_CAD_PLANE;
        f->whole = true;
        f->error = i, f->trim_error = 2 * i;
        set_plane(ctx, f, corner[i]);
        f->edge = owned(ctx, 4, sizeof(int));
        f->use = owned(ctx, 4, sizeof *f->use);
        f->shell = i / 5;
        f->trim = (kn_trim){owned(ctx, 4, sizeof(kn_spline)), 4, owned(ctx, 1, sizeof(int)), 1};
        f->trim.loop_end[0] = 4;
        for (int k = 0; k < 4; k++) {
            const double knots[4] = {0, 0, 1, 1}, *all = knots;
            const double coef[4] = {sides[k][0], sides[k + 1][0], sides[k][1], sides[k + 1][1]};
            assert_int_equal(kn_spline_init(ctx, &f->trim.curves[k], 1, 2, false, (int[]){1}, (int[]){2}, &all, coef),
                             KN_OK);
            note_edge(cad, middle, i, k);
            set_line(ctx, cad, i, k);
        }
        cad->nfaces++;
    }
    assert_int_equal(cad->nedges, EDGES);
}

static bool same_spline(const kn_spline *a, const kn_spline *b)
{
    bool same = a->nvars == b->nvars && a->ncomp == b->ncomp && a->rational == b->rational;
    for (int d = 0; same && d < a->nvars; d++) {
        size_t n = (size_t)(a->count[d] + a->degree[d] + 1);
        same = a->degree[d] == b->degree[d] && a->count[d] == b->count[d] &&
               memcmp(a->knots[d], b->knots[d], n * sizeof(double)) == 0;
    }
    return same && memcmp(a->coef, b->coef, kn_spline_count(a) * (size_t)a->ncomp * sizeof(double)) == 0;
}

static void assert_same(const kn_cad *a, const kn_cad *b)
{
    assert_int_equal(a->nfaces, b->nfaces);
    assert_int_equal(a->nedges, b->nedges);
    assert_int_equal(a->nbodies, b->nbodies);
    assert_int_equal(a->nvertices, b->nvertices);
    for (int i = 0; i < a->nvertices; i++)
        assert_memory_equal(a->vertices[i].at, b->vertices[i].at, sizeof a->vertices[i].at);
    for (int i = 0; i < a->nbodies; i++) {
        assert_string_equal(a->bodies[i].name, b->bodies[i].name);
        assert_int_equal(a->bodies[i].solid, b->bodies[i].solid);
        assert_int_equal(a->bodies[i].instances, b->bodies[i].instances);
        assert_memory_equal(a->bodies[i].place, b->bodies[i].place, sizeof a->bodies[i].place);
    }
    for (int i = 0; i < a->nedges; i++) {
        const kn_cad_edge *e = &a->edges[i], *g = &b->edges[i];
        assert_memory_equal(e->face, g->face, sizeof e->face);
        assert_memory_equal(e->curve, g->curve, sizeof e->curve);
        assert_true(e->more == g->more && e->point == g->point && e->angle == g->angle);
        assert_true(same_spline(&e->line, &g->line) && e->error == g->error);
        assert_memory_equal(e->vertex, g->vertex, sizeof e->vertex);
    }
    for (int i = 0; i < a->nfaces; i++) {
        const kn_cad_face *f = &a->faces[i], *g = &b->faces[i];
        assert_string_equal(f->name, g->name);
        assert_true(f->type == g->type && f->body == g->body && f->shell == g->shell && f->colored == g->colored &&
                    f->whole == g->whole);
        assert_true(f->error == g->error && f->trim_error == g->trim_error);
        assert_memory_equal(f->color, g->color, sizeof f->color);
        assert_true(same_spline(&f->surface, &g->surface));
        assert_int_equal(f->trim.ncurves, g->trim.ncurves);
        assert_int_equal(f->trim.nloops, g->trim.nloops);
        for (int k = 0; k < f->trim.ncurves; k++) {
            assert_int_equal(f->edge[k], g->edge[k]);
            assert_true(same_spline(&f->trim.curves[k], &g->trim.curves[k]));
            assert_true(same_spline(&f->use[k].plane, &g->use[k].plane) && f->use[k].against == g->use[k].against);
        }
    }
}

typedef struct scene {
    test_memory memory;
    kn_ctx *ctx;
    kn_cad cad;
} scene;

static void begin(scene *s)
{
    *s = (scene){.memory = TEST_MEMORY_INIT};
    s->ctx = test_ctx(&s->memory, 1);
    make_box(s->ctx, &s->cad);
}

static void end(scene *s)
{
    kn_cad_clear(s->ctx, &s->cad);
    kn_cad_clear(s->ctx, NULL);
    test_ctx_end(s->ctx, &s->memory);
}

static void through_bytes(void **state)
{
    (void)state;
    scene s;
    begin(&s);
    assert_int_equal(kn_cad_check(s.ctx, &s.cad), KN_OK);
    unsigned char *data = NULL, *twice = NULL;
    size_t bytes = 0, again = 0;
    kn_cad back = {0};
    assert_int_equal(kn_cad_write(s.ctx, &data, &bytes, &s.cad), KN_OK);
    // the head, a double at its place: 1.5 = 0x3ff8 of the placement, low byte first
    assert_memory_equal(data, "KNCAD\0\0\2\1\0\0\0\10\0\0\0\14\0\0\0\6\0\0\0box", 27);
    assert_memory_equal(data + 24 + 64 + 8 + 3 * 8, "\0\0\0\0\0\0\370\77", 8);
    assert_int_equal(kn_cad_parse(s.ctx, &back, "bytes", data, bytes), KN_OK);
    assert_same(&s.cad, &back);
    assert_int_equal(kn_cad_parse(s.ctx, &back, "bytes", data, bytes), KN_OK); // over what is there
    assert_int_equal(kn_cad_write(s.ctx, &twice, &again, &back), KN_OK);
    assert_int_equal(again, bytes);
    assert_memory_equal(data, twice, bytes);
    // an empty one
    kn_cad none = {0};
    kn_free(s.ctx, twice);
    assert_int_equal(kn_cad_write(s.ctx, &twice, &again, &none), KN_OK);
    assert_int_equal(again, 24);
    assert_int_equal(kn_cad_parse(s.ctx, &back, "none", twice, again), KN_OK);
    assert_int_equal(back.nfaces, 0);
    kn_free(s.ctx, data), kn_free(s.ctx, twice);
    kn_cad_clear(s.ctx, &back);
    end(&s);
}

// Every prefix and every single byte changed: an error, or a model; out unchanged on errors.
static void damaged_bytes(void **state)
{
    (void)state;
    scene s;
    begin(&s);
    unsigned char *data = NULL;
    size_t bytes = 0;
    kn_cad out = {0};
    assert_int_equal(kn_cad_write(s.ctx, &data, &bytes, &s.cad), KN_OK);
    for (size_t n = 0; n < bytes; n += n < 200 ? 1 : 7) {
        unsigned char *exact = malloc(n + 1); // so that the sanitizer sees a byte too many
        memcpy(exact, data, n);
        kn_ctx_clear_error(s.ctx);
        assert_int_equal(kn_cad_parse(s.ctx, &out, "cut", exact, n), KN_EPARSE);
        assert_memory_equal(kn_ctx_message(s.ctx), "cut: byte ", 10);
        assert_null(out.faces);
        free(exact);
    }
    int refused = 0;
    for (size_t i = 0; i < bytes; i += 3) {
        unsigned char was = data[i];
        data[i] ^= 0x55;
        kn_status status = kn_cad_parse(s.ctx, &out, "changed", data, bytes);
        assert_true(status == KN_OK || status == KN_EPARSE || status == KN_EDOMAIN || status == KN_ELIMIT);
        if (status != KN_OK) assert_null(out.faces);
        refused += status != KN_OK;
        kn_cad_clear(s.ctx, &out);
        data[i] = was;
    }
    assert_true(refused > 100);
    unsigned char *more = malloc(bytes + 1);
    memcpy(more, data, bytes), more[bytes] = 0;
    kn_ctx_clear_error(s.ctx);
    assert_int_equal(kn_cad_parse(s.ctx, &out, "more", more, bytes + 1), KN_EPARSE);
    assert_non_null(strstr(kn_ctx_message(s.ctx), "after the end"));
    more[7] = 3;
    kn_ctx_clear_error(s.ctx);
    assert_int_equal(kn_cad_parse(s.ctx, &out, "newer", more, bytes), KN_EPARSE);
    assert_string_equal(kn_ctx_message(s.ctx), "newer: byte 7: version 3, not 2");
    // 2^31 - 1 faces in a few bytes: refused before anything is allocated
    memcpy(more, data, bytes);
    memset(more + 20, 0xff, 4), more[23] = 0x7f;
    size_t before = kn_ctx_counters(s.ctx).peak_bytes;
    assert_int_equal(kn_cad_parse(s.ctx, &out, "huge", more, bytes), KN_EPARSE);
    assert_int_equal(kn_ctx_counters(s.ctx).peak_bytes, before);
    free(more);
    kn_free(s.ctx, data);
    end(&s);
}

static void refused(scene *s, const char *message)
{
    kn_ctx_clear_error(s->ctx);
    assert_int_equal(kn_cad_check(s->ctx, &s->cad), KN_EDOMAIN);
    if (!strstr(kn_ctx_message(s->ctx), message)) fail_msg("%s, not %s", kn_ctx_message(s->ctx), message);
}

// Where the line of an edge ends.
static int end_of(kn_cad *cad, int edge)
{
    double x[3];
    for (int c = 0; c < 3; c++) x[c] = cad->edges[edge].line.coef[2 * c + 1];
    return corner_at(cad, x);
}

static void what_is_no_model(void **state)
{
    (void)state;
    scene s;
    begin(&s);
    kn_cad_face *f = &s.cad.faces[2];
    kn_cad_edge *e = &s.cad.edges[3];
    kn_cad_body *b = s.cad.bodies;
    f->type = KN_CAD_TYPES, refused(&s, "face 2: type 11"), f->type = KN_CAD_PLANE;
    assert_null(kn_cad_type_name(KN_CAD_TYPES));
    assert_string_equal(kn_cad_type_name(KN_CAD_CYLINDER), "cylinder");
    f->body = 1, refused(&s, "face 2: body 1 of 1"), f->body = 0;
    f->shell = -1, refused(&s, "face 2: shell -1"), f->shell = 0;
    s.cad.nvertices = -1, refused(&s, "-1 vertices"), s.cad.nvertices = CORNERS;
    e->vertex[1] = CORNERS, refused(&s, "edge 3: vertex 8 of 8"), e->vertex[1] = e->vertex[0];
    refused(&s, "edge 3 does not end at vertex");
    e->error = 10.0, assert_int_equal(kn_cad_check(s.ctx, &s.cad), KN_OK); // so far that may be
    e->error = NAN, refused(&s, "edge 3: error"), e->error = 0.0;
    e->vertex[1] = end_of(&s.cad, 3);
    e->point = true, refused(&s, "edge 3: no line"), e->point = false;
    e->line.ncomp = 2, refused(&s, "edge 3: no line"), e->line.ncomp = 3;
    e->line.knots[0][0] = e->line.knots[0][1] = 1.0, refused(&s, "does not lie along edge 3");
    e->line.knots[0][0] = e->line.knots[0][1] = 2.0;
    kn_spline *plane = &f->use[1].plane;
    plane->coef[0] = 0.25, refused(&s, "face 2, curve 1: its plane"), plane->coef[0] = 1.0;
    f->use[1].against = !f->use[1].against, refused(&s, "face 2, curve 1: its plane");
    f->use[1].against = !f->use[1].against;
    plane->knots[0][0] = 9.0, refused(&s, "knot"), plane->knots[0][0] = 2.0;
    assert_int_equal(kn_cad_check(s.ctx, &s.cad), KN_OK);
    f->color[1] = 1.5, refused(&s, "colour 1.5"), f->color[1] = NAN, refused(&s, "colour"), f->color[1] = 0;
    f->error = -1, refused(&s, "errors -1"), f->error = 0;
    f->trim_error = INFINITY, refused(&s, "errors 0, inf"), f->trim_error = 0;
    f->surface.nvars = 1, refused(&s, "face 2: no surface"), f->surface.nvars = 2;
    f->surface.coef[0] = NAN, refused(&s, "control point"), f->surface.coef[0] = 0;
    f->trim.curves[0].coef[0] = 0.25, refused(&s, "trim"), f->trim.curves[0].coef[0] = 0;
    int loops = f->trim.nloops, curves = f->trim.ncurves, edge = f->edge[1];
    f->trim.nloops = f->trim.ncurves = 0, refused(&s, "no trim");
    f->trim.nloops = loops, f->trim.ncurves = curves;
    f->edge[1] = EDGES, refused(&s, "edge 12 of 12"), f->edge[1] = (edge + 1) % EDGES;
    refused(&s, "other faces"), f->edge[1] = edge;
    // the middle of a side moved inwards: no longer the whole square
    double *x = &f->trim.curves[0].coef[3], *y = &f->trim.curves[1].coef[2];
    *x = *y = 0.5, refused(&s, "whole"), *x = *y = 0.0;
    memset(f->name, 'a', sizeof f->name), refused(&s, "does not end");
    strcpy(f->name, "a\nb"), refused(&s, "control character"), strcpy(f->name, "front");
    b->instances = 0, refused(&s, "0 instances"), b->instances = 1;
    b->place[5] = NAN, refused(&s, "placement"), b->place[5] = 0;
    e->angle = 3.2, refused(&s, "angle 3.2"), e->angle = 0;
    int face = e->face[1], curve = e->curve[1];
    e->face[1] = 0, refused(&s, "other faces"), e->face[1] = face;
    e->more = true; // its faces may then be others
    e->face[1] = FACES, refused(&s, "edge 3: face 6 of 6"), e->face[1] = face;
    e->curve[1] = 4, refused(&s, "curve 4 of face"), e->curve[1] = curve;
    e->face[1] = e->face[0], e->curve[1] = e->curve[0];
    assert_int_equal(kn_cad_check(s.ctx, &s.cad), KN_EDOMAIN), e->face[1] = face, e->curve[1] = curve;
    e->more = false;
    assert_int_equal(kn_cad_check(s.ctx, &s.cad), KN_OK);
    end(&s);
}

// The faces that a text names are those whose bits are set in `wanted`.
static void found(scene *s, const char *text, unsigned wanted)
{
    int *faces = NULL, n = 0;
    unsigned got = 0;
    kn_ctx_clear_error(s->ctx);
    assert_int_equal(kn_cad_find(s->ctx, &faces, &n, &s->cad, text), KN_OK);
    for (int i = 0; i < n; i++) {
        got |= 1u << faces[i];
        if (i > 0) assert_true(faces[i] > faces[i - 1]);
    }
    kn_free(s->ctx, faces);
    assert_int_equal(got, wanted);
}

static void not_found(scene *s, const char *text, const char *message)
{
    int *faces = NULL, n = -7;
    kn_ctx_clear_error(s->ctx);
    assert_int_not_equal(kn_cad_find(s->ctx, &faces, &n, &s->cad, text), KN_OK);
    assert_null(faces);
    assert_int_equal(n, -7);
    if (!strstr(kn_ctx_message(s->ctx), message)) fail_msg("%s: %s", text, kn_ctx_message(s->ctx));
}

static void faces_by_text(void **state)
{
    (void)state;
    scene s;
    begin(&s);
    found(&s, "3", 8), found(&s, "0,2-4", 1 + 4 + 8 + 16), found(&s, "1+5", 2 + 32);
    found(&s, "name:top", 2), found(&s, "name:TOP", 2), found(&s, "name:*t*", 1 + 2 + 4 + 16 + 32);
    found(&s, "name:?ack", 8), found(&s, "name:*grip", 32), found(&s, "name:*", 63), found(&s, "name:**o?", 1 + 2);
    found(&s, "type:plane", 31), found(&s, "type:bspline", 32), found(&s, "type:plane&name:*t", 4 + 16);
    found(&s, "type:bspline+type:plane&name:b*", 32 + 1 + 8);
    found(&s, "color:#ff0000", 2), found(&s, "color:#FF0000", 2), found(&s, "color:#000000", 1 + 8);
    found(&s, "color:#00bc00", 4), found(&s, "color:#00bd00", 4); // 0.5 linear is 187.5 of 255 in sRGB
    found(&s, "body:box", 63), found(&s, "body:0", 63);
    found(&s, "near:0.5,1,9", 2), found(&s, "near:0.5,-1,1", 4), found(&s, "near:0.5,1,-0.1", 1);
    found(&s, "near:0.9,1,1.5&type:bspline", 32);
    // of those that the rest holds for, wherever it stands
    found(&s, "near:0.5,1,9&type:bspline", 32), found(&s, "name:*t*&near:0.5,1,9", 2), found(&s, "3&near:0.5,1,9", 8);
    not_found(&s, "6", "0 to 5"), not_found(&s, "3-1", "expected"), not_found(&s, "1,", "expected");
    not_found(&s, "", "expected"), not_found(&s, "x:1", "expected"), not_found(&s, "99999999999", "0 to 5");
    not_found(&s, "name:lid", "bottom, top, front, back, left, right grip");
    not_found(&s, "type:torus", "plane, bspline"), not_found(&s, "body:cube", "there is box");
    not_found(&s, "color:#123456", "#000000, #ff0000"), not_found(&s, "color:red", "expected");
    not_found(&s, "near:1,2", "expected"), not_found(&s, "near:1,2,x", "expected");
    not_found(&s, "name:top&name:back", "none with all");
    strcpy(s.cad.faces[4].name, "L\xc3\xa4nge\xe2\x82\xac"); // a character of two bytes, one of three
    found(&s, "name:L?nge?", 16), found(&s, "name:*?nge?", 16), found(&s, "name:l\xc3\xa4*?", 16);
    not_found(&s, "name:L??nge*", "none with name"), not_found(&s, "name:*e??", "none with name");
    kn_cad none = {0};
    int *faces = NULL, n = 0;
    assert_int_equal(kn_cad_find(s.ctx, &faces, &n, &none, "0"), KN_EDOMAIN);
    end(&s);
}

// The unit square's face cut to its lower left triangle: the nearest point lies on the cut, or inside.
static void near_a_trimmed_face(void **state)
{
    (void)state;
    scene s;
    begin(&s);
    s.cad.nfaces = 2; // z = 0 and z = 3; edges are left as they are, and not looked at
    kn_cad_face *f = &s.cad.faces[1];
    f->whole = false;
    kn_spline *c = f->trim.curves;
    // (0,0) (1,0) (0,1): the second side runs across, the third is (0,1) (0,0), the last goes
    c[1].coef[0] = 1, c[1].coef[1] = 0, c[1].coef[2] = 0, c[1].coef[3] = 1;
    c[2].coef[0] = 0, c[2].coef[1] = 0, c[2].coef[2] = 1, c[2].coef[3] = 0;
    kn_spline_clear(s.ctx, &c[3]), kn_spline_clear(s.ctx, &f->use[3].plane);
    f->trim.ncurves = f->trim.loop_end[0] = 3;
    assert_int_equal(kn_trim_check(s.ctx, &f->trim), KN_OK);
    // Above (0.9, 1.8): the triangle x + y / 2 <= 1, z = 3 is hypot(2.5, distance in the plane) away, the distance in
    // the plane 0.8 / |(1, 1/2)| = 0.7155: 2.6004. The bottom is 0.5 away from z = 0.5.
    found(&s, "near:0.9,1.8,0.5", 1);
    // From z = 1.52 the bottom is 1.52 away, the top 1.48 in a straight line, which ends beyond the cut: 1.644.
    found(&s, "near:0.9,1.8,1.52", 1);
    found(&s, "near:0.2,0.4,1.52", 2); // and here inside it
    found(&s, "near:0.9,1.8,1.68", 2); // 1.68 to hypot(1.32, 0.7155) = 1.5014
    s.cad.nfaces = FACES;              // so that all is cleared
    end(&s);
}

static kn_status round_trip(kn_ctx *ctx, void *user)
{
    const scene *s = user;
    unsigned char *data = NULL;
    size_t bytes = 0;
    int *faces = NULL, n = 0;
    kn_cad back = {0};
    kn_status status = kn_cad_write(ctx, &data, &bytes, &s->cad);
    if (status == KN_OK) status = kn_cad_parse(ctx, &back, "bytes", data, bytes);
    if (status != KN_OK) assert_null(back.faces);
    if (status == KN_OK) status = kn_cad_find(ctx, &faces, &n, &back, "type:plane+near:1,2,3");
    if (status != KN_OK) assert_null(faces);
    kn_free(ctx, data), kn_free(ctx, faces);
    kn_cad_clear(ctx, &back);
    return status;
}

static void out_of_memory(void **state)
{
    (void)state;
    scene s;
    begin(&s);
    s.cad.nfaces = s.cad.faces[0].trim.ncurves = 1; // smaller: one face, and edges that it has alone
    s.cad.faces[0].trim.ncurves = 4;
    s.cad.nedges = 4;
    for (int i = 0; i < 4; i++) {
        assert_int_equal(s.cad.faces[0].edge[i], i);
        s.cad.edges[i].face[1] = s.cad.edges[i].curve[1] = -1;
    }
    test_allocation_failures(round_trip, &s);
    s.cad.nfaces = FACES, s.cad.nedges = EDGES; // so that all is cleared
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(through_bytes), cmocka_unit_test(damaged_bytes),       cmocka_unit_test(what_is_no_model),
        cmocka_unit_test(faces_by_text), cmocka_unit_test(near_a_trimmed_face), cmocka_unit_test(out_of_memory),
    };
    return cmocka_run_group_tests_name("cad/cad", tests, NULL, NULL);
}
