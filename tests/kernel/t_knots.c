// SPDX-License-Identifier: Apache-2.0
// Knot vectors: spans, breaks, unions, blossoms and bands.
#include <math.h>

#include "kernel/knots.h"
#include "tests/support/support.h"

static const double knots[] = {0, 0, 0, 0, 1, 1, 2, 4, 4, 4, 4}; // cubic, 7 coefficients
enum { P = 3, N = 7 };

static void spans(void **state)
{
    (void)state;
    const struct {
        double t;
        int span;
    } cases[] = {{-9, 3}, {0, 3}, {0.5, 3}, {1, 5}, {1.5, 5}, {2, 6}, {3.9, 6}, {4, 6}, {99, 6}, {NAN, 3}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_int_equal(kn_knots_span(knots, P, N, cases[i].t), cases[i].span);
    assert_int_equal(kn_knots_spans(knots, P, N), 3);
    int s = -1;
    const int expected[] = {3, 5, 6, N};
    for (int i = 0; i < 4; i++) assert_int_equal(s = kn_knots_next_span(knots, P, N, s), expected[i]);
}

static void breaks(void **state)
{
    (void)state;
    double at[4];
    int times[4];
    assert_int_equal(kn_knots_breaks(NULL, NULL, knots, P, N), 4);
    assert_int_equal(kn_knots_breaks(at, times, knots, P, N), 4);
    const double expected[] = {0, 1, 2, 4};
    const int often[] = {4, 2, 1, 4};
    for (int i = 0; i < 4; i++) assert_true(at[i] == expected[i] && times[i] == often[i]);
    double back[11];
    assert_int_equal(kn_knots_repeat(NULL, at, times, 4), 11);
    assert_int_equal(kn_knots_repeat(back, at, times, 4), 11);
    assert_memory_equal(back, knots, sizeof knots);
}

static void unions(void **state)
{
    (void)state;
    const double a[] = {0, 0, 1, 1, 2, 5}, b[] = {0, 1, 1, 1, 3, 5, 5}, expected[] = {0, 0, 1, 1, 1, 2, 3, 5, 5};
    double out[13];
    assert_int_equal(kn_knots_union(NULL, a, 6, b, 7), 9);
    assert_int_equal(kn_knots_union(out, a, 6, b, 7), 9);
    assert_memory_equal(out, expected, sizeof expected);
    assert_int_equal(kn_knots_union(out, a, 6, NULL, 0), 6);
    assert_memory_equal(out, a, sizeof a);
}

static void faults(void **state)
{
    (void)state;
    assert_null(kn_knots_fault(knots, P, N));
    assert_null(kn_knots_fault((double[]){0, 1, 3}, 0, 2));
    assert_non_null(kn_knots_fault((double[]){0, 1, 1, 3}, 0, 3)); // twice at degree 0
    assert_non_null(kn_knots_fault((double[]){0, 0, 2, 1, 3, 3}, 1, 4));
    assert_non_null(kn_knots_fault((double[]){0, 0, NAN, 3, 3}, 1, 3));
}

// The blossom of x^2 is xy, of x it is (x + y)/2, of 1 it is 1, whatever the span: with coefficients at the knots'
// own blossoms. Knots at integers a power of two apart, so that all is exact.
static void polar_forms(void **state)
{
    (void)state;
    const double k[] = {0, 0, 0, 1, 2, 3, 4, 4, 4};
    for (int s = 2; s < 6; s++)
        for (double x = -2; x <= 6; x += 0.5)
            for (double y = -2; y <= 6; y += 0.5) {
                double w[3], args[2] = {x, y}, square = 0, line = 0, one = 0;
                kn_knots_blossom(w, k, 2, s, args);
                for (int i = 0; i < 3; i++) {
                    double u = k[s - 1 + i], v = k[s + i];
                    square += w[i] * u * v, line += w[i] * (u + v), one += w[i];
                }
                assert_true(square == x * y && line == x + y && one == 1);
            }
}

// Values add up to 1, derivatives to 0, also at and beyond the ends; N' against its closed form for hat functions.
static void basis_functions(void **state)
{
    (void)state;
    const double k[] = {0, 0, 2, 4, 8, 8};
    double v[6];
    kn_knots_basis(v, k, 1, 2, 3.0, 2);
    const double expected[] = {0.5, 0.5, -0.5, 0.5, 0, 0};
    for (int i = 0; i < 6; i++) assert_true(v[i] == expected[i]);
    test_rng rng = test_random(1);
    for (int round = test_scale(100); round > 0; round--) {
        double t = test_uniform(&rng, -0.5, 4.5), values[3 * (P + 1)];
        kn_knots_basis(values, knots, P, kn_knots_span(knots, P, N, t), t, 2);
        double bound = 0, sum[3] = {0};
        for (int d = 0; d < 3; d++)
            for (int i = 0; i <= P; i++) sum[d] += values[d * (P + 1) + i], bound += fabs(values[d * (P + 1) + i]);
        // 6 roundings per level and the sums; the recurrence's own absolute sums are within 4 times those of the
        // result
        for (int d = 0; d < 3; d++) assert_true(fabs(sum[d] - (d == 0)) <= 4 * 30 * 0x1p-53 * bound);
    }
}

// Refinement and elevation make convex combinations; refining to the same knots is the identity, bit for bit.
static void bands(void **state)
{
    (void)state;
    double w[16 * (P + 1)];
    int first[16];
    kn_band band = {.rows = N, .first = first, .w = w};
    kn_band_refine(&band, knots, P, N, knots);
    for (int i = 0; i < N; i++)
        for (int k = 0; k <= P; k++) assert_true(w[i * (P + 1) + k] == (first[i] + k == i));
    const double in[2 * N] = {1, 2, 3, 4, 5, 6, 7, -1, -2, -3, -4, -5, -6, -7};
    double out[2 * N];
    kn_band_apply(out, &band, in, 2, N, 1);
    assert_memory_equal(out, in, sizeof in);
    kn_band_apply(out, &band, in, 1, N, 2);
    assert_memory_equal(out, in, sizeof in);

    const double finer[] = {0, 0, 0, 0, 0.3, 1, 1, 1, 1.7, 2, 4, 4, 4, 4}; // 10 coefficients
    const double higher[] = {0, 0, 0, 0, 0, 1, 1, 1, 2, 2, 4, 4, 4, 4, 4}; // 10 of degree 4
    for (int kind = 0; kind < 2; kind++) {
        band.rows = 10;
        if (kind == 0)
            kn_band_refine(&band, knots, P, N, finer);
        else
            kn_band_elevate(&band, knots, P, N, higher);
        for (int i = 0; i < 10; i++) {
            double sum = 0;
            int used = 0;
            for (int k = 0; k < band.width; k++) {
                assert_true(w[i * band.width + k] >= 0);
                sum += w[i * band.width + k];
                used += w[i * band.width + k] > 0;
            }
            if (kind == 1 && used > 1) sum /= band.divisor;
            assert_true(fabs(sum - 1) <= 30 * 0x1p-53); // p + 1 terms >= 0 of at most 6 p + 2 roundings
        }
    }
}

enum { MOST = 64 };

// Knots of degree p over [0, n], clamped, each interior one 0 .. p + 1 times; now and then tiny and huge spans.
static int random_knots(double *k, test_rng *rng, int p, int n)
{
    int count = 0;
    double at = 0;
    for (int b = 0; b <= n; b++) {
        int times = b == 0 || b == n ? p + 1 : test_int(rng, 0, p + 1);
        for (int i = 0; i < times && count < MOST - p - 1; i++) k[count++] = at;
        at += test_int(rng, 0, 5) == 0 ? 1e-9 : test_int(rng, 0, 5) == 0 ? 1e6 : test_int(rng, 1, 3);
    }
    while (count < 2 * (p + 1) || k[count - 1] != k[count - 1 - p]) k[count++] = at;
    return count - p - 1;
}

// The fast map against the plain one. Both compute sums of positive terms with at most 5 roundings a level and their
// additions, so that each weight is within gamma(5 p) of the true one; sums of p + 1 blossoms add p roundings.
static void assert_close_bands(const kn_band *a, const kn_band *b, int p)
{
    for (int i = 0; i < a->rows; i++)
        for (int k = 0; k < b->width; k++) {
            int at = b->first[i] + k - a->first[i], terms = a->terms ? a->terms[i] : a->width;
            double x = at >= 0 && at < terms ? a->w[i * a->width + at] : 0, y = b->w[i * b->width + k];
            if (!(fabs(x - y) <= (12 * p + 2) * 0x1p-53 * y))
                fail_msg("degree %d, row %d, weight %d: %.17g, plainly %.17g", p, i, k, x, y);
        }
}

static void fast_refinement_is_the_plain_one(void **state)
{
    (void)state;
    test_rng rng = test_random(7);
    static double w[3][MOST * 12];
    int first[3][MOST], terms[MOST];
    for (int round = test_scale(400); round > 0; round--) {
        double old[2 * MOST], to[2 * MOST], extra[MOST];
        int p = test_int(&rng, 0, 9), n = random_knots(old, &rng, p, test_int(&rng, 1, 5)), m = 0, last = n + p;
        for (int i = 0; i < last; i++) { // a break as often as it may be, or a new knot
            int free = p + 1;
            for (int k = 0; k <= last; k++) free -= old[k] == old[i];
            bool inside = old[i] > old[0] && old[i] < old[last];
            if (inside && old[i] != old[i - 1])
                for (int k = test_int(&rng, 0, free); k > 0 && m < 20; k--) extra[m++] = old[i];
            double middle = old[i] + 0.5 * (old[i + 1] - old[i]);
            if (middle > old[i] && middle < old[i + 1])
                for (int k = test_int(&rng, -2, p + 1); k > 0 && m < 20; k--) extra[m++] = middle;
        }
        int at = 0;
        for (int i = 0, j = 0; i <= last || j < m;)
            to[at++] = j >= m || (i <= last && old[i] <= extra[j]) ? old[i++] : extra[j++];
        if (n + m > MOST) continue;
        kn_band fast = {.rows = n + m, .first = first[0], .terms = terms, .w = w[0]};
        kn_band padded = {.rows = n + m, .first = first[1], .w = w[1]},
                plain = {.rows = n + m, .first = first[2], .w = w[2]};
        kn_band_refine(&fast, old, p, n, to);
        kn_band_refine(&padded, old, p, n, to);
        kn_band_refine_plain(&plain, old, p, n, to);
        assert_close_bands(&fast, &plain, p);
        assert_close_bands(&padded, &plain, p);
        for (int i = 0; i < n + m; i++)
            for (int k = 0; k < terms[i]; k++) assert_true(fast.w[i * fast.width + k] > 0);
    }
}

// A part of the knots: from one place inside to another, breaks or not.
static void refinement_of_a_part(void **state)
{
    (void)state;
    test_rng rng = test_random(8);
    static double w[2][MOST * 12];
    int first[2][MOST], terms[MOST];
    for (int round = test_scale(400); round > 0; round--) {
        double old[2 * MOST], to[2 * MOST];
        int p = test_int(&rng, 0, 9), n = random_knots(old, &rng, p, test_int(&rng, 1, 5)), last = n + p, at = 0;
        double lo = old[test_int(&rng, 0, n - 1)], hi = old[test_int(&rng, p + 1, last)];
        if (test_int(&rng, 0, 1)) lo = lo + 0.25 * (old[last] - lo);
        if (test_int(&rng, 0, 1)) hi = hi + 0.25 * (old[last] - hi);
        if (!(lo < hi)) continue;
        for (int k = 0; k <= p; k++) to[at++] = lo;
        for (int i = 0; i <= last; i++)
            if (old[i] > lo && old[i] < hi) to[at++] = old[i];
        for (int k = 0; k <= p; k++) to[at++] = hi;
        kn_band fast = {.rows = at - p - 1, .first = first[0], .terms = terms, .w = w[0]};
        kn_band plain = {.rows = at - p - 1, .first = first[1], .w = w[1]};
        kn_band_refine(&fast, old, p, n, to);
        kn_band_refine_plain(&plain, old, p, n, to);
        assert_close_bands(&fast, &plain, p);
    }
}

static void fast_elevation_is_the_plain_one(void **state)
{
    (void)state;
    test_rng rng = test_random(9);
    static double w[3][2 * MOST * 12];
    int first[3][2 * MOST], terms[2 * MOST];
    for (int round = test_scale(400); round > 0; round--) {
        double old[2 * MOST], to[4 * MOST];
        int p = test_int(&rng, 0, 9), n = random_knots(old, &rng, p, test_int(&rng, 1, 5)), last = n + p, at = 0;
        for (int i = 0; i <= last; i++) {
            to[at++] = old[i];
            if (i == last || old[i] < old[i + 1]) to[at++] = old[i];
        }
        kn_band fast = {.rows = at - p - 2, .first = first[0], .terms = terms, .w = w[0]};
        kn_band padded = {.rows = at - p - 2, .first = first[1], .w = w[1]};
        kn_band plain = {.rows = at - p - 2, .first = first[2], .w = w[2]};
        kn_band_elevate(&fast, old, p, n, to);
        kn_band_elevate(&padded, old, p, n, to);
        kn_band_elevate_plain(&plain, old, p, n, to);
        assert_true(fast.divisor == p + 1 && plain.divisor == p + 1);
        assert_close_bands(&fast, &plain, p);
        assert_close_bands(&padded, &plain, p);
    }
}

// One band with 1 .. 9 terms, in all shapes: the fast application gives the bits of the plain one.
static void fast_application_is_the_plain_one(void **state)
{
    (void)state;
    test_rng rng = test_random(10);
    double w[9 * 9], in[2 * 12 * 5], out[2][2 * 9 * 5];
    int first[9], terms[9];
    for (int inner = 1; inner <= 5; inner++)
        for (int divide = 0; divide < 2; divide++) {
            for (int i = 0; i < 9; i++) {
                first[i] = test_int(&rng, 0, 3), terms[i] = 1 + i;
                for (int k = 0; k <= i; k++) w[i * 9 + k] = test_uniform(&rng, 0.1, 1);
            }
            w[0] = 1;
            for (int i = 0; i < 2 * 12 * inner; i++) in[i] = test_uniform(&rng, -1, 1);
            in[first[0]] = -0.0;
            kn_band band = {.rows = 9, .width = 9, .first = first, .terms = terms, .w = w, .divisor = divide ? 7 : 0};
            kn_band_apply(out[0], &band, in, 2, 12, (size_t)inner);
            kn_band_apply_plain(out[1], &band, in, 2, 12, (size_t)inner);
            assert_memory_equal(out[0], out[1], 2 * 9 * (size_t)inner * sizeof(double));
            assert_memory_equal(out[0], in + first[0] * inner, (size_t)inner * sizeof(double)); // a copy
        }
}

// Joining copies what lies in one piece, and takes the lower of equals.
static void joins(void **state)
{
    (void)state;
    const double at[] = {0, 1, 2}, to[] = {0, 0, 0, 1, 1, 2, 2, 2}, smooth[] = {0, 0, 0, 1, 2, 2, 2};
    double w[15];
    int first[5];
    kn_band band = {.rows = 5, .first = first, .w = w};
    const double pieces[] = {1, 2, 3, 3, 4, 8};
    double out[5];
    kn_band_join(&band, at, 3, 2, to);
    kn_band_apply(out, &band, pieces, 1, 6, 1);
    const double full[] = {1, 2, 3, 4, 8}, less[] = {1, 2, 4, 8};
    for (int i = 0; i < 5; i++) assert_true(out[i] == full[i]);
    assert_int_equal(first[2], 0); // the common one from the lower piece
    band.rows = 4;
    kn_band_join(&band, at, 3, 2, smooth);
    kn_band_apply(out, &band, pieces, 1, 6, 1);
    for (int i = 0; i < 4; i++) assert_true(out[i] == less[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spans),
        cmocka_unit_test(breaks),
        cmocka_unit_test(unions),
        cmocka_unit_test(faults),
        cmocka_unit_test(polar_forms),
        cmocka_unit_test(basis_functions),
        cmocka_unit_test(bands),
        cmocka_unit_test(joins),
        cmocka_unit_test(fast_refinement_is_the_plain_one),
        cmocka_unit_test(refinement_of_a_part),
        cmocka_unit_test(fast_elevation_is_the_plain_one),
        cmocka_unit_test(fast_application_is_the_plain_one),
    };
    return cmocka_run_group_tests_name("kernel/knots", tests, NULL, NULL);
}
