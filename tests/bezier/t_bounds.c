// SPDX-License-Identifier: Apache-2.0
// Boxes, oriented boxes and Lipschitz bounds of pieces: what they contain, how tight they are, failures, memory.
// tests/oracle/t_bounds.c holds them against exact arithmetic.
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kernel/knots.h"
#include "tests/bezier/reference.h"

static kn_bezier curve(kn_ctx *ctx, int degree, int ncomp, bool rational, const double *coef)
{
    kn_bezier b;
    assert_int_equal(kn_bezier_init(ctx, &b, 1, ncomp, rational, &degree), KN_OK);
    memcpy(b.coef, coef, (size_t)(ncomp * (degree + 1)) * sizeof *coef);
    return b;
}

static void whole_boxes(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double lo[2], hi[2];
    const double zero = 0.0, one = 1.0;
    kn_bezier a = curve(ctx, 2, 2, false, (double[]){1, -3, 2, 0.1, 0.1, 0.1});
    assert_int_equal(kn_bezier_box(ctx, lo, hi, &a, NULL, NULL), KN_OK);
    assert_true(lo[0] == -3 && hi[0] == 2 && lo[1] == 0.1 && hi[1] == 0.1); // exact
    assert_int_equal(kn_bezier_box(ctx, lo, hi, &a, &zero, &one), KN_OK);
    assert_true(lo[0] == -3 && hi[0] == 2 && lo[1] == 0.1 && hi[1] == 0.1);
    a.coef[1] = NAN;
    assert_int_equal(kn_bezier_box(ctx, lo, hi, &a, NULL, NULL), KN_OK);
    assert_true(lo[0] == -INFINITY && hi[0] == INFINITY && lo[1] == 0.1);
    kn_bezier_clear(ctx, &a);
    a = curve(ctx, 2, 2, true, (double[]){1, -6, 10, 3, 2, 4}); // 1/3, -3, 2.5: exact quotients stay, 1/3 does not
    assert_int_equal(kn_bezier_box(ctx, lo, hi, &a, NULL, NULL), KN_OK);
    assert_true(lo[0] == -3 && hi[0] == 2.5);
    a.coef[1] = 2.0 / 3.0 + 1.0, a.coef[2] = 4; // 1/3 is the least: the doubles around it
    assert_int_equal(kn_bezier_box(ctx, lo, hi, &a, NULL, NULL), KN_OK);
    assert_true(3.0L * lo[0] <= 1.0L && 3.0L * nextafter(lo[0], 1.0) > 1.0L && hi[0] == 1);
    kn_bezier_clear(ctx, &a);
    test_ctx_end(ctx, &memory);
}

// Over a part, beyond the unit interval, at a point, and where only a part has positive weights. The restriction's
// bound: 2 (5 n + 4) u of the sizes, which are at most 9 here.
static void boxes_over_parts(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const struct {
        double from, to, least, most;
    } cases[] = {{0.25, 0.5, 0.25, 0.5}, {-2, 3, -2, 3}, {0.75, 0.75, 0.75, 0.75}};
    kn_bezier a = curve(ctx, 1, 1, false, (double[]){0, 1});
    double lo, hi, slack = 2 * 9 * 9 * DBL_EPSILON;
    for (int i = 0; i < 3; i++) {
        assert_int_equal(kn_bezier_box(ctx, &lo, &hi, &a, &cases[i].from, &cases[i].to), KN_OK);
        assert_true(lo <= cases[i].least && lo >= cases[i].least - slack);
        assert_true(hi >= cases[i].most && hi <= cases[i].most + slack);
    }
    kn_bezier_clear(ctx, &a);
    a = curve(ctx, 1, 2, true, (double[]){1, 1, 1, -0.5}); // 1/(1 - 1.5 t): 1 .. 4 on [0,1/2]
    double zero = 0.0, half = 0.5;
    assert_int_equal(kn_bezier_box(ctx, &lo, &hi, &a, &zero, &half), KN_OK);
    assert_true(lo <= 1 && lo > 1 - slack && hi >= 4 && hi < 4 + 16 * slack);
    lo = hi = 17.0;
    assert_int_equal(kn_bezier_box(ctx, &lo, &hi, &a, NULL, NULL), KN_EDOMAIN);
    assert_true(lo == 17.0 && hi == 17.0);
    kn_bezier_clear(ctx, &a);
    a = curve(ctx, 3, 1, false, (double[]){0, 0, 0, 1e300}); // t^3: what underflows is not lost
    double tiny = 0x1p-360;
    assert_int_equal(kn_bezier_box(ctx, &lo, &hi, &a, &zero, &tiny), KN_OK);
    assert_true(lo <= 0 && (long double)hi >= 1e300L * 0x1p-1080L);
    kn_bezier_clear(ctx, &a);
    test_ctx_end(ctx, &memory);
}

