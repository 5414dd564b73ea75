// SPDX-License-Identifier: Apache-2.0
// CAD files at the command line: what info lists, how --faces chooses, what broken and compressed files do, and faces
// as tiles.
#include "tests/cli/command.h"

#if KN_WITH_OCCT
#include "bridges/occt/occt_probe.h"

#include <knurl/io.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char knob[] =
    "examples/cad/knob.step"; // 0 plane, 1 torus, 2 cylinder, 3 grip, 4 plane, 5 torus, 6 plane

static void make(char path[PATH_BYTES], const char *name, kn_occt_kind kind)
{
    kn_ctx *ctx = NULL;
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK);
    test_tmp_path(path, name);
    if (kn_occt_make(ctx, kind, path) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    kn_ctx_destroy(ctx);
}

static void assert_said(const char *text)
{
    if (!strstr(complained, text)) fail_msg("not said: \"%s\", but: %s", text, complained);
}

// One line that names the file.
static void assert_one_line_about(const char *path)
{
    assert_said(path);
    const char *end = strchr(complained, '\n');
    assert_non_null(end);
    assert_int_equal(end[1], '\0');
}

static size_t size_of(const json_t *root, const char *key)
{
    return json_array_size(json_object_get(root, key));
}

static void assert_face(const json_t *root, size_t i, const char *type, const char *name, const char *color)
{
    const json_t *face = json_array_get(json_object_get(root, "faces"), i);
    assert_string_equal(json_string_value(json_object_get(face, "type")), type);
    assert_string_equal(json_string_value(json_object_get(face, "name")), name);
    assert_string_equal(json_string_value(json_object_get(face, "color")), color);
    assert_int_equal(json_integer_value(json_object_get(face, "body")), 0);
    assert_int_equal(json_integer_value(json_object_get(face, "open_edges")), 0);
}

static void what_is_in_a_file(void **state)
{
    (void)state;
    assert_int_equal(run("info '%s' --json", knob), 0);
    json_t *root = printed_json();
    assert_string_equal(json_string_value(json_object_get(root, "format")), "CAD");
    assert_int_equal(size_of(root, "bodies"), 1);
    assert_int_equal(size_of(root, "faces"), 7);
    assert_int_equal(size_of(root, "edges"), 10);
    const json_t *body = json_array_get(json_object_get(root, "bodies"), 0);
    assert_string_equal(json_string_value(json_object_get(body, "name")), "knob");
    assert_true(json_is_true(json_object_get(body, "solid")));
    assert_face(root, 0, "plane", "", "#cbcbd3");
    assert_face(root, 1, "torus", "", "#e75959");
    assert_face(root, 3, "cylinder", "grip", "#595959");
    json_decref(root);
    assert_int_equal(run("info '%s'", knob), 0);
    assert_non_null(strstr(printed, "1 body, 7 faces, 10 edges"));
    assert_non_null(strstr(printed, "grip"));
}

// Converted to IGES faces and bodies keep their names; a texture's faces have them in front.
static void names_in_iges(void **state)
{
    (void)state;
    char path[PATH_BYTES];
    test_tmp_path(path, "named.igs");
    assert_int_equal(run("convert '%s' -q -o '%s'", knob, path), 0);
    assert_int_equal(run("info '%s' --json", path), 0);
    json_t *root = printed_json();
    const json_t *body = json_array_get(json_object_get(root, "bodies"), 0);
    assert_string_equal(json_string_value(json_object_get(body, "name")), "knob");
    assert_face(root, 0, "bspline", "", "#cbcbd3");
    assert_face(root, 3, "bspline", "grip", "#595959");
    json_decref(root);
    assert_int_equal(run("apply '%s' --faces 2,3 --no-join --tile straight --count 4,1 -q -o '%s'", knob, path), 0);
    assert_int_equal(run("info '%s'", path), 0);
    assert_non_null(strstr(printed, " grip c1,0 ridge 2 "));
    assert_non_null(strstr(printed, " face 2 c3,0 ridge 0 "));
    remove(path);
}

