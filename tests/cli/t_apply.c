// SPDX-License-Identifier: Apache-2.0
// Options of apply for the shell and its cells: what they change, what they refuse, and the same in a recipe.
#include "tests/cli/command.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static json_t *get(const json_t *o, const char *key)
{
    json_t *value = json_object_get(o, key);
    assert_non_null(value);
    return value;
}

static double number(const json_t *o, const char *key)
{
    assert_true(json_is_number(get(o, key)));
    return json_number_value(get(o, key));
}

static const char square[] = "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n6 0 0\n0 6 0\n6 6 0\n";

static void make_square(char path[PATH_BYTES])
{
    test_tmp_path(path, "square.g2");
    write_text(path, square);
}

// The report of a job that is planned only.
static json_t *plan(const char *base, const char *options)
{
    assert_int_equal(run("apply '%s' --tile bump --dry-run --json %s", base, options), 0);
    return printed_json();
}

// The largest z of a job's mesh: STL has one float in a line of twelve for each triangle.
static void z_range(const char *base, const char *options, float range[2])
{
    char out[PATH_BYTES];
    test_tmp_path(out, "z.stl");
    assert_int_equal(run("apply '%s' --tile bump -q -o '%s' %s", base, out, options), 0);
    size_t bytes;
    char *file = test_read_file(out, &bytes);
    assert_non_null(file);
    range[0] = 1e30F, range[1] = -1e30F;
    for (size_t at = 84; at + 50 <= bytes; at += 50)
        for (size_t corner = 0; corner < 3; corner++) {
            float z;
            memcpy(&z, file + at + 12 + 12 * corner + 8, sizeof z);
            range[0] = z < range[0] ? z : range[0];
            range[1] = z > range[1] ? z : range[1];
        }
    free(file);
}

static void lengths_have_units(void **state)
{
    (void)state;
    char base[PATH_BYTES];
    make_square(base);
    json_t *r = plan(base, "--size 20mm --unit cm --height 1mm");
    assert_int_equal(number(r, "cells"), 9); // 6 cm by 2 cm, each way
    assert_true(fabs(number(r, "height") - 0.1) < 1e-9);
    json_decref(r);
    r = plan(base, "--height 0.1cm --size 2,30mm --unit cm"); // in any order
    assert_int_equal(number(r, "cells"), 6);
    assert_true(fabs(number(r, "height") - 0.1) < 1e-9);
    json_decref(r);
    assert_int_equal(run("apply '%s' --tile bump --dry-run --size 3km", base), 2);
    assert_non_null(strstr(complained, "such as 3 or 3mm"));
    assert_int_equal(run("apply '%s' --tile bump --dry-run --size 3mm,", base), 2);
    assert_int_equal(run("apply '%s' --tile bump --dry-run --size -3mm", base), 2);
    assert_int_equal(run("apply '%s' --tile bump --dry-run --height 0mm", base), 2);
}

static void both_normals(void **state)
{
    (void)state;
    char base[PATH_BYTES];
    make_square(base);
    json_t *r = plan(base, "--count 1");
    assert_string_equal(json_string_value(get(get(r, "normal"), "method")), "fitted");
    json_decref(r);
    r = plan(base, "--count 1 --normal exact-direction");
    assert_string_equal(json_string_value(get(get(r, "normal"), "method")), "exact-direction");
    assert_true(json_is_true(get(get(r, "normal"), "certified")));
    json_decref(r);
    assert_int_equal(run("apply '%s' --tile bump --dry-run --normal exact", base), 2);
}

