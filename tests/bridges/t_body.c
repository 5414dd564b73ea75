// SPDX-License-Identifier: Apache-2.0
// Textures in the bodies of CAD files, from end to end: a knob that OCCT makes here, knurled; a rod in an assembly;
// sheets. What comes out is looked at by OCCT.
#include "tests/support/integral.h"
#include "tests/support/support.h"

#include <knurl/knurl.h>

#if KN_WITH_OCCT
#include "bridges/occt/cad_read.h"
#include "bridges/occt/occt_check.h"
#include "bridges/occt/occt_knob.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { KNOB_FACES = 7 };

// Runs `knurl apply ARGUMENTS`; answers its exit code, and what it printed on both streams: free it.
static int apply(char **said, const char *format, ...) KN_PRINTF(2, 3);
static int apply(char **said, const char *format, ...)
{
    char arguments[2 * TEST_PATH_BYTES], log[TEST_PATH_BYTES], line[4 * TEST_PATH_BYTES];
    test_tmp_path(log, "body.log");
    va_list list;
    va_start(list, format);
    vsnprintf(arguments, sizeof arguments, format, list);
    va_end(list);
    snprintf(line, sizeof line, "'%s' apply %s >'%s' 2>&1", getenv("KNURL"), arguments, log);
    int status = system(line);
    *said = test_read_file(log, NULL);
    assert_non_null(*said);
    remove(log);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static int count(const char *text, const char *word)
{
    int n = 0;
    for (const char *at = strstr(text, word); at; at = strstr(at + 1, word)) n++;
    return n;
}

static void expect_text(const char *said, const char *part)
{
    if (!strstr(said, part)) fail_msg("not said: \"%s\", but: %s", part, said);
}

typedef struct scene {
    kn_ctx *ctx;
    char knob[TEST_PATH_BYTES], out[TEST_PATH_BYTES];
    kn_occt_report base;
} scene;

static kn_occt_report check_file(kn_ctx *ctx, const char *path)
{
    kn_occt_model *model = NULL;
    kn_occt_report report = {0};
    if (kn_occt_open_step(ctx, &model, path) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    assert_int_equal(kn_occt_check(ctx, &report, model), KN_OK);
    kn_occt_close(ctx, model);
    return report;
}

static void make(scene *s)
{
    assert_int_equal(kn_ctx_create(&s->ctx, NULL), KN_OK);
    test_tmp_path(s->knob, "knob.step"), test_tmp_path(s->out, "knob-out.step");
    if (kn_occt_write_knob(s->ctx, s->knob) != KN_OK) fail_msg("%s", kn_ctx_message(s->ctx));
    s->base = check_file(s->ctx, s->knob);
    assert_int_equal(s->base.faces, KNOB_FACES);
    assert_true(s->base.valid);
}

static void clear(scene *s)
{
    remove(s->knob), remove(s->out);
    kn_ctx_destroy(s->ctx);
}

// The part of a texture's patches, all of which .g2 holds exactly, in (1/3) int x . dA.
static double volume_of(kn_ctx *ctx, const char *path)
{
    kn_model model = {0};
    double volume = 0.0, area = 0.0;
    assert_int_equal(kn_read_model(ctx, &model, path), KN_OK);
    assert_true(model.nsplines > 0);
    for (int i = 0; i < model.nsplines; i++)
        test_add_integrals(ctx, &volume, &area, &(kn_patch){.spline = &model.splines[i]});
    kn_model_clear(ctx, &model);
    return volume;
}

static void expect_body(const char *said, const char *mode, int replaced, int kept, bool closed)
{
    const char *json = strchr(said, '{');
    assert_non_null(json);
    json_t *root = json_loads(json, JSON_DISABLE_EOF_CHECK, NULL), *body = json_object_get(root, "body");
    assert_non_null(body);
    assert_string_equal(json_string_value(json_object_get(body, "mode")), mode);
    assert_int_equal(json_integer_value(json_object_get(body, "faces_replaced")), replaced);
    assert_int_equal(json_integer_value(json_object_get(body, "faces_kept")), kept);
    assert_int_equal(json_is_true(json_object_get(body, "closed")), closed);
    json_decref(root);
}

// One solid, closed and valid; the other faces are what they were; the volume is that of the knob, less the part of the
// grip's cylinder, and with that of the texture. x . n = 12 on the cylinder, whose axis is z.
static void knurled_knob(void **state)
{
    (void)state;
    scene s;
    make(&s);
    char *said, g2[TEST_PATH_BYTES];
    test_tmp_path(g2, "knob.g2");
    int code = apply(
        &said, "'%s' --faces name:grip --tile knurl --count 12,2 --height 0.8 --taper 2.4 --json -o '%s' -o '%s'",
        s.knob, s.out, g2);
    if (code != 0) fail_msg("%s", said);
    expect_body(said, "replace", 1, KNOB_FACES - 1, true);
    free(said);
    kn_occt_report r = check_file(s.ctx, s.out);
    assert_int_equal(r.solids, 1);
    assert_int_equal(r.closed_shells, 1);
    assert_int_equal(r.shells, 1);
    assert_int_equal(r.free_edges, 0);
    assert_true(r.valid);
    assert_int_equal(r.faces, KNOB_FACES - 1 + 12 * 2 * 13);
    assert_int_equal(r.valid_faces, r.faces);
    double grip = 12.0 * (2.0 * acos(-1.0) * 12.0 * 9.5) / 3.0;
    double expected = s.base.volume - grip + volume_of(s.ctx, g2);
    assert_true(fabs(r.volume - expected) <= 1e-6 * expected);
    assert_true(r.volume > s.base.volume); // the texture is outside

    char *text = test_read_file(s.out, NULL);
    assert_non_null(text);
    assert_int_equal(count(text, "=PLANE("), 3);
    assert_int_equal(count(text, "=CYLINDRICAL_SURFACE("), 1);
    assert_int_equal(count(text, "=TOROIDAL_SURFACE("), 2);
    assert_int_equal(count(text, "=PRODUCT("), 1);
    expect_text(text, "PRODUCT('knob'");
    expect_text(text, "PRE_DEFINED_COLOUR('red')"); // of the two fillets
    assert_null(strstr(text, "'grip'"));
    expect_text(text, "ADVANCED_FACE('grip c11,1 ");
    assert_null(strstr(text, "('s0 c"));
    free(text);
    remove(g2);
    clear(&s);
}

// Cubics in the place of the exact faces: those of the border are the edges of the body, too.
static void limited_knob(void **state)
{
    (void)state;
    scene s;
    make(&s);
    char *said;
    int code = apply(&said,
                     "'%s' --faces name:grip --tile straight --count 8,2 --height 0.6 --taper 1.5 --max-degree cubic "
                     "--body replace --json -o '%s'",
                     s.knob, s.out);
    if (code != 0) fail_msg("%s", said);
    expect_body(said, "replace", 1, KNOB_FACES - 1, true);
    free(said);
    kn_occt_report r = check_file(s.ctx, s.out);
    assert_int_equal(r.solids, 1);
    assert_int_equal(r.closed_shells, 1);
    assert_int_equal(r.free_edges, 0);
    assert_int_equal(r.max_degree, 3);
    assert_int_equal(r.faces, KNOB_FACES - 1 + 8 * 2 * 3);
    assert_int_equal(r.valid_faces, r.faces);
    assert_true(r.valid);
    assert_true(r.volume > s.base.volume);
    clear(&s);
}

// Everything of the knob stays, and the texture is a product of its own; or the texture is alone.
static void covered_knob(void **state)
{
    (void)state;
    scene s;
    make(&s);
    char *said;
    int code = apply(&said, "'%s' --faces name:grip --tile straight --count 8,2 --body cover --json -o '%s'", s.knob,
                     s.out);
    if (code != 0) fail_msg("%s", said);
    expect_body(said, "cover", 0, KNOB_FACES, true);
    free(said);
    kn_occt_report r = check_file(s.ctx, s.out);
    assert_int_equal(r.solids, 1);
    assert_int_equal(r.faces, KNOB_FACES + 8 * 2 * 3);
    assert_true(fabs(r.volume - s.base.volume) <= 1e-9 * r.volume);
    char *text = test_read_file(s.out, NULL);
    assert_int_equal(count(text, "=PRODUCT("), 2);
    expect_text(text, "'grip'");
    free(text);

    code = apply(&said, "'%s' --faces name:grip --tile straight --count 8,2 --body none --json -o '%s'", s.knob,
                 s.out);
    if (code != 0) fail_msg("%s", said);
    expect_text(said, "\"body\": null");
    free(said);
    r = check_file(s.ctx, s.out);
    assert_int_equal(r.faces, 8 * 2 * 3);
    assert_int_equal(r.solids, 0);
    clear(&s);
}

// What cannot be closed is said, and nothing is written; by default it is covered, with the reason.
static void cannot_replace(void **state)
{
    (void)state;
    static const struct {
        const char *options, *why;
    } cases[] = {
        {"--tile knurl --count 16,3", "ends above face"},
        {"--tile chain --count 8,3 --taper 2", "leaves gaps"},
        {"--tile scale --count 8,3 --taper 2", "does not fill face"},
        {"--tile knurl --count 16,3 --taper 2 --density 0.5", "cells are left out"},
        {"--tile flower --count 6,2 --height 0.1 --taper 3", "do not meet bit for bit"},
    };
    scene s;
    make(&s);
    char *said;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int code = apply(&said, "'%s' --faces name:grip %s --body replace -o '%s'", s.knob, cases[i].options, s.out);
        assert_int_equal(code, 3);
        expect_text(said, cases[i].why);
        free(said);
        assert_int_not_equal(access(s.out, F_OK), 0);
    }
    int code = apply(&said, "'%s' --faces name:grip %s -o '%s'", s.knob, cases[0].options, s.out);
    assert_int_equal(code, 0);
    expect_text(said, "its faces stay below the texture (--body cover): the texture ends above face");
    free(said);
    assert_int_equal(apply(&said, "data/teapot.bpt --tile knurl --count 2,2 --body replace -o '%s'", s.out), 2);
    expect_text(said, "it needs a base from a CAD file");
    free(said);
    assert_int_equal(apply(&said, "'%s' --tile knurl --body perhaps -o '%s'", s.knob, s.out), 2);
    expect_text(said, "replace, cover or none");
    free(said);
    clear(&s);
}

// OCCT hashes addresses, which are others in each run; of three coloured products, the file is the same in all.
static void the_same_bytes(void **state)
{
    (void)state;
    static const char *const schemas[] = {"ap214", "ap214", "ap214", "ap214", "ap214", "ap203", "ap242"};
    scene s;
    make(&s);
    char *said, *first[2] = {NULL, NULL}, two[TEST_PATH_BYTES];
    size_t bytes[2] = {0, 0};
    test_tmp_path(two, "two.step");
    assert_int_equal(apply(&said,
                           "'%s' --faces name:grip --tile straight --count 4,1 --height 0.5 --body cover -o '%s'",
                           s.knob, two),
                     0);
    free(said);
    for (size_t i = 0; i < 2 * sizeof schemas / sizeof *schemas; i++) {
        int code = apply(&said,
                         "'%s' --faces 2 --tile straight --count 4,1 --height 0.1 --body cover --step %s -o '%s'",
                         two, schemas[i / 2], s.out);
        if (code != 0) fail_msg("%s", said);
        free(said);
        int k = (int)(i % 2);
        first[k] = test_read_file(s.out, &bytes[k]);
        assert_non_null(first[k]);
        assert_int_equal(count(first[k], "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION"), 3);
        if (k == 0) continue;
        assert_int_equal(bytes[0], bytes[1]);
        assert_memory_equal(first[0], first[1], bytes[0]);
        free(first[0]), free(first[1]);
    }
    kn_occt_report r = check_file(s.ctx, s.out);
    assert_true(r.valid);
    assert_int_equal(r.ncolours, 4); // three of the knob, and the tile's
    remove(two);
    clear(&s);
}

// ---- real files ----

static bool shared(char path[TEST_PATH_BYTES], const char *name)
{
    snprintf(path, TEST_PATH_BYTES, "../shared/data/%s", name);
    if (access(path, R_OK) == 0) return true;
    print_message("%s is not here: skipped\n", path);
    return false;
}

// The part of two faces of a file: its cylinders are none but for some digits.
static double faces_of(kn_ctx *ctx, const char *path, int a, int b)
{
    kn_cad cad = {0};
    double volume = 0.0, area = 0.0;
    assert_int_equal(kn_occt_read(ctx, &cad, path), KN_OK);
    assert_true(cad.nfaces > a && cad.nfaces > b);
    test_add_integrals(ctx, &volume, &area, &(kn_patch){.spline = &cad.faces[a].surface});
    test_add_integrals(ctx, &volume, &area, &(kn_patch){.spline = &cad.faces[b].surface});
    kn_cad_clear(ctx, &cad);
    return volume;
}

// The rod of an assembly: two half cylinders, splines that meet along two edges. All 18 instances of 5 parts are there,
// and the rod, which stands there once, has the volume of the texture in place of its two faces'.
static void rod(void **state)
{
    (void)state;
    char path[TEST_PATH_BYTES], *said, g2[TEST_PATH_BYTES];
    if (!shared(path, "as1-oc-214.stp")) skip();
    scene s;
    make(&s);
    test_tmp_path(g2, "rod.g2");
    kn_occt_report before = check_file(s.ctx, path);
    int code = apply(&said,
                     "'%s' --faces 'body:rod&type:bspline' --tile straight --count 2,2 --height 0.5 --taper 15 "
                     "--body replace --json -o '%s' -o '%s'",
                     path, s.out, g2);
    if (code != 0) fail_msg("%s", said);
    expect_body(said, "replace", 2, 51, true);
    free(said);
    kn_occt_report r = check_file(s.ctx, s.out);
    assert_int_equal(r.placed_solids, before.placed_solids);
    assert_int_equal(r.placed_solids, 18);
    assert_int_equal(r.solids, before.solids);
    assert_int_equal(r.closed_shells, before.closed_shells);
    assert_int_equal(r.free_edges, 0);
    assert_int_equal(r.ncolours, before.ncolours + 1);
    assert_true(r.valid);
    assert_int_equal(r.faces, before.faces - 2 + 2 * 2 * 2 * 3);
    double expected = before.volume - faces_of(s.ctx, path, 9, 10) + volume_of(s.ctx, g2);
    assert_true(fabs(r.volume - expected) <= 1e-6 * 15708.0); // the rod's own: radius 5, length 200
    assert_true(r.volume > before.volume);
    remove(g2);
    clear(&s);
}

// All sides of two parts that coincide in their own coordinates, and neighbours among them at right angles, which come
// down to the edges between them. Each part is a solid by itself.
static void boxes(void **state)
{
    (void)state;
    char *said, g2[TEST_PATH_BYTES];
    scene s;
    make(&s);
    test_tmp_path(g2, "boxes.g2");
    if (kn_occt_write_boxes(s.ctx, s.knob) != KN_OK) fail_msg("%s", kn_ctx_message(s.ctx));
    // x and y = 0: no part of (1/3) int x . dA
    const char *const faces[] = {"near:0,10,15+near:5,0,15", "0-11"};
    for (int k = 0; k < test_cases(2); k++) {
        int replaced = k == 0 ? 2 : 12;
        int code = apply(
            &said,
            "'%s' --faces '%s' --tile bump --count 3 --taper 2 --height 0.5 --body replace --json -o '%s' "
            "-o '%s'",
            s.knob, faces[k], s.out, g2);
        if (code != 0) fail_msg("%s", said);
        expect_body(said, "replace", replaced, 12 - replaced, true);
        free(said);
        kn_occt_report r = check_file(s.ctx, s.out);
        assert_int_equal(r.solids, 2);
        assert_int_equal(r.closed_shells, 2);
        assert_int_equal(r.shells, 2);
        assert_int_equal(r.free_edges, 0);
        assert_true(r.valid);
        double expected = volume_of(s.ctx, g2) + (k == 0 ? 2.0 * 10.0 * 20.0 * 30.0 : 0.0);
        assert_true(fabs(r.volume - expected) <= 1e-6 * expected);
        assert_true(r.volume > 2.0 * 10.0 * 20.0 * 30.0); // the texture is outside
    }
    remove(g2);
    clear(&s);
}

// The same protocol as asked for, in all of the file.
static void protocols(void **state)
{
    (void)state;
    static const char *const schemas[][2] = {{"ap203", "CONFIG_CONTROL_DESIGN"},
                                             {"ap242", "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING"}};
    scene s;
    make(&s);
    for (size_t i = 0; i < 2; i++) {
        char *said, *text;
        int code = apply(
            &said, "'%s' --faces name:grip --tile straight --count 4,1 --taper 3 --step %s --body replace -o '%s'",
            s.knob, schemas[i][0], s.out);
        if (code != 0) fail_msg("%s", said);
        free(said);
        kn_occt_report r = check_file(s.ctx, s.out);
        assert_true(r.valid);
        assert_int_equal(r.closed_shells, 1);
        assert_int_equal(r.faces, KNOB_FACES - 1 + 4 * 3);
        text = test_read_file(s.out, NULL);
        assert_non_null(text);
        expect_text(text, schemas[i][1]);
        assert_null(strstr(text, "automotive"));
        free(text);
    }
    clear(&s);
}

// One of four sheets side by side: an open shell.
static void sheet(void **state)
{
    (void)state;
    char path[TEST_PATH_BYTES], *said;
    if (!shared(path, "splinecage.stp")) skip();
    scene s;
    make(&s);
    int code = apply(&said, "'%s' --faces 0 --tile knurl --count 2,2 --json -o '%s'", path, s.out);
    if (code != 0) fail_msg("%s", said);
    expect_body(said, "replace", 1, 3, false);
    free(said);
    kn_occt_report r = check_file(s.ctx, s.out);
    assert_int_equal(r.solids, 0);
    assert_int_equal(r.faces, 3 + 2 * 2 * 13);
    assert_int_equal(r.valid_faces, r.faces);
    char *text = test_read_file(s.out, NULL);
    expect_text(text, "ADVANCED_FACE('face 0 c1,1 "); // it has no name
    free(text);
    clear(&s);
}

// The recipes of examples/cad for files that are not there, beside a copy of the file; fewer cells.
static void recipes(void **state)
{
    (void)state;
    static const struct {
        const char *name, *file, *cells, *mode;
        int replaced, kept;
        bool closed;
    } all[] = {{"rod", "as1-oc-214.stp", "--count 4,3 --taper 40", "replace", 2, 51, true},
               {"cage", "splinecage.stp", "--count 2,2", "replace", 1, 3, false},
               {"surf114", "surf114.igs", "", "cover", 0, 4, false}};
    scene s;
    size_t ran = 0;
    make(&s);
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        char path[TEST_PATH_BYTES], from[TEST_PATH_BYTES], recipe[TEST_PATH_BYTES], copy[TEST_PATH_BYTES], *said;
        if (!shared(path, all[i].file)) continue;
        size_t bytes;
        char *whole = test_read_file(path, &bytes), *text;
        assert_non_null(whole);
        snprintf(from, sizeof from, "examples/cad/%s.json", all[i].name);
        test_tmp_path(recipe, "recipe.json");
        test_tmp_path(copy, all[i].file);
        text = test_read_file(from, NULL);
        assert_non_null(text);
        char *base = strstr(text, all[i].file); // what lies beside the recipe has a name of this run
        assert_non_null(base);
        FILE *file = fopen(recipe, "w");
        assert_non_null(file);
        fprintf(file, "%.*s%s%s", (int)(base - text), text, strrchr(copy, '/') + 1, base + strlen(all[i].file));
        assert_int_equal(fclose(file), 0);
        file = fopen(copy, "w");
        assert_non_null(file);
        assert_int_equal(fwrite(whole, 1, bytes, file), bytes);
        assert_int_equal(fclose(file), 0);
        if (apply(&said, "'%s' %s --json -o '%s'", recipe, all[i].cells, s.out) != 0) fail_msg("%s", said);
        expect_body(said, all[i].mode, all[i].replaced, all[i].kept, all[i].closed);
        if (i == 1) assert_true(check_file(s.ctx, s.out).valid); // OCCT takes long for the others
        free(said), free(text), free(whole);
        remove(recipe), remove(copy);
        ran++;
    }
    clear(&s);
    if (ran == 0) skip();
}

int main(void)
{
    // OCCT takes its time for the last ones, and files of other builds are the same: in gcc's release alone.
#if defined NDEBUG && !defined __clang__
    const size_t left_out = 0;
#else
    const size_t left_out = 4;
#endif
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(limited_knob),   cmocka_unit_test(covered_knob), cmocka_unit_test(cannot_replace),
        cmocka_unit_test(boxes),          cmocka_unit_test(sheet),        cmocka_unit_test(recipes),
        cmocka_unit_test(knurled_knob),   cmocka_unit_test(rod),          cmocka_unit_test(protocols),
        cmocka_unit_test(the_same_bytes),
    };
    return _cmocka_run_group_tests("bridges/body", tests, sizeof tests / sizeof *tests - left_out, NULL, NULL);
}
#else
static void without_occt(void **state)
{
    (void)state;
    skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(without_occt)};
    return cmocka_run_group_tests_name("bridges/body", tests, NULL, NULL);
}
#endif
