// SPDX-License-Identifier: Apache-2.0
// Tiles over trimmed surfaces: which cells there are, heights that fall off, and what is cut off, against dense
// polygons along the same borders and integrals by Green's formula.
#include "tests/support/support.h"

#include "tests/support/scene.h"
#include "tests/support/surfaces.h"
#include "kernel/context.h"

#include <knurl/knurl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NU = 24, NV = 20, DENSE = 96 }; // points along one curve

typedef struct scene {
    test_memory memory;
    kn_ctx *ctx;
    kn_spline base;
    kn_tile tile;
    kn_trim trim;
    kn_job_options o;
} scene;

// ---- trims ----

static void add_curve(kn_ctx *ctx, kn_trim *trim, int degree, const double *x, const double *y)
{
    double knots[2 * 4], coef[2 * 4];
    const int count = degree + 1;
    for (int i = 0; i <= degree; i++) {
        knots[i] = 0, knots[count + i] = 1;
        coef[i] = x[i], coef[count + i] = y[i];
    }
    kn_spline *curves = kn_resize(ctx, trim->curves, (size_t)trim->ncurves + 1, sizeof *curves);
    assert_non_null(curves);
    trim->curves = curves;
    curves[trim->ncurves] = (kn_spline){0};
    assert_int_equal(kn_spline_init(ctx, &curves[trim->ncurves++], 1, 2, false, &degree, &count,
                                    (const double *const[]){knots}, coef),
                     KN_OK);
}

static void end_loop(kn_ctx *ctx, kn_trim *trim)
{
    int *ends = kn_resize(ctx, trim->loop_end, (size_t)trim->nloops + 1, sizeof *ends);
    assert_non_null(ends);
    trim->loop_end = ends;
    ends[trim->nloops++] = trim->ncurves;
}

static void add_box(kn_ctx *ctx, kn_trim *trim, double x0, double y0, double x1, double y1)
{
    const double x[5] = {x0, x1, x1, x0, x0}, y[5] = {y0, y0, y1, y1, y0};
    for (int k = 0; k < 4; k++) add_curve(ctx, trim, 1, x + k, y + k);
    end_loop(ctx, trim);
}

// A closed curve of four cubics, nearly an ellipse; a hole runs clockwise.
static void add_oval(kn_ctx *ctx, kn_trim *trim, double cx, double cy, double a, double b, bool hole)
{
    static const double c[5] = {1, 0, -1, 0, 1}, s[5] = {0, 1, 0, -1, 0}, k = 0.5522847498;
    for (int q = 0; q < 4; q++) {
        int i = hole ? 4 - q : q, j = hole ? 3 - q : q + 1;
        double t = hole ? -k : k;
        const double x[4] = {cx + a * c[i], cx + a * (c[i] - t * s[i]), cx + a * (c[j] + t * s[j]), cx + a * c[j]};
        const double y[4] = {cy + b * s[i], cy + b * (s[i] + t * c[i]), cy + b * (s[j] - t * c[j]), cy + b * s[j]};
        add_curve(ctx, trim, 3, x, y);
    }
    end_loop(ctx, trim);
}

static void plate_with_hole(kn_ctx *ctx, kn_trim *trim)
{
    add_box(ctx, trim, 0, 0, 1, 1);
    add_oval(ctx, trim, 0.45, 0.52, 0.23, 0.27, true);
}

static void disc(kn_ctx *ctx, kn_trim *trim)
{
    add_oval(ctx, trim, 0.5, 0.47, 0.38, 0.41, false);
}

static void bay(kn_ctx *ctx, kn_trim *trim) // one side of the square, and a border that bends both ways
{
    const double x[4] = {1, 0.9, 0.3, 0}, y[4] = {0.3, 0.9, 0.1, 0.8};
    add_curve(ctx, trim, 1, (const double[]){0, 1}, (const double[]){0, 0});
    add_curve(ctx, trim, 1, (const double[]){1, 1}, (const double[]){0, 0.3});
    add_curve(ctx, trim, 3, x, y);
    add_curve(ctx, trim, 1, (const double[]){0, 0}, (const double[]){0.8, 0});
    end_loop(ctx, trim);
}

