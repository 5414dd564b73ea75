// SPDX-License-Identifier: Apache-2.0
// Shortest decimal text against the C library's printf and strtod, and the table against exact integers.
#include "tests/support/support.h"

#include "io/decimal.h"
#include "io/decimal_table.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *step(char text[KN_DECIMAL_BYTES + 1], double x)
{
    size_t n = kn_decimal_step(text, x);
    assert_true(n <= KN_DECIMAL_BYTES);
    text[n] = '\0';
    return text;
}

static const char *plain(char text[KN_DECIMAL_BYTES + 1], double x, int significant)
{
    size_t n = kn_decimal_plain(text, x, significant);
    assert_true(n <= KN_DECIMAL_BYTES);
    text[n] = '\0';
    return text;
}

static void step_form(void **state)
{
    (void)state;
    static const struct {
        double x;
        const char *text;
    } cases[] = {
        {0.0, "0."},
        {-0.0, "0."},
        {1.0, "1."},
        {-2.0, "-2."},
        {0.5, "0.5"},
        {-0.0625, "-0.0625"},
        {0.01, "0.01"},
        {1e-3, "1.E-3"},
        {1.25e-7, "1.25E-7"},
        {123.456, "123.456"},
        {100.0, "100."},
        {1e15, "1000000000000000."},
        {1e17, "1.E17"},
        {1e22, "1.E22"},
        {9007199254740992.0, "9007199254740992."},
        {0.1, "0.1"},
        {1.0 / 3.0, "0.3333333333333333"},
        {5e-324, "5.E-324"},
        {9.88131291682493e-324, "1.E-323"},
        {2.2250738585072014e-308, "2.2250738585072014E-308"},
        {-1.7976931348623157e308, "-1.7976931348623157E308"},
    };
    char text[KN_DECIMAL_BYTES + 1];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_string_equal(step(text, cases[i].x), cases[i].text);
}

static void plain_form(void **state)
{
    (void)state;
    char text[KN_DECIMAL_BYTES + 1];
    assert_string_equal(plain(text, -2.0, 9), "-2");
    assert_string_equal(plain(text, 0.0, 9), "0");
    assert_string_equal(plain(text, -0.0, 9), "0");
    assert_string_equal(plain(text, 1e-3, 9), "1e-3");
    assert_string_equal(plain(text, 1.0 / 3.0, 9), "0.333333333");
    assert_string_equal(plain(text, 2.0 / 3.0, 4), "0.6667");
    assert_string_equal(plain(text, 0.99999, 3), "1");
    assert_string_equal(plain(text, 123456.0, 3), "123000");
    assert_string_equal(plain(text, 1.0 / 3.0, 17), "0.3333333333333333");
    assert_string_equal(plain(text, 6.02214076e23, 9), "6.02214076e23");
}

static void integers(void **state)
{
    (void)state;
    char text[KN_DECIMAL_BYTES + 1], expected[KN_DECIMAL_BYTES + 1];
    test_rng rng = test_random(1);
    for (int i = 0; i < 2000; i++) {
        uint64_t n = test_bits(&rng) >> test_int(&rng, 0, 63);
        text[kn_decimal_integer(text, n)] = '\0';
        snprintf(expected, sizeof expected, "%llu", (unsigned long long)n);
        assert_string_equal(text, expected);
    }
}

// A double of random bits: every exponent, with many or few bits set, and short decimals.
static double any_double(test_rng *rng, int kind)
{
    uint64_t bits = test_bits(rng);
    if (kind == 1) bits &= 0xfff0000000000000u; // the first of a binade
    if (kind == 2) bits &= 0xffffff0000000000u;
    if (kind == 3) return (double)test_int(rng, -1000000, 1000000) / 1e5;
    if (kind == 4) return test_uniform(rng, -10.0, 10.0);
    if (kind == 5) bits &= 0x800fffffffffffffu; // below the normal range
    double x;
    memcpy(&x, &bits, sizeof x);
    return isfinite(x) ? x : 1.0;
}

