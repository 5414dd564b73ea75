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
// ---- where results live: how an operation allocates nothing in the steady state ----
// out's array is used again whenever out has as many coefficients (all components together) as the result. Two ways,
// both between kn_scratch_mark and kn_scratch_release, both leaving out as it was when they fail:
//
// 1. Temporary pieces in scratch, the result copied last. Good for everything; nothing is cleared:
//        kn_bezier c = {.nvars = .., .ncomp = .., .rational = .., .degree = ..};
//        status = kn_bezier_scratch(ctx, &c, "what");           // room for c.coef
//        ... fill c.coef; anything may fail ...
//        if (status == KN_OK) status = kn_bezier_store(ctx, out, &c);
// 2. Straight into place, for kernels that a copy would slow down. Take all else that may fail first: from
//    kn_bezier_begin on nothing does, for c.coef may be out's own array.
//        status = kn_bezier_begin(ctx, &c, out, kn_bezier_is(out, a) || kn_bezier_is(out, b), "what");
//        if (status != KN_OK) ... nothing to undo ...
//        ... fill c.coef from a and b, which are not written to yet ...
//        kn_bezier_end(ctx, out, &c);

// c->coef = scratch, not cleared, for the shape that c has, after kn_bezier_check.
kn_status kn_bezier_scratch(kn_ctx *ctx, kn_bezier *c, const char *what);
// out = c, wherever c lives (no check of its shape); an empty c makes out empty.
kn_status kn_bezier_store(kn_ctx *ctx, kn_bezier *out, const kn_bezier *c);
// Whether out is the operand a: they share their coefficients.
static inline bool kn_bezier_is(const kn_bezier *out, const kn_bezier *a)
{
    return out->coef == a->coef;
}
// Room for the shape that c has, after kn_bezier_check: out's own array if it fits and out is no operand, scratch if
// it fits and out is one, else a new array.
kn_status kn_bezier_begin(kn_ctx *ctx, kn_bezier *c, const kn_bezier *out, bool is_operand, const char *what);
// The same for a shape that kn_bezier_check has accepted.
kn_status kn_bezier_begin_checked(kn_ctx *ctx, kn_bezier *c, const kn_bezier *out, bool is_operand);
// out becomes c, which kn_bezier_begin has made for it.
void kn_bezier_end(kn_ctx *ctx, kn_bezier *out, kn_bezier *c);

// As the end of an operation whose result was allocated (kn_bezier_alloc): on KN_OK out becomes *result and out's old
// coefficients are freed; otherwise result's are. Answers status.
kn_status kn_bezier_finish(kn_ctx *ctx, kn_bezier *out, kn_bezier *result, kn_status status);
// KN_EDOMAIN (recorded) unless 0 <= var < nvars.
kn_status kn_bezier_check_var(kn_ctx *ctx, const char *what, const kn_bezier *b, int var);
// The coefficients of one component.
static inline double *kn_bezier_comp(const kn_bezier *b, int comp)
{
    return b->coef + (size_t)comp * kn_bezier_count(b);
}

// The ncomp homogeneous values at a point, plainly. work: ncomp * count / (last degree + 1) numbers, the
// values first.
void kn_bezier_eval_plain(double *work, const kn_bezier *b, const double *at);

// b seen along variable var: (outer, degree[var] + 1, inner) with the components part of outer.
typedef struct kn_axis {
    size_t outer, inner;
} kn_axis;
kn_axis kn_bezier_axis(const kn_bezier *b, int var);

#endif
