// SPDX-License-Identifier: Apache-2.0
// knurl animate: morph targets and their animation, pictures, what is refused.
#include "tests/cli/command.h"

#include <knurl/knurl.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if KN_WITH_EMBREE && KN_WITH_PNG && KN_WITH_TINYGLTF

static void write_square(char path[PATH_BYTES])
{
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static const double knots[] = {0, 0, 1, 1}, coef[12] = {0, 0, 4, 4, 0, 4, 0, 4, 0, 0, 0, 0};
    const double *both[2] = {knots, knots};
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    kn_spline s = {0};
    assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, degree, count, both, coef), KN_OK);
    test_tmp_path(path, "square.g2");
    write_g2(path, &s);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static const char texture[] = "--tile bump --count 2,2 --height 0.5 -q";

// The JSON of a .glb; *bin: its binary chunk, in *file, for free().
static json_t *open_glb(char **file, const unsigned char **bin, const char *path)
{
    size_t bytes;
    *file = test_read_file(path, &bytes);
    assert_non_null(*file);
    uint32_t length;
    memcpy(&length, *file + 12, 4);
    assert_memory_equal(*file, "glTF", 4);
    assert_true(20 + (size_t)length + 8 <= bytes);
    *bin = (const unsigned char *)*file + 20 + length + 8;
    json_t *root = json_loadb(*file + 20, length, 0, NULL);
    assert_non_null(root);
    return root;
}

static json_int_t whole(const json_t *o, const char *key)
{
    return json_integer_value(json_object_get(o, key)); // 0 when it is missing, as in glTF
}

// Three floats of element i of an accessor.
static void element(float out[3], const json_t *root, const unsigned char *bin, json_int_t accessor, size_t i)
{
    const json_t *a = json_array_get(json_object_get(root, "accessors"), (size_t)accessor);
    const json_t *view = json_array_get(json_object_get(root, "bufferViews"), (size_t)whole(a, "bufferView"));
    size_t stride = (size_t)whole(view, "byteStride");
    memcpy(out, bin + whole(view, "byteOffset") + whole(a, "byteOffset") + i * (stride ? stride : 12), 12);
}

static size_t elements(const json_t *root, json_int_t accessor)
{
    return (size_t)whole(json_array_get(json_object_get(root, "accessors"), (size_t)accessor), "count");
}

static const json_t *primitive_of(const json_t *root, size_t mesh)
{
    const json_t *m = json_array_get(json_object_get(root, "meshes"), mesh);
    return json_array_get(json_object_get(m, "primitives"), 0);
}

static json_int_t position_of(const json_t *attributes)
{
    return whole(attributes, "POSITION");
}

