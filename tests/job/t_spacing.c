// SPDX-License-Identifier: Apache-2.0
// Jobs whose cells are even, free, in rows of different counts, and whose heights follow the stretch.
#include "tests/support/support.h"

#include "tests/support/scene.h"

#include <knurl/knurl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double origin[3] = {0}, axis[3] = {0, 0, 3};

static void make_job(kn_ctx *ctx, kn_job **job, const kn_spline *s, int n, const kn_tile *tile,
                     const kn_job_options *o)
{
    if (kn_job_create(ctx, job, s, n, tile, o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
}

static double ratio(const kn_cells_range *r)
{
    return r->max / r->min;
}

// S at (u,v), and its unit normal.
static void direct(kn_ctx *ctx, double point[3], double normal[3], const kn_spline *s, const double at[2])
{
    double d[9], length = 0;
    assert_int_equal(kn_spline_derivatives(ctx, d, s, at, 1), KN_OK);
    for (int c = 0; c < 3; c++) {
        int e = (c + 1) % 3, f = (c + 2) % 3;
        point[c] = d[c];
        normal[c] = d[3 + e] * d[6 + f] - d[3 + f] * d[6 + e];
        length += normal[c] * normal[c];
    }
    for (int c = 0; c < 3; c++) normal[c] /= sqrt(length);
}

// Every stride-th patch of a tile within its cells, at random parameters, against S + w n: within the certificate
// times |w|, and 1e-12 of coordinates below 10 for rounding.
static void check_patches(kn_ctx *ctx, const kn_job *job, const scene_result *r, size_t stride)
{
    test_rng rng = test_random(5);
    kn_job_report report = kn_job_describe(job);
    assert_true(report.normal.certified && r->count == report.patches);
    for (size_t i = 0; i < r->count; i += stride) {
        const kn_patch *p = &r->patches[i];
        kn_bezier d = {0};
        kn_patch_place place;
        double x[2] = {test_uniform(&rng, 0, 1), test_uniform(&rng, 0, 1)}, uvw[3], is[3], s[3], n[3], at[2];
        assert_int_equal(kn_job_source(ctx, &d, &place, job, &p->id), KN_OK);
        assert_int_equal(kn_bezier_eval(ctx, uvw, &d, x), KN_OK);
        assert_int_equal(kn_bezier_eval(ctx, is, &p->bezier, x), KN_OK);
        for (int v = 0; v < 2; v++) at[v] = (double)scene_parameter(job, place.surface, v, place.cell[v] + uvw[v]);
        direct(ctx, s, n, kn_shell_surface(kn_job_shell(job, place.surface)), at);
        double off = 0;
        for (int c = 0; c < 3; c++) off += pow(is[c] - s[c] - uvw[2] * n[c], 2);
        double bound = fabs(uvw[2]) * (report.normal.length_error + 1.01 * report.normal.angle_error) + 1e-11;
        assert_true(sqrt(off) <= bound);
        kn_bezier_clear(ctx, &d);
    }
}

// A job of the dome with both spacings: *before and *after its spread.
static void compare(kn_ctx *ctx, const kn_spline *s, int n, double size, kn_cells_spread *before,
                    kn_cells_spread *after)
{
    kn_tile tile = {0};
    kn_job *job = NULL;
    scene_dome(ctx, &tile);
    kn_job_options o = {.size = {size, 0}, .height = 0.02, .normal_tol = 1e-4, .spacing = KN_CELLS_UNIFORM};
    make_job(ctx, &job, s, n, &tile, &o);
    *before = kn_job_describe(job).spread;
    kn_job_destroy(ctx, job);
    o.spacing = KN_CELLS_DEFAULT; // from a size: even
    make_job(ctx, &job, s, n, &tile, &o);
    *after = kn_job_describe(job).spread;
    assert_int_equal(before->cells, after->cells);
    scene_result r;
    scene_run(ctx, job, &r);
    check_patches(ctx, job, &r, 1 + r.count / 200);
    scene_result_clear(&r);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
}

static void even_cells(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    kn_model teapot = {0};
    kn_spline s = {0};
    kn_cells_spread a, b;
    assert_int_equal(kn_read_bpt(ctx, &teapot, "data/teapot.bpt"), KN_OK);
    // an eighth of a torus: angles of rational quadratics, all lengths along v equal
    scene_torus(ctx, &s);
    compare(ctx, &s, 1, 0.2, &a, &b);
    assert_true(ratio(&a.height) > 1.05 && ratio(&b.height) < 1 + 1e-9);
    assert_true(ratio(&b.width) < 4.0 / 3 + 1e-9); // radii from 3 to 4
    kn_spline_clear(ctx, &s);
    compare(ctx, &teapot.splines[8], 1, 0.2, &a, &b); // the lower body
    assert_true(ratio(&a.area) > 4 && ratio(&b.area) < 1.3);
    compare(ctx, &teapot.splines[16], 1, 0.2, &a, &b); // half of the spout
    assert_true(ratio(&b.area) < 0.7 * ratio(&a.area));
    kn_model_clear(ctx, &teapot);
    test_ctx_end(ctx, &memory);
}

// Control point k of edge e of a bicubic patch (0 and 1 at the ends of u, 2 and 3 at those of v).
static void on_edge(double p[3], const kn_spline *s, int e, int k)
{
    for (int c = 0; c < 3; c++) p[c] = s->coef[16 * c + (e < 2 ? 12 * e + k : 4 * k + 3 * (e - 2))];
}

// The edge of a that is one of b's, and whether they run the same way; -1: none.
static int shared_edge(bool *same_way, const kn_spline *a, const kn_spline *b)
{
    for (int e = 0; e < 4; e++)
        for (int f = 0; f < 4; f++)
            for (int way = 0; way < 2; way++) {
                double apart = 0, p[3], q[3];
                for (int k = 0; k < 4; k++) {
                    on_edge(p, a, e, k), on_edge(q, b, f, way ? 3 - k : k);
                    apart = fmax(apart, test_max_difference(p, q, 3));
                }
                *same_way = way == 0;
                if (apart < 1e-9) return e;
            }
    return -1;
}

// Five points, both ends among them, of each edge of one surface's patches whose ends lie within tol of the curve.
static size_t edge_points(kn_ctx *ctx, double *to, const scene_result *r, int surface, const double *curve,
                          int ncurve, double tol)
{
    size_t found = 0;
    for (size_t i = 0; i < r->count; i++)
        for (int e = 0; e < 4 && r->patches[i].id.surface == surface; e++) {
            bool on = true;
            for (int k = 0; k < 5; k++) {
                double at[2] = {k / 4.0, k / 4.0}, best = INFINITY, *p = to + 3 * (found + (size_t)k);
                at[e / 2] = e % 2;
                assert_int_equal(kn_bezier_eval(ctx, p, &r->patches[i].bezier, at), KN_OK);
                for (int q = 0; k % 4 == 0 && q < ncurve; q++)
                    best = fmin(best,
                                hypot(hypot(p[0] - curve[3 * q], p[1] - curve[3 * q + 1]), p[2] - curve[3 * q + 2]));
                on = on && (k % 4 != 0 || best <= tol);
            }
            found += on ? 5 : 0;
        }
    return found;
}

// The dome covers the cell and is 0 on its border: on an edge that two patches of the body share, the corners of one
// side are those of the other's, bit for bit where both run the same way, else within the rounding of a restriction
// to the cell, gamma(6 p + 1) each way, below 1e-14 of coordinates below 4; and so are points in between, of higher
// degrees with as many roundings: 1e-13.
static void neighbours_meet(void **state)
{
    (void)state;
    enum { ROOM = 4096, SAMPLES = 4001 };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_model teapot = {0};
    kn_tile tile = {0};
    assert_int_equal(kn_read_bpt(ctx, &teapot, "data/teapot.bpt"), KN_OK);
    scene_dome(ctx, &tile);
    static const int pairs[2][2] = {{4, 5}, {4, 8}}; // side by side, and one below the other
    double *curve = malloc(3 * SAMPLES * sizeof *curve), *p[2];
    for (int side = 0; side < 2; side++) p[side] = malloc(3 * ROOM * sizeof *p[side]);
    for (int k = 0; k < 2; k++) {
        kn_spline s[2] = {teapot.splines[pairs[k][0]], teapot.splines[pairs[k][1]]};
        kn_job *job = NULL;
        scene_result r;
        bool same_way;
        int edge = shared_edge(&same_way, &s[0], &s[1]);
        assert_true(edge >= 0);
        for (int q = 0; q < SAMPLES; q++) {
            double t = (double)q / (SAMPLES - 1), at[2] = {t, t};
            at[edge / 2] = edge % 2;
            assert_int_equal(kn_spline_eval(ctx, curve + 3 * q, &s[0], at), KN_OK);
        }
        make_job(ctx, &job, s, 2, &tile, &(kn_job_options){.size = {0.4, 0}, .height = 0.05, .normal_tol = 2e-2});
        scene_run(ctx, job, &r);
        size_t n[2];
        for (int side = 0; side < 2; side++) n[side] = edge_points(ctx, p[side], &r, side, curve, SAMPLES, 2e-3);
        assert_true(n[0] == n[1] && n[0] >= 40 && n[0] < ROOM);
        for (size_t i = 0; i < n[0]; i++) {
            double best = INFINITY;
            for (size_t j = 0; j < n[1]; j++) best = fmin(best, test_max_difference(p[0] + 3 * i, p[1] + 3 * j, 3));
            assert_true(best <= (i % 5 % 4 != 0 ? 1e-13 : same_way ? 0 : 1e-14));
        }
        scene_result_clear(&r);
        kn_job_destroy(ctx, job);
    }
    free(curve), free(p[0]), free(p[1]);
    kn_tile_clear(ctx, &tile);
    kn_model_clear(ctx, &teapot);
    test_ctx_end(ctx, &memory);
}

// (u^2, v, 0) with speed 2 u, and a sheet over the whole cell with heights w(u), the same at both ends.
static void stretched_plane(kn_ctx *ctx, kn_spline *out)
{
    static const double k2[] = {0.25, 0.25, 0.25, 1, 1, 1}, k1[] = {0, 0, 1, 1};
    const double *knots[2] = {k2, k1}, coef[18] = {0.0625, 0.0625, 0.25, 0.25, 1, 1, 0, 1, 0, 1, 0, 1};
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, (const int[]){2, 1}, (const int[]){3, 2}, knots, coef),
                     KN_OK);
}

