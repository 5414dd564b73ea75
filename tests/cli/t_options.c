// SPDX-License-Identifier: Apache-2.0
// Options of placement, selection, variation and crossing, the same as keys of a recipe; tiles from files; layers.
#include "tests/cli/command.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char square[] = "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n6 0 0\n0 6 0\n6 6 0\n"
                             "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 9\n6 0 9\n0 6 9\n6 6 9\n";
static const char pyramid[] = "v 0.1 0.1 0\nv 0.9 0.1 0\nv 0.9 0.9 0\nv 0.1 0.9 0\nv 0.5 0.5 1\n"
                              "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 4 3 2 1\n";

static void make_square(char path[PATH_BYTES])
{
    test_tmp_path(path, "squares.g2");
    write_text(path, square);
}

static int count(const json_t *o, const char *key)
{
    assert_true(json_is_integer(json_object_get(o, key)));
    return (int)json_integer_value(json_object_get(o, key));
}

// Two squares of 4 x 4 cells each.
static int cells_with(const char *base, const char *options)
{
    assert_int_equal(run("apply '%s' --tile bump --count 4 --height 1 --dry-run --json %s", base, options), 0);
    json_t *r = printed_json();
    int n = count(r, "cells");
    json_decref(r);
    return n;
}

static void cells_that_are_there(void **state)
{
    (void)state;
    char base[PATH_BYTES], picture[PATH_BYTES];
    make_square(base);
    assert_int_equal(cells_with(base, ""), 32);
    assert_int_equal(cells_with(base, "--faces 1"), 16);
    assert_int_equal(cells_with(base, "--faces 0-1"), 32);
    assert_int_equal(cells_with(base, "--mask 'u>0.5'"), 16);
    assert_int_equal(cells_with(base, "--mask 'face==0 && x<1.6'"), 4);
    assert_int_equal(cells_with(base, "--mask 0"), 0);
    assert_int_equal(cells_with(base, "--skip 2"), 8);
    assert_int_equal(cells_with(base, "--range 3,5"), 5);
    assert_int_equal(cells_with(base, "--slab 8,12"), 16);
    assert_int_equal(cells_with(base, "--within-angle z,10"), 32);
    assert_int_equal(cells_with(base, "--within-angle -z,10"), 0);
    assert_int_equal(cells_with(base, "--within-angle 1,0,0,91"), 32);
    assert_int_equal(cells_with(base, "--camera 3,3,50,3,3,100"), 0); // it looks away
    test_tmp_path(picture, "field.g2");                               // u
    write_text(picture, "200 1 0 0\n1 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0\n1\n0\n1\n");
    char option[PATH_BYTES + 16];
    snprintf(option, sizeof option, "--mask '%s'", picture);
    assert_int_equal(cells_with(base, option), 16);
    assert_int_equal(run("apply '%s' --tile bump --count 4 --dry-run --json --mask 'u>0.5'", base), 0);
    json_t *r = printed_json();
    assert_int_equal(count(json_object_get(r, "cells_dropped"), "mask"), 16);
    json_decref(r);
}

static void values_that_make_no_sense(void **state)
{
    (void)state;
    static const char *const wrong[] = {
        "--faces 3-1",
        "--faces x",
        "--faces 1,",
        "--faces 0-99999",
        "--within-angle 30",
        "--within-angle w,30",
        "--within-angle 0,0,0,30",
        "--within-angle z,200",
        "--skip 0",
        "--density 0",
        "--density 1.5",
        "--seed -1",
        "--seed 1.5",
        "--range -1",
        "--range 1,0",
        "--range 1,2,3",
        "--slab 1",
        "--slab a,b",
        "--mirror w",
        "--border round",
        "--border clip,x",
        "--stagger x",
        "--shift 1,2,3",
        "--scatter 0",
        "--scatter -1mm",
        "--taper 0",
        "--vary height",
        "--vary =3",
        "--vary height=",
        "--set height=x",
        "--jitter 3",
        "--jitter angle=400",
        "--jitter size=1",
        "--jitter shift=-1",
        "--crossing perhaps",
        "--crossing-tol 1mm",
        "--camera 1,2,3",
        "--picture 3",
        "--camera 1,2,3,1,2,3",
        "--rotate 1e9",
    };
    char base[PATH_BYTES];
    make_square(base);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        if (run("apply '%s' --tile bump --count 4 --dry-run %s", base, wrong[i]) != 2)
            fail_msg("%s: %s", wrong[i], complained);
        assert_string_equal(printed, "");
    }
    assert_int_equal(run("apply '%s' --tile bump --count 4 --dry-run --mask 'u >'", base), 3);
    assert_non_null(strstr(complained, "--mask: expression 'u >'"));
    assert_int_equal(run("apply '%s' --tile bump --count 4 --dry-run --vary wobble=1", base), 3);
    assert_int_equal(run("apply '%s' --tile bump --count 4 --dry-run --mask none.png", base), 3);
    assert_int_equal(run("apply '%s' --tile bump --count 4 --resume -o x.glb", base), 2);
    assert_int_equal(run("apply '%s' --tile bump --count 4 --resume -o x.step -o x.stpz", base), 2);
    assert_non_null(strstr(complained, "cannot be gone on with"));
    assert_int_equal(run("apply '%s' --tile bump --count 4 --resume -o x.mesh", base), 2);
}