// A bump from 0 to 1 on the plane z = 0: its heights are known. Float32 rounds 1 to itself.
static void sides_and_fields(void **state)
{
    (void)state;
    char base[PATH_BYTES];
    float z[2];
    make_square(base);
    z_range(base, "--count 1 --height 1", z);
    assert_true(z[0] == 0 && z[1] > 0.9F && z[1] < 1.0001F);
    float top = z[1];
    z_range(base, "--count 1 --height 1 --side below", z);
    assert_true(z[1] == 0 && fabsf(z[0] + top) < 1e-5F);
    z_range(base, "--count 1 --height 1 --side both", z);
    assert_true(fabsf(z[0] + 1) < 1e-5F && fabsf(z[1] - (2 * top - 1)) < 1e-5F);
    z_range(base, "--count 1 --height 1 --thickness 0.5", z);
    assert_true(fabsf(z[1] - 0.5F * top) < 1e-5F);
    z_range(base, "--count 1 --height 1 --direction 1,0,3", z);
    assert_true(fabsf(z[1] - 3 * top) < 1e-5F);
    // z = w - w^2 / 4 is increasing up to w = 2.
    z_range(base, "--count 1 --height 1 --attraction 0,0,-0.25", z);
    assert_true(fabsf(z[1] - (top - 0.25F * top * top)) < 1e-5F);
    z_range(base, "--count 1 --height 1 --attraction 0,0,-0.25 --attraction-power 3", z);
    assert_true(fabsf(z[1] - (top - 0.25F * top * top * top)) < 1e-5F);
}

static void fields_that_do_not_fit(void **state)
{
    (void)state;
    char base[PATH_BYTES], path[PATH_BYTES];
    make_square(base);
    test_tmp_path(path, "field.g2");
    assert_int_equal(run("apply '%s' --tile bump --dry-run --direction 1,2", base), 2);
    assert_int_equal(run("apply '%s' --tile bump --dry-run --thickness 1,2", base), 2);
    assert_int_equal(run("apply '%s' --tile bump --dry-run --thickness '%s'", base, path), 3); // no such file
    write_text(path, "200 1 0 0\n1 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n1\n1\n1\n1\n");
    assert_int_equal(run("apply '%s' --tile bump --dry-run --count 1 --thickness '%s'", base, path), 0);
    assert_int_equal(run("apply '%s' --tile bump --dry-run --count 1 --direction '%s'", base, path), 3);
    assert_non_null(strstr(complained, "3 components"));
    assert_int_equal(run("apply '%s' --tile bump --dry-run --count 1 --thickness -1", base), 2);
    assert_int_equal(run("apply '%s' --tile bump --dry-run --direction 0,0,0", base), 2);
    assert_int_equal(run("apply '%s' --tile bump --dry-run --direction 0,0,1 --normal fitted", base), 2);
    assert_int_equal(run("apply '%s' --tile bump --dry-run --attraction-power 3", base), 2);
    assert_int_equal(run("apply '%s' --tile bump --dry-run --attraction-power 0", base), 2);
}

// A rectangle twice as long at its end as at its beginning: even lines make areas alike where uniform ones do not.
static void cells_are_reported(void **state)
{
    (void)state;
    char base[PATH_BYTES];
    test_tmp_path(base, "stretched.g2"); // x = 2 u + 4 u^2
    write_text(base, "200 1 0 0\n3 0\n3 3\n0 0 0 1 1 1\n2 2\n0 0 1 1\n0 0 0\n1 0 0\n6 0 0\n0 6 0\n1 6 0\n6 6 0\n");
    double most[2];
    for (int even = 0; even < 2; even++) {
        json_t *r = plan(base, even ? "--count 6 --spacing even" : "--count 6 --spacing uniform");
        json_t *width = get(get(r, "spread"), "width");
        most[even] = number(width, "max") / number(width, "min");
        assert_int_equal(json_array_size(get(width, "histogram")), 24);
        json_decref(r);
    }
    // Widths between u and u + 1/6: 2/6 + 4 (2 u + 1/6) / 6, from 4/9 to 14/9.
    assert_true(fabs(most[0] - 3.5) < 1e-4); // six digits are printed
    assert_true(fabs(most[1] - 1) < 1e-4);
    assert_int_equal(run("apply '%s' --tile bump --dry-run --spacing evn", base), 2);
    // Heights that follow the stretch change from cell to cell: a tile over a line between cells crosses knots there.
    static const char *const ways[] = {"trim", "approximate", "refuse"};
    for (int k = 0; k < 3; k++)
        assert_int_equal(run("apply '%s' --tile fish --count 3,2 --shift 0.3 --stretch --max-degree 40 --dry-run -q "
                             "--crossing %s",
                             base, ways[k]),
                         k < 2 ? 0 : 3);
    assert_non_null(strstr(complained, "--crossing trim"));
}

