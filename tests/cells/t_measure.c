// SPDX-License-Identifier: Apache-2.0
// Sizes of cells against closed forms.
#include "tests/support/support.h"

#include <knurl/cells.h>
#include <math.h>
#include <string.h>

// The angle of a rational quadratic quarter circle with weights 1, sqrt(1/2), 1.
static double angle(double t)
{
    double s = 1 - t, m = sqrt(0.5);
    return atan2(2 * m * s * t + t * t, s * s + 2 * m * s * t);
}

// u around an axis at radius 3 + cos(v's angle), both quarter circles.
static void quarter_torus(kn_ctx *ctx, kn_spline *out)
{
    static const double knots[] = {0, 0, 0, 1, 1, 1};
    const double *both[2] = {knots, knots}, c[3] = {1, 1, 0}, s[3] = {0, 1, 1}, w[3] = {1, sqrt(0.5), 1};
    const int degree[2] = {2, 2}, count[2] = {3, 3};
    double coef[36];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double f = w[i] * w[j], radius = 3 + c[j];
            const double p[4] = {f * radius * c[i], f * radius * s[i], f * s[j], f};
            for (int k = 0; k < 4; k++) coef[9 * k + 3 * i + j] = p[k];
        }
    assert_int_equal(kn_spline_init(ctx, out, 2, 4, true, degree, count, both, coef), KN_OK);
}

typedef struct sizes {
    double min, sum, max;
} sizes;

static void add(sizes *s, double x)
{
    s->min = fmin(s->min, x);
    s->max = fmax(s->max, x);
    s->sum += x;
}

// Quadrature is no bound: 1e-10 is a hundred times what is seen, and an error of a rule would be far more.
static void near(const kn_cells_range *r, const sizes *s, double n)
{
    assert_true(fabs(r->min - s->min) <= 1e-10 && fabs(r->max - s->max) <= 1e-10);
    assert_true(fabs(r->mean - s->sum / n) <= 1e-10);
    size_t all = 0;
    for (int i = 0; i < KN_CELLS_BINS; i++) all += r->histogram[i];
    assert_true(all == (size_t)n);
    assert_true(r->histogram[(int)(r->min / r->mean * KN_CELLS_BINS / 3)] > 0);
}

static void a_torus(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline torus = {0};
    quarter_torus(ctx, &torus);
    static const double u[] = {0, 0.01, 0.3, 0.35, 0.5, 0.9, 1}, v[] = {0.25, 0.5, 0.55, 0.85};
    const double *lines[2] = {u, v};
    const int n[2] = {7, 4};
    sizes width = {INFINITY, 0, 0}, height = width, area = width;
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 3; j++) {
            double a = angle(u[i + 1]) - angle(u[i]), lo = angle(v[j]), hi = angle(v[j + 1]);
            add(&width, a * (3 + 0.5 * (cos(lo) + cos(hi))));
            add(&height, hi - lo);
            add(&area, a * (3 * (hi - lo) + sin(hi) - sin(lo)));
        }
    kn_cells_spread s;
    assert_int_equal(kn_cells_measure(ctx, &s, &torus, lines, n), KN_OK);
    assert_int_equal(s.cells, 18);
    near(&s.width, &width, 18), near(&s.height, &height, 18), near(&s.area, &area, 18);

    const double pi = acos(-1);
    assert_int_equal(kn_cells_measure(ctx, &s, &torus, NULL, NULL), KN_OK);
    assert_int_equal(s.cells, 1);
    assert_true(fabs(s.area.mean - pi / 2 * (3 * pi / 2 + 1)) <= 1e-9);
    kn_spline_clear(ctx, &torus);
    test_ctx_end(ctx, &memory);
}

// x = u^2, with a knot in the middle of a cell, beside a square of another size: together.
static void several_surfaces(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    static const double k2[] = {0, 0, 0, 1, 1, 1}, k1[] = {0, 0, 1, 1}, at[] = {0.5};
    const double *knots[2] = {k2, k1}, *flat[2] = {k1, k1};
    static const double x[18] = {0, 0, 0, 0, 1, 1, 0, 1, 0, 1, 0, 1}, square[12] = {0, 0, 2, 2, 0, 2, 0, 2};
    kn_spline s[2] = {{0}};
    assert_int_equal(kn_spline_init(ctx, &s[0], 2, 3, false, (const int[]){2, 1}, (const int[]){3, 2}, knots, x),
                     KN_OK);
    assert_int_equal(kn_spline_init(ctx, &s[1], 2, 3, false, (const int[]){1, 1}, (const int[]){2, 2}, flat, square),
                     KN_OK);
    assert_int_equal(kn_spline_insert_knots(ctx, &s[0], &s[0], 0, at, 1), KN_OK);
    static const double u[] = {0.25, 0.75};
    kn_cells_grid grids[2] = {{.surface = &s[0], .lines = {u, NULL}, .nlines = {2, 0}}, {.surface = &s[1]}};
    kn_cells_spread r;
    assert_int_equal(kn_cells_measure_all(ctx, &r, grids, 2), KN_OK);
    assert_int_equal(r.cells, 2);
    assert_true(fabs(r.width.min - 0.5) <= 1e-14 && fabs(r.width.max - 2) <= 1e-14);
    assert_true(fabs(r.height.min - 1) <= 1e-14 && fabs(r.height.max - 2) <= 1e-14);
    assert_true(fabs(r.area.mean - 2.25) <= 1e-14); // (1/2 + 4) / 2: bins of 1/24 of 3 means
    assert_true(r.area.histogram[1] == 1 && r.area.histogram[(int)(4 / 2.25 * 8)] == 1);
    kn_spline_clear(ctx, &s[0]), kn_spline_clear(ctx, &s[1]);
    test_ctx_end(ctx, &memory);
}

