// SPDX-License-Identifier: Apache-2.0
// Surfaces and volumes from curves and surfaces: ruled, extruded, revolved, skinned.
#include <math.h>
#include <string.h>

#include <knurl/construct.h>

#include "tests/support/support.h"

static double gamma_of(double n)
{
    return n * 0x1p-53 / (1.0 - n * 0x1p-53);
}

// A random operand over [0,4]^nvars, of at most three variables.
static kn_spline operand(kn_ctx *ctx, test_rng *rng, int nvars, int dim, bool rational)
{
    int degree[3] = {0}, count[3] = {0};
    kn_spline s;
    for (int d = 0; d < nvars; d++) degree[d] = test_int(rng, 1, 3), count[d] = degree[d] + 1 + test_int(rng, 0, 3);
    test_random_spline(ctx, &s, rng, nvars, dim + rational, rational, degree, count, 9);
    for (int d = 0; d < nvars; d++) assert_int_equal(kn_spline_reparameterize(ctx, &s, &s, d, 0, 4), KN_OK);
    return s;
}

// Coefficients k of each group of n are those of part, bit for bit.
static void assert_layer(const kn_spline *s, size_t n, size_t k, const kn_spline *part)
{
    assert_int_equal(s->ncomp, part->ncomp);
    size_t m = kn_spline_count(part) * (size_t)part->ncomp;
    for (size_t i = 0; i < m; i++) assert_true(s->coef[i * n + k] == part->coef[i]);
    for (int d = 0; d < part->nvars; d++) {
        assert_int_equal(s->degree[d], part->degree[d]);
        assert_int_equal(s->count[d], part->count[d]);
        assert_memory_equal(s->knots[d], part->knots[d],
                            (size_t)(part->count[d] + part->degree[d] + 1) * sizeof(double));
    }
}

static void to_rational(kn_ctx *ctx, kn_spline *s) // with the weight 1
{
    kn_spline r;
    size_t n = kn_spline_count(s) * (size_t)s->ncomp, points = kn_spline_count(s);
    assert_int_equal(kn_spline_init(ctx, &r, s->nvars, s->ncomp + 1, true, s->degree, s->count,
                                    (const double *const *)s->knots, NULL),
                     KN_OK);
    memcpy(r.coef, s->coef, n * sizeof *s->coef);
    for (size_t i = 0; i < points; i++) r.coef[n + i] = 1.0;
    kn_spline_swap(s, &r);
    kn_spline_clear(ctx, &r);
}

// Both ends are the operands as kn_spline_make_compatible makes them, bit for bit.
static void ruled(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = test_scale(40); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3), dim = test_int(&rng, 1, 3);
        kn_spline list[2] = {operand(ctx, &rng, nvars, dim, round % 2),
                             operand(ctx, &rng, nvars, dim, round % 3 == 0)};
        kn_spline s = {0};
        assert_int_equal(kn_construct_ruled(ctx, &s, &list[0], &list[1]), KN_OK);
        assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
        for (int i = 0; i < 2; i++)
            if (list[1 - i].rational && !list[i].rational) to_rational(ctx, &list[i]);
        assert_int_equal(kn_spline_make_compatible(ctx, list, 2), KN_OK);
        assert_int_equal(s.nvars, nvars + 1);
        assert_layer(&s, 2, 0, &list[0]);
        assert_layer(&s, 2, 1, &list[1]);
        const double expected[] = {0, 0, 1, 1};
        assert_memory_equal(s.knots[nvars], expected, sizeof expected);
        assert_int_equal(kn_construct_ruled(ctx, &list[0], &list[0], &list[1]), KN_OK); // in place
        assert_memory_equal(list[0].coef, s.coef, kn_spline_count(&s) * (size_t)s.ncomp * sizeof *s.coef);
        kn_spline_clear(ctx, &list[0]);
        kn_spline_clear(ctx, &list[1]);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

