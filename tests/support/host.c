// SPDX-License-Identifier: Apache-2.0
#include "tests/support/host.h"

#include "tests/support/support.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROOM = 20000 };

// Text of entities one after the other; every function answers the number of what it wrote.
typedef struct writer {
    char *text;
    size_t used;
    uint32_t next;
} writer;

static uint32_t put(writer *w, const char *form, ...)
{
    va_list list;
    va_start(list, form);
    w->used += (size_t)snprintf(w->text + w->used, ROOM - w->used, "#%u=", w->next);
    w->used += (size_t)vsnprintf(w->text + w->used, ROOM - w->used, form, list);
    w->used += (size_t)snprintf(w->text + w->used, ROOM - w->used, ";\n");
    va_end(list);
    assert_true(w->used < ROOM);
    return w->next++;
}

static uint32_t put_direction(writer *w, const double d[3])
{
    return put(w, "DIRECTION('',(%.1f,%.1f,%.1f))", d[0], d[1], d[2]);
}

static uint32_t put_vertex(writer *w, const double x[3])
{
    return put(w, "VERTEX_POINT('',#%u)", put(w, "CARTESIAN_POINT('',(%.1f,%.1f,%.1f))", x[0], x[1], x[2]));
}

static uint32_t put_edge(writer *w, uint32_t from, uint32_t to, const double a[3], const double b[3])
{
    double d[3];
    for (int c = 0; c < 3; c++) d[c] = b[c] - a[c];
    uint32_t point = put(w, "CARTESIAN_POINT('',(%.1f,%.1f,%.1f))", a[0], a[1], a[2]);
    uint32_t vector = put(w, "VECTOR('',#%u,1.)", put_direction(w, d));
    return put(w, "EDGE_CURVE('',#%u,#%u,#%u,.T.)", from, to, put(w, "LINE('',#%u,#%u)", point, vector));
}

static uint32_t put_plane(writer *w, const double at[3], const double normal[3], const double x[3])
{
    uint32_t point = put(w, "CARTESIAN_POINT('',(%.1f,%.1f,%.1f))", at[0], at[1], at[2]);
    uint32_t z = put_direction(w, normal), first = put_direction(w, x);
    return put(w, "PLANE('',#%u)", put(w, "AXIS2_PLACEMENT_3D('',#%u,#%u,#%u)", point, z, first));
}

// edges: numbers, negative where the loop runs against them.
static uint32_t put_face(writer *w, uint32_t plane, const int *edges, int n)
{
    char list[200];
    int used = 0;
    for (int i = 0; i < n; i++)
        used += snprintf(list + used, sizeof list - (size_t)used, "%s#%u", i ? "," : "",
                         put(w, "ORIENTED_EDGE('',*,*,#%d,.%c.)", abs(edges[i]), edges[i] > 0 ? 'T' : 'F'));
    uint32_t loop = put(w, "EDGE_LOOP('',(%s))", list);
    return put(w, "ADVANCED_FACE('stays',(#%u),#%u,.T.)", put(w, "FACE_OUTER_BOUND('',#%u,.T.)", loop), plane);
}

// Corners 0 .. 3 go round; the middle of the side from corner i to i + 1 is its own point on the lid's border.
static const double corner[4][2] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};

static void middle(double x[3], int i)
{
    for (int c = 0; c < 2; c++) x[c] = 0.5 * (corner[i][c] + corner[(i + 1) % 4][c]);
    x[2] = 2.0;
}

static void make_seed(kn_ctx *ctx, kn_step_seed *s, const double a[3], const double b[3], int degree)
{
    kn_bezier line = {0};
    kn_spline curve = {0};
    assert_int_equal(kn_bezier_init(ctx, &line, 1, 3, false, (int[]){1}), KN_OK);
    for (int c = 0; c < 3; c++) line.coef[2 * c] = a[c], line.coef[2 * c + 1] = b[c];
    assert_int_equal(kn_bezier_elevate(ctx, &line, &line, (int[]){degree}), KN_OK);
    assert_int_equal(kn_spline_of_bezier(ctx, &curve, &line), KN_OK);
    s->curve = curve;
    kn_bezier_clear(ctx, &line);
}

