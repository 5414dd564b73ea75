// SPDX-License-Identifier: Apache-2.0
// kn_mesh_add_trimmed: areas, orientation, closed meshes of both sides of cuts, edges shared with neighbours, failures.
#include "tests/support/support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <knurl/mesh.h>

// (r, t) itself over the plane z = 0, or a saddle over it, elevated to the degrees.
static void make_patch(kn_ctx *ctx, kn_bezier *out, int n, int m, double bend)
{
    assert_int_equal(kn_bezier_init(ctx, out, 2, 3, false, (int[]){n, m}), KN_OK);
    size_t count = kn_bezier_count(out);
    for (int i = 0; i <= n; i++)
        for (int j = 0; j <= m; j++) {
            size_t at = (size_t)(i * (m + 1) + j);
            out->coef[at] = (double)i / n, out->coef[count + at] = (double)j / m;
            out->coef[2 * count + at] = bend * i * (n - i) - bend * j * (m - j);
        }
}

static void random_function(kn_ctx *ctx, kn_bezier *f, test_rng *rng)
{
    assert_int_equal(kn_bezier_init(ctx, f, 2, 1, false, (int[]){test_int(rng, 1, 4), test_int(rng, 1, 4)}), KN_OK);
    for (size_t i = 0; i < kn_bezier_count(f); i++) f->coef[i] = test_uniform(rng, -1.0, 1.0);
}

// Twice the area of triangle k in the plane.
static double area_of(const kn_mesh *mesh, size_t k)
{
    const uint32_t *c = &mesh->triangle[3 * k];
    const double *p = &mesh->position[3 * c[0]], *q = &mesh->position[3 * c[1]], *r = &mesh->position[3 * c[2]];
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
}

// The integral of x dy - y dx along polylines is twice the area.
static double trim_area(const kn_trim *trim)
{
    double area = 0.0;
    for (int i = 0; i < trim->ncurves; i++) {
        const kn_spline *c = &trim->curves[i];
        int n = c->count[0];
        for (int k = 0; k + 1 < n; k++) area += c->coef[k] * c->coef[n + k + 1] - c->coef[k + 1] * c->coef[n + k];
    }
    return trim->nloops > 0 ? area : 2.0;
}

typedef struct side {
    double from[3], to[3];
} side;

static int compare(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(side));
}

static double plus_zero(double x)
{
    return x == 0.0 ? 0.0 : x; // no -0 among what is compared by bits
}

static side side_of(const kn_mesh *mesh, size_t k, int e, bool backwards)
{
    side s;
    const double *p = &mesh->position[3 * mesh->triangle[3 * k + (size_t)(backwards ? (e + 1) % 3 : e)]];
    const double *q = &mesh->position[3 * mesh->triangle[3 * k + (size_t)(backwards ? e : (e + 1) % 3)]];
    for (int c = 0; c < 3; c++) s.from[c] = plus_zero(p[c]), s.to[c] = plus_zero(q[c]);
    return s;
}

// Every side of a triangle is another one's run backwards, by the bits of its points, unless it lies on the square's
// border. Returns how many lie there.
static size_t assert_closed(const kn_mesh *mesh)
{
    size_t n = 3 * mesh->ntriangles, border = 0;
    side *list = test_malloc((n + 1) * sizeof *list);
    for (size_t k = 0; k < n; k++) list[k] = side_of(mesh, k / 3, (int)(k % 3), false);
    qsort(list, n, sizeof *list, compare);
    for (size_t k = 0; k + 1 < n; k++) assert_true(compare(&list[k], &list[k + 1]) != 0);
    for (size_t k = 0; k < n; k++) {
        side back = side_of(mesh, k / 3, (int)(k % 3), true);
        if (bsearch(&back, list, n, sizeof *list, compare)) continue;
        bool on = false;
        for (int c = 0; c < 2; c++)
            on = on || (back.from[c] == back.to[c] && (back.from[c] == 0.0 || back.from[c] == 1.0));
        assert_true(on);
        border++;
    }
    test_free(list);
    return border;
}

