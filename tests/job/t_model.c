// SPDX-License-Identifier: Apache-2.0
// Curves, volumes and meshes as tiles, through jobs: against T(D) in long double, counts, faces that are hidden, and
// what they look like.
#include "tests/support/kinds.h"
#include "tests/support/scene.h"

#include <float.h>
#include <math.h>
#include <string.h>

// A bar from u = 0 to u = 1 as two boxes, and one box on the first; a curve across the cell that crosses into the
// next one; a pyramid as a mesh on the border u = 1 whose base goes from v = 0 to v = 1.
static void make_tile(kn_ctx *ctx, kn_tile *out)
{
    static const double boxes[3][6] = {
        {0, 0.25, 0, 0.5, 0.75, 0.5}, {0.5, 0.25, 0, 1, 0.75, 0.5}, {0, 0.25, 0.5, 0.5, 0.75, 1}};
    static const double line[6] = {0.25, 0.125, 0, 1.25, 0.125, 1};
    static double position[15] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.5, 0.75};
    static uint32_t triangle[12] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
    const kn_mesh mesh = {.nvertices = 5, .ntriangles = 4, .position = position, .triangle = triangle};
    kn_spline s = {0};
    assert_int_equal(kn_tile_init(ctx, out, "kinds", 3), KN_OK);
    for (int k = 0; k < 3; k++) {
        double corner[24];
        for (int i = 0; i < 8; i++)
            for (int c = 0; c < 3; c++) corner[3 * i + c] = boxes[k][(i >> (2 - c) & 1) ? 3 + c : c];
        scene_multilinear(ctx, &s, 3, corner);
        assert_int_equal(kn_tile_add(ctx, out, 0, &s), KN_OK);
    }
    scene_multilinear(ctx, &s, 1, line);
    assert_int_equal(kn_tile_add(ctx, out, 1, &s), KN_OK);
    assert_int_equal(kn_tile_set_mesh(ctx, out, 2, &mesh), KN_OK);
    for (int p = 0; p < 3; p++) out->parts[p].name[0] = (char)('a' + p);
    kn_spline_clear(ctx, &s);
}

static kn_job *make_job(kn_ctx *ctx, const kn_spline *base, const kn_tile *tile, int u, int v, double height,
                        double mesh_tol)
{
    kn_job *job = NULL;
    kn_job_options o = kn_job_defaults();
    o.count[0] = u, o.count[1] = v, o.height = height, o.mesh_tol = mesh_tol;
    assert_int_equal(kn_job_create(ctx, &job, base, 1, tile, &o), KN_OK);
    return job;
}

// Every curve and volume is T(D) in 27 places.
static void composed_exactly(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    kn_spline base = {0};
    kn_tile tile = {0};
    scene_bicubic(ctx, &base, 0.3);
    make_tile(ctx, &tile);
    kn_job *job = make_job(ctx, &base, &tile, 3, 2, 0.1, 1);
    scene_result r = {0};
    scene_run(ctx, job, &r);
    kn_job_report report = kn_job_describe(job);
    assert_int_equal(report.volumes, 3 * 6);
    assert_int_equal(report.curves, 2 * 6); // cut at the cell line
    assert_int_equal(report.meshes, 6);
    assert_int_equal(report.patches, r.count);
    for (size_t i = 0; i < r.count; i++) {
        const kn_patch *p = &r.patches[i];
        if (p->id.part == 2) continue;
        assert_int_equal(p->bezier.nvars, p->id.part == 0 ? 3 : 1);
        kn_bezier d = {0};
        kn_patch_place place;
        assert_int_equal(kn_job_source(ctx, &d, &place, job, &p->id), KN_OK);
        for (int k = 0; k < 27; k++) {
            const double at[3] = {k / 9 / 2.0, k / 3 % 3 / 2.0, k % 3 / 2.0};
            double uvw[3], got[3], want[3];
            assert_int_equal(kn_bezier_eval(ctx, uvw, &d, at), KN_OK);
            assert_int_equal(kn_bezier_eval(ctx, got, &p->bezier, at), KN_OK);
            if (place.cell[0] + uvw[0] > 3) continue; // beyond the end S + w n goes on otherwise (job.h)
            long double u = scene_parameter(job, place.surface, 0, place.cell[0] + (long double)uvw[0]);
            long double v = scene_parameter(job, place.surface, 1, place.cell[1] + (long double)uvw[1]);
            assert_int_equal(kn_shell_eval(ctx, want, NULL, kn_job_shell(job, 0), (double)u, (double)v, uvw[2]),
                             KN_OK);
            // n in use is within normal_tol of the shell's, or is it; beside that rounding
            assert_true(test_max_difference(got, want, 3) <= report.stand_in_error + 1e-12);
        }
        kn_bezier_clear(ctx, &d);
    }
    scene_result_clear(&r);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile), kn_spline_clear(ctx, &base);
    test_ctx_end(ctx, &memory);
}

