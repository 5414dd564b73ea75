// SPDX-License-Identifier: Apache-2.0
// kn_cells_fit: its bound against samples and against a known difference, how smooth it is, edges, every failure.
#include "tests/cells/scene.h"
#include "tests/support/support.h"

#include <knurl/compose.h>
#include <knurl/construct.h>
#include <knurl/io.h>
#include <math.h>
#include <string.h>

static const double origin[3] = {0}, axis[3] = {0, 0, 2};

// A height field.
static void hills(double p[3], double u, double v)
{
    p[0] = u + 0.2 * u * (1 - u) * v, p[1] = v;
    p[2] = 0.2 * sin(5 * u) * cos(4 * v);
}

enum { CASES = 7 };
typedef struct fit_case {
    int n[2];
    bool closed[2], smooth;
    double tolerance;
} fit_case;

static void make(kn_ctx *ctx, kn_spline *s, fit_case *c, int which)
{
    static const fit_case all[CASES] = {
        {{12, 10}, {false, false}, false, 1e-3}, {{12, 10}, {false, false}, true, 2e-3},
        {{16, 8}, {true, false}, false, 1e-5},   {{16, 8}, {true, false}, true, 1e-4},
        {{20, 12}, {true, true}, true, 1e-3},    {{14, 9}, {false, false}, true, 1e-4},
        {{16, 8}, {true, false}, true, 1e-3},
    };
    *c = all[which];
    if (which < 2) scene_hills(ctx, s, hills);
    if (which == 2 || which == 3) assert_int_equal(kn_construct_cone(ctx, s, origin, axis, 1, 0.3), KN_OK);
    if (which == 4) assert_int_equal(kn_construct_torus(ctx, s, origin, axis, 3, 1), KN_OK);
    if (which == 5) { // a patch of the teapot's spout
        kn_model model = {0};
        assert_int_equal(kn_read_bpt(ctx, &model, "data/teapot.bpt"), KN_OK);
        kn_spline_swap(s, &model.splines[16]);
        kn_model_clear(ctx, &model);
    }
    if (which == 6) assert_int_equal(kn_construct_sphere(ctx, s, origin, 1), KN_OK);
}

static void make_map(kn_ctx *ctx, kn_spline *map, const kn_spline *s, const fit_case *c)
{
    const kn_cells_relax_options o = {.closed = {c->closed[0], c->closed[1]}, .smooth = c->smooth};
    assert_int_equal(kn_cells_relax(ctx, map, s, c->n, &o), KN_OK);
}

