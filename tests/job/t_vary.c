// SPDX-License-Identifier: Apache-2.0
// Tiles that vary over the base: shared edges bit for bit, values against tiles of constant parameters, the taper.
#include "tests/support/support.h"

#include "tests/support/scene.h"
#include "tests/support/surfaces.h"

#include <knurl/io.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- tiles ----

// The dome with "lift", which raises all of it, its border too, and "bulge", which moves what is inside the cell.
static void changing_dome(kn_ctx *ctx, kn_tile *out)
{
    scene_dome(ctx, out);
    assert_int_equal(kn_tile_add_parameter(ctx, out, "lift", 0, 1, 0, 2), KN_OK);
    assert_int_equal(kn_tile_add_parameter(ctx, out, "bulge", 1, 2, 0.5, 2), KN_OK);
    for (int s = 0; s < 4; s++) {
        kn_spline target = {0};
        for (int k = 0; k < 2; k++) {
            assert_int_equal(kn_spline_copy(ctx, &target, &out->parts[0].splines[s]), KN_OK);
            size_t n = kn_spline_count(&target);
            for (size_t i = 0; i < n; i++) {
                double *u = &target.coef[i], *v = u + n, *w = v + n;
                double inside = *u * (1 - *u) * *v * (1 - *v); // 0 on the border of the cell
                if (k == 0) *w += 0.5;
                if (k == 1) *w += 2 * inside, *u += inside, *v -= 0.5 * inside;
            }
            assert_int_equal(kn_tile_set_target(ctx, out, k, 0, s, &target), KN_OK);
        }
        kn_spline_clear(ctx, &target);
    }
}

// ---- fields ----

static double waves(const void *user, const kn_place *p)
{
    (void)user;
    return 0.6 + 0.3 * sin(2 * p->point[0] + p->point[1]) + 0.2 * cos(3 * p->point[2]);
}

static double by_normal(const void *user, const kn_place *p)
{
    (void)user;
    return 1.2 + 0.5 * p->normal[0] * p->normal[1] + 0.1 * p->curvature[0];
}

static double constant(const void *user, const kn_place *p)
{
    (void)p;
    return *(const double *)user;
}

static double nowhere(const void *user, const kn_place *p)
{
    (void)user;
    return p->uv[0] > 0.5 ? NAN : 1;
}

// ---- edges ----

// Control points of an edge, 4 numbers each.
typedef struct edge {
    double p[4 * (KN_MAX_DEGREE + 1)];
    int n;
} edge;

static edge edge_of(const kn_bezier *b, int which)
{
    int var = which / 2, along = 1 - var, end = which % 2;
    size_t row = (size_t)b->degree[1] + 1, all = kn_bezier_count(b);
    edge e = {.n = b->degree[along] + 1};
    for (int k = 0; k < e.n; k++)
        for (int c = 0; c < b->ncomp; c++) {
            size_t i = (size_t)(var == 0 ? end * b->degree[0] : k), j = (size_t)(var == 0 ? k : end * b->degree[1]);
            e.p[4 * k + c] = b->coef[(size_t)c * all + i * row + j];
        }
    return e;
}

// Whether two edges are one within tol, in either direction.
static bool same_edge(const edge *a, const edge *b, double tol)
{
    if (a->n != b->n) return false;
    for (int back = 0; back < 2; back++) {
        bool same = true;
        for (int k = 0; same && k < a->n; k++)
            same = test_max_difference(a->p + 4 * k, b->p + 4 * (back ? b->n - 1 - k : k), 4) <= tol;
        if (same) return true;
    }
    return false;
}

static edge *all_edges(const scene_result *r)
{
    edge *edges = calloc(4 * r->count, sizeof *edges);
    assert_non_null(edges);
    for (size_t i = 0; i < 4 * r->count; i++) edges[i] = edge_of(&r->patches[i / 4].bezier, (int)(i % 4));
    return edges;
}

// How many edges no other patch has.
static size_t open_edges(const scene_result *r, double tol)
{
    size_t n = 4 * r->count, open = 0;
    edge *edges = all_edges(r);
    for (size_t i = 0; i < n; i++) {
        bool found = false;
        for (size_t j = 0; j < n && !found; j++) found = j != i && same_edge(&edges[i], &edges[j], tol);
        open += !found;
    }
    free(edges);
    return open;
}

static kn_job *make_job(kn_ctx *ctx, const kn_spline *bases, int n, const kn_tile *tile, const kn_job_options *o)
{
    kn_job *job = NULL;
    kn_status status = kn_job_create(ctx, &job, bases, n, tile, o);
    if (status != KN_OK) print_error("%s\n", kn_ctx_message(ctx));
    assert_int_equal(status, KN_OK);
    return job;
}

