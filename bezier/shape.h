// SPDX-License-Identifier: Apache-2.0
// Checks and shapes that the operations on kn_bezier share.
#ifndef BEZIER_SHAPE_H
#define BEZIER_SHAPE_H

#include "kernel/context.h"

#include <knurl/bezier.h>

// The number of all coefficients, or KN_ELIMIT (recorded, `what` named) beyond KN_MAX_VARS, KN_MAX_COMPS,
// KN_MAX_DEGREE or KN_MAX_COEFS, or KN_EDOMAIN for negative degrees, nvars < 0 or ncomp < 1 (2 when rational).
kn_status kn_bezier_check(kn_ctx *ctx, const char *what, int nvars, int ncomp, bool rational, const int *degree);
// Allocates b->coef, not cleared, for the shape that b already has, after kn_bezier_check.
kn_status kn_bezier_alloc(kn_ctx *ctx, kn_bezier *b, const char *what);
// KN_EDOMAIN (recorded) for a piece without coefficients; else kn_bezier_check, for pieces that were put together by
// hand: loops over fixed buffers rely on the limits.
kn_status kn_bezier_check_operand(kn_ctx *ctx, const char *what, const kn_bezier *a);
// The same for two, which must have the same variables.
kn_status kn_bezier_check_pair(kn_ctx *ctx, const char *what, const kn_bezier *a, const kn_bezier *b);
// As the end of an operation: on KN_OK out becomes *result and out's old coefficients are freed; otherwise
// result's are. Answers status.
kn_status kn_bezier_finish(kn_ctx *ctx, kn_bezier *out, kn_bezier *result, kn_status status);
// KN_EDOMAIN (recorded) unless 0 <= var < nvars.
kn_status kn_bezier_check_var(kn_ctx *ctx, const char *what, const kn_bezier *b, int var);
// The coefficients of one component.
static inline double *kn_bezier_comp(const kn_bezier *b, int comp)
{
    return b->coef + (size_t)comp * kn_bezier_count(b);
}

// The ncomp homogeneous values at a point, plainly. work: ncomp * count / (last degree + 1) numbers, the values
// first.
void kn_bezier_eval_plain(double *work, const kn_bezier *b, const double *at);

// b seen along variable var: (outer, degree[var] + 1, inner) with the components part of outer.
typedef struct kn_axis {
    size_t outer, inner;
} kn_axis;
kn_axis kn_bezier_axis(const kn_bezier *b, int var);

#endif