// Three frames: two targets. The first frame and a target are the still texture of that time.
static void targets(void **state)
{
    (void)state;
    char square[PATH_BYTES], film[PATH_BYTES], still[PATH_BYTES], *files[2];
    const unsigned char *bin[2];
    write_square(square);
    test_tmp_path(film, "film.glb"), test_tmp_path(still, "still.glb");
    assert_int_equal(
        run("animate '%s' %s --vary 'offset=0.3*u*{t}' --frames 3 --seconds 4 -o '%s'", square, texture, film), 0);
    assert_int_equal(run("animate '%s' %s --vary 'offset=0.3*u*0.5' --frames 1 -o '%s'", square, texture, still), 0);
    json_t *root = open_glb(&files[0], &bin[0], film), *other = open_glb(&files[1], &bin[1], still);

    const json_t *p = primitive_of(root, 0), *q = primitive_of(other, 0), *list = json_object_get(p, "targets");
    assert_int_equal(json_array_size(list), 2);
    assert_null(json_object_get(q, "targets"));
    json_int_t base = position_of(json_object_get(p, "attributes")), move = position_of(json_array_get(list, 0)),
               then = position_of(json_object_get(q, "attributes"));
    size_t n = elements(root, base);
    assert_true(n > 0 && elements(root, move) == n && elements(other, then) == n);
    float most = 0;
    for (size_t i = 0; i < n; i++) {
        float a[3], b[3], c[3];
        element(a, root, bin[0], base, i), element(b, root, bin[0], move, i), element(c, other, bin[1], then, i);
        for (int k = 0; k < 3; k++) { // three roundings to float of coordinates up to 4, or 1 in height
            assert_true(a[k] + b[k] - c[k] <= 1e-6f && a[k] + b[k] - c[k] >= -1e-6f);
            most = b[k] > most ? b[k] : most;
        }
    }
    assert_true(most > 0.05f);

    const json_t *animation = json_array_get(json_object_get(root, "animations"), 0);
    const json_t *channel = json_array_get(json_object_get(animation, "channels"), 0);
    const json_t *sampler = json_array_get(json_object_get(animation, "samplers"), (size_t)whole(channel, "sampler"));
    assert_string_equal(json_string_value(json_object_get(json_object_get(channel, "target"), "path")), "weights");
    assert_int_equal(elements(root, whole(sampler, "input")), 3);
    assert_int_equal(elements(root, whole(sampler, "output")), 6);
    float times[3], weights[3];
    element(times, root, bin[0], whole(sampler, "input"), 0);
    assert_true(times[0] == 0 && times[1] == 2 && times[2] == 4);
    element(weights, root, bin[0], whole(sampler, "output"), 0); // 0 0 | 1 0 | 0 1
    assert_true(weights[0] == 0 && weights[1] == 0 && weights[2] == 1);
    json_decref(root), json_decref(other);
    free(files[0]), free(files[1]);
}

// One mesh becomes another one of other triangles; a mesh with a hole does not.
static void metamorphosis(void **state)
{
    (void)state;
    static const char four[] = "v .2 .2 0\nv .8 .2 0\nv .2 .8 0\nv .2 .2 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    static const char six[] =
        "v .9 .5 .5\nv .1 .5 .5\nv .5 .9 .5\nv .5 .1 .5\nv .5 .5 1\nv .5 .5 0\nf 1 3 5\nf 3 2 5\n"
        "f 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";
    char square[PATH_BYTES], a[PATH_BYTES], b[PATH_BYTES], out[PATH_BYTES], *file;
    const unsigned char *bin;
    write_square(square);
    test_tmp_path(a, "four.obj"), test_tmp_path(b, "six.obj"), test_tmp_path(out, "morph.glb");
    test_write_file(a, four, strlen(four)), test_write_file(b, six, strlen(six));
    static const char what[] =
        "animate '%s' --tile '%s' --morph '%s' --count 2,1 --vary 'morph={t}' --frames 3 -q -o '%s'";
    assert_int_equal(run(what, square, a, b, out), 0);
    json_t *root = open_glb(&file, &bin, out);
    assert_int_equal(json_array_size(json_object_get(primitive_of(root, 0), "targets")), 2);
    json_decref(root);
    free(file);
    test_write_file(b, six, strlen(six) - 8); // without its last triangle
    assert_int_equal(run(what, square, a, b, out), 3);
}

// The same bytes each time, and pictures numbered from 1.
static void pictures(void **state)
{
    (void)state;
    char square[PATH_BYTES], out[PATH_BYTES], path[PATH_BYTES + 16], *bytes[2];
    size_t n[2];
    write_square(square);
    test_tmp_path(out, "film.png");
    for (int k = 0; k < 2; k++) {
        assert_int_equal(
            run("animate '%s' %s --vary 'offset=0.2*{t}' --frames 2 --picture-width 48 --picture-height 32 "
                "--samples 1 -j %d -o '%s'",
                square, texture, k + 1, out),
            0);
        snprintf(path, sizeof path, "%.*s-0003.png", (int)strlen(out) - 4, out);
        assert_false(exists(path));
        snprintf(path, sizeof path, "%.*s-0002.png", (int)strlen(out) - 4, out);
        assert_true(exists(path));
        bytes[k] = test_read_file(path, &n[k]);
    }
    assert_true(n[0] == n[1]);
    assert_memory_equal(bytes[0], bytes[1], n[0]);
    free(bytes[0]), free(bytes[1]);
}

