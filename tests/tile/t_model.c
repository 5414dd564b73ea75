// SPDX-License-Identifier: Apache-2.0
// What a tile can hold: curves, surfaces, trimmed ones, volumes, meshes, parameters; copies, values, checks.
#include "tests/support/scene.h"
#include "tests/support/support.h"

#include <knurl/construct.h>
#include <knurl/tile.h>

#include <float.h>
#include <math.h>
#include <string.h>

// The unit cube scaled and moved; left-handed: u and v exchanged.
static void make_cube(kn_ctx *ctx, kn_spline *out, double u, double v, double w, double size, bool left_handed)
{
    double corner[24];
    for (int i = 0; i < 8; i++) {
        double x = i >> 2 & 1, y = i >> 1 & 1, z = i & 1;
        corner[3 * i] = u + size * (left_handed ? y : x);
        corner[3 * i + 1] = v + size * (left_handed ? x : y);
        corner[3 * i + 2] = w + size * z;
    }
    scene_multilinear(ctx, out, 3, corner);
}

static const double LINE[6] = {0.25, 0.5, 0, 0.75, 0.5, 1};
static const double SHEET[12] = {0, 0, 0, 0, 1, 0, 1, 0, 0.5, 1, 1, 0.5};

// The triangle (0,0), (1,0), (0,1) of a surface's domain.
static void make_triangle(kn_ctx *ctx, kn_trim *out)
{
    const double corner[4][2] = {{0, 0}, {1, 0}, {0, 1}, {0, 0}};
    const int degree = 1;
    kn_spline curves[3] = {{0}}; // of a view, which is then copied
    int loop_end = 3;
    kn_trim view = {.curves = curves, .ncurves = 3, .loop_end = &loop_end, .nloops = 1};
    for (int k = 0; k < 3; k++) {
        kn_bezier b = {0};
        assert_int_equal(kn_bezier_init(ctx, &b, 1, 2, false, &degree), KN_OK);
        for (int c = 0; c < 2; c++)
            for (int i = 0; i < 2; i++) b.coef[2 * c + i] = corner[k + i][c];
        assert_int_equal(kn_spline_of_bezier(ctx, &curves[k], &b), KN_OK);
        kn_bezier_clear(ctx, &b);
    }
    *out = (kn_trim){0};
    assert_int_equal(kn_trim_copy(ctx, out, &view), KN_OK);
    for (int k = 0; k < 3; k++) kn_spline_clear(ctx, &curves[k]);
}