// The bound is never passed by samples, and is not far above them: coefficients exceed values by a quarter, and what
// is sampled is near the largest.
static void bounds(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(61);
    enum { SAMPLES = 10000 };
    static double at[2 * SAMPLES], uv[2 * SAMPLES], want[3 * SAMPLES], got[3 * SAMPLES];
    for (int which = 0; which < CASES; which++) {
        kn_spline s = {0}, map = {0}, out = {0};
        fit_case c;
        make(ctx, &s, &c, which);
        make_map(ctx, &map, &s, &c);
        double error = -1, worst = 0;
        assert_int_equal(kn_cells_fit(ctx, &out, &error, &s, &map, &(kn_cells_fit_options){.tolerance = c.tolerance}),
                         KN_OK);
        assert_true(error > 0 && error <= c.tolerance && !out.rational && out.ncomp == 3);
        for (int d = 0; d < 2; d++) {
            assert_true(out.degree[d] >= 3 && out.degree[d] <= 7);
            assert_int_equal(kn_spline_spans(&out, d), c.n[d]);
            for (int i = 0; i < out.count[d] + out.degree[d] + 1; i++) // the knots are lines of cells
                assert_true(out.knots[d][i] == floor(out.knots[d][i]));
        }
        for (int k = 0; k < SAMPLES; k++)
            for (int d = 0; d < 2; d++) at[2 * k + d] = test_uniform(&rng, 0, c.n[d]);
        assert_int_equal(kn_spline_eval_batch(ctx, uv, &map, SAMPLES, at), KN_OK);
        assert_int_equal(kn_spline_eval_batch(ctx, want, &s, SAMPLES, uv), KN_OK);
        assert_int_equal(kn_spline_eval_batch(ctx, got, &out, SAMPLES, at), KN_OK);
        for (int k = 0; k < 3 * SAMPLES; k += 3) {
            double x = want[k] - got[k], y = want[k + 1] - got[k + 1], z = want[k + 2] - got[k + 2];
            worst = fmax(worst, sqrt(x * x + y * y + z * z));
        }
        assert_true(worst <= error + 1e-14); // what evaluation itself may be off by
        assert_true(error <= 3 * worst);
        kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map), kn_spline_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

// x = u^4 over one cell that is all of the domain: the cubic through 0, 1/3, 2/3, 1 is off by the polynomial
// u (u - 1/3) (u - 2/3) (u - 1), whose largest value is 1/81, at the ends (3 +- sqrt 5)/6.
static void known_error(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double k1[] = {0, 0, 1, 1}, k4[] = {0, 0, 0, 0, 0, 1, 1, 1, 1, 1}, *ks[2] = {k4, k1}, *kb[2] = {k1, k1};
    const double coef[30] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1};
    const double unit[8] = {0, 0, 1, 1, 0, 1, 0, 1};
    kn_spline s = {0}, map = {0}, out = {0};
    double error, x, at[2] = {(3 - sqrt(5)) / 6, 0.25}, p[3];
    assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, (const int[]){4, 1}, (const int[]){5, 2}, ks, coef), KN_OK);
    assert_int_equal(kn_spline_init(ctx, &map, 2, 2, false, (const int[]){1, 1}, (const int[]){2, 2}, kb, unit),
                     KN_OK);
    assert_int_equal(kn_cells_fit(ctx, &out, &error, &s, &map, &(kn_cells_fit_options){.tolerance = 0.1}), KN_OK);
    assert_true(out.degree[0] == 3 && out.degree[1] == 3);
    assert_true(error >= 1 / 81.0 && error <= 1.3 / 81.0);
    assert_int_equal(kn_spline_eval(ctx, p, &out, at), KN_OK);
    x = pow(at[0], 4);
    assert_true(fabs(fabs(p[0] - x) - 1 / 81.0) <= 1e-15 && fabs(p[1] - 0.25) <= 1e-15 && fabs(p[2]) <= 1e-15);
    assert_int_equal(kn_cells_fit(ctx, &out, &error, &s, &map, &(kn_cells_fit_options){.tolerance = 1e-3}),
                     KN_OK); // one degree more: exact
    assert_true(out.degree[0] == 4 && out.degree[1] == 3 && error < 1e-12);
    assert_int_equal(kn_cells_fit(ctx, &map, NULL, &s, &map, &(kn_cells_fit_options){.tolerance = 1e-3}),
                     KN_OK); // in place, the error not wanted
    assert_memory_equal(map.coef, out.coef, 3 * kn_spline_count(&out) * sizeof *out.coef);
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map), kn_spline_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

