// SPDX-License-Identifier: Apache-2.0
// Which cells there are, against the patches that the job without a selection makes.
#include "tests/support/support.h"

#include "tests/support/scene.h"
#include "tests/support/surfaces.h"

#include <knurl/knurl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NU = 24, NV = 20 }; // multiples of the spans of all bases

typedef struct scene {
    test_memory memory;
    kn_ctx *ctx;
    kn_spline base;
    kn_tile tile;
    kn_job_options o;
} scene;

static void begin(scene *s, void (*make)(kn_ctx *, kn_spline *), void (*tile)(kn_ctx *, kn_tile *))
{
    *s = (scene){.memory = TEST_MEMORY_INIT,
                 .o = {.count = {NU, NV}, .height = 0.2, .normal_tol = 1e-2, .max_degree = 40}};
    s->ctx = test_ctx(&s->memory, 2);
    make(s->ctx, &s->base);
    tile(s->ctx, &s->tile);
}

static void end(scene *s)
{
    kn_tile_clear(s->ctx, &s->tile);
    kn_spline_clear(s->ctx, &s->base);
    test_ctx_end(s->ctx, &s->memory);
}

// The cells with patches, as a table; what the report says of them agrees.
static kn_job_report run(scene *s, bool has[NU][NV], scene_result *r)
{
    kn_job *job = NULL;
    if (kn_job_create(s->ctx, &job, &s->base, 1, &s->tile, &s->o) != KN_OK) fail_msg("%s", kn_ctx_message(s->ctx));
    scene_run(s->ctx, job, r);
    kn_job_report report = kn_job_describe(job);
    memset(has, 0, sizeof(bool[NU][NV]));
    size_t cells = 0, dropped = 0;
    for (size_t i = 0; i < r->count; i++) has[r->patches[i].id.cell[0]][r->patches[i].id.cell[1]] = true;
    for (int i = 0; i < NU * NV; i++) cells += has[i / NV][i % NV];
    for (int k = 0; k < KN_DROP_REASONS; k++) dropped += report.dropped[k];
    assert_int_equal(report.cells, cells);
    assert_int_equal(report.cells + dropped, NU * NV);
    assert_int_equal(report.patches, r->count);
    kn_job_destroy(s->ctx, job);
    return report;
}

static double checkered(const void *user, const kn_place *place)
{
    (void)user;
    return place->point[2] > 0 && place->uv[0] < 0.5;
}

// By numbers, chance, a field and an angle: the torus of radii 3 and 1, whose middles of cells are known.
static void by_number_field_and_angle(void **state)
{
    (void)state;
    scene s;
    scene_result r;
    bool has[NU][NV], again[NU][NV];
    begin(&s, make_torus, scene_plate);
    s.o.select = (kn_job_selection){.skip = {3, 2}};
    kn_job_report report = run(&s, has, &r);
    for (int i = 0; i < NU * NV; i++) assert_int_equal(has[i / NV][i % NV], i / NV % 3 == 0 && i % NV % 2 == 0);
    assert_int_equal(report.dropped[KN_DROP_SKIP], NU * NV - NU / 3 * NV / 2);
    scene_result_clear(&r);

    s.o.select = (kn_job_selection){.first = 17, .count = 30};
    report = run(&s, has, &r);
    for (int i = 0; i < NU * NV; i++) assert_int_equal(has[i / NV][i % NV], i >= 17 && i < 47);
    scene_result_clear(&r);

    s.o.select = (kn_job_selection){.mask = {checkered, NULL, KN_NEEDS_POINT}};
    report = run(&s, has, &r);
    for (int i = 0; i < NU * NV; i++) assert_int_equal(has[i / NV][i % NV], i / NV < NU / 2 && i % NV < NV / 2);
    assert_int_equal(report.dropped[KN_DROP_MASK], NU * NV * 3 / 4);
    scene_result_clear(&r);

    // normals of the upper half of the tube, which is the first half of v
    s.o.select = (kn_job_selection){.cone = true, .cone_axis = {0, 0, 2}, .cone_angle = acos(-1.0) / 2};
    report = run(&s, has, &r);
    for (int i = 0; i < NU * NV; i++) assert_int_equal(has[i / NV][i % NV], i % NV < NV / 2);
    scene_result_clear(&r);

    const int none[1] = {0};
    s.o.select = (kn_job_selection){.surfaces = none, .nsurfaces = 0};
    report = run(&s, has, &r);
    assert_int_equal(report.dropped[KN_DROP_SURFACE], NU * NV);
    scene_result_clear(&r);

    s.o.select = (kn_job_selection){.density = 0.5, .seed = 3};
    report = run(&s, has, &r);
    assert_true(report.cells > NU * NV / 4 && report.cells < NU * NV * 3 / 4); // 5.5 deviations
    scene_result_clear(&r);
    s.o.select.density = 0.7; // who stayed stays
    report = run(&s, again, &r);
    for (int i = 0; i < NU * NV; i++) assert_true(!has[i / NV][i % NV] || again[i / NV][i % NV]);
    scene_result_clear(&r);
    end(&s);
}

