// SPDX-License-Identifier: Apache-2.0
// Sensitivities of composed control points against differences of whole jobs.
#include "tests/support/support.h"

#include "tests/support/scene.h"

#include <math.h>
#include <string.h>

// One patch of degrees (2,2), and two parameters: "swing" moves u and v as well as w, "lift" moves w alone.
static void make_tile(kn_ctx *ctx, kn_tile *out)
{
    static const double knots[] = {0, 0, 0, 1, 1, 1};
    const double *both[2] = {knots, knots};
    const int degree[2] = {2, 2}, count[2] = {3, 3};
    double coef[27];
    kn_spline s = {0};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            coef[3 * i + j] = 0.2 + 0.25 * i + 0.05 * j;
            coef[9 + 3 * i + j] = 0.25 + 0.2 * j;
            coef[18 + 3 * i + j] = 0.3 + 0.1 * i * j;
        }
    assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, degree, count, both, coef), KN_OK);
    assert_int_equal(kn_tile_init(ctx, out, "flap", 1), KN_OK);
    assert_int_equal(kn_tile_add(ctx, out, 0, &s), KN_OK);
    assert_int_equal(kn_tile_add_parameter(ctx, out, "swing", 0.5, 1, 0, 1), KN_OK);
    assert_int_equal(kn_tile_add_parameter(ctx, out, "lift", 0, 2, -2, 2), KN_OK);
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < 27; i++) s.coef[i] = coef[i] + (k == 0 ? 0.02 * (i % 5) : i >= 18 ? 0.1 * (i % 3) : 0);
        assert_int_equal(kn_tile_set_target(ctx, out, k, 0, 0, &s), KN_OK);
    }
    kn_spline_clear(ctx, &s);
}

typedef struct scene {
    kn_spline base, direction;
    kn_tile tile;
    kn_job_options options;
} scene;

// rational: on a torus; else on a bicubic spline of 3 x 2 spans.
static void scene_init(kn_ctx *ctx, scene *s, bool rational)
{
    static const double knots[] = {0, 0, 1, 1}, coef[12] = {0.1, 0.2, 0, 0.3, 0, 0.1, -0.2, 0.1, 1, 1.2, 0.9, 1};
    const double *both[2] = {knots, knots};
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    *s = (scene){.options = kn_job_defaults()};
    if (rational)
        scene_torus(ctx, &s->base);
    else
        scene_spline(ctx, &s->base);
    assert_int_equal(kn_spline_init(ctx, &s->direction, 2, 3, false, degree, count, both, coef), KN_OK);
    make_tile(ctx, &s->tile);
    s->options.count[0] = 3, s->options.count[1] = 2;
    s->options.height = 0.4, s->options.offset = 0.1;
    s->options.side = KN_JOB_BOTH;
    s->options.quarter_turns = 1;
    s->options.max_degree = 40;
    s->options.direction = &s->direction; // T is then exact in S: n does not move with it
}

static void scene_clear(kn_ctx *ctx, scene *s)
{
    kn_spline_clear(ctx, &s->base), kn_spline_clear(ctx, &s->direction);
    kn_tile_clear(ctx, &s->tile);
}

static void run(kn_ctx *ctx, scene_result *r, const scene *s, const kn_tile *tile)
{
    kn_job *job = NULL;
    assert_int_equal(kn_job_create(ctx, &job, &s->base, 1, tile, &s->options), KN_OK);
    scene_run(ctx, job, r);
    kn_job_destroy(ctx, job);
}

