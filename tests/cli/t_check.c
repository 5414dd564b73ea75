// SPDX-License-Identifier: Apache-2.0
// knurl check: exit codes, JSON against closed forms, pictures and scenes, what is refused.
#include "tests/cli/command.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <knurl/knurl.h>

#if KN_WITH_TINYGLTF
#include "bridges/tinygltf/gltf.h"
#endif

// ---- bases ----

static const double origin[3] = {0, 0, 0}, z_axis[3] = {0, 0, 1};

static void write_torus(char path[PATH_BYTES])
{
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    assert_int_equal(kn_construct_torus(ctx, &s, origin, z_axis, 3, 1), KN_OK);
    test_tmp_path(path, "torus.g2");
    write_g2(path, &s);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Of radius 1 and height 3.
static void write_cylinder(char path[PATH_BYTES])
{
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    assert_int_equal(kn_construct_cylinder(ctx, &s, origin, (const double[3]){0, 0, 3}, 1), KN_OK);
    test_tmp_path(path, "cylinder.g2");
    write_g2(path, &s);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Unit squares: one looks up at z = 0, the other down at z = 1, with u the other way round, both over [0,1]^2.
static const char facing[] = "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n"
                             "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n1 0 1\n0 0 1\n1 1 1\n0 1 1\n";

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

static double element(const json_t *o, const char *key, size_t i)
{
    return json_number_value(json_array_get(get(o, key), i));
}

static const char *verdict(const json_t *o)
{
    return json_string_value(get(o, "verdict"));
}

// The contract: a bound below the truth, and within 1 % of it; the last digits that are printed lie outwards.
static void assert_safe(double bound, double truth)
{
    assert_true(bound <= truth && bound >= 0.99 * truth - 1e-5);
}

// ---- closed forms ----

// Above a torus of radii 3 and 1 the inner circle comes to the axis at 3 - 1, below all of it to its own circle at 1.
static void safe_heights_of_a_torus(void **state)
{
    (void)state;
    char path[PATH_BYTES];
    write_torus(path);
    assert_int_equal(run("check '%s' --height 0.1 --side both --json", path), 0); // the tube has room for 1
    json_t *r = printed_json();
    assert_safe(number(get(r, "safe_height"), "above"), 2);
    assert_safe(number(get(r, "safe_height"), "below"), 1);
    assert_string_equal(verdict(get(r, "jacobian")), "positive");
    assert_true(number(get(r, "jacobian"), "min") > 0);
    assert_true(element(r, "range", 0) == -0.1 && element(r, "range", 1) == 0.1);
    assert_int_equal(number(r, "folding_cells"), 0);
    assert_string_equal(verdict(json_array_get(get(r, "global"), 0)), "none");
    assert_true(json_is_true(get(r, "passed")));

    // The worst cells come first: on both sides the limit below is nearer, and where it is the point lies on the torus.
    json_t *worst = json_array_get(get(r, "local"), 0);
    assert_int_equal(number(worst, "surface"), 0);
    assert_safe(number(worst, "safe_below"), 1);
    double x = element(worst, "point", 0), y = element(worst, "point", 1), z = element(worst, "point", 2);
    assert_true(fabs(hypot(hypot(x, y) - 3, z) - 1) < 1e-9); // printed with twelve digits
    json_decref(r);
}

static void too_deep_is_4_and_says_what_to_do(void **state)
{
    (void)state;
    char path[PATH_BYTES];
    write_torus(path);
    assert_int_equal(run("check '%s' --height -1.5 --json --work 1", path), 4); // whatever else: it folds
    json_t *r = printed_json();
    assert_string_equal(verdict(get(r, "jacobian")), "mixed");
    assert_true(number(get(r, "jacobian"), "min") < 0);
    assert_int_equal(number(r, "folding_cells"), 16);
    assert_true(json_is_true(get(json_array_get(get(r, "local"), 0), "folds")));
    json_decref(r);

    assert_int_equal(run("check '%s' --height -1.5 --work 1", path), 4);
    assert_non_null(strstr(printed, "folds: yes"));
    assert_non_null(strstr(printed, "16 of 16 cells fold"));
    assert_non_null(strstr(printed, "lower the texture to 0.99"));
    assert_non_null(strstr(printed, "--side above"));
    assert_int_equal(run("check '%s' --height -1.5 --work 1 -q", path), 4);
    assert_string_equal(printed, "");
}

// Both rise towards each other over a gap of 1: they meet where their heights sum to 1.
static void sheets_that_face_each_other(void **state)
{
    (void)state;
    char path[PATH_BYTES];
    test_tmp_path(path, "facing.g2");
    write_text(path, facing);
    assert_int_equal(run("check '%s' --height 0.4 --json", path), 0);
    json_t *r = printed_json();
    assert_true(json_is_true(get(r, "passed")));
    assert_string_equal(verdict(json_array_get(get(r, "global"), 0)), "none");
    json_decref(r);

    assert_int_equal(run("check '%s' --height 0.6 --json", path), 4);
    r = printed_json();
    json_t *found = json_array_get(get(r, "global"), 0), *a = get(found, "a"), *b = get(found, "b");
    assert_string_equal(verdict(found), "found");
    assert_true(number(found, "gap") < 1e-9);
    assert_int_equal(number(a, "surface") + number(b, "surface"), 1);
    double up = number(a, "surface") == 0 ? element(a, "lo", 2) : element(b, "lo", 2);
    double down = number(a, "surface") == 0 ? element(b, "lo", 2) : element(a, "lo", 2);
    assert_true(fabs(up + down - 1) < 1e-9); // a witness is good to 1e-10 of the size, printed with twelve digits
    assert_true(fabs(element(found, "point", 2) - up) < 1e-9);
    json_decref(r);
    assert_int_equal(run("check '%s' --height 0.6", path), 4);
    assert_non_null(strstr(printed, "meets itself: yes"));
    assert_int_equal(run("check '%s' --height 4mm --unit cm", path), 0); // 0.4
    assert_int_equal(run("check '%s' --height 6mm --unit cm", path), 4);
}

// A tile that stands in one corner of its cell: on the two sheets these corners do not face each other.
static void only_the_region_of_the_tile_counts(void **state)
{
    (void)state;
    char path[PATH_BYTES], tile[PATH_BYTES];
    test_tmp_path(path, "facing.g2");
    test_tmp_path(tile, "corner.g2");
    write_text(path, facing);
    write_text(tile, "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0.1 0.1 0\n0.3 0.1 1\n0.1 0.3 0\n0.3 0.3 1\n");
    assert_int_equal(run("check '%s' --tile '%s' --count 1 --height 0.8", path, tile), 0);
    assert_int_equal(run("check '%s' --tile '%s' --count 2 --height 0.8", path, tile), 0);
    assert_int_equal(run("check '%s' --height 0.8", path), 4);
    // In a cell that is the left half of the tile's own they do: it then reaches over [0.2,0.6].
    assert_int_equal(run("check '%s' --tile '%s' --tile-cell 0,0,0.5,0.5 --count 1 --height 0.8", path, tile), 4);
}

// Volumes and meshes occupy what they occupy, too: cubes of half the sheets' distance.
static void tiles_that_are_no_surfaces(void **state)
{
    (void)state;
    char path[PATH_BYTES], tile[PATH_BYTES];
    test_tmp_path(path, "facing.g2");
    test_tmp_path(tile, "corner.obj");
    write_text(path, facing);
    write_text(tile, "v 0.1 0.1 0\nv 0.3 0.1 1\nv 0.1 0.3 0\nv 0.3 0.3 1\nf 1 2 4\nf 1 4 3\n");
    assert_int_equal(run("check '%s' --tile cross --count 2 --height 0.4", path), 0);
    assert_int_equal(run("check '%s' --tile cross --count 2 --height 0.8", path), 4);
#if KN_WITH_OPENMESH
    assert_int_equal(run("check '%s' --tile '%s' --count 2 --height 0.8", path, tile), 0);
    assert_int_equal(run("check '%s' --tile '%s' --tile-cell 0,0,0.5,0.5 --count 1 --height 0.8", path, tile), 4);
#endif
}

// Below a cylinder of radius 1 a texture may be 1 high, whatever the tile; where the tile is lower than that it fits.
static void local_heights_with_a_tile(void **state)
{
    (void)state;
    char path[PATH_BYTES];
    write_cylinder(path);
    assert_int_equal(run("check '%s' --tile bump --count 8,2 --normal-tol 1e-3 --height -0.5 --json", path), 0);
    json_t *r = printed_json();
    assert_string_equal(verdict(get(r, "jacobian")), "positive");
    assert_int_equal(number(r, "cells"), 16);
    assert_true(number(get(r, "jacobian"), "min") >= 0); // over what the tile occupies, as the verdict
    assert_true(element(r, "range", 0) > -0.55 && element(r, "range", 1) < 0.05);
    json_decref(r);
    assert_int_equal(run("check '%s' --tile bump --count 8,2 --normal-tol 1e-3 --height -1.5 --work 1 --json", path),
                     4);
    r = printed_json();
    assert_string_equal(verdict(get(r, "jacobian")), "mixed");
    assert_true(number(r, "folding_cells") > 0);
    assert_true(number(get(r, "jacobian"), "min") < 0);
    json_decref(r);
}

// Cells that apply leaves out do not count, and what is lower somewhere is. A cone of radii 2 and 0.4, the wide end at
// v = 0: a tile goes 0.6 below it where the radius is more than that.
static void as_apply_places_and_chooses(void **state)
{
    (void)state;
    static const struct {
        const char *options;
        int code, cells;
    } cases[] = {{"", 4, 32},
                 {"--range 0,1", 0, 1},
                 {"--skip 4,4", 0, 2},
                 {"--mask 'v<0.5'", 0, 16},
                 {"--mask 'v>0.5'", 4, 16},
                 {"--faces 0 --density 1", 4, 32},
                 {"--vary height='1-0.9*v'", 0, 32},
                 {"--shift 0.5,0", 4, 32},
                 {"--mask 'v<0.5' --shift 0.5,0 --mirror u", 0, 16},
                 {"--mask 'v<0'", 0, 0}};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    char path[PATH_BYTES];
    assert_int_equal(kn_construct_cone(ctx, &s, origin, (const double[3]){0, 0, 3}, 2, 0.4), KN_OK);
    test_tmp_path(path, "cone.g2");
    write_g2(path, &s);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int code = run("check '%s' --tile bump --count 8,4 --normal-tol 1e-2 --height -0.6 --json %s", path,
                       cases[i].options);
        if (code != cases[i].code) fail_msg("%s: exit code %d", cases[i].options, code);
        json_t *r = printed_json();
        assert_int_equal(number(r, "cells"), cases[i].cells);
        assert_true((number(r, "folding_cells") > 0) == (code == 4));
        json_decref(r);
    }
    assert_int_equal(run("check '%s' --height -0.1 --mask 1", path), 2); // of what?
    assert_int_equal(run("check '%s' --height -0.1 --stagger 0.5", path), 2);
}

// What no cell line cuts along a parameter line of its own lies in several cells: from the wide end of the cone, where it
// fits, to the narrow one, where it does not.
static void one_tile_over_many_cells(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    char path[PATH_BYTES], tile[PATH_BYTES];
    assert_int_equal(kn_construct_cone(ctx, &s, origin, (const double[3]){0, 0, 3}, 2, 0.4), KN_OK);
    test_tmp_path(path, "cone.g2");
    test_tmp_path(tile, "long.g2");
    write_g2(path, &s);
    write_text(tile, "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0.1 0.1 0\n0.5 0.3 1\n0.5 3.7 0\n0.9 3.9 1\n");
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
    assert_int_equal(
        run("check '%s' --tile '%s' --count 8,4 --normal-tol 1e-2 --height -0.6 --range 0,1 --json", path, tile), 4);
    json_t *r = printed_json();
    assert_int_equal(number(r, "cells"), 4);
    assert_true(number(r, "folding_cells") > 0);
    json_decref(r);
}

// The thorn's sheet has no height of its own: with an offset, on both sides and in volumes it is a region all the same.
static void flat_patches(void **state)
{
    (void)state;
    static const char *const where[] = {"--height 0.2", "--height 0.2 --offset 0.1", "--height 0.2 --side both",
                                        "--height 0.2 --side below"};
    // Of the tile's heights: from the sheet at 0 (both: -1) to a tip between w = 0.5 and 1.5.
    static const double lo[] = {0, 0.1, -0.2, -0.3}, hi[] = {0.3, 0.4, 0.4, 0};
    char square[PATH_BYTES], block[PATH_BYTES];
    test_tmp_path(square, "square.g2");
    write_text(square, "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n9 0 0\n0 9 0\n9 9 0\n");
    test_tmp_path(block, "block.g2");
    write_text(block, "700 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n"
                      "0 0 0\n5 0 0\n0 5 0\n5 5 0\n0 0 1\n5 0 1\n0 5 1\n5 5 1\n");
    for (int i = 0; i < 4; i++) {
        assert_int_equal(run("check '%s' --tile thorn --count 2 %s --json", square, where[i]), 0);
        json_t *r = printed_json();
        double from = element(r, "range", 0), to = element(r, "range", 1);
        assert_true(from >= lo[i] && to <= hi[i] && to - from > 0.1);
        assert_true(from == 0 || fabs(from) > 1e-6); // no rounding of 0
        json_decref(r);
    }
    assert_int_equal(run("check '%s' --tile thorn --count 1", square), 0);
    assert_int_equal(run("check '%s' --tile bump --count 4", block), 0);
    assert_int_equal(run("check '%s' --tile bump --count 4 --height 0.5", block), 0);
}

// Every failure has advice that can be followed.
static void advice(void **state)
{
    (void)state;
    char path[PATH_BYTES];
    write_cylinder(path);
    assert_int_equal(run("check '%s' --height -0.3 --offset -1.2", path), 4); // beyond the axis, whatever the height
    assert_non_null(strstr(printed, "lower the offset: "));
    assert_int_equal(run("check '%s' --height -0.6 --offset -0.6", path), 4);
    assert_non_null(strstr(printed, "lower the height: "));
    test_tmp_path(path, "square.g2");
    write_text(path, "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n9 0 0\n0 9 0\n9 9 0\n");
    assert_int_equal(run("check '%s' --height 1 --direction 0,0,-1", path), 4);
    assert_non_null(strstr(printed, "the direction points below the base"));
}

static void a_recipe(void **state)
{
    (void)state;
    char base[PATH_BYTES], recipe[PATH_BYTES];
    write_cylinder(base);
    test_tmp_path(recipe, "recipe.json");
    char text[PATH_BYTES + 256];
    snprintf(text, sizeof text,
             "{\"format\": 1, \"base\": \"%s\", \"normal_tol\": 1e-3,"
             " \"layers\": [{\"tile\": \"thorn\", \"count\": [8, 2], \"height\": -1.5}]}",
             base);
    write_text(recipe, text); // a thorn that comes from all around beyond the axis folds
    assert_int_equal(run("check '%s' --json --work 1", recipe), 4);
    json_t *r = printed_json();
    assert_string_equal(json_string_value(get(r, "tile")), "thorn");
    assert_int_equal(number(r, "cells"), 16);
    json_decref(r);
}

static void volumes(void **state)
{
    (void)state;
    static const char head[] = "700 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n2 2\n0 0 2 2\n";
    char path[PATH_BYTES], text[512];
    test_tmp_path(path, "block.g2");
    snprintf(text, sizeof text, "%s0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n", head);
    write_text(path, text);
    assert_int_equal(run("check '%s' --json", path), 0);
    json_t *r = printed_json();
    assert_true(element(r, "range", 0) == 0 && element(r, "range", 1) == 2); // its own heights
    // det = 1 x 1 x 1/2, everywhere: products of small integers are exact, bounds are rounded outwards
    assert_true(number(get(r, "jacobian"), "min") <= 0.5 && number(get(r, "jacobian"), "max") >= 0.5);
    assert_true(number(get(r, "jacobian"), "min") > 0.49);
    json_decref(r);
    snprintf(text, sizeof text, "%s0 0 0\n0 1 0\n1 0 0\n1 1 0\n0 0 1\n0 1 1\n1 0 1\n1 1 1\n", head);
    write_text(path, text);
    assert_int_equal(run("check '%s'", path), 4);
    assert_non_null(strstr(printed, "inside out"));
}

// ---- fields ----

// Twice the thickness is half the height; a field that is no constant comes from a file.
static void thickness_counts(void **state)
{
    (void)state;
    char path[PATH_BYTES], field[PATH_BYTES];
    write_cylinder(path);
    assert_int_equal(run("check '%s' --height -0.4 --thickness 2 --json", path), 0);
    json_t *r = printed_json();
    assert_safe(number(get(r, "safe_height"), "below"), 0.5);
    json_decref(r);
    test_tmp_path(field, "thickness.g2");
    write_text(field, "200 1 0 0\n1 0\n2 2\n0 0 1 1\n2 2\n0 0 5 5\n2\n2\n2\n2\n");
    assert_int_equal(run("check '%s' --height -0.4 --thickness '%s' --json", path, field), 0);
    r = printed_json();
    assert_safe(number(get(r, "safe_height"), "below"), 0.5);
    json_decref(r);
}

// ---- pictures and scenes ----

static void a_scene_with_colors(void **state)
{
    (void)state;
#if KN_WITH_TINYGLTF
    char path[PATH_BYTES], out[PATH_BYTES];
    write_torus(path);
    test_tmp_path(out, "heat.glb");
    // At 1.4 the outer side has more than enough room above, and the inner one (2) less than twice as much.
    assert_int_equal(run("check '%s' --height 1.4 --work 1 -q -o '%s'", path, out), 4);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_scene scene = {0};
    assert_int_equal(kn_gltf_read(ctx, &scene, out), KN_OK);
    assert_int_equal(scene.nitems, 1);
    const kn_scene_item *item = &scene.items[0];
    assert_non_null(item->color);
    float lo[3] = {1, 1, 1}, hi[3] = {0, 0, 0};
    for (size_t v = 0; v < item->mesh.nvertices; v++)
        for (size_t c = 0; c < 3; c++) {
            float x = item->color[3 * v + c];
            assert_true(x >= 0 && x <= 1);
            lo[c] = x < lo[c] ? x : lo[c];
            hi[c] = x > hi[c] ? x : hi[c];
        }
    assert_true(hi[0] - lo[0] > 0.1F);
    // The height rises along the circle of the tube, so that the colour depends on the distance from the axis alone:
    // in metres, y upwards, millimetres before.
    const double *p = item->mesh.position;
    for (size_t v = 0; v < item->mesh.nvertices; v++)
        if (hypot(p[3 * v], p[3 * v + 2]) > 3.5e-3)
            for (size_t c = 0; c < 3; c++) assert_true(fabsf(item->color[3 * v + c] - item->color[c]) < 1e-3F);
    kn_scene_clear(ctx, &scene);
    test_ctx_end(ctx, &memory);
    char *text = test_read_file(out, NULL);
    assert_non_null(text);
    assert_non_null(strstr(text + 20, "Safe height above the base")); // behind the header, in the JSON
    free(text);
#else
    skip();
#endif
}

// Under a sphere the Jacobian (1 + w)^2 touches 0 at the centre and turns back: its colour has to say so.
static void a_touching_zero_is_seen(void **state)
{
    (void)state;
#if KN_WITH_TINYGLTF
    char path[PATH_BYTES], out[PATH_BYTES];
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    assert_int_equal(kn_construct_sphere(ctx, &s, origin, 1), KN_OK);
    test_tmp_path(path, "sphere.g2");
    write_g2(path, &s);
    kn_spline_clear(ctx, &s);
    test_tmp_path(out, "sphere.glb");
    assert_int_equal(run("check '%s' --height -1.2 --work 1 -q -o '%s'", path, out), 4); // it folds at 1
    kn_scene scene = {0};
    assert_int_equal(kn_gltf_read(ctx, &scene, out), KN_OK);
    const float *color = scene.items[0].color;
    assert_non_null(color);
    // 1 of the 1.2 that were asked for: of the warm half of the scale, whose red is above twice its blue.
    for (size_t v = 0; v < scene.items[0].mesh.nvertices; v++) assert_true(color[3 * v] > 2.0F * color[3 * v + 2]);
    kn_scene_clear(ctx, &scene);
    test_ctx_end(ctx, &memory);
#else
    skip();
#endif
}

static void a_picture_with_a_legend(void **state)
{
    (void)state;
#if KN_WITH_EMBREE && KN_WITH_PNG && KN_WITH_CAIRO
    char path[PATH_BYTES], out[PATH_BYTES];
    test_tmp_path(path, "facing.g2");
    write_text(path, facing);
    test_tmp_path(out, "heat.png");
    assert_int_equal(run("check '%s' --height 0.4 -q --pixels 320,240 -o '%s'", path, out), 0);
    size_t bytes = 0;
    char *file = test_read_file(out, &bytes);
    assert_non_null(file);
    assert_memory_equal(file, "\x89PNG\r\n\x1a\n", 8);
    assert_memory_equal(file + 16, "\0\0\1\x40\0\0\0\xf0", 8); // IHDR: 320 x 240
    assert_true(bytes > 10000);                                // a plain one has some hundred
    free(file);
#else
    skip();
#endif
}

// ---- what is refused ----

static void usage_errors(void **state)
{
    (void)state;
    assert_int_equal(run("check"), 2);
    assert_int_equal(run("check data/teapot.bpt"), 2);
    assert_non_null(strstr(complained, "--height H is missing"));
    assert_int_equal(run("check data/teapot.bpt --heigth 1"), 2);
    assert_non_null(strstr(complained, "did you mean '--height'"));
    assert_int_equal(run("check data/teapot.bpt --height 0"), 2);
    assert_int_equal(run("check data/teapot.bpt --height 1 --color red"), 2);
    assert_int_equal(run("check data/teapot.bpt --height 1 --side left"), 2);
    assert_int_equal(run("check data/teapot.bpt --height 1 --count 3"), 2);
    assert_int_equal(run("check data/teapot.bpt --height 1 --tile thron"), 2);
    assert_int_equal(run("check data/teapot.bpt --height 1 --work 0"), 2);
    assert_int_equal(run("check data/teapot.bpt --height 1 --pixels 10"), 2);
    assert_int_equal(run("check data/teapot.bpt data/teapot.bpt --height 1"), 2);
    assert_int_equal(run("check data/teapot.bpt --height 1 --direction 0,0,0"), 2);
    assert_int_equal(run("check data/teapot.bpt --height 1 --direction 0,0,1 --normal fitted"), 2);
    assert_int_equal(run("check data/teapot.bpt --height 1 --attraction-power 3"), 2);
    assert_int_equal(run("check data/teapot.bpt --height 1 --thickness 0"), 2);
    assert_int_equal(run("check data/teapot.bpt --height 1 -o x.stl"), 2);
    assert_non_null(strstr(complained, ".glb"));
    assert_string_equal(printed, "");
}

static void bad_input_is_3(void **state)
{
    (void)state;
    char path[PATH_BYTES];
    assert_int_equal(run("check /nonexistent/x.g2 --height 1"), 3);
    test_tmp_path(path, "cusp.g2"); // turns back on itself: S_u vanishes along a line inside
    write_text(path, "200 1 0 0\n3 0\n4 4\n0 0 0 0 1 1 1 1\n2 2\n0 0 1 1\n"
                     "0 0 0\n20 0 0\n-10 0 0\n10 0 0\n0 9 0\n20 9 0\n-10 9 0\n10 9 0\n");
    assert_int_equal(run("check '%s' --height 1", path), 3);
    assert_non_null(strstr(complained, "cusp.g2: surface 0: "));
    assert_int_equal(strchr(complained, '\n') - complained, strlen(complained) - 1); // one line
    assert_int_equal(run("check data/teapot.bpt --height 1 --thickness /nonexistent/x.g2"), 3);
    test_tmp_path(path, "none.g2"); // a thickness that falls to 0: the message names its file
    write_text(path, "200 1 0 0\n1 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0\n1\n0\n1\n");
    assert_int_equal(run("check data/teapot.bpt --height 1 --thickness '%s'", path), 3);
    assert_non_null(strstr(complained, "none.g2"));
    write_text(path, "100 1 0 0\n3 0\n2 2\n0 0 1 1\n0 0 0\n1 0 0\n");
    assert_int_equal(run("check data/teapot.bpt --height 1 --direction '%s'", path), 3);
    assert_non_null(strstr(complained, "--direction: "));
}

// Interrupted while it draws: exit code 5 and no file of any name.
static void interrupted_is_5(void **state)
{
    (void)state;
    char folder[PATH_BYTES], out[PATH_BYTES + 16], line[2 * PATH_BYTES];
    test_tmp_path(folder, "check-interrupted");
    assert_int_equal(mkdir(folder, 0777), 0);
    snprintf(out, sizeof out, "%s/heat.png", folder);
    int status = SIGINT;
    // on a busy machine a signal may come before the program listens: then again, later
    for (long wait = 500; WIFSIGNALED(status) && wait <= 8000; wait *= 2) {
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            execl(getenv("KNURL"), "knurl", "check", "data/teapot.bpt", "--height", "0.1", "-q", "--side", "both",
                  "--pixels", "8000,6000", "-o", out, (char *)NULL);
            _exit(127);
        }
        nanosleep(&(struct timespec){.tv_sec = wait / 1000, .tv_nsec = wait % 1000 * 1000000}, NULL);
        kill(child, SIGINT);
        assert_int_equal(waitpid(child, &status, 0), child);
    }
    assert_true(WIFEXITED(status));
    int code = WEXITSTATUS(status);
    if (code == 2) skip(); // built without what draws
    assert_int_equal(code, 5);
    snprintf(line, sizeof line, "rmdir '%s'", folder); // fails when anything is left in it
    assert_int_equal(system(line), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(safe_heights_of_a_torus),
        cmocka_unit_test(too_deep_is_4_and_says_what_to_do),
        cmocka_unit_test(sheets_that_face_each_other),
        cmocka_unit_test(only_the_region_of_the_tile_counts),
        cmocka_unit_test(tiles_that_are_no_surfaces),
        cmocka_unit_test(local_heights_with_a_tile),
        cmocka_unit_test(as_apply_places_and_chooses),
        cmocka_unit_test(one_tile_over_many_cells),
        cmocka_unit_test(flat_patches),
        cmocka_unit_test(advice),
        cmocka_unit_test(a_recipe),
        cmocka_unit_test(volumes),
        cmocka_unit_test(thickness_counts),
        cmocka_unit_test(a_scene_with_colors),
        cmocka_unit_test(a_touching_zero_is_seen),
        cmocka_unit_test(a_picture_with_a_legend),
        cmocka_unit_test(usage_errors),
        cmocka_unit_test(bad_input_is_3),
        cmocka_unit_test(interrupted_is_5),
    };
    return cmocka_run_group_tests_name("cli/check", tests, NULL, NULL);
}