// ---- slabs ----

// Heights between which the patches of every cell lie: those of 5 x 5 points each, so that cells which touch are known
// to; `reach` more by their control points is what may be kept in vain.
static void measure(scene *s, const scene_result *r, double lo[NU * NV], double hi[NU * NV])
{
    for (int i = 0; i < NU * NV; i++) lo[i] = INFINITY, hi[i] = -INFINITY;
    for (size_t i = 0; i < r->count; i++) {
        const kn_patch *p = &r->patches[i];
        int cell = p->id.cell[0] * NV + p->id.cell[1];
        for (int k = 0; k < 25; k++) {
            double point[3], at[2] = {0.25 * (k / 5), 0.25 * (k % 5)};
            assert_int_equal(kn_bezier_eval(s->ctx, point, &p->bezier, at), KN_OK);
            lo[cell] = fmin(lo[cell], point[2]);
            hi[cell] = fmax(hi[cell], point[2]);
        }
    }
}

static bool in_ranges(const kn_cell_range *list, size_t n, size_t cell)
{
    for (size_t i = 0; i < n; i++)
        if (cell >= list[i].first && cell - list[i].first < list[i].count) return true;
    return false;
}

// Of the cell but one behind its own, and of the one behind that: no parameter line of it is a line of cells.
static void make_far(kn_ctx *ctx, kn_tile *out)
{
    static const double coef[12] = {1.4, 1.9, 2.4, 2.9, 0.2, 0.9, 0.1, 0.8, 0.2, 0.5, 0.7, 1};
    assert_int_equal(kn_tile_init(ctx, out, "far", 1), KN_OK);
    scene_add_patch(ctx, out, 1, 1, coef);
}

static void slabs_miss_no_cell(void **state)
{
    (void)state;
    static const struct {
        void (*base)(kn_ctx *, kn_spline *);
        void (*tile)(kn_ctx *, kn_tile *);
        kn_job_placement placement;
        bool stretch;
    } cases[] = {{make_torus, scene_plate, {.shift = {0.0}}, false},
                 {make_torus, scene_strip, {.shift = {0.0}}, false},
                 {make_torus, scene_plate, {.stagger = {0.5}}, false},
                 {make_torus, scene_plate, {.shift = {0.0}}, true},
                 {make_wavy, scene_strip, {.shift = {0.0}}, false},
                 {make_wavy, scene_plate, {.scatter = {.distance = 0.4}}, false},
                 {make_wavy, make_far, {.border = {KN_BORDER_CLIP, KN_BORDER_CLIP}}, false}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        scene s;
        scene_result r;
        kn_job *job = NULL;
        kn_job_slabs *slabs = NULL;
        double lo[NU * NV], hi[NU * NV], z[2];
        begin(&s, cases[k].base, cases[k].tile);
        s.o.placement = cases[k].placement, s.o.stretch = cases[k].stretch;
        s.o.crossing = KN_CROSSING_TRIM;
        if (kn_job_create(s.ctx, &job, &s.base, 1, &s.tile, &s.o) != KN_OK)
            fail_msg("%zu: %s", k, kn_ctx_message(s.ctx));
        scene_run(s.ctx, job, &r);
        measure(&s, &r, lo, hi);
        assert_int_equal(kn_job_slabs_create(s.ctx, &slabs, job), KN_OK);
        kn_job_slabs_range(slabs, z);
        size_t kept = 0, touching = 0;
        for (int i = 0; i <= 40; i++) {
            kn_cell_range *list = NULL;
            size_t n = 0;
            double a = z[0] + (z[1] - z[0]) * i / 40, b = a + 0.01;
            assert_int_equal(kn_job_slabs_find(s.ctx, &list, &n, slabs, a, b), KN_OK);
            for (size_t c = 0; c < NU * NV; c++) {
                bool touches = lo[c] <= b && hi[c] >= a, found = in_ranges(list, n, c);
                if (touches && !found) fail_msg("case %zu: cell %zu is not in the slab", k, c);
                touching += touches, kept += found;
            }
            kn_free(s.ctx, list);
        }
        assert_true(touching > 0);
        if (kept > 3 * touching) fail_msg("case %zu: %zu cells for %zu", k, kept, touching); // not all for any
        kn_cell_range *list = NULL;
        size_t n = 9;
        assert_int_equal(kn_job_slabs_find(s.ctx, &list, &n, slabs, 1, 0), KN_EDOMAIN);
        assert_true(list == NULL && n == 9);
        kn_job_slabs_destroy(s.ctx, slabs);
        kn_job_slabs_destroy(s.ctx, NULL);
        kn_job_destroy(s.ctx, job);
        scene_result_clear(&r);
        end(&s);
    }
}

