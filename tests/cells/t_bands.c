// SPDX-License-Identifier: Apache-2.0
// Bands of rows against the closed form of a cone.
#include "tests/support/support.h"

#include <knurl/cells.h>
#include <knurl/construct.h>
#include <math.h>

static const double origin[3] = {0}, axis[3] = {0, 0, 3};
static const double pi = 3.14159265358979323846;

// Slant length L, radii from base to top: every row is a circle of its middle's radius.
static void check_cone(kn_ctx *ctx, double base, double top, double size0, double size1, int least_bands)
{
    kn_spline s = {0};
    kn_cells_band *bands = NULL;
    int n = -1, rows = 0;
    double slant = sqrt(9 + (base - top) * (base - top)), size[2] = {size0, size1};
    assert_int_equal(kn_construct_cone(ctx, &s, origin, axis, base, top), KN_OK);
    assert_int_equal(kn_cells_bands(ctx, &bands, &n, &s, size), KN_OK);
    assert_true(n >= least_bands);
    assert_true(bands[0].lo == 0 && bands[n - 1].hi == 1);
    int total = (int)round(slant / size1);
    for (int k = 0; k < n; k++) {
        const kn_cells_band *b = &bands[k];
        if (k > 0) assert_true(b->lo == bands[k - 1].hi && b->count[0] != bands[k - 1].count[0]);
        rows += b->count[1];
        assert_true(fabs(b->hi - (double)rows / total) <= 1e-12);
        for (int r = 0; r < b->count[1]; r++) {
            double v = b->lo + (b->hi - b->lo) * (r + 0.5) / b->count[1];
            double cells = 2 * pi * (base + (top - base) * v) / size0;
            cells = fmax(cells, 4); // the quarters of the circle; within sqrt(3/2), 15 % and rounding
            assert_true(b->count[0] + 0.5 >= 0.85 * cells / sqrt(1.5) - 1e-9);
            assert_true(b->count[0] - 0.5 <= 1.15 * cells * sqrt(1.5) + 1e-9);
            if (b->count[0] > 16) assert_true(b->count[0] % 4 == 0);
        }
    }
    assert_int_equal(rows, total);
    kn_free(ctx, bands);
    kn_spline_clear(ctx, &s);
}

static void cones(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    check_cone(ctx, 2, 0.2, 0.1, 0.1, 5);
    check_cone(ctx, 0.2, 2, 0.3, 0.1, 3);
    check_cone(ctx, 2, 0, 0.25, 0.25, 4);
    check_cone(ctx, 1, 1.2, 0.1, 0.1, 1);
    test_ctx_end(ctx, &memory);
}

// A cylinder is one band; and two half cones, one upside down, have the borders of one.
static void side_by_side(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline cone = {0}, other = {0};
    kn_cells_band *one = NULL, *two = NULL;
    int n1, n2;
    static const double size[2] = {0.1, 0.1};
    assert_int_equal(kn_construct_cylinder(ctx, &cone, origin, axis, 1), KN_OK);
    assert_int_equal(kn_cells_bands(ctx, &one, &n1, &cone, size), KN_OK);
    assert_int_equal(n1, 1);
    assert_int_equal(one[0].count[0], 64); // 62.8, in quarters
    assert_int_equal(one[0].count[1], 30);
    kn_free(ctx, one);

    assert_int_equal(kn_construct_cone(ctx, &cone, origin, axis, 2, 0.5), KN_OK);
    assert_int_equal(kn_spline_reverse(ctx, &other, &cone, 1), KN_OK);
    const kn_cells_along along[2] = {{&cone, 1, false}, {&other, 1, true}};
    assert_int_equal(kn_cells_bands(ctx, &one, &n1, &cone, size), KN_OK);
    assert_int_equal(kn_cells_shared_bands(ctx, &two, &n2, along, 2, size), KN_OK);
    assert_int_equal(n1, n2);
    for (int k = 0; k < n1; k++) {
        const kn_cells_band *a = &one[k], *b = &two[k], *c = &two[n1 + n1 - 1 - k];
        assert_true(a->count[0] == b->count[0] && a->count[0] == c->count[0]);
        assert_true(a->count[1] == b->count[1] && a->count[1] == c->count[1]);
        assert_true(fabs(a->lo - b->lo) <= 1e-14 && fabs(a->lo - (1 - c->hi)) <= 1e-14);
    }
    kn_free(ctx, one), kn_free(ctx, two);
    kn_spline_clear(ctx, &cone), kn_spline_clear(ctx, &other);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0}, torus = {0}, empty = {0};
    kn_cells_band *bands = NULL;
    int n = -7;
    const double bad[][2] = {{0, 1}, {1, -1}, {INFINITY, 1}, {1, NAN}}, good[2] = {1, 1};
    const double low[2] = {1, 1e-9}, thin[2] = {1e-9, 1};
    assert_int_equal(kn_construct_cylinder(ctx, &s, origin, axis, 1), KN_OK);
    assert_int_equal(kn_construct_torus(ctx, &torus, origin, axis, 3, 1), KN_OK);
    for (int k = 0; k < 4; k++) {
        assert_int_equal(kn_cells_bands(ctx, &bands, &n, &s, bad[k]), KN_EDOMAIN);
        kn_ctx_clear_error(ctx);
    }
    assert_int_equal(kn_cells_bands(ctx, &bands, &n, &empty, good), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_cells_bands(ctx, &bands, &n, &s, low), KN_ELIMIT);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_cells_bands(ctx, &bands, &n, &s, thin), KN_ELIMIT);
    kn_ctx_clear_error(ctx);
    const kn_cells_along wrong[2] = {{&s, 1, false}, {&torus, 1, false}}, across = {&s, 0, false};
    assert_int_equal(kn_cells_shared_bands(ctx, &bands, &n, wrong, 2, good), KN_EDOMAIN); // other knots
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_cells_shared_bands(ctx, &bands, &n, &across, 1, good), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_cells_shared_bands(ctx, &bands, &n, wrong, 0, good), KN_EDOMAIN);
    assert_true(bands == NULL && n == -7);
    kn_spline_clear(ctx, &s), kn_spline_clear(ctx, &torus);
    test_ctx_end(ctx, &memory);
}

static kn_status make_bands(kn_ctx *ctx, void *user)
{
    (void)user;
    static const double knots[] = {0, 0, 1, 1}, coef[12] = {0, 2, 4, 2, 0, 2, 0, 2, 0, 0, 0, 0}, size[2] = {1, 1};
    const double *both[2] = {knots, knots};
    kn_spline s = {0};
    kn_cells_band *bands = NULL;
    int n = -7;
    kn_status status = kn_spline_init(ctx, &s, 2, 3, false, (const int[]){1, 1}, (const int[]){2, 2}, both, coef);
    if (status == KN_OK) status = kn_cells_bands(ctx, &bands, &n, &s, size);
    assert_true((status == KN_OK) == (bands != NULL) && (status == KN_OK) == (n != -7));
    kn_free(ctx, bands);
    kn_spline_clear(ctx, &s);
    return status;
}

static void allocation(void **state)
{
    (void)state;
    test_allocation_failures(make_bands, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(cones), cmocka_unit_test(side_by_side),
                                       cmocka_unit_test(failures), cmocka_unit_test(allocation)};
    return cmocka_run_group_tests_name("cells/bands", tests, NULL, NULL);
}
