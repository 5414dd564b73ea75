// SPDX-License-Identifier: Apache-2.0
// knurl convert: from one kind of file to others and back, what is refused, and exit codes.
#include "tests/cli/command.h"

#include <knurl/knurl.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#if KN_WITH_OCCT
#include "bridges/occt/occt_check.h"
#endif

static const char teapot[] = "data/teapot.bpt";

// .g2 to .itd and back is the same text: every number is the same double.
static void there_and_back(void **state)
{
    (void)state;
    char g2[PATH_BYTES], itd[PATH_BYTES], again[PATH_BYTES];
    size_t n, m;
    test_tmp_path(g2, "pot.g2"), test_tmp_path(itd, "pot.itd"), test_tmp_path(again, "again.g2");
    assert_int_equal(run("convert %s -o %s -o %s -q", teapot, g2, itd), 0);
    assert_string_equal(printed, "");
    assert_int_equal(run("convert %s -o %s --json", itd, again), 0);
    json_t *o = printed_json();
    assert_int_equal(json_integer_value(json_object_get(o, "splines")), 32);
    assert_int_equal(json_integer_value(json_object_get(o, "left_out")), 0);
    const json_t *file = json_array_get(json_object_get(o, "outputs"), 0);
    char *a = test_read_file(g2, &n), *b = test_read_file(again, &m);
    assert_int_equal(json_integer_value(json_object_get(file, "bytes")), m);
    json_decref(o);
    assert_int_equal(n, m);
    assert_memory_equal(a, b, n);
    free(a), free(b);
    remove(g2), remove(itd), remove(again);
}

