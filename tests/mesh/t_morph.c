// SPDX-License-Identifier: Apache-2.0
// What meshes are, disks laid flat, and one connectivity for two of them.
#include "tests/mesh/starved.h"
#include "tests/support/support.h"

#include <knurl/mesh.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// A grid of (n + 1)^2 vertices over [0,1]^2 as a height field; hole: without its middle square.
static void make_grid(kn_ctx *ctx, kn_mesh *out, int n, double height, bool hole)
{
    const int degree[2] = {2, 2};
    kn_bezier b = {0};
    assert_int_equal(kn_bezier_init(ctx, &b, 2, 3, false, degree), KN_OK);
    for (size_t i = 0; i < 3; i++)
        for (size_t j = 0; j < 3; j++) {
            b.coef[3 * i + j] = 0.5 * (double)i, b.coef[9 + 3 * i + j] = 0.5 * (double)j;
            b.coef[18 + 3 * i + j] = i == 1 && j == 1 ? height : 0;
        }
    const int segments[2] = {n, n};
    assert_int_equal(kn_mesh_add_patch(ctx, out, &b, segments, false), KN_OK);
    if (hole) {
        size_t at = 6 * (size_t)((n / 2) * n + n / 2);
        memmove(out->triangle + at, out->triangle + at + 6, (3 * out->ntriangles - at - 6) * sizeof *out->triangle);
        out->ntriangles -= 2;
    }
    kn_bezier_clear(ctx, &b);
}