static void a_slab_selects(void **state)
{
    (void)state;
    scene s;
    scene_result r, part;
    bool has[NU][NV];
    double lo[NU * NV], hi[NU * NV];
    begin(&s, make_torus, scene_plate);
    (void)run(&s, has, &r);
    measure(&s, &r, lo, hi);
    s.o.select = (kn_job_selection){.slab = true, .slab_z = {0.3, 0.4}};
    kn_job_report report = run(&s, has, &part);
    assert_true(report.dropped[KN_DROP_SLAB] > NU * NV / 4);
    for (int i = 0; i < NU * NV; i++) assert_true(has[i / NV][i % NV] || hi[i] < 0.3 || lo[i] > 0.4);
    scene_result_clear(&r);
    scene_result_clear(&part);
    end(&s);
}

// ---- cameras ----

// On the x axis at `eye`, looking at the origin, or along x from afar (eye 0): a picture of (y, z), of half width `wide`
// at distance 1.
static kn_job_view camera(double eye, double wide)
{
    kn_job_view v = {.pixels = {400, 400}};
    if (eye != 0) { // y / (eye - x), depth between 0.1 and 100
        const double m[16] = {0,  1 / wide, 0, 0,  0, 0, 1 / wide, 0, -1.002, 0, 0, 1.002 * eye - 0.2002,
                              -1, 0,        0, eye};
        memcpy(v.matrix, m, sizeof m);
    } else {
        const double m[16] = {0, 1 / wide, 0, 0, 0, 0, 1 / wide, 0, -0.01, 0, 0, 0, 0, 0, 0, 1};
        memcpy(v.matrix, m, sizeof m);
    }
    return v;
}

static bool is_seen(const kn_job_view *v, const double p[3])
{
    double clip[4];
    for (int k = 0; k < 4; k++)
        clip[k] = v->matrix[4 * k] * p[0] + v->matrix[4 * k + 1] * p[1] + v->matrix[4 * k + 2] * p[2] +
                  v->matrix[4 * k + 3];
    for (int k = 0; k < 3; k++)
        if (fabs(clip[k]) > clip[3]) return false;
    return true;
}

// The segment from p to the eye passes through the ball of radius 2 less a little: 1e-3 of it.
static bool is_behind_sphere(const double p[3], double eye)
{
    double d[3] = {(eye != 0 ? eye : 1e6) - p[0], -p[1], -p[2]}, a = 0, b = 0, least = 0;
    for (int c = 0; c < 3; c++) a += d[c] * d[c], b -= d[c] * p[c];
    double t = fmin(fmax(b / a, 0), 1);
    for (int c = 0; c < 3; c++) least += (p[c] + t * d[c]) * (p[c] + t * d[c]);
    return sqrt(least) < 2 * 1.001;
}

// What is dropped cannot be seen: it is out of the picture, small, or behind the sphere.
static void cameras_drop_what_is_not_seen(void **state)
{
    (void)state;
    const struct {
        double eye, wide, least;
        bool hidden;
    } cases[] = {{5, 0.3, 0, false}, {0, 1, 0, false}, {8, 0.5, 0, true}, {0, 3, 0, true}, {50, 0.1, 20, true}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        scene s;
        scene_result all, part;
        bool has[NU][NV];
        begin(&s, make_sphere, scene_plate);
        (void)run(&s, has, &all);
        kn_job_view view = camera(cases[k].eye, cases[k].wide);
        view.least_pixels = cases[k].least, view.hidden = cases[k].hidden;
        s.o.select = (kn_job_selection){.view = &view};
        kn_job_report report = run(&s, has, &part);
        for (size_t i = 0; i < all.count; i++) {
            const kn_patch *p = &all.patches[i];
            if (has[p->id.cell[0]][p->id.cell[1]] || cases[k].least > 0) continue;
            for (int j = 0; j < 9; j++) {
                double point[3], at[2] = {0.5 * (j / 3), 0.5 * (j % 3)};
                assert_int_equal(kn_bezier_eval(s.ctx, point, &p->bezier, at), KN_OK);
                assert_true(!is_seen(&view, point) || (view.hidden && is_behind_sphere(point, cases[k].eye)));
            }
        }
        bool some = cases[k].hidden && cases[k].least == 0;
        assert_true(some ? report.dropped[KN_DROP_HIDDEN] > NU : true);
        assert_true(cases[k].wide < 3 && !cases[k].hidden ? report.dropped[KN_DROP_OUTSIDE] > NU : true);
        assert_true(cases[k].least > 0 ? report.dropped[KN_DROP_SMALL] > 0 : true);
        scene_result_clear(&all);
        scene_result_clear(&part);
        end(&s);
    }
}