static double determinant(double a[3][3])
{
    return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) - a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
           a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
}

// Every control point is center + sum s_i axis[i] with |s_i| <= half[i], solved in long double. Its roundings are
// 2^-11 of those that half must cover.
static void assert_holds(const kn_oriented_box *box, const kn_bezier *b)
{
    int dim = kn_bezier_dim(b);
    size_t n = kn_bezier_count(b);
    double gram[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            gram[i][j] = 0.0;
            for (int k = 0; k < 3; k++) gram[i][j] += box->axis[i][k] * box->axis[j][k];
            assert_true(fabs(gram[i][j] - (i == j)) < 1e-14);
        }
    assert_true(fabs(determinant(gram) - 1.0) < 1e-13);
    for (size_t k = 0; k < n; k++) {
        long double x[3] = {0}, y[3], s[3];
        for (int c = 0; c < dim; c++) {
            x[c] = b->coef[(size_t)c * n + k];
            if (b->rational) x[c] /= b->coef[(size_t)dim * n + k];
            x[c] -= box->center[c];
        }
        for (int i = 0; i < 3; i++)
            y[i] = s[i] = box->axis[i][0] * x[0] + box->axis[i][1] * x[1] + box->axis[i][2] * x[2];
        for (int step = 0; step < 3; step++) { // (A^T A) s = y by iteration: the matrix is 1 but for 1e-15
            long double r[3];
            for (int i = 0; i < 3; i++) {
                r[i] = y[i];
                for (int j = 0; j < 3; j++) {
                    long double g = 0.0L;
                    for (int c = 0; c < 3; c++) g += (long double)box->axis[i][c] * box->axis[j][c];
                    r[i] -= g * s[j];
                }
            }
            for (int i = 0; i < 3; i++) s[i] += r[i];
        }
        for (int i = 0; i < 3; i++) assert_true(fabsl(s[i]) <= box->half[i]);
    }
}

static double surface(const double *h)
{
    return h[0] * h[1] + h[1] * h[2] + h[2] * h[0];
}

// A random patch, thin along a random direction, which is not near a coordinate axis: bumps of 2% of its side. Turned
// by the frame it has a surface of about 1 in the right axes; the box along the coordinates has several times that.
static void slanted_patches(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    int smaller = 0, rounds = test_scale(60);
    for (int round = 0; round < rounds; round++) {
        bool rational = round % 2;
        double u[3] = {1, -1, 0}, v[3] = {1, 1, -2}, n[3] = {1, 1, 1}, at[3], lo[3], hi[3], sides[3];
        for (int i = 0; i < 3; i++) at[i] = test_uniform(&rng, -5, 5) * (round % 3 ? 1.0 : 1e6);
        kn_bezier b;
        kn_oriented_box box;
        assert_int_equal(kn_bezier_init(ctx, &b, 2, 3 + rational, rational, (int[]){3, 2}), KN_OK);
        for (size_t k = 0; k < 12; k++) {
            double x = (double)(k / 3) / 3, y = (double)(k % 3) / 2, z = test_uniform(&rng, 0, 0.02);
            double w = rational ? test_uniform(&rng, 0.5, 2) : 1.0;
            for (size_t c = 0; c < 3; c++)
                b.coef[c * 12 + k] = w * (at[c] + x * u[c] / sqrt(2) + y * v[c] / sqrt(6) + z * n[c] / sqrt(3));
            if (rational) b.coef[36 + k] = w;
        }
        assert_int_equal(kn_bezier_oriented_box(ctx, &box, &b), KN_OK);
        assert_holds(&box, &b);
        assert_int_equal(kn_bezier_box(ctx, lo, hi, &b, NULL, NULL), KN_OK);
        for (int i = 0; i < 3; i++) sides[i] = 0.5 * (hi[i] - lo[i]);
        assert_true(surface(box.half) <= 0.25 * 1.1 * 1.1); // sides 1, 1, 0.02, and 10% for the choice of axes
        smaller += box.half[0] * box.half[1] * box.half[2] <= 0.1 * sides[0] * sides[1] * sides[2];
        kn_bezier_clear(ctx, &b);
    }
    assert_int_equal(smaller, rounds);
    test_ctx_end(ctx, &memory);
}

