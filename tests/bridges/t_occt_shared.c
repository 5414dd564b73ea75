// SPDX-License-Identifier: Apache-2.0
// Solids of CAD files through `knurl convert`: they come out as solids, with as many faces, edges and vertices, as Open
// CASCADE and gmsh see them.
#include "tests/support/support.h"

#if KN_WITH_OCCT
#include "bridges/occt/occt_check.h"
#include "bridges/occt/occt_probe.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct looked {
    kn_occt_report report;
    double volume;
    char name[32]; // of the first face
} looked;

static bool ends_in(const char *path, const char *ending)
{
    size_t n = strlen(path), m = strlen(ending);
    return n >= m && strcmp(path + n - m, ending) == 0;
}

// Of an oblique prism of height 11: the quadrature of surfaces of extrusion does not converge in OCCT 7.6.
static double prism(kn_ctx *ctx, const kn_occt_model *model, int nfaces)
{
    double least = INFINITY;
    for (int i = 0; i < nfaces; i++) {
        double area = 0.0;
        assert_int_equal(kn_occt_area(ctx, &area, model, i, 1e-9), KN_OK);
        least = fmin(least, area); // one of the two planes
    }
    return 11.0 * least;
}

static looked look_at(const char *path, bool is_prism)
{
    kn_ctx *ctx = NULL;
    kn_occt_model *model = NULL;
    looked out = {.volume = 0.0};
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK);
    kn_status status = ends_in(path, ".igs") ? kn_occt_open_iges(ctx, &model, path)
                                             : kn_occt_open_step(ctx, &model, path);
    if (status == KN_OK) status = kn_occt_check(ctx, &out.report, model);
    if (status == KN_OK) status = kn_occt_volume(ctx, &out.volume, model, 1e-8);
    if (status == KN_OK && is_prism) out.volume = prism(ctx, model, out.report.faces);
    if (status == KN_OK) status = kn_occt_face_name(ctx, out.name, sizeof out.name, model, 0);
    if (status != KN_OK) fail_msg("%s: %s", path, kn_ctx_message(ctx));
    kn_occt_close(ctx, model);
    kn_ctx_destroy(ctx);
    return out;
}

static void convert(const char *from, const char *to, const char *options)
{
    char line[4 * TEST_PATH_BYTES];
    snprintf(line, sizeof line, "'%s' convert -q '%s' -o '%s' %s", getenv("KNURL"), from, to, options);
    if (system(line) != 0) fail_msg("%s", line);
}

static void make(kn_occt_kind kind, const char *path)
{
    kn_ctx *ctx = NULL;
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK);
    if (kn_occt_make(ctx, kind, path) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    kn_ctx_destroy(ctx);
}

// One solid for one, of as many faces, edges and vertices. Outlines are within 1e-5 mm (docs/exchange.md), edges within a
// few times that of their faces, and of solids as large as these the volume within 1e-6.
static void expect_same(const looked *a, const looked *b, const char *what)
{
    const kn_occt_report *x = &a->report, *y = &b->report;
    if (!y->valid || y->first_invalid >= 0 || y->free_edges > 0 || y->closed_shells != x->closed_shells ||
        y->solids != x->solids || y->faces != x->faces || y->edges != x->edges || y->vertices != x->vertices)
        fail_msg(
            "%s: valid %d, face %d is not, %d free edges; %d, %d closed shells; %d, %d solids; %d, %d faces; %d, %d "
            "edges; %d, %d vertices",
            what, y->valid, y->first_invalid, y->free_edges, x->closed_shells, y->closed_shells, x->solids, y->solids,
            x->faces, y->faces, x->edges, y->edges, x->vertices, y->vertices);
    if (!(fabs(b->volume - a->volume) <= 1e-6 * a->volume))
        fail_msg("%s: volume %.12g, %.12g", what, a->volume, b->volume);
    if (!(y->max_tolerance <= 5e-5)) fail_msg("%s: tolerance %g", what, y->max_tolerance);
}

static void made_solids(void **state)
{
    (void)state;
    static const char *const endings[] = {".step", ".igs"};
    for (int kind = 0; kind < KN_OCCT_KINDS; kind++) {
        char from[TEST_PATH_BYTES], step[TEST_PATH_BYTES], to[TEST_PATH_BYTES], what[64];
        test_tmp_path(from, "shared.brep"), test_tmp_path(step, "shared.step");
        make((kn_occt_kind)kind, from), make((kn_occt_kind)kind, step);
        looked base = look_at(step, kind == KN_OCCT_EXTRUDED);
        assert_int_equal(base.report.solids, 1);
        if (kind == KN_OCCT_HOLLOW) assert_int_equal(base.report.closed_shells, 3);
        for (int i = 0; i < 2; i++) {
            snprintf(what, sizeof what, "shape %d%s", kind, endings[i]);
            snprintf(to, sizeof to, "%s%s", step, endings[i]);
            convert(from, to, "");
            looked out = look_at(to, false);
            expect_same(&base, &out, what);
            remove(to);
        }
        remove(from), remove(step);
    }
}

