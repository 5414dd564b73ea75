// SPDX-License-Identifier: Apache-2.0
// Meshes cut along segments: areas against the shoelace formula of the outline, volumes, conforming, not crossed by any
// segment, and the same on both sides of an edge.
#include "tests/support/support.h"

#include <knurl/mesh.h>

#include <math.h>
#include <string.h>

enum { GRID = 5, STAR = 17 };
static const double near = 1e-9;

typedef struct sheet {
    double position[3 * (GRID + 1) * (GRID + 1)], normal[3 * (GRID + 1) * (GRID + 1)];
    uint32_t triangle[6 * GRID * GRID];
    kn_mesh mesh;
} sheet;

// The square [0,1]^2 on a grid whose inner corners are moved, at heights a + b u + c v.
static void make_sheet(sheet *s, test_rng *rng, double a, double b, double c)
{
    size_t n = 0;
    for (int i = 0; i <= GRID; i++)
        for (int j = 0; j <= GRID; j++) {
            double *p = s->position + 3 * (i * (GRID + 1) + j), *m = s->normal + 3 * (i * (GRID + 1) + j);
            p[0] = (i + (i % GRID ? test_uniform(rng, -0.3, 0.3) : 0)) / GRID;
            p[1] = (j + (j % GRID ? test_uniform(rng, -0.3, 0.3) : 0)) / GRID;
            p[2] = a + b * p[0] + c * p[1];
            m[0] = 0.6, m[1] = 0, m[2] = 0.8;
        }
    for (int i = 0; i < GRID; i++)
        for (int j = 0; j < GRID; j++) {
            uint32_t k = (uint32_t)(i * (GRID + 1) + j), l = k + GRID + 1, t[6] = {k, l, l + 1, k, l + 1, k + 1};
            memcpy(s->triangle + n, t, sizeof t);
            n += 6;
        }
    s->mesh = (kn_mesh){.nvertices = (GRID + 1) * (GRID + 1), .ntriangles = (size_t)2 * GRID * GRID};
    s->mesh.position = s->position, s->mesh.normal = s->normal, s->mesh.triangle = s->triangle;
}

// A star about (x, y), counterclockwise; returns its area.
static double make_star(kn_mesh_segment *out, test_rng *rng, double x, double y, double lo, double hi)
{
    double at[STAR][2], area = 0;
    for (int i = 0; i < STAR; i++) {
        double r = test_uniform(rng, lo, hi), angle = 2 * acos(-1.0) * i / STAR;
        at[i][0] = x + r * cos(angle), at[i][1] = y + r * sin(angle);
    }
    for (int i = 0; i < STAR; i++) {
        const double *p = at[i], *q = at[(i + 1) % STAR];
        out[i] = (kn_mesh_segment){{p[0], p[1]}, {q[0], q[1]}};
        area += (p[0] * q[1] - p[1] * q[0]) / 2;
    }
    return area;
}

static const double *corner(const kn_mesh *m, size_t t, size_t k)
{
    return m->position + 3 * (size_t)m->triangle[3 * t + k % 3];
}

static double cross(const double *o, const double *a, const double *b)
{
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
}