// Both sides of a cut, and both sides of each cut again: one closed mesh that covers the square once.
static void cuts_are_closed(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    for (int trial = 0; trial < test_scale(25); trial++) {
        kn_bezier patch = {0}, f[2] = {{0}, {0}};
        kn_trim whole = {0}, half[2] = {0}, part[2] = {0};
        kn_trim_cut_report first, then;
        kn_mesh mesh = {0};
        make_patch(ctx, &patch, 1, 1, 0.0);
        for (int k = 0; k < 2; k++) random_function(ctx, &f[k], &rng);
        const int segments[2] = {1 << test_int(&rng, 0, 5), 1 << test_int(&rng, 0, 5)};
        double sum = 0.0;
        assert_int_equal(kn_trim_cut(ctx, &half[0], &half[1], &first, &whole, &f[0], 2e-3), KN_OK);
        for (int k = 0; k < 2; k++) {
            if (!(k == 0 ? first.below : first.above)) continue;
            assert_int_equal(kn_trim_cut(ctx, &part[0], &part[1], &then, &half[k], &f[1], 2e-3), KN_OK);
            for (int i = 0; i < 2; i++) {
                if (!(i == 0 ? then.below : then.above)) continue;
                size_t before = mesh.ntriangles;
                double area = 0.0;
                assert_int_equal(kn_mesh_add_trimmed(ctx, &mesh, &patch, &part[i], segments, false), KN_OK);
                for (size_t t = before; t < mesh.ntriangles; t++) {
                    assert_true(area_of(&mesh, t) > 0.0);
                    area += area_of(&mesh, t);
                }
                assert_true(fabs(area - trim_area(&part[i])) < 1e-12);
                sum += area;
            }
        }
        assert_true(fabs(sum - 2.0) < 1e-12);
        assert_true(assert_closed(&mesh) >= (size_t)(2 * segments[0] + 2 * segments[1]));
        for (size_t i = 0; i < mesh.nvertices; i++) assert_true(mesh.normal[3 * i + 2] == 1.0);
        for (int k = 0; k < 2; k++) {
            kn_trim_clear(ctx, &half[k]), kn_trim_clear(ctx, &part[k]);
            kn_bezier_clear(ctx, &f[k]);
        }
        kn_bezier_clear(ctx, &patch);
        kn_mesh_clear(ctx, &mesh);
    }
    test_ctx_end(ctx, &memory);
}

static bool has_point(const kn_mesh *mesh, const double *p)
{
    for (size_t i = 0; i < mesh->nvertices; i++)
        if (memcmp(mesh->position + 3 * i, p, 3 * sizeof *p) == 0) return true;
    return false;
}

