// SPDX-License-Identifier: Apache-2.0
// Meshes over trimmed surfaces, cut off at the border: areas by Green's formula, dense polygons along the same borders,
// and what neighbours have in common.
#include "tests/support/support.h"

#include "tests/support/scene.h"
#include "tests/support/surfaces.h"
#include "tests/support/trims.h"

#include <knurl/job.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

// All meshes of a job as triangles by themselves.
typedef struct soup {
    double *at; // 9 numbers each
    size_t n, room, meshes;
    uint64_t hash;
} soup;

typedef struct scene {
    test_memory memory;
    kn_ctx *ctx;
    kn_spline base[2];
    int nbases;
    kn_tile tile;
    kn_trim trim[2];
    kn_job_options o;
    double *points;
} scene;

// ---- tiles ----

static void set_mesh(kn_ctx *ctx, kn_tile *tile, double (*at)[3], size_t nvertices, uint32_t *triangle,
                     size_t ntriangles)
{
    kn_mesh mesh = {.nvertices = nvertices, .ntriangles = ntriangles, .position = &at[0][0], .triangle = triangle};
    assert_int_equal(kn_tile_init(ctx, tile, "mesh", 1), KN_OK);
    assert_int_equal(kn_tile_set_mesh(ctx, tile, 0, &mesh), KN_OK);
}

// A roof over the whole cell, 0 on its edges.
static void roof(kn_ctx *ctx, kn_tile *tile)
{
    double at[5][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.4, 0.55, 1}};
    uint32_t triangle[12] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
    set_mesh(ctx, tile, at, 5, triangle, 4);
}

