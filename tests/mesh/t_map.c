// SPDX-License-Identifier: Apache-2.0
// Meshes through maps: against closed forms, conforming, oriented, and the same on both sides of a common edge.
#include "tests/support/surfaces.h"

#include <knurl/mesh.h>

#include <float.h>
#include <math.h>
#include <string.h>

// (u, v, w) on a cylinder of radius 1 + w along v.
static kn_status roll(kn_ctx *ctx, void *user, double point[3], double *normal, const double from[3],
                      const double *from_normal)
{
    (void)ctx;
    if (user) ++*(int *)user;
    double r = 1 + from[2], c = cos(from[0]), s = sin(from[0]);
    point[0] = r * c, point[1] = from[1], point[2] = -r * s;
    if (!normal) return KN_OK;
    double n[3] = {-from_normal[0] / r * s + from_normal[2] * c, from_normal[1],
                   -from_normal[0] / r * c - from_normal[2] * s};
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 3; k++) normal[k] = n[k] / length;
    return KN_OK;
}

// The box [u0, u0 + size] x [0,1] x [0.25,0.5] with its corners as vertices, outside seen counterclockwise.
typedef struct box {
    double position[24];
    uint32_t triangle[36];
    kn_mesh mesh;
} box;
static void make_box(box *b, double u0, double size)
{
    static const uint32_t quads[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                         {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    for (int i = 0; i < 8; i++) {
        b->position[3 * i] = u0 + size * (i >> 2 & 1);
        b->position[3 * i + 1] = i >> 1 & 1;
        b->position[3 * i + 2] = 0.25 + 0.25 * (i & 1);
    }
    for (int q = 0; q < 6; q++) {
        const uint32_t *c = quads[q], t[6] = {c[0], c[1], c[2], c[0], c[2], c[3]};
        memcpy(b->triangle + 6 * q, t, sizeof t);
    }
    b->mesh = (kn_mesh){.nvertices = 8, .ntriangles = 12, .position = b->position, .triangle = b->triangle};
}

static double volume(const kn_mesh *m)
{
    double sum = 0;
    for (size_t t = 0; t < m->ntriangles; t++) {
        const double *p = m->position + 3 * (size_t)m->triangle[3 * t];
        const double *q = m->position + 3 * (size_t)m->triangle[3 * t + 1];
        const double *r = m->position + 3 * (size_t)m->triangle[3 * t + 2];
        sum += (p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) +
                p[2] * (q[0] * r[1] - q[1] * r[0])) /
               6;
    }
    return sum;
}

// Every directed edge has its opposite once.
static bool closed(const kn_mesh *m)
{
    for (size_t e = 0; e < 3 * m->ntriangles; e++) {
        uint32_t a = m->triangle[e], b = m->triangle[e % 3 == 2 ? e - 2 : e + 1];
        int found = 0;
        for (size_t f = 0; f < 3 * m->ntriangles; f++)
            found += m->triangle[f] == b && m->triangle[f % 3 == 2 ? f - 2 : f + 1] == a;
        if (found != 1) return false;
    }
    return true;
}

// A quarter of a thick pipe: its volume is ((1.5^2 - 1.25^2) / 2) pi/2 less what chords within the tolerance cut off.
static void a_box_becomes_a_pipe(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double angle = acos(-1.0) / 2;
    box b;
    make_box(&b, 0, angle);
    for (int k = 0; k < 3; k++) {
        kn_mesh out = {0};
        kn_mesh_map_options o = kn_mesh_map_defaults();
        double deviation = -1, want = (1.5 * 1.5 - 1.25 * 1.25) / 2 * angle;
        const double tolerance[3] = {0, 0.05, 0.002};
        o.tolerance = tolerance[k];
        o.reversed = k == 1;
        assert_int_equal(kn_mesh_map_by(ctx, &out, &deviation, &b.mesh, roll, NULL, &o), KN_OK);
        assert_true(closed(&out));
        assert_true(k == 0 ? out.ntriangles == 12 && out.nvertices == 8 : out.ntriangles > 12);
        assert_true(deviation <= o.tolerance);
        // the map keeps orientation: positive, but for `reversed`. Areas 1.5 and 1.25 times angle, of the sheets that
        // chords move inwards, bound what is missing.
        double got = volume(&out) * (o.reversed ? -1 : 1);
        if (k > 0) assert_true(fabs(got - want) <= 2.75 * angle * o.tolerance * 1.1);
        for (size_t i = 0; i < out.nvertices; i++) { // on the pipe's inside, outside, or a flat side of it
            double r = hypot(out.position[3 * i], out.position[3 * i + 2]), n = 0;
            assert_true(r >= 1.25 - 4 * DBL_EPSILON && r <= 1.5 + 4 * DBL_EPSILON);
            for (size_t c = 0; c < 3; c++) n += out.normal[3 * i + c] * out.normal[3 * i + c];
            assert_true(fabs(n - 1) <= 8 * DBL_EPSILON);
        }
        kn_mesh_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

// Every point of the mesh is within the tolerance of the cylinder it is on: the top alone, of which both radii are
// known everywhere.
static void points_between_are_near(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double position[12] = {0, 0, 0.5, 1, 0, 0.5, 1, 1, 0.5, 0, 1, 0.5}, normal[12] = {0};
    uint32_t triangle[6] = {0, 1, 2, 0, 2, 3};
    for (int i = 0; i < 4; i++) normal[3 * i + 2] = 1;
    kn_mesh mesh = {.nvertices = 4, .ntriangles = 2, .position = position, .normal = normal, .triangle = triangle};
    kn_mesh_map_options o = {.tolerance = 1e-3};
    kn_mesh out = {0};
    assert_int_equal(kn_mesh_map_by(ctx, &out, NULL, &mesh, roll, NULL, &o), KN_OK);
    for (size_t t = 0; t < out.ntriangles; t++)
        for (int i = 0; i <= 4; i++)
            for (int j = 0; i + j <= 4; j++) {
                double p[3] = {0}, weight[3] = {i / 4.0, j / 4.0, (4 - i - j) / 4.0};
                for (size_t k = 0; k < 3; k++)
                    for (size_t c = 0; c < 3; c++)
                        p[c] += weight[k] * out.position[3 * (size_t)out.triangle[3 * t + k] + c];
                assert_true(fabs(hypot(p[0], p[2]) - 1.5) <= o.tolerance);
            }
    for (size_t i = 0; i < out.nvertices; i++) // normals point away from the axis
        assert_true(fabs(out.normal[3 * i] * 1.5 - out.position[3 * i]) <= 16 * DBL_EPSILON);
    kn_mesh_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

// Two boxes side by side have the same vertices on the common side, bit for bit, though they are cut by themselves.
static void neighbours_agree(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    box b[2];
    kn_mesh out[2] = {{0}};
    kn_spline wavy = {0};
    kn_shell *shell = NULL;
    make_wavy(ctx, &wavy);
    double lo, hi;
    kn_spline_domain(&wavy, 0, &lo, &hi);
    assert_int_equal(kn_shell_create(ctx, &shell, &wavy, NULL), KN_OK);
    double middle = 0.5 * (lo + hi);
    make_box(&b[0], lo, middle - lo);
    make_box(&b[1], middle, hi - middle);
    for (int i = 4; i < 8; i++) b[0].position[3 * i] = middle;
    kn_mesh_map_options o = {.tolerance = 1e-3};
    for (int k = 0; k < 2; k++) assert_int_equal(kn_mesh_map(ctx, &out[k], NULL, &b[k].mesh, shell, &o), KN_OK);
    int common = 0;
    for (size_t i = 0; i < out[0].nvertices; i++)
        for (size_t j = 0; j < out[1].nvertices; j++)
            common += memcmp(out[0].position + 3 * i, out[1].position + 3 * j, 3 * sizeof(double)) == 0;
    assert_true(common >= 4); // corners, and what the edges between them became
    // and no vertex of one is nearly, but not, a vertex of the other
    for (size_t i = 0; i < out[0].nvertices; i++)
        for (size_t j = 0; j < out[1].nvertices; j++) {
            double d = test_max_difference(out[0].position + 3 * i, out[1].position + 3 * j, 3);
            assert_true(d == 0 || d > 1e-6);
        }
    kn_mesh_clear(ctx, &out[0]), kn_mesh_clear(ctx, &out[1]);
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &wavy);
    test_ctx_end(ctx, &memory);
}

// Over a shell: images are kn_shell_eval's, normals kn_shell_map_normal's, or the estimate's.
static void through_a_shell(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline torus = {0};
    kn_shell *shell = NULL;
    make_torus(ctx, &torus);
    assert_int_equal(kn_shell_create(ctx, &shell, &torus, NULL), KN_OK);
    double position[9] = {0.1, 0.1, 0, 0.3, 0.15, 0.1, 0.2, 0.4, 0.2}, normal[9] = {1, 0, 0.5, 0, 1, 1, 0, 0, 1};
    uint32_t triangle[3] = {0, 1, 2};
    kn_mesh mesh = {.nvertices = 3, .ntriangles = 1, .position = position, .normal = normal, .triangle = triangle};
    for (int k = 0; k < 2; k++) {
        kn_mesh out = {0};
        kn_mesh_map_options o = {.estimate_normals = k == 1};
        assert_int_equal(kn_mesh_map(ctx, &out, NULL, &mesh, shell, &o), KN_OK);
        for (size_t i = 0; i < 3; i++) {
            double p[3], n[3];
            const double *at = position + 3 * i;
            assert_int_equal(kn_shell_eval(ctx, p, NULL, shell, at[0], at[1], at[2]), KN_OK);
            assert_int_equal(k ? kn_shell_map_normal_estimate(ctx, n, shell, at, normal + 3 * i)
                               : kn_shell_map_normal(ctx, n, shell, at, normal + 3 * i),
                             KN_OK);
            assert_memory_equal(p, out.position + 3 * i, sizeof p);
            assert_memory_equal(n, out.normal + 3 * i, sizeof n);
        }
        kn_mesh_clear(ctx, &out);
    }
    kn_shell_destroy(ctx, shell);
    kn_spline_clear(ctx, &torus);
    test_ctx_end(ctx, &memory);
}

static kn_status refuse(kn_ctx *ctx, void *user, double point[3], double *normal, const double from[3],
                        const double *from_normal)
{
    (void)ctx, (void)point, (void)normal, (void)from, (void)from_normal;
    return --*(int *)user == 0 ? KN_EUNDEFINED : KN_OK;
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    box b;
    make_box(&b, 0, 1);
    kn_mesh out = {.nvertices = 77}, empty = {0};
    double deviation = 5;
    kn_mesh_map_options bad[3] = {
        {.tolerance = -1}, {.tolerance = INFINITY}, {.tolerance = 1e-4, .max_triangles = 50}};
    for (int k = 0; k < 3; k++)
        assert_int_equal(kn_mesh_map_by(ctx, &out, &deviation, &b.mesh, roll, NULL, &bad[k]),
                         k == 2 ? KN_ELIMIT : KN_EDOMAIN);
    for (int calls = 1; calls < 16; calls += 6) {
        int left = calls;
        assert_int_equal(kn_mesh_map_by(ctx, &out, &deviation, &b.mesh, refuse, &left, NULL), KN_EUNDEFINED);
    }
    b.triangle[5] = 8;
    assert_int_equal(kn_mesh_map_by(ctx, &out, &deviation, &b.mesh, roll, NULL, NULL), KN_EDOMAIN);
    assert_true(out.nvertices == 77 && !out.position && deviation == 5);
    out = (kn_mesh){0};
    assert_int_equal(kn_mesh_map_by(ctx, &out, NULL, &empty, roll, NULL, NULL), KN_OK);
    assert_int_equal(out.ntriangles, 0);
    kn_mesh_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

static kn_status map_call(kn_ctx *ctx, void *user)
{
    kn_mesh out = {0}, copy = {0};
    kn_mesh_map_options o = {.tolerance = 0.02};
    kn_status status = kn_mesh_map_by(ctx, &out, NULL, user, roll, NULL, &o);
    assert_true((status == KN_OK) == (out.triangle != NULL));
    if (status == KN_OK) status = kn_mesh_copy(ctx, &copy, &out);
    assert_true((status == KN_OK) == (copy.triangle != NULL));
    if (status == KN_OK) {
        assert_int_equal(copy.nvertices, out.nvertices);
        assert_memory_equal(copy.normal, out.normal, 3 * out.nvertices * sizeof(double));
        assert_memory_equal(copy.triangle, out.triangle, 3 * out.ntriangles * sizeof(uint32_t));
        status = kn_mesh_copy(ctx, &copy, &copy);
    }
    kn_mesh_clear(ctx, &out), kn_mesh_clear(ctx, &copy);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    box b;
    make_box(&b, 0, 1.5);
    test_allocation_failures(map_call, &b.mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_box_becomes_a_pipe),
                                       cmocka_unit_test(points_between_are_near),
                                       cmocka_unit_test(neighbours_agree),
                                       cmocka_unit_test(through_a_shell),
                                       cmocka_unit_test(failures),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("mesh/map", tests, NULL, NULL);
}
