// SPDX-License-Identifier: Apache-2.0
// Patches merged into surfaces: how many, that no value moved, that seams inside are smooth, that edges still pair.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/patches.h"
#include "tests/support/scene.h"
#include "tests/support/surfaces.h"

#include <knurl/io.h>

// ---- a sink that keeps what comes ----

typedef struct kept {
    kn_ctx *ctx;
    kn_spline surface[512];
    size_t n;
    double length; // of all edges, by chords
    double area;
} kept;

static kn_status keep_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    kept *k = user;
    (void)product;
    for (size_t i = 0; i < block->count; i++) {
        const kn_spline s = kn_patch_spline(&block->patches[i]);
        assert_true(k->n < 512);
        assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
        assert_int_equal(kn_spline_copy(ctx, &k->surface[k->n++], &s), KN_OK);
        if (!block->patches[i].edge) continue;
        for (int e = 0; e < 4; e++) { // edges lie on the ends, whatever their parameters are
            const kn_spline *edge = &block->patches[i].edge[e];
            for (int end = 0; end < 2; end++) {
                double x[3], y[3], at[2];
                at[e / 2] = e % 2, at[1 - e / 2] = end;
                assert_int_equal(kn_spline_eval(ctx, x, &s, at), KN_OK);
                assert_int_equal(kn_spline_eval(ctx, y, edge, &(double){end}), KN_OK);
                for (int c = 0; c < 3; c++) assert_true(fabs(x[c] - y[c]) <= 1e-9);
            }
        }
    }
    return KN_OK;
}

static void clear_kept(kept *k)
{
    for (size_t i = 0; i < k->n; i++) kn_spline_clear(k->ctx, &k->surface[i]);
}

// The largest jump of the first derivative in either variable at inner knots, relative to that derivative.
static double jump(kn_ctx *ctx, const kn_spline *s)
{
    double most = 0.0;
    for (int v = 0; v < 2; v++)
        for (int k = s->degree[v] + 1; k < s->count[v]; k++) {
            double at[2], below[9], above[9];
            for (int i = 0; i < 5; i++) {
                at[1 - v] = 0.1 + 0.2 * i;
                at[v] = nextafter(s->knots[v][k], 0.0);
                assert_int_equal(kn_spline_derivatives(ctx, below, s, at, 1), KN_OK);
                at[v] = s->knots[v][k];
                assert_int_equal(kn_spline_derivatives(ctx, above, s, at, 1), KN_OK);
                double size = 0.0, diff = 0.0;
                for (int c = 3; c < 9; c++)
                    size = fmax(size, fabs(above[c])), diff = fmax(diff, fabs(above[c] - below[c]));
                most = fmax(most, diff / size);
            }
        }
    return most;
}

// Points of some exact patches lie on one of the merged surfaces: the nearest of a grid of its points, and from there
// by Gauss' and Newton's method.
static void distances(kn_ctx *ctx, const kept *exact, const kept *merged, double tolerance)
{
    for (size_t i = 0; i < exact->n; i += 1 + exact->n / 5) {
        double at[2] = {0.3, 0.6}, x[3], best = INFINITY;
        assert_int_equal(kn_spline_eval(ctx, x, &exact->surface[i], at), KN_OK);
        for (size_t k = 0; k < merged->n; k++) {
            const kn_spline *s = &merged->surface[k];
            double u = 0.5, v = 0.5, here = INFINITY, y[9], seed[2] = {0.5, 0.5};
            for (int p = 0; p <= 20; p++)
                for (int q = 0; q <= 20; q++) {
                    double w[2] = {p / 20.0, q / 20.0}, d = 0.0;
                    assert_int_equal(kn_spline_eval(ctx, y, s, w), KN_OK);
                    for (int c = 0; c < 3; c++) d += (y[c] - x[c]) * (y[c] - x[c]);
                    if (d < here) here = d, seed[0] = w[0], seed[1] = w[1];
                }
            u = seed[0], v = seed[1];
            for (int step = 0; step < 20; step++) { // Gauss & Newton
                double w[2] = {u, v}, a = 0.0, b = 0.0, c2 = 0.0, f = 0.0, g = 0.0, d = 0.0;
                assert_int_equal(kn_spline_derivatives(ctx, y, s, w, 1), KN_OK);
                for (int c = 0; c < 3; c++) {
                    double e = y[c] - x[c];
                    a += y[3 + c] * y[3 + c], b += y[3 + c] * y[6 + c], c2 += y[6 + c] * y[6 + c];
                    f += y[3 + c] * e, g += y[6 + c] * e, d += e * e;
                }
                here = d;
                double det = a * c2 - b * b;
                if (!(det > 0.0)) break;
                u = fmin(1.0, fmax(0.0, u - (c2 * f - b * g) / det));
                v = fmin(1.0, fmax(0.0, v - (a * g - b * f) / det));
            }
            best = fmin(best, sqrt(here));
        }
        assert_true(best <= tolerance);
    }
}

