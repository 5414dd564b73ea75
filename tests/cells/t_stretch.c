// SPDX-License-Identifier: Apache-2.0
// Factors of height against the stretch that is evaluated directly.
#include "tests/support/support.h"

#include <knurl/cells.h>
#include <knurl/construct.h>
#include <math.h>
#include <string.h>

// Sizes of cells as the header says them.
static double step(const double *x, int n, double at)
{
    int i = 0;
    while (i < n - 2 && at > x[i + 1]) i++;
    double own = x[i + 1] - x[i], before = i > 0 ? x[i] - x[i - 1] : own;
    double after = i < n - 2 ? x[i + 2] - x[i + 1] : own, t = (at - x[i]) / own;
    return (1 - t) * (before + own) / 2 + t * (own + after) / 2;
}

static double target(kn_ctx *ctx, const kn_spline *s, double *const lines[2], const int n[2], double mean,
                     const double at[2])
{
    double d[9];
    assert_int_equal(kn_spline_derivatives(ctx, d, s, at, 1), KN_OK);
    const double *a = d + 3, *b = d + 6;
    double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    double area = sqrt(x * x + y * y + z * z) * step(lines[0], n[0], at[0]) * step(lines[1], n[1], at[1]) / mean;
    return pow((area * area + 1 / 256.0) / (1 + 1 / 256.0), 0.25);
}

