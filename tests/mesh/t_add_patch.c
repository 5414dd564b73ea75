// SPDX-License-Identifier: Apache-2.0
// kn_mesh_add_patch: closed forms, edges that neighbours share bit for bit, collapsed edges, failures.
#include "tests/support/support.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include <knurl/mesh.h>

#define HALF_SQRT2 0.70710678118654752440

// A patch with these coefficients, components slowest, t fastest.
static kn_bezier patch_of(kn_ctx *ctx, int n, int m, bool rational, const double *coef)
{
    kn_bezier p = {0};
    int degree[2] = {n, m};
    assert_int_equal(kn_bezier_init(ctx, &p, 2, rational ? 4 : 3, rational, degree), KN_OK);
    memcpy(p.coef, coef, (size_t)p.ncomp * kn_bezier_count(&p) * sizeof *coef);
    return p;
}

static double *coef_at(const kn_bezier *p, int comp, int i, int j)
{
    size_t row = (size_t)p->degree[1] + 1;
    return &p->coef[(size_t)comp * kn_bezier_count(p) + (size_t)i * row + (size_t)j];
}

static void add(kn_ctx *ctx, kn_mesh *mesh, const kn_bezier *p, int a, int b, bool reversed)
{
    int segments[2] = {a, b};
    assert_int_equal(kn_mesh_add_patch(ctx, mesh, p, segments, reversed), KN_OK);
}

static double distance(const double *a, const double *b)
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