// A block with upright walls, closed.
static void block(kn_ctx *ctx, kn_tile *tile)
{
    static const uint32_t quads[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                         {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    double at[8][3];
    uint32_t triangle[36];
    for (int i = 0; i < 8; i++) {
        at[i][0] = 0.1 + 0.7 * (i >> 2 & 1), at[i][1] = 0.15 + 0.75 * (i >> 1 & 1), at[i][2] = i & 1;
    }
    for (int q = 0; q < 6; q++) {
        const uint32_t *c = quads[q], v[6] = {c[0], c[1], c[2], c[0], c[2], c[3]};
        memcpy(triangle + 6 * q, v, sizeof v);
    }
    set_mesh(ctx, tile, at, 8, triangle, 12);
}

// A sheet from u = -0.5 to u = 1.5, at w = 0.
static void wide_sheet(kn_ctx *ctx, kn_tile *tile)
{
    double at[4][3] = {{-0.5, 0, 0}, {1.5, 0, 0}, {1.5, 1, 0}, {-0.5, 1, 0}};
    uint32_t triangle[6] = {0, 1, 2, 0, 2, 3};
    set_mesh(ctx, tile, at, 4, triangle, 2);
}

// An upright wall along the cell's end of u.
static void wall(kn_ctx *ctx, kn_tile *tile)
{
    double at[4][3] = {{1, 0, 0}, {1, 1, 0}, {1, 1, 1}, {1, 0, 1}};
    uint32_t triangle[6] = {0, 1, 2, 0, 2, 3};
    set_mesh(ctx, tile, at, 4, triangle, 2);
}

// ---- scenes ----

static void begin(scene *s, void (*make)(kn_ctx *, kn_spline *), void (*tile)(kn_ctx *, kn_tile *),
                  void (*trim)(kn_ctx *, kn_trim *))
{
    *s = (scene){.memory = TEST_MEMORY_INIT,
                 .o = {.height = 0.2, .max_degree = 40, .trimmed = KN_TRIMMED_CLIP, .crossing_tol = 1e-4}};
    s->ctx = test_ctx(&s->memory, 1);
    s->nbases = 1;
    make(s->ctx, &s->base[0]);
    tile(s->ctx, &s->tile);
    trim(s->ctx, &s->trim[0]);
    s->points = trims_dense(&s->trim[0]);
    s->o.trims = s->trim;
    s->o.count[0] = 8, s->o.count[1] = 7;
}

static void end(scene *s)
{
    kn_tile_clear(s->ctx, &s->tile);
    for (int i = 0; i < 2; i++) {
        kn_spline_clear(s->ctx, &s->base[i]);
        kn_trim_clear(s->ctx, &s->trim[i]);
    }
    free(s->points);
    test_ctx_end(s->ctx, &s->memory);
}

static kn_status take(kn_ctx *ctx, void *user, const kn_patch_block *patches, void *product)
{
    (void)ctx, (void)product;
    soup *to = user;
    for (size_t i = 0; i < patches->count; i++) {
        const kn_mesh *m = patches->patches[i].mesh;
        if (!m) continue;
        to->meshes++;
        if (to->n + m->ntriangles > to->room) {
            to->room = 2 * (to->n + m->ntriangles);
            to->at = realloc(to->at, to->room * 9 * sizeof *to->at);
            assert_non_null(to->at);
        }
        for (size_t k = 0; k < 3 * m->ntriangles; k++) {
            memcpy(to->at + 9 * to->n + 3 * k, m->position + 3 * (size_t)m->triangle[k], 3 * sizeof(double));
            for (size_t c = 0; c < 3; c++) {
                uint64_t bits;
                memcpy(&bits, to->at + 9 * to->n + 3 * k + c, sizeof bits);
                to->hash = (to->hash ^ bits) * UINT64_C(0x100000001b3);
            }
        }
        to->n += m->ntriangles;
    }
    return KN_OK;
}

static kn_status try_run(kn_ctx *ctx, const scene *s, soup *out, kn_job_report *report)
{
    kn_job *job = NULL;
    kn_sink sink = {.user = out, .commit = take};
    kn_status status = kn_job_create(ctx, &job, s->base, s->nbases, &s->tile, &s->o);
    assert_true((status == KN_OK) == (job != NULL));
    if (status == KN_OK) status = kn_job_run(ctx, job, &sink, 1);
    if (status == KN_OK && report) *report = kn_job_describe(job);
    kn_sink_close(ctx, &sink);
    kn_job_destroy(ctx, job);
    return status;
}

static kn_job_report run(scene *s, soup *out)
{
    kn_job_report report = {0};
    if (try_run(s->ctx, s, out, &report) != KN_OK) fail_msg("%s", kn_ctx_message(s->ctx));
    return report;
}

static double area_above(const soup *m)
{
    double sum = 0;
    for (size_t i = 0; i < m->n; i++) {
        const double *p = m->at + 9 * i, *q = p + 3, *r = p + 6;
        sum += ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])) / 2;
    }
    return sum;
}

// ---- what is left ----

// Over the plane [0,2] x [0,3] at z = 1, whose images are straight: what is left of roofs that cover all cells has the
// area of the region, and no point of it lies beyond.
static void areas_agree(void **state)
{
    (void)state;
    static void (*const trims[])(kn_ctx *, kn_trim *) = {trims_plate_with_hole, trims_disc, trims_bay};
    for (int t = 0; t < 3; t++)
        for (int k = 0; k < 2; k++) {
            scene s;
            soup m = {0};
            begin(&s, make_plane, roof, trims[t]);
            if (k == 1) s.o.count[0] = s.o.count[1] = 1; // holes inside of triangles
            kn_job_report report = run(&s, &m);
            assert_true(report.crossing_error > 0 && report.crossing_error <= 1e-4);
            // the border is 5 long at most
            assert_true(fabs(area_above(&m) - 6 * trims_area(&s.trim[0])) <= 5 * report.crossing_error);
            for (size_t i = 0; i < 3 * m.n; i += 4) // dense points are 1e-4 off a curve
                assert_true(trims_off(&s.trim[0], s.points, m.at[3 * i] / 2, m.at[3 * i + 1] / 3) <=
                            report.crossing_error + 2e-4);
            free(m.at);
            end(&s);
        }
}

