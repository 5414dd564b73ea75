// SPDX-License-Identifier: Apache-2.0
// Closed meshes on the sphere, and one that turns into another.
#include "tests/mesh/starved.h"
#include "tests/support/support.h"

#include <knurl/mesh.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- bodies ----

static void add_triangle(kn_mesh *m, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *t = m->triangle + 3 * m->ntriangles++;
    t[0] = a, t[1] = b, t[2] = c;
}

static void make_room(kn_ctx *ctx, kn_mesh *out, size_t nvertices, size_t ntriangles)
{
    double *position = calloc(3 * nvertices, sizeof *position);
    uint32_t *triangle = calloc(3 * ntriangles, sizeof *triangle);
    assert_true(position && triangle);
    const kn_mesh m = {.nvertices = nvertices, .ntriangles = ntriangles, .position = position, .triangle = triangle};
    assert_int_equal(kn_mesh_copy(ctx, out, &m), KN_OK);
    out->ntriangles = 0;
    free(position), free(triangle);
}

// Two poles and `rings` circles of n: a body of revolution about z, of radius by height.
static void make_turned(kn_ctx *ctx, kn_mesh *m, int rings, int n, const double (*outline)[2])
{
    make_room(ctx, m, (size_t)(rings * n + 2), (size_t)(2 * rings * n));
    uint32_t un = (uint32_t)n, bottom = (uint32_t)(rings * n), top = bottom + 1;
    for (int r = 0; r < rings; r++)
        for (int k = 0; k < n; k++) {
            double *p = m->position + 3 * (r * n + k), angle = 6.283185307179586 * (k + 0.3) / n;
            p[0] = outline[r + 1][0] * cos(angle), p[1] = outline[r + 1][0] * sin(angle), p[2] = outline[r + 1][1];
        }
    m->position[3 * bottom + 2] = outline[0][1], m->position[3 * top + 2] = outline[rings + 1][1];
    for (uint32_t k = 0; k < un; k++) {
        uint32_t next = (k + 1) % un;
        add_triangle(m, bottom, next, k);
        for (uint32_t r = 0; r + 1 < (uint32_t)rings; r++) {
            add_triangle(m, r * un + k, r * un + next, (r + 1) * un + next);
            add_triangle(m, r * un + k, (r + 1) * un + next, (r + 1) * un + k);
        }
        add_triangle(m, (uint32_t)(rings - 1) * un + k, (uint32_t)(rings - 1) * un + next, top);
    }
}

static void make_ball(kn_ctx *ctx, kn_mesh *m, int rings, int n)
{
    double outline[64][2];
    for (int r = 0; r < rings + 2; r++) {
        double angle = 3.141592653589793 * r / (rings + 1);
        outline[r][0] = sin(angle), outline[r][1] = -cos(angle);
    }
    make_turned(ctx, m, rings, n, (const double(*)[2])outline);
}

// A head with two long ears that bend backwards: not seen as a whole from any point.
static void make_eared(kn_ctx *ctx, kn_mesh *m, int rings, int n)
{
    make_ball(ctx, m, rings, n);
    for (size_t v = 0; v < m->nvertices; v++) {
        double *p = m->position + 3 * v, y = fabs(p[1]) - 0.5, z = p[2] - 0.85;
        double r = 1 + 2 * exp(-12 * (p[0] * p[0] + y * y + z * z));
        for (int c = 0; c < 3; c++) p[c] *= r;
        if (p[2] > 1) p[0] += (p[2] - 1) * (p[2] - 1);
    }
}

// Two needles of triangles at each end, as stored by programs that cut polygons into fans.
static void make_prism(kn_ctx *ctx, kn_mesh *m, int n, double height)
{
    make_room(ctx, m, (size_t)(2 * n), (size_t)(4 * n - 4));
    for (int k = 0; k < 2 * n; k++) {
        double *p = m->position + 3 * k, angle = 6.283185307179586 * (k / 2) / n;
        p[0] = cos(angle), p[1] = sin(angle), p[2] = k % 2 * height;
    }
    for (int k = 0; k < n; k++) {
        uint32_t a = (uint32_t)(2 * k), b = (uint32_t)(2 * ((k + 1) % n));
        add_triangle(m, a, b, b + 1), add_triangle(m, a, b + 1, a + 1);
        if (k >= 1 && k + 1 < n) add_triangle(m, 0, b, a), add_triangle(m, 1, a + 1, b + 1);
    }
}