// Quarters of a circle of radius 3 + cos, by the rule; and polygons exactly.
static void spans(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    double length[4] = {-1, -1, -1, -1};
    static const double at[] = {0.5};
    quarter_torus(ctx, &s);
    assert_int_equal(kn_spline_insert_knots(ctx, &s, &s, 0, at, 1), KN_OK);
    assert_int_equal(kn_cells_span_lengths(ctx, length, &s, 0, 0.3), KN_OK);
    double radius = 3 + cos(angle(0.3));
    assert_true(fabs(length[0] - radius * angle(0.5)) <= 1e-12);
    assert_true(fabs(length[1] - radius * (acos(-1) / 2 - angle(0.5))) <= 1e-12);
    assert_int_equal(kn_cells_span_lengths(ctx, length, &s, 1, 0.7), KN_OK);
    assert_true(fabs(length[0] - acos(-1) / 2) <= 1e-12 && length[2] == -1);
    double before = length[0];
    assert_int_equal(kn_cells_span_lengths(ctx, length, &s, 2, 0), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_cells_span_lengths(ctx, length, &s, 0, NAN), KN_EDOMAIN);
    assert_true(length[0] == before);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0}, curve = {0};
    quarter_torus(ctx, &s);
    double lo, hi;
    kn_spline_domain(&s, 0, &lo, &hi);
    const double bad[][3] = {{lo, lo, hi}, {lo, hi, lo}, {lo, hi + 1, hi + 2}, {lo, NAN, hi}, {-INFINITY, lo, hi}};
    kn_cells_spread out, before;
    memset(&out, 7, sizeof out);
    before = out;
    for (int k = 0; k < 5; k++) {
        const double *lines[2] = {NULL, bad[k]};
        assert_int_equal(kn_cells_measure(ctx, &out, &s, lines, (const int[]){0, 3}), KN_EDOMAIN);
        kn_ctx_clear_error(ctx);
    }
    const double *one[2] = {&lo, NULL};
    assert_int_equal(kn_cells_measure(ctx, &out, &s, one, (const int[]){1, 0}), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_cells_measure_all(ctx, &out, NULL, 0), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_cells_measure(ctx, &out, &curve, NULL, NULL), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    size_t n = 3 * kn_spline_count(&s);
    for (size_t i = 0; i < n; i++) s.coef[i] *= 1e200; // |S_u x S_v| overflows
    assert_int_equal(kn_cells_measure(ctx, &out, &s, NULL, NULL), KN_EDOMAIN);
    assert_memory_equal(&out, &before, sizeof out);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static kn_status measure_torus(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_spline s = {0};
    kn_cells_spread out = {.cells = 77};
    kn_status status = KN_OK;
    const double knots[] = {0, 0, 1, 1}, *both[2] = {knots, knots};
    static const double square[12] = {0, 0, 2, 2, 0, 2, 0, 2};
    status = kn_spline_init(ctx, &s, 2, 3, false, (const int[]){1, 1}, (const int[]){2, 2}, both, square);
    if (status == KN_OK) {
        double length = -1;
        status = kn_cells_span_lengths(ctx, &length, &s, 0, 0.5);
        assert_true((status == KN_OK) == (length != -1));
        if (status == KN_OK) status = kn_cells_measure(ctx, &out, &s, NULL, NULL);
        assert_true((status == KN_OK) == (out.cells != 77));
    }
    kn_spline_clear(ctx, &s);
    return status;
}

static void allocation(void **state)
{
    (void)state;
    test_allocation_failures(measure_torus, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_torus), cmocka_unit_test(several_surfaces),
                                       cmocka_unit_test(spans), cmocka_unit_test(failures),
                                       cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("cells/measure", tests, NULL, NULL);
}
