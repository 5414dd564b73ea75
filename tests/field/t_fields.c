// SPDX-License-Identifier: Apache-2.0
// Fields against direct evaluation: splines, samples, noise.
#include "tests/support/support.h"

#include <knurl/field.h>
#include <math.h>
#include <string.h>

static double at(const kn_field *f, double u, double v)
{
    kn_place place = {.uv = {u, v}};
    return f->value(f->user, &place);
}

static void spline_over_unit_square(kn_ctx *ctx, kn_spline *out, test_rng *rng, int ncomp, bool rational)
{
    const int degree[2] = {3, 2}, count[2] = {6, 4};
    test_random_spline(ctx, out, rng, 2, ncomp, rational, degree, count, 9);
    for (int d = 0; d < 2; d++) assert_int_equal(kn_spline_reparameterize(ctx, out, out, d, 0, 1), KN_OK);
}

// kn_spline_eval sums in another order: both within gamma(6 (p + q) + 2) of sum |c| N <= 9, with a weight in [1, 9]
// three times that, and twice for the two of them.
static void splines(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    for (int round = 0; round < test_scale(20); round++) {
        kn_spline s = {0};
        kn_field f = {0};
        spline_over_unit_square(ctx, &s, &rng, round % 2 == 1 ? 2 : 1, round % 2 == 1);
        assert_int_equal(kn_field_spline(ctx, &f, &s), KN_OK);
        assert_int_equal(f.needs, 0);
        for (int i = 0; i < 20; i++) {
            double uv[2] = {i == 0 ? 0 : i == 1 ? 1 : test_uniform(&rng, 0, 1), test_uniform(&rng, 0, 1)}, value;
            assert_int_equal(kn_spline_eval(ctx, &value, &s, uv), KN_OK);
            assert_true(fabs(at(&f, uv[0], uv[1]) - value) <= 6 * 32 * 0x1p-53 * 9);
        }
        kn_spline_clear(ctx, &s);
    }
    test_ctx_end(ctx, &memory);
}

static void bad_splines(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(2);
    kn_spline s = {0};
    kn_field f = {.needs = 77};
    assert_int_equal(kn_field_spline(ctx, &f, &s), KN_EDOMAIN); // empty
    spline_over_unit_square(ctx, &s, &rng, 2, false);
    assert_int_equal(kn_field_spline(ctx, &f, &s), KN_EDOMAIN); // two components
    kn_spline_clear(ctx, &s);
    spline_over_unit_square(ctx, &s, &rng, 1, false);
    assert_int_equal(kn_spline_reparameterize(ctx, &s, &s, 1, 0, 2), KN_OK);
    assert_int_equal(kn_field_spline(ctx, &f, &s), KN_EDOMAIN); // another domain
    assert_int_equal(f.needs, 77);
    assert_null(f.value);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// On integers bilinear values at quarters are exact.
static void grids(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    const double values[15] = {0, 4, 8, 3, 1, 5, 7, 2, 6, 9, 4, 4, 1, 0, 12};
    kn_field_samples s = {{3, 5}, {false, false}, values};
    kn_field f = {0};
    assert_int_equal(kn_field_grid(ctx, &f, &s), KN_OK);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 5; j++) assert_true(at(&f, i / 2.0, j / 4.0) == values[5 * i + j]);
    assert_true(at(&f, 0.25, 0.125) == (0 + 4 + 5 + 7) / 4.0);
    assert_true(at(&f, 0.875, 1) == 0.25 * 9 + 0.75 * 12);
    assert_true(at(&f, -3, 0.25) == 4 && at(&f, 9, 9) == 12); // the border goes on
    (void)at(&f, NAN, NAN);                                   // stays inside the samples
    s.n[0] = 4, s.n[1] = 2;
    s.closed[0] = true;
    assert_int_equal(kn_field_grid(ctx, &f, &s), KN_OK);
    for (int i = -4; i < 8; i++) assert_true(at(&f, i / 4.0, 0) == values[2 * ((i + 8) % 4)]);
    assert_true(at(&f, 0.875, 0) == (values[6] + values[0]) / 2);
    assert_true(at(&f, 0.875, 0) == at(&f, -0.125, 0) && at(&f, 0.875, 0) == at(&f, 1.875, 0));
    s.n[0] = 1;
    assert_int_equal(kn_field_grid(ctx, &f, &s), KN_OK);
    assert_true(at(&f, 0.3, 1) == 4);

    kn_field kept = f;
    s.n[1] = 1;
    assert_int_equal(kn_field_grid(ctx, &f, &s), KN_EDOMAIN);
    s.n[0] = 0, s.n[1] = 2;
    assert_int_equal(kn_field_grid(ctx, &f, &s), KN_EDOMAIN);
    const double broken[4] = {0, 1, INFINITY, 2};
    s = (kn_field_samples){{2, 2}, {false, false}, broken};
    assert_int_equal(kn_field_grid(ctx, &f, &s), KN_EDOMAIN);
    assert_true(f.value == kept.value && f.user == kept.user);
    test_ctx_end(ctx, &memory);
}

// The gradient at a lattice point, from the noise around it: noise(p + h e) = sqrt(2/3) (1 - s(h)) g.e h + O(h^4).
static void gradient_at(double g[3], const double p[3], uint64_t seed)
{
    const double h = 0x1p-10;
    for (int c = 0; c < 3; c++) {
        double x[3] = {p[0], p[1], p[2]};
        x[c] += h;
        g[c] = round(kn_noise(x, seed) / (h * sqrt(2.0 / 3)));
    }
}