// The area vector of a triangle, twice.
static void twice_area(double out[3], const kn_mesh *mesh, size_t k)
{
    const double *p[3];
    double a[3], b[3];
    for (int c = 0; c < 3; c++) p[c] = mesh->position + 3 * (size_t)mesh->triangle[3 * k + (size_t)c];
    for (int c = 0; c < 3; c++) a[c] = p[1][c] - p[0][c], b[c] = p[2][c] - p[0][c];
    for (int c = 0; c < 3; c++) out[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

// x = 3 r, y = 5 t: all numbers are small dyadic ones, so everything is exact.
static void a_rectangle_is_exact(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double coef[] = {0, 0, 3, 3, 0, 5, 0, 5, 7, 7, 7, 7};
    kn_bezier p = patch_of(ctx, 1, 1, false, coef);
    kn_mesh mesh = {0};
    add(ctx, &mesh, &p, 4, 2, false);
    add(ctx, &mesh, &p, 2, 1, true);
    assert_int_equal(mesh.nvertices, 15 + 6);
    assert_int_equal(mesh.ntriangles, 16 + 4);
    for (size_t i = 0; i < 15; i++) {
        const double *x = mesh.position + 3 * i, *n = mesh.normal + 3 * i;
        size_t row = i / 3, column = i % 3;
        assert_true(x[0] == 0.75 * (double)row && x[1] == 2.5 * (double)column && x[2] == 7.0);
        assert_true(n[0] == 0.0 && n[1] == 0.0 && n[2] == 1.0);
    }
    for (size_t i = 15; i < 21; i++) assert_true(mesh.normal[3 * i + 2] == -1.0);
    double area[3], sum[2] = {0.0, 0.0};
    for (size_t k = 0; k < mesh.ntriangles; k++) {
        for (int c = 0; c < 3; c++) assert_true((mesh.triangle[3 * k + (size_t)c] >= 15) == (k >= 16));
        twice_area(area, &mesh, k);
        assert_true(k < 16 ? area[2] > 0.0 : area[2] < 0.0);
        sum[k >= 16] += area[2];
    }
    assert_true(sum[0] == 30.0 && sum[1] == -30.0);
    kn_mesh_clear(ctx, &mesh);
    assert_null(mesh.position);
    kn_mesh_clear(ctx, &mesh);
    kn_bezier_clear(ctx, &p);
    test_ctx_end(ctx, &memory);
}

// An octant of the unit sphere, rational of degree (2,2): the arc (1,0)-(0,1) turned about z; the edge t = 1 is the
// pole.
static kn_bezier sphere_octant(kn_ctx *ctx)
{
    const double x[3] = {1, 1, 0}, y[3] = {0, 1, 1}, w[3] = {1, HALF_SQRT2, 1};
    double coef[36];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double weight = w[i] * w[j];
            coef[3 * i + j] = weight * x[i] * x[j];
            coef[9 + 3 * i + j] = weight * y[i] * x[j];
            coef[18 + 3 * i + j] = weight * y[j];
            coef[27 + 3 * i + j] = weight;
        }
    return patch_of(ctx, 2, 2, true, coef);
}

static void a_sphere_is_its_own_normal(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_bezier p = sphere_octant(ctx);
    kn_mesh mesh = {0};
    enum { A = 6, B = 8 };
    add(ctx, &mesh, &p, A, B, false);
    // Sums of three products twice over, a quotient, a root: below 20 roundings; derivatives lose a factor of about
    // 1 / sin of the distance to the pole, at most B.
    for (size_t i = 0; i < mesh.nvertices; i++) {
        const double *x = mesh.position + 3 * i, origin[3] = {0, 0, 0};
        assert_true(fabs(distance(x, origin) - 1.0) <= 20 * DBL_EPSILON);
        // At the pole: the extrapolation leaves h^3 |n'''| / 48 with h = 1/128; the turning rate of the meridian is
        // at most 2 and |n'''| at most 60: 6e-7.
        assert_true(distance(x, mesh.normal + 3 * i) <= (i % (B + 1) == B ? 6e-7 : 40 * B * DBL_EPSILON));
    }
    assert_int_equal(mesh.ntriangles, 2 * A * B - A); // at the pole one of each two is degenerate
    double area[3];
    for (size_t k = 0; k < mesh.ntriangles; k++) {
        const double *x = mesh.position + 3 * (size_t)mesh.triangle[3 * k];
        twice_area(area, &mesh, k);
        assert_true(area[0] * x[0] + area[1] * x[1] + area[2] * x[2] > 0.0);
    }
    kn_mesh_clear(ctx, &mesh);
    kn_bezier_clear(ctx, &p);
    test_ctx_end(ctx, &memory);
}

// A quarter of the cone z = 1 - |(x,y)|: the normal is constant along rulings, up to the apex, which has none itself.
static void a_cone_keeps_its_normals_at_the_apex(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double s = HALF_SQRT2;
    const double coef[] = {1, 0, s, 0, 0, 0, 0, 0, s, 0, 1, 0, 0, 1, 0, s, 0, 1, 1, 1, s, s, 1, 1};
    kn_bezier p = patch_of(ctx, 2, 1, true, coef);
    kn_mesh mesh = {0};
    enum { A = 5, B = 3 };
    add(ctx, &mesh, &p, A, B, false);
    for (size_t i = 0; i <= A; i++)
        for (size_t j = 0; j <= B; j++) {
            const double *base = mesh.position + 3 * i * (B + 1), *n = mesh.normal + 3 * (i * (B + 1) + j);
            double exact[3] = {base[0] * s, base[1] * s, s};
            // Below 50 roundings, amplified by 1 / h = 512 where the limit is extrapolated with weights of sum 5.
            assert_true(distance(n, exact) <= (j == B ? 5 * 512 : 1) * 50 * DBL_EPSILON);
        }
    kn_mesh_clear(ctx, &mesh);
    kn_bezier_clear(ctx, &p);
    test_ctx_end(ctx, &memory);
}

// (r t^2, t, 0): at t = 0 the normal vanishes to second order; and a constant patch, which has no normal anywhere.
static void normals_where_nothing_helps(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double cusp[] = {0, 0, 0, 0, 0, 1, 0, 0.5, 1, 0, 0.5, 1, 0, 0, 0, 0, 0, 0}, point[] = {1, 2, 3};
    kn_bezier p = patch_of(ctx, 1, 2, false, cusp), q = patch_of(ctx, 0, 0, false, point);
    kn_mesh mesh = {0};
    add(ctx, &mesh, &p, 4, 4, false);
    assert_int_equal(mesh.ntriangles, 32 - 4);
    for (size_t i = 0; i < mesh.nvertices; i++)
        assert_true(fabs(mesh.normal[3 * i + 2] - 1.0) <= 20 * DBL_EPSILON); // the extrapolation adds a few roundings
    size_t before = mesh.nvertices;
    add(ctx, &mesh, &q, 2, 2, false);
    assert_int_equal(mesh.nvertices, before + 9);
    assert_int_equal(mesh.ntriangles, 32 - 4);
    for (size_t i = before; i < mesh.nvertices; i++) {
        assert_true(mesh.position[3 * i] == 1.0 && mesh.position[3 * i + 2] == 3.0);
        assert_true(mesh.normal[3 * i + 2] == 1.0);
    }
    kn_mesh_clear(ctx, &mesh);
    kn_bezier_clear(ctx, &p);
    kn_bezier_clear(ctx, &q);
    test_ctx_end(ctx, &memory);
}

// The inner control points and weights of a random patch of this shape, with irrational-looking numbers.
static kn_bezier random_patch(kn_ctx *ctx, test_rng *rng, int n, int m, bool rational)
{
    kn_bezier p = {0};
    int degree[2] = {n, m};
    assert_int_equal(kn_bezier_init(ctx, &p, 2, rational ? 4 : 3, rational, degree), KN_OK);
    size_t count = kn_bezier_count(&p);
    for (size_t i = 0; i < (size_t)p.ncomp * count; i++)
        p.coef[i] = i < 3 * count ? test_uniform(rng, -1.0, 1.0) : test_uniform(rng, 0.5, 2.0);
    return p;
}

// Edge e of p: 0: r = 0, 1: r = 1 (both along t); 2: t = 0, 3: t = 1 (along r). Control point k, counted from the end
// when backwards.
static double *edge_coef(const kn_bezier *p, int comp, int e, int k, bool backwards)
{
    int n = p->degree[e < 2 ? 1 : 0], end = e % 2 ? p->degree[e < 2 ? 0 : 1] : 0;
    if (backwards) k = n - k;
    return e < 2 ? coef_at(p, comp, end, k) : coef_at(p, comp, k, end);
}

static const double *edge_vertex(const kn_mesh *mesh, size_t first, int a, int b, int e, int k, bool backwards)
{
    if (backwards) k = (e < 2 ? b : a) - k;
    int i = e < 2 ? (e ? a : 0) : k, j = e < 2 ? k : (e == 3 ? b : 0);
    return mesh->position + 3 * (first + (size_t)i * ((size_t)b + 1) + (size_t)j);
}

// Two patches with nothing in common but the control points of one edge, run in either direction by either variable.
static void neighbours_share_edge_points(kn_ctx *ctx, test_rng *rng, int e, int f, bool backwards, bool rational)
{
    int n = test_int(rng, 1, 15), s = test_int(rng, 1, 9);
    int other[4] = {test_int(rng, 1, 15), test_int(rng, 1, 15), test_int(rng, 1, 9), test_int(rng, 1, 9)};
    kn_bezier p = random_patch(ctx, rng, e < 2 ? other[0] : n, e < 2 ? n : other[0], rational);
    kn_bezier q = random_patch(ctx, rng, f < 2 ? other[1] : n, f < 2 ? n : other[1], rational);
    for (int c = 0; c < p.ncomp; c++)
        for (int k = 0; k <= n; k++) *edge_coef(&q, c, f, k, backwards) = *edge_coef(&p, c, e, k, false);
    int sp[2] = {e < 2 ? other[2] : s, e < 2 ? s : other[2]}, sq[2] = {f < 2 ? other[3] : s, f < 2 ? s : other[3]};
    kn_mesh mesh = {0};
    add(ctx, &mesh, &p, sp[0], sp[1], false);
    size_t first = mesh.nvertices;
    add(ctx, &mesh, &q, sq[0], sq[1], true);
    for (int k = 0; k <= s; k++) {
        const double *x = edge_vertex(&mesh, 0, sp[0], sp[1], e, k, false);
        const double *y = edge_vertex(&mesh, first, sq[0], sq[1], f, k, backwards);
        assert_memory_equal(x, y, 3 * sizeof *x);
    }
    kn_mesh_clear(ctx, &mesh);
    kn_bezier_clear(ctx, &p);
    kn_bezier_clear(ctx, &q);
}

static void edges_depend_on_their_control_points_alone(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = 0; round < test_scale(8); round++)
        for (int e = 0; e < 4; e++)
            for (int f = 0; f < 4; f++)
                for (int k = 0; k < 4; k++) neighbours_share_edge_points(ctx, &rng, e, f, k & 1, k & 2);
    test_ctx_end(ctx, &memory);
}