// A tetrahedron; its arrays are static.
static kn_mesh tetrahedron(void)
{
    static double position[12] = {0.25, 0.25, 0, 0.75, 0.25, 0, 0.5, 0.75, 0, 0.5, 0.5, 0.5};
    static uint32_t triangle[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    return (kn_mesh){.nvertices = 4, .ntriangles = 4, .position = position, .triangle = triangle};
}

// Part 0 "metal": a curve, a sheet, a trimmed sheet, a volume; part 1 "glass": a mesh. Parameter "lift" moves the
// sheet and the mesh up by 1 at 3, parameter "bend" the sheet's last corner only.
static kn_status make_all(kn_ctx *ctx, kn_tile *out, const kn_spline *kinds, const kn_trim *trim)
{
    kn_mesh mesh = tetrahedron();
    kn_spline target = {0};
    double lifted[12];
    kn_status status = kn_tile_init(ctx, out, "all", 2);
    if (status != KN_OK) return status;
    strcpy(out->parts[0].name, "metal");
    strcpy(out->parts[1].name, "glass");
    status = kn_tile_add(ctx, out, 0, &kinds[0]);
    if (status == KN_OK) status = kn_tile_add(ctx, out, 0, &kinds[1]);
    if (status == KN_OK) status = kn_tile_add_parameter(ctx, out, "lift", 1, 3, 0, 5);
    if (status == KN_OK) status = kn_spline_copy(ctx, &target, &kinds[1]);
    for (int i = 0; status == KN_OK && i < 4; i++) target.coef[8 + i] += 1;
    if (status == KN_OK) status = kn_tile_set_target(ctx, out, 0, 0, 1, &target);
    if (status == KN_OK) status = kn_tile_add_trimmed(ctx, out, 0, &kinds[1], trim); // after a target is there
    if (status == KN_OK) status = kn_tile_add(ctx, out, 0, &kinds[2]);
    if (status == KN_OK) status = kn_tile_set_mesh(ctx, out, 1, &mesh);
    for (int i = 0; i < 12; i++) lifted[i] = mesh.position[i] + (i % 3 == 2);
    if (status == KN_OK) status = kn_tile_set_mesh_target(ctx, out, 0, 1, lifted);
    if (status == KN_OK) status = kn_tile_add_parameter(ctx, out, "bend", 0, 1, -1, 1); // after targets are there
    for (int i = 0; status == KN_OK && i < 4; i++) target.coef[8 + i] = kinds[1].coef[8 + i] + (i == 3 ? 0.25 : 0);
    if (status == KN_OK) status = kn_tile_set_target(ctx, out, 1, 0, 1, &target);
    kn_spline_clear(ctx, &target);
    return status;
}

typedef struct fixture {
    kn_spline kinds[3];
    kn_trim trim;
} fixture;

static void fixture_make(kn_ctx *ctx, fixture *f)
{
    *f = (fixture){0};
    scene_multilinear(ctx, &f->kinds[0], 1, LINE);
    scene_multilinear(ctx, &f->kinds[1], 2, SHEET);
    make_cube(ctx, &f->kinds[2], 0.25, 0.25, 0, 0.5, false);
    make_triangle(ctx, &f->trim);
}

static void fixture_clear(kn_ctx *ctx, fixture *f)
{
    for (int k = 0; k < 3; k++) kn_spline_clear(ctx, &f->kinds[k]);
    kn_trim_clear(ctx, &f->trim);
}

static void same_spline(const kn_spline *a, const kn_spline *b)
{
    assert_int_equal(a->nvars, b->nvars);
    assert_int_equal(kn_spline_count(a), kn_spline_count(b));
    assert_memory_equal(a->coef, b->coef, (size_t)a->ncomp * kn_spline_count(a) * sizeof(double));
}

static void holds_all_kinds(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    fixture f;
    kn_tile tile = {0}, copy = {0};
    fixture_make(ctx, &f);
    assert_int_equal(make_all(ctx, &tile, f.kinds, &f.trim), KN_OK);
    assert_int_equal(kn_tile_check(ctx, &tile), KN_OK);
    assert_int_equal(kn_tile_copy(ctx, &copy, &tile), KN_OK);
    const int kind[4] = {0, 1, 1, 2};
    for (int t = 0; t < 2; t++) {
        const kn_tile *at = t == 0 ? &tile : &copy;
        assert_int_equal(at->parts[0].nsplines, 4);
        for (int k = 0; k < 4; k++) {
            same_spline(&at->parts[0].splines[k], &f.kinds[kind[k]]);
            assert_int_equal(at->parts[0].trims[k].nloops, k == 2 ? 1 : 0);
            for (int p = 0; p < 2; p++) assert_true((at->parts[0].targets[4 * p + k].coef != NULL) == (k == 1));
        }
        same_spline(&at->parts[0].trims[2].curves[1], &f.trim.curves[1]);
        assert_true(at->parts[1].mesh.ntriangles == 4 && at->parts[1].mesh.triangle[10] == 0);
        assert_true(at->parts[1].mesh_targets[0][11] == 1.5 && at->parts[1].mesh_targets[1] == NULL);
        assert_int_equal(at->nparameters, 2);
        assert_string_equal(at->parameters[1].name, "bend");
        assert_string_equal(at->parts[1].name, "glass");
    }
    kn_mesh other = tetrahedron();
    other.ntriangles = 2;
    assert_int_equal(kn_tile_set_mesh(ctx, &copy, 1, &other), KN_OK); // targets go with the mesh
    assert_true(copy.parts[1].mesh.ntriangles == 2 && !copy.parts[1].mesh_targets);
    assert_int_equal(kn_tile_check(ctx, &copy), KN_OK);
    kn_tile_clear(ctx, &tile), kn_tile_clear(ctx, &copy);
    fixture_clear(ctx, &f);
    test_ctx_end(ctx, &memory);
}

// P + sum of (x - value) / (target - value) (P at the target - P), numbers that are exact here.
static void values_of_parameters(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    fixture f;
    kn_tile tile = {0}, out = {0};
    fixture_make(ctx, &f);
    assert_int_equal(make_all(ctx, &tile, f.kinds, &f.trim), KN_OK);
    const double values[4][2] = {{1, 0}, {3, 0}, {2, -1}, {7, 0.5}}; // the last beyond its range, which ends at 5
    const double lift[4] = {0, 1, 0.5, 2}, bend[4] = {0, 0, -0.25, 0.125};
    for (int k = 0; k < 4; k++) {
        assert_int_equal(kn_tile_vary(ctx, &out, &tile, values[k]), KN_OK);
        assert_int_equal(out.nparameters, 0);
        assert_true(!out.parts[0].targets && !out.parts[1].mesh_targets);
        for (int i = 0; i < 4; i++)
            assert_true(out.parts[0].splines[1].coef[8 + i] == SHEET[3 * i + 2] + lift[k] + (i == 3 ? bend[k] : 0));
        assert_true(out.parts[1].mesh.position[11] == 0.5 + lift[k]);
        assert_true(out.parts[1].mesh.position[10] == 0.5);
        same_spline(&out.parts[0].splines[2], &f.kinds[1]); // no target
        assert_int_equal(kn_tile_check(ctx, &out), KN_OK);
        kn_tile_clear(ctx, &out);
    }
    const double bad[2] = {1, INFINITY};
    out.nparts = 77;
    assert_int_equal(kn_tile_vary(ctx, &out, &tile, bad), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "bend"));
    tile.parameters[1].target = 0; // its value
    assert_int_equal(kn_tile_vary(ctx, &out, &tile, values[0]), KN_EDOMAIN);
    assert_int_equal(out.nparts, 77);
    kn_tile_clear(ctx, &tile);
    fixture_clear(ctx, &f);
    test_ctx_end(ctx, &memory);
}