// A face that cannot be textured is named by its number in the file, and its name.
static void a_face_is_to_blame(void **state)
{
    (void)state;
    char out[PATH_BYTES];
    test_tmp_path(out, "blame.stl");
    assert_int_equal(run("apply '%s' --faces 2-3 --no-join --tile straight --count 2,2 -q -o '%s'", knob, out), 3);
    assert_non_null(strstr(complained, "surface 0, which has 4 knot spans there"));
    assert_non_null(strstr(complained, "; surface 0 is face 2 of the file\n"));
    assert_int_equal(run("apply '%s' --faces 3 --tile straight --count 2,2 -q -o '%s'", knob, out), 3);
    assert_non_null(strstr(complained, "; surface 0 is face 3 of the file, \"grip\"\n"));
    assert_int_equal(run("apply data/cone.g2 --tile straight --count 1,1 -q -o '%s'", out), 3);
    assert_null(strstr(complained, " of the file"));
}

// A cylinder in each format.
static void three_formats(void **state)
{
    (void)state;
    static const char *const names[] = {"cylinder.step", "cylinder.brep", "cylinder.igs"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char path[PATH_BYTES], out[PATH_BYTES];
        make(path, names[i], KN_OCCT_CYLINDER);
        test_tmp_path(out, "cylinder.stl");
        assert_int_equal(run("info '%s' --json", path), 0);
        json_t *root = printed_json();
        assert_int_equal(size_of(root, "faces"), 3);
        json_decref(root);
        assert_int_equal(run("apply '%s' --faces type:cylinder --tile straight --count 8,2 -q -o '%s'", path, out),
                         0);
        assert_true(exists(out));
        remove(out), remove(path);
    }
}

static int chosen(const char *faces)
{
    if (run("apply '%s' --faces '%s' --no-join --trimmed keep --tile straight --count 8,2 --dry-run --json", knob,
            faces) != 0)
        fail_msg("%s: %s", faces, complained);
    json_t *root = printed_json();
    int n = (int)json_integer_value(json_object_get(root, "surfaces"));
    json_decref(root);
    return n;
}