// Against de Casteljau and its derivatives. Control points are at most 2 in size and weights at least 1/2, so each
// value and each derivative (degree at most 8) is right to gamma(4 (n + m)) times 8 sums of |control points|; the
// normal then to that over the length of the cross product.
static void vertices_agree_with_evaluation(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    for (int round = 0; round < test_scale(40); round++) {
        kn_bezier p = random_patch(ctx, &rng, test_int(&rng, 1, 8), test_int(&rng, 1, 8), round % 2);
        kn_mesh mesh = {0};
        enum { A = 5, B = 4 };
        add(ctx, &mesh, &p, A, B, false);
        double bound = 4.0 * (p.degree[0] + p.degree[1] + 4) * DBL_EPSILON * 8.0;
        for (size_t i = 0; i < mesh.nvertices; i++) {
            size_t row = i / (B + 1), column = i % (B + 1);
            double at[2] = {(double)row / A, (double)column / B}, d[9], n[3];
            assert_int_equal(kn_bezier_derivatives(ctx, d, &p, at, 1), KN_OK);
            assert_true(distance(d, mesh.position + 3 * i) <= bound);
            const double *r = d + 3, *t = d + 6;
            for (int c = 0; c < 3; c++) n[c] = r[(c + 1) % 3] * t[(c + 2) % 3] - r[(c + 2) % 3] * t[(c + 1) % 3];
            double lr = distance(r, (double[3]){0}), lt = distance(t, (double[3]){0});
            double length = distance(n, (double[3]){0});
            for (int c = 0; c < 3; c++) n[c] /= length;
            assert_true(distance(n, mesh.normal + 3 * i) <= 100.0 * bound * (lr + lt + lr * lt) / length);
        }
        kn_mesh_clear(ctx, &mesh);
        kn_bezier_clear(ctx, &p);
    }
    test_ctx_end(ctx, &memory);
}

