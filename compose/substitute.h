// SPDX-License-Identifier: Apache-2.0
// One variable replaced by a univariate function: a linear map along one axis.
#ifndef COMPOSE_SUBSTITUTE_H
#define COMPOSE_SUBSTITUTE_H

#include "kernel/context.h"

#include <knurl/bezier.h>

// What replaces a variable of degree p by g = X/w, univariate of degree m, on the span [lo,hi] of it. Scaled: row k
// is to be divided by C(p m, k).
typedef struct kn_substitution {
    int p, rows; // rows = p m + 1
    // (rows, p + 1): column i is C(p,i) x^i s^(p-i), x = (X - lo w)/(hi - lo), s = (hi w - X)/(hi - lo)
    double *matrix;
    double *weight; // w^p, for a rational g
} kn_substitution;

// In scratch memory.
kn_status kn_substitution_init(kn_ctx *ctx, kn_substitution *out, int p, const kn_bezier *g, double lo, double hi);
// out (rows, inner) = in (p + 1, inner) with the variable replaced.
void kn_substitution_apply(double *out, const double *in, size_t inner, const kn_substitution *map);
// out (rows, inner) = the weight that a polynomial gets: equal along inner.
void kn_substitution_weight(double *out, size_t inner, const kn_substitution *map);
// KN_OK when g is a function of one variable and one value and p times its degree is allowed.
kn_status kn_substitution_check(kn_ctx *ctx, const char *call, int p, int nvars, int dim, int degree);

#endif
