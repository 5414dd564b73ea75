// SPDX-License-Identifier: Apache-2.0
// Models from CAD files against what Open CASCADE itself says of them: shapes that it makes, and real files where they
// are (../shared/data).
#include "tests/support/support.h"

#if KN_WITH_OCCT
#include "bridges/occt/cad_read.h"
#include "bridges/occt/occt_probe.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct scene {
    test_memory memory;
    kn_ctx *ctx;
    kn_cad cad;
    kn_occt_probe *probe;
} scene;

static void open_file(scene *s, const char *path)
{
    *s = (scene){.memory = TEST_MEMORY_INIT};
    s->ctx = test_ctx(&s->memory, 1);
    kn_status status = kn_occt_probe_open(s->ctx, &s->probe, &s->cad, path);
    if (status != KN_OK) fail_msg("%s", kn_ctx_message(s->ctx));
    assert_int_equal(kn_cad_check(s->ctx, &s->cad), KN_OK);
}

static void end(scene *s)
{
    kn_occt_probe_close(s->ctx, s->probe);
    kn_cad_clear(s->ctx, &s->cad);
    test_ctx_end(s->ctx, &s->memory);
}

static void open_made(scene *s, kn_occt_kind kind, const char *ending)
{
    char path[TEST_PATH_BYTES], name[32];
    kn_ctx *ctx = NULL;
    snprintf(name, sizeof name, "made%d%s", (int)kind, ending);
    test_tmp_path(path, name);
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK);
    if (kn_occt_make(ctx, kind, path) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    kn_ctx_destroy(ctx);
    open_file(s, path);
    remove(path);
}

// Point and unit normal of a face at a place in the square; false: no normal there.
static bool look(const scene *s, int face, const double square[2], double point[3], double normal[3])
{
    const kn_spline *a = &s->cad.faces[face].surface;
    double at[2], d[9], size[2] = {0, 0}, length = 0;
    for (int k = 0; k < 2; k++) {
        double lo, hi;
        kn_spline_domain(a, k, &lo, &hi);
        at[k] = lo + square[k] * (hi - lo);
    }
    assert_int_equal(kn_spline_derivatives(s->ctx, d, a, at, 1), KN_OK); // value, S_v or S_u first: by the index
    const double *u = d + 3 * 1, *v = d + 3 * 2;
    for (int c = 0; c < 3; c++) {
        int e = (c + 1) % 3, f = (c + 2) % 3;
        point[c] = d[c];
        normal[c] = u[e] * v[f] - u[f] * v[e];
        length += normal[c] * normal[c];
        size[0] += u[c] * u[c], size[1] += v[c] * v[c];
    }
    length = sqrt(length);
    for (int c = 0; c < 3; c++) normal[c] /= length;
    return length > 1e-6 * sqrt(size[0] * size[1]) && length > 1e-9;
}

// At random places of each face. The surface is the file's: distances are rounding (1e-12 of a part of some tens of
// mm, and OCCT's projection, whose own tolerance is 1e-9); normals point as OCCT's do (both from derivatives that have
// lost no more than 6 digits, above); what is in the trim is what OCCT calls inside, unless it is within a thousandth
// of the border (of OCCT's parameters): cubics stay within 1e-5 mm of conics.
static void compare(const scene *s, int samples, double error)
{
    test_rng rng = test_random(11);
    int inside = 0, outside = 0;
    for (int i = 0; i < s->cad.nfaces; i++)
        for (int k = 0; k < samples; k++) {
            double square[2] = {test_uniform(&rng, 0, 1), test_uniform(&rng, 0, 1)}, point[3], normal[3], dot = 0;
            kn_answer answer = KN_YES;
            kn_occt_place place;
            bool smooth = look(s, i, square, point, normal);
            assert_int_equal(kn_occt_probe_face(s->ctx, &place, s->probe, i, point, 1e-3), KN_OK);
            if (!(place.distance <= error + s->cad.faces[i].error))
                fail_msg("face %d: %g from OCCT's", i, place.distance);
            for (int c = 0; c < 3; c++) dot += normal[c] * place.normal[c];
            bool there = place.normal[0] != 0 || place.normal[1] != 0 || place.normal[2] != 0;
            if (smooth && there && !(dot > 1 - 1e-9)) fail_msg("face %d: normals %g apart", i, dot);
            assert_int_equal(kn_trim_contains(s->ctx, &answer, &s->cad.faces[i].trim, square), KN_OK);
            if (place.inside == 0) continue; // near the border
            if ((answer == KN_YES) != (place.inside > 0))
                fail_msg("face %d at %g, %g (OCCT: %g, %g): inside %d, OCCT %d", i, square[0], square[1], place.u,
                         place.v, (int)answer, place.inside);
            inside += place.inside > 0, outside += place.inside < 0;
        }
    assert_true(inside > 0);
    (void)outside;
}