// Tips that are a point in some frames and nearly one in others, and frames that need finer meshes than the first:
// all frames have the same triangles.
static void alike(void **state)
{
    (void)state;
    char square[PATH_BYTES], film[PATH_BYTES];
    write_square(square);
    test_tmp_path(film, "thorn.glb");
    assert_int_equal(
        run("animate '%s' --tile thorn --count 2,2 --vary 'bend=0.8*sin(6.28*{t}+3*x)' --frames 3 -o '%s'", square,
            film),
        0);
    assert_int_equal(
        run("animate '%s' --tile bump --count 2,2 --vary 'height=4*{t}' --frames 3 --json -o '%s'", square, film), 0);
    assert_non_null(strstr(printed, "\"frames\": 3"));
    char *file;
    const unsigned char *bin;
    json_t *root = open_glb(&file, &bin, film);
    assert_int_equal(json_array_size(json_object_get(primitive_of(root, 0), "targets")), 2);
    json_decref(root);
    free(file);
}

// Layers lie on each other, and those that are only a base are not drawn.
static void layers(void **state)
{
    (void)state;
    char square[PATH_BYTES], recipe[PATH_BYTES], film[PATH_BYTES], *file;
    const unsigned char *bin;
    write_square(square);
    test_tmp_path(recipe, "layers.json"), test_tmp_path(film, "layers.glb");
    FILE *f = fopen(recipe, "w");
    assert_non_null(f);
    fprintf(f,
            "{\"format\": 1, \"base\": \"%s\", \"layers\": ["
            "{\"name\": \"a\", \"tile\": \"straight\", \"count\": 2, \"base_only\": true, \"direction\": [0,0,1]},"
            "{\"on\": \"a\", \"tile\": \"straight\", \"count\": 1, \"height\": 0.1, \"direction\": [0,0,1],"
            " \"vary\": {\"offset\": \"{t}\"}}]}",
            square);
    assert_int_equal(fclose(f), 0);
    assert_int_equal(run("animate '%s' --frames 2 -o '%s'", recipe, film), 0);
    json_t *root = open_glb(&file, &bin, film);
    assert_int_equal(json_array_size(json_object_get(root, "meshes")), 1);
    json_t *accessor = json_array_get(json_object_get(root, "accessors"),
                                      (size_t)position_of(json_object_get(primitive_of(root, 0), "attributes")));
    // 4 cells of 3 patches are the base: 12 times as many patches as over the square
    assert_true(whole(accessor, "count") >= (json_int_t)12 * 3 * 4);
    json_decref(root);
    free(file);
}

#endif

static void refusals(void **state)
{
    (void)state;
    assert_int_equal(run("animate"), 2);
    assert_non_null(strstr(complained, "BASE"));
    assert_int_equal(run("animate a.g2 --tile bump"), 2);
    assert_non_null(strstr(complained, "-o OUT is missing"));
    assert_int_equal(run("animate a.g2 --tile bump -o film.stl"), 2);
    assert_non_null(strstr(complained, "film.stl"));
    assert_int_equal(run("animate a.g2 --tile bump --picture-width 81 -o film.mp4"), 2);
    assert_non_null(strstr(complained, "even"));
    assert_int_equal(run("animate a.g2 b.g2"), 2);
    assert_int_equal(run("animate a.g2 --frames 0"), 2);
    assert_int_equal(run("animate a.g2 --seconds 0"), 2);
    assert_int_equal(run("animate nowhere.g2 --tile bump -o film.glb"), 3);
    assert_int_equal(run("animate --help"), 0);
    assert_non_null(strstr(printed, "{t}"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#if KN_WITH_EMBREE && KN_WITH_PNG && KN_WITH_TINYGLTF
        cmocka_unit_test(targets),
        cmocka_unit_test(metamorphosis),
        cmocka_unit_test(pictures),
        cmocka_unit_test(alike),
        cmocka_unit_test(layers),
#endif
        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests_name("cli/animate", tests, NULL, NULL);
}
