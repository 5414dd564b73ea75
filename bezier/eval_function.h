// SPDX-License-Identifier: Apache-2.0
// A piece as the kernel's evaluation sees it.
#ifndef BEZIER_EVAL_FUNCTION_H
#define BEZIER_EVAL_FUNCTION_H

#include "bezier/shape.h"
#include "kernel/eval.h"

// f points into the rest and into the piece: it is not to be copied.
typedef struct kn_bezier_function {
    kn_eval_function f;
    int degree[KN_MAX_VARS], count[KN_MAX_VARS];
    const double *unit[KN_MAX_VARS]; // no knots: over [0,1]
} kn_bezier_function;

// b has variables.
static inline void kn_bezier_as_function(kn_bezier_function *to, const kn_bezier *b)
{
    *to = (kn_bezier_function){.f = {.nvars = b->nvars, .ncomp = b->ncomp, .rational = b->rational}};
    for (int d = 0; d < b->nvars; d++) to->degree[d] = b->degree[d], to->count[d] = b->degree[d] + 1;
    to->f.degree = to->degree, to->f.count = to->count, to->f.knots = to->unit, to->f.coef = b->coef;
}

#endif