// A step outwards leaves the body, one inwards stays in it. Normals of the others point as OCCT's, so a few will do.
static void assert_outward(const scene *s)
{
    for (int i = 0; i < s->cad.nfaces; i++) {
        if (!s->cad.bodies[s->cad.faces[i].body].solid) continue;
        test_rng rng = test_random((uint64_t)i);
        for (int tries = 0, done = 0; tries < 60 && done < 3; tries++) {
            double square[2] = {test_uniform(&rng, 0, 1), test_uniform(&rng, 0, 1)}, p[3], n[3], out[3], in[3];
            kn_answer answer = KN_NO;
            int where = 0;
            assert_int_equal(kn_trim_contains(s->ctx, &answer, &s->cad.faces[i].trim, square), KN_OK);
            if (answer != KN_YES || !look(s, i, square, p, n)) continue;
            for (int c = 0; c < 3; c++) out[c] = p[c] + 1e-3 * n[c], in[c] = p[c] - 1e-3 * n[c];
            assert_int_equal(kn_occt_probe_body(s->ctx, &where, s->probe, s->cad.faces[i].body, out, 1e-6), KN_OK);
            assert_int_equal(where, -1);
            assert_int_equal(kn_occt_probe_body(s->ctx, &where, s->probe, s->cad.faces[i].body, in, 1e-6), KN_OK);
            assert_int_equal(where, 1);
            done++;
        }
    }
}

// Along each edge both faces' trims run through the same points of space, in opposite directions.
static void assert_edges_meet(const scene *s)
{
    enum { STEPS = 16 };
    for (int i = 0; i < s->cad.nedges; i++) {
        const kn_cad_edge *e = &s->cad.edges[i];
        if (e->face[1] < 0 || e->point || e->more) continue;
        double end[2][2][3], n[3];
        for (int k = 0; k < 2; k++) {
            const kn_spline *c = &s->cad.faces[e->face[k]].trim.curves[e->curve[k]];
            int m = c->count[0];
            look(s, e->face[k], (double[2]){c->coef[0], c->coef[m]}, end[k][0], n);
            look(s, e->face[k], (double[2]){c->coef[m - 1], c->coef[2 * m - 1]}, end[k][1], n);
        }
        for (int k = 0; k < 2; k++) // OCCT's vertices have a tolerance of 1e-7
            for (int c = 0; c < 3; c++) assert_true(fabs(end[0][k][c] - end[1][1 - k][c]) <= 2e-7 + 1e-5);
    }
}

typedef struct expected {
    int faces, edges, seams, points, type[KN_CAD_TYPES];
    int sharp; // edges between faces that meet at an angle above 0.1
} expected;

static void assert_counts(const scene *s, const expected *x)
{
    int seams = 0, points = 0, sharp = 0, types[KN_CAD_TYPES] = {0};
    for (int i = 0; i < s->cad.nedges; i++) {
        const kn_cad_edge *e = &s->cad.edges[i];
        seams += e->face[0] == e->face[1];
        points += e->point;
        sharp += e->face[1] >= 0 && e->face[0] != e->face[1] && e->angle > 0.1;
    }
    for (int i = 0; i < s->cad.nfaces; i++) types[s->cad.faces[i].type]++;
    assert_int_equal(s->cad.nfaces, x->faces);
    assert_int_equal(s->cad.nedges, x->edges);
    assert_int_equal(seams, x->seams);
    assert_int_equal(points, x->points);
    assert_int_equal(sharp, x->sharp);
    for (int t = 0; t < KN_CAD_TYPES; t++) assert_int_equal(types[t], x->type[t]);
    assert_int_equal(s->cad.nbodies, 1);
}

// Counts by hand: a cylinder has two circles and a seam; a sphere a seam and two poles; a rounded box 6 + 12 + 8 faces,
// whose 48 edges are smooth, and 24 + 24 of them.
static const expected counts[KN_OCCT_KINDS] = {
    [KN_OCCT_BOX] = {6, 12, 0, 0, {[KN_CAD_PLANE] = 6}, 12},
    [KN_OCCT_CYLINDER] = {3, 3, 1, 0, {[KN_CAD_PLANE] = 2, [KN_CAD_CYLINDER] = 1}, 2},
    [KN_OCCT_SPHERE] = {1, 3, 1, 2, {[KN_CAD_SPHERE] = 1}, 0},
    [KN_OCCT_TORUS] = {1, 2, 2, 0, {[KN_CAD_TORUS] = 1}, 0},
    [KN_OCCT_CONE] = {3, 3, 1, 0, {[KN_CAD_PLANE] = 2, [KN_CAD_CONE] = 1}, 2},
    [KN_OCCT_APEX] = {2, 3, 1, 1, {[KN_CAD_PLANE] = 1, [KN_CAD_CONE] = 1}, 1},
    [KN_OCCT_SECTOR] = {3, 3, 1, 0, {[KN_CAD_PLANE] = 2, [KN_CAD_TORUS] = 1}, 2},
    [KN_OCCT_DRILLED] = {7, 15, 1, 0, {[KN_CAD_PLANE] = 6, [KN_CAD_CYLINDER] = 1}, 14},
};