static void faces_are_chosen(void **state)
{
    (void)state;
    static const struct {
        const char *faces;
        int n;
    } cases[] = {
        {"0,3", 2},
        {"1-3", 3},
        {"name:grip", 1},
        {"name:GR?P&3", 1},
        {"type:torus", 2},
        {"color:#e75959", 2},
        {"body:0", 7},
        {"body:k*&type:pl*", 3},
        {"near:12,0,10&3", 1},
        {"name:grip+4-5", 3},
        {"colour:#595959&type:cylinder", 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        if (chosen(cases[i].faces) != cases[i].n) fail_msg("%s: %s", cases[i].faces, printed);
}

// What is not there: bad input, and the message says what there is. What is no choice: usage.
static void faces_are_not_there(void **state)
{
    (void)state;
    static const struct {
        const char *faces;
        int code;
        const char *said;
    } cases[] = {
        {"name:x", 3, "none with name:x; there is grip"},
        {"type:cone", 3, "there is plane, torus, cylinder"},
        {"color:#000000", 3, "there is #cbcbd3, #e75959, #595959"},
        {"body:9", 3, "there is knob"},
        {"7", 3, "face 7; the file has 0 to 6"},
        {"type:plane&name:grip", 3, "none with all of type:plane&name:grip"},
        {"near:1,2", 3, "near:X,Y,Z"},
        {"near:nan,0,0", 3, "got 'nan,0,0'"},
        {"sort:plane", 3, "got 'sort:plane'"},
        {"plane", 2, "name:TEXT"},
        {"3-1", 2, "got '3-1'"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int code = run("apply '%s' --faces '%s' --tile straight --count 8,2 --dry-run", knob, cases[i].faces);
        if (code != cases[i].code) fail_msg("%s: %d: %s", cases[i].faces, code, complained);
        assert_said(cases[i].said);
        if (code == 3) assert_one_line_about(knob);
    }
    char path[PATH_BYTES];
    test_tmp_path(path, "square.g2");
    write_text(path, "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n");
    assert_int_equal(run("apply '%s' --faces name:x --tile straight --count 2,2 --dry-run", path), 2);
    assert_said("is no CAD file");
}

static char *knob_text(size_t *bytes)
{
    char *text = test_read_file(knob, bytes);
    assert_non_null(text);
    return text;
}

static void broken_files(void **state)
{
    (void)state;
    char path[PATH_BYTES];
    size_t bytes = 0;
    char *text = knob_text(&bytes);
    test_tmp_path(path, "broken.step");
    static const size_t parts[] = {0, 10, 500}; // of a thousand
    static const char *const why[] = {"neither STEP, IGES nor BREP", "is cut off", "is cut off"};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        test_write_file(path, text, bytes / 1000 * parts[i]);
        assert_int_equal(run("info '%s'", path), 3);
        assert_one_line_about(path);
        assert_said(why[i]);
        assert_int_equal(run("apply '%s' --tile straight --count 2,2 --dry-run", path), 3);
        assert_one_line_about(path);
    }
    char *at = strstr(text, "CARTESIAN_POINT('',("); // one that is no number
    assert_non_null(at);
    at = strchr(at, '(') + 4;
    memcpy(at + 1, "NAN", 3);
    test_write_file(path, text, bytes);
    int code = run("info '%s'", path);
    assert_true(code == 0 || code == 3);
    assert_null(strstr(printed, "nan"));
    remove(path);
    assert_int_equal(run("info '%s'", path), 3);
    assert_one_line_about(path);
    free(text);
}

// Without the program that reads them.
static void no_reader(void **state)
{
    (void)state;
    assert_int_equal(setenv("KNURL_CAD", "/nowhere/knurl-cad", 1), 0);
    int code = run("info '%s'", knob);
    assert_int_equal(unsetenv("KNURL_CAD"), 0);
    assert_int_not_equal(code, 0);
    assert_said("needs knurl-cad");
    assert_one_line_about(knob);
#if !defined(__SANITIZE_ADDRESS__) // under which it does not limit itself
    assert_int_equal(setenv("KNURL_CAD_BYTES", "1000000", 1), 0);
    code = run("info '%s'", knob);
    assert_int_equal(unsetenv("KNURL_CAD_BYTES"), 0);
    assert_int_not_equal(code, 0);
    assert_null(strstr(complained, "malloc")); // in words of ours
    assert_one_line_about(knob);
#endif
}

#if KN_WITH_ZLIB
static void compressed_files(void **state)
{
    (void)state;
    char flat[PATH_BYTES], packed[PATH_BYTES], out[PATH_BYTES];
    test_tmp_path(flat, "flat.g2"), test_tmp_path(packed, "packed.stpz"), test_tmp_path(out, "again.stp");
    write_text(flat, "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n9 0 0\n0 9 0\n9 9 0\n");
    assert_int_equal(run("apply '%s' --tile straight --count 2,2 -q -o '%s'", flat, packed), 0);
    size_t bytes = 0;
    char *text = test_read_file(packed, &bytes);
    assert_non_null(text);
    assert_true((unsigned char)text[0] == 0x1f && (unsigned char)text[1] == 0x8b);
    assert_int_equal(run("info '%s' --json", packed), 0);
    json_t *root = printed_json();
    assert_int_equal(size_of(root, "faces"), 2 * 2 * 3);
    json_decref(root);
    assert_int_equal(run("apply '%s' --faces 0 --tile straight --count 1,1 -q -o '%s'", packed, out), 0);
    assert_true(exists(out));
    test_write_file(out, text, bytes); // by what is in it, not by its name
    assert_int_equal(run("info '%s'", out), 0);
    test_write_file(packed, text, bytes / 2);
    assert_int_equal(run("info '%s'", packed), 3);
    assert_one_line_about(packed);
    assert_said("cut off");
    free(text);
    text = knob_text(&bytes);
    test_write_file(out, text, bytes / 2);
    char line[3 * PATH_BYTES];
    snprintf(line, sizeof line, "gzip -n <'%s' >'%s'", out, packed);
    assert_int_equal(system(line), 0);
    assert_int_equal(run("info '%s'", packed), 3); // what is wrong inside is said of the file itself
    assert_one_line_about(packed);
    assert_said("END-ISO-10303-21");
    free(text);
    remove(flat), remove(packed), remove(out);
}
#else
static void compressed_files(void **state)
{
    (void)state;
    skip();
}
#endif

// ---- faces as tiles ----

static void box_of(const char *path, int splines, double lo[3], double hi[3])
{
    kn_ctx *ctx = NULL;
    kn_model model = {0};
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK);
    assert_int_equal(kn_read_model(ctx, &model, path), KN_OK);
    assert_int_equal(model.nsplines, splines);
    for (int c = 0; c < 3; c++) lo[c] = INFINITY, hi[c] = -INFINITY;
    for (int i = 0; i < model.nsplines; i++) {
        const kn_spline *s = &model.splines[i];
        size_t n = kn_spline_count(s);
        for (size_t k = 0; k < 3 * n; k++) {
            lo[k / n] = fmin(lo[k / n], s->coef[k]);
            hi[k / n] = fmax(hi[k / n], s->coef[k]);
        }
    }
    kn_model_clear(ctx, &model);
    kn_ctx_destroy(ctx);
}

// A box of 10 x 20 x 30 on a square of side 2, four times, at a height of 1/8 of the w-axis's unit: it fills the
// square up to 30/8.
static void a_box_is_a_tile(void **state)
{
    (void)state;
    static const char *const names[] = {"box.step", "box.igs", "box.brep"};
    char flat[PATH_BYTES], out[PATH_BYTES];
    test_tmp_path(flat, "flat.g2"), test_tmp_path(out, "boxes.g2");
    write_text(flat, "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n2 0 0\n0 2 0\n2 2 0\n");
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char path[PATH_BYTES];
        double lo[3], hi[3];
        make(path, names[i], KN_OCCT_BOX);
        int code = run("apply '%s' --tile '%s' --tile-cell 0,0,10,20 --count 2,2 --height 0.125 -q -o '%s'", flat,
                       path, out);
        if (code != 0) fail_msg("%s", complained);
        box_of(out, 4 * 6, lo, hi);
        static const double most[3] = {2, 2, 3.75};
        for (int c = 0; c < 3; c++) assert_true(fabs(lo[c]) <= 1e-12 && fabs(hi[c] - most[c]) <= 1e-12);
        remove(path), remove(out);
    }
    remove(flat);
}