// A hole in the middle: the points on the edges are the untrimmed patch's, bit for bit; and so are those inside.
static void edges_are_those_of_the_patch(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_bezier patch = {0}, f = {0};
    kn_trim whole = {0}, in = {0}, out = {0};
    kn_trim_cut_report report;
    make_patch(ctx, &patch, 3, 2, 0.1);
    // (r - 1/2)^2 + (t - 1/2)^2 - 1/9
    assert_int_equal(kn_bezier_init(ctx, &f, 2, 1, false, (int[]){2, 2}), KN_OK);
    static const double square[3] = {0.25, -0.25, 0.25};
    for (int k = 0; k < 9; k++) f.coef[k] = square[k / 3] + square[k % 3] - 1.0 / 9.0;
    assert_int_equal(kn_trim_cut(ctx, &in, &out, &report, &whole, &f, 1e-3), KN_OK);
    assert_true(report.below && report.above && out.nloops == 2 && in.nloops == 1);
    for (int reversed = 0; reversed < 2; reversed++)
        for (int s = 3; s <= 12; s += 3) {
            kn_mesh full = {0}, hole = {0}, disk = {0}, none = {0};
            const int segments[2] = {s, s + 1};
            assert_int_equal(kn_mesh_add_patch(ctx, &full, &patch, segments, reversed), KN_OK);
            assert_int_equal(kn_mesh_add_trimmed(ctx, &none, &patch, &whole, segments, reversed), KN_OK);
            assert_memory_equal(none.position, full.position, 3 * full.nvertices * sizeof *full.position);
            assert_int_equal(kn_mesh_add_trimmed(ctx, &hole, &patch, &out, segments, reversed), KN_OK);
            assert_int_equal(kn_mesh_add_trimmed(ctx, &disk, &patch, &in, segments, reversed), KN_OK);
            for (int i = 0; i <= s; i++)
                for (int j = 0; j <= s + 1; j++) {
                    const double *p = full.position + 3 * (i * (s + 2) + j);
                    if (i == 0 || j == 0 || i == s || j == s + 1) assert_true(has_point(&hole, p));
                }
            for (size_t t = 0; t < hole.ntriangles; t++) assert_true((area_of(&hole, t) < 0.0) == (reversed == 1));
            // 1/9 pi, from inside: the area of a polygon of many corners
            double area = 0.0;
            for (size_t t = 0; t < disk.ntriangles; t++) area += 0.5 * area_of(&disk, t);
            assert_true(fabs(fabs(area) - 3.14159265358979 / 9.0) < 2e-3 * 2.1); // tol times the circumference
            kn_mesh_clear(ctx, &full), kn_mesh_clear(ctx, &hole), kn_mesh_clear(ctx, &disk);
            kn_mesh_clear(ctx, &none);
        }
    kn_trim_clear(ctx, &in), kn_trim_clear(ctx, &out);
    kn_bezier_clear(ctx, &patch), kn_bezier_clear(ctx, &f);
    test_ctx_end(ctx, &memory);
}

// A triangle with one curved side, a cubic, run forwards by one region and backwards by the other.
static void make_side(kn_ctx *ctx, kn_trim *trim, bool upper)
{
    static const double corner[2][4] = {{0, 0, 1, 0}, {1, 0, 1, 1}}, other[2][4] = {{1, 1, 0, 1}, {0, 1, 0, 0}};
    static const double knots[2][8] = {{0, 0, 0, 0, 1, 1, 1, 1}, {-1, -1, -1, -1, 0, 0, 0, 0}},
                        line[4] = {0, 0, 1, 1};
    static const double x[4] = {1.0, 0.4, 0.9, 0.0}, y[4] = {1.0, 0.9, 0.2, 0.0};
    *trim = (kn_trim){.curves = NULL};
    kn_trim_cut_report unused;
    kn_bezier f = {0};
    kn_trim a = {0}, b = {0}, whole = {0};
    // a region of three curves, whose last two are then replaced
    assert_int_equal(kn_bezier_init(ctx, &f, 2, 1, false, (int[]){1, 1}), KN_OK);
    f.coef[0] = 0.0, f.coef[1] = 1.0, f.coef[2] = -1.0, f.coef[3] = 0.0; // t - r
    assert_int_equal(kn_trim_cut(ctx, &a, &b, &unused, &whole, &f, 1e-3), KN_OK);
    kn_trim_clear(ctx, upper ? &a : &b);
    *trim = upper ? b : a;
    assert_int_equal(trim->ncurves, 3);
    for (int k = 0; k < 3; k++) {
        double coef[8];
        for (int i = 0; i < 4; i++) coef[i] = upper ? x[3 - i] : x[i], coef[4 + i] = upper ? y[3 - i] : y[i];
        const double *ends = upper ? other[k % 2] : corner[k % 2];
        kn_spline_clear(ctx, &trim->curves[k]);
        if (k == 2)
            assert_int_equal(kn_spline_init(ctx, &trim->curves[k], 1, 2, false, (int[]){3}, (int[]){4},
                                            (const double *[]){knots[upper]}, coef),
                             KN_OK);
        else
            assert_int_equal(kn_spline_init(ctx, &trim->curves[k], 1, 2, false, (int[]){1}, (int[]){2},
                                            (const double *[]){line}, (double[]){ends[0], ends[2], ends[1], ends[3]}),
                             KN_OK);
    }
    kn_bezier_clear(ctx, &f);
}