static void made_shapes(const char *ending)
{
    for (int kind = 0; kind < KN_OCCT_KINDS; kind++) {
        scene s;
        open_made(&s, (kn_occt_kind)kind, ending);
        if (counts[kind].faces > 0) assert_counts(&s, &counts[kind]);
        if (!s.cad.bodies[0].solid) fail_msg("shape %d is open", kind);
        compare(&s, test_scale(25), 2e-9);
        assert_outward(&s);
        assert_edges_meet(&s);
        end(&s);
    }
}

static void brep_shapes(void **state)
{
    (void)state;
    made_shapes(".brep");
}

static void step_shapes(void **state)
{
    (void)state;
    made_shapes(".step");
}

// A cylinder that goes round: closed in u over [0, 2 pi] bit for bit, whole, of four arcs; and its square is OCCT's.
static void round_cylinder(void **state)
{
    (void)state;
    scene s;
    open_made(&s, KN_OCCT_CYLINDER, ".step");
    int *found = NULL, n = 0;
    assert_int_equal(kn_cad_find(s.ctx, &found, &n, &s.cad, "type:cylinder"), KN_OK);
    const kn_cad_face *f = &s.cad.faces[found[0]];
    const kn_spline *a = &f->surface;
    double lo, hi;
    assert_true(n == 1 && f->whole && f->error == 0 && f->trim_error == 0);
    assert_int_equal(f->trim.ncurves, 4);
    kn_spline_domain(a, 0, &lo, &hi);
    assert_true(lo == 0 && hi == 2 * acos(-1.0));
    assert_int_equal(kn_spline_spans(a, 0), 4);
    size_t points = kn_spline_count(a), last = points - (size_t)a->count[1];
    for (int c = 0; c < 4; c++)
        for (int j = 0; j < a->count[1]; j++)
            assert_true(a->coef[(size_t)c * points + (size_t)j] == a->coef[(size_t)c * points + last + (size_t)j]);
    for (int k = 0; k < 20; k++) { // on the circle of radius 5: three roundings of numbers below 8
        double p[3], normal[3];
        look(&s, found[0], (double[2]){k / 19.0, 0.3}, p, normal);
        assert_true(fabs(hypot(p[0], p[1]) - 5) <= 1e-14 * 5 && fabs(p[2] - 6) <= 1e-14 * 6);
        assert_true(p[0] * normal[0] + p[1] * normal[1] > 0);
    }
    for (int i = 0; i < s.cad.nedges; i++) // right angles at the rims, to the rounding of atan2 and a cross product
        if (s.cad.edges[i].face[0] != s.cad.edges[i].face[1])
            assert_true(fabs(s.cad.edges[i].angle - acos(0.0)) <= 1e-9);
    kn_free(s.ctx, found);
    end(&s);
}

// Round edges of a box: each is tangent to its neighbours.
static void smooth_edges(void **state)
{
    (void)state;
    scene s;
    open_made(&s, KN_OCCT_FILLET, ".step");
    assert_int_equal(s.cad.nfaces, 26);
    int cylinders = 0, spheres = 0;
    for (int i = 0; i < s.cad.nedges; i++)
        if (!(s.cad.edges[i].angle <= 1e-6)) fail_msg("edge %d: %g", i, s.cad.edges[i].angle);
    for (int i = 0; i < s.cad.nfaces; i++) {
        cylinders += s.cad.faces[i].type == KN_CAD_CYLINDER;
        spheres += s.cad.faces[i].type == KN_CAD_SPHERE;
    }
    assert_int_equal(cylinders, 12);
    assert_int_equal(spheres, 8);
    end(&s);
}

static bool shared(char path[TEST_PATH_BYTES], const char *name)
{
    snprintf(path, TEST_PATH_BYTES, "../shared/data/%s", name);
    FILE *file = fopen(path, "rb");
    if (file) fclose(file);
    if (!file) print_message("# %s is not there: skipped\n", path);
    return file != NULL;
}

