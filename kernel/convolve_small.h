// SPDX-License-Identifier: Apache-2.0
// Products of small Bernstein forms from beginning to end in registers: scaling, convolution and division in one call.
#ifndef KERNEL_CONVOLVE_SMALL_H
#define KERNEL_CONVOLVE_SMALL_H

#include <stdbool.h>
#include <stddef.h>

// Component `to` of the result += sign * component a of the first operand * component b of the second.
typedef struct kn_term {
    int to, a, b;
    double sign;
} kn_term;

// Dense coefficients in at most two variables; component ncomp is the constant 1 if with_one.
typedef struct kn_small_operand {
    const double *coef;
    int rows, columns, ncomp; // rows and columns: degrees + 1; 1 for a variable that is missing
    bool with_one;
} kn_small_operand;

// Whether kn_small_run takes operands of these degrees + 1 and components (the constant 1 included), on this machine.
bool kn_small_fits(int rows_a, int columns_a, int na, int rows_b, int columns_b, int nb);
// Whether the terms come component by component of the result, none of which is left out.
bool kn_small_in_order(const kn_term *terms, int nterms, int ncomp);
// out = the sum of the terms, components dense one after the other; out may be an operand's array.
// error:  as kn_convolution_pack_thin, kn_convolution_run and kn_convolution_divide together.
void kn_small_run(double *out, const kn_small_operand *a, const kn_small_operand *b, const kn_term *terms,
                  int nterms);

#endif
