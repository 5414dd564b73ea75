// SPDX-License-Identifier: Apache-2.0
// Doubles as shortest decimal text. Source: Giulietti, The Schubfach way to render doubles, 2020.
#include "io/decimal.h"
#include "io/decimal_table.h"

#include <stdbool.h>
#include <string.h>

enum { TABLE_FIRST = -292, MAX_PLAIN_DIGITS = 17, DIGITS = 17 };

// floor(log10(2^q)), or floor(log10(3/4 2^q)) for the first double of a binade; exact for |q| <= 1500.
static int log10_of_power(int q, bool first)
{
    return (int)(((int64_t)q * 1262611 - (first ? 524031 : 0)) >> 22);
}

// floor(log2(10^k)); exact for |k| <= 1500.
static int log2_of_power(int k)
{
    return (int)(((int64_t)k * 1741647) >> 19);
}

// The high half of a * b; the low half goes to *low. By halves: ISO C has no type of 128 bits.
static uint64_t multiply(uint64_t a, uint64_t b, uint64_t *low)
{
    uint64_t a0 = a & 0xffffffffu, a1 = a >> 32, b0 = b & 0xffffffffu, b1 = b >> 32;
    uint64_t p00 = a0 * b0, p01 = a0 * b1, p10 = a1 * b0;
    uint64_t middle = (p00 >> 32) + (p01 & 0xffffffffu) + (p10 & 0xffffffffu);
    *low = (middle << 32) | (p00 & 0xffffffffu);
    return a1 * b1 + (p01 >> 32) + (p10 >> 32) + (middle >> 32);
}

// c g / 2^128 rounded to odd: the integer part, its last bit set when a fraction is lost. The paper shows that with g
// above the true power by less than 1 a fraction of at most 2^-63 can only come from that excess.
static uint64_t round_to_odd(const uint64_t g[2], uint64_t c)
{
    uint64_t low, fraction;
    uint64_t carry = multiply(g[1], c, &low);
    uint64_t whole = multiply(g[0], c, &fraction);
    fraction += carry;
    whole += fraction < carry;
    return whole | (fraction > 1);
}

// digits * 10^exponent for c 2^q > 0, not yet free of trailing zeros. With v the value over 10^k, 10^k the largest
// power of ten not wider than the rounding interval of x, the interval holds one or two of the integers next to v,
// and at most one multiple of ten: that one if it is there, else the nearer neighbour. All is carried times 4, so
// that the interval's ends, half an ulp away (a quarter below the first double of a binade), are integers before
// scaling.
static kn_decimal shortest(uint64_t c, int q, bool first)
{
    int k = log10_of_power(q, first);
    int shift = q + log2_of_power(-k) + 1;
    const uint64_t *g = power_of_ten[-k - TABLE_FIRST];
    uint64_t open = c & 1; // round half to even: the ends belong to the interval of an even c
    uint64_t lower = round_to_odd(g, (4 * c - (first ? 1 : 2)) << shift) + open;
    uint64_t value = round_to_odd(g, (4 * c) << shift);
    uint64_t upper = round_to_odd(g, (4 * c + 2) << shift) - open;
    uint64_t s = value / 4;
    if (s >= 10) {
        uint64_t tens = s / 10;
        bool below = lower <= 40 * tens, above = 40 * tens + 40 <= upper;
        if (below != above) return (kn_decimal){tens + above, k + 1};
    }
    bool below = lower <= 4 * s, above = 4 * s + 4 <= upper;
    if (below != above) return (kn_decimal){s + above, k};
    uint64_t middle = 4 * s + 2;
    bool up = value > middle || (value == middle && (s & 1) == 1);
    return (kn_decimal){s + up, k};
}

static kn_decimal strip_zeros(kn_decimal d)
{
    while (d.digits >= 100000000 && d.digits % 100000000 == 0) d.digits /= 100000000, d.exponent += 8;
    while (d.digits != 0 && d.digits % 10 == 0) d.digits /= 10, d.exponent++;
    return d;
}