// From afar tessellations are coarser, near the camera as without one.
static void detail_follows_the_camera(void **state)
{
    (void)state;
    int segments[2];
    for (int k = 0; k < 2; k++) {
        scene s;
        scene_result r;
        bool has[NU][NV];
        begin(&s, make_sphere, scene_plate);
        s.o.mesh_tol = 1e-3;
        kn_job_view view = camera(k == 0 ? 3 : 3000, k == 0 ? 1 : 0.001);
        view.pixels[0] = view.pixels[1] = k == 0 ? 4000 : 100;
        view.matrix[8] = 0, view.matrix[11] = 0; // any depth
        s.o.select = (kn_job_selection){.view = &view};
        kn_job_report report = run(&s, has, &r);
        assert_true(r.count > 0);
        segments[k] = 0;
        size_t triangles = 0;
        for (size_t i = 0; i < r.count; i++) {
            segments[k] = r.patches[i].segments[0] > segments[k] ? r.patches[i].segments[0] : segments[k];
            triangles += 2 * (size_t)r.patches[i].segments[0] * (size_t)r.patches[i].segments[1];
        }
        assert_int_equal(report.triangles, triangles);
        scene_result_clear(&r);
        end(&s);
    }
    assert_true(segments[1] < segments[0]);
}

// ---- what is refused ----

static double no_number(const void *user, const kn_place *place)
{
    (void)user, (void)place;
    return NAN;
}

static void nonsense_is_refused(void **state)
{
    (void)state;
    static const int ninth[1] = {9};
    kn_job_view empty = {.pixels = {10, 10}}, flat = camera(5, 1), odd = camera(5, 1), fuzzy = camera(5, 1);
    flat.pixels[1] = 0, odd.matrix[3] = NAN, fuzzy.chord_pixels = -1;
    const kn_job_selection cases[] = {{.surfaces = ninth, .nsurfaces = 1},
                                      {.nsurfaces = -1},
                                      {.nsurfaces = 2},
                                      {.skip = {-1, 0}},
                                      {.density = 1.5},
                                      {.density = NAN},
                                      {.cone = true},
                                      {.cone = true, .cone_axis = {1, 0, 0}, .cone_angle = -1},
                                      {.mask = {no_number, NULL, 0}},
                                      {.slab = true, .slab_z = {1, 0}},
                                      {.slab = true, .slab_z = {NAN, 0}},
                                      {.view = &empty},
                                      {.view = &flat},
                                      {.view = &odd},
                                      {.view = &fuzzy}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        scene s;
        kn_job *job = NULL;
        begin(&s, make_torus, scene_plate);
        s.o.select = cases[k];
        kn_status status = kn_job_create(s.ctx, &job, &s.base, 1, &s.tile, &s.o);
        if (status != KN_EDOMAIN || job) fail_msg("case %zu: %d", k, (int)status);
        end(&s);
    }
}

// ---- memory ----

static kn_status selects(kn_ctx *ctx, void *user)
{
    (void)user;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *safe = test_ctx(&memory, 1);
    kn_spline base = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    kn_job_slabs *slabs = NULL;
    kn_cell_range *list = NULL;
    size_t n = 0;
    scene_bicubic(safe, &base, 0.1);
    scene_diamond(safe, &tile);
    kn_job_view view = camera(9, 1);
    kn_job_options o = {.count = {1, 2}, .height = 0.1, .normal_tol = 1e-2, .select = {.view = &view}};
    kn_status status = kn_job_create(ctx, &job, &base, 1, &tile, &o);
    if (status == KN_OK) status = kn_job_slabs_create(ctx, &slabs, job);
    if (status == KN_OK) status = kn_job_slabs_find(ctx, &list, &n, slabs, -1, 1);
    assert_true((status == KN_OK) == (list != NULL));
    kn_free(ctx, list);
    kn_job_slabs_destroy(ctx, slabs);
    kn_job_destroy(ctx, job);
    kn_tile_clear(safe, &tile);
    kn_spline_clear(safe, &base);
    test_ctx_end(safe, &memory);
    return status;
}

static void allocation(void **state)
{
    (void)state;
    test_allocation_failures(selects, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(by_number_field_and_angle),
                                       cmocka_unit_test(slabs_miss_no_cell),
                                       cmocka_unit_test(a_slab_selects),
                                       cmocka_unit_test(cameras_drop_what_is_not_seen),
                                       cmocka_unit_test(detail_follows_the_camera),
                                       cmocka_unit_test(nonsense_is_refused),
                                       cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("job/select", tests, NULL, NULL);
}
