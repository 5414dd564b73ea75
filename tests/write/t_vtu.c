// SPDX-License-Identifier: Apache-2.0
// VTK files of Bezier cells: arrays as they are stored, the order of points, and what VTK itself makes of them where it
// is installed (Debian: python3-vtk9).
#include "tests/write/world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

// ---- arrays ----

static int digit(char c)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *at = memchr(digits, c, 64);
    assert_non_null(at);
    return (int)(at - digits);
}

// The bytes of the array of this name, the first one after `text`, for free; the eight before them are their number.
static unsigned char *array(const char *text, const char *name, size_t *bytes)
{
    char key[64];
    (void)snprintf(key, sizeof key, "Name=\"%s\"", name);
    const char *at = strstr(text, key);
    assert_non_null(at);
    at = strchr(at, '>') + 1;
    size_t n = (size_t)(strchr(at, '<') - at), m = 0;
    assert_int_equal(n % 4, 0);
    unsigned char *out = malloc(n);
    assert_non_null(out);
    for (size_t i = 0; i < n; i += 4) {
        int pad = (at[i + 3] == '=') + (at[i + 2] == '=');
        uint32_t bits = 0;
        for (int k = 0; k < 4; k++) bits = bits << 6 | (uint32_t)(k >= 4 - pad ? 0 : digit(at[i + (size_t)k]));
        for (int k = 0; k < 3 - pad; k++) out[m++] = (unsigned char)(bits >> (16 - 8 * k));
    }
    uint64_t length = 0;
    for (int i = 7; i >= 0; i--) length = length << 8 | out[i];
    assert_int_equal(length, m - 8);
    memmove(out, out + 8, m - 8);
    *bytes = m - 8;
    return out;
}

static double *doubles(const char *text, const char *name, size_t n)
{
    size_t bytes;
    double *x = (double *)(void *)array(text, name, &bytes); // little-endian machines alone run this test's bytes
    assert_int_equal(bytes, n * sizeof *x);
    return x;
}

static int64_t *integers(const char *text, const char *name, size_t n)
{
    size_t bytes;
    int64_t *x = (int64_t *)(void *)array(text, name, &bytes);
    assert_int_equal(bytes, n * sizeof *x);
    return x;
}

// One volume of degrees 2, 2, 2: its 27 points stand in the order of VTK_TRIQUADRATIC_HEXAHEDRON but for the faces, which
// come as -x +x -y +y -z +z in both.
static void order_of_points(void **state)
{
    (void)state;
    static const int order[27][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2},
                                     {0, 2, 2}, {1, 0, 0}, {2, 1, 0}, {1, 2, 0}, {0, 1, 0}, {1, 0, 2}, {2, 1, 2},
                                     {1, 2, 2}, {0, 1, 2}, {0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}, {0, 1, 1},
                                     {2, 1, 1}, {1, 0, 1}, {1, 2, 1}, {1, 1, 0}, {1, 1, 2}, {1, 1, 1}};
    world w;
    world_make(&w, "order.vtu");
    const int degree[3] = {2, 2, 2};
    kn_patch *p = &w.patch[0];
    kn_bezier_clear(w.ctx, &p->bezier);
    assert_int_equal(kn_bezier_init(w.ctx, &p->bezier, 3, 4, true, degree), KN_OK);
    for (int k = 0; k < 27; k++) { // at (i, j, k), weight 1 + index / 32
        int at[3] = {k / 9, k / 3 % 3, k % 3};
        double weight = 1.0 + k / 32.0;
        for (int c = 0; c < 3; c++) p->bezier.coef[27 * c + k] = at[c] * weight;
        p->bezier.coef[81 + k] = weight;
    }
    char *text = world_write(&w, kn_vtu_sink, 0, 1, 1, NULL);
    double *x = doubles(text, "Points", 81), *weight = doubles(text, "RationalWeights", 27);
    double *d = doubles(text, "HigherOrderDegrees", 3);
    int64_t *c = integers(text, "connectivity", 27), *end = integers(text, "offsets", 1);
    for (int i = 0; i < 27; i++) {
        for (int k = 0; k < 3; k++) assert_true(fabs(x[3 * i + k] - order[i][k]) < 1e-15);
        assert_true(weight[i] == 1.0 + (9 * order[i][0] + 3 * order[i][1] + order[i][2]) / 32.0);
        assert_int_equal(c[i], i);
    }
    assert_int_equal(end[0], 27);
    assert_true(d[0] == 2.0 && d[1] == 2.0 && d[2] == 2.0);
    assert_non_null(strstr(text, "<Piece NumberOfPoints=\"27\" NumberOfCells=\"1\">"));
    free(x), free(weight), free(d), free(c), free(end), free(text);
    world_clear(&w);
}

// ---- what VTK says ----