// Of a smooth map the fit is C1 or better everywhere, the quarters of a circle and the seam among it; a seam is one
// edge, bit for bit.
static void continuity(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int which = 3; which <= 4; which++) {
        kn_spline s = {0}, map = {0}, out = {0};
        fit_case c;
        make(ctx, &s, &c, which);
        make_map(ctx, &map, &s, &c);
        assert_int_equal(kn_cells_fit(ctx, &out, NULL, &s, &map, &(kn_cells_fit_options){.tolerance = c.tolerance}),
                         KN_OK);
        for (int d = 0; d < 2; d++)
            for (int i = out.degree[d] + 1; i < out.count[d]; i++) // at most degree - 1 times
                assert_true(out.knots[d][i] < out.knots[d][i + out.degree[d] - 1]);
        for (int k = 0; k <= 20; k++) {
            double at[2] = {0, c.n[1] * k / 20.0}, a[9], b[9];
            assert_int_equal(kn_spline_derivatives(ctx, a, &out, at, 1), KN_OK);
            at[0] = c.n[0];
            assert_int_equal(kn_spline_derivatives(ctx, b, &out, at, 1), KN_OK);
            assert_true(test_max_difference(a, b, 3) == 0);
            assert_true(test_max_difference(a + 3, b + 3, 6) <= 1e-9);
        }
        kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map), kn_spline_clear(ctx, &out);
    }
    test_ctx_end(ctx, &memory);
}

// Two surfaces that share an edge, corners on it fixed: fits of the same degrees share it, bit for bit.
static void shared_edges(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline whole = {0}, part[2] = {{0}}, map[2] = {{0}}, out[2] = {{0}};
    scene_hills(ctx, &whole, hills);
    assert_int_equal(kn_spline_subdivide(ctx, &part[0], &part[1], &whole, 0, 0.5), KN_OK);
    const kn_cells_relax_options o = {.fixed = {{true, true}, {true, true}}};
    for (int k = 0; k < 2; k++) {
        const double half[1] = {k == 0 ? 0.0 : 0.5};
        assert_true(part[k].knots[0][0] == half[0]);
        assert_int_equal(kn_cells_relax(ctx, &map[k], &part[k], (const int[]){6, 8}, &o), KN_OK);
    }
    // even lines differ on both sides: take those of the first for the edge
    size_t n = kn_spline_count(&map[0]), edge = (size_t)map[0].count[1];
    memcpy(map[1].coef + n, map[0].coef + n + (n - edge), edge * sizeof(double));
    for (int k = 0; k < 2; k++)
        assert_int_equal(
            kn_cells_fit(ctx, &out[k], NULL, &part[k], &map[k], &(kn_cells_fit_options){.tolerance = 1e-2}), KN_OK);
    assert_true(out[0].degree[0] == 3 && out[1].degree[0] == 3);
    n = kn_spline_count(&out[0]), edge = (size_t)out[0].count[1];
    for (size_t c = 0; c < 3; c++)
        assert_memory_equal(out[1].coef + c * n, out[0].coef + c * n + (n - edge), edge * sizeof(double));
    for (int k = 0; k < 2; k++)
        kn_spline_clear(ctx, &part[k]), kn_spline_clear(ctx, &map[k]), kn_spline_clear(ctx, &out[k]);
    kn_spline_clear(ctx, &whole);
    test_ctx_end(ctx, &memory);
}

// A sum of degrees that is kept, and what is taken instead of the tolerance; a message that tells both distances.
static void limited(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0}, map = {0}, out = {0};
    double error = -1, before = INFINITY;
    fit_case c;
    make(ctx, &s, &c, 0);
    make_map(ctx, &map, &s, &c);
    for (int sum = 6; sum <= 14; sum += 2) {
        const kn_cells_fit_options o = {.tolerance = 1e-11, .at_most = 1, .degree_sum = sum};
        assert_int_equal(kn_cells_fit(ctx, &out, &error, &s, &map, &o), KN_OK);
        assert_true(out.degree[0] + out.degree[1] == sum && error > 1e-11 && error < before);
        before = error;
    }
    assert_int_equal(kn_cells_fit(ctx, &out, &error, &s, &map, &(kn_cells_fit_options){.tolerance = 1, .at_most = 9}),
                     KN_OK);
    assert_true(out.degree[0] + out.degree[1] == 6 && error <= 1); // the tolerance is met at once
    const kn_cells_fit_options bad[] = {{.tolerance = 1, .degree_sum = 5},
                                        {.tolerance = 1, .at_most = -1},
                                        {.tolerance = 1, .at_most = NAN},
                                        {.tolerance = 1, .degree_sum = -1}};
    for (int k = 0; k < 4; k++) {
        assert_int_equal(kn_cells_fit(ctx, &out, &error, &s, &map, &bad[k]), KN_EDOMAIN);
        kn_ctx_clear_error(ctx);
    }
    // between the largest sample and the bound: what is certain is not enough
    assert_int_equal(kn_cells_fit(ctx, &out, &error, &s, &map, &(kn_cells_fit_options){.tolerance = 0.99 * before}),
                     KN_EUNDECIDED);
    assert_non_null(strstr(kn_ctx_message(ctx), "certainly within"));
    kn_ctx_clear_error(ctx);
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map), kn_spline_clear(ctx, &out);
    test_ctx_end(ctx, &memory);
}