static void refusals_leave_the_mesh_alone(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double coef[] = {0, 0, 3, 3, 0, 5, 0, 5, 7, 7, 7, 7};
    kn_bezier good = patch_of(ctx, 1, 1, false, coef), curve = {0}, plane = {0};
    int one[2] = {1, 1};
    assert_int_equal(kn_bezier_init(ctx, &curve, 1, 3, false, one), KN_OK);
    assert_int_equal(kn_bezier_init(ctx, &plane, 2, 3, true, one), KN_OK);
    kn_bezier bare = good; // no coefficients
    bare.coef = NULL;
    kn_mesh mesh = {0};
    add(ctx, &mesh, &good, 1, 1, false);
    kn_mesh before = mesh;
    const struct {
        const kn_bezier *patch;
        int segments[2];
        kn_status status;
    } refused[] = {
        {&curve, {1, 1}, KN_EDOMAIN},
        {&plane, {1, 1}, KN_EDOMAIN},
        {&good, {0, 1}, KN_EDOMAIN},
        {&good, {1, -3}, KN_EDOMAIN},
        {&bare, {1, 1}, KN_EDOMAIN},
        {&good, {65535, 65535}, KN_ELIMIT},
        {&good, {2147483647, 2147483647}, KN_ELIMIT},
    };
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        kn_ctx_clear_error(ctx);
        assert_int_equal(kn_mesh_add_patch(ctx, &mesh, refused[i].patch, refused[i].segments, false),
                         refused[i].status);
        assert_int_equal(kn_ctx_error(ctx), refused[i].status);
        assert_memory_equal(&mesh, &before, sizeof mesh);
    }
    kn_mesh_clear(ctx, &mesh);
    kn_bezier_clear(ctx, &good);
    kn_bezier_clear(ctx, &curve);
    kn_bezier_clear(ctx, &plane);
    test_ctx_end(ctx, &memory);
}

static kn_status add_twice(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_bezier p = {0};
    int degree[2] = {2, 3}, segments[2] = {3, 2};
    kn_status status = kn_bezier_init(ctx, &p, 2, 3, false, degree);
    for (size_t i = 0; status == KN_OK && i < 36; i++) p.coef[i] = (double)((i * i * 7) % 11);
    kn_mesh mesh = {0};
    for (size_t k = 0; k < 2 && status == KN_OK; k++) {
        status = kn_mesh_add_patch(ctx, &mesh, &p, segments, false);
        if (status != KN_OK) assert_true(mesh.nvertices == 12 * k && mesh.ntriangles == 12 * k);
    }
    kn_mesh_clear(ctx, &mesh);
    kn_bezier_clear(ctx, &p);
    return status;
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    test_allocation_failures(add_twice, NULL);
}

// Growth is geometric: a thousand patches ask for memory a few dozen times.
static void growth_is_geometric(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_bezier p = sphere_octant(ctx);
    kn_mesh mesh = {0};
    size_t before = memory.calls;
    for (int i = 0; i < 1000; i++) add(ctx, &mesh, &p, 2, 2, false);
    assert_true(memory.calls - before < 80);
    kn_mesh_clear(ctx, &mesh);
    kn_bezier_clear(ctx, &p);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_rectangle_is_exact),
        cmocka_unit_test(a_sphere_is_its_own_normal),
        cmocka_unit_test(a_cone_keeps_its_normals_at_the_apex),
        cmocka_unit_test(normals_where_nothing_helps),
        cmocka_unit_test(edges_depend_on_their_control_points_alone),
        cmocka_unit_test(vertices_agree_with_evaluation),
        cmocka_unit_test(refusals_leave_the_mesh_alone),
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(growth_is_geometric),
    };
    return cmocka_run_group_tests_name("mesh/add_patch", tests, NULL, NULL);
}