static void the_same_in_a_recipe(void **state)
{
    (void)state;
    char base[PATH_BYTES], path[PATH_BYTES], text[2048];
    make_square(base);
    test_tmp_path(path, "shell.json");
    const char *name = strrchr(base, '/') + 1;
    snprintf(
        text, sizeof text,
        "{\"format\":1,\"base\":\"%s\",\"unit\":\"cm\",\"normal\":\"exact-direction\",\"tol\":\"1mm\","
        "\"layers\":[{\"tile\":\"bump\",\"size\":\"20mm\",\"height\":\"1mm\",\"side\":\"both\",\"thickness\":2,"
        "\"attraction\":[0,0,-0.1],\"attraction_power\":2,\"spacing\":\"even\",\"stretch\":false,\"rows\":false}]}",
        name);
    write_text(path, text);
    assert_int_equal(run("apply '%s' --dry-run --json", path), 0);
    json_t *r = printed_json();
    assert_int_equal(number(r, "cells"), 9);
    assert_string_equal(json_string_value(get(get(r, "normal"), "method")), "exact-direction");
    json_decref(r);
    static const char *const wrong[] = {
        "\"size\":\"3km\"",         "\"side\":\"left\"",    "\"side\":1",        "\"thickness\":\"x\"",
        "\"direction\":[1,2]",      "\"direction\":\"up\"", "\"attraction\":[]", "\"attraction_power\":0",
        "\"attraction_power\":1.5", "\"spacing\":true",     "\"rows\":1",        "\"stretch\":\"yes\"",
        "\"height\":\"0mm\"",
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        snprintf(text, sizeof text, "{\"format\":1,\"base\":\"%s\",\"layers\":[{\"tile\":\"bump\",%s}]}", name,
                 wrong[i]);
        write_text(path, text);
        assert_int_equal(run("apply '%s' --dry-run", path), 3);
        assert_non_null(strstr(complained, "shell.json"));
    }
}

static double fit_number(const char *key)
{
    json_t *r = printed_json();
    double x = json_number_value(get(get(r, "fit"), key));
    json_decref(r);
    return x;
}

// CAD files get faces within the degree and the tolerance, meshes what is composed; what composes to more than 25 is
// limited and not refused. Merging leaves fewer faces.
static void limits_of_cad_files(void **state)
{
    (void)state;
    char step[PATH_BYTES], stl[PATH_BYTES], step2[PATH_BYTES];
    test_tmp_path(step, "limits.step"), test_tmp_path(stl, "limits.stl"), test_tmp_path(step2, "limits2.step");
    static const char job[] =
        "apply data/teapot.bpt --faces 0 --tile bump --count 2 --height 0.1 --normal-tol 1e-2 -q";
    assert_int_equal(run("%s --json -o '%s'", job, step), 0);
    assert_true(fit_number("max_degree") == 25 && fit_number("limited_faces") == 0 &&
                fit_number("exact_faces") == 36);
    assert_int_equal(run("%s --json --max-degree cubic --tol 0.1mm -o '%s' -o '%s'", job, step, stl), 0);
    assert_true(fit_number("max_degree") == 3 && fit_number("limited_faces") == 36 && fit_number("exact_faces") == 0);
    assert_true(fit_number("tolerance") == 0.1 && fit_number("certified_error") > 0);
    assert_true(fit_number("certified_error") <= 0.1 && fit_number("seam_angle_rad") > 0);
    assert_true(fit_number("seam_angle_rad") <= fit_number("seam_angle_asked_rad") && fit_number("wide_angles") == 0);
    assert_true(fabs(fit_number("seam_angle_asked_rad") - 0.0174532925) < 1e-6); // one degree; six digits
    double points = fit_number("control_points");
    assert_int_equal(run("%s --json --max-degree cubic --tol 0.1mm --seam-angle 0.1 -o '%s'", job, step), 0);
    assert_true(fit_number("seam_angle_rad") <= 0.00174534 && fit_number("control_points") > points);
    assert_true(fabs(fit_number("seam_angle_asked_rad") - 0.00174532925) < 1e-7);
    assert_int_equal(run("%s --json --max-degree cubic --tol 0.1mm --dry-run -o '%s'", job, step2), 0);
    assert_true(fit_number("limited_faces") == 36 && fabs(fit_number("control_points") - points) <= 0.5 * points);
    assert_false(exists(step2));
    assert_int_equal(run("%s --json --max-degree 11 --unit cm --merge -o '%s'", job, step), 0);
    assert_true(fit_number("tolerance") == 0.001); // 0.01 mm
    json_t *r = printed_json();
    assert_true(json_integer_value(get(get(get(r, "fit"), "merge"), "faces")) < 36);
    json_decref(r);
    // The exact direction of a normal needs more than degree 25, where u and v run along both variables.
    assert_int_equal(run("%s --json --tile scale --normal exact-direction -o '%s'", job, step), 0);
    assert_true(fit_number("max_degree") == 25 && fit_number("limited_faces") > 0);
    r = printed_json();
    assert_true(json_integer_value(json_array_get(get(r, "degree"), 0)) > 25);
    json_decref(r);
    assert_int_equal(run("%s --max-degree 2 -o '%s'", job, step), 2);
    assert_non_null(strstr(complained, "from 3 to 56"));
    static const char *const bad[] = {"0", "-1", "nan", "inf", "46", "0.001", "x", ""};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_equal(run("%s --seam-angle '%s' -o '%s'", job, bad[i], step), 2);
        assert_non_null(strstr(complained, "--seam-angle: expected"));
    }
    assert_int_equal(run("%s --merge --resume -o '%s'", job, step), 2);
    remove(step), remove(stl);
}