static double bezier(const double *c, int degree, double t)
{
    double x[4];
    memcpy(x, c, ((size_t)degree + 1) * sizeof *x);
    for (int m = degree; m > 0; m--)
        for (int n = 0; n < m; n++) x[n] = (1 - t) * x[n] + t * x[n + 1];
    return x[0];
}

// The same borders as many points, for each curve DENSE + 1 of them.
static double *dense(const kn_trim *trim)
{
    double *p = malloc((size_t)trim->ncurves * (DENSE + 1) * 2 * sizeof *p);
    assert_non_null(p);
    for (int i = 0; i < trim->ncurves; i++) {
        const kn_spline *c = &trim->curves[i];
        for (int k = 0; k <= DENSE; k++)
            for (int d = 0; d < 2; d++)
                p[2 * (i * (DENSE + 1) + k) + d] = bezier(c->coef + d * c->count[0], c->degree[0], (double)k / DENSE);
    }
    return p;
}

static bool is_inside(const kn_trim *trim, const double *points, double x, double y)
{
    int winding = 0;
    for (int i = 0; i < trim->ncurves; i++)
        for (int k = 0; k < DENSE; k++) {
            const double *p = points + 2 * (i * (DENSE + 1) + k), *q = p + 2;
            double left = (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
            if (p[1] <= y && q[1] > y && left > 0) winding++;
            if (p[1] > y && q[1] <= y && left < 0) winding--;
        }
    return winding > 0;
}

// The least distance of (x,y), u and v as many times as cells, from borders that are no sides of the square.
static double from_border(const kn_trim *trim, const double *points, double x, double y)
{
    double least = INFINITY;
    for (int i = 0; i < trim->ncurves; i++)
        for (int k = 0; k < DENSE; k++) {
            const double *p = points + 2 * (i * (DENSE + 1) + k), *q = p + 2;
            bool side = false;
            for (int d = 0; d < 2; d++) side = side || (p[d] == q[d] && (p[d] == 0 || p[d] == 1));
            if (side) continue;
            double a = (q[0] - p[0]) * NU, b = (q[1] - p[1]) * NV, c = (x - p[0]) * NU, e = (y - p[1]) * NV;
            double t = fmin(fmax((a * c + b * e) / (a * a + b * b), 0), 1);
            least = fmin(least, hypot(c - t * a, e - t * b));
        }
    return least;
}

// The integral of x dy, of degree 5: three places by Gauss are exact.
static double area_of(const kn_trim *trim)
{
    static const double at[3] = {0.11270166537925831, 0.5, 0.88729833462074169}, weight[3] = {5, 8, 5};
    double area = 0;
    for (int i = 0; i < trim->ncurves; i++) {
        const double *x = trim->curves[i].coef;
        int p = trim->curves[i].degree[0];
        double dy[3];
        for (int k = 0; k < p; k++) dy[k] = p * (x[p + 2 + k] - x[p + 1 + k]);
        for (int k = 0; k < 3; k++) area += weight[k] / 18 * bezier(x, p, at[k]) * bezier(dy, p - 1, at[k]);
    }
    return area;
}

// ---- scenes ----

static void begin(scene *s, void (*make)(kn_ctx *, kn_spline *), void (*tile)(kn_ctx *, kn_tile *),
                  void (*trim)(kn_ctx *, kn_trim *))
{
    *s = (scene){.memory = TEST_MEMORY_INIT,
                 .o = {.count = {NU, NV}, .height = 0.2, .normal_tol = 1e-2, .max_degree = 40}};
    s->ctx = test_ctx(&s->memory, 2);
    make(s->ctx, &s->base);
    tile(s->ctx, &s->tile);
    trim(s->ctx, &s->trim);
    s->o.trims = &s->trim;
}

static void end(scene *s)
{
    kn_tile_clear(s->ctx, &s->tile);
    kn_spline_clear(s->ctx, &s->base);
    kn_trim_clear(s->ctx, &s->trim);
    test_ctx_end(s->ctx, &s->memory);
}

static kn_job *make_job(scene *s, scene_result *r)
{
    kn_job *job = NULL;
    if (kn_job_create(s->ctx, &job, &s->base, 1, &s->tile, &s->o) != KN_OK) fail_msg("%s", kn_ctx_message(s->ctx));
    scene_run(s->ctx, job, r);
    assert_int_equal(kn_job_describe(job).patches, r->count);
    return job;
}

static void (*const trims[])(kn_ctx *, kn_trim *) = {plate_with_hole, disc, bay};

// How much of a cell the region has, by a grid of points: 0, all, or something.
static int share(const kn_trim *trim, const double *points, int i, int j)
{
    enum { N = 6 };
    int in = 0;
    for (int k = 0; k <= N; k++)
        for (int m = 0; m <= N; m++)
            in += is_inside(trim, points, fmin((i + (double)k / N) / NU, 1 - 1e-9) + 1e-10,
                            fmin((j + (double)m / N) / NV, 1 - 1e-9) + 1e-10);
    return in == 0 ? 0 : in == (N + 1) * (N + 1) ? 2 : 1;
}

// Whole tiles stay in exactly those cells that the region touches; where the border comes nearer to a cell than the
// grid of points can tell, either will do.
static void cells_that_touch_stay(void **state)
{
    (void)state;
    for (int t = 0; t < 3; t++) {
        scene s;
        scene_result r = {0};
        static bool has[NU][NV];
        begin(&s, t == 1 ? make_wavy : make_plane, scene_plate, trims[t]);
        double *points = dense(&s.trim);
        kn_job *job = make_job(&s, &r);
        memset(has, 0, sizeof has);
        for (size_t i = 0; i < r.count; i++) {
            has[r.patches[i].id.cell[0]][r.patches[i].id.cell[1]] = true;
            assert_null(r.patches[i].trim);
        }
        size_t dropped = 0;
        for (int i = 0; i < NU; i++)
            for (int j = 0; j < NV; j++) {
                int what = share(&s.trim, points, i, j);
                double near = INFINITY;
                for (int k = 0; k <= 8 && what == 0; k++) { // points 1/8 apart: the border may be 1/16 nearer
                    const double x[4] = {i + k / 8.0, i + k / 8.0, i, i + 1.0},
                                 y[4] = {j, j + 1.0, j + k / 8.0, j + k / 8.0};
                    for (int m = 0; m < 4; m++) near = fmin(near, from_border(&s.trim, points, x[m] / NU, y[m] / NV));
                }
                if (what > 0) assert_true(has[i][j]);
                if (what == 0 && near > 0.1) assert_false(has[i][j]);
                dropped += !has[i][j];
            }
        kn_job_report report = kn_job_describe(job);
        assert_int_equal(report.dropped[KN_DROP_TRIM], dropped);
        assert_int_equal(report.cells + dropped, NU * NV);
        assert_true(dropped > NU * NV / 20);
        kn_job_destroy(s.ctx, job);
        scene_result_clear(&r);
        free(points);
        end(&s);
    }
}

// The whole square is no trim.
static void all_of_it_is_no_trim(void **state)
{
    (void)state;
    scene s;
    scene_result all = {0}, r = {0};
    begin(&s, make_wavy, scene_dome, plate_with_hole);
    s.o.trims = NULL;
    kn_job_destroy(s.ctx, make_job(&s, &all));
    kn_trim_clear(s.ctx, &s.trim);
    s.o.trims = &s.trim;
    for (int k = 0; k < 4; k++) {
        if (k == 1) add_box(s.ctx, &s.trim, 0, 0, 1, 1);
        s.o.trimmed = k == 2 ? KN_TRIMMED_CLIP : KN_TRIMMED_KEEP;
        kn_job_destroy(s.ctx, make_job(&s, &r));
        assert_int_equal(r.count, all.count);
        for (size_t i = 0; i < r.count; i++) {
            const kn_bezier *a = &r.patches[i].bezier, *b = &all.patches[i].bezier;
            assert_memory_equal(a->coef, b->coef, (size_t)a->ncomp * kn_bezier_count(a) * sizeof *a->coef);
        }
        scene_result_clear(&r);
    }
    scene_result_clear(&all);
    end(&s);
}

// Heights of a dome are 0 in all cells that the border crosses, and full where it is far. The plane lies at z = 1.
static void heights_fall_off(void **state)
{
    (void)state;
    for (int covering = 0; covering < 2; covering++) {
        scene s;
        scene_result r = {0};
        begin(&s, make_plane, scene_dome, plate_with_hole);
        s.o.trimmed = KN_TRIMMED_TAPER;
        s.o.taper = 0.5;
        s.tile.covering = covering;
        double *points = dense(&s.trim), most = 0;
        kn_job *job = make_job(&s, &r);
        size_t crossed = 0;
        for (size_t i = 0; i < r.count; i++) {
            const kn_patch *p = &r.patches[i];
            size_t n = kn_bezier_count(&p->bezier);
            int what = share(&s.trim, points, p->id.cell[0], p->id.cell[1]);
            crossed += what == 1;
            assert_true(what > 0 || covering);
            for (size_t k = 0; k < n; k++) {
                double x = p->bezier.coef[k] / 2, y = p->bezier.coef[n + k] / 3, z = p->bezier.coef[2 * n + k] - 1;
                if (what < 2) assert_true(fabs(z) < 1e-12);
                // cells are 1/12 and 3/20: the border's own cell, and then 0.5
                if (from_border(&s.trim, points, x, y) < 1e-3) assert_true(fabs(z) < 1e-12);
                most = fmax(most, z);
            }
        }
        assert_true(most > 0.1);
        assert_true(covering ? crossed > 0 : crossed == 0);
        kn_job_destroy(s.ctx, job);
        scene_result_clear(&r);
        free(points);
        end(&s);
    }
}

// ---- cut off ----

// Of patches that lie in the plane [0,2] x [0,3] and are affine images of their (r,t): areas of what is left, and how
// far a point of a trim is off the region at most, in the plane.
typedef struct cut_parts {
    const kn_trim *trim;
    const double *points;
    double area, off;
    size_t trimmed;
} cut_parts;

// Distance from the region, its sides included.
static double off_region(const cut_parts *c, double u, double v)
{
    double least = INFINITY;
    if (is_inside(c->trim, c->points, u, v)) return 0;
    for (int i = 0; i < c->trim->ncurves; i++)
        for (int k = 0; k < DENSE; k++) {
            const double *p = c->points + 2 * (i * (DENSE + 1) + k), *q = p + 2;
            double a = (q[0] - p[0]) * 2, b = (q[1] - p[1]) * 3, x = (u - p[0]) * 2, y = (v - p[1]) * 3;
            double t = fmin(fmax((a * x + b * y) / (a * a + b * b), 0), 1);
            least = fmin(least, hypot(x - t * a, y - t * b));
        }
    return least;
}

static kn_status measure_block(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)ctx, (void)product;
    cut_parts *c = user;
    for (size_t i = 0; i < block->count; i++) {
        const kn_patch *p = &block->patches[i];
        const kn_bezier *b = &p->bezier;
        size_t n = kn_bezier_count(b), row = (size_t)b->degree[1] + 1;
        const size_t at[3] = {0, n - row, row - 1};
        double x[3], y[3];
        for (int k = 0; k < 3; k++) x[k] = b->coef[at[k]], y[k] = b->coef[n + at[k]];
        double size = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
        c->area += fabs(size) * (p->trim ? scene_trim_area(p->trim) : 1.0);
        c->trimmed += p->trim != NULL;
        for (int k = 0; p->trim && k < p->trim->ncurves; k++) {
            const kn_spline *curve = &p->trim->curves[k];
            for (int m = 0; m < curve->count[0]; m += 5) {
                double r = curve->coef[m], t = curve->coef[curve->count[0] + m];
                double px = x[0] + r * (x[1] - x[0]) + t * (x[2] - x[0]);
                double py = y[0] + r * (y[1] - y[0]) + t * (y[2] - y[0]);
                c->off = fmax(c->off, off_region(c, px / 2, py / 3));
            }
        }
    }
    return KN_OK;
}

