// SPDX-License-Identifier: Apache-2.0
// What bounds of pieces share: coefficients over a box with bounds of their errors, and boxes around points.
#ifndef BEZIER_BOUNDS_H
#define BEZIER_BOUNDS_H

#include "bezier/shape.h"

// ncomp arrays of n coefficients; error has the same shape, NULL: exact. Arrays of an operand, or in scratch.
typedef struct kn_hull {
    size_t n;
    const double *coef, *error;
} kn_hull;

// The coefficients of a over [lo,hi]; both NULL: over [0,1]^nvars.
// fails: KN_EDOMAIN not finite, or lo > hi, or only one of them is NULL.
kn_status kn_bezier_hull(kn_ctx *ctx, const char *what, kn_hull *out, const kn_bezier *a, const double *lo,
                         const double *hi);
// The box of dim components, behind which the weight lies when rational. fails: KN_EDOMAIN the weight, less its
// error, is not positive everywhere.
kn_status kn_hull_box(kn_ctx *ctx, const char *what, double *lo, double *hi, const kn_hull *hull, int dim,
                      bool rational);

// The oriented box of n points of dimension dim 2 or 3, component c at points[c * n + k]. relative: each may be wrong
// by that much of itself. chords: nchords directions that the box may follow, 3 numbers each.
void kn_oriented_box_fit(kn_oriented_box *out, const double *points, int dim, size_t n, double relative,
                         double (*chords)[3], int nchords);
// The oriented box of control points: count[d] in variable d, the weight behind dim components when rational.
// fails: KN_EDOMAIN dim, weights that are not positive; KN_ENOMEM.
kn_status kn_oriented_box_of(kn_ctx *ctx, const char *what, kn_oriented_box *out, const double *coef, int dim,
                             bool rational, int nvars, const int *count);

// The coefficients of a piece, each known within gamma(known) size_k (size NULL: exact). out[v] >= the norm of its
// derivative in variable v over the unit box. fails: KN_EDOMAIN weights; KN_ELIMIT doubled degrees; KN_ENOMEM.
kn_status kn_rational_lipschitz(kn_ctx *ctx, const char *what, double *out, const kn_bezier *a, const double *size,
                                double known);

#endif