// Nets of any size and shape, in the plane and in space: lines, points, random ones.
static void any_net(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    for (int round = test_scale(300); round > 0; round--) {
        int dim = test_int(&rng, 2, 3), nvars = test_int(&rng, 0, 3), degree[3];
        bool rational = test_int(&rng, 0, 1);
        double scale = pow(10.0, test_int(&rng, -200, 200)), far = test_int(&rng, 0, 1) ? 1e8 : 0.0;
        int rank = test_int(&rng, 0, 3); // how many directions the points spread in
        for (int d = 0; d < nvars; d++) degree[d] = test_int(&rng, 0, 3);
        kn_bezier b, c = {0};
        kn_oriented_box box;
        test_random_bezier(ctx, &b, &rng, nvars, dim + rational, rational, degree, 5);
        size_t n = kn_bezier_count(&b);
        double spread[3][3];
        for (int i = 0; i < 9; i++) spread[i / 3][i % 3] = i / 3 < rank ? test_uniform(&rng, -1, 1) : 0.0;
        for (size_t k = 0; k < n; k++) {
            double s[3] = {test_uniform(&rng, -1, 1), test_uniform(&rng, -1, 1), test_uniform(&rng, -1, 1)};
            for (size_t i = 0; i < (size_t)dim; i++) {
                double x = far + s[0] * spread[0][i] + s[1] * spread[1][i] + s[2] * spread[2][i];
                b.coef[i * n + k] = scale * x * (rational ? b.coef[(size_t)dim * n + k] : 1.0);
            }
        }
        assert_int_equal(kn_bezier_oriented_box(ctx, &box, &b), KN_OK);
        assert_holds(&box, &b);
        if (dim == 2) assert_true(box.half[2] == 0.0 && box.center[2] == 0.0 && box.axis[2][2] == 1.0);
        // never worse than the box along the coordinates but for rounding: 32 u and 12 u of the points' sizes
        double lo[3] = {0}, hi[3] = {0}, sides[3], size = 0.0;
        assert_int_equal(kn_bezier_box(ctx, lo, hi, &b, NULL, NULL), KN_OK);
        for (int i = 0; i < 3; i++) size = fmax(size, fmax(fabs(lo[i]), fabs(hi[i])));
        for (int i = 0; i < 3; i++) sides[i] = 0.5 * (hi[i] - lo[i]) / scale + 64 * DBL_EPSILON * size / scale;
        for (int i = 0; i < 3; i++) box.half[i] /= scale;
        assert_true(surface(box.half) <= surface(sides));
        kn_bezier_clear(ctx, &b);
        kn_bezier_clear(ctx, &c);
    }
    kn_bezier a = curve(ctx, 1, 2, false, (double[]){0, 1, INFINITY, 2});
    kn_oriented_box box;
    assert_int_equal(kn_bezier_oriented_box(ctx, &box, &a), KN_OK);
    assert_true(box.half[0] == INFINITY && box.half[1] == INFINITY);
    kn_bezier_clear(ctx, &a);
    test_ctx_end(ctx, &memory);
}