static void sheet(kn_ctx *ctx, kn_tile *out, const double w[5])
{
    static const double k4[] = {0, 0, 0, 0, 0, 1, 1, 1, 1, 1}, k1[] = {0, 0, 1, 1};
    const double *knots[2] = {k4, k1};
    double coef[30];
    kn_spline s = {0};
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < 2; j++) coef[2 * i + j] = i / 4.0, coef[10 + 2 * i + j] = j, coef[20 + 2 * i + j] = w[i];
    assert_int_equal(kn_tile_init(ctx, out, "sheet", 1), KN_OK);
    assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, (const int[]){4, 1}, (const int[]){5, 2}, knots, coef),
                     KN_OK);
    assert_int_equal(kn_tile_add(ctx, out, 0, &s), KN_OK);
    kn_spline_clear(ctx, &s);
}

// The slope dz/dx of a patch at one end of r.
static double end_slope(kn_ctx *ctx, const kn_bezier *b, double r)
{
    double d[9];
    assert_int_equal(kn_bezier_derivatives(ctx, d, b, (const double[]){r, 0.5}, 1), KN_OK);
    return d[5] / d[3];
}

// Lines at u = 1/4 .. 1 by length of (u^2): widths in parameter differ, lengths of cells do not, and slopes agree
// across lines. With uniform lines lengths differ: a sheet that lies flat at lines has no kink, one with slope w' has
// slopes w' / width.
static void smoothness_across_cells(void **state)
{
    (void)state;
    enum { N = 5 };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static const double flat[5] = {0.2, 0.2, 0.9, 0.2, 0.2}, steep[5] = {0.5, 0.6, 0.5, 0.4, 0.5};
    kn_spline s = {0};
    stretched_plane(ctx, &s);
    for (int k = 0; k < 4; k++) {
        kn_tile tile = {0};
        kn_job *job = NULL;
        scene_result r;
        sheet(ctx, &tile, k % 2 == 0 ? flat : steep);
        kn_job_options o = {.count = {N, 1}, .height = 1, .normal_tol = 1e-9, .max_degree = 40};
        o.spacing = k < 2 ? KN_CELLS_EVEN : KN_CELLS_UNIFORM;
        make_job(ctx, &job, &s, 1, &tile, &o);
        scene_run(ctx, job, &r);
        assert_int_equal(r.count, N);
        const double *line = kn_job_lines(job, 0, 0);
        for (int i = 0; i + 1 < N; i++) {
            double left = end_slope(ctx, &r.patches[i].bezier, 1),
                   right = end_slope(ctx, &r.patches[i + 1].bezier, 0);
            // x_r = 2 u du, with du the cell's width, and z_r = 4 (0.6 - 0.5) for the steep sheet
            double rise = k % 2 == 0 ? 0 : 0.4, per = 2 * line[i + 1];
            assert_true(fabs(left - rise / (per * (line[i + 1] - line[i]))) <= 1e-7);
            assert_true(fabs(right - rise / (per * (line[i + 2] - line[i + 1]))) <= 1e-7);
        }
        double first = line[1] - line[0], last = line[N] - line[N - 1];
        assert_true(k < 2 ? first > 1.5 * last : fabs(first - last) <= 1e-14);
        scene_result_clear(&r);
        kn_job_destroy(ctx, job);
        kn_tile_clear(ctx, &tile);
    }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// A cone in rows: widths within a factor that the cone itself does not have, cells with numbers of their own.
static void rows_of_a_cone(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    kn_spline cone = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    scene_result r;
    assert_int_equal(kn_construct_cone(ctx, &cone, origin, axis, 2, 0.2), KN_OK);
    scene_dome(ctx, &tile);
    kn_job_options o = {.size = {0.3, 0}, .height = 0.05, .normal_tol = 1e-4};
    make_job(ctx, &job, &cone, 1, &tile, &o);
    kn_cells_spread before = kn_job_describe(job).spread;
    kn_job_destroy(ctx, job);

    o.rows = true;
    make_job(ctx, &job, &cone, 1, &tile, &o); // the dome is casual
    kn_job_report report = kn_job_describe(job);
    assert_true(report.nparts > 2 && report.nsurfaces == 1);
    assert_true(ratio(&before.width) > 6 && ratio(&report.spread.width) < 2.1);
    assert_true(ratio(&before.area) > 6 && ratio(&report.spread.area) < 2.1);
    scene_run(ctx, job, &r);
    check_patches(ctx, job, &r, 3);
    for (size_t i = 0; i < r.count; i++)
        for (size_t j = 0; j < i; j++)
            assert_true(memcmp(&r.patches[i].id, &r.patches[j].id, sizeof r.patches[i].id));
    for (int part = 1; part < report.nparts; part++) { // borders are lines of both, and counts change there
        int here[2], below[2];
        kn_shell_cells(kn_job_shell(job, part), here), kn_shell_cells(kn_job_shell(job, part - 1), below);
        assert_true(kn_job_lines(job, part, 1)[0] == kn_job_lines(job, part - 1, 1)[below[1]]);
        assert_true(here[0] < below[0]);
    }
    scene_result_clear(&r);
    kn_job_destroy(ctx, job);

    job = NULL;
    o.count[0] = 9;
    assert_int_equal(kn_job_create(ctx, &job, &cone, 1, &tile, &o), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    o.count[0] = 0, tile.covering = true;
    assert_int_equal(kn_job_create(ctx, &job, &cone, 1, &tile, &o), KN_EDOMAIN);
    assert_true(job == NULL && strstr(kn_ctx_message(ctx), "dome") != NULL);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &cone);
    test_ctx_end(ctx, &memory);
}

// The body of the teapot, eight patches, in rows: those side by side have the same ones.
static void rows_of_the_teapot(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    kn_model teapot = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    assert_int_equal(kn_read_bpt(ctx, &teapot, "data/teapot.bpt"), KN_OK);
    scene_diamond(ctx, &tile);
    static const double inside[8] = {0.1, 0.1, 0.9, 0.9, 0.1, 0.9, 0.1, 0.9};
    memcpy(tile.parts[0].splines[0].coef, inside, sizeof inside);
    kn_job_options o = {.size = {0.3, 0}, .height = 0.02, .normal_tol = 1e-2};
    make_job(ctx, &job, teapot.splines, teapot.nsplines, &tile, &o);
    kn_cells_spread before = kn_job_describe(job).spread;
    kn_job_destroy(ctx, job);
    o.rows = true;
    make_job(ctx, &job, teapot.splines, teapot.nsplines, &tile, &o);
    kn_job_report report = kn_job_describe(job);
    assert_true(report.nparts > 40 && report.nsurfaces == 32);
    assert_true(ratio(&before.area) > 20 && ratio(&report.spread.area) < 3);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_model_clear(ctx, &teapot);
    test_ctx_end(ctx, &memory);
}

// h on a cone is sqrt of the cell's area over the mean, within the error that is reported and that of n; on the edge
// that two patches share T is one, and a thickness multiplies.
static void heights_by_stretch(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    kn_spline cone = {0}, twice = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    assert_int_equal(kn_construct_cone(ctx, &cone, origin, axis, 2, 0.5), KN_OK);
    scene_dome(ctx, &tile);
    static const double k0[] = {0, 1}, two[] = {2};
    const double *knots[2] = {k0, k0};
    assert_int_equal(kn_spline_init(ctx, &twice, 2, 1, false, (const int[]){0, 0}, (const int[]){1, 1}, knots, two),
                     KN_OK);
    kn_job_options o = {.size = {0.3, 0}, .height = 0.1, .normal_tol = 1e-4, .max_degree = 40, .stretch = true};
    for (int k = 0; k < 2; k++) {
        if (k == 1) o.thickness = &twice;
        make_job(ctx, &job, &cone, 1, &tile, &o);
        kn_job_report report = kn_job_describe(job);
        const kn_shell *shell = kn_job_shell(job, 0);
        int n[2];
        kn_shell_cells(shell, n);
        assert_true(report.stretch_error > 0 && report.stretch_error < 0.03);
        for (int j = 0; j < n[1]; j++) {
            // at the middle of a cell: its area is that of a strip of the cone, equal in each row
            double u = (double)scene_parameter(job, 0, 0, 0.5), v = (double)scene_parameter(job, 0, 1, j + 0.5), s[3],
                   t[3], up = 0;
            assert_int_equal(kn_shell_eval(ctx, s, NULL, shell, u, v, 0), KN_OK);
            assert_int_equal(kn_shell_eval(ctx, t, NULL, shell, u, v, 0.1), KN_OK);
            for (int c = 0; c < 3; c++) up += (t[c] - s[c]) * (t[c] - s[c]);
            double area = 2 * acos(-1) / n[0] * hypot(s[0], s[1]) * sqrt(9 + 1.5 * 1.5) / n[1];
            double h = sqrt(area / report.spread.area.mean) * (k == 1 ? 2 : 1);
            // the floor is below 1 % here, and a cell's du varies along a quarter's cells by a few percent
            assert_true(fabs(sqrt(up) / 0.1 / h - 1) <= report.stretch_error + 0.03);
        }
        kn_job_destroy(ctx, job);
    }
    kn_spline_clear(ctx, &cone), kn_spline_clear(ctx, &twice);

    kn_model teapot = {0};
    assert_int_equal(kn_read_bpt(ctx, &teapot, "data/teapot.bpt"), KN_OK);
    o.thickness = NULL;
    make_job(ctx, &job, teapot.splines + 4, 8, &tile, &o); // the body
    for (int i = 0; i <= 10; i++) {
        double x = i / 10.0, p[2][3], off = 0; // patch 4 below, 8 above
        assert_int_equal(kn_shell_eval(ctx, p[0], NULL, kn_job_shell(job, 0), x, 1, 0.1), KN_OK);
        assert_int_equal(kn_shell_eval(ctx, p[1], NULL, kn_job_shell(job, 4), x, 0, 0.1), KN_OK);
        for (int c = 0; c < 3; c++) off = fmax(off, fabs(p[0][c] - p[1][c]));
        assert_true(off <= 0.1 * 1.5 * 2.1e-4); // of the two normals, and of heights below 1.5
    }
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_model_clear(ctx, &teapot);
    test_ctx_end(ctx, &memory);
}

static void free_corners(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    kn_model teapot = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    scene_result r;
    assert_int_equal(kn_read_bpt(ctx, &teapot, "data/teapot.bpt"), KN_OK);
    scene_dome(ctx, &tile);
    kn_job_options o = {.size = {0.25, 0}, .height = 0.02, .normal_tol = 1e-3};
    make_job(ctx, &job, teapot.splines + 16, 1, &tile, &o); // half of the spout
    kn_cells_spread before = kn_job_describe(job).spread;
    kn_job_destroy(ctx, job);
    o.spacing = KN_CELLS_FREE, o.cells_tol = 1e-3;
    make_job(ctx, &job, teapot.splines + 16, 1, &tile, &o);
    kn_job_report report = kn_job_describe(job);
    assert_true(report.cells_error > 0 && report.cells_error <= 1e-3);
    assert_true(ratio(&report.spread.area) < 0.6 * ratio(&before.area));
    int n[2];
    kn_shell_cells(kn_job_shell(job, 0), n);
    for (int d = 0; d < 2; d++)
        for (int i = 0; i <= n[d]; i++) assert_true(kn_job_lines(job, 0, d)[i] == i);
    scene_run(ctx, job, &r);
    check_patches(ctx, job, &r, 2);
    // the corners of the domain stay
    double a[3], b[3];
    for (int c = 0; c < 4; c++) {
        const double at[2] = {c / 2, c % 2}, to[2] = {at[0] * n[0], at[1] * n[1]};
        assert_int_equal(kn_spline_eval(ctx, a, &teapot.splines[16], at), KN_OK);
        assert_int_equal(kn_spline_eval(ctx, b, kn_shell_surface(kn_job_shell(job, 0)), to), KN_OK);
        assert_true(test_max_difference(a, b, 3) <= 1e-12);
    }
    scene_result_clear(&r);
    kn_job_destroy(ctx, job);

    job = NULL;
    kn_spline field = {0};
    static const double k0[] = {0, 1}, up[] = {0, 0, 1};
    const double *knots[2] = {k0, k0};
    assert_int_equal(kn_spline_init(ctx, &field, 2, 3, false, (const int[]){0, 0}, (const int[]){1, 1}, knots, up),
                     KN_OK);
    o.direction = &field;
    assert_int_equal(kn_job_create(ctx, &job, teapot.splines + 16, 1, &tile, &o), KN_EDOMAIN);
    assert_true(job == NULL);
    kn_spline_clear(ctx, &field);
    kn_tile_clear(ctx, &tile);
    kn_model_clear(ctx, &teapot);
    test_ctx_end(ctx, &memory);
}

static kn_status plan_small(kn_ctx *ctx, void *user)
{
    const kn_job_options *o = user;
    static const double k1[] = {0, 0, 1, 1}, coef[12] = {0, 1, 4, 3, 0, 2, 0, 2, 0, 0, 0, 0};
    const double *knots[2] = {k1, k1}, square[12] = {0.2, 0.2, 0.8, 0.8, 0.2, 0.8, 0.2, 0.8, 0, 0, 1, 1};
    kn_spline s = {0}, sheet_of_tile = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    kn_status status = kn_spline_init(ctx, &s, 2, 3, false, (const int[]){1, 1}, (const int[]){2, 2}, knots, coef);
    if (status == KN_OK)
        status = kn_spline_init(ctx, &sheet_of_tile, 2, 3, false, (const int[]){1, 1}, (const int[]){2, 2}, knots,
                                square);
    if (status == KN_OK) status = kn_tile_init(ctx, &tile, "square", 1);
    if (status == KN_OK) status = kn_tile_add(ctx, &tile, 0, &sheet_of_tile);
    if (status == KN_OK) status = kn_job_create(ctx, &job, &s, 1, &tile, o);
    assert_true((status == KN_OK) == (job != NULL));
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &sheet_of_tile);
    return status;
}