// A tile from a mesh: its top is at the height, which varies from place to place.
static void meshes_as_tiles(void **state)
{
    (void)state;
    char base[PATH_BYTES], mesh[PATH_BYTES], out[PATH_BYTES], text[1024];
    make_square(base);
    test_tmp_path(mesh, "pyramid.obj");
    write_text(mesh, pyramid);
    assert_int_equal(run("apply '%s' --tile '%s' --count 2 --height 1 --faces 0 --dry-run --json", base, mesh), 0);
    json_t *r = printed_json();
    assert_int_equal(count(r, "meshes"), 4);
    assert_int_equal(count(r, "triangles"), 24);
    json_decref(r);
    test_tmp_path(out, "pyramid.json");
    snprintf(text, sizeof text,
             "{\"format\":1,\"kind\":\"tile\",\"name\":\"p\",\"parts\":[{\"name\":\"p\",\"file\":\"%s\"}],"
             "\"defaults\":{\"count\":[3,1],\"height\":2}}",
             strrchr(mesh, '/') + 1);
    write_text(out, text);
    assert_int_equal(run("apply '%s' --tile '%s' --dry-run --json", base, out), 0);
    r = printed_json();
    assert_int_equal(count(r, "cells"), 6);
    assert_true(json_number_value(json_object_get(r, "height")) == 2);
    json_decref(r);
    assert_int_equal(run("apply '%s' --tile '%s' --count 5 --dry-run --json", base, out), 0); // what is said counts
    r = printed_json();
    assert_int_equal(count(r, "cells"), 50);
    json_decref(r);
    assert_int_equal(run("apply '%s' --tile '%s' --tile-cell 0,0,2,2 --dry-run", base, out), 2);
    write_text(out, "{\"format\":1,\"kind\":\"tile\",\"name\":\"p\",\n\"parts\":[}");
    assert_int_equal(run("apply '%s' --tile '%s' --dry-run", base, out), 3);
    assert_non_null(strstr(complained, "pyramid.json:2: "));
    write_text(mesh, "v 0 0 0\nf 1 2 3\n");
    assert_int_equal(run("apply '%s' --tile '%s' --dry-run", base, mesh), 3);
    assert_non_null(strstr(complained, "pyramid.obj: "));
    assert_int_equal(strchr(complained, '\n') - complained, strlen(complained) - 1); // one line
}

static void make_recipe(char path[PATH_BYTES], const char *base, const char *layers)
{
    char text[2048];
    snprintf(text, sizeof text, "{\"format\":1,\"base\":\"%s\",\"layers\":[%s]}", strrchr(base, '/') + 1, layers);
    test_tmp_path(path, "layers.json");
    write_text(path, text);
}