static void make_box(kn_ctx *ctx, test_host *h, writer *w, int degree)
{
    uint32_t low[4], high[4], mid[4];
    int bottom[4], up[4], rim[8];
    double x[8][3], m[4][3];
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 2; k++)
            x[4 * k + i][0] = corner[i][0], x[4 * k + i][1] = corner[i][1], x[4 * k + i][2] = 2 * k;
        middle(m[i], i);
        low[i] = put_vertex(w, x[i]), high[i] = put_vertex(w, x[4 + i]), mid[i] = put_vertex(w, m[i]);
    }
    for (int i = 0; i < 4; i++) {
        int n = (i + 1) % 4;
        bottom[i] = (int)put_edge(w, low[i], low[n], x[i], x[n]);
        up[i] = (int)put_edge(w, low[i], high[i], x[i], x[4 + i]);
        rim[2 * i] = (int)put_edge(w, high[i], mid[i], x[4 + i], m[i]);
        rim[2 * i + 1] = (int)put_edge(w, high[n], mid[i], x[4 + n], m[i]); // runs against the way round
        // The walls run round below the rim from left to right seen from outside: along it backwards.
        kn_step_seed *s = &h->seed[2 * i];
        make_seed(ctx, &s[0], x[4 + i], m[i], degree);
        s[0].edge = (uint32_t)rim[2 * i], s[0].vertex[0] = high[i], s[0].vertex[1] = mid[i];
        s[0].along = true, s[0].forward = false;
        make_seed(ctx, &s[1], m[i], x[4 + n], degree);
        s[1].edge = (uint32_t)rim[2 * i + 1], s[1].vertex[0] = mid[i], s[1].vertex[1] = high[n];
        s[1].along = false, s[1].forward = false;
    }
    for (int i = 0; i < 4; i++) {
        int n = (i + 1) % 4;
        double along[3] = {0, 0, 0}, out[3] = {0, 0, 0};
        for (int c = 0; c < 2; c++) along[c] = 0.25 * (corner[n][c] - corner[i][c]);
        out[0] = along[1], out[1] = -along[0];
        int loop[5] = {bottom[i], up[n], rim[2 * i + 1], -rim[2 * i], -up[i]};
        h->faces[i] = put_face(w, put_plane(w, x[i], out, along), loop, 5);
    }
    int loop[4] = {-bottom[3], -bottom[2], -bottom[1], -bottom[0]};
    h->faces[4] = put_face(w, put_plane(w, x[0], (double[]){0, 0, -1}, (double[]){1, 0, 0}), loop, 4);
}

static void put_structure(writer *w, uint32_t solid, uint32_t context)
{
    uint32_t app = put(w, "APPLICATION_CONTEXT('core data for automotive mechanical design processes')");
    put(w, "APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,#%u)", app);
    uint32_t pc = put(w, "PRODUCT_CONTEXT('',#%u,'mechanical')", app);
    uint32_t dc = put(w, "PRODUCT_DEFINITION_CONTEXT('part definition',#%u,'design')", app);
    uint32_t formation = put(w, "PRODUCT_DEFINITION_FORMATION('','',#%u)",
                             put(w, "PRODUCT('box','box','',(#%u))", pc));
    uint32_t shape = put(w, "PRODUCT_DEFINITION_SHAPE('','',#%u)",
                         put(w, "PRODUCT_DEFINITION('design','',#%u,#%u)", formation, dc));
    uint32_t at = put(w, "CARTESIAN_POINT('',(0.,0.,0.))");
    uint32_t place = put(w, "AXIS2_PLACEMENT_3D('',#%u,$,$)", at);
    put(w, "SHAPE_DEFINITION_REPRESENTATION(#%u,#%u)", shape,
        put(w, "ADVANCED_BREP_SHAPE_REPRESENTATION('',(#%u,#%u),#%u)", place, solid, context));
}

void test_host_make(kn_ctx *ctx, test_host *h, int degree)
{
    writer w = {.text = calloc(ROOM, 1), .next = 1};
    *h = (test_host){.text = w.text};
    uint32_t mm = put(&w, "(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
    uint32_t rad = put(&w, "(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
    uint32_t sr = put(&w, "(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())");
    uint32_t off = put(&w, "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-7),#%u,'distance_accuracy_value','')",
                       mm);
    h->host.context = put(&w,
                          "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#%u))"
                          "GLOBAL_UNIT_ASSIGNED_CONTEXT((#%u,#%u,#%u))REPRESENTATION_CONTEXT('',''))",
                          off, mm, rad, sr);
    make_box(ctx, h, &w, degree);
    h->shell = (kn_step_shell){.number = w.next++, .closed = true, .faces = h->faces, .nfaces = 5};
    put_structure(&w, put(&w, "MANIFOLD_SOLID_BREP('box',#%u)", h->shell.number), h->host.context);
    for (int k = 0; k < 4; k++) { // r along x, t along y
        double x[2] = {2.0 * (k / 2), 2.0 * (k % 2)};
        assert_int_equal(kn_bezier_init(ctx, &h->lid[k], 2, 3, false, (int[]){1, 1}), KN_OK);
        for (int i = 0; i < 4; i++) {
            double p[3] = {x[0] + 2.0 * (i / 2), x[1] + 2.0 * (i % 2), 2.0};
            if (p[0] == 2.0 && p[1] == 2.0) p[2] = 3.0;
            for (int c = 0; c < 3; c++) h->lid[k].coef[4 * c + i] = p[c];
        }
        assert_int_equal(kn_bezier_elevate(ctx, &h->lid[k], &h->lid[k], (int[]){degree, degree}), KN_OK);
    }
    h->shell_of[0] = 0;
    h->host.entities = h->text, h->host.bytes = w.used, h->host.numbers = w.next - 1;
    h->host.shells = &h->shell, h->host.nshells = 1;
    h->host.shell_of = h->shell_of, h->host.nsurfaces = 1;
    h->host.seeds = h->seed, h->host.nseeds = 8;
}

void test_host_clear(kn_ctx *ctx, test_host *h)
{
    for (int i = 0; i < 8; i++) kn_spline_clear(ctx, &h->seed[i].curve);
    for (int i = 0; i < 4; i++) kn_bezier_clear(ctx, &h->lid[i]);
    free(h->text);
}