static void refusals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    fixture f;
    kn_tile tile = {0};
    kn_mesh mesh = tetrahedron();
    fixture_make(ctx, &f);
    assert_int_equal(make_all(ctx, &tile, f.kinds, &f.trim), KN_OK);
    assert_int_equal(kn_tile_add_trimmed(ctx, &tile, 0, &f.kinds[0], &f.trim), KN_EDOMAIN);
    assert_int_equal(kn_tile_add_trimmed(ctx, &tile, 2, &f.kinds[1], &f.trim), KN_EDOMAIN);
    assert_int_equal(kn_tile_set_mesh(ctx, &tile, 2, &mesh), KN_EDOMAIN);
    assert_int_equal(kn_tile_set_target(ctx, &tile, 2, 0, 0, &f.kinds[0]), KN_EDOMAIN);
    assert_int_equal(kn_tile_set_target(ctx, &tile, 0, -1, 0, &f.kinds[0]), KN_EDOMAIN);
    assert_int_equal(kn_tile_set_target(ctx, &tile, 0, 0, 4, &f.kinds[0]), KN_EDOMAIN);
    assert_int_equal(kn_tile_set_target(ctx, &tile, 0, 0, 0, &f.kinds[1]), KN_EDOMAIN);
    assert_int_equal(kn_tile_set_mesh_target(ctx, &tile, 0, 0, mesh.position), KN_EDOMAIN);
    assert_int_equal(kn_tile_set_mesh_target(ctx, &tile, -1, 1, mesh.position), KN_EDOMAIN);
    char longest[KN_NAME_BYTES + 1] = {0};
    memset(longest, 'x', KN_NAME_BYTES);
    assert_int_equal(kn_tile_add_parameter(ctx, &tile, longest, 0, 1, 0, 1), KN_ELIMIT);
    assert_true(tile.parts[0].nsplines == 4 && tile.nparameters == 2 && !tile.parts[0].targets[0].coef);
    kn_tile_clear(ctx, &tile);
    fixture_clear(ctx, &f);
    test_ctx_end(ctx, &memory);
}