// How many faces have this colour in a STEP file that is made of the knob with these options.
static int colored(const char *options, const char *color)
{
    char step[PATH_BYTES];
    int n = 0;
    test_tmp_path(step, "colored.step");
    if (run("apply '%s' --no-join --trimmed keep --height 0.5 --body none -q %s -o '%s'", knob, options, step) != 0)
        fail_msg("%s: %s", options, complained);
    assert_int_equal(run("info '%s' --json", step), 0);
    json_t *root = printed_json();
    const json_t *faces = json_object_get(root, "faces");
    for (size_t i = 0; i < json_array_size(faces); i++) {
        const char *own = json_string_value(json_object_get(json_array_get(faces, i), "color"));
        n += own && strcmp(own, color) == 0;
    }
    json_decref(root);
    remove(step);
    return n;
}

// A tile that has a colour keeps it; one of which nobody said any takes that of the face below.
static void faces_keep_their_colors(void **state)
{
    (void)state;
    char plain[PATH_BYTES], red[PATH_BYTES], options[4 * PATH_BYTES];
    test_tmp_path(plain, "plain.g2"), test_tmp_path(red, "red.json");
    write_text(plain, "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0.5\n1 0 0.5\n0 1 0.5\n1 1 0.5\n");
    snprintf(options, sizeof options, "--faces name:grip --tile '%s' --count 4,1", plain);
    assert_int_equal(colored(options, "#595959"), 4);
    snprintf(options, sizeof options, "--faces 0,1,3 --tile '%s' --count 4,4", plain); // a plane, a torus, the grip
    assert_int_equal(colored(options, "#cbcbd3"), 16);
    assert_int_equal(colored(options, "#e75959"), 16);
    assert_int_equal(colored(options, "#595959"), 16);
    snprintf(options, sizeof options, "--faces 0,1,3 --tile '%s' --count 4,4 --color 0 --palette 00ff00", plain);
    assert_int_equal(colored(options, "#00ff00"), 48);
    assert_int_equal(colored("--faces name:grip --tile straight --count 4,1", "#595959"), 0);
    char *name = strrchr(plain, '/') + 1, text[2 * PATH_BYTES];
    snprintf(text, sizeof text,
             "{\"format\": 1, \"kind\": \"tile\", \"name\": \"red\", \"parts\": [{\"name\": \"a\", \"file\": \"%s\", "
             "\"material\": {\"color\": [1, 0, 0]}}]}",
             name);
    write_text(red, text);
    snprintf(options, sizeof options, "--faces name:grip --tile '%s' --count 4,1", red);
    assert_int_equal(colored(options, "#ff0000"), 4);
    remove(plain), remove(red);
}