static void flat_cover(kn_ctx *ctx, kn_tile *out)
{
    static const double coef[12] = {0, 0, 1, 1, 0, 1, 0, 1, 0.5, 0.5, 0.5, 0.5};
    assert_int_equal(kn_tile_init(ctx, out, "cover", 1), KN_OK);
    scene_add_patch(ctx, out, 1, 1, coef);
}

// A covering tile over the plane: what is left has the area of the region, to within the border's length times what
// is said of its error.
static void areas_agree(void **state)
{
    (void)state;
    for (int t = 0; t < 3; t++)
        for (int k = 0; k < 2; k++) {
            scene s;
            begin(&s, make_plane, k == 0 ? flat_cover : scene_dome, trims[t]);
            s.tile.covering = true;
            s.o.trimmed = KN_TRIMMED_CLIP;
            s.o.crossing_tol = 1e-4;
            if (t == 2) s.o.count[0] = 3, s.o.count[1] = 2; // long borders in one patch
            double *points = dense(&s.trim);
            kn_job *job = NULL;
            cut_parts parts = {&s.trim, points, 0, 0, 0};
            kn_sink sink = {.user = &parts, .commit = measure_block};
            if (kn_job_create(s.ctx, &job, &s.base, 1, &s.tile, &s.o) != KN_OK) fail_msg("%s", kn_ctx_message(s.ctx));
            assert_int_equal(kn_job_run(s.ctx, job, &sink, 1), KN_OK);
            kn_job_report report = kn_job_describe(job);
            assert_true(report.crossing_error > 0 && report.crossing_error <= 1e-4);
            assert_true(parts.trimmed > 4 && report.trim_curves > 3);
            // the region's border is 5 long at most; dense points are 1e-4 off a curve
            assert_true(fabs(parts.area - 6 * area_of(&s.trim)) <= 5 * report.crossing_error);
            assert_true(parts.off <= report.crossing_error + 2e-4);
            kn_job_destroy(s.ctx, job);
            free(points);
            end(&s);
        }
}

