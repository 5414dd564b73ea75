// SPDX-License-Identifier: Apache-2.0
// Tiles over trimmed surfaces: which cells there are, heights that fall off, and what is cut off, against dense
// polygons along the same borders and integrals by Green's formula.
#include "tests/support/support.h"

#include "tests/support/scene.h"
#include "tests/support/surfaces.h"
#include "tests/support/trims.h"
#include "kernel/context.h"

#include <knurl/knurl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NU = 24, NV = 20 };

typedef struct scene {
    test_memory memory;
    kn_ctx *ctx;
    kn_spline base;
    kn_tile tile;
    kn_trim trim;
    kn_job_options o;
} scene;

// The least distance of (x,y), u and v as many times as cells, from borders that are no sides of the square.
static double from_border(const kn_trim *trim, const double *points, double x, double y)
{
    double least = INFINITY;
    for (int i = 0; i < trim->ncurves; i++)
        for (int k = 0; k < TRIMS_DENSE; k++) {
            const double *p = points + 2 * (i * (TRIMS_DENSE + 1) + k), *q = p + 2;
            bool side = false;
            for (int d = 0; d < 2; d++) side = side || (p[d] == q[d] && (p[d] == 0 || p[d] == 1));
            if (side) continue;
            double a = (q[0] - p[0]) * NU, b = (q[1] - p[1]) * NV, c = (x - p[0]) * NU, e = (y - p[1]) * NV;
            double t = fmin(fmax((a * c + b * e) / (a * a + b * b), 0), 1);
            double dx = c - t * a, dy = e - t * b, square = dx * dx + dy * dy;
            if (square < least) least = square;
        }
    return sqrt(least);
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

static void (*const trims[])(kn_ctx *, kn_trim *) = {trims_plate_with_hole, trims_disc, trims_bay};

// How much of a cell the region has, by a grid of points: 0, all, or something.
static int share(const kn_trim *trim, const double *points, int i, int j)
{
    enum { N = 6 };
    int in = 0;
    for (int k = 0; k <= N; k++)
        for (int m = 0; m <= N; m++)
            in += trims_is_inside(trim, points, fmin((i + (double)k / N) / NU, 1 - 1e-9) + 1e-10,
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
        double *points = trims_dense(&s.trim);
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
    begin(&s, make_wavy, scene_dome, trims_plate_with_hole);
    s.o.trims = NULL;
    kn_job_destroy(s.ctx, make_job(&s, &all));
    kn_trim_clear(s.ctx, &s.trim);
    s.o.trims = &s.trim;
    for (int k = 0; k < 4; k++) {
        if (k == 1) trims_add_box(s.ctx, &s.trim, 0, 0, 1, 1);
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
        begin(&s, make_plane, scene_dome, trims_plate_with_hole);
        s.o.trimmed = KN_TRIMMED_TAPER;
        s.o.taper = 0.5;
        s.tile.covering = covering;
        double *points = trims_dense(&s.trim), most = 0;
        kn_job *job = make_job(&s, &r);
        size_t crossed = 0;
        for (size_t i = 0; i < r.count; i++) {
            const kn_patch *p = &r.patches[i];
            size_t n = kn_bezier_count(&p->bezier);
            int what = share(&s.trim, points, p->id.cell[0], p->id.cell[1]);
            crossed += what == 1;
            assert_true(what > 0 || covering);
            // a cell whose middle is farther than 1 has no point nearer than 0.2
            bool near = from_border(&s.trim, points, (p->id.cell[0] + 0.5) / NU, (p->id.cell[1] + 0.5) / NV) < 1;
            for (size_t k = 0; k < n; k++) {
                double x = p->bezier.coef[k] / 2, y = p->bezier.coef[n + k] / 3, z = p->bezier.coef[2 * n + k] - 1;
                if (fabs(z) < 1e-12) continue;
                assert_int_equal(what, 2);
                // cells are 1/12 and 3/20: the border's own cell, and then 0.5
                assert_true(!near || k % 4 > 0 || from_border(&s.trim, points, x, y) >= 1e-3);
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
            for (int m = 0; m < curve->count[0]; m += 20) {
                double r = curve->coef[m], t = curve->coef[curve->count[0] + m];
                double px = x[0] + r * (x[1] - x[0]) + t * (x[2] - x[0]);
                double py = y[0] + r * (y[1] - y[0]) + t * (y[2] - y[0]);
                c->off = fmax(c->off, trims_off(c->trim, c->points, px / 2, py / 3));
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
        for (int k = 0; k < (t == 0 ? 2 : 1); k++) {
            scene s;
            begin(&s, make_plane, k == 0 ? flat_cover : scene_dome, trims[t]);
            s.tile.covering = true;
            s.o.trimmed = KN_TRIMMED_CLIP;
            s.o.crossing_tol = 1e-4;
            if (t == 2) s.o.count[0] = 3, s.o.count[1] = 2; // long borders in one patch
            double *points = trims_dense(&s.trim);
            kn_job *job = NULL;
            cut_parts parts = {&s.trim, points, 0, 0, 0};
            kn_sink sink = {.user = &parts, .commit = measure_block};
            if (kn_job_create(s.ctx, &job, &s.base, 1, &s.tile, &s.o) != KN_OK) fail_msg("%s", kn_ctx_message(s.ctx));
            assert_int_equal(kn_job_run(s.ctx, job, &sink, 1), KN_OK);
            kn_job_report report = kn_job_describe(job);
            assert_true(report.crossing_error > 0 && report.crossing_error <= 1e-4);
            assert_true(parts.trimmed > 4 && report.trim_curves > 3);
            // the region's border is 5 long at most; dense points are 1e-4 off a curve
            assert_true(fabs(parts.area - 6 * trims_area(&s.trim)) <= 5 * report.crossing_error);
            assert_true(parts.off <= report.crossing_error + 2e-4);
            kn_job_destroy(s.ctx, job);
            free(points);
            end(&s);
        }
}

// ---- overhanging tiles, a curved base, a border of one closed spline ----

static void blob(kn_ctx *ctx, kn_trim *trim)
{
    static const double knots[12] = {0, 0, 0, 0, 0.2, 0.4, 0.6, 0.8, 1, 1, 1, 1};
    static const double coef[16] = {0.82, 0.85, 0.6,  0.35, 0.14, 0.15, 0.5,  0.82, // u
                                    0.45, 0.7,  0.93, 0.6,  0.8,  0.3,  0.05, 0.45};
    trim->curves = kn_alloc_zero(ctx, 1, sizeof *trim->curves);
    assert_non_null(trim->curves);
    assert_int_equal(kn_spline_init(ctx, &trim->curves[0], 1, 2, false, (const int[]){3}, (const int[]){8},
                                    (const double *const[]){knots}, coef),
                     KN_OK);
    trim->ncurves = 1;
    trims_end_loop(ctx, trim);
}

// The same as cubics.
static void blob_pieces(kn_ctx *ctx, kn_trim *trim)
{
    kn_trim whole = {0};
    kn_bezier *pieces = NULL;
    size_t n = 0;
    blob(ctx, &whole);
    assert_int_equal(kn_spline_to_bezier(ctx, &pieces, &n, &whole.curves[0]), KN_OK);
    assert_int_equal(n, 5);
    for (size_t i = 0; i < n; i++) {
        trims_add_curve(ctx, trim, 3, pieces[i].coef, pieces[i].coef + 4);
        kn_bezier_clear(ctx, &pieces[i]);
    }
    trims_end_loop(ctx, trim);
    kn_free(ctx, pieces);
    kn_trim_clear(ctx, &whole);
}

static void bent(kn_ctx *ctx, kn_spline *out)
{
    scene_bicubic(ctx, out, 0.05);
}

typedef struct hang {
    const scene *s;
    cut_parts parts;
    uint64_t hash;
    double worst; // share of a patch that is left, against that of a grid's points
    bool seen[4][3], look;
} hang;

static void add_hash(hang *h, const double *x, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        uint64_t bits;
        memcpy(&bits, &x[i], sizeof bits);
        h->hash = (h->hash ^ bits) * UINT64_C(0x100000001b3);
    }
}

// Where the diamond of a cell puts (r,t), from its own control points.
static void in_base(const hang *h, const int cell[2], double r, double t, double at[2])
{
    const double *c = h->s->tile.parts[0].splines[0].coef;
    for (int d = 0; d < 2; d++, c += 4) {
        double x = (1 - r) * ((1 - t) * c[0] + t * c[1]) + r * ((1 - t) * c[2] + t * c[3]);
        at[d] = (cell[d] + x) / h->s->o.count[d];
    }
}

// The share of a patch over the region, by a grid of points.
static double grid_share(const hang *h, const int cell[2])
{
    enum { GRID = 32 };
    int in = 0;
    double at[2];
    for (int k = 0; k < GRID * GRID; k++) {
        in_base(h, cell, (k / GRID + 0.5) / GRID, (k % GRID + 0.5) / GRID, at);
        in += trims_is_inside(h->parts.trim, h->parts.points, at[0], at[1]);
    }
    return (double)in / (GRID * GRID);
}

static kn_status hang_block(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)ctx, (void)product;
    hang *h = user;
    for (size_t i = 0; i < block->count; i++) {
        const kn_patch *p = &block->patches[i];
        double at[2];
        assert_int_equal(p->id.piece, 0);
        add_hash(h, p->bezier.coef, 3 * kn_bezier_count(&p->bezier));
        for (int k = 0; p->trim && k < p->trim->ncurves; k++) {
            const kn_spline *c = &p->trim->curves[k];
            add_hash(h, c->coef, 2 * kn_spline_count(c));
            for (int m = 0; h->look && m < c->count[0]; m += 20) {
                in_base(h, p->id.cell, c->coef[m], c->coef[c->count[0] + m], at);
                h->parts.off = fmax(h->parts.off, trims_off(h->parts.trim, h->parts.points, at[0], at[1]));
            }
        }
        h->parts.trimmed += p->trim != NULL;
        double left = p->trim ? scene_trim_area(p->trim) : 1.0;
        if (h->look) h->worst = fmax(h->worst, fabs(left - grid_share(h, p->id.cell)));
        h->seen[p->id.cell[0]][p->id.cell[1]] = true;
    }
    return KN_OK;
}

// Corners of a tile reach into neighbours: each is cut along the border wherever it is, with any number of threads.
static void overhangs_are_cut(void **state)
{
    (void)state;
    uint64_t hash = 0;
    for (int threads = 1; threads <= 3; threads += 2) {
        scene s;
        kn_trim pieces = {0};
        kn_job *job = NULL;
        begin(&s, bent, scene_diamond, blob);
        kn_ctx *safe = s.ctx, *ctx = test_ctx(&s.memory, threads);
        blob_pieces(safe, &pieces);
        s.o.count[0] = 4, s.o.count[1] = 3;
        s.o.trimmed = KN_TRIMMED_CLIP;
        s.o.crossing_tol = 1e-3;
        double *points = trims_dense(&pieces);
        hang h = {.s = &s, .look = threads == 1, .parts = {.trim = &pieces, .points = points}};
        kn_sink sink = {.user = &h, .commit = hang_block};
        if (kn_job_create(ctx, &job, &s.base, 1, &s.tile, &s.o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
        assert_int_equal(kn_job_run(ctx, job, &sink, 1), KN_OK);
        double error = kn_job_describe(job).crossing_error;
        for (int k = 0; k < 12; k++)
            if (h.look && !h.seen[k / 3][k % 3]) h.worst = fmax(h.worst, grid_share(&h, (const int[]){k / 3, k % 3}));
        assert_true(error > 0 && error <= 1e-3 && h.parts.trimmed > 4);
        // distances in the plane of (2 u, 3 v): less than 1.3 times those on the base and 0.2 above it, whose
        // derivatives are 3 long; chords of 1/96 of a piece are 1e-4 off
        assert_true(h.parts.off <= 1.3 * error + 1e-4);
        // the border crosses at most 2 (length) 32 + 2 of the grid's squares, each at most half wrong; its length in
        // one patch is less than 3
        assert_true(h.worst <= (3.0 * 32 + 1) / (32 * 32));
        if (threads > 1) assert_true(h.hash == hash);
        hash = h.hash;
        kn_job_destroy(ctx, job);
        kn_ctx_destroy(ctx);
        kn_trim_clear(safe, &pieces);
        free(points);
        end(&s);
    }
}

static kn_status try_trimmed(kn_ctx *ctx, void *user)
{
    const scene *s = user;
    kn_job *job = NULL;
    scene_result r = {0};
    kn_sink sink = scene_sink(&r);
    kn_status status = kn_job_create(ctx, &job, &s->base, 1, &s->tile, &s->o);
    assert_true((status == KN_OK) == (job != NULL));
    if (status == KN_OK) status = kn_job_run(ctx, job, &sink, 1);
    kn_sink_close(ctx, &sink);
    kn_job_destroy(ctx, job);
    scene_result_clear(&r);
    return status;
}

// Allocations that fail, the first ones and some of all, are told, and leave nothing behind.
static void little_memory(void **state)
{
    enum { PLACES = 10 };
    (void)state;
    scene s;
    begin(&s, make_plane, flat_cover, trims_disc);
    s.o.count[0] = 1, s.o.count[1] = 1;
    s.o.trimmed = KN_TRIMMED_CLIP;
    s.o.crossing_tol = 0.05;
    size_t calls = s.memory.calls;
    assert_int_equal(try_trimmed(s.ctx, &s), KN_OK);
    calls = s.memory.calls - calls;
    for (size_t k = 0; k < PLACES; k++) { // all of them would take minutes
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 1);
        memory.fail_at = memory.calls + (k < PLACES / 2 ? k : k * calls / PLACES);
        assert_int_equal(try_trimmed(ctx, &s), KN_ENOMEM);
        assert_int_equal(kn_ctx_error(ctx), KN_ENOMEM);
        test_ctx_end(ctx, &memory);
    }
    end(&s);
}

static void bad_trims(void **state)
{
    (void)state;
    scene s;
    kn_job *job = NULL;
    begin(&s, make_plane, scene_plate, trims_disc);
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
        cmocka_unit_test(overhangs_are_cut),
        cmocka_unit_test(little_memory),
        cmocka_unit_test(bad_trims),
    };
    return cmocka_run_group_tests_name("job/trimmed", tests, NULL, NULL);
}