#if KN_WITH_OCCT
static kn_occt_report look(const char *path)
{
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_occt_model *model = NULL;
    kn_occt_report report;
    if (kn_occt_open_step(ctx, &model, path) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    assert_int_equal(kn_occt_check(ctx, &report, model), KN_OK);
    kn_occt_close(ctx, model);
    test_ctx_end(ctx, &memory);
    return report;
}
#endif

// A surface of degrees 3, 1 with a kink becomes two faces; one of degree 5 is limited to 3.
static void to_step(void **state)
{
    (void)state;
    char g2[PATH_BYTES], step[PATH_BYTES];
    test_tmp_path(g2, "in.g2"), test_tmp_path(step, "out.step");
    write_text(g2,
               "200 1 0 0\n3 0\n7 4\n0 0 0 0 1 1 1 2 2 2 2\n2 2\n0 0 1 1\n"
               "0 0 0\n1 0 1\n2 0 1\n3 0 0\n4 0 2\n5 0 2\n6 0 0\n0 9 0\n1 9 1\n2 9 1\n3 9 0\n4 9 2\n5 9 2\n6 9 0\n"
               "200 1 0 0\n3 0\n6 6\n0 0 0 0 0 0 1 1 1 1 1 1\n2 2\n0 0 1 1\n"
               "0 20 0\n1 20 1\n2 20 0\n3 20 2\n4 20 0\n5 20 0\n0 29 0\n1 29 1\n2 29 0\n3 29 2\n4 29 0\n5 29 0\n");
    assert_int_equal(run("convert %s -o %s --unit cm --json", g2, step), 0);
    json_t *o = printed_json();
    assert_true(json_is_null(json_object_get(json_array_get(json_object_get(o, "outputs"), 0), "fit")));
    json_decref(o);
#if KN_WITH_OCCT
    kn_occt_report r = look(step);
    assert_int_equal(r.faces, 3);
    assert_int_equal(r.valid_faces, 3);
    assert_int_equal(r.max_degree, 5);
    assert_true(r.hi[1] > 289 && r.hi[1] < 291); // cm in IN, mm in STEP
#endif
    assert_int_equal(run("convert %s -o %s --max-degree cubic --tol 0.001 --json", g2, step), 0);
    o = printed_json();
    const json_t *fit = json_object_get(json_array_get(json_object_get(o, "outputs"), 0), "fit");
    double error = json_real_value(json_object_get(fit, "certified_error"));
    assert_true(error > 0 && error <= 0.001);
    assert_int_equal(json_integer_value(json_object_get(fit, "limited")), 1);
    assert_int_equal(json_integer_value(json_object_get(fit, "exact")), 2);
    json_decref(o);
#if KN_WITH_OCCT
    r = look(step);
    assert_int_equal(r.faces, 3);
    assert_int_equal(r.valid_faces, 3);
    assert_int_equal(r.max_degree, 3);
#endif
    remove(g2), remove(step);
}

static void free_form_obj(void **state)
{
    (void)state;
    char obj[PATH_BYTES], text[TEXT_BYTES];
    test_tmp_path(obj, "pot.obj");
    assert_int_equal(run("convert %s -o %s --obj-surfaces", teapot, obj), 0);
    slurp(obj, text);
    assert_non_null(strstr(text, "cstype bspline\ndeg 3 3\nsurf 0 1 0 1 -16 -15"));
    assert_null(strstr(text, "\nf "));
    assert_int_equal(run("convert %s -o %s --tol 0.1", teapot, obj), 0);
    slurp(obj, text);
    assert_non_null(strstr(text, "\nf "));
    remove(obj);
}

// A name in Latin-1 goes into XML and JSON as a name in UTF-8.
static void names_of_files(void **state)
{
    (void)state;
    char from[PATH_BYTES], vtu[PATH_BYTES], glb[PATH_BYTES], text[TEXT_BYTES];
    test_tmp_path(from, "caf\xe9-x\xc3\xa4.bpt"), test_tmp_path(vtu, "name.vtu"), test_tmp_path(glb, "name.glb");
    slurp(teapot, text);
    write_text(from, text);
    assert_int_equal(run("convert %s -o %s -q", from, vtu), 0);
    slurp(vtu, text);
    assert_non_null(strstr(text, "_caf\xc3\xa9_x\xc3\xa4 -->"));
#if KN_WITH_TINYGLTF
    assert_int_equal(run("convert %s -o %s -q", from, glb), 0);
    size_t n;
    char *data = test_read_file(glb, &n);
    json_t *o = json_loadb(data + 20, n - 20, JSON_DISABLE_EOF_CHECK, NULL);
    assert_non_null(o);
    const json_t *material = json_array_get(json_object_get(o, "materials"), 0);
    assert_non_null(strstr(json_string_value(json_object_get(material, "name")), "-caf\xef\xbf\xbd-x\xc3\xa4"));
    json_decref(o), free(data);
    remove(glb);
#endif
    remove(from), remove(vtu);
}

#if KN_WITH_OCCT
static double highest_point(const char *stl)
{
    size_t bytes;
    unsigned char *data = (unsigned char *)test_read_file(stl, &bytes);
    double highest = -1e9;
    for (size_t t = 84; t + 50 <= bytes; t += 50)
        for (size_t k = 0; k < 3; k++) {
            float z;
            memcpy(&z, data + t + 12 + 12 * k + 8, sizeof z);
            highest = fmax(highest, (double)z);
        }
    free(data);
    return highest;
}

// A face of 30 spans one way and one arched span the other: triangles follow the arch, to the tolerance. Its height is
// 10 (3 x (1 - x)^2 + 3 x^2 (1 - x)) at x = 1/2, which no chord of height t is further below than t.
static void faces_as_triangles(void **state)
{
    (void)state;
    char g2[PATH_BYTES], step[PATH_BYTES], stl[PATH_BYTES], text[TEXT_BYTES];
    const double y[4] = {0, 0, 10, 10}, z[4] = {0, 10, 10, 0};
    size_t n = (size_t)snprintf(text, sizeof text, "200 1 0 0\n3 0\n33 4\n0 0 0");
    test_tmp_path(g2, "arch.g2"), test_tmp_path(step, "arch.step"), test_tmp_path(stl, "arch.stl");
    for (int i = 0; i <= 30; i++) n += (size_t)snprintf(text + n, sizeof text - n, " %d", i);
    n += (size_t)snprintf(text + n, sizeof text - n, " 30 30 30\n4 4\n0 0 0 0 1 1 1 1\n");
    for (int i = 0; i < 4 * 33; i++)
        n += (size_t)snprintf(text + n, sizeof text - n, "%d %g %g\n", i % 33, y[i / 33], z[i / 33]);
    write_text(g2, text);
    assert_int_equal(run("convert %s -o %s -q", g2, step), 0);
    assert_int_equal(run("convert %s -o %s -q --tol 0.2", step, stl), 0);
    double coarse = highest_point(stl);
    assert_int_equal(run("convert %s -o %s -q --tol 0.0005", step, stl), 0);
    double fine = highest_point(stl);
    assert_true(coarse >= 7.5 - 0.2 && coarse <= 7.5 + 1e-6); // single precision
    assert_true(fine >= 7.5 - 0.0005 && fine <= 7.5 + 1e-6);
    assert_true(fine > coarse);
    remove(g2), remove(step), remove(stl);
}

// A side of a triangle, its ends in order of their bytes.
typedef struct side {
    float end[2][3];
    int turn; // 1 or -1: which way it runs
} side;

static int compare_sides(const void *a, const void *b)
{
    return memcmp(((const side *)a)->end, ((const side *)b)->end, sizeof((const side *)a)->end);
}

static side *read_sides(const char *stl, size_t *n)
{
    size_t bytes;
    char *data = test_read_file(stl, &bytes);
    assert_true(data && bytes > 84);
    side *sides = calloc((bytes - 84) / 50 * 3, sizeof *sides);
    assert_non_null(sides);
    *n = 0;
    for (size_t t = 84; t + 50 <= bytes; t += 50) {
        float x[3][3];
        memcpy(x, data + t + 12, sizeof x);
        for (int k = 0; k < 9; k++) x[k / 3][k % 3] += 0.0F; // one zero
        for (int k = 0; k < 3; k++) {
            side *s = &sides[(*n)++];
            s->turn = memcmp(x[k], x[(k + 1) % 3], sizeof x[k]) < 0 ? 1 : -1;
            memcpy(s->end[s->turn < 0], x[k], sizeof x[k]);
            memcpy(s->end[s->turn > 0], x[(k + 1) % 3], sizeof x[k]);
        }
    }
    free(data);
    return sides;
}

static bool on_border(const side *s, float end)
{
    for (int c = 0; c < 2; c++)
        for (int k = 0; k < 2; k++)
            if (s->end[0][c] == (float)k * end && s->end[1][c] == (float)k * end) return true;
    return false;
}

// The faces of a texture have as many triangles as they bend, no more, and those of neighbours meet: every side of one
// is a side of another, turned round, but along the square's border.
static void triangles_meet(void **state)
{
    (void)state;
    char g2[PATH_BYTES], step[PATH_BYTES], stl[PATH_BYTES];
    test_tmp_path(g2, "flat.g2"), test_tmp_path(step, "thorns.step"), test_tmp_path(stl, "thorns.stl");
    write_text(g2, "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n8 0 0\n0 8 0\n8 8 0\n");
    assert_int_equal(run("apply %s --tile thorn --count 2,2 -q -o %s", g2, step), 0);
    assert_int_equal(run("convert %s -o %s -q", step, stl), 0);
    size_t n, open = 0, faces = 4 * 16;
    side *sides = read_sides(stl, &n);
    qsort(sides, n, sizeof *sides, compare_sides);
    for (size_t i = 0, j = 0; i < n; i = j) {
        int sum = 0;
        for (; j < n && compare_sides(&sides[i], &sides[j]) == 0; j++) sum += sides[j].turn;
        if (sum == 0) continue;
        open++;
        assert_true(j == i + 1 && on_border(&sides[i], 8.0F));
    }
    assert_true(open >= 4 * 2 && n / 3 < faces * 400); // 25 segments each way would be 1250
    free(sides);
    remove(g2), remove(step), remove(stl);
}
#endif

// One file by several names: before it is there, and, by what the system says of it, when it is.
static void one_file_twice(void **state)
{
    (void)state;
    char folder[PATH_BYTES], link_there[PATH_BYTES], path[PATH_BYTES + 8], other[PATH_BYTES + 8];
    test_tmp_path(folder, "folder"), test_tmp_path(link_there, "link");
    assert_int_equal(mkdir(folder, 0700), 0);
    assert_int_equal(symlink(folder, link_there), 0);
    const char *const commands[] = {"convert data/teapot.bpt",
                                    "apply data/teapot.bpt --tile straight --count 1,1 -n"};
    for (int there = 0; there < 2; there++) {
        snprintf(path, sizeof path, "%s/d.g2", folder);
        if (there) write_text(path, "");
        for (size_t c = 0; c < sizeof commands / sizeof *commands; c++) {
            assert_int_equal(run("%s -q -o '%s/d.g2' -o '%s/./d.g2'", commands[c], folder, folder), 2);
            assert_non_null(strstr(complained, "is given twice, once as"));
            assert_int_equal(run("%s -q -o '%s//d.g2' -o '%s/d.g2'", commands[c], folder, link_there), 2);
            const char *name = strrchr(folder, '/') + 1; // another way to it
            assert_int_equal(run("%s -q -o '%s/../%s/d.g2' -o '%s/d.g2'", commands[c], folder, name, folder), 2);
            assert_int_equal(run("%s -q -o d.g2 -o ./d.g2", commands[c]), 2);
            assert_non_null(strstr(complained, "once as 'd.g2'"));
        }
    }
    snprintf(other, sizeof other, "%s/e.g2", folder);
    assert_int_equal(link(path, other), 0);
    assert_int_equal(run("convert data/teapot.bpt -q -o '%s' -o '%s'", path, other), 2);
    remove(other);
    assert_int_equal(run("convert data/teapot.bpt -q -o '%s' -o '%s' -o '%s/d.itd'", path, other, folder), 0);
    assert_true(exists(path) && exists(other));
    remove(path), remove(other), remove(link_there);
    snprintf(path, sizeof path, "%s/d.itd", folder);
    remove(path);
    assert_int_equal(rmdir(folder), 0);
}

static void what_is_refused(void **state)
{
    (void)state;
    char g2[PATH_BYTES], out[PATH_BYTES];
    test_tmp_path(g2, "bad.g2"), test_tmp_path(out, "out.itd");
    assert_int_equal(run("convert"), 2);
    assert_int_equal(run("convert %s", teapot), 2);
    assert_int_equal(run("convert %s %s -o %s", teapot, teapot, out), 2);
    assert_int_equal(run("convert %s -o %s -o %s", teapot, out, out), 2);
    assert_non_null(strstr(complained, "is given twice"));
    assert_int_equal(run("convert %s -o out.foo", teapot), 2);
    assert_non_null(strstr(complained, "no writer for 'out.foo'"));
    assert_int_equal(run("convert %s -o %s --max-degree 2.5", teapot, out), 2);
    assert_int_equal(run("convert %s -o %s --tol 0", teapot, out), 2);
    assert_int_equal(run("convert %s -o %s --unit furlong", teapot, out), 2);
    assert_int_equal(run("convert nowhere.g2 -o %s", out), 3);
    assert_int_equal(run("convert nowhere.foo -o %s", out), 3);
    write_text(g2, "200 1 0 0\n3 0\n2 2\n0 0 1 x\n");
    assert_int_equal(run("convert %s -o %s", g2, out), 3);
    assert_non_null(strstr(complained, "bad.g2:4"));
    write_text(g2, "100 1 0 0\n1 0\n2 2\n0 0 1 1\n0\n1\n"); // nothing that lies in space
    assert_int_equal(run("convert %s -o %s", g2, out), 3);
    assert_false(exists(out));
    assert_int_equal(run("convert %s -o /nowhere/x.itd", teapot), 1);
    remove(g2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(there_and_back),
        cmocka_unit_test(to_step),
        cmocka_unit_test(free_form_obj),
        cmocka_unit_test(names_of_files),
#if KN_WITH_OCCT
        cmocka_unit_test(faces_as_triangles),
        cmocka_unit_test(triangles_meet),
#endif
        cmocka_unit_test(one_file_twice),
        cmocka_unit_test(what_is_refused),
    };
    return cmocka_run_group_tests_name("cli/convert", tests, NULL, NULL);
}