// The largest |derivative| at samples of a grid.
static double steepest(kn_ctx *ctx, const kn_bezier *b, int var)
{
    double most = 0.0, at[2] = {0};
    for (int i = 0; i <= 32; i++)
        for (int j = 0; j <= (b->nvars > 1 ? 32 : 0); j++) {
            double d[4 * 3], sum = 0.0;
            at[0] = i / 32.0, at[1] = j / 32.0;
            assert_int_equal(kn_bezier_derivatives(ctx, d, b, at, 1), KN_OK);
            for (int c = 0; c < kn_bezier_dim(b); c++) {
                double x = d[(1 + var) * kn_bezier_dim(b) + c];
                sum += x * x;
            }
            most = fmax(most, sqrt(sum));
        }
    return most;
}

// Derivatives of cubics are means of at most 3 vectors in each variable, weights differ by a factor of 2: the bound is
// seldom far from the steepest place. Half the cases lie within a factor of 2 (a random net's are near 1.2 and 1.6).
static void lipschitz_bounds(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(3);
    enum { CASES = 41 };
    for (int rational = 0; rational < 2; rational++) {
        double ratio[CASES];
        for (int i = 0; i < CASES; i++) {
            int nvars = 1 + i % 2, var = test_int(&rng, 0, nvars - 1);
            double bound[2], moved[2];
            kn_bezier b;
            assert_int_equal(kn_bezier_init(ctx, &b, nvars, 2 + rational, rational, (int[]){3, 2}), KN_OK);
            size_t n = kn_bezier_count(&b);
            for (size_t k = 0; k < 3 * n; k++)
                if (k < (size_t)b.ncomp * n)
                    b.coef[k] = k < 2 * n ? test_uniform(&rng, -1, 1) : test_uniform(&rng, 1, 2);
            assert_int_equal(kn_bezier_lipschitz(ctx, bound, &b), KN_OK);
            double most = steepest(ctx, &b, var);
            assert_true(bound[var] >= most * (1.0 - 1e-12)); // the samples are rounded
            ratio[i] = bound[var] / most;
            const double turn[4] = {1, 0, 0, 1}, far[2] = {1e3, -1e3};
            assert_int_equal(kn_bezier_affine(ctx, &b, &b, 2, turn, far), KN_OK);
            assert_int_equal(kn_bezier_lipschitz(ctx, moved, &b), KN_OK);
            assert_true(fabs(moved[var] - bound[var]) <= 1e-9 * bound[var]); // 1e3 times some hundred u
            kn_bezier_clear(ctx, &b);
        }
        qsort(ratio, CASES, sizeof *ratio, kn_knots_by_value);
        assert_true(ratio[CASES / 2] <= 2.0);
    }
    test_ctx_end(ctx, &memory);
}