typedef struct expected {
    const char *tile;
    void (*base)(kn_ctx *ctx, kn_spline *out);
    int count[2], max_degree, cells;
    size_t most_faces;
} expected;

static void bent(kn_ctx *ctx, kn_spline *out)
{
    scene_bicubic(ctx, out, 0.3);
}

static void few_faces(void **state)
{
    (void)state;
    // Over one span of a bicubic: cells of bump are flat at their borders and join C1. Pyramids have creases all
    // round.
    static const expected cases[] = {
        {"bump", bent, {4, 4}, KN_MAX_DEGREE, 4, 1}, {"bump", bent, {4, 4}, KN_MAX_DEGREE, 2, 4},
        {"bump", bent, {3, 5}, KN_MAX_DEGREE, 8, 1}, {"bump", bent, {4, 4}, 5, 4, 1},
        {"bump", make_torus, {4, 4}, 11, 4, 50},     {"knurl", bent, {4, 4}, KN_MAX_DEGREE, 4, 208},
    };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const expected *e = &cases[i];
        kn_spline base = {0};
        kn_tile tile;
        kn_job *job = NULL;
        static kept all, few;
        all = (kept){.ctx = ctx}, few = (kept){.ctx = ctx};
        kn_merge_summary sum;
        kn_limit_summary limits;
        e->base(ctx, &base);
        assert_int_equal(kn_builtin_tile(ctx, &tile, e->tile), KN_OK);
        kn_job_options o = {
            .count = {e->count[0], e->count[1]}, .height = 0.05, .normal_tol = 1e-3, .max_degree = KN_MAX_DEGREE};
        assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_OK);
        kn_sink inner = {.user = &few, .commit = keep_commit}, merged,
                sinks[2] = {{.user = &all, .commit = keep_commit}};
        double tolerance = e->max_degree < KN_MAX_DEGREE ? 1e-3 : 1e-9;
        assert_int_equal(kn_merge_sink(ctx, &merged, &inner, 1,
                                       &(kn_merge_options){.tolerance = tolerance, .cells = e->cells, .angle = 0.01},
                                       &sum),
                         KN_OK);
        assert_int_equal(kn_limit_sink(ctx, &sinks[1], &merged, 1,
                                       &(kn_limit_options){.max_degree = e->max_degree, .tolerance = 1e-3}, &limits),
                         KN_OK);
        assert_int_equal(kn_job_run(ctx, job, sinks, 2), KN_OK);
        for (int k = 0; k < 2; k++) kn_sink_close(ctx, &sinks[k]);
        assert_true(sum.patches == all.n && sum.faces == few.n && sum.error <= tolerance);
        assert_true(sum.angle <= 0.01);
        assert_true(sum.faces <= e->most_faces && (sum.merged > 0) == (sum.faces < sum.patches));
        if (e->most_faces < sum.patches) assert_true(sum.merged > 0);
        for (size_t k = 0; k < few.n; k++) assert_true(jump(ctx, &few.surface[k]) <= 1e-6);
        distances(ctx, &all, &few, limits.error + sum.error + 1e-9);
        clear_kept(&all), clear_kept(&few);
        kn_job_destroy(ctx, job);
        kn_tile_clear(ctx, &tile);
        kn_spline_clear(ctx, &base);
    }
    test_ctx_end(ctx, &memory);
}

