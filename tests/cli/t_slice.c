// SPDX-License-Identifier: Apache-2.0
// knurl slice: drawings and 3MF files, the report, what is refused.
#include "tests/cli/command.h"

#include <knurl/knurl.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if KN_WITH_LIB3MF
#include "bridges/lib3mf/slices.h"
#endif

// A tube about z, of radius 1 and height 2.
static void write_tube(char path[PATH_BYTES])
{
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    const double base[3] = {0, 0, 0}, axis[3] = {0, 0, 2};
    assert_int_equal(kn_construct_cylinder(ctx, &s, base, axis, 1), KN_OK);
    test_tmp_path(path, "tube.g2");
    write_g2(path, &s);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static const char texture[] = "--tile knurl --count 8,3 --height 0.1 --normal-tol 1e-2 --max-degree 40";

static long long number(const json_t *o, const char *key)
{
    json_t *value = json_object_get(o, key);
    assert_true(json_is_integer(value));
    return json_integer_value(value);
}

static void layers(void **state)
{
    (void)state;
    char tube[PATH_BYTES], svg[PATH_BYTES], first[PATH_BYTES], last[PATH_BYTES], more[PATH_BYTES];
    write_tube(tube);
    test_tmp_path(svg, "tube.svg");
    assert_int_equal(run("slice %s %s --layer 0.25 --from 0 --to 2 --json -o %s", tube, texture, svg), 0);
    json_t *o = printed_json();
    assert_int_equal(number(o, "layers"), 8);
    assert_int_equal(number(o, "contours"), 8); // one around the tube in each
    assert_int_equal(number(o, "open"), 0);
    double error = json_real_value(json_object_get(o, "error"));
    assert_true(error > 0 && error <= json_real_value(json_object_get(o, "tolerance")));
    assert_true(number(o, "cells_composed") >= 24);
    json_decref(o);
    snprintf(first, sizeof first, "%.*s-1.svg", (int)strlen(svg) - 4, svg);
    snprintf(last, sizeof last, "%.*s-8.svg", (int)strlen(svg) - 4, svg);
    snprintf(more, sizeof more, "%.*s-9.svg", (int)strlen(svg) - 4, svg);
    char text[TEXT_BYTES];
    slurp(first, text);
    assert_non_null(strstr(text, "<title>z = 0.125 mm</title>"));
    assert_non_null(strstr(text, "class=\"closed\""));
    assert_true(exists(last) && !exists(more));
}

static void three_mf(void **state)
{
    (void)state;
#if KN_WITH_LIB3MF
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char tube[PATH_BYTES], path[PATH_BYTES];
    kn_3mf_slices_facts facts;
    write_tube(tube);
    test_tmp_path(path, "tube.3mf");
    assert_int_equal(run("slice %s %s --layer 0.1in --from 0.5 --to 1.5 --unit in -q -o %s", tube, texture, path), 0);
    assert_string_equal(printed, "");
    assert_int_equal(kn_3mf_slices_look(ctx, &facts, path), KN_OK);
    assert_int_equal(facts.slices, 10);
    assert_int_equal(facts.polygons, 10);
    assert_true(facts.top > 1.499 * 25.4 && facts.top < 1.501 * 25.4);
    test_ctx_end(ctx, &memory);
#else
    skip();
#endif
}

// Whatever tiles are made of is cut: volumes by their faces, trimmed patches, which meet their neighbours.
static void what_tiles_hold(void **state)
{
    (void)state;
    char tube[PATH_BYTES], svg[PATH_BYTES];
    static const struct {
        const char *options;
        bool closed;
        long long least; // contours
    } kinds[] = {{"--tile cross --count 4,2 --max-degree 40 --layer 0.5", true, 4},
                 {"--tile knurl --count 8,3 --shift 0.3 --crossing trim --max-degree 40 --layer 0.5", true, 4}};
    write_tube(tube);
    test_tmp_path(svg, "kind.svg");
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        assert_int_equal(run("slice %s %s --normal-tol 1e-2 --height 0.1 --from 0 --to 2 --json -o %s", tube,
                             kinds[i].options, svg),
                         0);
        json_t *o = printed_json();
        assert_true(number(o, "contours") >= kinds[i].least);
        if (kinds[i].closed) assert_int_equal(number(o, "open"), 0);
        json_decref(o);
    }
    assert_int_equal(run("slice %s %s --mask 0 --layer 0.5 -o %s", tube, texture, svg), 3);
    assert_non_null(strstr(complained, "no cell"));
}

