// SPDX-License-Identifier: Apache-2.0
// Colours by a field on the command line: which cell has which material in OBJ, recipes, and what is refused.
#include "tests/cli/command.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char square[] = "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n6 0 0\n0 6 0\n6 6 0\n";

static void make_square(char path[PATH_BYTES])
{
    test_tmp_path(path, "square.g2");
    write_text(path, square);
}

// Calls line for each line of a file, up to its end, which is cut off.
static void each_line(const char *path, void (*line)(void *user, char *text), void *user)
{
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    char text[512];
    while (fgets(text, sizeof text, file)) {
        text[strcspn(text, "\n")] = '\0';
        line(user, text);
    }
    fclose(file);
}

typedef struct materials {
    double kd[64][3];
    int count;
} materials;

static void take_material(void *user, char *text)
{
    materials *m = user;
    if (strncmp(text, "newmtl ", 7) == 0) assert_true(++m->count < 64);
    if (strncmp(text, "Kd ", 3) != 0) return;
    char *at = text + 3;
    for (int c = 0; c < 3; c++) m->kd[m->count - 1][c] = strtod(at, &at);
}

typedef struct groups {
    double x[4096]; // of vertices
    int count, current, triangles[8], columns;
} groups;

// usemtl NAME.K; a triangle of the cells in column i of `columns` has its material K = i.
static void take_face(void *user, char *text)
{
    groups *g = user;
    if (strncmp(text, "usemtl ", 7) == 0) g->current = atoi(strrchr(text, '.') + 1);
    if (strncmp(text, "v ", 2) == 0) {
        assert_true(g->count < 4096);
        g->x[g->count++] = strtod(text + 2, NULL);
    }
    if (strncmp(text, "f ", 2) != 0) return;
    double middle = 0;
    char *at = text + 2;
    for (int k = 0; k < 3; k++) {
        long v = strtol(at, &at, 10);
        if (v < 0) v += g->count + 1; // counted back from the last one
        assert_true(v >= 1 && v <= g->count);
        middle += g->x[v - 1] / 3;
        at += strcspn(at, " ");
    }
    assert_int_equal(g->current, (int)floor(middle / 6 * g->columns));
    g->triangles[g->current]++;
}

static void which_cell_has_which(void **state)
{
    (void)state;
    char base[PATH_BYTES], obj[PATH_BYTES], mtl[PATH_BYTES];
    make_square(base);
    test_tmp_path(obj, "steps.obj"), test_tmp_path(mtl, "steps.mtl");
    assert_int_equal(run("apply '%s' --tile bump --count 4 --height 1 --tol 0.5 --color u --palette '#000,ffffff' "
                         "--color-steps 4 -q -o '%s'",
                         base, obj),
                     0);
    materials m = {.count = 0};
    groups g = {.columns = 4, .current = -1};
    each_line(mtl, take_material, &m);
    each_line(obj, take_face, &g);
    assert_int_equal(m.count, 4);
    for (int k = 0; k < 4; k++) {
        assert_true(g.triangles[k] > 0 && g.triangles[k] == g.triangles[0]);
        for (int c = 0; c < 3; c++) assert_true(fabs(m.kd[k][c] - k / 3.0) <= 5e-6); // written with six digits
    }
    remove(obj), remove(mtl);
}

static size_t slurp_all(const char *path, char **bytes)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    size_t size = (size_t)ftell(file);
    rewind(file);
    *bytes = malloc(size);
    assert_non_null(*bytes);
    assert_int_equal(fread(*bytes, 1, size, file), size);
    fclose(file);
    return size;
}

// A recipe says the same, and threads do not matter.
static void recipe(void **state)
{
    (void)state;
    char base[PATH_BYTES], path[PATH_BYTES], out[2][PATH_BYTES], *bytes[2];
    make_square(base);
    test_tmp_path(path, "colors.json"), test_tmp_path(out[0], "a.step"), test_tmp_path(out[1], "b.step");
    char text[TEXT_BYTES];
    snprintf(text, sizeof text,
             "{\"format\": 1, \"base\": \"%s\", \"layers\": [{\"tile\": \"chain\", \"count\": 3, \"height\": 1, "
             "\"color\": \"0.5+noise(x,y,z)\", \"palette\": [\"102030\", \"#fed\"], \"color_steps\": 5, "
             "\"color_part\": [\"ring\"]}]}",
             base);
    write_text(path, text);
    assert_int_equal(run("apply '%s' -j 2 -q -o '%s'", path, out[0]), 0);
    assert_int_equal(run("apply '%s' --tile chain --count 3 --height 1 --color '0.5+noise(x,y,z)' --palette "
                         "102030,fed --color-steps 5 --color-part ring -j 1 -q -o '%s'",
                         base, out[1]),
                     0);
    size_t size[2] = {slurp_all(out[0], &bytes[0]), slurp_all(out[1], &bytes[1])};
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(bytes[0], bytes[1], size[0]);
    for (int i = 0; i < 2; i++) free(bytes[i]), remove(out[i]);
}

static void what_is_refused(void **state)
{
    (void)state;
    static const struct {
        const char *options, *says;
        int code;
    } wrong[] = {{"--palette gold", "--color", 2},
                 {"--color u --palette blurple", "copper", 2},
                 {"--color u --palette 12345,fff", "rrggbb", 2},
                 {"--color u --palette 12345g", "rrggbb", 2},
                 {"--color u --palette fff,", "rrggbb", 2},
                 {"--color u --color-steps 0", "--color-steps", 2},
                 {"--color u --color-steps 257", "--color-steps", 2},
                 {"--color u --color-part ,", "--color-part", 2},
                 {"--color u --color-part lid", "\"lid\"", 3},
                 {"--color 'u+'", "--color", 3}};
    char base[PATH_BYTES], out[PATH_BYTES];
    make_square(base);
    test_tmp_path(out, "none.obj");
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_int_equal(run("apply '%s' --tile bump --count 2 -q -o '%s' %s", base, out, wrong[i].options),
                         wrong[i].code);
        assert_non_null(strstr(complained, wrong[i].says));
        assert_false(exists(out));
    }
    // check has an option of its own with this name
    assert_int_equal(run("check '%s' --height 1 --color jacobian -q", base), 0);
    assert_int_equal(run("check '%s' --height 1 --color u -q", base), 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(which_cell_has_which), cmocka_unit_test(recipe),
                                       cmocka_unit_test(what_is_refused)};
    return cmocka_run_group_tests_name("cli/color", tests, NULL, NULL);
}