// The bound holds at random parameters, and is at most twice what is seen there (and 1e-3). That h is near t at all:
// `most`.
static void check(kn_ctx *ctx, const kn_spline *s, int nu, int nv, int degree, test_rng *rng, double most)
{
    double *lines[2], error = -1, worst = 0;
    const int n[2] = {nu + 1, nv + 1}, count[2] = {nu, nv};
    for (int d = 0; d < 2; d++) assert_int_equal(kn_cells_even_lines(ctx, &lines[d], s, d, count[d]), KN_OK);
    const double *const both[2] = {lines[0], lines[1]};
    kn_spline h = {0};
    kn_cells_spread spread;
    kn_cells_stretch_options o = {.degree = degree};
    assert_int_equal(kn_cells_measure(ctx, &spread, s, both, n), KN_OK);
    if (kn_cells_stretch(ctx, &h, &error, s, both, n, &o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    assert_true(h.degree[0] == degree && h.degree[1] == degree && h.ncomp == 1);
    assert_true(h.count[0] == nu + degree && h.count[1] == nv + degree);
    for (int i = 0; i < 4000; i++) {
        double at[2], value;
        for (int d = 0; d < 2; d++) at[d] = test_uniform(rng, lines[d][0], lines[d][n[d] - 1]);
        assert_int_equal(kn_spline_eval(ctx, &value, &h, at), KN_OK);
        assert_true(value > 0);
        double t = target(ctx, s, lines, n, spread.area.mean, at);
        worst = fmax(worst, fabs(value - t) / t);
    }
    assert_true(worst <= error);
    assert_true(error <= 2 * worst + 1e-3);
    assert_true(error <= most);
    kn_spline_clear(ctx, &h);
    for (int d = 0; d < 2; d++) kn_free(ctx, lines[d]);
}

static void bounds_hold(void **state)
{
    (void)state;
    test_rng rng = test_random(1);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static const double origin[3] = {1, 2, 3}, axis[3] = {0, 1, 2};
    static const double knots[] = {0, 0, 0, 0, 0.5, 1, 1, 1, 1};
    const double *both[2] = {knots, knots};
    double coef[75];
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < 5; j++) {
            coef[5 * i + j] = i + 0.2 * j * j, coef[25 + 5 * i + j] = j - 0.2 * i;
            coef[50 + 5 * i + j] = sin(i + 0.7 * j);
        }
    kn_spline s = {0};
    assert_int_equal(kn_construct_torus(ctx, &s, origin, axis, 3, 1), KN_OK);
    check(ctx, &s, 24, 12, 1, &rng, 0.02), check(ctx, &s, 24, 12, 2, &rng, 0.05);
    assert_int_equal(kn_construct_cone(ctx, &s, origin, axis, 2, 0.25), KN_OK);
    check(ctx, &s, 16, 9, 1, &rng, 0.02), check(ctx, &s, 16, 9, 3, &rng, 0.01);
    assert_int_equal(kn_construct_sphere(ctx, &s, origin, 2), KN_OK); // poles: the area vanishes
    check(ctx, &s, 16, 24, 2, &rng, 0.1);
    kn_spline_clear(ctx, &s);
    assert_int_equal(kn_spline_init(ctx, &s, 2, 3, false, (const int[]){3, 3}, (const int[]){5, 5}, both, coef),
                     KN_OK);
    check(ctx, &s, 10, 8, 1, &rng, 0.03), check(ctx, &s, 10, 8, 2, &rng, 0.03), check(ctx, &s, 9, 7, 3, &rng, 0.03);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void plane(kn_ctx *ctx, kn_spline *s)
{
    static const double knots[] = {0, 0, 1, 1}, coef[12] = {0, 0, 4, 4, 0, 2, 0, 2, 0, 0, 0, 0};
    const double *both[2] = {knots, knots};
    assert_int_equal(kn_spline_init(ctx, s, 2, 3, false, (const int[]){1, 1}, (const int[]){2, 2}, both, coef),
                     KN_OK);
}

// Equal cells: 1 everywhere, of degree 1, and with a given mean the root of the ratio, but for the floor.
static void a_plane(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0}, h = {0};
    double error = -1;
    static const double u[] = {0, 0.25, 0.5, 0.75, 1};
    const double *lines[2] = {u, u};
    const int n[2] = {5, 5};
    plane(ctx, &s);
    assert_int_equal(kn_cells_stretch(ctx, &h, &error, &s, lines, n, NULL), KN_OK);
    assert_true(h.degree[0] == 1 && error < 1e-11);
    for (size_t i = 0; i < kn_spline_count(&h); i++) assert_true(fabs(h.coef[i] - 1) <= 1e-14);
    const kn_cells_stretch_options o = {.mean = 0.125}; // cells are 1 x 1/2
    assert_int_equal(kn_cells_stretch(ctx, &h, &error, &s, lines, n, &o), KN_OK);
    for (size_t i = 0; i < kn_spline_count(&h); i++)
        assert_true(fabs(h.coef[i] - pow((16 + 1 / 256.0) / (1 + 1 / 256.0), 0.25)) <= 1e-14);
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &h);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0}, h = {0}, cylinder = {0};
    double error = -1;
    static const double u[] = {0, 0.5, 1}, axis[3] = {0, 0, 1};
    const double *lines[2] = {u, u};
    const int n[2] = {3, 3}, less[2] = {3, 2};
    plane(ctx, &s);
    const kn_cells_stretch_options bad[] = {{.mean = -1},   {.mean = INFINITY}, {.degree = 4},
                                            {.degree = -1}, {.tolerance = -1},  {.tolerance = NAN}};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        assert_int_equal(kn_cells_stretch(ctx, &h, &error, &s, lines, n, &bad[k]), KN_EDOMAIN);
        kn_ctx_clear_error(ctx);
    }
    assert_int_equal(kn_cells_stretch(ctx, &h, &error, &s, lines, less, NULL), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_construct_cylinder(ctx, &cylinder, (const double[3]){0}, axis, 1), KN_OK);
    assert_int_equal(kn_cells_stretch(ctx, &h, &error, &cylinder, lines, n, NULL),
                     KN_EDOMAIN); // knots that are no lines
    kn_ctx_clear_error(ctx);
    kn_spline flat = {0}, steep = {0};
    assert_int_equal(kn_spline_copy(ctx, &flat, &s), KN_OK);
    memset(flat.coef, 0, 12 * sizeof *flat.coef);
    assert_int_equal(kn_cells_stretch(ctx, &h, &error, &flat, lines, n, NULL), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_spline_elevate(ctx, &steep, &s, (const int[]){14, 1}), KN_OK);
    assert_int_equal(kn_cells_stretch(ctx, &h, &error, &steep, lines, n, NULL), KN_ELIMIT);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_spline_elevate(ctx, &steep, &s, (const int[]){3, 3}), KN_OK);
    for (int i = 0; i < 16; i++) steep.coef[i] += 3 * (i % 3); // bent within a cell
    const kn_cells_stretch_options tight = {.tolerance = 1e-9};
    assert_int_equal(kn_cells_stretch(ctx, &h, &error, &steep, lines, n, &tight), KN_EUNDECIDED);
    assert_true(h.coef == NULL && error == -1);
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &flat), kn_spline_clear(ctx, &steep);
    kn_spline_clear(ctx, &cylinder);
    test_ctx_end(ctx, &memory);
}

static kn_status stretch_plane(kn_ctx *ctx, void *user)
{
    (void)user;
    static const double knots[] = {0, 0, 1, 1}, coef[12] = {0, 0, 4, 4, 0, 2, 0, 2, 0, 0, 0, 0}, u[] = {0, 1};
    const double *both[2] = {knots, knots}, *lines[2] = {u, u};
    kn_spline s = {0}, h = {0};
    double error = -1;
    kn_status status = kn_spline_init(ctx, &s, 2, 3, false, (const int[]){1, 1}, (const int[]){2, 2}, both, coef);
    if (status == KN_OK) status = kn_cells_stretch(ctx, &h, &error, &s, lines, (const int[]){2, 2}, NULL);
    assert_true((status == KN_OK) == (h.coef != NULL) && (status == KN_OK) == (error != -1));
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &h);
    return status;
}

static void allocation(void **state)
{
    (void)state;
    test_allocation_failures(stretch_plane, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(bounds_hold), cmocka_unit_test(a_plane),
                                       cmocka_unit_test(failures), cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("cells/stretch", tests, NULL, NULL);
}