// Lower degrees: the solid is still one; edges of a higher degree than wanted are each face's own, and there are none here.
static void limited(void **state)
{
    (void)state;
    char from[TEST_PATH_BYTES], to[TEST_PATH_BYTES];
    test_tmp_path(from, "limited.step"), test_tmp_path(to, "limited-out.step");
    make(KN_OCCT_DRILLED, from);
    looked base = look_at(from, false);
    convert(from, to, "--max-degree 3 --tol 0.001");
    looked out = look_at(to, false);
    assert_true(out.report.max_degree <= 3);
    expect_same(&base, &out, "limited");
    remove(from), remove(to);
}

// Names of faces and colours go along, also twice.
static void names_and_colours(void **state)
{
    (void)state;
    char from[TEST_PATH_BYTES], to[TEST_PATH_BYTES], again[TEST_PATH_BYTES];
    test_tmp_path(from, "named.step"), test_tmp_path(to, "named-out.step"), test_tmp_path(again, "named-out.igs");
    make(KN_OCCT_CYLINDER, from);
    convert(from, to, "");
    char *text = test_read_file(to, NULL), *at;
    assert_non_null(text);
    assert_non_null(strstr(text, "MANIFOLD_SOLID_BREP('"));
    FILE *file = fopen(from, "w");
    assert_non_null(file);
    char *rest = text;
    for (; (at = strstr(rest, "ADVANCED_FACE(''")); rest = at + 15) {
        fwrite(rest, 1, (size_t)(at - rest) + 15, file);
        fputs("skin", file);
    }
    fputs(rest, file);
    assert_int_equal(fclose(file), 0);
    free(text);
    looked base = look_at(from, false);
    assert_string_equal(base.name, "skin");
    convert(from, to, ""), convert(from, again, "");
    looked step = look_at(to, false), iges = look_at(again, false);
    expect_same(&base, &step, "named"), expect_same(&base, &iges, "named .igs");
    assert_string_equal(step.name, "skin");
    assert_int_equal(base.report.ncolours, 1);
    assert_int_equal(step.report.ncolours, 1);
    for (int c = 0; c < 3; c++) // four digits of sRGB
        assert_true(fabs(step.report.colour[0][c] - base.report.colour[0][c]) <= 2e-4);
    remove(from), remove(to), remove(again);
}

// An assembly: each of its parts once.
static void real_file(void **state)
{
    (void)state;
    const char *from = "../shared/data/as1-oc-214.stp";
    char to[TEST_PATH_BYTES], *before = test_read_file(from, NULL);
    if (!before) {
        print_message("no %s here\n", from);
        skip();
    }
    for (int i = 0; i < 2; i++) {
        test_tmp_path(to, i == 0 ? "as1-out.step" : "as1-out.igs");
        convert(from, to, "");
        looked out = look_at(to, false);
        const kn_occt_report *r = &out.report;
        assert_true(r->valid && r->free_edges == 0);
        assert_int_equal(r->solids, 5), assert_int_equal(r->closed_shells, 5), assert_int_equal(r->faces, 53);
        assert_int_equal(r->edges, 126), assert_int_equal(r->vertices, 84);
        assert_int_equal(r->ncolours, 5);
        assert_true(r->max_tolerance <= 5e-5);
        if (i == 0) {
            char *text = test_read_file(to, NULL);
            assert_non_null(text);
            assert_non_null(strstr(text, "MANIFOLD_SOLID_BREP('nut'"));
            free(text);
        }
        remove(to);
    }
    free(before);
}

static void meshed(void **state)
{
    (void)state;
    char from[TEST_PATH_BYTES], to[TEST_PATH_BYTES], mesh[TEST_PATH_BYTES], log[TEST_PATH_BYTES];
    char command[4 * TEST_PATH_BYTES];
    if (system("command -v gmsh >/dev/null 2>&1") != 0) {
        print_message("no gmsh here\n");
        skip();
    }
    test_tmp_path(from, "meshed.brep"), test_tmp_path(to, "meshed.step");
    test_tmp_path(mesh, "meshed.msh"), test_tmp_path(log, "meshed.log");
    make(KN_OCCT_DRILLED, from);
    convert(from, to, "");
    snprintf(command, sizeof command, "gmsh -3 -format msh2 -v 3 -o '%s' '%s' >'%s' 2>&1", mesh, to, log);
    assert_int_equal(system(command), 0);
    char *said = test_read_file(log, NULL), *points = test_read_file(mesh, NULL);
    assert_true(said && points);
    if (strstr(said, "Error") || strstr(said, "Warning")) fail_msg("%s", said);
    assert_non_null(strstr(points, "$Elements"));
    assert_non_null(strstr(points, " 4 2 0 1 ")); // tetrahedra of one volume
    free(said), free(points);
    remove(from), remove(to), remove(mesh), remove(log);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(made_solids), cmocka_unit_test(limited), cmocka_unit_test(names_and_colours),
        cmocka_unit_test(real_file),   cmocka_unit_test(meshed),
    };
    return cmocka_run_group_tests_name("bridges/occt_shared", tests, NULL, NULL);
}
#else
int main(void)
{
    return 77; // skipped: no OCCT here
}
#endif