static void extruded(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    const double vector[] = {3, -2, 5};
    for (int round = test_scale(20); round > 0; round--) {
        int nvars = test_int(&rng, 1, 3);
        kn_spline a = operand(ctx, &rng, nvars, 3, round % 2), s = {0};
        assert_int_equal(kn_construct_extruded(ctx, &s, &a, vector), KN_OK);
        assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
        assert_layer(&s, 2, 0, &a);
        size_t n = kn_spline_count(&a);
        for (size_t i = 0; i < 3 * n; i++)
            a.coef[i] += vector[i / n] * (a.rational ? a.coef[3 * n + i % n] : 1.0); // integers: exact
        assert_layer(&s, 2, 1, &a);
        kn_spline_clear(ctx, &a);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// ---- revolved ----

typedef struct cylindrical {
    double height, distance;
} cylindrical;

static cylindrical around(const double p[3], const double origin[3], const double axis[3])
{
    double q[3], square = 0.0, length = 0.0, along = 0.0;
    for (int c = 0; c < 3; c++) q[c] = p[c] - origin[c], along += q[c] * axis[c], length += axis[c] * axis[c];
    for (int c = 0; c < 3; c++) {
        double across = q[c] - along / length * axis[c];
        square += across * across;
    }
    return (cylindrical){along / sqrt(length), sqrt(square)};
}

// Height and distance from the axis stay those of the operand, and the turn is what the angle says. Sizes: |a| <= 9
// over weights >= 1, |origin| <= 16; roundings: those of the values (at most 19 a variable, 14 for the arc), twice for
// the division, and 30 in coefficients and in this test. The weights of arcs are at least 1/2 on pieces of a quarter.
static void revolved(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    const double quarter = 0x1.921fb54442d18p+0;
    for (int round = test_scale(30); round > 0; round--) {
        int nvars = test_int(&rng, 1, 2);
        double origin[3], axis[3], angle = round % 3 ? test_uniform(&rng, 0.1, 4 * quarter) : 4 * quarter;
        for (int c = 0; c < 3; c++) origin[c] = test_int(&rng, -9, 9), axis[c] = test_int(&rng, -3, 3);
        if (axis[0] == 0 && axis[1] == 0 && axis[2] == 0) axis[1] = 2;
        kn_spline a = operand(ctx, &rng, nvars, 3, round % 2), s = {0};
        assert_int_equal(kn_construct_revolved(ctx, &s, &a, origin, axis, angle), KN_OK);
        assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
        if (!a.rational) to_rational(ctx, &a);
        size_t n = (size_t)s.count[nvars];
        assert_layer(&s, n, 0, &a);
        if (round % 3 == 0) assert_layer(&s, n, n - 1, &a);
        double tolerance = gamma_of(2.0 * (2 * 19 + 14) + 1 + 60) * 2.0 * (2 * 9 + 2 * 16) * 2.0;
        for (int i = 0; i < 20; i++) {
            double at[3], p[3], q[3], end[3];
            for (int d = 0; d < nvars; d++) at[d] = test_uniform(&rng, 0, 4);
            at[nvars] = test_uniform(&rng, 0, 1);
            assert_int_equal(kn_spline_eval(ctx, p, &s, at), KN_OK);
            assert_int_equal(kn_spline_eval(ctx, q, &a, at), KN_OK);
            at[nvars] = 1.0;
            assert_int_equal(kn_spline_eval(ctx, end, &s, at), KN_OK);
            cylindrical of_p = around(p, origin, axis), of_q = around(q, origin, axis);
            assert_true(fabs(of_p.height - of_q.height) <= tolerance);
            assert_true(fabs(of_p.distance - of_q.distance) <= tolerance);
            double chord = 0.0;
            for (int c = 0; c < 3; c++) chord += (end[c] - q[c]) * (end[c] - q[c]);
            assert_true(fabs(sqrt(chord) - 2.0 * sin(angle / 2.0) * of_q.distance) <= tolerance);
        }
        kn_spline_clear(ctx, &a);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// Counterclockwise about z, exactly at quarters; points on the axis stay; a profile against the axis faces outwards.
static void revolved_by_quarters(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double origin[3] = {0, 0, 7}, axis[3] = {0, 0, 0.3}, top[3] = {0, 0, 5}, edge[3] = {2, 0, 1};
    kn_spline a = {0}, s = {0};
    assert_int_equal(kn_construct_line(ctx, &a, 3, top, edge), KN_OK);
    assert_int_equal(kn_construct_revolved(ctx, &s, &a, origin, axis, 4 * 0x1.921fb54442d18p+0), KN_OK);
    const double expected[5][2] = {{2, 0}, {0, 2}, {-2, 0}, {0, -2}, {2, 0}};
    for (int k = 0; k < 5; k++) {
        assert_true(s.coef[9 + 2 * k] == expected[k][0] && s.coef[18 + 9 + 2 * k] == expected[k][1]);
        assert_true(s.coef[2 * k] == 0.0 && s.coef[18 + 2 * k] == 0.0 && s.coef[36 + 2 * k] == 5.0);
    }
    for (int i = 0; i < 10; i++) {
        double at[2] = {0.5, (i + 0.5) / 10}, d[9], normal[3];
        assert_int_equal(kn_spline_derivatives(ctx, d, &s, at, 1), KN_OK);
        for (int c = 0; c < 3; c++)
            normal[c] = d[3 + (c + 1) % 3] * d[6 + (c + 2) % 3] - d[3 + (c + 2) % 3] * d[6 + (c + 1) % 3];
        assert_true(normal[0] * d[0] + normal[1] * d[1] > 0.0);
    }
    // A tilted axis through points that no double hits: within rounding they count as on it.
    const double tilted[3] = {1, 2, 3}, none[3] = {0, 0, 0};
    double on[3];
    for (int c = 0; c < 3; c++) on[c] = tilted[c] * (1.0 / 3.0);
    assert_int_equal(kn_construct_line(ctx, &a, 3, on, edge), KN_OK);
    assert_int_equal(kn_construct_revolved(ctx, &s, &a, none, tilted, 1.0), KN_OK);
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++) assert_true(s.coef[c * 6 + k] == s.coef[18 + k] * on[c]);
    kn_spline_clear(ctx, &a);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// ---- skinned ----

// out(.., site_i) = section i: interpolation leaves gamma(8 p + 4) of the coefficients' absolute sum in
// each homogeneous component; evaluation of both (19 roundings a variable) on top. Weights of sections are at least 1.
static void skinned(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(4);
    for (int round = test_scale(20); round > 0; round--) {
        int nvars = test_int(&rng, 1, 2), n = test_int(&rng, 2, 6), degree = test_int(&rng, 1, n - 1 > 3 ? 3 : n - 1);
        kn_spline section[6], s = {0};
        double sites[6], largest = 0.0;
        for (int i = 0; i < n; i++) {
            section[i] = operand(ctx, &rng, nvars, 3, false);
            sites[i] = i + (round % 2 ? test_uniform(&rng, -0.3, 0.3) : 0.0);
        }
        assert_int_equal(kn_construct_skinned(ctx, &s, n, section, degree, sites), KN_OK);
        assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
        assert_int_equal(s.degree[nvars], degree);
        for (size_t i = 0; i < kn_spline_count(&s) * 3; i++) largest = fmax(largest, fabs(s.coef[i]));
        double tolerance = gamma_of(8 * degree + 4 + 3 * 19 + 30) * largest;
        for (int i = 0; i < n; i++)
            for (int k = 0; k < 10; k++) {
                double at[3], p[3], q[3];
                for (int d = 0; d < nvars; d++) at[d] = test_uniform(&rng, 0, 4);
                at[nvars] = sites[i];
                assert_int_equal(kn_spline_eval(ctx, p, &s, at), KN_OK);
                assert_int_equal(kn_spline_eval(ctx, q, &section[i], at), KN_OK);
                assert_true(test_max_difference(p, q, 3) <= tolerance);
            }
        assert_int_equal(kn_spline_make_compatible(ctx, section, n), KN_OK);
        assert_layer(&s, (size_t)n, 0, &section[0]);
        assert_layer(&s, (size_t)n, (size_t)n - 1, &section[n - 1]);
        for (int i = 0; i < n; i++) kn_spline_clear(ctx, &section[i]);
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

// Circles of growing radius, one above the other: a cone, whose sections are the circles; chord lengths are equal.
static void skinned_circles(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline section[4] = {{0}}, s = {0};
    const double up[3] = {0, 0, 1};
    for (int i = 0; i < 4; i++)
        assert_int_equal(kn_construct_circle(ctx, &section[i], (double[]){0, 0, i}, up, 1 + i), KN_OK);
    assert_int_equal(kn_construct_skinned(ctx, &s, 4, section, 3, NULL), KN_OK);
    assert_int_equal(kn_spline_check(ctx, &s), KN_OK);
    const double knots[] = {0, 0, 0, 0, 1, 1, 1, 1};
    assert_memory_equal(s.knots[1], knots, sizeof knots);
    for (int i = 0; i <= 20; i++)
        for (int j = 0; j <= 20; j++) {
            double at[2] = {i / 20.0, j / 20.0}, p[3];
            assert_int_equal(kn_spline_eval(ctx, p, &s, at), KN_OK);
            // linear data, condition of cubic interpolation at thirds below 16
            assert_true(fabs(hypot(p[0], p[1]) - (1 + p[2])) <= 16 * gamma_of(150) * 4);
            assert_true(fabs(p[2] - 3 * at[1]) <= 16 * gamma_of(150) * 4);
        }
    for (int i = 0; i < 4; i++) kn_spline_clear(ctx, &section[i]);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    kn_spline a = operand(ctx, &rng, 1, 3, false), flat = operand(ctx, &rng, 1, 2, false), s = {0}, empty = {0};
    kn_spline surface = operand(ctx, &rng, 2, 3, false), other = {0};
    assert_int_equal(kn_spline_reparameterize(ctx, &other, &a, 0, 0, 5), KN_OK);
    const double vector[3] = {0, 0, 1}, none[3] = {0}, bad[3] = {0, NAN, 0};
    assert_int_equal(kn_construct_ruled(ctx, &s, &a, &flat), KN_EDOMAIN);
    assert_int_equal(kn_construct_ruled(ctx, &s, &a, &surface), KN_EDOMAIN);
    assert_int_equal(kn_construct_ruled(ctx, &s, &a, &other), KN_EDOMAIN);
    assert_int_equal(kn_construct_ruled(ctx, &s, &a, &empty), KN_EDOMAIN);
    assert_int_equal(kn_construct_ruled(ctx, &s, &empty, &a), KN_EDOMAIN);
    assert_int_equal(kn_construct_extruded(ctx, &s, &empty, vector), KN_EDOMAIN);
    assert_int_equal(kn_construct_extruded(ctx, &s, &a, bad), KN_EDOMAIN);
    assert_int_equal(kn_construct_revolved(ctx, &s, &flat, none, vector, 1), KN_EDOMAIN);
    assert_int_equal(kn_construct_revolved(ctx, &s, &empty, none, vector, 1), KN_EDOMAIN);
    assert_int_equal(kn_construct_revolved(ctx, &s, &a, bad, vector, 1), KN_EDOMAIN);
    assert_int_equal(kn_construct_revolved(ctx, &s, &a, none, bad, 1), KN_EDOMAIN);
    assert_int_equal(kn_construct_revolved(ctx, &s, &a, none, none, 1), KN_EUNDEFINED);
    assert_int_equal(kn_construct_revolved(ctx, &s, &a, none, vector, 7), KN_EDOMAIN);
    const kn_spline list[] = {a, a, a}, mixed[] = {a, other, a};
    const double equal[] = {0, 0, 1};
    assert_int_equal(kn_construct_skinned(ctx, &s, 1, list, 1, NULL), KN_EDOMAIN);
    assert_int_equal(kn_construct_skinned(ctx, &s, 3, list, 3, NULL), KN_EDOMAIN);
    assert_int_equal(kn_construct_skinned(ctx, &s, 3, list, 0, NULL), KN_EDOMAIN);
    assert_int_equal(kn_construct_skinned(ctx, &s, 3, list, 2, equal), KN_EDOMAIN);
    assert_int_equal(kn_construct_skinned(ctx, &s, 3, list, 2, NULL), KN_EUNDEFINED); // no distance
    assert_int_equal(kn_construct_skinned(ctx, &s, 3, mixed, 2, NULL), KN_EDOMAIN);
    // Weights 1, 100, 1 at 0, 0.1, 1: the parabola through them goes below zero.
    kn_spline heavy[3] = {{0}};
    for (int i = 0; i < 3; i++) {
        assert_int_equal(kn_spline_copy(ctx, &heavy[i], &a), KN_OK);
        to_rational(ctx, &heavy[i]);
    }
    size_t n = kn_spline_count(&a);
    for (size_t i = 0; i < 4 * n; i++) heavy[0].coef[i] *= 100.0;
    assert_int_equal(kn_construct_skinned(ctx, &s, 3, heavy, 2, (double[]){0, 0.9, 1}), KN_EUNDEFINED);
    assert_int_equal(s.nvars, 0);
    int degree[KN_MAX_VARS], count[KN_MAX_VARS];
    for (int d = 0; d < KN_MAX_VARS; d++) degree[d] = 1, count[d] = 2;
    kn_spline full;
    test_random_spline(ctx, &full, &rng, KN_MAX_VARS, 3, false, degree, count, 9);
    assert_int_equal(kn_construct_extruded(ctx, &s, &full, vector), KN_ELIMIT);
    kn_spline_clear(ctx, &full);
    for (int i = 0; i < 3; i++) kn_spline_clear(ctx, &heavy[i]);
    kn_spline_clear(ctx, &a);
    kn_spline_clear(ctx, &flat);
    kn_spline_clear(ctx, &surface);
    kn_spline_clear(ctx, &other);
    test_ctx_end(ctx, &memory);
}

static kn_status make(kn_ctx *ctx, kn_spline *s, const kn_spline *a, const kn_spline *b, int which)
{
    const double vector[3] = {1, 2, 3}, none[3] = {0};
    switch (which) {
    case 0: return kn_construct_ruled(ctx, s, a, b);
    case 1: return kn_construct_extruded(ctx, s, a, vector);
    case 2: return kn_construct_revolved(ctx, s, a, none, vector, 1);
    default: return kn_construct_skinned(ctx, s, 3, (kn_spline[]){*a, *b, *a}, 2, (double[]){0, 1, 2});
    }
}

static kn_status once(kn_ctx *ctx, void *user)
{
    kn_spline a = {0}, b = {0}, s = {0};
    const double knots[] = {0, 0, 1, 1}, finer[] = {0, 0, 0, 0.5, 1, 1, 1};
    const double coef[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
    kn_status status = kn_spline_init(ctx, &a, 1, 3, false, (int[]){1}, (int[]){2}, (const double *[]){knots}, coef);
    if (status == KN_OK)
        status = kn_spline_init(ctx, &b, 1, 4, true, (int[]){2}, (int[]){4}, (const double *[]){finer}, coef);
    if (status == KN_OK) {
        status = make(ctx, &s, &a, &b, *(int *)user);
        if (status != KN_OK) assert_true(s.nvars == 0 && !s.coef);
    }
    kn_spline_clear(ctx, &a);
    kn_spline_clear(ctx, &b);
    kn_spline_clear(ctx, &s);
    return status;
}

static void allocation_failures(void **state)
{
    (void)state;
    for (int which = 0; which < 4; which++) test_allocation_failures(once, &which);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(ruled),    cmocka_unit_test(extruded),
                                       cmocka_unit_test(revolved), cmocka_unit_test(revolved_by_quarters),
                                       cmocka_unit_test(skinned),  cmocka_unit_test(skinned_circles),
                                       cmocka_unit_test(failures), cmocka_unit_test(allocation_failures)};
    return cmocka_run_group_tests_name("construct/operands", tests, NULL, NULL);
}
