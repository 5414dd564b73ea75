// SPDX-License-Identifier: Apache-2.0
// POV-Ray scenes: what they say, and a small picture by POV-Ray where it is installed.
#include "tests/write/world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

static size_t count_of(const char *text, const char *what)
{
    size_t n = 0;
    for (const char *at = text; (at = strstr(at, what)); at += strlen(what)) n++;
    return n;
}

static void what_becomes_of_patches(void **state)
{
    (void)state;
    world w;
    world_make(&w, "scene.pov");
    char *text = world_write(&w, kn_pov_sink, 0, PATCHES, 3, NULL);
    size_t pieces = (size_t)kn_spline_spans(&w.spline[5], 0) * (size_t)kn_spline_spans(&w.spline[5], 1);
    assert_int_equal(count_of(text, "bicubic_patch {"), 2 + pieces); // 2 and 3 are rational
    assert_int_equal(count_of(text, "mesh2 {"), 4);
    assert_int_equal(count_of(text, "sphere_sweep {"), 1);
    assert_int_equal(count_of(text, "#declare Part_"), 3);
    assert_non_null(strstr(text, "#declare Part_1 = texture { pigment { color rgb <0.5,0.5,0.125> }"));
    // The control points of a bicubic patch in rows: of (3, 2) the middle of 2 is elevated.
    double p[3];
    const kn_bezier *b = &w.patch[0].bezier;
    const char *at = strstr(text, "bicubic_patch {");
    at = strchr(at, '<');
    assert_int_equal(sscanf(at, "<%lf,%lf,%lf>", &p[0], &p[1], &p[2]), 3);
    for (int c = 0; c < 3; c++) assert_true(fabs(p[c] - b->coef[12 * c]) <= 0.51e-8 * fabs(p[c]));
    at = strchr(at + 1, '<');
    assert_int_equal(sscanf(at, "<%lf,%lf,%lf>", &p[0], &p[1], &p[2]), 3);
    for (int c = 0; c < 3; c++)
        assert_true(fabs(p[c] - (b->coef[12 * c] + 2 * b->coef[12 * c + 1]) / 3) <= 1e-8 * (1 + fabs(p[c])));
    free(text);
    world_clear(&w);
}

// The spread of the green of all pixels of a picture in binary PPM.
static double spread(const char *path)
{
    int width, height, most, n = 0;
    double sum = 0, squares = 0;
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    assert_int_equal(fgetc(f), 'P');
    assert_int_equal(fgetc(f), '6');
    for (int c; (c = fgetc(f)) == '\n' || c == '#';) // comments may stand before the numbers
        while (c == '#' && fgetc(f) != '\n') {
        }
    (void)fseek(f, -1, SEEK_CUR);
    assert_int_equal(fscanf(f, "%d %d %d", &width, &height, &most), 3);
    assert_true(width == 96 && height == 72 && most == 255);
    fgetc(f);
    for (; n < width * height; n++) {
        int rgb[3];
        for (int c = 0; c < 3; c++) rgb[c] = fgetc(f);
        assert_true(rgb[2] != EOF);
        sum += rgb[1], squares += (double)rgb[1] * rgb[1];
    }
    fclose(f);
    return sqrt(squares / n - sum / n * sum / n);
}

static void a_picture(void **state)
{
    (void)state;
    world w;
    char command[3 * TEST_PATH_BYTES], picture[TEST_PATH_BYTES];
    world_make(&w, "picture.pov");
    test_tmp_path(picture, "picture.ppm");
    free(world_write(&w, kn_pov_sink, 0, 4, 2, NULL));
    (void)snprintf(command, sizeof command,
                   "command -v povray >/dev/null || exit 77; povray -D +FP +W96 +H72 '+I%s' '+O%s' >/dev/null 2>&1",
                   w.path, picture);
    int how = system(command);
    bool there = WIFEXITED(how) && WEXITSTATUS(how) != 77;
    if (there) {
        assert_true(WIFEXITED(how) && WEXITSTATUS(how) == 0);
        assert_true(spread(picture) > 8); // of 256: something stands before the floor
    }
    free(world_write(&w, kn_pov_sink, 0, 0, 1, NULL)); // nothing: the floor alone
    if (there) assert_int_equal(system(command), 0);
    remove(picture);
    world_clear(&w);
    if (there) return;
    print_message("skipped: no povray\n");
    skip();
}

static void refusals(void **state)
{
    (void)state;
    world w;
    kn_sink sink = {0};
    world_make(&w, "refused.pov");
    assert_int_equal(kn_pov_sink(w.ctx, &sink, "/nowhere/x.pov"), KN_EIO);
    w.patch[3].look = 3;
    world_refused(&w, kn_pov_sink, 0, PATCHES, "part 3, of 3");
    w.patch[3].look = 0;
    world_without_memory(&w, kn_pov_sink, 2, 4);
    world_clear(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_becomes_of_patches),
        cmocka_unit_test(a_picture),
        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests_name("write/pov", tests, NULL, NULL);
}