// Of what trims_bay leaves between two values of u, over the plane: below the cubic from (1, 0.3) to (0, 0.8).
static double strip_area(double from, double to)
{
    enum { STEPS = 4000 };
    static const double x[4] = {1, 0.9, 0.3, 0}, y[4] = {0.3, 0.9, 0.1, 0.8};
    double sum = 0, last[2] = {1, 0.3};
    for (int k = 1; k <= STEPS; k++) { // chords: 1e-6 off
        double t = (double)k / STEPS, r = 1 - t, b[4] = {r * r * r, 3 * r * r * t, 3 * r * t * t, t * t * t},
               at[2] = {0};
        for (int i = 0; i < 4; i++) at[0] += b[i] * x[i], at[1] += b[i] * y[i];
        double lo = fmax(from, at[0]), hi = fmin(to, last[0]), slope = (last[1] - at[1]) / (last[0] - at[0]);
        if (lo < hi) sum += (hi - lo) * (at[1] + slope * ((lo + hi) / 2 - at[0]));
        last[0] = at[0], last[1] = at[1];
    }
    return 6 * sum;
}

static int compare(const void *a, const void *b)
{
    const double *x = a, *y = b;
    for (int c = 0; c < 6; c++)
        if (x[c] != y[c]) return x[c] < y[c] ? -1 : 1;
    return 0;
}

// The edges of all triangles in order, each from its lower end.
static double (*edges_of(const soup *m))[6]
{
    double(*list)[6] = malloc((3 * m->n + 1) * sizeof *list);
    assert_non_null(list);
    for (size_t i = 0; i < 3 * m->n; i++) {
        double e[6];
        memcpy(e, m->at + 3 * i, 3 * sizeof *e);
        memcpy(e + 3, m->at + (i % 3 == 2 ? 3 * i - 6 : 3 * i + 3), 3 * sizeof *e);
        bool swap = false, known = false;
        for (int c = 0; c < 3 && !known; c++)
            if (e[c] != e[c + 3]) swap = e[c] > e[c + 3], known = true;
        for (int c = 0; c < 6; c++) list[i][c] = e[swap ? (c + 3) % 6 : c];
    }
    qsort(list, 3 * m->n, sizeof *list, compare);
    return list;
}

static bool on_side(const double *e)
{
    return (e[0] == e[3] && (e[0] == 0 || e[0] == 2)) || (e[1] == e[4] && (e[1] == 0 || e[1] == 3));
}

// Every edge has two triangles, bit for bit, over cells too, but for those along the border and the plane's sides. Of
// blocks, what the border leaves open has walls' heights.
static void cuts_meet(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        scene s;
        soup m = {0};
        begin(&s, make_plane, k == 0 ? roof : block, k == 0 ? trims_bay : trims_plate_with_hole);
        double error = run(&s, &m).crossing_error;
        double(*edges)[6] = edges_of(&m);
        size_t open = 0;
        for (size_t i = 0, n; i < 3 * m.n; i += n) {
            for (n = 1; i + n < 3 * m.n && compare(edges[i], edges[i + n]) == 0; n++) continue;
            assert_true(n <= 2);
            if (n == 2 || on_side(edges[i])) continue;
            open++;
            for (int e = 0; e < 2; e++) { // both of its ends are on the border
                double u = edges[i][3 * e] / 2, v = edges[i][3 * e + 1] / 3;
                double step = 4e-4 + 2 * error; // inside of the region by no more
                bool out = false;
                for (int c = 0; c < 8; c++)
                    out = out || !trims_is_inside(&s.trim[0], s.points, u + step * cos(c * 0.7854) / 2,
                                                  v + step * sin(c * 0.7854) / 3);
                assert_true(out);
            }
        }
        assert_true(open > 40);
        free(edges);
        free(m.at);
        end(&s);
    }
}

// Beyond an open end what is nearest in the region counts.
static void beyond_ends(void **state)
{
    (void)state;
    scene s;
    soup m = {0};
    begin(&s, make_plane, wide_sheet, trims_bay);
    s.o.count[0] = s.o.count[1] = 1;
    double error = run(&s, &m).crossing_error;
    double want = 6 * (trims_area(&s.trim[0]) + 0.5 * 0.3 + 0.5 * 0.8);
    assert_true(fabs(area_above(&m) - want) <= 7 * error);
    free(m.at);
    m = (soup){0};
    s.o.placement.border[0] = KN_BORDER_CLIP;
    error = run(&s, &m).crossing_error;
    assert_true(fabs(area_above(&m) - 6 * trims_area(&s.trim[0])) <= 5 * error);
    free(m.at);
    end(&s);
}

