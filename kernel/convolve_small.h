// SPDX-License-Identifier: Apache-2.0
// Products of small Bernstein forms in registers from beginning to end: scaling, convolution, division in one call.
#ifndef KERNEL_CONVOLVE_SMALL_H
#define KERNEL_CONVOLVE_SMALL_H

#include <stdbool.h>
#include <stddef.h>

enum { KN_SMALL_DEGREE = 8 }; // in each of at most two variables

// Component `to` of the result += sign * component a of the first operand * component b of the second.
typedef struct kn_term {
    int to, a, b;
    double sign;
} kn_term;

// Dense coefficients in at most two variables; component ncomp is the constant 1 if with_one, and in coef otherwise,
// if anything wants it.
typedef struct kn_small_operand {
    const double *coef;
    int rows, columns, ncomp; // rows and columns: degrees + 1; 1 for a variable that is missing
    bool with_one;
} kn_small_operand;

// Whether this machine has them.
bool kn_small_here(void);

// out = a * b, component by component, as kn_bezier_product has it: ncomp are dimensions, equal or 1, and rational
// adds the product of the weights, 1 where with_one. Any number of components.
// in:     rows and columns up to KN_SMALL_DEGREE + 1. out, dense, may be an operand's array: component c is written
//         after component c of both was read, or component 0 of the one of dimension 1, and no other is read again.
// error:  that of the scaled operands (one rounding each: all weights are exact), of sums of at most `rows` terms, of
//         the sums of at most `columns` of these, and of the quotient, rounded to nearest.
void kn_small_product(double *out, const kn_small_operand *a, const kn_small_operand *b, bool rational);

// Whether kn_small_run takes operands of these degrees + 1 and components (the constant 1 included), on this machine.
bool kn_small_fits(int rows_a, int columns_a, int na, int rows_b, int columns_b, int nb);
// Whether the terms come component by component of the result, none of which is left out.
bool kn_small_in_order(const kn_term *terms, int nterms, int ncomp);
// out = the sum of the terms, components dense one after the other; out may be an operand's array.
// error:  as above, the sums of `rows` terms going on from term to term.
void kn_small_run(double *out, const kn_small_operand *a, const kn_small_operand *b, const kn_term *terms,
                  int nterms);

#endif