// One thing wrong at a time, and what the message says of it.
static void check_finds(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    fixture f;
    fixture_make(ctx, &f);
    const char *const says[] = {"curve 0 has no length",
                                "volume 3 has no volume",
                                "volume 3 is left-handed",
                                "surface 2",
                                "curve 0 cannot be trimmed",
                                "vertex 1 of its mesh is not finite",
                                "triangle 2 of its mesh: vertex 4 of 4",
                                "triangle 1 of its mesh has a vertex twice",
                                "two parameters \"lift\"",
                                "parameter 1 has no name",
                                "parameter \"bend\" from 0 to 0",
                                "parameter \"lift\" is 1, not in [2, 5]",
                                "spline 1: the target of \"bend\" is not finite",
                                "the target of \"lift\" for its mesh is not finite",
                                "spline 1: the target of \"lift\" has other degrees or knots"};
    for (size_t k = 0; k < sizeof says / sizeof *says; k++) {
        kn_tile tile = {0};
        assert_int_equal(make_all(ctx, &tile, f.kinds, &f.trim), KN_OK);
        kn_spline *s = tile.parts[0].splines;
        kn_mesh *m = &tile.parts[1].mesh;
        for (size_t i = 0; k == 0 && i < 6; i++) s[0].coef[i] = 0.5;
        for (size_t i = 0; k == 1 && i < 8; i++) s[3].coef[16 + i] = s[3].coef[i];
        for (size_t i = 0; k == 2 && i < 8; i++) {
            double u = s[3].coef[i];
            s[3].coef[i] = s[3].coef[8 + i], s[3].coef[8 + i] = u;
        }
        if (k == 3) tile.parts[0].trims[2].curves[1].coef[0] = 0.75; // does not begin where the one before ends
        if (k == 4) assert_int_equal(kn_trim_copy(ctx, &tile.parts[0].trims[0], &f.trim), KN_OK);
        if (k == 5) m->position[4] = NAN;
        if (k == 6) m->triangle[8] = 4;
        if (k == 7) m->triangle[4] = m->triangle[3];
        if (k == 8) strcpy(tile.parameters[1].name, "lift");
        if (k == 9) tile.parameters[1].name[0] = 0;
        if (k == 10) tile.parameters[1].target = 0;
        if (k == 11) tile.parameters[0].lo = 2;
        if (k == 12) tile.parts[0].targets[5].coef[3] = INFINITY;
        if (k == 13) tile.parts[1].mesh_targets[0][5] = NAN;
        if (k == 14) tile.parts[0].targets[1].knots[0][2] = 0.75;
        kn_ctx_clear_error(ctx);
        assert_int_equal(kn_tile_check(ctx, &tile), KN_EDOMAIN);
        if (!strstr(kn_ctx_message(ctx), says[k])) fail_msg("%s: %s", says[k], kn_ctx_message(ctx));
        kn_tile_clear(ctx, &tile);
    }
    fixture_clear(ctx, &f);
    test_ctx_end(ctx, &memory);
}

// (u, v) -> (1 - v, u) of every coordinate, targets and meshes too.
static void turns_all_kinds(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    fixture f;
    kn_tile tile = {0}, turned = {0};
    fixture_make(ctx, &f);
    assert_int_equal(make_all(ctx, &tile, f.kinds, &f.trim), KN_OK);
    assert_int_equal(make_all(ctx, &turned, f.kinds, &f.trim), KN_OK);
    assert_int_equal(kn_tile_rotate(ctx, &turned, 1), KN_OK);
    for (int k = 0; k < 4; k++)
        for (int target = 0; target < 3; target++) {
            const kn_spline *a = target ? &tile.parts[0].targets[4 * (target - 1) + k] : &tile.parts[0].splines[k];
            const kn_spline *b = target ? &turned.parts[0].targets[4 * (target - 1) + k]
                                        : &turned.parts[0].splines[k];
            size_t n = a->coef ? kn_spline_count(a) : 0;
            for (size_t i = 0; i < n; i++)
                assert_true(b->coef[i] == 1 - a->coef[n + i] && b->coef[n + i] == a->coef[i] &&
                            b->coef[2 * n + i] == a->coef[2 * n + i]);
        }
    for (size_t i = 0; i < 4; i++) {
        const double *a = tile.parts[1].mesh.position + 3 * i, *b = turned.parts[1].mesh.position + 3 * i;
        const double *c = tile.parts[1].mesh_targets[0] + 3 * i, *d = turned.parts[1].mesh_targets[0] + 3 * i;
        assert_true(b[0] == 1 - a[1] && b[1] == a[0] && b[2] == a[2]);
        assert_true(d[0] == 1 - c[1] && d[1] == c[0] && d[2] == c[2]);
    }
    kn_tile_clear(ctx, &tile), kn_tile_clear(ctx, &turned);
    fixture_clear(ctx, &f);
    test_ctx_end(ctx, &memory);
}