static kn_status feed(kn_ctx *ctx, const kn_merge_options *o, const kn_patch *patches, size_t n,
                      kn_merge_summary *sum)
{
    test_tile tile;
    kn_job_report report = test_report(n, 3, 3);
    kn_sink inner = {0}, sink = {0};
    test_tile_make(&tile, 1);
    kn_status status = kn_null_sink(ctx, &inner);
    if (status == KN_OK) status = kn_merge_sink(ctx, &sink, &inner, 1, o, sum);
    if (status != KN_OK) {
        kn_sink_close(ctx, &inner);
        return status;
    }
    status = test_feed(ctx, &sink, &tile.tile, &report, patches, n, 1);
    kn_sink_close(ctx, &sink);
    return status;
}

// Four quarters of one bicubic, the last one turned by a quarter: one surface, which is C2 but for rounding. Torn
// apart, or with one of another kind, they are not.
enum { QUARTERS = 4 };
static void make_quarters(kn_ctx *ctx, kn_patch patches[QUARTERS])
{
    kn_patch whole;
    kn_bezier half[2] = {{0}, {0}};
    test_rng rng = test_random(4);
    test_patch(ctx, &whole, &rng, 3, 3, false, 0.0, 0.1);
    assert_int_equal(kn_bezier_subdivide(ctx, &half[0], &half[1], &whole.bezier, 0, 0.5), KN_OK);
    for (int i = 0; i < 2; i++) {
        patches[2 * i] = patches[2 * i + 1] = (kn_patch){.segments = {2, 2}, .exact = true};
        assert_int_equal(
            kn_bezier_subdivide(ctx, &patches[2 * i].bezier, &patches[2 * i + 1].bezier, &half[i], 1, 0.5), KN_OK);
        kn_bezier_clear(ctx, &half[i]);
    }
    double turned[48];
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 4; i++)
            for (int j = 0; j < 4; j++) turned[16 * c + 4 * i + j] = patches[3].bezier.coef[16 * c + 4 * (3 - j) + i];
    memcpy(patches[3].bezier.coef, turned, sizeof turned);
    kn_bezier_clear(ctx, &whole.bezier);
}

static void quarters(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_patch patches[QUARTERS];
    kn_merge_summary sum;
    const kn_merge_options o = {.tolerance = 1e-9};
    make_quarters(ctx, patches);
    assert_int_equal(feed(ctx, &o, patches, QUARTERS, &sum), KN_OK);
    assert_true(sum.patches == 4 && sum.faces == 1 && sum.merged == 1 && sum.c2 == 1 && sum.error < 1e-12);
    patches[3].id.cell[1] = 4; // beyond the fourth cell
    assert_int_equal(feed(ctx, &o, patches, QUARTERS, &sum), KN_OK);
    assert_true(sum.faces == 3 - (sum.merged - 1) && sum.faces >= 2);
    patches[3].id.cell[1] = 0, patches[3].look = 0, patches[3].reversed = true;
    assert_int_equal(feed(ctx, &o, patches, QUARTERS, &sum), KN_OK);
    assert_true(sum.faces == 3);
    patches[3].reversed = false;
    for (int i = 0; i < 48; i++) patches[3].bezier.coef[i] += i < 16 ? 0.01 : 0.0; // torn off
    assert_int_equal(feed(ctx, &o, patches, QUARTERS, &sum), KN_OK);
    assert_true(sum.faces == 3 && sum.merged == 1);
    for (int i = 0; i < QUARTERS; i++) kn_bezier_clear(ctx, &patches[i].bezier);
    test_ctx_end(ctx, &memory);
}

static void normal_at(kn_ctx *ctx, double n[3], const kn_spline *s, double u, double v)
{
    double x[9];
    assert_int_equal(kn_spline_derivatives(ctx, x, s, (double[]){u, v}, 1), KN_OK);
    for (int c = 0; c < 3; c++)
        n[c] = x[3 + (c + 1) % 3] * x[6 + (c + 2) % 3] - x[3 + (c + 2) % 3] * x[6 + (c + 1) % 3];
}

