// SPDX-License-Identifier: Apache-2.0
// Inside knurl: doubles as the shortest decimal text that reads back as the same double.
#ifndef IO_DECIMAL_H
#define IO_DECIMAL_H

#include <stddef.h>
#include <stdint.h>

enum { KN_DECIMAL_BYTES = 40 }; // room for the text of any double, or of any 64-bit integer

// digits * 10^exponent; digits below 10^17 and not a multiple of ten, or zero.
typedef struct kn_decimal {
    uint64_t digits;
    int exponent;
} kn_decimal;

// The decimal with the fewest digits among those that round to |x|, and of these the one nearest to |x|. x is finite.
kn_decimal kn_decimal_shortest(double x);

// Each writes the text of x (finite), without a zero byte at the end, and answers its length. Locale independent.
// STEP: a decimal point always, exponent with E: 1.E-3 0.5 -2. (ISO 10303-21). Zero of either sign: "0.".
size_t kn_decimal_step(char *out, double x);
// IGES: the same with D, the exponent of double precision: 1.D-3 0.5 -2.
size_t kn_decimal_iges(char *out, double x);
// C and most else: 1e-3 0.5 -2. At most `significant` digits (1 .. 17, the shortest text rounded once more).
size_t kn_decimal_plain(char *out, double x, int significant);
size_t kn_decimal_integer(char *out, uint64_t n);

#endif