// A grid of n x 4 around a ring.
static void make_torus(kn_ctx *ctx, kn_mesh *m, uint32_t n)
{
    make_room(ctx, m, (size_t)n * 4, (size_t)n * 8);
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t j = 0; j < 4; j++) {
            double *p = m->position + 3 * (4 * i + j), a = 6.283185307179586 * i / n, b = 1.5707963267948966 * j;
            p[0] = (2 + cos(b)) * cos(a), p[1] = (2 + cos(b)) * sin(a), p[2] = sin(b);
            uint32_t i1 = (i + 1) % n, j1 = (j + 1) % 4;
            add_triangle(m, 4 * i + j, 4 * i1 + j, 4 * i1 + j1);
            add_triangle(m, 4 * i + j, 4 * i1 + j1, 4 * i + j1);
        }
}

// ---- checks ----

static long double det(const double *p, const double *q, const double *r)
{
    long double sum = 0;
    for (int c = 0; c < 3; c++) {
        int d = (c + 1) % 3, e = (c + 2) % 3;
        sum += p[c] * ((long double)q[d] * r[e] - (long double)q[e] * r[d]);
    }
    return sum;
}

// The distance from x to a triangle, by Ericson's regions: brute force and plain.
static double distance_to(const double *x, const double *a, const double *b, const double *c)
{
    double ab[3], ac[3], best = INFINITY;
    const double *corner[3] = {a, b, c};
    double d[5] = {0}; // ab.ab, ab.ac, ac.ac, ax.ab, ax.ac
    for (int k = 0; k < 3; k++) {
        ab[k] = b[k] - a[k], ac[k] = c[k] - a[k];
        d[0] += ab[k] * ab[k], d[1] += ab[k] * ac[k], d[2] += ac[k] * ac[k];
        d[3] += (x[k] - a[k]) * ab[k], d[4] += (x[k] - a[k]) * ac[k];
    }
    double area = d[0] * d[2] - d[1] * d[1], s = (d[3] * d[2] - d[4] * d[1]) / area,
           t = (d[4] * d[0] - d[3] * d[1]) / area;
    if (s >= 0 && t >= 0 && s + t <= 1) {
        best = 0;
        for (int k = 0; k < 3; k++) best += pow(a[k] + s * ab[k] + t * ac[k] - x[k], 2);
        return sqrt(best);
    }
    for (int i = 0; i < 3; i++) {
        const double *p = corner[i], *q = corner[(i + 1) % 3];
        double along = 0, length = 0, sum = 0;
        for (int k = 0; k < 3; k++) along += (x[k] - p[k]) * (q[k] - p[k]), length += (q[k] - p[k]) * (q[k] - p[k]);
        double part = length > 0 ? fmin(fmax(along / length, 0), 1) : 0;
        for (int k = 0; k < 3; k++) sum += pow(p[k] + part * (q[k] - p[k]) - x[k], 2);
        best = fmin(best, sum);
    }
    return sqrt(best);
}

static double distance_to_mesh(const double *x, const kn_mesh *m, const double *position)
{
    double best = INFINITY;
    for (size_t i = 0; i < m->ntriangles; i++) {
        const uint32_t *t = m->triangle + 3 * i;
        best = fmin(best, distance_to(x, position + 3 * t[0], position + 3 * t[1], position + 3 * t[2]));
    }
    return best;
}

static void middle_of(double out[3], const kn_mesh *m, const double *position, size_t triangle)
{
    for (int c = 0; c < 3; c++) {
        out[c] = 0;
        for (int k = 0; k < 3; k++) out[c] += position[3 * m->triangle[3 * triangle + (size_t)k] + (size_t)c] / 3;
    }
}

// Both ways, at vertices and in the middle of triangles. Vertices of faces are weighted means of a triangle's corners,
// however wrong the weights are, hence lie on it to gamma(8) times coordinates below 8. The distance is measured with
// quotients of Gram determinants, which lose 2^-52 over the square of the sine of an angle, 0.01 at least.
static void assert_same_surface(const kn_mesh *m, const double *position, const kn_mesh *source)
{
    const double bound = 1e-11;
    double x[3];
    for (size_t i = 0; i < m->ntriangles; i += 1 + m->ntriangles / 300) {
        middle_of(x, m, position, i);
        assert_true(distance_to_mesh(x, source, source->position) <= bound);
        assert_true(distance_to_mesh(position + 3 * m->triangle[3 * i], source, source->position) <= bound);
    }
    for (size_t i = 0; i < source->ntriangles; i += 1 + source->ntriangles / 60) {
        middle_of(x, source, source->position, i);
        // weights are quotients of determinants of nearly flat cones: an error of 1e-16 over 1e-4 of their area
        assert_true(distance_to_mesh(x, m, position) <= 1e-9);
        assert_true(distance_to_mesh(source->position + 3 * source->triangle[3 * i], m, position) <= bound);
    }
}