// A field of thickness, and a base that is bent: the bound holds, and the bits are the same for any number of threads.
static void bent_bases(void **state)
{
    (void)state;
    static const double knots[4] = {0, 0, 1, 1}, factor[4] = {0.5, 1, 1.5, 0.8};
    for (int k = 0; k < 2; k++) {
        scene s;
        soup m = {0}, again = {0};
        kn_spline h = {0};
        begin(&s, make_wavy, roof, trims_disc);
        assert_int_equal(kn_spline_init(s.ctx, &h, 2, 1, false, (const int[]){1, 1}, (const int[]){2, 2},
                                        (const double *const[]){knots, knots}, factor),
                         KN_OK);
        s.o.count[0] = 6, s.o.count[1] = 6, s.o.normal_tol = 1e-2;
        s.o.crossing_tol = 1e-3;
        if (k == 1) s.o.thickness = &h;
        double error = run(&s, &m).crossing_error;
        assert_true(error > 0 && error <= 1e-3);
        kn_ctx *ctx = test_ctx(&s.memory, 3);
        assert_int_equal(try_run(ctx, &s, &again, NULL), KN_OK);
        assert_true(m.n > 100 && again.n == m.n && again.hash == m.hash);
        kn_ctx_destroy(ctx);
        kn_spline_clear(s.ctx, &h);
        free(m.at), free(again.at);
        end(&s);
    }
}

// Sheets from u = -0.5 to u = 1.5 over two planes side by side, the second one turned round in two ways, with the same
// border on both: where they reach over the shared edge they are cut by what is there.
static void over_a_shared_edge(void **state)
{
    (void)state;
    for (int turned = 0; turned < 2; turned++) {
        scene s;
        soup m = {0};
        begin(&s, make_plane, wide_sheet, trims_bay);
        make_plane(s.ctx, &s.base[1]);
        double *c = s.base[1].coef; // (0,0), (0,1), (1,0), (1,1)
        for (int i = 0; i < 4; i++) c[i] += 2;
        if (turned) // half a turn: u and v run backwards
            for (int d = 0; d < 2; d++) {
                const double old[4] = {c[4 * d], c[4 * d + 1], c[4 * d + 2], c[4 * d + 3]};
                for (int i = 0; i < 4; i++) c[4 * d + i] = old[3 - i];
            }
        trims_bay(s.ctx, &s.trim[1]);
        s.nbases = 2;
        s.o.count[0] = 2, s.o.count[1] = 1;
        s.o.placement.border[0] = KN_BORDER_CLIP;
        double error = run(&s, &m).crossing_error;
        // each place is covered twice, but for the half cells at both open ends, which are covered once
        double twice = 0, want;
        for (int k = 0; k < 2; k++) {
            soup one = {0};
            scene alone;
            begin(&alone, make_plane, wide_sheet, trims_bay);
            alone.o.count[0] = 2, alone.o.count[1] = 1;
            alone.o.placement.border[0] = KN_BORDER_CLIP;
            (void)run(&alone, &one);
            twice += area_above(&one);
            free(one.at);
            end(&alone);
        }
        // over the shared edge: half a cell of each, [0.75,1] of the first one's u, and [0,0.25] or [0.75,1] of the second's
        want = twice + strip_area(0.75, 1) + (turned ? strip_area(0.75, 1) : strip_area(0, 0.25));
        assert_true(fabs(area_above(&m) - want) <= 24 * error);
        free(m.at);
        // one sheet alone, with a border that goes on: the seam between what lies on either side of the edge is no gap
        static const int first[1] = {0};
        m = (soup){0};
        s.o.count[0] = 1;
        kn_trim_clear(s.ctx, &s.trim[1]);
        trims_add_box(s.ctx, &s.trim[1], 0, turned ? 0.7 : 0, 1, turned ? 1 : 0.3);
        s.o.select.surfaces = first, s.o.select.nsurfaces = 1;
        error = run(&s, &m).crossing_error;
        want = 6 * trims_area(&s.trim[0]) + 6 * 0.5 * 0.3;
        assert_true(fabs(area_above(&m) - want) <= 8 * error);
        double(*edges)[6] = edges_of(&m);
        size_t seam = 0;
        for (size_t i = 0, n; i < 3 * m.n; i += n) {
            for (n = 1; i + n < 3 * m.n && compare(edges[i], edges[i + n]) == 0; n++) continue;
            if (edges[i][0] != 2 || edges[i][3] != 2) continue;
            assert_int_equal(n, 2);
            seam++;
        }
        assert_true(seam > 0);
        free(edges);
        free(m.at);
        end(&s);
    }
}

