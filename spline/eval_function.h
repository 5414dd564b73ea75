// SPDX-License-Identifier: Apache-2.0
// A spline as the kernel's evaluation sees it.
#ifndef SPLINE_EVAL_FUNCTION_H
#define SPLINE_EVAL_FUNCTION_H

#include "kernel/eval.h"
#include "spline/internal.h"

// f points into knots (KN_MAX_VARS of them) and s.
static inline void kn_spline_as_function(kn_eval_function *f, const double **knots, const kn_spline *s)
{
    for (int d = 0; d < s->nvars; d++) knots[d] = s->knots[d];
    *f = (kn_eval_function){.nvars = s->nvars,
                            .ncomp = s->ncomp,
                            .rational = s->rational,
                            .degree = s->degree,
                            .count = s->count,
                            .knots = knots,
                            .coef = s->coef};
}

#endif