static double volume(const kn_mesh *m, const double *position)
{
    long double sum = 0;
    for (size_t i = 0; i < m->ntriangles; i++) {
        const uint32_t *t = m->triangle + 3 * i;
        sum += det(position + 3 * t[0], position + 3 * t[1], position + 3 * t[2]);
    }
    return (double)sum / 6;
}

enum { BODIES = 5 };
static void make_body(kn_ctx *ctx, kn_mesh *m, int which)
{
    static const double cube[4][2] = {{0, -1}, {1.4142135623730951, -1}, {1.4142135623730951, 1}, {0, 1}};
    static const double hourglass[9][2] = {{0, -2},    {1, -1.8},  {1.1, -1.2}, {0.4, -0.5}, {0.1, 0},
                                           {0.4, 0.5}, {1.1, 1.2}, {1, 1.8},    {0, 2}};
    if (which == 0) make_ball(ctx, m, 4, 5);
    if (which == 1) make_turned(ctx, m, 2, 4, cube);
    if (which == 2) make_eared(ctx, m, 15, 16);
    if (which == 3) make_prism(ctx, m, 24, 0.1);
    if (which == 4) make_turned(ctx, m, 7, 9, hourglass);
}

// ---- tests ----

// Every triangle is turned outwards, by a determinant in long double; their areas are those of one sphere. What points
// up in space does on the sphere, for bodies of revolution.
static void spheres(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int body = 0; body < BODIES; body++) {
        kn_mesh m = {0};
        make_body(ctx, &m, body);
        double *x = calloc(6 * m.nvertices, sizeof *x), *again = x + 3 * m.nvertices, sum = 0;
        assert_non_null(x);
        assert_int_equal(kn_mesh_to_sphere(ctx, x, &m), KN_OK);
        for (size_t v = 0; v < m.nvertices; v++)
            assert_true(fabs(hypot(hypot(x[3 * v], x[3 * v + 1]), x[3 * v + 2]) - 1) <= 1e-15);
        for (size_t i = 0; i < m.ntriangles; i++) {
            const double *p[3];
            for (int k = 0; k < 3; k++) p[k] = x + 3 * m.triangle[3 * i + (size_t)k];
            long double value = det(p[0], p[1], p[2]), cosines = 1;
            assert_true(value > 0);
            for (int k = 0; k < 3; k++)
                for (int c = 0; c < 3; c++) cosines += (long double)p[k][c] * p[(k + 1) % 3][c];
            sum += (double)(2 * atan2l(value, cosines));
        }
        assert_true(fabs(sum - 12.566370614359172) <= 1e-12);
        double up = 0;
        for (size_t v = 0; v < m.nvertices; v++) up += x[3 * v + 2] * (m.position[3 * v + 2] > 0.05 ? 1 : -1);
        assert_true(up > 0);
        assert_int_equal(kn_mesh_to_sphere(ctx, again, &m), KN_OK);
        assert_memory_equal(again, x, 3 * m.nvertices * sizeof *x);
        free(x);
        kn_mesh_clear(ctx, &m);
    }
    test_ctx_end(ctx, &memory);
}

// At 0 it is a, at 1 b; the vertices of both are there; it is closed and of genus 0, in every moment the same triangles.
static void morphs(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int body = 0; body < BODIES; body++) {
        kn_mesh a = {0}, b = {0}, m = {0};
        kn_mesh_topology t;
        double *target = NULL;
        make_body(ctx, &a, body), make_body(ctx, &b, (body + 1) % BODIES);
        assert_int_equal(kn_mesh_morph(ctx, &m, &target, &a, &b), KN_OK);
        assert_null(m.normal);
        assert_int_equal(kn_mesh_survey(ctx, &t, &m), KN_OK);
        assert_true(t.components == 1 && t.border == 0 && t.irregular == 0 && t.euler == 2);
        assert_true(t.vertices == m.nvertices && m.nvertices >= a.nvertices + b.nvertices);
        assert_memory_equal(m.position, a.position, 3 * a.nvertices * sizeof *target);
        assert_same_surface(&m, m.position, &a);
        assert_same_surface(&m, target, &b);
        // flat pieces of closed surfaces with nothing between: the volumes are equal
        assert_true(fabs(volume(&m, m.position) - volume(&a, a.position)) <= 1e-11);
        assert_true(fabs(volume(&m, target) - volume(&b, b.position)) <= 1e-11);
        kn_free(ctx, target);
        kn_mesh_clear(ctx, &a), kn_mesh_clear(ctx, &b), kn_mesh_clear(ctx, &m);
    }
    test_ctx_end(ctx, &memory);
}

