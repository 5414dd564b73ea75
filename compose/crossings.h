// SPDX-License-Identifier: Apache-2.0
// Where a function x = X/w on [0,1]^n, in Bernstein form with positive w, meets the knots of another spline.
#ifndef COMPOSE_CROSSINGS_H
#define COMPOSE_CROSSINGS_H

#include "kernel/context.h"

#include <knurl/bezier.h>

// A growing list of numbers in scratch memory: no release between the first and the last addition.
typedef struct kn_numbers {
    double *list;
    int count, room;
} kn_numbers;
kn_status kn_numbers_add(kn_ctx *ctx, kn_numbers *numbers, double value);
// Sorts the list and drops, of numbers that differ by at most `near`, all but one: one of keep[0 .. nkeep-1]
// (sorted) if there is one among them.
void kn_numbers_merge(kn_numbers *numbers, const double *keep, int nkeep, double near);

// Crossings nearer to each other than this are one: about the rounding of a root, and of a parameter.
double kn_nearness(const double *breaks, int n);

// The variable that x = X/w alone depends on, or -1: X and w are then products of a function of that variable and a
// common function of the others, within rounding, and at_x, at_w (degree + 1 numbers each) receive the former. A
// constant depends on variable 0 alone.
int kn_depends_alone(double *at_x, double *at_w, const kn_bezier *piece, int c);

// Adds lo + r (hi - lo) for every r in (0,1) where X - value w changes its sign, X and w univariate of this degree:
// the signs at neighbouring numbers differ, as they are computed.
kn_status kn_crossings(kn_ctx *ctx, kn_numbers *out, const double *x, const double *w, int degree, double value,
                       double lo, double hi);

// The span s of breaks[0 .. nbreaks-1] that contains x = X/w of component c, the end spans reaching to infinity:
// KN_EDOMAIN (recorded) when x crosses a break, KN_EUNDECIDED when that remains open. Beyond a break do not count:
// 2^-40 of the largest |x|, and what x changes when variable d moves by blur[d] of the piece: ends of the piece are
// rounded parameters.
kn_status kn_locate(kn_ctx *ctx, const char *call, int *span, const kn_bezier *piece, int c, const double *breaks,
                    int nbreaks, const double *blur);

#endif