// T(D) is a polynomial of degree at most 3 + 3 + 1 in the parameter, and of degree 1 where w alone moves: the central
// difference over +-h .. +-4h that is exact up to degree 8 is the derivative, but for rounding: 8 values of up to 8,
// each within 40 roundings, over h.
static void by_parameters(void **state)
{
    (void)state;
    const double h = 0.05, weight[4] = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
    for (int rational = 0; rational < 2; rational++) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 1);
        scene s;
        scene_init(ctx, &s, rational != 0);
        kn_job *job = NULL;
        scene_result own;
        assert_int_equal(kn_job_create(ctx, &job, &s.base, 1, &s.tile, &s.options), KN_OK);
        scene_run(ctx, job, &own);
        for (int k = 0; k < 2; k++) {
            scene_result r[8];
            for (int i = 0; i < 8; i++) {
                double values[2] = {0.5, 0};
                values[k] += (i < 4 ? i + 1 : 3 - i) * h;
                kn_tile now = {0};
                assert_int_equal(kn_tile_vary(ctx, &now, &s.tile, values), KN_OK);
                run(ctx, &r[i], &s, &now);
                kn_tile_clear(ctx, &now);
            }
            double most = 0;
            assert_int_equal(r[0].count, 6);
            for (size_t p = 0; p < r[0].count; p++) {
                kn_bezier d = {0}, up[8] = {{0}}; // without parameters the tile may compose to lower degrees
                const kn_bezier *c = &own.patches[p].bezier;
                for (int i = 0; i < 8; i++)
                    assert_int_equal(kn_bezier_elevate(ctx, &up[i], &r[i].patches[p].bezier, c->degree), KN_OK);
                assert_int_equal(kn_job_parameter_sensitivity(ctx, &d, job, &r[0].patches[p].id, k), KN_OK);
                assert_true(d.ncomp == c->ncomp && !d.rational);
                for (int v = 0; v < 2; v++) assert_int_equal(d.degree[v], c->degree[v]);
                for (size_t i = 0; i < (size_t)c->ncomp * kn_bezier_count(c); i++) {
                    double slope = 0;
                    for (int j = 0; j < 4; j++) slope += weight[j] / h * (up[j].coef[i] - up[4 + j].coef[i]);
                    assert_true(fabs(slope - d.coef[i]) <= 8 * 8 * 40 * 0x1p-53 / h);
                    most = fmax(most, fabs(slope));
                }
                kn_bezier_clear(ctx, &d);
                for (int i = 0; i < 8; i++) kn_bezier_clear(ctx, &up[i]);
            }
            assert_true(most > 0.01);
            for (int i = 0; i < 8; i++) scene_result_clear(&r[i]);
        }
        scene_result_clear(&own);
        kn_job_destroy(ctx, job);
        scene_clear(ctx, &s);
        test_ctx_end(ctx, &memory);
    }
}

// T is linear in S: the difference of two jobs is the derivative, whatever the step. Without parameters, and without
// turns, the patches have lower degrees than the tile's times the largest sum, and sensitivities have these.
static void by_the_base(void **state)
{
    (void)state;
    for (int kind = 0; kind < 4; kind++) {
        bool rational = kind % 2 != 0, plain = kind / 2 != 0;
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 1);
        scene s;
        scene_result before, after;
        scene_init(ctx, &s, rational);
        if (plain) {
            kn_tile now = {0};
            assert_int_equal(kn_tile_vary(ctx, &now, &s.tile, (const double[2]){0.5, 0}), KN_OK);
            kn_tile_clear(ctx, &s.tile);
            s.tile = now;
            s.options.quarter_turns = 0;
        }
        kn_job *job = NULL;
        assert_int_equal(kn_job_create(ctx, &job, &s.base, 1, &s.tile, &s.options), KN_OK);
        run(ctx, &before, &s, &s.tile);
        size_t n = kn_spline_count(&s.base);
        for (int i = 0; i < s.base.count[0]; i += 2)
            for (int j = 0; j < s.base.count[1]; j += 2) {
                const int index[2] = {i, j};
                double touched = 0;
                double *y = &s.base.coef[n + (size_t)(i * s.base.count[1] + j)], kept = *y;
                *y += 0.5;
                run(ctx, &after, &s, &s.tile);
                *y = kept;
                for (size_t p = 0; p < before.count; p++) {
                    kn_bezier d = {0};
                    const kn_bezier *a = &before.patches[p].bezier, *b = &after.patches[p].bezier;
                    size_t m = kn_bezier_count(a);
                    assert_int_equal(kn_job_base_sensitivity(ctx, &d, job, &before.patches[p].id, 0, index), KN_OK);
                    assert_true(d.ncomp == 1);
                    for (int v = 0; v < 2; v++) assert_int_equal(d.degree[v], a->degree[v]);
                    if (plain) assert_true(kn_bezier_count(&d) < 15 * 15);
                    for (size_t k = 0; k < (size_t)a->ncomp * m; k++) {
                        double slope = k / m == 1 ? d.coef[k % m] : 0; // y alone moves
                        // each of two values of up to 8 within 40 roundings, over the step
                        assert_true(fabs((b->coef[k] - a->coef[k]) / 0.5 - slope) <= 2 * 8 * 40 * 0x1p-53 / 0.5);
                    }
                    for (size_t k = 0; k < m; k++) touched = fmax(touched, d.coef[k]);
                    kn_bezier_clear(ctx, &d);
                }
                assert_true(touched > 1e-4);
                scene_result_clear(&after);
            }
        scene_result_clear(&before);
        kn_job_destroy(ctx, job);
        scene_clear(ctx, &s);
        test_ctx_end(ctx, &memory);
    }
}