// Curves have no inside: alone they are refused, beside surfaces left out aloud.
static void curves(void **state)
{
    (void)state;
    char tube[PATH_BYTES], svg[PATH_BYTES], tile[PATH_BYTES];
    static const char curve[] = "100 1 0 0\n3 0\n2 2\n0 0 1 1\n0 0.5 0\n1 0.5 0.5\n";
    static const char sheet[] = "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
    write_tube(tube);
    test_tmp_path(svg, "curves.svg");
    test_tmp_path(tile, "curve.g2");
    for (int k = 0; k < 2; k++) {
        FILE *f = fopen(tile, "w");
        assert_non_null(f);
        fputs(curve, f);
        if (k == 1) fputs(sheet, f);
        assert_int_equal(fclose(f), 0);
        int code = run("slice %s --tile %s --count 4,2 --height 0.1 --normal-tol 1e-2 --max-degree 40 --layer 0.5 "
                       "--from 0 --to 2 -o %s",
                       tube, tile, svg);
        assert_int_equal(code, k == 0 ? 3 : 0);
        assert_non_null(strstr(complained, "inside"));
        assert_true((strstr(complained, "warning") != NULL) == (k == 1));
    }
}

// A mesh that reaches beyond an open end: heights are found all the same, and nothing lies outside of them.
static void meshes_beyond_the_end(void **state)
{
    (void)state;
    char tube[PATH_BYTES], svg[PATH_BYTES], tile[PATH_BYTES];
    write_tube(tube);
    test_tmp_path(svg, "beyond.svg");
    test_tmp_path(tile, "beyond.obj");
    FILE *f = fopen(tile, "w");
    assert_non_null(f);
    fputs("v 0.1 -0.5 0\nv 0.9 0.1 0\nv 0.5 1.75 0\nv 0.5 0.5 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n", f);
    assert_int_equal(fclose(f), 0);
    long long contours[2];
    for (int k = 0; k < 2; k++) {
        // layers of 1/4 about z = -1/8, 1/8, .. in both
        assert_int_equal(
            run("slice %s --tile %s --count 5,2 --height 0.1 --normal-tol 1e-3 --layer 0.25 --json %s -o %s", tube,
                tile, k == 0 ? "" : "--from -4 --to 6", svg),
            0);
        json_t *o = printed_json();
        double bottom = json_real_value(json_object_get(o, "bottom"));
        double top = json_real_value(json_object_get(o, "top"));
        contours[k] = number(o, "contours");
        assert_int_equal(number(o, "open"), 0);
        // The mesh reaches from half a cell below 0 to three quarters of one above 2; the lowest and the highest
        // layer that has contours, each in its middle, are less than a layer from there.
        if (k == 0) assert_true(bottom >= -0.625 && bottom < -0.375 && top > 2.625 && top <= 2.875);
        json_decref(o);
    }
    assert_true(contours[0] > 0 && labs(contours[1] - contours[0]) <= 10); // layers lie elsewhere, one at each end
}

static void the_same_bytes(void **state)
{
    (void)state;
#if KN_WITH_LIB3MF
    char tube[PATH_BYTES], path[PATH_BYTES], *bytes[2];
    size_t n[2];
    write_tube(tube);
    test_tmp_path(path, "same.3mf");
    for (int k = 0; k < 2; k++) {
        assert_int_equal(run("slice %s %s --layer 0.5 -q -j %d -o %s", tube, texture, k + 1, path), 0);
        bytes[k] = test_read_file(path, &n[k]);
    }
    assert_true(n[0] == n[1]);
    assert_memory_equal(bytes[0], bytes[1], n[0]);
    free(bytes[0]), free(bytes[1]);
#else
    skip();
#endif
}

static void refusals(void **state)
{
    (void)state;
    char tube[PATH_BYTES], svg[PATH_BYTES];
    write_tube(tube);
    test_tmp_path(svg, "refused.svg");
    assert_int_equal(run("slice %s %s -o %s", tube, texture, svg), 2);
    assert_non_null(strstr(complained, "--layer"));
    assert_int_equal(run("slice %s %s --layer -1 -o %s", tube, texture, svg), 2);
    assert_int_equal(run("slice %s %s --layer 0.1", tube, texture), 2);
    assert_int_equal(run("slice %s %s --layer 0.1 -o x.stl", tube, texture), 2);
    assert_int_equal(run("slice %s --layer 0.1 -o %s", tube, svg), 2);
    assert_int_equal(run("slice --tile knurl --layer 0.1 -o %s", svg), 2);
    assert_int_equal(run("slice %s %s --layer 0.1 --from 3 --to 2 -o %s", tube, texture, svg), 3);
    assert_int_equal(run("slice %s %s --layer 1e-9 -o %s", tube, texture, svg), 3);
    assert_non_null(strstr(complained, "layers between"));
    assert_int_equal(run("slice no-such.g2 %s --layer 1 -o %s", texture, svg), 3);
    assert_int_equal(run("slice %s %s --layer 1 -o /no/such/folder/x.svg", tube, texture), 1);
    assert_int_equal(run("slice --help"), 0);
    assert_non_null(strstr(printed, "--layer"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(layers),
                                       cmocka_unit_test(three_mf),
                                       cmocka_unit_test(what_tiles_hold),
                                       cmocka_unit_test(curves),
                                       cmocka_unit_test(meshes_beyond_the_end),
                                       cmocka_unit_test(the_same_bytes),
                                       cmocka_unit_test(refusals)};
    return cmocka_run_group_tests_name("cli/slice", tests, NULL, NULL);
}
