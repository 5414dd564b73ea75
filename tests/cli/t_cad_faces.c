// SPDX-License-Identifier: Apache-2.0
// Faces of CAD files with borders and neighbours, at the command line: what --trimmed does at a hole, and --join-angle
// at an edge.
#include "tests/cli/command.h"

#if KN_WITH_OCCT
#include "bridges/occt/occt_probe.h"

#include <knurl/io.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const json_t *get(const json_t *o, const char *key)
{
    const json_t *value = json_object_get(o, key);
    assert_non_null(value);
    return value;
}

static int whole(const json_t *o, const char *key)
{
    assert_true(json_is_integer(get(o, key)));
    return (int)json_integer_value(get(o, key));
}

static double number(const json_t *o, const char *key)
{
    assert_true(json_is_number(get(o, key)));
    return json_number_value(get(o, key));
}

static int count(const char *path, const char *word)
{
    char *text = test_read_file(path, NULL);
    int n = 0;
    assert_non_null(text);
    for (const char *at = strstr(text, word); at; at = strstr(at + 1, word)) n++;
    free(text);
    return n;
}

// ---- triangles of a sheet over a plane ----

typedef struct sheet {
    char *file;
    size_t n; // triangles
    double area[3], size, normal[3], lowest, middle[3];
} sheet;

