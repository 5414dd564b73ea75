// SPDX-License-Identifier: Apache-2.0
// Where a tile goes on over an edge that two surfaces share, and where it must not.
#include "tests/support/support.h"

#include "tests/support/scene.h"

#include <knurl/knurl.h>
#include <math.h>
#include <string.h>

// A strip of one column of cells along y in [0,1]: bilinear spans between the knots, x from x0 to x0 + dx, and z from
// z0 to z0 + dz.
typedef struct strip {
    int n; // control points along y, at most 4
    double y[4], knots[6];
    bool backward; // v runs against y, and u against x
    double x0, dx, dz;
} strip;

static void make_strip(kn_ctx *ctx, kn_spline *out, const strip *s)
{
    static const double u[] = {0, 0, 1, 1};
    const double *knots[2] = {u, s->knots};
    const int degree[2] = {1, 1}, count[2] = {2, s->n};
    double coef[24];
    size_t n = (size_t)s->n;
    for (size_t i = 0; i < 2; i++)
        for (size_t j = 0; j < n; j++) {
            size_t a = s->backward ? 1 - i : i, b = s->backward ? n - 1 - j : j;
            coef[i * n + j] = s->x0 + s->dx * (double)a;
            coef[2 * n + i * n + j] = s->y[b];
            coef[4 * n + i * n + j] = s->dz * (double)a;
        }
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, degree, count, knots, coef), KN_OK);
}

static void run(kn_ctx *ctx, kn_job **job, scene_result *r, const strip *strips, int nsurfaces, const kn_tile *tile,
                const int count[2])
{
    kn_spline s[2] = {{0}, {0}};
    for (int i = 0; i < nsurfaces; i++) make_strip(ctx, &s[i], &strips[i]);
    kn_job_options o = {.count = {count[0], count[1]}, .height = 0.125, .normal_tol = 1e-9};
    assert_int_equal(kn_job_create(ctx, job, s, nsurfaces, tile, &o), KN_OK);
    kn_sink sink = scene_sink(r);
    assert_int_equal(kn_job_run(ctx, *job, &sink, 1), KN_OK);
    kn_sink_close(ctx, &sink);
    for (int i = 0; i < 2; i++) kn_spline_clear(ctx, &s[i]);
}

static int places_on_other(kn_ctx *ctx, const kn_job *job, const scene_result *r)
{
    int n = 0;
    for (size_t i = 0; i < r->count; i++) {
        kn_bezier d = {0};
        kn_patch_place place;
        assert_int_equal(kn_job_source(ctx, &d, &place, job, &r->patches[i].id), KN_OK);
        n += place.surface != r->patches[i].id.surface;
        kn_bezier_clear(ctx, &d);
    }
    return n;
}

// Two strips that share the edge x = 1, and whether a tile goes on over it: over one curve with one parametrization,
// where the cell lines and the normals of both sides meet.
static void goes_on_where_all_agrees(void **state)
{
    (void)state;
    static const strip flat = {2, {0, 1}, {0, 0, 1, 1}, false, 0, 1, 0};
    static const strip three = {4, {0, 0.25, 0.75, 1}, {0, 0, 1, 2, 3, 3}, false, 0, 1, 0};
    static const strip even = {3, {0, 0.5, 1}, {0, 0, 0.5, 1, 1}, false, 0, 1, 0};
    static const strip uneven = {3, {0, 0.5, 1}, {0, 0, 0.3, 1, 1}, false, 0, 1, 0};
    const struct {
        strip first, second;
        bool backward;
        double dz; // of the second
        int count, beyond;
    } cases[] = {
        {flat, flat, false, 0, 2, 4},       {flat, flat, true, 0, 3, 6},
        {flat, flat, false, 1, 2, 0}, // a crease
        {three, three, false, 0, 4, 8},     {three, three, true, 0, 6, 12},
        {three, three, true, 0, 4, 0}, // the fourth line lies in the first span of one and in the last of the other
        {uneven, uneven, false, 0, 10, 20}, {even, uneven, false, 0, 10, 0}, // the same points, other knots
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 1);
        strip strips[2] = {cases[k].first, cases[k].second};
        strips[1].x0 = 1, strips[1].dz = cases[k].dz, strips[1].backward = cases[k].backward;
        kn_tile tile = {0};
        kn_job *job = NULL;
        scene_result r = {0};
        scene_strip(ctx, &tile); // reaches over both ends of u
        run(ctx, &job, &r, strips, 2, &tile, (const int[2]){2, cases[k].count});
        int beyond = places_on_other(ctx, job, &r);
        if (beyond != cases[k].beyond) fail_msg("case %zu: %d pieces go on, not %d", k, beyond, cases[k].beyond);
        scene_result_clear(&r);
        kn_job_destroy(ctx, job);
        kn_tile_clear(ctx, &tile);
        test_ctx_end(ctx, &memory);
    }
}

