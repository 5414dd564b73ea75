// SPDX-License-Identifier: Apache-2.0
// Inside solve and above: where a polynomial of one variable changes its sign.
#ifndef SOLVE_CURVES_H
#define SOLVE_CURVES_H

#include "kernel/context.h"

#include <knurl/solve.h>

// A growing list of numbers of the caller's: kn_free(ctx, list->at).
typedef struct kn_sign_change {
    double at; // in [0,1]
    bool rise; // f is below 0 before it and not below after it; else the other way
} kn_sign_change;
typedef struct kn_sign_changes {
    kn_sign_change *list;
    size_t count, room;
} kn_sign_changes;

// Values of a polynomial in Bernstein form by Horner's rule in t / (1 - t), or in its reciprocal: scaled[i] =
// C(degree,i) c[i]. In [0,1] they are off by gamma(6 degree + 4) sum |c_i| B_i at most.
void kn_bernstein_scale(double *scaled, const double *c, int degree);
double kn_bernstein_horner(const double *scaled, int degree, double t);

// Appends, in increasing order, the places of [0,1] where f, of Bernstein coefficients c[0 .. degree], goes from
// f < 0 to f >= 0 or back, to neighbouring doubles: zero counts as positive, so that any two functions that agree
// have the same list, also where f vanishes at an end or throughout. Neighbouring crossings alternate. Reversing c
// gives the same places, 1 - at up to its rounding. *doubtful (not cleared) counts the places where two crossings, or
// none, are nearer to each other than the rounding of the coefficients tells.
kn_status kn_solve_sign_changes(kn_ctx *ctx, kn_sign_changes *out, size_t *doubtful, const double *c, int degree);

typedef struct kn_trace_options {
    double tol;                   // as kn_solve_curves_bezier
    double longest;               // of a chord
    double error;                 // by which coefficients of f may be wrong
    const kn_sign_changes *edges; // the changes of sign along x = 0, x = 1 (in y), y = 0, y = 1 (in x), where the
                                  // caller knows them; NULL: found from f
} kn_trace_options;
// As kn_solve_curves_bezier. *distance: points of curves are that near to zeros of all functions within `error` of f,
// rounding included, but where the report counts something; about tol, more where f has hardly a slope. A zero that
// lies beyond the square by no more than that is its neighbour's.
kn_status kn_solve_trace(kn_ctx *ctx, kn_solve_curve **curves, size_t *n, kn_solve_report *report, double *distance,
                         const kn_bezier *f, const kn_trace_options *options);

#endif