// Vertices of meshes are T of their places, and those on the line between two cells are the same in both.
static void meshes_meet(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline base = {0};
    kn_tile tile = {0};
    scene_cylinder(ctx, &base); // closed in u
    make_tile(ctx, &tile);
    kn_job *job = make_job(ctx, &base, &tile, 8, 3, 0.1, 0.01);
    scene_result r = {0};
    scene_run(ctx, job, &r);
    size_t triangles = 0, nmeshes = 0;
    const kn_mesh *at[8][3] = {{NULL}};
    for (size_t i = 0; i < r.count; i++) {
        if (!r.patches[i].mesh) continue;
        const kn_patch_id *id = &r.patches[i].id;
        assert_true(id->part == 2 && id->patch == 0 && r.patches[i].exact);
        at[id->cell[0]][id->cell[1]] = r.patches[i].mesh;
        triangles += r.patches[i].mesh->ntriangles;
        nmeshes++;
    }
    assert_int_equal(nmeshes, 24);
    assert_true(triangles > 24 * 4); // their edges were split
    for (int c = 0; c < 24; c++) {
        const kn_mesh *m = at[c / 3][c % 3], *next = at[(c / 3 + 1) % 8][c % 3];
        double w[3] = {0, 0, 0.75 * 0.1}, want[3];
        double u = (double)scene_parameter(job, 0, 0, c / 3 + 0.5L),
               v = (double)scene_parameter(job, 0, 1, c % 3 + 0.5L);
        assert_int_equal(kn_shell_eval(ctx, want, NULL, kn_job_shell(job, 0), u, v, w[2]), KN_OK);
        assert_true(test_max_difference(m->position + 12, want, 3) <= 1e-13); // a few roundings of u, v
        // u = 1 of this cell and u = 0 of the next one: every vertex of one that lies there is one of the other
        int common = 0;
        for (size_t i = 0; i < m->nvertices; i++)
            for (size_t j = 0; j < next->nvertices; j++) {
                double d = test_max_difference(m->position + 3 * i, next->position + 3 * j, 3);
                assert_true(d == 0 || d > 1e-6);
                common += d == 0;
            }
        assert_true(common >= 2);
    }
    scene_result_clear(&r);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile), kn_spline_clear(ctx, &base);
    test_ctx_end(ctx, &memory);
}

// Every directed edge has as many opposites: no gap, up to rounding, which is looked at with a hash of rounded
// points.
static bool is_closed(const kn_mesh *m)
{
    for (size_t e = 0; e < 3 * m->ntriangles; e++) {
        const double *a = m->position + 3 * (size_t)m->triangle[e];
        const double *b = m->position + 3 * (size_t)m->triangle[e % 3 == 2 ? e - 2 : e + 1];
        int balance = 0;
        for (size_t f = 0; f < 3 * m->ntriangles; f++) {
            const double *p = m->position + 3 * (size_t)m->triangle[f];
            const double *q = m->position + 3 * (size_t)m->triangle[f % 3 == 2 ? f - 2 : f + 1];
            balance += test_max_difference(a, p, 3) <= 1e-12 && test_max_difference(b, q, 3) <= 1e-12;
            balance -= test_max_difference(a, q, 3) <= 1e-12 && test_max_difference(b, p, 3) <= 1e-12;
        }
        if (balance != 0) return false;
    }
    return true;
}