// Two pairs of strips in the same place: of two bodies each goes on over its own edge, and onto no other surface.
static void bodies_stay_apart(void **state)
{
    (void)state;
    static const int bodies[] = {0, 0, 3, 3};
    strip strips[4];
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s[4] = {{0}};
    kn_tile tile = {0};
    kn_job *job = NULL;
    scene_result r = {0};
    scene_strip(ctx, &tile);
    for (int i = 0; i < 4; i++) {
        strips[i] = (strip){2, {0, 1}, {0, 0, 1, 1}, false, i % 2, 1, 0};
        make_strip(ctx, &s[i], &strips[i]);
    }
    kn_job_options o = {.count = {2, 2}, .height = 0.125, .normal_tol = 1e-9, .bodies = bodies};
    assert_int_equal(kn_job_create(ctx, &job, s, 4, &tile, &o), KN_OK);
    kn_sink sink = scene_sink(&r);
    assert_int_equal(kn_job_run(ctx, job, &sink, 1), KN_OK);
    kn_sink_close(ctx, &sink);
    assert_int_equal(places_on_other(ctx, job, &r), 2 * 4);
    for (size_t i = 0; i < r.count; i++) {
        kn_bezier d = {0};
        kn_patch_place place;
        const kn_patch *p = &r.patches[i];
        assert_int_equal(p->body, bodies[p->id.surface]);
        assert_int_equal(kn_job_source(ctx, &d, &place, job, &p->id), KN_OK);
        assert_int_equal(bodies[place.surface], p->body);
        kn_bezier_clear(ctx, &d);
    }
    scene_result_clear(&r);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    for (int i = 0; i < 4; i++) kn_spline_clear(ctx, &s[i]);
    test_ctx_end(ctx, &memory);
}

// A wall at u = 1 of its cell stands on that cell's side of a crease, beside the patches that it meets there.
static void walls_stay_in_their_cell(void **state)
{
    (void)state;
    static const double line[] = {0, 0, 1, 1}, fold[] = {0, 0, 1, 2, 2};
    const double *square[2] = {line, line}, *folded[2] = {fold, line};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int at = 0; at < 2; at++) {
        const double wall[12] = {at, at, at, at, 0.25, 0.25, 0.75, 0.75, 0, 1, 0, 1};
        const double base[18] = {0, 0, 1, 1, 1, 1, 0, 1, 0, 1, 0, 1, 0, 0, 0, 0, 1, 1}; // z = 0, then x = 1
        kn_spline s = {0}, w = {0};
        kn_tile tile = {0};
        kn_job *job = NULL;
        scene_result r = {0};
        assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, (const int[]){1, 1}, (const int[]){3, 2}, folded, base),
                         KN_OK);
        assert_int_equal(kn_spline_init(ctx, &w, 2, 3, false, (const int[]){1, 1}, (const int[]){2, 2}, square, wall),
                         KN_OK);
        assert_int_equal(kn_tile_init(ctx, &tile, "wall", 1), KN_OK);
        assert_int_equal(kn_tile_add(ctx, &tile, 0, &w), KN_OK);
        kn_job_options o = {.count = {2, 1}, .height = 0.125};
        assert_int_equal(kn_job_create(ctx, &job, &s, 1, &tile, &o), KN_OK);
        kn_sink sink = scene_sink(&r);
        assert_int_equal(kn_job_run(ctx, job, &sink, 1), KN_OK);
        kn_sink_close(ctx, &sink);
        assert_int_equal(r.count, 2);
        for (size_t i = 0; i < r.count; i++) {
            const kn_bezier *b = &r.patches[i].bezier;
            size_t n = kn_bezier_count(b);
            // The corner where r = 0 and w = 1: 1/8 along the normal, which is z in cell 0 and -x in cell 1.
            size_t top = (size_t)b->degree[1];
            int cell = r.patches[i].id.cell[0];
            double x = cell == 0 ? at : 1 - 0.125, z = cell == 0 ? 0.125 : at;
            assert_true(fabs(b->coef[top] - x) < 1e-6 && fabs(b->coef[2 * n + top] - z) < 1e-6);
        }
        scene_result_clear(&r);
        kn_job_destroy(ctx, job);
        kn_tile_clear(ctx, &tile);
        kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &w);
    }
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(goes_on_where_all_agrees),
        cmocka_unit_test(bodies_stay_apart),
        cmocka_unit_test(walls_stay_in_their_cell),
    };
    return cmocka_run_group_tests_name("job/edges", tests, NULL, NULL);
}
