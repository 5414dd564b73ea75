// SPDX-License-Identifier: Apache-2.0
// knurl info: creases, poles and apexes of surfaces, volumes, and surfaces that have no normal.
#include "tests/cli/command.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include <knurl/knurl.h>

static const double origin[3] = {0, 0, 0}, z_axis[3] = {0, 0, 1};
static const double pi = 3.14159265358979324;

typedef struct base {
    test_memory memory;
    kn_ctx *ctx;
    kn_spline spline;
    char path[PATH_BYTES];
} base;

static void begin(base *b, const char *name)
{
    *b = (base){.memory = TEST_MEMORY_INIT};
    b->ctx = test_ctx(&b->memory, 1);
    test_tmp_path(b->path, name);
}

// Writes the spline, and answers what info says of it.
static json_t *info_of(base *b)
{
    write_g2(b->path, &b->spline);
    kn_spline_clear(b->ctx, &b->spline);
    test_ctx_end(b->ctx, &b->memory);
    assert_int_equal(run("info '%s' --json", b->path), 0);
    return printed_json();
}

static void assert_counts(const json_t *info, size_t creases, size_t poles, size_t apexes, size_t without)
{
    assert_int_equal(json_array_size(json_object_get(info, "creases")), creases);
    assert_int_equal(json_array_size(json_object_get(info, "poles")), poles);
    assert_int_equal(json_array_size(json_object_get(info, "apexes")), apexes);
    assert_int_equal(json_array_size(json_object_get(info, "without_normal")), without);
}

static void assert_edge(const json_t *note, const char *edge, double z)
{
    const json_t *p = json_object_get(note, "point");
    assert_string_equal(json_string_value(json_object_get(note, "edge")), edge);
    assert_int_equal(json_integer_value(json_object_get(note, "surface")), 0);
    for (size_t c = 0; c < 3; c++) // on the axis, but for the rounding of a circle of radius 2
        assert_true(fabs(json_number_value(json_array_get(p, c)) - (c == 2 ? z : 0)) < 1e-14);
}

static void a_sphere_has_two_poles(void **state)
{
    (void)state;
    base b;
    begin(&b, "sphere.g2");
    assert_int_equal(kn_construct_sphere(b.ctx, &b.spline, origin, 2), KN_OK);
    json_t *info = info_of(&b);
    assert_counts(info, 0, 2, 0, 0);
    const json_t *poles = json_object_get(info, "poles");
    assert_edge(json_array_get(poles, 0), "v0", -2);
    assert_edge(json_array_get(poles, 1), "v1", 2);
    json_decref(info);
    assert_int_equal(run("info '%s'", b.path), 0);
    assert_non_null(strstr(printed, "pole    surface 0: v1, at "));
}

static void a_torus_has_nothing(void **state)
{
    (void)state;
    base b;
    begin(&b, "torus.g2");
    assert_int_equal(kn_construct_torus(b.ctx, &b.spline, origin, z_axis, 3, 1), KN_OK);
    json_t *info = info_of(&b);
    assert_counts(info, 0, 0, 0, 0);
    json_decref(info);
}

static void a_cone_has_an_apex(void **state)
{
    (void)state;
    base b;
    begin(&b, "cone.g2");
    assert_int_equal(kn_construct_cone(b.ctx, &b.spline, origin, z_axis, 1, 0), KN_OK);
    json_t *info = info_of(&b);
    assert_counts(info, 0, 0, 1, 0);
    assert_edge(json_array_get(json_object_get(info, "apexes"), 0), "v1", 1);
    json_decref(info);
}

// Two planes at right angles that meet at u = 1/4; the file's first surface is a plane.
static void a_roof_has_a_crease(void **state)
{
    (void)state;
    char path[PATH_BYTES];
    test_tmp_path(path, "roof.g2");
    write_text(path, "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n"
                     "200 1 0 0\n3 0\n3 2\n0 0 0.25 1 1\n2 2\n0 0 1 1\n0 0 0\n1 0 1\n2 0 0\n0 3 0\n1 3 1\n2 3 0\n");
    assert_int_equal(run("info '%s' --json", path), 0);
    json_t *info = printed_json();
    assert_counts(info, 1, 0, 0, 0);
    const json_t *crease = json_array_get(json_object_get(info, "creases"), 0);
    assert_int_equal(json_integer_value(json_object_get(crease, "surface")), 1);
    assert_string_equal(json_string_value(json_object_get(crease, "variable")), "u");
    assert_true(json_number_value(json_object_get(crease, "knot")) == 0.25);
    assert_true(fabs(json_number_value(json_object_get(crease, "angle_rad")) - pi / 2) < 1e-12);
    json_decref(info);
    assert_int_equal(run("info '%s'", path), 0);
    assert_non_null(strstr(printed, "crease  surface 1: u = 0.25, up to 90 degrees"));
}

static void a_volume_is_counted(void **state)
{
    (void)state;
    base b;
    begin(&b, "block.g2");
    kn_spline plane = {0};
    const double up[3] = {0, 0, 2}, knots[4] = {0, 0, 1, 1}, coef[12] = {0, 0, 1, 1, 0, 1, 0, 1, 0, 0, 0, 0};
    assert_int_equal(kn_spline_init(b.ctx, &plane, 2, 3, false, (const int[]){1, 1}, (const int[]){2, 2},
                                    (const double *const[]){knots, knots}, coef),
                     KN_OK);
    assert_int_equal(kn_construct_extruded(b.ctx, &b.spline, &plane, up), KN_OK);
    kn_spline_clear(b.ctx, &plane);
    json_t *info = info_of(&b);
    assert_counts(info, 0, 0, 0, 0);
    assert_int_equal(json_integer_value(json_object_get(info, "volumes")), 1);
    json_decref(info);

    // It is a shell itself: three parameters, and no more.
    double x, y, z;
    assert_int_equal(run("eval '%s' --at 0.5,0.25,0.5", b.path), 0);
    assert_int_equal(sscanf(printed, "%lf %lf %lf", &x, &y, &z), 3);
    assert_true(x == 0.5 && y == 0.25 && z == 1);
    assert_int_equal(run("eval '%s' --at 0.5,0.25", b.path), 2);
}

static void a_surface_without_a_normal_is_told(void **state)
{
    (void)state;
    char path[PATH_BYTES];
    test_tmp_path(path, "cusp.g2"); // turns back on itself: S_u vanishes along a line inside
    write_text(path, "200 1 0 0\n3 0\n4 4\n0 0 0 0 1 1 1 1\n2 2\n0 0 1 1\n"
                     "0 0 0\n20 0 0\n-10 0 0\n10 0 0\n0 9 0\n20 9 0\n-10 9 0\n10 9 0\n");
    assert_int_equal(run("info '%s' --json", path), 0);
    json_t *info = printed_json();
    assert_counts(info, 0, 0, 0, 1);
    json_decref(info);
    assert_int_equal(run("info '%s'", path), 0);
    assert_non_null(strstr(printed, "trouble surface 0: "));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sphere_has_two_poles), cmocka_unit_test(a_torus_has_nothing),
        cmocka_unit_test(a_cone_has_an_apex),     cmocka_unit_test(a_roof_has_a_crease),
        cmocka_unit_test(a_volume_is_counted),    cmocka_unit_test(a_surface_without_a_normal_is_told),
    };
    return cmocka_run_group_tests_name("cli/info", tests, NULL, NULL);
}