// Cells that the patches become, in order: the pieces of each.
static void compare_cells(world *w, FILE *answers)
{
    static const double at[3][3] = {{0.2, 0.3, 0.7}, {0.9, 0.15, 0.4}, {0.0, 1.0, 0.5}};
    static const int types[4] = {0, 75, 77, 79};
    for (int i = 0; i < PATCHES; i++) {
        kn_spline s;
        kn_bezier *pieces = NULL;
        size_t n = 0;
        world_spline(w, &s, i);
        assert_int_equal(kn_spline_to_bezier(w->ctx, &pieces, &n, &s), KN_OK);
        double largest = 0;
        for (size_t k = 0; k < 3 * kn_spline_count(&s); k++) largest = fmax(largest, fabs(s.coef[k]));
        for (size_t p = 0; p < n; p++) {
            int type, part;
            assert_int_equal(fscanf(answers, "%d %d", &type, &part), 2);
            assert_int_equal(type, types[s.nvars]);
            assert_int_equal(part, i % 3);
            for (int k = 0; k < 3; k++) {
                double x[3], y[3];
                assert_int_equal(fscanf(answers, "%lf %lf %lf", &x[0], &x[1], &x[2]), 3);
                assert_int_equal(kn_bezier_eval(w->ctx, y, &pieces[p], at[k]), KN_OK);
                // sums of at most 24 products of weights, basis functions of 10 roundings each, and points; weights
                // are at least 1 and at most 9: 9 * 100 * 2^-53 of the largest point and some room
                for (int c = 0; c < 3; c++) assert_true(fabs(x[c] - y[c]) <= 1e-12 * largest);
            }
            kn_bezier_clear(w->ctx, &pieces[p]);
        }
        kn_free(w->ctx, pieces);
        kn_spline_clear(w->ctx, &s);
    }
}

static void as_vtk_sees_it(void **state)
{
    (void)state;
    world w;
    char command[2 * TEST_PATH_BYTES];
    world_make(&w, "cells.vtu");
    free(world_write(&w, kn_vtu_sink, 0, PATCHES, 3, NULL)); // three pieces
    (void)snprintf(command, sizeof command, "/usr/bin/python3 tests/write/vtk_eval.py '%s' 2>&1", w.path);
    FILE *answers = popen(command, "r");
    assert_non_null(answers);
    int first = fgetc(answers);
    if (first != EOF && first >= '0' && first <= '9') {
        ungetc(first, answers);
        compare_cells(&w, answers);
        assert_int_equal(pclose(answers), 0);
        world_clear(&w);
        return;
    }
    int how = pclose(answers);
    world_clear(&w);
    assert_true(WIFEXITED(how) && (WEXITSTATUS(how) == 77 || WEXITSTATUS(how) == 127));
    print_message("skipped: no VTK 9.1 for /usr/bin/python3 (python3-vtk9)\n");
    skip();
}

// Trimmed surfaces and meshes are triangles; one block is one piece, whatever comes before it.
static void triangles_too(void **state)
{
    (void)state;
    world w;
    kn_trim trim;
    kn_mesh mesh = {0};
    size_t bytes;
    world_make(&w, "mixed.vtu");
    world_make_trim(&w, &trim);
    w.patch[0].trim = &trim;
    assert_int_equal(kn_patch_tessellate(w.ctx, &mesh, &w.patch[0]), KN_OK);
    kn_patch kept = w.patch[1];
    w.patch[1] = (kn_patch){.mesh = &mesh, .look = 2};
    char *text = world_write(&w, kn_vtu_sink, 0, 3, 3, NULL);
    unsigned char *types = array(text, "types", &bytes);
    assert_int_equal(bytes, 2 * mesh.ntriangles + 1);
    for (size_t i = 0; i < bytes; i++) assert_int_equal(types[i], i + 1 < bytes ? 5 : 77);
    double *x = doubles(text, "Points", 3 * (2 * mesh.nvertices + 12));
    assert_memory_equal(x, mesh.position, 3 * mesh.nvertices * sizeof *x);
    int64_t *c = integers(text, "connectivity", 6 * mesh.ntriangles + 12);
    for (size_t i = 0; i < 3 * mesh.ntriangles; i++) {
        assert_int_equal(c[i], mesh.triangle[i]);
        assert_int_equal(c[3 * mesh.ntriangles + i], mesh.nvertices + mesh.triangle[i]);
    }
    free(x), free(c), free(types), free(text);
    w.patch[1] = kept;
    kn_mesh_clear(w.ctx, &mesh);
    kn_trim_clear(w.ctx, &trim);
    world_clear(&w);
}

// A grid of no cells is a piece of none, which VTK reads.
static void nothing(void **state)
{
    (void)state;
    world w;
    char command[2 * TEST_PATH_BYTES];
    world_make(&w, "none.vtu");
    char *text = world_write(&w, kn_vtu_sink, 0, 0, 1, NULL);
    const char *piece = strstr(text, "<Piece NumberOfPoints=\"0\" NumberOfCells=\"0\">");
    assert_non_null(piece);
    assert_null(strstr(piece + 1, "<Piece "));
    free(text);
    (void)snprintf(command, sizeof command, "/usr/bin/python3 tests/write/vtk_eval.py '%s' 2>&1", w.path);
    FILE *answers = popen(command, "r");
    assert_non_null(answers);
    int first = fgetc(answers), how = pclose(answers);
    if (WIFEXITED(how) && WEXITSTATUS(how) == 0) assert_int_equal(first, EOF); // neither a cell nor a complaint
    world_clear(&w);
}

static void refusals(void **state)
{
    (void)state;
    world w;
    kn_sink sink = {0};
    world_make(&w, "refused.vtu");
    assert_int_equal(kn_vtu_sink(w.ctx, &sink, "/nowhere/x.vtu"), KN_EIO);
    w.patch[1].look = -1;
    world_refused(&w, kn_vtu_sink, 0, 2, "part -1, of 3");
    world_without_memory(&w, kn_vtu_sink, 4, 3);
    world_clear(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(order_of_points), cmocka_unit_test(as_vtk_sees_it), cmocka_unit_test(triangles_too),
        cmocka_unit_test(nothing),         cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests_name("write/vtu", tests, NULL, NULL);
}