// A circle needs weights, which a tile cannot have.
static void weights_are_no_tile(void **state)
{
    (void)state;
    char path[PATH_BYTES];
    make(path, "drilled.step", KN_OCCT_DRILLED);
    assert_int_equal(run("apply data/teapot.bpt --tile '%s' --count 2,2 --dry-run", path), 3);
    assert_one_line_about(path);
    assert_said("(cylinder) has weights");
    assert_int_equal(run("apply data/teapot.bpt --tile '%s.step' --count 2,2 --dry-run", path), 3);
    assert_said("cannot open");
    remove(path);
}

// ---- files of other programs ----

static void other_programs(void **state)
{
    (void)state;
    static const struct {
        const char *path;
        size_t bodies, faces;
    } files[] = {{"../shared/data/as1-oc-214.stp", 5, 53},
                 {"../shared/data/splinecage.stp", 4, 4},
                 {"../shared/data/surf114.igs", 1, 4}};
    int present = 0;
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        if (access(files[i].path, R_OK) != 0) continue;
        present++;
        assert_int_equal(run("info '%s'", files[i].path), 0); // as JSON one of them is longer than what is kept
        const char *counts = strchr(printed, '\n');
        assert_non_null(counts);
        size_t bodies = 0, faces = 0;
        assert_int_equal(sscanf(counts, " %zu bod%*[^,], %zu face", &bodies, &faces), 2);
        assert_int_equal(bodies, files[i].bodies);
        assert_int_equal(faces, files[i].faces);
    }
    if (present > 0) return;
    print_message("../shared/data is not here: skipped\n");
    skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_in_a_file),   cmocka_unit_test(names_in_iges),
        cmocka_unit_test(a_face_is_to_blame),  cmocka_unit_test(three_formats),
        cmocka_unit_test(faces_are_chosen),    cmocka_unit_test(faces_are_not_there),
        cmocka_unit_test(broken_files),        cmocka_unit_test(no_reader),
        cmocka_unit_test(compressed_files),    cmocka_unit_test(a_box_is_a_tile),
        cmocka_unit_test(weights_are_no_tile), cmocka_unit_test(faces_keep_their_colors),
        cmocka_unit_test(other_programs),
    };
    return cmocka_run_group_tests_name("cli/cad", tests, NULL, NULL);
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
    return cmocka_run_group_tests_name("cli/cad", tests, NULL, NULL);
}
#endif