static void allocation(void **state)
{
    (void)state;
    kn_job_options options[] = {{.size = {1.5, 0}, .normal_tol = 1e-2, .rows = true, .stretch = true},
                                {.size = {2.5, 0}, .normal_tol = 1e-2, .spacing = KN_CELLS_FREE, .cells_tol = 0.1}};
    for (int k = 0; k < 2; k++) test_allocation_failures(plan_small, &options[k]);
}

// At the default limit of degrees: free corners, a constant thickness and the stretch leave room for the rest.
static void within_degrees(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    kn_model teapot = {0};
    kn_spline torus = {0}, half = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    assert_int_equal(kn_read_bpt(ctx, &teapot, "data/teapot.bpt"), KN_OK);
    assert_int_equal(kn_construct_torus(ctx, &torus, origin, axis, 3, 1), KN_OK); // a weight of degrees 2, 2
    scene_dome(ctx, &tile);                                                       // of degree 2
    kn_job_options o = {.size = {0.4, 0}, .normal_tol = 1e-3, .spacing = KN_CELLS_FREE};
    make_job(ctx, &job, teapot.splines + 24, 1, &tile, &o);
    const kn_spline *s = kn_shell_surface(kn_job_shell(job, 0));
    kn_job_report report = kn_job_describe(job);
    assert_true(s->degree[0] + s->degree[1] <= 25 / 2 && report.even_instead == 0);
    assert_true(report.cells_error > 0 && report.cells_error <= 1e-3 * report.cell_size);
    assert_true(report.degree[0] <= 25 && report.degree[1] <= 25);
    kn_job_destroy(ctx, job);
    o.cells_tol = 1e-14; // no fit: the surface stays as it is, and that is told
    make_job(ctx, &job, teapot.splines + 24, 1, &tile, &o);
    report = kn_job_describe(job);
    s = kn_shell_surface(kn_job_shell(job, 0));
    assert_true(report.even_instead == 1 && report.cells_error == 0 && s->degree[0] == 3 && s->degree[1] == 3);
    kn_job_destroy(ctx, job);

    static const double linear[] = {0, 0, 1, 1}, halves[] = {0.5, 0.5, 0.5, 0.5};
    const double *knots[2] = {linear, linear};
    assert_int_equal(kn_spline_init(ctx, &half, 2, 1, false, (const int[]){1, 1}, (const int[]){2, 2}, knots, halves),
                     KN_OK);
    for (int k = 0; k < 3; k++) { // half the thickness, the stretch, both
        o = (kn_job_options){.count = {16, 12}, .height = 0.1, .normal_tol = 1e-3, .spacing = KN_CELLS_EVEN};
        o.thickness = k != 1 ? &half : NULL, o.stretch = k > 0;
        make_job(ctx, &job, &torus, 1, &tile, &o);
        report = kn_job_describe(job);
        assert_true(report.degree[0] <= 25 && report.degree[1] <= 25);
        assert_true(k == 0 ? report.stretch_error == 0 : report.stretch_error > 0 && report.stretch_error < 0.2);
        for (int i = 0; i < 192; i++) {
            const kn_shell *shell = kn_job_shell(job, 0);
            double u = (double)scene_parameter(job, 0, 0, i % 16 + 0.5),
                   v = (double)scene_parameter(job, 0, 1, i / 16 + 0.5), a[3], b[3], up = 0;
            assert_int_equal(kn_shell_eval(ctx, a, NULL, shell, u, v, 0), KN_OK);
            assert_int_equal(kn_shell_eval(ctx, b, NULL, shell, u, v, 0.1), KN_OK);
            for (int c = 0; c < 3; c++) up += (b[c] - a[c]) * (b[c] - a[c]);
            // areas of equal cells are as the distances from the axis; du dv is within 4 % of theirs
            double h = (k == 1 ? 1 : 0.5) * (k > 0 ? sqrt(hypot(a[0], a[1]) / 3) : 1);
            assert_true(fabs(sqrt(up) / 0.1 / h - 1) <= report.stretch_error + (k > 0 ? 0.04 : 2e-3));
        }
        kn_job_destroy(ctx, job);
    }
    kn_spline_clear(ctx, &torus), kn_spline_clear(ctx, &half);
    kn_tile_clear(ctx, &tile);
    kn_model_clear(ctx, &teapot);
    test_ctx_end(ctx, &memory);
}