static void curves_are_sampled_alike(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_bezier patch = {0};
    kn_trim lower, upper;
    kn_mesh mesh = {0};
    make_patch(ctx, &patch, 1, 1, 0.0);
    make_side(ctx, &lower, false), make_side(ctx, &upper, true);
    assert_int_equal(kn_trim_check(ctx, &lower), KN_OK);
    assert_int_equal(kn_trim_check(ctx, &upper), KN_OK);
    assert_int_equal(kn_mesh_add_trimmed(ctx, &mesh, &patch, &lower, (int[]){8, 8}, false), KN_OK);
    assert_int_equal(kn_mesh_add_trimmed(ctx, &mesh, &patch, &upper, (int[]){8, 8}, false), KN_OK);
    assert_int_equal(assert_closed(&mesh), 32);
    double sum = 0.0;
    for (size_t t = 0; t < mesh.ntriangles; t++) sum += area_of(&mesh, t);
    assert_true(fabs(sum - 2.0) < 1e-12);
    kn_mesh_clear(ctx, &mesh);
    kn_bezier_clear(ctx, &patch);
    kn_trim_clear(ctx, &lower), kn_trim_clear(ctx, &upper);
    test_ctx_end(ctx, &memory);
}

static void refusals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_bezier patch = {0}, flat = {0};
    kn_trim trim;
    kn_mesh mesh = {0};
    make_patch(ctx, &patch, 1, 1, 0.0);
    make_side(ctx, &trim, false);
    assert_int_equal(kn_mesh_add_trimmed(ctx, &mesh, &flat, &trim, (int[]){8, 8}, false), KN_EDOMAIN);
    assert_int_equal(kn_mesh_add_trimmed(ctx, &mesh, &patch, &trim, (int[]){0, 8}, false), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    // steps so short that there would be more than 2^20 points
    assert_int_equal(kn_mesh_add_trimmed(ctx, &mesh, &patch, &trim, (int[]){1 << 21, 1}, false), KN_ELIMIT);
    assert_true(mesh.nvertices == 0 && mesh.ntriangles == 0);
    kn_mesh_clear(ctx, &mesh);
    kn_bezier_clear(ctx, &patch);
    kn_trim_clear(ctx, &trim);
    test_ctx_end(ctx, &memory);
}

static kn_status add_one(kn_ctx *ctx, void *user)
{
    const kn_trim *trim = user;
    kn_bezier patch = {
        .nvars = 2, .ncomp = 3, .degree = {1, 1}, .coef = (double[]){0, 0, 1, 1, 0, 1, 0, 1, 0, 0, 0, 0}};
    kn_mesh mesh = {0};
    kn_status status = kn_mesh_add_trimmed(ctx, &mesh, &patch, trim, (int[]){4, 4}, false);
    if (status != KN_OK) assert_true(mesh.nvertices == 0 && mesh.ntriangles == 0);
    kn_mesh_clear(ctx, &mesh);
    return status;
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_trim trim;
    make_side(ctx, &trim, true);
    test_allocation_failures(add_one, &trim);
    kn_trim_clear(ctx, &trim);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cuts_are_closed),           cmocka_unit_test(edges_are_those_of_the_patch),
        cmocka_unit_test(curves_are_sampled_alike),  cmocka_unit_test(refusals),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests_name("mesh/add_trimmed", tests, NULL, NULL);
}