static void bad_trims(void **state)
{
    (void)state;
    scene s;
    kn_job *job = NULL;
    begin(&s, make_plane, scene_plate, disc);
    s.o.trimmed = (kn_job_trimmed)7;
    assert_int_equal(kn_job_create(s.ctx, &job, &s.base, 1, &s.tile, &s.o), KN_EDOMAIN);
    s.o.trimmed = KN_TRIMMED_KEEP;
    kn_ctx_clear_error(s.ctx);
    s.o.spacing = KN_CELLS_FREE;
    assert_int_equal(kn_job_create(s.ctx, &job, &s.base, 1, &s.tile, &s.o), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(s.ctx), "free corners"));
    s.o.spacing = KN_CELLS_DEFAULT;
    kn_ctx_clear_error(s.ctx);
    s.trim.curves[1].coef[0] += 0.01;
    assert_int_equal(kn_job_create(s.ctx, &job, &s.base, 1, &s.tile, &s.o), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(s.ctx), "trim"));
    assert_null(job);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cells_that_touch_stay),
        cmocka_unit_test(all_of_it_is_no_trim),
        cmocka_unit_test(heights_fall_off),
        cmocka_unit_test(areas_agree),
        cmocka_unit_test(bad_trims),
    };
    return cmocka_run_group_tests_name("job/trimmed", tests, NULL, NULL);
}