// A row of two cubes from u = 0 to u = 1 and a third on the second: they cover each other, and the row itself in the
// next cell.
static void covered_faces(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double corner[4][3] = {{0, 0, 0}, {0.5, 0, 0}, {0.5, 0, 0.5}, {0.25, 0.5, 0.5}}; // the last one: in part
    kn_bezier list[5] = {{0}};
    for (int k = 0; k < 4; k++) {
        kn_spline s = {0};
        kn_bezier *pieces = NULL;
        size_t n;
        make_cube(ctx, &s, corner[k][0], corner[k][1], corner[k][2], 0.5, k == 1); // one of them the other way round
        assert_int_equal(kn_spline_to_bezier(ctx, &pieces, &n, &s), KN_OK);
        list[k] = pieces[0];
        kn_free(ctx, pieces);
        kn_spline_clear(ctx, &s);
    }
    const int curve = 1;
    assert_int_equal(kn_bezier_init(ctx, &list[4], 1, 3, false, &curve), KN_OK); // no volume
    kn_tile_cover cover[30], want[30] = {{0}};
    // cube 1 is left-handed: its variable 0 runs along v, its variable 1 along u
    want[1] = (kn_tile_cover){true, 1, {0, 0}}, want[6 + 2] = (kn_tile_cover){true, 0, {0, 0}};
    want[0] = (kn_tile_cover){true, 1, {-1, 0}}, want[6 + 3] = (kn_tile_cover){true, 0, {1, 0}};
    want[6 + 5] = (kn_tile_cover){true, 2, {0, 0}}, want[12 + 4] = (kn_tile_cover){true, 1, {0, 0}};
    assert_int_equal(kn_tile_cover_faces(ctx, cover, list, 5), KN_OK);
    for (int k = 0; k < 30; k++) {
        assert_true(cover[k].covered == want[k].covered);
        if (!cover[k].covered) continue;
        assert_int_equal(cover[k].by, want[k].by);
        assert_int_equal(cover[k].cell[0], want[k].cell[0]);
        assert_int_equal(cover[k].cell[1], want[k].cell[1]);
    }
    for (int k = 0; k < 5; k++) kn_bezier_clear(ctx, &list[k]);
    test_ctx_end(ctx, &memory);
}

static kn_status every_call(kn_ctx *ctx, void *user)
{
    const fixture *f = user;
    kn_tile tile = {0}, copy = {0}, varied = {0};
    const double values[2] = {2, 1};
    kn_tile_cover cover[6];
    kn_status status = make_all(ctx, &tile, f->kinds, &f->trim);
    if (status == KN_OK) status = kn_tile_check(ctx, &tile);
    if (status == KN_OK) status = kn_tile_copy(ctx, &copy, &tile);
    assert_true((status == KN_OK) == (copy.parts != NULL));
    if (status == KN_OK) status = kn_tile_vary(ctx, &varied, &tile, values);
    assert_true((status == KN_OK) == (varied.parts != NULL));
    kn_bezier *pieces = NULL;
    size_t n = 0;
    if (status == KN_OK) status = kn_spline_to_bezier(ctx, &pieces, &n, &f->kinds[2]);
    if (status == KN_OK) status = kn_tile_cover_faces(ctx, cover, pieces, 1);
    for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    kn_tile_clear(ctx, &tile), kn_tile_clear(ctx, &copy), kn_tile_clear(ctx, &varied);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    fixture f;
    fixture_make(ctx, &f);
    test_allocation_failures(every_call, &f);
    fixture_clear(ctx, &f);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(holds_all_kinds),    cmocka_unit_test(values_of_parameters),
                                       cmocka_unit_test(refusals),           cmocka_unit_test(check_finds),
                                       cmocka_unit_test(turns_all_kinds),    cmocka_unit_test(covered_faces),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("tile/model", tests, NULL, NULL);
}