// Perlin's formula in long double, with the gradients found above: each has two components +-1 and a 0.
static void noise_is_perlin_s(void **state)
{
    (void)state;
    test_rng rng = test_random(3);
    int seen[27] = {0};
    for (int round = 0; round < test_scale(200); round++) {
        uint64_t seed = test_bits(&rng);
        double far = round % 4 == 0 ? 1e6 : 20, x[3], base[3];
        long double sum = 0, t[3], s[3];
        for (int c = 0; c < 3; c++) {
            x[c] = test_uniform(&rng, -far, far);
            base[c] = floor(x[c]);
            t[c] = (long double)x[c] - base[c];
            s[c] = t[c] * t[c] * t[c] * (t[c] * (6 * t[c] - 15) + 10);
        }
        for (int k = 0; k < 8; k++) {
            const int bit[3] = {k & 1, k >> 1 & 1, k >> 2};
            double corner[3], g[3];
            long double weight = 1, along = 0;
            for (int c = 0; c < 3; c++) corner[c] = base[c] + bit[c];
            assert_true(kn_noise(corner, seed) == 0);
            gradient_at(g, corner, seed);
            assert_true(fabs(g[0]) + fabs(g[1]) + fabs(g[2]) == 2 && fmax(fabs(g[0]), fabs(g[1])) == 1);
            seen[(int)(9 * g[0] + 3 * g[1] + g[2]) + 13]++;
            for (int c = 0; c < 3; c++) {
                weight *= bit[c] ? s[c] : 1 - s[c];
                along += (long double)g[c] * (t[c] - bit[c]);
            }
            sum += weight * along;
        }
        assert_true(fabsl(sum * sqrtl(2.0L / 3) - kn_noise(x, seed)) <= 1e-12L);
    }
    int kinds = 0;
    for (int k = 0; k < 27; k++) kinds += seen[k] > 0;
    assert_int_equal(kinds, 12); // 1600 draws: one missing has a chance of 1e-60
}

// Continuous over lattice planes; in [-1,1]; seeds differ; where doubles have no fraction it is 0.
static void noise_is_continuous(void **state)
{
    (void)state;
    test_rng rng = test_random(4);
    double most = 0;
    int same = 0;
    for (int round = 0; round < test_scale(20000); round++) {
        double x[3] = {test_uniform(&rng, -9, 9), test_uniform(&rng, -9, 9), test_uniform(&rng, -9, 9)}, y[3];
        double value = kn_noise(x, 5);
        most = fmax(most, fabs(value));
        same += value == kn_noise(x, 6);
        memcpy(y, x, sizeof y);
        int c = round % 3;
        x[c] = round / 3 % 17 - 8;
        y[c] = nextafter(x[c], -100);
        // |d noise| <= sqrt(2/3) (s' <= 15/8 times a difference of at most 2 sqrt(2) sqrt(3), and sqrt(2)) < 9
        assert_true(fabs(kn_noise(x, 5) - kn_noise(y, 5)) <= 9 * fabs(x[c] - y[c]) + 2e-12);
    }
    assert_true(most <= 1 && most > 0.5);
    assert_true(same < 20);
    const double far[3] = {0x1p51 + 1, 0.5, 0.5}, none[3] = {0.5, NAN, 0.5};
    assert_true(kn_noise(far, 1) == 0 && kn_noise(none, 1) == 0);
}

static void octaves(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(5);
    kn_field_octaves o = {.size = 2, .octaves = 3, .seed = 9};
    kn_field f = {0};
    assert_int_equal(kn_field_noise(ctx, &f, &o), KN_OK);
    assert_int_equal(f.needs, KN_NEEDS_POINT);
    for (int i = 0; i < 50; i++) {
        kn_place place = {0};
        double sum = 0;
        for (int c = 0; c < 3; c++) place.point[c] = test_uniform(&rng, -4, 4);
        for (int k = 0; k < 3; k++) {
            double x[3], frequency = 0.5 * (1 << k); // powers of two: the products are exact
            for (int c = 0; c < 3; c++) x[c] = place.point[c] * frequency;
            sum += kn_noise(x, 9 + (uint64_t)k) / (1 << k);
        }
        double value = f.value(&o, &place);
        assert_true(fabs(value - sum / 1.75) <= 4 * 0x1p-53);
        o.lo = 2, o.hi = 5;
        double scaled = f.value(&o, &place);
        assert_true(fabs(scaled - (3.5 + 1.5 * value)) <= 8 * 0x1p-53 * 5 && scaled >= 2 && scaled <= 5);
        o.lo = o.hi = 0;
    }
    static const kn_field_octaves bad[] = {{.size = 0},          {.size = -1},
                                           {.size = INFINITY},   {.size = 1, .octaves = -1},
                                           {.size = 1, .lo = 2}, {.size = 1, .hi = INFINITY}};
    kn_field kept = f;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(kn_field_noise(ctx, &f, &bad[i]), KN_EDOMAIN);
    o.octaves = 33;
    assert_int_equal(kn_field_noise(ctx, &f, &o), KN_ELIMIT);
    assert_true(f.value == kept.value && f.user == kept.user);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(splines),           cmocka_unit_test(bad_splines),         cmocka_unit_test(grids),
        cmocka_unit_test(noise_is_perlin_s), cmocka_unit_test(noise_is_continuous), cmocka_unit_test(octaves)};
    return cmocka_run_group_tests_name("field/fields", tests, NULL, NULL);
}