// It reads back; n - 1 digits would not; and of n digits it is the nearest, that is, printf's.
static void expect_shortest(double x)
{
    char text[KN_DECIMAL_BYTES + 1], digits[32], fewer[64], same[64], printed[64];
    assert_true(strtod(step(text, x), NULL) == x);
    assert_true(strtod(plain(text, x, 17), NULL) == x);
    kn_decimal d = kn_decimal_shortest(x);
    if (x == 0.0) return;
    int n = snprintf(digits, sizeof digits, "%llu", (unsigned long long)d.digits);
    assert_true(d.digits % 10 != 0);
    snprintf(fewer, sizeof fewer, "%.*e", n - 2, x);
    if (n > 1) assert_true(strtod(fewer, NULL) != x);
    snprintf(same, sizeof same, "%.*e", n - 1, fabs(x));
    if (strtod(same, NULL) != fabs(x)) return; // below the first double of a binade the interval is narrower
    snprintf(printed, sizeof printed, "%c%s%se%+03d", digits[0], n > 1 ? "." : "", digits + 1, d.exponent + n - 1);
    assert_string_equal(printed, same);
}

static void shortest(void **state)
{
    (void)state;
    test_rng rng = test_random(2);
    int n = test_scale(60000);
    for (int i = 0; i < n; i++) expect_shortest(any_double(&rng, i % 6));
    for (int e = -1074; e <= 1023; e++) { // every binade: its first double and the neighbours
        double x = ldexp(1.0, e);
        expect_shortest(x);
        expect_shortest(nextafter(x, 0.0));
        expect_shortest(nextafter(x, 2.0 * x < INFINITY ? 2.0 * x : x));
    }
}

// ---- the table: numbers of 40 words of 32 bits, the lowest first ----
enum { WORDS = 40 };

static void times_ten(uint32_t *n)
{
    uint64_t carry = 0;
    for (int i = 0; i < WORDS; i++) {
        carry += (uint64_t)n[i] * 10;
        n[i] = (uint32_t)carry;
        carry >>= 32;
    }
    assert_int_equal(carry, 0);
}

static void add_one(uint32_t *n)
{
    int i = 0;
    while (++n[i] == 0) i++;
}

// n = ceil(n / divisor); ceilings of quotients may be taken one after the other.
static void divide_up(uint32_t *n, uint32_t divisor)
{
    uint64_t rest = 0;
    for (int i = WORDS - 1; i >= 0; i--) {
        rest = (rest << 32) | n[i];
        n[i] = (uint32_t)(rest / divisor);
        rest %= divisor;
    }
    if (rest != 0) add_one(n);
}

static int bit_length(const uint32_t *n)
{
    int bits = 32 * WORDS;
    while (bits > 0 && (n[(bits - 1) / 32] >> ((bits - 1) % 32) & 1) == 0) bits--;
    return bits;
}

static void expect_entry(const uint32_t *n, int k)
{
    const uint64_t *g = power_of_ten[k + 292];
    assert_true(g[0] == ((uint64_t)n[3] << 32 | n[2]));
    assert_true(g[1] == ((uint64_t)n[1] << 32 | n[0]));
}

static void table(void **state)
{
    (void)state;
    uint32_t power[WORDS] = {1}, n[WORDS];
    for (int k = 0; k <= 324; k++, times_ten(power)) {
        memcpy(n, power, sizeof n);
        for (; bit_length(n) > 128;) { // halves, rounded up, keep ceil(10^k / 2^j)
            divide_up(n, 2);
        }
        while (bit_length(n) < 128) { // exact powers
            uint32_t doubled[WORDS];
            for (int i = 0; i < WORDS; i++) doubled[i] = n[i] << 1 | (i > 0 ? n[i - 1] >> 31 : 0);
            memcpy(n, doubled, sizeof n);
        }
        expect_entry(n, k);
        if (k == 0 || k > 292) continue;
        // 10^-k: 2^127 < 2^m / 10^k < 2^128 for m = 127 + bits of 10^k, as 10^k is no power of two
        memset(n, 0, sizeof n);
        int m = 127 + bit_length(power);
        n[m / 32] = (uint32_t)1 << (m % 32);
        for (int i = 0; i < k; i++) divide_up(n, 10);
        expect_entry(n, -k);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(step_form), cmocka_unit_test(plain_form), cmocka_unit_test(integers),
        cmocka_unit_test(shortest),  cmocka_unit_test(table),
    };
    return cmocka_run_group_tests_name("io/decimal", tests, NULL, NULL);
}