// Faces between volumes are hidden, in the cell and between cells; at open ends they are not. What is left is closed.
static void outside_of_volumes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline base = {0};
    kn_tile tile = {0};
    scene_bicubic(ctx, &base, 0.3);
    make_tile(ctx, &tile);
    for (int sign = -1; sign <= 1; sign += 2) {
        kn_job *job = make_job(ctx, &base, &tile, 2, 1, 0.05 * sign, 1);
        scene_result r = {0};
        kn_mesh mesh = {0};
        scene_run(ctx, job, &r);
        size_t faces = 0;
        for (size_t i = 0; i < r.count; i++) {
            const kn_patch *p = &r.patches[i];
            if (p->bezier.nvars != 3) continue;
            // boxes 0 and 1 hide each other's sides, box 2 lies on the first; cells hide each other's ends
            int cell = p->id.cell[0];
            const int want[3] = {(1 << 1) | (1 << 5) | (cell == 1) << 0, (1 << 0) | (cell == 0) << 1, 1 << 4};
            assert_int_equal(p->hidden, want[p->id.patch]);
            for (int k = 0; k < 6; k++) faces += !(p->hidden >> k & 1);
            assert_int_equal(kn_patch_tessellate(ctx, &mesh, p), KN_OK);
        }
        assert_int_equal(faces, 2 * (18 - 4) - 2);
        assert_true(is_closed(&mesh));
        double sum = 0; // six times the volume: positive when triangles look outside
        for (size_t t = 0; t < mesh.ntriangles; t++) {
            const double *p = mesh.position + 3 * (size_t)mesh.triangle[3 * t];
            const double *q = mesh.position + 3 * (size_t)mesh.triangle[3 * t + 1];
            const double *s = mesh.position + 3 * (size_t)mesh.triangle[3 * t + 2];
            sum += p[0] * (q[1] * s[2] - q[2] * s[1]) + p[1] * (q[2] * s[0] - q[0] * s[2]) +
                   p[2] * (q[0] * s[1] - q[1] * s[0]);
        }
        assert_true(sum > 0);
        kn_mesh_clear(ctx, &mesh);
        scene_result_clear(&r);
        kn_job_destroy(ctx, job);
    }
    kn_tile_clear(ctx, &tile), kn_spline_clear(ctx, &base);
    test_ctx_end(ctx, &memory);
}