// ---- tests ----

// Fields vary from control point to control point, and all edges but those of the base's border are still shared.
static void edges_stay_shared(void **state)
{
    (void)state;
    for (int which = 0; which < 3; which++) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 1);
        kn_spline base = {0};
        kn_tile tile = {0};
        changing_dome(ctx, &tile);
        if (which == 0) scene_spline(ctx, &base);
        if (which == 1) scene_cylinder(ctx, &base);
        if (which == 2) make_torus(ctx, &base);
        const kn_field_octaves noise = {.size = 0.7, .octaves = 2, .seed = 3, .lo = 0.5, .hi = 2};
        kn_job_vary vary[] = {{"lift", {waves, NULL, KN_NEEDS_POINT}},
                              {"bulge", {0}},
                              {"height", {by_normal, NULL, KN_NEEDS_NORMAL | KN_NEEDS_CURVATURE}},
                              {"offset", {waves, NULL, KN_NEEDS_POINT}}};
        assert_int_equal(kn_field_noise(ctx, &vary[1].field, &noise), KN_OK);
        kn_job_options o = kn_job_defaults();
        o.count[0] = 8, o.count[1] = 6;
        if (which == 2) o.count[1] = 8;
        o.height = 0.1;
        o.normal_tol = 1e-2;
        o.vary = vary, o.nvary = 4;
        kn_job *job = make_job(ctx, &base, 1, &tile, &o);
        scene_result r;
        scene_run(ctx, job, &r);
        assert_true(r.count >= 4u * (size_t)o.count[0] * (size_t)o.count[1]);
        size_t border = which == 0 ? 2 * 2 * (8 + 6) : which == 1 ? 2 * 2 * 8 : 0;
        // n is the same on both sides of a line, bit for bit, and to some roundings where a torus closes (shell.h)
        assert_int_equal(open_edges(&r, which == 2 ? 4e-15 : 0), border);
        scene_result_clear(&r);
        kn_job_destroy(ctx, job);
        kn_tile_clear(ctx, &tile), kn_spline_clear(ctx, &base);
        test_ctx_end(ctx, &memory);
    }
}

// A field that is constant gives the tile of that parameter, and a height and an offset those of the options.
static void constants(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline base = {0};
    kn_tile tile = {0}, varied = {0};
    scene_spline(ctx, &base);
    changing_dome(ctx, &tile);
    const double lift = 0.4, bulge = 7, height = 1.5, offset = -0.03, values[2] = {lift, bulge}; // bulge: at most 2
    const kn_job_vary vary[] = {{"lift", {constant, &lift, 0}},
                                {"bulge", {constant, &bulge, 0}},
                                {"height", {constant, &height, 0}},
                                {"offset", {constant, &offset, 0}}};
    assert_int_equal(kn_tile_vary(ctx, &varied, &tile, values), KN_OK);
    for (int side = 0; side < 3; side++) {
        kn_job_options o = kn_job_defaults();
        o.count[0] = 6, o.count[1] = 4;
        o.height = 0.1, o.offset = 0.01;
        o.side = (kn_job_side)side;
        o.quarter_turns = side;
        o.vary = vary, o.nvary = 4;
        kn_job *job = make_job(ctx, &base, 1, &tile, &o);
        o.vary = NULL, o.nvary = 0;
        o.height = 0.15, o.offset = 0.01 - 0.03;
        kn_job *plain = make_job(ctx, &base, 1, &varied, &o);
        scene_result a, b;
        scene_run(ctx, job, &a);
        scene_run(ctx, plain, &b);
        assert_int_equal(a.count, b.count);
        for (size_t i = 0; i < a.count; i++) {
            const kn_bezier *p = &a.patches[i].bezier, *q = &b.patches[i].bezier;
            // coordinates up to 5; composed in two ways, each within some ten roundings of them (t_job)
            assert_true(memcmp(&a.patches[i].id, &b.patches[i].id, sizeof(kn_patch_id)) == 0);
            assert_true(test_max_difference(p->coef, q->coef, 3 * kn_bezier_count(p)) <= 5e-14);
        }
        scene_result_clear(&a), scene_result_clear(&b);
        kn_job_destroy(ctx, job), kn_job_destroy(ctx, plain);
    }
    kn_tile_clear(ctx, &tile), kn_tile_clear(ctx, &varied), kn_spline_clear(ctx, &base);
    test_ctx_end(ctx, &memory);
}