static void corner_of(double out[3], const sheet *s, size_t triangle, size_t corner)
{
    float x[3];
    memcpy(x, s->file + 84 + 50 * triangle + 12 * (corner + 1), sizeof x);
    for (int c = 0; c < 3; c++) out[c] = (double)x[c];
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Half of the cross product of two sides.
static void area_of(double out[3], double x[3][3], const sheet *s, size_t triangle)
{
    for (size_t k = 0; k < 3; k++) corner_of(x[k], s, triangle, k);
    for (int c = 0; c < 3; c++) {
        int p = (c + 1) % 3, q = (c + 2) % 3;
        out[c] = 0.5 * ((x[1][p] - x[0][p]) * (x[2][q] - x[0][q]) - (x[1][q] - x[0][q]) * (x[2][p] - x[0][p]));
    }
}

// The sum of the area vectors of a sheet is that of what it covers, whatever its heights are: each point of the plane
// is covered once, or once more upwards than downwards. middle: of what is covered.
static void read_sheet(sheet *s, const char *path)
{
    size_t bytes = 0;
    double x[3][3], a[3];
    *s = (sheet){.file = test_read_file(path, &bytes), .lowest = INFINITY};
    assert_true(s->file && bytes > 84);
    s->n = (bytes - 84) / 50;
    for (size_t t = 0; t < s->n; t++) {
        area_of(a, x, s, t);
        for (int c = 0; c < 3; c++) s->area[c] += a[c];
    }
    s->size = sqrt(dot(s->area, s->area));
    for (int c = 0; c < 3; c++) s->normal[c] = s->area[c] / s->size;
    for (size_t t = 0; t < s->n; t++) {
        area_of(a, x, s, t);
        double part = dot(a, s->normal) / s->size;
        for (int k = 0; k < 3; k++) {
            s->lowest = fmin(s->lowest, dot(x[k], s->normal));
            for (int c = 0; c < 3; c++) s->middle[c] += part * x[k][c] / 3.0;
        }
    }
}

// The largest height of corners at most `near` from the axis through the middle.
static double height_near(const sheet *s, double near)
{
    double most = 0.0;
    for (size_t t = 0; t < s->n; t++)
        for (size_t k = 0; k < 3; k++) {
            double x[3], d[3];
            corner_of(x, s, t, k);
            for (int c = 0; c < 3; c++) d[c] = x[c] - s->middle[c];
            double h = dot(d, s->normal), r = sqrt(fmax(dot(d, d) - h * h, 0.0));
            if (r <= near) most = fmax(most, dot(x, s->normal) - s->lowest);
        }
    return most;
}

// ---- a hole ----

enum { ROWS = 24, COLUMNS = 48, PATCHES = 3 }; // of the tile `straight`, whose ridge goes through its cell's middle
static const double side[2] = {10, 20}, radius = 3, height = 0.5, pi = 3.14159265358979323846;

typedef struct hole {
    int cells, dropped, faces, trimmed; // faces in the STEP file; trimmed surfaces in the .g2 file
    double error, area, at_border;
} hole;

static hole cover(const char *base, const char *trimmed)
{
    char step[PATH_BYTES], g2[PATH_BYTES], stl[PATH_BYTES];
    test_tmp_path(step, "hole.step"), test_tmp_path(g2, "hole.g2"), test_tmp_path(stl, "hole.stl");
    int code = run("apply '%s' --faces 2 --tile straight --count %d,%d --height %g %s --body none --json -q -o '%s' "
                   "-o '%s' -o '%s'",
                   base, ROWS, COLUMNS, height, trimmed, step, g2, stl);
    if (code != 0) fail_msg("%s: %s", trimmed, complained);
    json_t *root = printed_json();
    hole h = {.cells = whole(root, "cells"), .error = number(root, "crossing_error")};
    h.dropped = whole(get(root, "cells_dropped"), "trim");
    h.faces = count(step, "ADVANCED_FACE("), h.trimmed = count(g2, "210 1 0 ");
    json_decref(root);
    sheet s;
    read_sheet(&s, stl);
    h.area = s.size;
    h.at_border = height_near(&s, radius + 0.01);
    free(s.file);
    remove(step), remove(g2), remove(stl);
    return h;
}

// Cells of the lattice around the hole's middle that lie within its circle, and those that it touches.
static void count_cells(int *within, int *touched)
{
    *within = *touched = 0;
    for (int i = 0; i < ROWS; i++)
        for (int j = 0; j < COLUMNS; j++) {
            double lo = 0.0, hi = 0.0;
            for (int d = 0; d < 2; d++) {
                double n = d == 0 ? ROWS : COLUMNS, w = side[d] / n;
                double a = fabs(((d == 0 ? i : j) + 0.5 - n / 2) * w);
                lo += a > w / 2 ? (a - w / 2) * (a - w / 2) : 0.0, hi += (a + w / 2) * (a + w / 2);
            }
            *within += hi < radius * radius;
            *touched += lo < radius * radius && hi >= radius * radius;
        }
}

static void make_drilled(char path[PATH_BYTES])
{
    kn_ctx *ctx = NULL;
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK);
    test_tmp_path(path, "drilled.step");
    if (kn_occt_make(ctx, KN_OCCT_DRILLED, path) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    kn_ctx_destroy(ctx);
}

// A face of 10 x 20 with a hole of radius 3 in its middle. Areas: of what stays whole, exactly but for the floats of the
// file; of what is cut, within the distance that is told, and the 1e-5 mm that the file's circle is read within, along
// the circle. A sheet's chords do not matter: its border is what is measured.
static void a_hole(void **state)
{
    (void)state;
    char base[PATH_BYTES];
    int within, touched;
    make_drilled(base);
    count_cells(&within, &touched);
    const double cell = side[0] / ROWS * side[1] / COLUMNS, face = side[0] * side[1] - pi * radius * radius;
    const hole usual = cover(base, ""), keep = cover(base, "--trimmed keep"), clip = cover(base, "--trimmed clip"),
               taper = cover(base, "--trimmed taper --taper 1.5");
    // Whether the circle touches a cell is decided by boxes: cells near it stay.
    assert_true(keep.dropped <= within && keep.dropped > 0);
    assert_int_equal(keep.cells, ROWS * COLUMNS - keep.dropped);
    assert_int_equal(keep.faces, PATCHES * keep.cells);
    assert_int_equal(keep.trimmed, 0);
    assert_true(keep.error == 0.0);
    assert_true(fabs(keep.area - keep.cells * cell) <= 1e-4); // 25,000 triangles of floats of up to 64
    assert_true(memcmp(&usual, &keep, sizeof keep) == 0);     // what a single face has without the option
    assert_true(keep.at_border > 0.9 * height);
    // Between one and two patches of each cell on the circle are cut, or left out.
    assert_int_equal(clip.dropped, keep.dropped);
    assert_true(clip.trimmed >= touched && clip.trimmed <= PATCHES * touched);
    assert_true(clip.faces <= keep.faces + touched && clip.faces > keep.faces - PATCHES * touched);
    assert_true(clip.error > 0.0 && clip.error <= 1e-3 * 0.5); // --crossing-tol: a thousandth of a cell
    assert_true(fabs(clip.area - face) <= 2 * pi * radius * (clip.error + 1e-5) + 1e-4);
    assert_true(clip.at_border > 0.9 * height);
    // The same pieces, without height there.
    assert_int_equal(taper.trimmed, clip.trimmed);
    assert_int_equal(taper.faces, clip.faces);
    assert_true(fabs(taper.area - face) <= 2 * pi * radius * (taper.error + 1e-5) + 1e-4);
    assert_true(taper.at_border <= 1e-5); // floats
    remove(base);
}

// The same for a mesh, a roof over each cell: its triangles are cut along the circle, in all formats that have triangles.
static void a_hole_in_meshes(void **state)
{
    (void)state;
    static const char roof[] =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.4 0.6 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
    char base[PATH_BYTES], tile[PATH_BYTES], stl[PATH_BYTES], glb[PATH_BYTES], obj[PATH_BYTES];
    make_drilled(base);
    test_tmp_path(tile, "roof.obj"), test_tmp_path(stl, "hole.stl"), test_tmp_path(glb, "hole.glb");
    test_tmp_path(obj, "hole.obj");
    test_write_file(tile, roof, sizeof roof - 1);
    const double face = side[0] * side[1] - pi * radius * radius;
    const char *const ways[2] = {"keep", "clip"};
    sheet s;
    for (int k = 0; k < 2; k++) {
        int code = run(
            "apply '%s' --faces 2 --tile '%s' --count %d,%d --height %g --trimmed %s --body none --json -q -o "
            "'%s' -o '%s' -o '%s'",
            base, tile, ROWS, COLUMNS, height, ways[k], stl, glb, obj);
        if (code != 0) fail_msg("%s: %s", ways[k], complained);
        json_t *root = printed_json();
        double error = number(root, "crossing_error"), cells = whole(root, "cells");
        json_decref(root);
        read_sheet(&s, stl);
        if (k == 0) assert_true(error == 0.0 && (size_t)(4 * cells) == s.n);
        if (k == 1) assert_true(error > 0.0 && error <= 1e-3 * 0.5);
        if (k == 1) assert_true(fabs(s.size - face) <= 2 * pi * radius * (error + 1e-5) + 1e-4);
        // STL leaves out triangles that floats make a line
        assert_true((size_t)count(obj, "\nf ") >= s.n && (size_t)count(obj, "\nf ") <= s.n + s.n / 200);
        assert_true(height_near(&s, radius + 0.2) > 0.3 * height);
        free(s.file);
        remove(stl), remove(glb), remove(obj);
    }
    remove(base), remove(tile);
}

// ---- an edge ----

// Two squares of side 10 that meet along x = 10, the second one so many degrees up. Between its dimples that tile is at its
// full height.
static void make_roof(char path[PATH_BYTES], double degrees)
{
    char g2[PATH_BYTES], text[1024];
    const double c = 10 * cos(pi / 180 * degrees), s = 10 * sin(pi / 180 * degrees);
    static const char head[] = "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n";
    test_tmp_path(g2, "roof.g2"), test_tmp_path(path, "roof.step");
    snprintf(text, sizeof text,
             "%s0 0 0\n10 0 0\n0 10 0\n10 10 0\n%s10 0 0\n%.17g 0 %.17g\n10 10 0\n%.17g 10 %.17g\n", head, head,
             10 + c, s, 10 + c, s);
    write_text(g2, text);
    assert_int_equal(run("convert '%s' -q -o '%s'", g2, path), 0);
    remove(g2);
}

// The largest height over the first square, of patches' corners this near to x = 10: what is over the edge moves there
// by the sine of the angle between the normals, of 0.5 at most.
static double height_at_edge(const char *path, double near)
{
    kn_ctx *ctx = NULL;
    kn_model model = {0};
    double most = 0.0;
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK);
    assert_int_equal(kn_read_model(ctx, &model, path), KN_OK);
    for (int i = 0; i < model.nsplines; i++) {
        const kn_spline *s = &model.splines[i];
        size_t n = kn_spline_count(s), u = (size_t)s->count[0], v = (size_t)s->count[1];
        const size_t corner[4] = {0, v - 1, (u - 1) * v, u * v - 1};
        for (int k = 0; k < 4; k++)
            if (fabs(s->coef[corner[k]] - 10) <= near) most = fmax(most, s->coef[2 * n + corner[k]]);
    }
    kn_model_clear(ctx, &model);
    kn_ctx_destroy(ctx);
    return most;
}