// What is refused says which surface it is, what would help, and numbers that can be read.
static void messages(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s[2] = {{0}}, down = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    scene_bicubic(ctx, &s[0], 0.2);
    scene_torus(ctx, &s[1]);
    scene_dome(ctx, &tile);
    kn_job_options o = {.size = {1e-300, 0}};
    assert_int_equal(kn_job_create(ctx, &job, s, 2, &tile, &o), KN_ELIMIT);
    assert_true(strlen(kn_ctx_message(ctx)) < 100);
    kn_ctx_clear_error(ctx);
    o = (kn_job_options){.count = {2, 2}, .max_degree = 20, .stretch = true};
    assert_int_equal(kn_job_create(ctx, &job, s, 2, &tile, &o), KN_EDOMAIN); // the torus
    assert_non_null(strstr(kn_ctx_message(ctx), "over surface 1"));
    assert_non_null(strstr(kn_ctx_message(ctx), "a tile of degree 1 at most, or no stretch"));
    kn_ctx_clear_error(ctx);
    static const double linear[] = {0, 0, 1, 1}, sinks[] = {1, 1, 1, -1};
    const double *knots[2] = {linear, linear};
    assert_int_equal(kn_spline_init(ctx, &down, 2, 1, false, (const int[]){1, 1}, (const int[]){2, 2}, knots, sinks),
                     KN_OK);
    o = (kn_job_options){.count = {2, 2}, .thickness = &down};
    assert_int_equal(kn_job_create(ctx, &job, s, 1, &tile, &o), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "surface 0: shell: the thickness"));
    kn_ctx_clear_error(ctx);
    assert_true(job == NULL);
    for (int k = 0; k < 2; k++) kn_spline_clear(ctx, &s[k]);
    kn_spline_clear(ctx, &down);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(even_cells),
                                       cmocka_unit_test(within_degrees),
                                       cmocka_unit_test(messages),
                                       cmocka_unit_test(neighbours_meet),
                                       cmocka_unit_test(smoothness_across_cells),
                                       cmocka_unit_test(rows_of_a_cone),
                                       cmocka_unit_test(rows_of_the_teapot),
                                       cmocka_unit_test(heights_by_stretch),
                                       cmocka_unit_test(free_corners),
                                       cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("job/spacing", tests, NULL, NULL);
}