// An edge of a varied tile patch: where its ends stand in space, and the heights of its control points.
typedef struct foot {
    int surface;
    double end[2][3], w[3];
} foot;

static foot foot_of(kn_ctx *ctx, const kn_job *job, const kn_patch_id *id, int which)
{
    kn_bezier d = {0};
    kn_patch_place place;
    assert_int_equal(kn_job_source(ctx, &d, &place, job, id), KN_OK);
    const edge e = edge_of(&d, which);
    foot f = {.surface = place.surface};
    assert_int_equal(e.n, 3);
    for (int k = 0; k < 3; k++) f.w[k] = e.p[4 * k + 2];
    for (int k = 0; k < 2; k++) {
        double at[2];
        for (int v = 0; v < 2; v++)
            at[v] = (double)scene_parameter(job, place.surface, v,
                                            (long double)place.cell[v] + (long double)e.p[8 * k + v]);
        assert_int_equal(kn_shell_eval(ctx, f.end[k], NULL, kn_job_shell(job, place.surface), at[0], at[1], 0),
                         KN_OK);
    }
    kn_bezier_clear(ctx, &d);
    return f;
}

// Edges that teapot patches share, in all the ways in which edges may meet: where two edges of tiles stand on one
// curve, their heights are the same, bit for bit.
static void teapot(void **state)
{
    (void)state;
    enum { USED = 12, CELLS = 2, EDGES = 4 * 4 * CELLS * CELLS * USED };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline bases[USED] = {{0}};
    for (int k = 0; k < USED; k++)
        if (!make_teapot(ctx, &bases[k], k)) skip();
    kn_tile tile = {0};
    changing_dome(ctx, &tile);
    kn_job_vary vary[] = {{"lift", {waves, NULL, KN_NEEDS_POINT}},
                          {"height", {by_normal, NULL, KN_NEEDS_NORMAL | KN_NEEDS_CURVATURE}}};
    kn_job_options o = kn_job_defaults();
    o.count[0] = o.count[1] = CELLS;
    o.spacing = KN_CELLS_UNIFORM;
    o.height = 0.05;
    o.normal_tol = 1e-2;
    o.vary = vary, o.nvary = 2;
    kn_job *job = make_job(ctx, bases, USED, &tile, &o);
    scene_result r;
    scene_run(ctx, job, &r);
    assert_int_equal(4 * r.count, EDGES);
    foot *feet = calloc(EDGES, sizeof *feet);
    assert_non_null(feet);
    for (size_t i = 0; i < EDGES; i++) feet[i] = foot_of(ctx, job, &r.patches[i / 4].id, (int)(i % 4));
    size_t shared = 0;
    for (size_t i = 0; i < EDGES; i++)
        for (size_t j = i + 1; j < EDGES; j++)
            for (int back = 0; back < 2 && feet[i].surface != feet[j].surface; back++) {
                const foot *f = &feet[i], *g = &feet[j];
                if (test_max_difference(f->end[0], g->end[back], 3) > 1e-9 ||
                    test_max_difference(f->end[1], g->end[1 - back], 3) > 1e-9)
                    continue;
                shared++;
                for (int k = 0; k < 3; k++) assert_true(f->w[k] == g->w[back ? 2 - k : k]);
            }
    // three rings of four patches: four edges in each, and four between two of them, of 2 CELLS pieces
    assert_int_equal(shared, 2 * CELLS * (3 * 4 + 2 * 4));
    free(feet);
    scene_result_clear(&r);
    kn_job_destroy(ctx, job);
    for (int k = 0; k < USED; k++) kn_spline_clear(ctx, &bases[k]);
    kn_tile_clear(ctx, &tile);
    test_ctx_end(ctx, &memory);
}

// ---- the taper ----

static double left_half(const void *user, const kn_place *p)
{
    (void)user;
    return p->uv[0] < 0.5;
}

