// SPDX-License-Identifier: Apache-2.0
// Zero sets of the Jacobian: of a torus the axis and the circle inside the tube; curves at one height.
#include "tests/support/surfaces.h"

#include <knurl/construct.h>
#include <knurl/fold.h>

#include <math.h>
#include <string.h>

static kn_shell *make_torus_shell(kn_ctx *ctx, kn_spline *s, double tol)
{
    const double center[3] = {0, 0, 0}, axis[3] = {0, 0, 1};
    kn_shell *shell = NULL;
    kn_shell_options o = {.normal_tol = tol};
    assert_int_equal(kn_construct_torus(ctx, s, center, axis, 3.0, 1.0), KN_OK);
    if (kn_shell_create(ctx, &shell, s, &o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    return shell;
}

// Below: the tube's centre line, at distance 3 from the axis. Above: the axis itself, z = 3 tan of the tube's angle.
static void surfaces_of_a_torus(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    kn_shell *shell = make_torus_shell(ctx, &s, 1e-6);
    kn_mesh mesh = {0};
    assert_int_equal(kn_fold_surface(ctx, &mesh, shell, -1.5, -0.5, 6), KN_OK);
    const size_t places = 25 * 25; // 4 x 4 cells
    assert_int_equal(mesh.nvertices, places);
    assert_int_equal(mesh.ntriangles, 2 * 24 * 24);
    for (size_t i = 0; i < mesh.nvertices; i++) {
        const double *p = mesh.position + 3 * i;
        assert_true(fabs(hypot(p[0], p[1]) - 3.0) < 1e-3 && fabs(p[2]) < 1e-3); // n's derivatives: 1e-4
        const double *n = mesh.normal + 3 * i;
        assert_true(fabs(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0) < 1e-12);
    }
    assert_int_equal(kn_fold_surface(ctx, &mesh, shell, 0.5, 6.0, 6), KN_OK);
    assert_true(mesh.nvertices > places / 4 && mesh.nvertices < places / 2 && mesh.ntriangles > 0);
    for (size_t i = 0; i < mesh.nvertices; i++) {
        const double *p = mesh.position + 3 * i;
        assert_true(hypot(p[0], p[1]) < 5e-3);
        for (int c = 0; c < 3; c++) assert_true(isfinite(mesh.normal[3 * i + (size_t)c]));
    }
    for (size_t i = 0; i < 3 * mesh.ntriangles; i++) assert_true(mesh.triangle[i] < mesh.nvertices);
    assert_int_equal(kn_fold_surface(ctx, &mesh, shell, -0.5, 0.5, 6), KN_OK); // none
    assert_true(mesh.nvertices == 0 && mesh.ntriangles == 0);
    kn_mesh_clear(ctx, &mesh);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// The tube's angle at the parameter v, counted from the outermost point.
static double angle_of(kn_ctx *ctx, const kn_spline *s, double u, double v)
{
    const double at[2] = {u, v};
    double p[3];
    assert_int_equal(kn_spline_eval(ctx, p, s, at), KN_OK);
    return atan2(p[2], hypot(p[0], p[1]) - 3.0);
}

// At w the Jacobian is 0 where (3 + (1 + w) cos) is: two lines around the hole, each at one angle.
static void curves_of_a_torus(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    kn_shell *shell = make_torus_shell(ctx, &s, 1e-6);
    double *points = NULL;
    size_t *ends = NULL, nlines = 0;
    const double w = 4.0, angle = acos(-3.0 / 5.0);
    assert_int_equal(kn_fold_curves(ctx, &points, &ends, &nlines, shell, w, 8), KN_OK);
    assert_int_equal(nlines, 2);
    assert_int_equal(ends[1], 2 * ends[0]);
    assert_int_equal(ends[0], 4 * 8 + 1); // one for each line of the grid across them
    for (size_t i = 0; i < ends[1]; i++)
        assert_true(fabs(fabs(angle_of(ctx, &s, points[2 * i], points[2 * i + 1])) - angle) < 1e-3);
    kn_free(ctx, points);
    kn_free(ctx, ends);
    assert_int_equal(kn_fold_curves(ctx, &points, &ends, &nlines, shell, 1.0, 8), KN_OK);
    assert_int_equal(nlines, 0);
    kn_free(ctx, points);
    kn_free(ctx, ends);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// z = -(x^2 + 0.7 y^2): at the top the radii are 1/2 and 1/1.4, so that a little below 1/2 J is 0 along a closed line
// around it.
static void make_bump(kn_ctx *ctx, kn_spline *out)
{
    const double k[6] = {-1, -1, -1, 1, 1, 1}, line[3] = {-1, 0, 1}, square[3] = {1, -1, 1};
    const double *knots[2] = {k, k};
    double coef[27];
    for (int i = 0; i < 9; i++) {
        coef[i] = line[i / 3], coef[9 + i] = line[i % 3];
        coef[18 + i] = -square[i / 3] - 0.7 * square[i % 3];
    }
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, (const int[2]){2, 2}, (const int[2]){3, 3}, knots, coef),
                     KN_OK);
}

// Every point is a root of J, neighbours lie on one square of the grid, and the line is closed.
static void closed_line(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    kn_shell *shell = NULL;
    make_bump(ctx, &s);
    kn_shell_options o = {.normal_tol = 1e-4};
    assert_int_equal(kn_shell_create(ctx, &shell, &s, &o), KN_OK);
    const double w = -0.53;
    double *points = NULL, lo, hi;
    size_t *ends = NULL, nlines = 0;
    assert_int_equal(kn_fold_curves(ctx, &points, &ends, &nlines, shell, w, 12), KN_OK);
    assert_int_equal(nlines, 1);
    assert_int_equal(kn_shell_jacobian_bounds(ctx, &lo, &hi, shell, w, w), KN_OK);
    const double mesh = 2.0 / 12.0, size = fmax(-lo, hi);
    assert_true(ends[0] > 8);
    assert_memory_equal(points, points + 2 * (ends[0] - 1), 2 * sizeof *points);
    for (size_t i = 0; i < ends[0]; i++) {
        double p[3], j[9], at[2];
        memcpy(at, points + 2 * i, sizeof at);
        assert_int_equal(kn_shell_eval(ctx, p, j, shell, at[0], at[1], w), KN_OK);
        double det = j[0] * (j[4] * j[8] - j[5] * j[7]) - j[1] * (j[3] * j[8] - j[5] * j[6]) +
                     j[2] * (j[3] * j[7] - j[4] * j[6]);
        assert_true(fabs(det) < 1e-9 * size);
        if (i > 0) // neighbours lie on one square of the grid
            assert_true(fabs(at[0] - points[2 * i - 2]) <= mesh * 1.001 &&
                        fabs(at[1] - points[2 * i - 1]) <= mesh * 1.001);
    }
    kn_free(ctx, points);
    kn_free(ctx, ends);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// (u, v, w - w^2 / 2): J is 0 on the plane w = 1. With u w in the third place: det 1 - w + u, curves u = w - 1.
static void volumes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double k[4] = {0, 0, 1, 1}, kw[6] = {0, 0, 0, 2, 2, 2}, height[3] = {0, 1, 0}, linear[3] = {0, 1, 2};
    const double *knots[3] = {k, k, kw};
    const int degree[3] = {1, 1, 2}, count[3] = {2, 2, 3};
    double coef[36], *points = NULL;
    size_t *ends = NULL, nlines = 0;
    kn_spline s = {0};
    kn_shell *shell = NULL;
    kn_mesh mesh = {0};
    for (int i = 0; i < 12; i++) {
        coef[i] = i / 6, coef[12 + i] = i / 3 % 2;
        coef[24 + i] = height[i % 3] + coef[i] * linear[i % 3];
    }
    assert_int_equal(kn_spline_init(ctx, &s, 3, 3, false, degree, count, knots, coef), KN_OK);
    assert_int_equal(kn_shell_from_volume(ctx, &shell, &s, NULL), KN_OK);
    assert_int_equal(kn_fold_surface(ctx, &mesh, shell, 0.0, 1.9, 4), KN_OK);
    for (size_t i = 0; i < mesh.nvertices; i++) {
        double u = mesh.position[3 * i], w = 1.0 + u;
        assert_true(fabs(mesh.position[3 * i + 2] - (w - 0.5 * w * w + u * w)) < 1e-12);
    }
    assert_true(mesh.nvertices == 20); // 4 of 5 lines: u = 1 would need w = 2
    assert_int_equal(kn_fold_curves(ctx, &points, &ends, &nlines, shell, 1.4, 4), KN_OK);
    assert_int_equal(nlines, 1);
    for (size_t i = 0; i < ends[0]; i++) assert_true(fabs(points[2 * i] - 0.4) < 1e-12);
    kn_free(ctx, points);
    kn_free(ctx, ends);
    kn_mesh_clear(ctx, &mesh);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void bad_arguments(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    kn_shell *shell = NULL;
    make_plane(ctx, &s);
    assert_int_equal(kn_shell_create(ctx, &shell, &s, NULL), KN_OK);
    kn_mesh mesh = {0};
    double *points = NULL;
    size_t *ends = NULL, nlines = 7;
    assert_int_equal(kn_fold_surface(ctx, &mesh, shell, 1.0, 1.0, 4), KN_EDOMAIN);
    assert_int_equal(kn_fold_surface(ctx, &mesh, shell, 0.0, INFINITY, 4), KN_EDOMAIN);
    assert_int_equal(kn_fold_surface(ctx, &mesh, shell, 0.0, 1.0, 0), KN_EDOMAIN);
    assert_int_equal(kn_fold_surface(ctx, &mesh, shell, 0.0, 1.0, 1 << 14), KN_ELIMIT);
    assert_int_equal(kn_fold_curves(ctx, &points, &ends, &nlines, shell, NAN, 4), KN_EDOMAIN);
    assert_int_equal(kn_fold_curves(ctx, &points, &ends, &nlines, shell, 0.0, -4), KN_EDOMAIN);
    assert_int_equal(kn_fold_curves(ctx, &points, &ends, &nlines, shell, 0.0, 1 << 14), KN_ELIMIT);
    assert_true(mesh.position == NULL && points == NULL && ends == NULL && nlines == 7);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

typedef struct held {
    kn_shell *shell;
} held;

static kn_status compute(kn_ctx *ctx, void *user)
{
    const held *h = user;
    double *points = NULL;
    size_t *ends = NULL, nlines = 7;
    kn_mesh mesh = {0};
    kn_status status = kn_fold_curves(ctx, &points, &ends, &nlines, h->shell, -1.5, 1);
    if (status != KN_OK) {
        assert_true(points == NULL && ends == NULL && nlines == 7);
        return status;
    }
    kn_free(ctx, points);
    kn_free(ctx, ends);
    status = kn_fold_surface(ctx, &mesh, h->shell, -1.5, -0.5, 1);
    if (status != KN_OK) assert_true(mesh.position == NULL && mesh.nvertices == 0);
    kn_mesh_clear(ctx, &mesh);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    held h = {0};
    make_cylinder(ctx, &s);
    kn_shell_options o = {.normal_tol = 0.05};
    assert_int_equal(kn_shell_create(ctx, &h.shell, &s, &o), KN_OK);
    test_allocation_failures(compute, &h);
    kn_shell_destroy(ctx, h.shell);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_of_a_torus), cmocka_unit_test(curves_of_a_torus),
        cmocka_unit_test(closed_line),         cmocka_unit_test(volumes),
        cmocka_unit_test(bad_arguments),       cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests_name("fold/zero_set", tests, NULL, NULL);
}