static void lines_of_curves(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double c[12] = {0, 1, 2, 4, 0, 0, 1, 1, 5, 5, 5, 5}, points[15];
    const int cubic = 3;
    kn_patch p = {.bezier = {.nvars = 1, .ncomp = 3, .coef = c}, .segments = {4, 4, 4}}, face = {0};
    p.bezier.degree[0] = cubic;
    kn_mesh mesh = {0};
    assert_int_equal(kn_patch_line_points(&p), 5);
    assert_int_equal(kn_patch_line(ctx, points, &p), KN_OK);
    for (int i = 0; i < 5; i++) {
        double t = i / 4.0, s = 1 - t, x = 3 * s * s * t + 6 * s * t * t + 4 * t * t * t;
        assert_true(fabs(points[3 * i] - x) <= 8 * DBL_EPSILON);
        assert_true(points[3 * i + 2] == 5);
    }
    assert_int_equal(kn_patch_tessellate(ctx, &mesh, &p), KN_OK); // nothing
    assert_int_equal(mesh.nvertices, 0);
    assert_int_equal(kn_patch_face(ctx, &face, &p, 0), KN_EDOMAIN);
    p.bezier.nvars = 2;
    assert_int_equal(kn_patch_line(ctx, points, &p), KN_EDOMAIN);
    assert_int_equal(kn_patch_line_points(&p), 0);
    double box[24];
    for (int i = 0; i < 24; i++) box[i] = i < 8 ? i >> 2 & 1 : i < 16 ? i >> 1 & 1 : i & 1;
    kn_patch v = {.bezier = {.nvars = 3, .ncomp = 3, .degree = {1, 1, 1}, .coef = box}, .segments = {1, 1, 1}};
    assert_int_equal(kn_patch_face(ctx, &face, &v, 6), KN_EDOMAIN);
    for (int k = 0; k < 6; k++) { // unit normals of the unit cube
        assert_int_equal(kn_patch_face(ctx, &face, &v, k), KN_OK);
        mesh.nvertices = mesh.ntriangles = 0;
        assert_int_equal(kn_mesh_add_patch(ctx, &mesh, &face.bezier, face.segments, face.reversed), KN_OK);
        for (int i = 0; i < 3; i++) assert_true(mesh.normal[i] == (i == k / 2 ? 2 * (k % 2) - 1 : 0));
        kn_bezier_clear(ctx, &face.bezier);
    }
    v.hidden = 1 | 1 << 3;
    mesh.nvertices = mesh.ntriangles = 0;
    assert_int_equal(kn_patch_tessellate(ctx, &mesh, &v), KN_OK);
    assert_int_equal(mesh.ntriangles, 8);
    kn_mesh bare = {.nvertices = 3, .position = box};
    assert_int_equal(kn_mesh_append(ctx, &mesh, &bare), KN_EDOMAIN); // no normals
    kn_mesh twice = {0};
    for (int k = 0; k < 2; k++) assert_int_equal(kn_mesh_append(ctx, &twice, &mesh), KN_OK);
    assert_int_equal(twice.ntriangles, 16);
    assert_int_equal(twice.triangle[24], mesh.triangle[0] + mesh.nvertices);
    kn_mesh_clear(ctx, &mesh), kn_mesh_clear(ctx, &twice);
    test_ctx_end(ctx, &memory);
}

static kn_status tessellate_call(kn_ctx *ctx, void *user)
{
    (void)user;
    double box[24];
    for (int i = 0; i < 24; i++) box[i] = i < 8 ? i >> 2 & 1 : i < 16 ? i >> 1 & 1 : i & 1;
    const kn_patch v = {.bezier = {.nvars = 3, .ncomp = 3, .degree = {1, 1, 1}, .coef = box}, .segments = {1, 1, 1}};
    double c[6] = {0, 1, 0, 1, 0, 1}, points[6];
    const kn_patch line = {.bezier = {.nvars = 1, .ncomp = 3, .degree = {1}, .coef = c}, .segments = {1, 1, 1}};
    kn_mesh mesh = {0}, other = {0};
    kn_status status = kn_patch_tessellate(ctx, &mesh, &v);
    if (status != KN_OK) assert_int_equal(mesh.ntriangles, 0);
    if (status == KN_OK) status = kn_mesh_append(ctx, &other, &mesh);
    if (status == KN_OK) status = kn_patch_line(ctx, points, &line);
    kn_mesh_clear(ctx, &mesh), kn_mesh_clear(ctx, &other);
    return status;
}

static kn_status job_call(kn_ctx *ctx, void *user)
{
    const kn_tile *tile = ((void **)user)[1];
    kn_job *job = NULL;
    kn_job_options o = kn_job_defaults();
    o.count[0] = o.count[1] = 1, o.height = 0.1, o.mesh_tol = 0.1;
    kn_status status = kn_job_create(ctx, &job, ((void **)user)[0], 1, tile, &o);
    kn_job_destroy(ctx, job);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline base = {0};
    kn_tile tile = {0};
    test_allocation_failures(tessellate_call, NULL);
    scene_bicubic(ctx, &base, 0.1);
    make_tile(ctx, &tile);
    void *both[2] = {&base, &tile};
    test_allocation_failures(job_call, both);
    kn_tile_clear(ctx, &tile), kn_spline_clear(ctx, &base);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(composed_exactly), cmocka_unit_test(meshes_meet),
                                       cmocka_unit_test(outside_of_volumes), cmocka_unit_test(lines_of_curves),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("job/model", tests, NULL, NULL);
}