// A plane of 10 x 10 units: a sheet at w = 1, whose composed control points are the heights.
static void taper(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double knots[] = {0, 0, 10, 10}, *both[2] = {knots, knots},
                 coef[12] = {0, 0, 10, 10, 0, 10, 0, 10, 0, 0, 0, 0};
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    kn_spline base = {0}, sheet = {0};
    kn_tile tile = {0};
    assert_int_equal(kn_spline_init(ctx, &base, 2, 3, false, degree, count, both, coef), KN_OK);
    const double unit[] = {0, 0, 1, 1}, *units[2] = {unit, unit}, flat[12] = {0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
    assert_int_equal(kn_spline_init(ctx, &sheet, 2, 3, false, degree, count, units, flat), KN_OK);
    assert_int_equal(kn_tile_init(ctx, &tile, "sheet", 1), KN_OK);
    assert_int_equal(kn_tile_add(ctx, &tile, 0, &sheet), KN_OK);
    kn_job_options o = kn_job_defaults();
    o.count[0] = o.count[1] = 10;
    o.height = 2, o.offset = 0.5;
    o.taper = 4;
    for (int masked = 0; masked < 2; masked++) {
        if (masked) o.select.mask = (kn_field){left_half, NULL, 0};
        kn_job *job = make_job(ctx, &base, 1, &tile, &o);
        scene_result r;
        scene_run(ctx, job, &r);
        for (size_t i = 0; i < r.count; i++) {
            const kn_bezier *b = &r.patches[i].bezier;
            size_t n = kn_bezier_count(b);
            for (size_t k = 0; k < n;
                 k++) { // the corners: control points between them lie on chords of the smooth step
                size_t row = (size_t)b->degree[1] + 1, at[2] = {k / row, k % row};
                if (at[0] % (size_t)b->degree[0] != 0 || at[1] % (size_t)b->degree[1] != 0) continue;
                double x = b->coef[k], y = b->coef[n + k], last = masked ? 5 : 10;
                double d = fmin(fmin(x, last - x), fmin(y, 10 - y)), t = fmin(fmax(d, 0) / 4, 1);
                assert_true(fabs(b->coef[2 * n + k] - (0.5 + 2 * t * t * (3 - 2 * t))) <= 1e-12);
            }
        }
        scene_result_clear(&r);
        kn_job_destroy(ctx, job);
    }
    kn_tile_clear(ctx, &tile), kn_spline_clear(ctx, &sheet), kn_spline_clear(ctx, &base);
    test_ctx_end(ctx, &memory);
}

// ---- chance ----

// One square of side 0.2 in the middle of the cell at w = 1, over 8 x 8 cells: what chance did to it is read off D.
static void chance(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double unit[] = {0, 0, 1, 1}, *units[2] = {unit, unit},
                 coef[12] = {0.4, 0.4, 0.6, 0.6, 0.4, 0.6, 0.4, 0.6, 1, 1, 1, 1};
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    kn_spline base = {0}, square = {0};
    kn_tile tile = {0};
    scene_bicubic(ctx, &base, 0);
    assert_int_equal(kn_spline_init(ctx, &square, 2, 3, false, degree, count, units, coef), KN_OK);
    assert_int_equal(kn_tile_init(ctx, &tile, "square", 1), KN_OK);
    assert_int_equal(kn_tile_add(ctx, &tile, 0, &square), KN_OK);
    kn_job_options o = kn_job_defaults();
    o.count[0] = o.count[1] = 8;
    o.height = 0.5, o.offset = 0.1;
    o.random = (kn_job_random){.seed = 4, .angle = 0.3, .shift = 0.1, .scale = 0.2, .height = 0.4};
    double least[5] = {9, 9, 9, 9, 9}, most[5] = {-9, -9, -9, -9, -9};
    for (int round = 0; round < 2; round++) { // the same again
        kn_job *job = make_job(ctx, &base, 1, &tile, &o);
        for (int i = 0; i < 64; i++) {
            const kn_patch_id id = {.cell = {i / 8, i % 8}};
            kn_patch_place place;
            kn_bezier d = {0};
            assert_int_equal(kn_job_source(ctx, &d, &place, job, &id), KN_OK);
            const double *u = d.coef, *v = u + 4, *w = v + 4, x = u[2] - u[0], y = v[2] - v[0];
            const double seen[5] = {atan2(y, x), hypot(x, y) / 0.2, (u[0] + u[3]) / 2 - 0.5, (v[0] + v[3]) / 2 - 0.5,
                                    (w[0] - 0.1) / 0.5};
            for (int k = 0; k < 5; k++) least[k] = fmin(least[k], seen[k]), most[k] = fmax(most[k], seen[k]);
            kn_bezier_clear(ctx, &d);
        }
        kn_job_destroy(ctx, job);
    }
    // 64 draws: within the bounds (and some roundings), and over more than half of them both ways
    const double middle[5] = {0, 1, 0, 0, 1}, reach[5] = {0.3, 0.2, 0.1, 0.1, 0.4};
    for (int k = 0; k < 5; k++) {
        assert_true(least[k] >= middle[k] - reach[k] - 1e-12 && most[k] <= middle[k] + reach[k] + 1e-12);
        assert_true(least[k] < middle[k] - 0.5 * reach[k] && most[k] > middle[k] + 0.5 * reach[k]);
    }
    kn_job *job = NULL;
    tile.covering = true;
    assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_EDOMAIN);
    tile.covering = false;
    o.random.scale = 1;
    assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_EDOMAIN);
    o.random.scale = 0.2, o.random.angle = -1;
    assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_EDOMAIN);
    assert_null(job);
    kn_tile_clear(ctx, &tile), kn_spline_clear(ctx, &square), kn_spline_clear(ctx, &base);
    test_ctx_end(ctx, &memory);
}