kn_decimal kn_decimal_shortest(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    uint64_t fraction = bits & 0xfffffffffffffu;
    int biased = (int)((bits >> 52) & 0x7ff);
    if (biased == 0 && fraction == 0) return (kn_decimal){0, 0};
    if (biased == 0) return strip_zeros(shortest(fraction, -1074, false));
    uint64_t c = fraction | 0x10000000000000u;
    int q = biased - 1075;
    // integers below 2^53 are their own digits
    if (q <= 0 && q >= -52 && (c & (((uint64_t)1 << -q) - 1)) == 0) return strip_zeros((kn_decimal){c >> -q, 0});
    return strip_zeros(shortest(c, q, fraction == 0 && biased > 1));
}

size_t kn_decimal_integer(char *out, uint64_t n)
{
    static const char pairs[] = "00010203040506070809101112131415161718192021222324252627282930313233343536373839"
                                "40414243444546474849505152535455565758596061626364656667686970717273747576777879"
                                "8081828384858687888990919293949596979899";
    char reversed[KN_DECIMAL_BYTES];
    char *at = reversed + sizeof reversed;
    for (; n >= 100; n /= 100) memcpy(at -= 2, pairs + 2 * (n % 100), 2);
    if (n >= 10)
        memcpy(at -= 2, pairs + 2 * n, 2);
    else
        *--at = (char)('0' + n);
    size_t length = (size_t)(reversed + sizeof reversed - at);
    memcpy(out, at, length);
    return length;
}

// Text of digits with `before` of them in front of the point; before may be 0 or -1 (0.0ddd), or above the number of
// digits (ddd00). Digits are copied as a whole block, whose end is then overwritten or not counted.
static size_t write_plain(char *out, const char *digits, int n, int before, bool point)
{
    char *at = out;
    if (before <= 0) {
        memcpy(at, "0.0", 3);
        at += 2 - before;
        memcpy(at, digits, DIGITS);
        return (size_t)(at - out) + (size_t)n;
    }
    memcpy(at, digits, DIGITS);
    if (before < n) {
        at[before] = '.';
        memcpy(at + before + 1, digits + before, DIGITS);
        return (size_t)n + 1;
    }
    for (int i = n; i < before; i++) at[i] = '0';
    if (point) at[before++] = '.';
    return (size_t)before;
}

static size_t write_exponent(char *out, const char *digits, int n, int exponent, char mark)
{
    char *at = out;
    *at++ = digits[0];
    if (n > 1 || mark != 'e') *at++ = '.';
    memcpy(at, digits + 1, DIGITS);
    at += n - 1;
    *at++ = mark;
    if (exponent < 0) *at++ = '-';
    at += kn_decimal_integer(at, (uint64_t)(exponent < 0 ? -exponent : exponent));
    return (size_t)(at - out);
}

// mark: before the exponent. A decimal point always, but for 'e'.
static size_t write_decimal(char *out, kn_decimal d, bool negative, char mark)
{
    char digits[2 * DIGITS] = {0};
    int n = (int)kn_decimal_integer(digits, d.digits), before = n + d.exponent;
    size_t sign = negative && d.digits != 0;
    out[0] = '-';
    if (before >= -1 && before <= MAX_PLAIN_DIGITS)
        return sign + write_plain(out + sign, digits, n, before, mark != 'e');
    return sign + write_exponent(out + sign, digits, n, before - 1, mark);
}

size_t kn_decimal_step(char *out, double x)
{
    return write_decimal(out, kn_decimal_shortest(x), x < 0.0, 'E');
}

size_t kn_decimal_iges(char *out, double x)
{
    return write_decimal(out, kn_decimal_shortest(x), x < 0.0, 'D');
}

size_t kn_decimal_plain(char *out, double x, int significant)
{
    kn_decimal d = kn_decimal_shortest(x);
    uint64_t limit = 1;
    for (int i = 0; i < significant; i++) limit *= 10;
    uint64_t unit = 1;
    int dropped = 0;
    for (; d.digits / unit >= limit; unit *= 10) dropped++;
    if (dropped > 0) {
        d.digits = (d.digits + unit / 2) / unit;
        d.exponent += dropped;
        d = strip_zeros(d);
    }
    return write_decimal(out, d, x < 0.0, 'e');
}