static void layers(void **state)
{
    (void)state;
    char base[PATH_BYTES], path[PATH_BYTES], out[PATH_BYTES];
    make_square(base);
    make_recipe(
        path, base,
        "{\"name\":\"hills\",\"tile\":\"bump\",\"count\":1,\"height\":1,\"faces\":[0],\"direction\":[0,0,1],"
        "\"base_only\":true},"
        "{\"tile\":\"knurl\",\"on\":\"hills\",\"count\":2,\"height\":0.1,\"direction\":[0,0,1]},"
        "{\"tile\":\"bump\",\"count\":[2,1],\"faces\":\"1\",\"mask\":\"u>0.5\",\"border\":[\"clip\",\"extend\"],"
        "\"vary\":{\"height\":\"1+u\"},\"set\":{\"offset\":0.5},\"seed\":3,\"within_angle\":[\"z\",20]}");
    test_tmp_path(out, "layers.stl");
    assert_int_equal(run("apply '%s' --json -o '%s'", path, out), 0);
    json_t *r = printed_json(), *list = json_object_get(r, "layers");
    assert_int_equal(json_array_size(list), 3);
    assert_int_equal(count(json_array_get(list, 0), "cells"), 1);
    assert_int_equal(count(json_array_get(list, 0), "patches"), 9);
    assert_int_equal(count(json_array_get(list, 1), "cells"), 36); // 2 x 2 on each of nine patches
    assert_int_equal(count(json_array_get(list, 2), "cells"), 1);
    assert_int_equal(count(r, "cells"), 37); // the first layer is a base alone
    size_t bytes;
    free(test_read_file(out, &bytes));
    assert_true(bytes <= 84 + 50 * (size_t)count(r, "triangles"));
    json_decref(r);
    assert_int_equal(run("apply '%s' --dry-run --resume -o '%s'", path, out), 0);
    char again[PATH_BYTES];
    test_tmp_path(again, "resumed.stl");
    assert_int_equal(run("apply '%s' -q --resume -o '%s'", path, again), 0);
    size_t na, nb;
    char *first = test_read_file(out, &na), *second = test_read_file(again, &nb);
    assert_true(first && second && na == nb);
    assert_memory_equal(first, second, na);
    free(first);
    free(second);
    static const char *const wrong[] = {
        "{\"tile\":\"bump\",\"on\":\"hills\"}",
        "{\"tile\":\"bump\",\"on\":1}",
        "{\"name\":\"a\",\"tile\":\"bump\",\"on\":\"a\"}",
        "{\"tile\":\"bump\",\"base_only\":true}",
        "{\"tile\":\"bump\",\"base_only\":1}",
        "{\"tile\":\"bump\",\"name\":\"\"}",
        "{\"tile\":\"bump\"},{\"count\":1}",
        "{\"tile\":\"bump\",\"vary\":\"height=1\"}",
        "{\"tile\":\"bump\",\"vary\":{\"height\":[]}}",
        "{\"tile\":\"bump\",\"set\":{\"height\":\"u\"}}",
        "{\"tile\":\"bump\",\"faces\":{}}",
        "{\"tile\":\"bump\",\"jitter\":{\"size\":1}}",
        "{\"tile\":\"bump\",\"hidden\":1}",
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        make_recipe(path, base, wrong[i]);
        if (run("apply '%s' --dry-run", path) != 3) fail_msg("%s: %s", wrong[i], complained);
        assert_non_null(strstr(complained, "layers.json"));
    }
}

// Thirds can be said. Two squares.
static void fractions(void **state)
{
    (void)state;
    char base[PATH_BYTES];
    make_square(base);
    assert_int_equal(run("apply '%s' --tile bump --count 6 --stagger 1/3 --dry-run --json", base), 0);
    json_t *r = printed_json();
    assert_int_equal(count(r, "cells"), 72);
    json_decref(r);
    assert_int_equal(run("apply '%s' --tile bump --count 6/2,8/2 --shift -1/4,3/2 --dry-run --json", base), 0);
    r = printed_json();
    assert_int_equal(count(r, "cells"), 24);
    json_decref(r);
    static const char *const wrong[] = {"--stagger 1/",    "--stagger /3",   "--stagger 1/0",
                                        "--stagger 1/2/3", "--stagger 1/17", "--count 1/2"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        if (run("apply '%s' --tile bump --count 6 %s --dry-run", base, wrong[i]) == 0) fail_msg("%s", wrong[i]);
}

// The same bytes with a journal as without, and none is left.
static void resumed_runs(void **state)
{
    (void)state;
    char base[PATH_BYTES], a[PATH_BYTES], b[PATH_BYTES], journal[PATH_BYTES + 16];
    make_square(base);
    test_tmp_path(a, "a.stl");
    test_tmp_path(b, "b.stl");
    assert_int_equal(run("apply '%s' --tile bump --count 4 -q -o '%s'", base, a), 0);
    assert_int_equal(run("apply '%s' --tile bump --count 4 -q --resume -o '%s'", base, b), 0);
    size_t na, nb;
    char *first = test_read_file(a, &na), *second = test_read_file(b, &nb);
    assert_true(first && second && na == nb);
    assert_memory_equal(first, second, na);
    free(first);
    free(second);
    snprintf(journal, sizeof journal, "%s.journal", b);
    assert_false(exists(journal));

    FILE *f = fopen(journal, "w"); // it is said which file is none
    assert_non_null(f);
    fputs("garbage", f);
    assert_int_equal(fclose(f), 0);
    assert_int_equal(run("apply '%s' --tile bump --count 4 -q --resume -o '%s'", base, b), 3);
    assert_non_null(strstr(complained, "b.stl.journal: "));
    assert_int_equal(remove(journal), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cells_that_are_there),
        cmocka_unit_test(values_that_make_no_sense),
        cmocka_unit_test(meshes_as_tiles),
        cmocka_unit_test(layers),
        cmocka_unit_test(fractions),
        cmocka_unit_test(resumed_runs),
    };
    return cmocka_run_group_tests_name("cli/options", tests, NULL, NULL);
}