static bool winds(const kn_mesh_segment *s, int n, double x, double y)
{
    bool in = false;
    for (int i = 0; i < n; i++) {
        const double *a = s[i].from, *b = s[i].to;
        if ((a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) in = !in;
    }
    return in;
}

// Seen from above, of triangles whose middle lies inside the outline, and of all.
static void areas(double out[2], const kn_mesh *m, const kn_mesh_segment *s, int n)
{
    out[0] = out[1] = 0;
    for (size_t t = 0; t < m->ntriangles; t++) {
        const double *p = corner(m, t, 0), *q = corner(m, t, 1), *r = corner(m, t, 2);
        double area = cross(p, q, r) / 2;
        out[1] += area;
        if (winds(s, n, (p[0] + q[0] + r[0]) / 3, (p[1] + q[1] + r[1]) / 3)) out[0] += area;
    }
}

static double volume(const kn_mesh *m)
{
    double sum = 0;
    for (size_t t = 0; t < m->ntriangles; t++) {
        const double *p = corner(m, t, 0), *q = corner(m, t, 1), *r = corner(m, t, 2);
        sum += p[2] * cross(p, q, r) / 6 + q[2] * cross(p, q, r) / 6 + r[2] * cross(p, q, r) / 6;
    }
    return sum;
}

// No point of a segment is inside a triangle, clear of its edges.
static void assert_not_crossed(const kn_mesh *m, const kn_mesh_segment *s, int n)
{
    for (int i = 0; i < n; i++)
        for (int k = 0; k <= 32; k++) {
            const double at[2] = {s[i].from[0] + k / 32.0 * (s[i].to[0] - s[i].from[0]),
                                  s[i].from[1] + k / 32.0 * (s[i].to[1] - s[i].from[1])};
            for (size_t t = 0; t < m->ntriangles; t++) {
                double least = INFINITY;
                for (size_t e = 0; e < 3; e++) {
                    const double *p = corner(m, t, e), *q = corner(m, t, e + 1);
                    least = fmin(least, cross(p, q, at) / fmax(hypot(q[0] - p[0], q[1] - p[1]), 1e-12));
                }
                assert_true(least <= 4 * near);
            }
        }
}

static void stars(void **state)
{
    (void)state;
    test_rng rng = test_random(71);
    for (int round = 0; round < 8 * test_scale(1); round++) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 1);
        static sheet flat;
        kn_mesh_segment star[STAR];
        kn_mesh cut = {0};
        kn_mesh_topology before, after;
        double b = test_uniform(&rng, -1, 1), c = test_uniform(&rng, -1, 1), got[2];
        make_sheet(&flat, &rng, 0.25, b, c);
        double want = make_star(star, &rng, 0.5, 0.5, 0.02, 0.45);
        assert_int_equal(kn_mesh_copy(ctx, &cut, &flat.mesh), KN_OK);
        assert_int_equal(kn_mesh_survey(ctx, &before, &cut), KN_OK);
        assert_int_equal(kn_mesh_cut(ctx, &cut, star, STAR, near), KN_OK);
        assert_int_equal(kn_mesh_survey(ctx, &after, &cut), KN_OK);
        assert_true(cut.ntriangles > flat.mesh.ntriangles + STAR);
        assert_memory_equal(cut.position, flat.position, sizeof flat.position);
        // one disk still, bounded by the edges of the square, none of which the star reaches
        assert_true(after.components == 1 && after.loops == 1 && after.euler == 1 && after.irregular == 0);
        assert_int_equal(after.border, before.border);
        assert_not_crossed(&cut, star, STAR);
        areas(got, &cut, star, STAR);
        // within `near` of the outline, shorter than 2 STAR, and of each edge of the mesh that passes a corner
        assert_true(fabs(got[0] - want) <= 4 * STAR * near && fabs(got[1] - 1) <= 4 * STAR * near);
        for (size_t v = 0; v < cut.nvertices; v++) { // on the same plane, but for `near`; normals are the same
            const double *p = cut.position + 3 * v, *n = cut.normal + 3 * v;
            assert_true(fabs(p[2] - (0.25 + b * p[0] + c * p[1])) <= 3 * near);
            assert_true(fabs(n[0] - 0.6) <= 1e-15 && n[1] == 0 && fabs(n[2] - 0.8) <= 1e-15);
        }
        kn_mesh_clear(ctx, &cut);
        test_ctx_end(ctx, &memory);
    }
}