// A parameter that moves w alone, by degree 1 each way, as all of the tile is: its patches and what they change by
// have the degrees of S(u,v), or of its weight times d, with u of degree 1 along both variables and v along one. T is
// linear in w.
static void of_least_degrees(void **state)
{
    (void)state;
    for (int rational = 0; rational < 2; rational++) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 1);
        scene s;
        kn_tile tile = {0}, now = {0};
        scene_init(ctx, &s, rational != 0);
        const kn_spline *rest = &s.tile.parts[0].splines[0], *lift = &s.tile.parts[0].targets[1];
        assert_int_equal(kn_tile_init(ctx, &tile, "flap", 1), KN_OK);
        assert_int_equal(kn_tile_add(ctx, &tile, 0, rest), KN_OK);
        assert_int_equal(kn_tile_add_parameter(ctx, &tile, "lift", 0, 2, -2, 2), KN_OK);
        assert_int_equal(kn_tile_set_target(ctx, &tile, 0, 0, 0, lift), KN_OK);
        kn_job *job = NULL;
        scene_result a, b;
        const double lifted[1] = {0.25};
        assert_int_equal(kn_job_create(ctx, &job, &s.base, 1, &tile, &s.options), KN_OK);
        assert_int_equal(kn_tile_vary(ctx, &now, &tile, lifted), KN_OK);
        run(ctx, &a, &s, &tile);
        run(ctx, &b, &s, &now);
        for (size_t p = 0; p < a.count; p++) {
            kn_bezier d = {0};
            const kn_bezier *from = &a.patches[p].bezier, *to = &b.patches[p].bezier;
            assert_int_equal(kn_job_parameter_sensitivity(ctx, &d, job, &a.patches[p].id, 0), KN_OK);
            for (int v = 0; v < 2; v++) {
                assert_int_equal(from->degree[v], rational ? 4 + 3 * v : 3 + 3 * v);
                assert_true(d.degree[v] == from->degree[v] && d.degree[v] == to->degree[v]);
            }
            for (size_t i = 0; i < (size_t)d.ncomp * kn_bezier_count(&d); i++) // rounding as above
                assert_true(fabs((to->coef[i] - from->coef[i]) / 0.25 - d.coef[i]) <= 2 * 8 * 40 * 0x1p-53 / 0.25);
            kn_bezier_clear(ctx, &d);
        }
        scene_result_clear(&a), scene_result_clear(&b);
        kn_job_destroy(ctx, job);
        kn_tile_clear(ctx, &tile), kn_tile_clear(ctx, &now);
        scene_clear(ctx, &s);
        test_ctx_end(ctx, &memory);
    }
}

static double two(const void *user, const kn_place *p)
{
    (void)user;
    return 2 + p->point[0];
}