static void an_edge(void **state)
{
    (void)state;
    static const struct {
        double degrees;
        const char *options, *why; // NULL: joined
        bool high;                 // there are heights along the edge
        int shells;                // 0: one, or one for each square; joined faces with a crease open there
    } cases[] = {{0, "", NULL, true, 1},
                 {0, "--no-join", "not wanted", true, 1},
                 {10, "", "angle", false, 1},
                 {10, "--join-angle 9.9", "angle", false, 1},
                 {10, "--join-angle 10.1", NULL, true, 0},
                 {10, "--join-angle 180", NULL, true, 0},
                 {10, "--join-angle 10.1 --no-join", "not wanted", false, 1},
                 {10, "--no-join --trimmed keep", "not wanted", true, 2}};
    char base[PATH_BYTES], g2[PATH_BYTES], step[PATH_BYTES];
    test_tmp_path(g2, "joined.g2"), test_tmp_path(step, "joined.step");
    for (int i = 0; i < test_cases((int)(sizeof cases / sizeof *cases)); i++) {
        make_roof(base, cases[i].degrees);
        int code = run("apply '%s' --tile dimples --count 4,4 --height 0.5 --body none %s --json -q "
                       "-o '%s' -o '%s'",
                       base, cases[i].options, g2, step);
        if (code != 0) fail_msg("%s: %s", cases[i].options, complained);
        json_t *root = printed_json();
        const json_t *edges = get(root, "edges"), *edge = json_array_get(edges, 0), *why = get(edge, "why");
        assert_int_equal(json_array_size(edges), 1);
        assert_int_equal(json_integer_value(json_array_get(get(edge, "faces"), 0)), 0);
        assert_int_equal(json_integer_value(json_array_get(get(edge, "faces"), 1)), 1);
        assert_int_equal(json_is_true(get(edge, "joined")), cases[i].why == NULL);
        if (cases[i].why) assert_string_equal(json_string_value(why), cases[i].why);
        if (!cases[i].why) assert_true(json_is_null(why));
        assert_true(fabs(number(edge, "angle_deg") - cases[i].degrees) < 1e-4); // printed with six digits
        assert_true(number(edge, "moved_mm") >= 0.0 && number(edge, "moved_mm") <= 1e-12);
        json_decref(root);
        int shells = count(step, "OPEN_SHELL(");
        if (cases[i].shells > 0 && shells != cases[i].shells) fail_msg("%s: %d shells", cases[i].options, shells);
        double most = height_at_edge(g2, cases[i].high ? 0.5 * sin(pi / 18) + 1e-9 : 1e-9);
        if (cases[i].high ? most < 0.2 : most > 1e-9) fail_msg("%s: %g", cases[i].options, most);
    }
    assert_int_equal(run("apply '%s' --tile straight --count 4,4 --join-angle 0 -n", base), 2);
    assert_non_null(strstr(complained, "--join-angle: expected degrees above 0 and up to 180"));
    remove(base), remove(g2), remove(step);
}

// ---- the body beside ----

// IGES holds the texture alone, and that is said; not where nobody wants the body.
static void iges_beside(void **state)
{
    (void)state;
    static const struct {
        const char *options, *file;
        bool said;
    } cases[] = {{"", "beside.igs", true}, {"--body none", "beside.igs", false}, {"", "beside.step", false}};
    for (int i = 0; i < test_cases((int)(sizeof cases / sizeof *cases)); i++) {
        char out[PATH_BYTES];
        test_tmp_path(out, cases[i].file);
        assert_int_equal(
            run("apply examples/cad/knob.step --faces name:grip --tile straight --count 4,1 --taper 3 %s "
                "-o '%s'",
                cases[i].options, out),
            0);
        bool said = strstr(complained, "the texture alone: bodies (--body) go out in STEP") != NULL;
        assert_int_equal(said, cases[i].said);
        remove(out);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_hole), cmocka_unit_test(a_hole_in_meshes),
                                       cmocka_unit_test(an_edge), cmocka_unit_test(iges_beside)};
    return cmocka_run_group_tests_name("cli/cad_faces", tests, NULL, NULL);
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
    return cmocka_run_group_tests_name("cli/cad_faces", tests, NULL, NULL);
}
#endif