// Exact ones: a straight line, a constant; numbers that overflow; huge and tiny weights.
static void lipschitz_corners(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double bound;
    kn_bezier a = curve(ctx, 2, 2, false, (double[]){0, 3, 6, 1, 5, 9});
    assert_int_equal(kn_bezier_lipschitz(ctx, &bound, &a), KN_OK);
    assert_true(bound >= 10 && bound <= 10 * (1 + 64 * DBL_EPSILON)); // |2 (3, 4)|
    kn_bezier_clear(ctx, &a);
    a = curve(ctx, 0, 1, false, (double[]){7});
    assert_int_equal(kn_bezier_lipschitz(ctx, &bound, &a), KN_OK);
    assert_true(bound == 0.0);
    kn_bezier_clear(ctx, &a);
    a = curve(ctx, 1, 1, false, (double[]){-DBL_MAX, DBL_MAX});
    assert_int_equal(kn_bezier_lipschitz(ctx, &bound, &a), KN_OK);
    assert_true(bound == INFINITY);
    kn_bezier_clear(ctx, &a);
    for (int e = -900; e <= 900; e += 300) { // t, over any constant weight
        a = curve(ctx, 1, 2, true, (double[]){0, ldexp(1.0, e), ldexp(1.0, e), ldexp(1.0, e)});
        assert_int_equal(kn_bezier_lipschitz(ctx, &bound, &a), KN_OK);
        assert_true(bound >= 1 && bound <= 1 + 1e-13);
        kn_bezier_clear(ctx, &a);
    }
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    double lo[4] = {17.0}, hi[4] = {17.0};
    const double zero = 0.0, one = 1.0, nan = NAN, infinite = INFINITY;
    kn_oriented_box box = {.half = {17.0}};
    kn_bezier a = curve(ctx, 1, 4, false, (double[]){0, 1, 2, 3, 4, 5, 6, 7}), empty = {0};
    kn_bezier flat = curve(ctx, 1, 3, true, (double[]){0, 1, 0, 1, 1, 0}), high;
    assert_int_equal(kn_bezier_init(ctx, &high, 1, 2, true, (int[]){29}), KN_OK);
    for (int i = 0; i < 60; i++) high.coef[i] = 1.0;
    assert_int_equal(kn_bezier_box(ctx, lo, hi, &empty, NULL, NULL), KN_EDOMAIN);
    assert_int_equal(kn_bezier_box(ctx, lo, hi, &a, &zero, NULL), KN_EDOMAIN);
    assert_int_equal(kn_bezier_box(ctx, lo, hi, &a, &one, &zero), KN_EDOMAIN);
    assert_int_equal(kn_bezier_box(ctx, lo, hi, &a, &nan, &one), KN_EDOMAIN);
    assert_int_equal(kn_bezier_box(ctx, lo, hi, &a, &zero, &infinite), KN_EDOMAIN);
    assert_int_equal(kn_bezier_box(ctx, lo, hi, &flat, NULL, NULL), KN_EDOMAIN); // a weight 0
    assert_int_equal(kn_bezier_oriented_box(ctx, &box, &empty), KN_EDOMAIN);
    assert_int_equal(kn_bezier_oriented_box(ctx, &box, &a), KN_EDOMAIN); // dimension 4
    assert_int_equal(kn_bezier_oriented_box(ctx, &box, &flat), KN_EDOMAIN);
    assert_int_equal(kn_bezier_lipschitz(ctx, lo, &empty), KN_EDOMAIN);
    assert_int_equal(kn_bezier_lipschitz(ctx, lo, &flat), KN_EDOMAIN);
    assert_int_equal(kn_ctx_error(ctx), KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_bezier_lipschitz(ctx, lo, &high), KN_ELIMIT); // degree 58
    assert_int_equal(kn_ctx_error(ctx), KN_ELIMIT);
    assert_true(lo[0] == 17.0 && hi[0] == 17.0 && box.half[0] == 17.0);
    kn_bezier_clear(ctx, &a);
    kn_bezier_clear(ctx, &flat);
    kn_bezier_clear(ctx, &high);
    test_ctx_end(ctx, &memory);
}

static kn_status call_once(kn_ctx *ctx, void *user)
{
    int which = *(const int *)user;
    const double lo[2] = {0.25, 0.5}, hi[2] = {0.5, 1.0};
    double least[3] = {17.0, 17.0, 17.0}, most[3] = {17.0, 17.0, 17.0};
    kn_oriented_box box = {.half = {17.0}};
    kn_bezier a = {0};
    kn_status status = kn_bezier_init(ctx, &a, 2, 3 + which % 2, which % 2, (int[]){2, 3});
    for (size_t i = 0; status == KN_OK && i < (size_t)a.ncomp * 12; i++) a.coef[i] = 1.0 + (double)(i % 5);
    if (status == KN_OK && which / 2 == 0) status = kn_bezier_box(ctx, least, most, &a, lo, hi);
    if (status == KN_OK && which / 2 == 1) status = kn_bezier_oriented_box(ctx, &box, &a);
    if (status == KN_OK && which / 2 == 2) status = kn_bezier_lipschitz(ctx, least, &a);
    if (status != KN_OK) assert_true(least[0] == 17.0 && most[2] == 17.0 && box.half[0] == 17.0);
    kn_bezier_clear(ctx, &a);
    return status;
}

static void out_of_memory(void **state)
{
    (void)state;
    for (int which = 0; which < 6; which++) test_allocation_failures(call_once, &which);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_boxes), cmocka_unit_test(boxes_over_parts), cmocka_unit_test(slanted_patches),
        cmocka_unit_test(any_net),     cmocka_unit_test(lipschitz_bounds), cmocka_unit_test(lipschitz_corners),
        cmocka_unit_test(failures),    cmocka_unit_test(out_of_memory),
    };
    return cmocka_run_group_tests_name("bezier/bounds", tests, NULL, NULL);
}