// A mesh over itself, renumbered: all vertices and edges lie on one another. And one that looks inwards.
static void near_and_turned_over(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_mesh a = {0}, b = {0}, m = {0};
    double *target = NULL;
    make_body(ctx, &a, 0), make_body(ctx, &b, 0);
    for (size_t i = 0; i < b.ntriangles; i++) { // the same surface; another first corner of each triangle
        uint32_t *t = b.triangle + 3 * i, kept = t[0];
        t[0] = t[1], t[1] = t[2], t[2] = kept;
    }
    assert_int_equal(kn_mesh_morph(ctx, &m, &target, &a, &b), KN_OK);
    assert_same_surface(&m, m.position, &a);
    assert_same_surface(&m, target, &b);
    kn_free(ctx, target);
    for (size_t i = 0; i < b.ntriangles; i++) {
        uint32_t *t = b.triangle + 3 * i, kept = t[0];
        t[0] = t[1], t[1] = kept;
    }
    assert_int_equal(kn_mesh_morph(ctx, &m, &target, &b, &a), KN_OK); // as the first looks
    assert_true(fabs(volume(&m, m.position) - volume(&b, b.position)) <= 1e-11 && volume(&b, b.position) < 0);
    assert_true(fabs(volume(&m, target) + volume(&a, a.position)) <= 1e-11);
    kn_free(ctx, target);
    kn_mesh_clear(ctx, &a), kn_mesh_clear(ctx, &b), kn_mesh_clear(ctx, &m);
    test_ctx_end(ctx, &memory);
}

static void refuses(kn_ctx *ctx, const kn_mesh *a, const kn_mesh *b, const char *says)
{
    kn_mesh m = {.nvertices = 7};
    double kept = 0, *target = &kept;
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_mesh_morph(ctx, &m, &target, a, b), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), says));
    assert_true(m.nvertices == 7 && target == &kept);
}

static void refusals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_mesh ball = {0}, torus = {0}, broken = {0}, two = {0};
    make_ball(ctx, &ball, 4, 5), make_torus(ctx, &torus, 5), make_ball(ctx, &broken, 4, 5);
    refuses(ctx, &ball, &torus,
            "the second has 1 components, 0 border loops, genus 1 and 0 irregular edges: it has h");
    refuses(ctx, &torus, &ball, "the first has 1 components, 0 border loops, genus 1");
    broken.ntriangles--;
    refuses(ctx, &broken, &ball,
            "the first has 1 components, 1 border loops, genus 0 and 0 irregular edges: it is open");
    refuses(ctx, &ball, &broken,
            "the first has 1 components, 0 border loops, genus 0 and 0 irregular edges: it is closed");
    broken.ntriangles++;
    double xyz[3 * 22] = {5};
    uint32_t kept = broken.triangle[1];
    broken.triangle[1] = broken.triangle[2], broken.triangle[2] = kept;
    refuses(ctx, &ball, &broken, "3 irregular edges: it is no surface that can be oriented");
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_mesh_to_sphere(ctx, xyz, &broken), KN_EDOMAIN);
    assert_true(xyz[0] == 5);
    make_room(ctx, &two, 2 * ball.nvertices, 2 * ball.ntriangles);
    for (size_t k = 0; k < 2; k++) {
        memcpy(two.position + 3 * k * ball.nvertices, ball.position, 3 * ball.nvertices * sizeof *two.position);
        for (size_t i = 0; i < 3 * ball.ntriangles; i++)
            two.triangle[3 * k * ball.ntriangles + i] = ball.triangle[i] + (uint32_t)(k * ball.nvertices);
    }
    two.ntriangles = 2 * ball.ntriangles;
    refuses(ctx, &ball, &two, "the second has 2 components, 0 border loops");
    // Two balls that share two vertices: of one piece and of Euler characteristic 2 + 2 - 2, but no surface there.
    for (size_t i = 3 * ball.ntriangles; i < 3 * two.ntriangles; i++)
        if (two.triangle[i] == 22 + 20 || two.triangle[i] == 22 + 21) two.triangle[i] -= 22;
    refuses(ctx, &ball, &two, "the surface touches itself at vertex 20");
    kn_mesh_clear(ctx, &ball), kn_mesh_clear(ctx, &torus), kn_mesh_clear(ctx, &broken), kn_mesh_clear(ctx, &two);
    test_ctx_end(ctx, &memory);
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_mesh a = {0}, b = {0};
    make_ball(ctx, &a, 1, 4), make_ball(ctx, &b, 2, 3);
    starved_morph(&a, &b);
    kn_mesh_clear(ctx, &a), kn_mesh_clear(ctx, &b);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(spheres), cmocka_unit_test(morphs),
                                       cmocka_unit_test(near_and_turned_over), cmocka_unit_test(refusals),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("mesh/to_sphere", tests, NULL, NULL);
}
