// SPDX-License-Identifier: Apache-2.0
// Scattered tiles: how far apart they are, how well they cover, and that chance is the same everywhere.
#include "tests/support/support.h"

#include "tests/support/scene.h"
#include "tests/support/surfaces.h"

#include <knurl/knurl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// A point-like casual tile: a tiny square about the middle of the cell, at w = 0.
static void make_speck(kn_ctx *ctx, kn_tile *out)
{
    static const double coef[12] = {0.499, 0.499, 0.501, 0.501, 0.499, 0.501, 0.499, 0.501, 0, 0, 0, 0};
    assert_int_equal(kn_tile_init(ctx, out, "speck", 1), KN_OK);
    scene_add_patch(ctx, out, 1, 1, coef);
}

// The middles of the specks: 3 numbers each.
static double *centres(kn_ctx *ctx, size_t *n, const kn_spline *base, const kn_job_options *o)
{
    kn_tile tile = {0};
    kn_job *job = NULL;
    scene_result r;
    make_speck(ctx, &tile);
    if (kn_job_create(ctx, &job, base, 1, &tile, o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    scene_run(ctx, job, &r);
    double *at = calloc(3 * r.count + 1, sizeof *at);
    assert_non_null(at);
    *n = 0;
    for (size_t i = 0; i < r.count; i++) { // a speck on a cell line is in pieces: the first one stands for it
        const kn_patch_id *a = &r.patches[i].id, *b = i > 0 ? &r.patches[i - 1].id : NULL;
        bool same = b && a->cell[0] == b->cell[0] && a->cell[1] == b->cell[1] && a->instance == b->instance;
        if (same) continue;
        assert_int_equal(kn_bezier_eval(ctx, at + 3 * (*n)++, &r.patches[i].bezier, (const double[]){0.5, 0.5}),
                         KN_OK);
    }
    scene_result_clear(&r);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    return at;
}

static double apart(const double *p, const double *q)
{
    return sqrt((p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) + (p[2] - q[2]) * (p[2] - q[2]));
}

static double nearest(const double *p, const double *at, size_t n, size_t but)
{
    double least = INFINITY;
    for (size_t i = 0; i < n; i++)
        if (i != but) least = fmin(least, apart(p, at + 3 * i));
    return least;
}

// No two are nearer than the distance, by brute force in space, also over the seams; no place is further from all
// than it by more than the least boxes that the search leaves open. The speck's middle is off its dart by less than
// its size where it is cut.
static void least_distance_and_coverage(void **state)
{
    (void)state;
    const struct {
        void (*make)(kn_ctx *, kn_spline *);
        double distance, speck;
    } cases[] = {
        {make_torus, 0.6, 0.02}, {make_wavy, 0.3, 0.02}, {make_sphere, 0.5, 0.02}, {make_cylinder, 0.4, 0.02}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 1);
        kn_spline base = {0};
        cases[k].make(ctx, &base);
        kn_job_options o = {.count = {8, 8},
                            .height = 0.1,
                            .normal_tol = 1e-2,
                            .max_degree = 40,
                            .placement = {.scatter = {.distance = cases[k].distance, .seed = 5}}};
        size_t n;
        double *at = centres(ctx, &n, &base, &o), worst = 0;
        assert_true(n > 20);
        for (size_t i = 0; i < n; i++)
            assert_true(nearest(at + 3 * i, at, n, i) >= cases[k].distance - cases[k].speck);
        test_rng rng = test_random(k);
        for (int i = 0; i < test_scale(2000); i++) {
            double lo[2], hi[2], uv[2], p[3];
            for (int d = 0; d < 2; d++) {
                kn_spline_domain(&base, d, &lo[d], &hi[d]);
                uv[d] = test_uniform(&rng, lo[d], hi[d]);
            }
            assert_int_equal(kn_spline_eval(ctx, p, &base, uv), KN_OK);
            worst = fmax(worst, nearest(p, at, n, n));
        }
        if (worst > 1.05 * cases[k].distance + cases[k].speck) fail_msg("case %zu: %zu, a hole of %g", k, n, worst);
        free(at);
        kn_spline_clear(ctx, &base);
        test_ctx_end(ctx, &memory);
    }
}

// The same for any number of threads, another for another seed, and a number that packing allows: disks of half the
// distance do not overlap, those of the distance cover.
static void chance_is_reproducible(void **state)
{
    (void)state;
    test_memory memory[3] = {TEST_MEMORY_INIT, TEST_MEMORY_INIT, TEST_MEMORY_INIT};
    double *at[3];
    size_t n[3];
    double distance = 0.5, area = 4 * acos(-1.0) * acos(-1.0) * 3; // of the torus
    for (int k = 0; k < 3; k++) {
        kn_ctx *ctx = test_ctx(&memory[k], k == 1 ? 4 : 1);
        kn_spline base = {0};
        make_torus(ctx, &base);
        kn_job_options o = {.count = {8, 8},
                            .height = 0.1,
                            .normal_tol = 1e-2,
                            .max_degree = 40,
                            .placement = {.scatter = {.distance = distance, .seed = k == 2 ? 2 : 1}}};
        at[k] = centres(ctx, &n[k], &base, &o);
        kn_spline_clear(ctx, &base);
        test_ctx_end(ctx, &memory[k]);
    }
    assert_int_equal(n[0], n[1]);
    assert_memory_equal(at[0], at[1], 3 * n[0] * sizeof *at[0]);
    assert_true(n[2] != n[0] || memcmp(at[0], at[2], 3 * n[0] * sizeof *at[0]) != 0);
    double most = area / (distance * distance * sqrt(0.75)), least = area / (distance * distance * 3 * sqrt(0.75));
    assert_true((double)n[0] < most && (double)n[0] > least); // hexagonal packing and covering
    for (int k = 0; k < 3; k++) free(at[k]);
}

static void too_many_are_refused(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline base = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    scene_bicubic(ctx, &base, 0.1);
    make_speck(ctx, &tile);
    kn_job_options o = {.count = {2, 2}, .placement = {.scatter = {.distance = 1e-4}}};
    assert_int_equal(kn_job_create(ctx, &job, &base, 1, &tile, &o), KN_ELIMIT);
    assert_null(job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &base);
    test_ctx_end(ctx, &memory);
}

static void specks(kn_ctx *safe, kn_spline *base, kn_tile *tile)
{
    scene_bicubic(safe, base, 0.1);
    make_speck(safe, tile);
}

static kn_status scatters(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_job_options o = {.count = {1, 1}, .normal_tol = 1e-2, .placement = {.scatter = {.distance = 3}}};
    return scene_try_job(ctx, specks, &o);
}

static void allocation(void **state)
{
    (void)state;
    test_allocation_failures(scatters, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(least_distance_and_coverage),
                                       cmocka_unit_test(chance_is_reproducible),
                                       cmocka_unit_test(too_many_are_refused), cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("job/scatter", tests, NULL, NULL);
}