// Heights that a field multiplies multiply what a parameter does to them.
static void under_a_field(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    scene s;
    scene_init(ctx, &s, false);
    const kn_job_vary vary = {"height", {two, NULL, KN_NEEDS_POINT}};
    s.options.vary = &vary, s.options.nvary = 1;
    kn_job *job = NULL;
    assert_int_equal(kn_job_create(ctx, &job, &s.base, 1, &s.tile, &s.options), KN_OK);
    const double lifted[2] = {0.5, 0.25};
    kn_tile now = {0};
    scene_result a, b;
    assert_int_equal(kn_tile_vary(ctx, &now, &s.tile, lifted), KN_OK);
    run(ctx, &a, &s, &s.tile);
    run(ctx, &b, &s, &now);
    for (size_t p = 0; p < a.count; p++) {
        kn_bezier d = {0}, to = {0}; // without parameters it may have lower degrees
        const kn_bezier *from = &a.patches[p].bezier;
        assert_int_equal(kn_job_parameter_sensitivity(ctx, &d, job, &a.patches[p].id, 1), KN_OK);
        assert_int_equal(kn_bezier_elevate(ctx, &to, &b.patches[p].bezier, from->degree), KN_OK);
        for (size_t i = 0; i < 3 * kn_bezier_count(&d); i++) // linear in w; rounding as above
            assert_true(fabs((to.coef[i] - from->coef[i]) / 0.25 - d.coef[i]) <= 2 * 16 * 40 * 0x1p-53 / 0.25);
        kn_bezier_clear(ctx, &d);
        kn_bezier_clear(ctx, &to);
    }
    scene_result_clear(&a), scene_result_clear(&b);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &now);
    scene_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void refusals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    scene s;
    scene_init(ctx, &s, false);
    kn_job *job = NULL;
    assert_int_equal(kn_job_create(ctx, &job, &s.base, 1, &s.tile, &s.options), KN_OK);
    kn_patch_id id = {0};
    kn_bezier d = {.nvars = 77};
    const int index[2] = {0, 0}, outside[2] = {0, 99};
    for (int k = -1; k < 3; k += 3) assert_int_equal(kn_job_parameter_sensitivity(ctx, &d, job, &id, k), KN_EDOMAIN);
    assert_int_equal(kn_job_base_sensitivity(ctx, &d, job, &id, 1, index), KN_EDOMAIN);
    assert_int_equal(kn_job_base_sensitivity(ctx, &d, job, &id, 0, outside), KN_EDOMAIN);
    id.cell[0] = 3;
    assert_int_equal(kn_job_parameter_sensitivity(ctx, &d, job, &id, 0), KN_EDOMAIN);
    id.cell[0] = 0, id.piece = 5;
    assert_int_equal(kn_job_base_sensitivity(ctx, &d, job, &id, 0, index), KN_EDOMAIN);
    assert_int_equal(d.nvars, 77);
    kn_job_destroy(ctx, job);
    scene_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

typedef struct asked {
    const kn_job *job;
} asked;

static kn_status call(kn_ctx *ctx, void *user)
{
    const asked *a = user;
    kn_patch_id id = {0};
    kn_bezier d = {0};
    const int index[2] = {1, 1};
    kn_status status = kn_job_parameter_sensitivity(ctx, &d, a->job, &id, 0);
    assert_true((status == KN_OK) == (d.coef != NULL));
    if (status == KN_OK) status = kn_job_base_sensitivity(ctx, &d, a->job, &id, 0, index);
    kn_bezier_clear(ctx, &d);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    scene s;
    scene_init(ctx, &s, false);
    kn_job *job = NULL;
    assert_int_equal(kn_job_create(ctx, &job, &s.base, 1, &s.tile, &s.options), KN_OK);
    test_allocation_failures(call, &(asked){job});
    kn_job_destroy(ctx, job);
    scene_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(by_parameters),    cmocka_unit_test(by_the_base),
                                       cmocka_unit_test(of_least_degrees), cmocka_unit_test(under_a_field),
                                       cmocka_unit_test(refusals),         cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("job/sensitivity", tests, NULL, NULL);
}