static void make_tetrahedron(kn_ctx *ctx, kn_mesh *out)
{
    static double position[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static uint32_t triangle[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    const kn_mesh m = {.nvertices = 4, .ntriangles = 4, .position = position, .triangle = triangle};
    assert_int_equal(kn_mesh_copy(ctx, out, &m), KN_OK);
}

static void surveys(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_mesh m = {0};
    kn_mesh_topology t;
    make_grid(ctx, &m, 4, 1, false);
    assert_int_equal(kn_mesh_survey(ctx, &t, &m), KN_OK);
    assert_true(t.vertices == 25 && t.edges == 2 * 20 + 16 && t.border == 16 && t.irregular == 0);
    assert_true(t.components == 1 && t.loops == 1 && t.euler == 1);
    uint32_t *triangle = m.triangle, kept = triangle[1];
    triangle[1] = triangle[2],
    triangle[2] = kept; // one triangle turned over: its three edges disagree, or are border
    assert_int_equal(kn_mesh_survey(ctx, &t, &m), KN_OK);
    assert_true(t.irregular > 0);
    triangle[1] = 99;
    t.edges = 7;
    assert_int_equal(kn_mesh_survey(ctx, &t, &m), KN_EDOMAIN);
    assert_int_equal(t.edges, 7);
    kn_mesh_clear(ctx, &m);

    make_grid(ctx, &m, 5, 1, true);
    assert_int_equal(kn_mesh_survey(ctx, &t, &m), KN_OK);
    assert_true(t.loops == 2 && t.euler == 0 && t.components == 1 && t.irregular == 0);
    kn_mesh_clear(ctx, &m);
    make_tetrahedron(ctx, &m);
    assert_int_equal(kn_mesh_survey(ctx, &t, &m), KN_OK);
    assert_true(t.border == 0 && t.loops == 0 && t.euler == 2 && t.edges == 6);
    kn_mesh_clear(ctx, &m);
    test_ctx_end(ctx, &memory);
}

// The border on the circle in its order, all triangles turned the right way, their areas together the polygon's.
static void flat_disks(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int n = 2; n <= 20; n += 6) {
        kn_mesh m = {0};
        make_grid(ctx, &m, n, 3, false);
        double *xy = calloc(2 * m.nvertices, sizeof *xy), sum = 0;
        assert_non_null(xy);
        uint32_t corner = (uint32_t)(n * (n + 1));
        assert_int_equal(kn_mesh_flatten(ctx, xy, &m, corner), KN_OK);
        assert_true(xy[2 * corner] == 1 && xy[2 * corner + 1] == 0);
        for (size_t i = 0; i < m.ntriangles; i++) {
            const uint32_t *t = m.triangle + 3 * i;
            double area = 0.5 * ((xy[2 * t[1]] - xy[2 * t[0]]) * (xy[2 * t[2] + 1] - xy[2 * t[0] + 1]) -
                                 (xy[2 * t[2]] - xy[2 * t[0]]) * (xy[2 * t[1] + 1] - xy[2 * t[0] + 1]));
            assert_true(area > 0);
            sum += area;
        }
        // 4 n steps of equal length: a regular polygon
        assert_true(fabs(sum - 2 * n * sin(6.283185307179586 / (4 * n))) <= 1e-12);
        assert_int_equal(kn_mesh_flatten(ctx, xy, &m, (uint32_t)(n + 2)), KN_EDOMAIN); // inside
        free(xy);
        kn_mesh_clear(ctx, &m);
    }
    double xy[100];
    kn_mesh m = {0};
    make_tetrahedron(ctx, &m);
    assert_int_equal(kn_mesh_flatten(ctx, xy, &m, 0), KN_EDOMAIN);
    kn_mesh_clear(ctx, &m);
    test_ctx_end(ctx, &memory);
}

// From a coarse flat square to a fine dome: all targets lie on the dome's triangles, the border on its border, and the
// corners that begin agree.
static void morphs(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_mesh a = {0}, b = {0}, both = {0};
    double *target = NULL;
    make_grid(ctx, &a, 3, 0, false), make_grid(ctx, &b, 12, 2, false);
    assert_int_equal(kn_mesh_morph(ctx, &both, &target, &a, &b), KN_OK);
    assert_int_equal(both.ntriangles, 18 * 16); // 18, 72 and 288 triangles: as many as b's 288
    assert_null(both.normal);
    double most = 0;
    for (size_t v = 0; v < both.nvertices; v++) {
        const double *p = both.position + 3 * v, *q = target + 3 * v;
        bool edge = p[0] == 0 || p[0] == 1 || p[1] == 0 || p[1] == 1;
        assert_true(p[2] == 0 && q[0] >= -1e-12 && q[0] <= 1 + 1e-12 && q[1] >= -1e-12 && q[1] <= 1 + 1e-12);
        // both borders are squares with equal sides, run from the same corner: they agree but for rounding
        if (edge) assert_true(test_max_difference(p, q, 3) <= 1e-12);
        // the dome's height there, 8 u (1 - u) v (1 - v), less what triangles of 1/12 lose: h^2 / 8 times 2 times 4
        double height = 8 * q[0] * (1 - q[0]) * q[1] * (1 - q[1]);
        assert_true(fabs(q[2] - height) <= 8.0 / 8 / 144 * 2);
        most = fmax(most, q[2]);
    }
    assert_true(most > 0.4); // of 1/2
    kn_free(ctx, target);

    // The same triangles: positions as they are.
    kn_mesh lifted = {0};
    make_grid(ctx, &lifted, 3, 5, false);
    assert_int_equal(kn_mesh_morph(ctx, &both, &target, &a, &lifted), KN_OK);
    assert_int_equal(both.ntriangles, a.ntriangles);
    assert_memory_equal(target, lifted.position, 3 * lifted.nvertices * sizeof *target);
    kn_free(ctx, target);
    kn_mesh_clear(ctx, &lifted);

    // No disks.
    kn_mesh solid = {0}, ring = {0};
    make_tetrahedron(ctx, &solid), make_grid(ctx, &ring, 5, 1, true);
    target = NULL;
    assert_int_equal(kn_mesh_morph(ctx, &both, &target, &a, &solid), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx),
                           "the first has 1 components, 1 border loops, genus 0 and 0 irregular edges: it is open"));
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_mesh_morph(ctx, &both, &target, &ring, &b), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "the first has 1 components, 2 border loops"));
    assert_null(target);
    assert_int_equal(both.ntriangles, a.ntriangles);
    kn_mesh_clear(ctx, &solid), kn_mesh_clear(ctx, &ring);
    kn_mesh_clear(ctx, &a), kn_mesh_clear(ctx, &b), kn_mesh_clear(ctx, &both);
    test_ctx_end(ctx, &memory);
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_mesh a = {0}, b = {0};
    make_grid(ctx, &a, 2, 0, false), make_grid(ctx, &b, 3, 1, false);
    starved_morph(&a, &b);
    kn_mesh_clear(ctx, &a), kn_mesh_clear(ctx, &b);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(surveys), cmocka_unit_test(flat_disks),
                                       cmocka_unit_test(morphs), cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("mesh/morph", tests, NULL, NULL);
}