// What an option says that means nothing here.
static void idle_options(void **state)
{
    (void)state;
    static const struct {
        const char *option, *ending, *said; // NULL: nothing
    } cases[] = {{"", "stl", NULL},
                 {"--step ap242", "stl", "--step: no STEP file is written"},
                 {"--instances", "igs", "--instances: no STEP file is written"},
                 {"--max-degree vda", "g2", "--max-degree: no CAD file is written"},
                 {"--max-degree vda --tol 0.1 --seam-angle 2 --merge", "igs", NULL},
                 {"--max-degree exact", "g2", NULL}, // of what is composed, too
                 {"--seam-angle 2", "stl", "--seam-angle: no CAD file is written"},
                 {"--merge", "stl", "--merge: no CAD file is written"},
                 {"--tol 0.1", "stl", NULL},
                 {"--tol 0.1", "obj", NULL},
                 {"--tol 0.1 --obj-surfaces", "obj", "--tol: neither a CAD file nor triangles are written"},
                 {"--tol 0.1", "g2", "--tol: neither a CAD file nor triangles are written"},
                 {"--max-degree vda --tol 0.1 --seam-angle 2 --merge --dry-run", "igs", NULL},
                 {"--join-angle 10", "stl", "--join-angle: "},
                 {"--trimmed clip", "stl", "--trimmed: "}};
    char base[PATH_BYTES], out[PATH_BYTES], name[16];
    make_square(base);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        snprintf(name, sizeof name, "idle.%s", cases[i].ending);
        test_tmp_path(out, name);
        assert_int_equal(run("apply '%s' --tile straight --count 2,2 %s -o '%s'", base, cases[i].option, out), 0);
        if (cases[i].said && !strstr(complained, cases[i].said)) fail_msg("%s: %s", cases[i].option, complained);
        if (!cases[i].said && strstr(complained, "--")) fail_msg("%s: %s", cases[i].option, complained);
        remove(out);
    }
    remove(base);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lengths_have_units),   cmocka_unit_test(both_normals),
        cmocka_unit_test(sides_and_fields),     cmocka_unit_test(fields_that_do_not_fit),
        cmocka_unit_test(limits_of_cad_files),  cmocka_unit_test(cells_are_reported),
        cmocka_unit_test(the_same_in_a_recipe), cmocka_unit_test(idle_options),
    };
    return cmocka_run_group_tests_name("cli/apply", tests, NULL, NULL);
}