// A wall that stands on the shared edge belongs to its own cell: cut where the border ends there, v = 0.3. The second
// plane is not trimmed.
static void on_a_shared_edge(void **state)
{
    (void)state;
    scene s;
    soup m = {0};
    begin(&s, make_plane, wall, trims_bay);
    make_plane(s.ctx, &s.base[1]);
    for (int i = 0; i < 4; i++) s.base[1].coef[i] += 2;
    s.nbases = 2;
    s.o.count[0] = s.o.count[1] = 1;
    double error = run(&s, &m).crossing_error, sum[2] = {0, 0};
    for (size_t i = 0; i < m.n; i++) {
        const double *p = m.at + 9 * i, *q = p + 3, *r = p + 6;
        sum[p[0] > 3] += ((q[1] - p[1]) * (r[2] - p[2]) - (q[2] - p[2]) * (r[1] - p[1])) / 2;
    }
    assert_int_equal(m.meshes, 2);
    assert_true(fabs(sum[0] - 0.2 * 3 * 0.3) <= 0.2 * error && fabs(sum[1] - 0.2 * 3) <= 1e-14);
    free(m.at);
    end(&s);
}

static void volumes_are_refused(void **state)
{
    (void)state;
    scene s;
    soup m = {0};
    begin(&s, make_plane, scene_box, trims_disc);
    assert_int_equal(try_run(s.ctx, &s, &m, NULL), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(s.ctx), "volumes cannot be trimmed: "));
    end(&s);
}

static kn_status starve(kn_ctx *ctx, void *user)
{
    soup m = {0};
    kn_status status = try_run(ctx, user, &m, NULL);
    free(m.at);
    return status;
}

// The first allocations, and some of all: all of them would take minutes.
static void little_memory(void **state)
{
    enum { PLACES = 24 };
    (void)state;
    for (int over = 0; over < 2; over++) {
        scene s;
        begin(&s, make_plane, over ? wide_sheet : roof, over ? trims_bay : trims_disc);
        make_plane(s.ctx, &s.base[1]);
        for (int i = 0; i < 4; i++) s.base[1].coef[i] += 2;
        s.nbases = 1 + over;
        s.o.count[0] = s.o.count[1] = 1;
        s.o.crossing_tol = 0.05;
        size_t calls = s.memory.calls;
        assert_int_equal(starve(s.ctx, &s), KN_OK);
        calls = s.memory.calls - calls;
        for (size_t k = 0; k < PLACES; k++) {
            test_memory memory = TEST_MEMORY_INIT;
            kn_ctx *ctx = test_ctx(&memory, 1);
            memory.fail_at = memory.calls + (k < PLACES / 4 ? k : k * calls / PLACES);
            assert_int_equal(starve(ctx, &s), KN_ENOMEM);
            assert_int_equal(kn_ctx_error(ctx), KN_ENOMEM);
            test_ctx_end(ctx, &memory);
        }
        end(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(areas_agree),         cmocka_unit_test(cuts_meet),
        cmocka_unit_test(beyond_ends),         cmocka_unit_test(bent_bases),
        cmocka_unit_test(over_a_shared_edge),  cmocka_unit_test(on_a_shared_edge),
        cmocka_unit_test(volumes_are_refused), cmocka_unit_test(little_memory),
    };
    return cmocka_run_group_tests_name("job/trimmed_mesh", tests, NULL, NULL);
}