// A box: its walls stand upright. It stays closed, keeps its volume, and its walls are cut where the star crosses them.
static void walls(void **state)
{
    (void)state;
    static const uint32_t quads[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                         {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    test_rng rng = test_random(72);
    for (int round = 0; round < 8; round++) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 1);
        kn_mesh_segment star[STAR];
        double position[24];
        uint32_t triangle[36];
        kn_mesh cut = {0}, box = {.nvertices = 8, .ntriangles = 12, .position = position, .triangle = triangle};
        kn_mesh_topology t;
        for (int i = 0; i < 8; i++) {
            position[3 * i] = 0.25 + 0.5 * (i >> 2 & 1), position[3 * i + 1] = 0.25 + 0.5 * (i >> 1 & 1);
            position[3 * i + 2] = i & 1;
        }
        for (int q = 0; q < 6; q++) {
            const uint32_t *c = quads[q], v[6] = {c[0], c[1], c[2], c[0], c[2], c[3]};
            memcpy(triangle + 6 * q, v, sizeof v);
        }
        if (round % 2 == 0) { // along two walls and into corners, bit for bit
            for (int i = 0; i < STAR; i++) star[i] = (kn_mesh_segment){{0.25, 0.25}, {0.25, 0.25}};
            star[0] = (kn_mesh_segment){{0.25, 0.25}, {0.75, 0.25}},
            star[1] = (kn_mesh_segment){{0.75, 0.25}, {0.75, 1}};
            star[2] = (kn_mesh_segment){{0.75, 1}, {0.25, 0.25}};
        } else {
            (void)make_star(star, &rng, 0.25, 0.5, 0.05, 0.5);
        }
        assert_int_equal(kn_mesh_copy(ctx, &cut, &box), KN_OK);
        assert_int_equal(kn_mesh_cut(ctx, &cut, star, STAR, near), KN_OK);
        assert_int_equal(kn_mesh_survey(ctx, &t, &cut), KN_OK);
        assert_true(t.components == 1 && t.border == 0 && t.irregular == 0 && t.euler == 2);
        assert_true(fabs(fabs(volume(&cut)) - 0.25) <= 64 * near);
        assert_true(cut.nvertices > 8);
        assert_not_crossed(&cut, star, STAR);
        double top = 0; // of one side, by its triangles' heights: the walls' area inside is their length inside
        for (size_t i = 0; i < cut.ntriangles; i++) {
            double lo = INFINITY, hi = -INFINITY;
            for (size_t k = 0; k < 3; k++) {
                const double *p = corner(&cut, i, k), *q = corner(&cut, i, k + 1);
                for (int s = 0; s < STAR; s++) { // no edge crosses a segment
                    double a = cross(star[s].from, star[s].to, p), b = cross(star[s].from, star[s].to, q);
                    double c = cross(p, q, star[s].from), d = cross(p, q, star[s].to);
                    assert_false(fmin(fabs(a), fmin(fabs(b), fmin(fabs(c), fabs(d)))) > 4 * near && a * b < 0 &&
                                 c * d < 0);
                }
                lo = fmin(lo, p[2]), hi = fmax(hi, p[2]);
            }
            top = fmax(top, hi - lo);
        }
        assert_true(top <= 1);
        kn_mesh_clear(ctx, &cut);
        test_ctx_end(ctx, &memory);
    }
}

// Vertices on the line u = x, in order.
static int on_line(double (*out)[3], const kn_mesh *m, double x)
{
    int n = 0;
    for (size_t v = 0; v < m->nvertices; v++) {
        const double *p = m->position + 3 * v;
        if (p[0] != x) continue;
        int k = n++;
        for (; k > 0 && out[k - 1][1] > p[1]; k--) memcpy(out[k], out[k - 1], sizeof *out);
        out[k][0] = 0, out[k][1] = p[1], out[k][2] = p[2];
    }
    return n;
}

