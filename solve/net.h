// SPDX-License-Identifier: Apache-2.0
// Coefficients of several functions of one shape on raw arrays, with bounds on their rounding.
//
// An error belongs to one function: each of its coefficients is within it of that of an exact function. Convex
// combinations keep it, and add their own rounding to it.
#ifndef SOLVE_NET_H
#define SOLVE_NET_H

#include <knurl/solve.h>

#include <math.h>

// ncomp functions of nvars variables over a box: arrays of count = prod_d (degree[d] + 1) numbers, one after the
// other, the last variable fastest.
typedef struct kn_net {
    int nvars, ncomp;
    int degree[KN_MAX_VARS];
    size_t count;
} kn_net;

// More than gamma(n) = n u / (1 - n u), for n < 2^40.
static inline double kn_rounding(double n)
{
    return n * 0x1.01p-53;
}

// More than what underflow takes from some thousand operations.
static inline double kn_underflow(void)
{
    return 0x1p-1060;
}

kn_net kn_net_make(int nvars, int ncomp, const int *degree);
// max |coef[i]|; NaN is passed over.
double kn_largest(const double *coef, size_t n);
// Seen along variable d an array of `count` numbers is (outer, degree[d] + 1, inner), without components.
size_t kn_net_inner(const kn_net *net, int d);
// Boxes of this many coefficients between two reports of progress: some 10 ms of work.
size_t kn_net_rhythm(size_t coefficients);
// out = in over the box [lo,hi], over [0,1]^nvars again. in, out, work: ncomp * count numbers each, all different.
// error[c] is raised by the rounding: gamma(5n + 2) times the largest coefficient for each variable, times
// (1 + 2 reach)^n for boxes that reach beyond [0,1].
void kn_net_restrict(double *out, double *error, const kn_net *net, const double *in, const double *lo,
                     const double *hi, double *work);
// The variable along which neighbouring coefficients differ most, each function measured in units of its largest
// coefficient; -1 when none differ by more than the errors.
int kn_net_steepest(const kn_net *net, const double *coef, const double *error);

// What a test makes of one box.
typedef enum kn_verdict {
    KN_HALVE, // undecided here
    KN_DONE,  // this box is settled
    KN_STOP,  // the whole question is
} kn_verdict;
typedef kn_verdict (*kn_box_test)(void *user, const kn_net *net, const double *coef, const double *error);

// Halves boxes until each is settled, at most `depth` times: *settled tells whether all are. KN_STOP ends it
// (*settled is then false). coef and error are those of the whole.
kn_status kn_net_divide(kn_ctx *ctx, bool *settled, const kn_net *net, const double *coef, const double *error,
                        int depth, kn_box_test test, void *user);

// The start of the predicates: checks f, its weights, the box (NULL: [0,1]^nvars) and the depth, and puts the
// numerators of f over the box into scratch, with their errors.
kn_status kn_predicate_start(kn_ctx *ctx, const char *what, kn_net *net, double **coef, double **error,
                             const kn_bezier *f, const double *lo, const double *hi, int depth);
// The answer to which sign the one function of net has, all boxes taken together.
kn_status kn_predicate_sign(kn_ctx *ctx, kn_sign *out, const kn_net *net, double *coef, double *error, int depth);

#endif