static int stop(void *user, const char *stage, double fraction)
{
    (void)user, (void)stage, (void)fraction;
    return 1;
}

static void refused(kn_ctx *ctx, kn_status want, const kn_spline *s, const kn_spline *map, double tolerance)
{
    kn_spline out = {0};
    double error = -1;
    assert_int_equal(kn_cells_fit(ctx, &out, &error, s, map, &(kn_cells_fit_options){.tolerance = tolerance}), want);
    assert_true(out.coef == NULL && error == -1 && kn_ctx_error(ctx) == want);
    kn_ctx_clear_error(ctx);
}

static void fails(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0}, map = {0}, jump = {0};
    fit_case c;
    make(ctx, &s, &c, 0);
    make_map(ctx, &map, &s, &c);
    refused(ctx, KN_EDOMAIN, &s, &map, 0);
    refused(ctx, KN_EDOMAIN, &s, &map, -1);
    refused(ctx, KN_EDOMAIN, &s, &map, NAN);
    refused(ctx, KN_EDOMAIN, &map, &map, 1e-3);
    refused(ctx, KN_EDOMAIN, &s, &s, 1e-3);
    refused(ctx, KN_EUNDECIDED, &s, &map, 1e-13);
    const double many[4] = {0.5, 0.5, 0.5, 0.5};
    assert_int_equal(kn_spline_insert_knots(ctx, &jump, &s, 1, many, 3), KN_OK); // quarters: 0.5 is there once
    refused(ctx, KN_EDOMAIN, &jump, &map, 1e-3);
    kn_ctx *impatient;
    assert_int_equal(kn_ctx_create(&impatient, &(kn_ctx_options){.progress = stop}), KN_OK);
    refused(impatient, KN_ECANCELLED, &s, &map, 1e-2);
    kn_ctx_destroy(impatient);
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map), kn_spline_clear(ctx, &jump);
    test_ctx_end(ctx, &memory);
}

static kn_status short_of_memory(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_spline s = {0}, map = {0}, out = {0};
    double error;
    const kn_cells_relax_options o = {.iterations = 1, .smooth = true, .closed = {true, false}};
    kn_status status = kn_construct_cone(ctx, &s, origin, axis, 1, 0.3);
    if (status == KN_OK) status = kn_cells_relax(ctx, &map, &s, (const int[]){5, 1}, &o);
    if (status == KN_OK)
        status = kn_cells_fit(ctx, &out, &error, &s, &map, &(kn_cells_fit_options){.tolerance = 1e-3});
    assert_true((status == KN_OK) == (out.coef != NULL));
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &map), kn_spline_clear(ctx, &out);
    return status;
}

static void memory_fails(void **state)
{
    (void)state;
    test_allocation_failures(short_of_memory, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds),       cmocka_unit_test(known_error), cmocka_unit_test(continuity),
        cmocka_unit_test(shared_edges), cmocka_unit_test(limited),     cmocka_unit_test(fails),
        cmocka_unit_test(memory_fails),
    };
    return cmocka_run_group_tests_name("cells/fit", tests, NULL, NULL);
}