// ---- failures ----

static void refusals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline base = {0};
    kn_tile tile = {0};
    scene_spline(ctx, &base);
    changing_dome(ctx, &tile);
    kn_job *job = NULL;
    kn_job_options o = kn_job_defaults();
    o.count[0] = 6, o.count[1] = 4;
    const double one = 1;
    kn_job_vary vary[2] = {{"girth", {constant, &one, 0}}, {"lift", {constant, &one, 0}}};
    o.vary = vary, o.nvary = 1;
    static const char *const says[] = {"girth", "no field", "twice", "nan"};
    for (int k = 0; k < 4; k++) {
        if (k == 1) vary[0] = (kn_job_vary){"height", {0}};
        if (k == 2) vary[0] = vary[1], o.nvary = 2;
        if (k == 3) vary[0].field = (kn_field){nowhere, NULL, 0}, o.nvary = 1;
        kn_ctx_clear_error(ctx);
        assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_EDOMAIN);
        assert_non_null(strstr(kn_ctx_message(ctx), says[k]));
        assert_null(job);
    }
    o.nvary = -1;
    assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_EDOMAIN);
    o.nvary = 0, o.taper = -1;
    assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_EDOMAIN);
    o.taper = INFINITY;
    assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_EDOMAIN);
    kn_tile_clear(ctx, &tile), kn_spline_clear(ctx, &base);
    test_ctx_end(ctx, &memory);
}

typedef struct scene {
    kn_spline base;
    kn_tile tile;
} scene;

static kn_status job_call(kn_ctx *ctx, void *user)
{
    const scene *s = user;
    const double height = 2;
    const kn_job_vary vary[2] = {{"lift", {waves, NULL, KN_NEEDS_POINT}}, {"height", {constant, &height, 0}}};
    kn_job_options o = kn_job_defaults();
    o.count[0] = o.count[1] = 1;
    o.vary = vary, o.nvary = 2;
    o.taper = 0.5;
    o.normal_tol = 0.1;
    kn_job *job = NULL;
    kn_sink sink = {0};
    kn_status status = kn_job_create(ctx, &job, &s->base, 1, &s->tile, &o);
    assert_true((status == KN_OK) == (job != NULL));
    if (status == KN_OK) status = kn_null_sink(ctx, &sink);
    if (status == KN_OK) status = kn_job_run(ctx, job, &sink, 1);
    kn_sink_close(ctx, &sink);
    kn_job_destroy(ctx, job);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    scene s = {0};
    const double knots[] = {0, 0, 1, 1}, *both[2] = {knots, knots}, flat[12] = {0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    kn_spline sheet = {0};
    scene_bicubic(ctx, &s.base, 0.1);
    assert_int_equal(kn_spline_init(ctx, &sheet, 2, 3, false, degree, count, both, flat), KN_OK);
    assert_int_equal(kn_tile_init(ctx, &s.tile, "sheet", 1), KN_OK);
    assert_int_equal(kn_tile_add(ctx, &s.tile, 0, &sheet), KN_OK);
    assert_int_equal(kn_tile_add_parameter(ctx, &s.tile, "lift", 0, 1, 0, 1), KN_OK);
    for (int i = 8; i < 12; i++) sheet.coef[i] = 0.5;
    assert_int_equal(kn_tile_set_target(ctx, &s.tile, 0, 0, 0, &sheet), KN_OK);
    kn_spline_clear(ctx, &sheet);
    test_allocation_failures(job_call, &s);
    kn_tile_clear(ctx, &s.tile), kn_spline_clear(ctx, &s.base);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(edges_stay_shared),
                                       cmocka_unit_test(constants),
                                       cmocka_unit_test(teapot),
                                       cmocka_unit_test(taper),
                                       cmocka_unit_test(chance),
                                       cmocka_unit_test(refusals),
                                       cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("job/vary", tests, NULL, NULL);
}