// Two triangles with one edge, each in the coordinates of its own cell, and the segments in another order.
static void both_sides_agree(void **state)
{
    (void)state;
    test_rng rng = test_random(73);
    for (int round = 0; round < 20; round++) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 1);
        double a = test_uniform(&rng, 0, 0.2), b = test_uniform(&rng, 0.8, 1), z[2] = {0.3, test_uniform(&rng, 0, 1)};
        double left[9] = {0.1, 0.5, 0.7, 1, a, z[0], 1, b, z[1]}, right[9] = {0.9, 0.4, 0, 0, b, z[1], 0, a, z[0]};
        uint32_t corners[3] = {0, 1, 2};
        kn_mesh one = {.nvertices = 3, .ntriangles = 1, .position = left, .triangle = corners}, two = one, cut = {0};
        kn_mesh_segment star[STAR], other[STAR];
        double at[2][4 * STAR][3];
        int n[2];
        two.position = right;
        (void)make_star(star, &rng, 1, 0.5, 0.05, 0.28);
        for (int i = 0; i < STAR; i++)
            for (int d = 0; d < 2; d++) { // on a lattice, so that shifts are exact
                star[i].from[d] = rint(star[i].from[d] * 0x1p40) * 0x1p-40;
                star[i].to[d] = rint(star[i].to[d] * 0x1p40) * 0x1p-40;
            }
        if (round % 4 == 0) star[0].from[0] = star[STAR - 1].to[0] = 1; // a corner on the edge
        for (int i = 0; i < STAR; i++) {
            other[i] = star[STAR - 1 - i];
            other[i].from[0] -= 1, other[i].to[0] -= 1;
        }
        for (int k = 0; k < 2; k++) {
            assert_int_equal(kn_mesh_copy(ctx, &cut, k == 0 ? &one : &two), KN_OK);
            assert_int_equal(kn_mesh_cut(ctx, &cut, k == 0 ? star : other, STAR, near), KN_OK);
            n[k] = on_line(at[k], &cut, 1 - k);
        }
        assert_true(n[0] >= 4);
        assert_int_equal(n[0], n[1]);
        assert_memory_equal(at[0], at[1], (size_t)n[0] * sizeof at[0][0]);
        kn_mesh_clear(ctx, &cut);
        test_ctx_end(ctx, &memory);
    }
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double position[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    uint32_t triangle[3] = {0, 1, 2};
    kn_mesh mesh = {.nvertices = 3, .ntriangles = 1, .position = position, .triangle = triangle};
    kn_mesh_segment s = {{0.2, -1}, {0.2, 2}};
    const double bad[3] = {0, -1, INFINITY};
    for (int k = 0; k < 3; k++) assert_int_equal(kn_mesh_cut(ctx, &mesh, &s, 1, bad[k]), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    s.to[1] = NAN;
    assert_int_equal(kn_mesh_cut(ctx, &mesh, &s, 1, near), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "segment 0"));
    kn_ctx_clear_error(ctx);
    s.to[1] = 2, triangle[2] = 3;
    assert_int_equal(kn_mesh_cut(ctx, &mesh, &s, 1, near), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "vertex 3 of 3"));
    assert_true(mesh.position == position && mesh.ntriangles == 1 && mesh.nvertices == 3);
    test_ctx_end(ctx, &memory);
}

static kn_status cut_call(kn_ctx *ctx, void *user)
{
    const sheet *flat = user;
    test_rng rng = test_random(74);
    kn_mesh_segment star[STAR];
    kn_mesh cut = {0};
    (void)make_star(star, &rng, 0.5, 0.5, 0.3, 0.45);
    kn_status status = kn_mesh_copy(ctx, &cut, &flat->mesh);
    size_t n = cut.ntriangles;
    if (status == KN_OK) status = kn_mesh_cut(ctx, &cut, star, STAR, near);
    assert_true((status == KN_OK) == (cut.ntriangles > n));
    kn_mesh_clear(ctx, &cut);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    static sheet flat;
    test_rng rng = test_random(75);
    make_sheet(&flat, &rng, 0, 0, 0);
    test_allocation_failures(cut_call, &flat);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(stars), cmocka_unit_test(walls),
                                       cmocka_unit_test(both_sides_agree), cmocka_unit_test(failures),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("mesh/cut", tests, NULL, NULL);
}