static void assembly(void **state)
{
    (void)state;
    static const struct {
        const char *name, *color;
        int instances, faces;
    } parts[] = {{"nut", "color:#ff0000", 8, 8},
                 {"rod", "color:#ff8000", 1, 4},
                 {"bolt", "color:#0000ff", 6, 7},
                 {"l-bracket", "color:#00ff00", 2, 16},
                 {"plate", NULL, 1, 18}};
    char path[TEST_PATH_BYTES];
    if (!shared(path, "as1-oc-214.stp")) skip();
    scene s;
    open_file(&s, path);
    int instances = 0;
    assert_int_equal(s.cad.nbodies, 5);
    for (int b = 0; b < 5; b++) {
        char text[64];
        int *faces = NULL, n = 0;
        assert_string_equal(s.cad.bodies[b].name, parts[b].name);
        assert_int_equal(s.cad.bodies[b].instances, parts[b].instances);
        assert_true(s.cad.bodies[b].solid);
        instances += s.cad.bodies[b].instances;
        snprintf(text, sizeof text, "body:%s%s%s", parts[b].name, parts[b].color ? "&" : "",
                 parts[b].color ? parts[b].color : "");
        assert_int_equal(kn_cad_find(s.ctx, &faces, &n, &s.cad, text), KN_OK);
        assert_int_equal(n, parts[b].faces);
        kn_free(s.ctx, faces);
    }
    assert_int_equal(instances, 18); // solids, as the file has them
    compare(&s, test_scale(10), 2e-9);
    assert_outward(&s);
    assert_edges_meet(&s);
    end(&s);
}

static void real_surfaces(void **state)
{
    (void)state;
    static const char *const names[] = {"splinecage.stp", "surf114.igs"};
    bool any = false;
    for (int i = 0; i < 2; i++) {
        char path[TEST_PATH_BYTES];
        if (!shared(path, names[i])) continue;
        any = true;
        scene s;
        open_file(&s, path);
        assert_int_equal(s.cad.nfaces, 4);
        for (int k = 0; k < 4; k++) assert_true(s.cad.faces[k].type == KN_CAD_BSPLINE && s.cad.faces[k].whole);
        for (int b = 0; b < s.cad.nbodies; b++) assert_false(s.cad.bodies[b].solid);
        compare(&s, test_scale(25), 1e-7); // projections onto splines end at 1e-9 of a parameter of some tens
        end(&s);
    }
    if (!any) skip();
}

static void refused(const char *text, const char *message)
{
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "refused.stp");
    test_write_file(path, text, strlen(text));
    kn_cad cad = {.nfaces = 0};
    assert_int_equal(kn_occt_read(ctx, &cad, path), KN_EPARSE);
    assert_memory_equal(kn_ctx_message(ctx), path, strlen(path));
    if (!strstr(kn_ctx_message(ctx), message)) fail_msg("%s, not %s", kn_ctx_message(ctx), message);
    assert_null(cad.faces);
    remove(path);
    test_ctx_end(ctx, &memory);
}

static void bad_files(void **state)
{
    (void)state;
    refused("solid of another kind\n", "neither STEP, IGES nor BREP");
    refused("", "neither STEP, IGES nor BREP");
    refused("ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\n", "cut off");
    refused(
        "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;\nEND-ISO-10303-21;\n",
        "OCCT");
    // One line of 80 columns, the start of IGES; with a last section OCCT is asked.
    char iges[256];
    snprintf(iges, sizeof iges, "%-72sS%7d\n", "", 1);
    refused(iges, "cut off");
    snprintf(iges, sizeof iges, "%-72sS%7d\n%-72sT%7d\n", "", 1, "S      1", 1);
    refused(iges, "OCCT");
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_cad cad = {.nfaces = 0};
    assert_int_equal(kn_occt_read(ctx, &cad, "/nonexistent/part.stp"), KN_EIO);
    test_ctx_end(ctx, &memory);
}

static kn_status read_all(kn_ctx *ctx, void *user)
{
    kn_cad cad = {.nfaces = 0};
    kn_status status = kn_occt_read(ctx, &cad, user);
    if (status != KN_OK) assert_null(cad.faces);
    kn_cad_clear(ctx, &cad);
    return status;
}

static void out_of_memory(void **state)
{
    (void)state;
    char path[TEST_PATH_BYTES];
    kn_ctx *ctx = NULL;
    test_tmp_path(path, "starved.brep");
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK);
    assert_int_equal(kn_occt_make(ctx, KN_OCCT_CYLINDER, path), KN_OK);
    kn_ctx_destroy(ctx);
    test_allocation_failures(read_all, path);
    remove(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(brep_shapes),  cmocka_unit_test(step_shapes),   cmocka_unit_test(round_cylinder),
        cmocka_unit_test(smooth_edges), cmocka_unit_test(assembly),      cmocka_unit_test(real_surfaces),
        cmocka_unit_test(bad_files),    cmocka_unit_test(out_of_memory),
    };
    return cmocka_run_group_tests_name("bridges/occt_read", tests, NULL, NULL);
}

#else

static void left_out(void **state)
{
    (void)state;
    skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(left_out)};
    return cmocka_run_group_tests_name("bridges/occt_read", tests, NULL, NULL);
}

#endif