// Two halves whose derivatives across the seam differ a little: what joining turns at the outer edges is within what
// the summary says, and where that is too much they stay two.
static void turned_edges(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_patch patches[QUARTERS];
    static kept few;
    kn_merge_summary sum;
    double most = 0.0;
    make_quarters(ctx, patches);                                                // 0 and 1 lie side by side in t
    for (int i = 0; i < 4; i++) patches[1].bezier.coef[32 + 4 * i + 1] += 2e-3; // z beside the seam
    for (int run = 0; run < 2; run++) {
        kn_merge_options o = {.tolerance = 1e-2, .angle = run ? 0.5 * most : 0.0};
        test_tile tile;
        kn_job_report report = test_report(2, 3, 3);
        kn_sink inner = {.user = &few, .commit = keep_commit}, sink;
        few = (kept){.ctx = ctx};
        test_tile_make(&tile, 1);
        assert_int_equal(kn_merge_sink(ctx, &sink, &inner, 1, &o, &sum), KN_OK);
        assert_int_equal(test_feed(ctx, &sink, &tile.tile, &report, patches, 2, 1), KN_OK);
        kn_sink_close(ctx, &sink);
        assert_int_equal(sum.faces, run ? 2 : 1);
        for (int i = 0; i <= 100 && run == 0; i++) {
            kn_spline one = {0};
            const kn_spline *s = &few.surface[0];
            double n[3], m[3], x[3], t = (i / 2) / 50.0, joint = s->knots[1][s->degree[1] + 1];
            assert_int_equal(kn_spline_of_bezier(ctx, &one, &patches[i % 2].bezier), KN_OK);
            normal_at(ctx, n, &one, 0.0, t);
            normal_at(ctx, m, s, 0.0, i % 2 ? joint + t * (1.0 - joint) : t * joint);
            kn_spline_clear(ctx, &one);
            for (int c = 0; c < 3; c++) x[c] = n[(c + 1) % 3] * m[(c + 2) % 3] - n[(c + 2) % 3] * m[(c + 1) % 3];
            most = fmax(most, atan2(hypot(hypot(x[0], x[1]), x[2]), n[0] * m[0] + n[1] * m[1] + n[2] * m[2]));
        }
        assert_true(run || (most > 1e-4 && most <= sum.angle && sum.unknown_angles == 0));
        clear_kept(&few);
    }
    for (int i = 0; i < QUARTERS; i++) kn_bezier_clear(ctx, &patches[i].bezier);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static const kn_merge_options bad[] = {{0.0, 0, 0.0},  {NAN, 0, 0.0}, {1.0, -1, 0.0}, {1.0, 65, 0.0},
                                           {1.0, 0, -0.1}, {1.0, 0, 0.9}, {1.0, 0, NAN}};
    kn_sink inner = {0}, sink = {0};
    kn_patch none;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(feed(ctx, &bad[i], &none, 0, NULL), KN_EDOMAIN);
    assert_int_equal(kn_merge_sink(ctx, &sink, &inner, 1, &(kn_merge_options){.tolerance = 1.0, .cells = 1}, NULL),
                     KN_EDOMAIN);
    assert_int_equal(kn_merge_sink(ctx, &sink, &inner, 0, &(kn_merge_options){.tolerance = 1.0, .cells = 1}, NULL),
                     KN_EDOMAIN);
    assert_null(sink.user);
    test_ctx_end(ctx, &memory);
}

static kn_status starved(kn_ctx *ctx, void *user)
{
    return feed(ctx, &(kn_merge_options){.tolerance = 1e-9}, user, QUARTERS, NULL);
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_patch patches[QUARTERS];
    make_quarters(ctx, patches);
    test_allocation_failures(starved, patches);
    for (int i = 0; i < QUARTERS; i++) kn_bezier_clear(ctx, &patches[i].bezier);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quarters),  cmocka_unit_test(turned_edges),
        cmocka_unit_test(failures),  cmocka_unit_test(allocation_failures),
        cmocka_unit_test(few_faces),
    };
    return cmocka_run_group_tests_name("io/merge_sink", tests, NULL, NULL);
}
