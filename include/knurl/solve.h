// SPDX-License-Identifier: Apache-2.0
// Certified signs, roots, intersections and closest points.
//
// What is called certified here holds for the function that the given coefficients define exactly: the rounding of
// the computation is inside the bounds (docs/numerics.md, "solve"). What cannot be decided is said to be so.
#ifndef KNURL_SOLVE_H
#define KNURL_SOLVE_H

#include <knurl/spline.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { KN_SOLVE_MAX_DEPTH = 1000 }; // halvings of one box, at most

// ---- predicates on one piece ----
// Common to the three:
// in:     f polynomial, or rational with positive weights (else KN_EDOMAIN); lo, hi: nvars numbers each,
//         0 <= lo <= hi <= 1 (else KN_EDOMAIN), both NULL for [0,1]^nvars; depth 0 .. KN_SOLVE_MAX_DEPTH, the number
//         of times that a box may be halved before the answer is "unknown"; 0 looks at the coefficients alone.
// out:    one answer; unchanged on failure. NaN among the coefficients gives "unknown".
// fails:  KN_EDOMAIN, KN_ENOMEM, KN_ECANCELLED.
// error:  none: a definite answer holds for the exact function.
// cost:   one pass over the coefficients where that decides; at most 2^depth boxes. From the first box
//         on that is undecided at the full depth, or whose coefficients differ by no more than their rounding, it
//         looks for two different signs alone, 4 halvings deep.

typedef enum kn_answer { KN_NO = -1, KN_UNKNOWN = 0, KN_YES = 1 } kn_answer;
typedef enum kn_sign {
    KN_SIGN_NEGATIVE = -1, // f < 0 everywhere
    KN_SIGN_UNKNOWN = 0,
    KN_SIGN_POSITIVE = 1, // f > 0 everywhere
    KN_SIGN_MIXED = 2,    // f > 0 somewhere and f < 0 somewhere
} kn_sign;

// The sign of f, of dimension 1 (else KN_EDOMAIN), over the closed box.
KN_API KN_CHECKED kn_status kn_solve_sign(kn_ctx *ctx, kn_sign *out, const kn_bezier *f, const double *lo,
                                          const double *hi, int depth);
// KN_YES: f, of any dimension, vanishes nowhere on the closed box: each box it was divided into has a plane through 0
// with all coefficients on one side. KN_NO: it has a zero there (found for dimension 1, and where the first
// coefficient of a box is exactly 0; kn_solve_zeros finds the others). source: the plane by Gilbert's iteration, An
// iterative procedure for computing the minimum of a quadratic form on a
//         convex set, SIAM J. Control 4 (1966).
KN_API KN_CHECKED kn_status kn_solve_nonzero(kn_ctx *ctx, kn_answer *out, const kn_bezier *f, const double *lo,
                                             const double *hi, int depth);
// The sign of the partial derivative of f, of dimension 1 (else KN_EDOMAIN), in variable var.
// fails:  also KN_ELIMIT: twice the degree of a rational piece passes KN_MAX_DEGREE.
KN_API KN_CHECKED kn_status kn_solve_monotone(kn_ctx *ctx, kn_sign *out, const kn_bezier *f, int var,
                                              const double *lo, const double *hi, int depth);

#ifdef __cplusplus
}
#endif
#endif
