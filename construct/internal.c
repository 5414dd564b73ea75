// SPDX-License-Identifier: Apache-2.0
// Operands of constructors: weights added, grids united, variables appended.
#include "construct/internal.h"

#include <math.h>
#include <string.h>

#include "kernel/context.h"
#include "spline/in_scratch.h"

kn_status kn_construct_finite(kn_ctx *ctx, const char *call, const double *x, int n)
{
    for (int i = 0; i < n; i++)
        if (!isfinite(x[i])) return kn_fail(ctx, KN_EDOMAIN, "%s: a number is %g", call, x[i]);
    return KN_OK;
}

kn_status kn_construct_operand(kn_ctx *ctx, const char *call, kn_spline *to, const kn_spline *a, bool rational)
{
    kn_status status = kn_spline_expect(ctx, call, a, 0);
    *to = *a;
    if (status != KN_OK || a->rational || !rational) return status;
    to->ncomp++, to->rational = true;
    status = kn_spline_in_scratch(ctx, call, to);
    if (status != KN_OK) return status;
    size_t n = kn_spline_count(a), dim = (size_t)a->ncomp;
    for (int d = 0; d < a->nvars; d++)
        memcpy(to->knots[d], a->knots[d], (size_t)(a->count[d] + a->degree[d] + 1) * sizeof *to->knots[d]);
    memcpy(to->coef, a->coef, n * dim * sizeof *to->coef);
    for (size_t i = 0; i < n; i++) to->coef[n * dim + i] = 1.0;
    return KN_OK;
}

kn_status kn_construct_unite(kn_ctx *ctx, const char *call, kn_spline *s, const int *var, int n, int least)
{
    double lo, hi, a, b;
    kn_spline_domain(&s[0], var[0], &lo, &hi);
    for (int i = 0; i < n; i++) {
        kn_spline_domain(&s[i], var[i], &a, &b);
        if (a != lo || b != hi)
            return kn_fail(ctx, KN_EDOMAIN, "%s: domains [%g, %g] and [%g, %g]", call, lo, hi, a, b);
    }
    return kn_spline_unite_all_in_scratch(ctx, s, var, n, least);
}

kn_status kn_construct_compatible(kn_ctx *ctx, const char *call, kn_spline *s, const kn_spline *list, int n)
{
    bool rational = false;
    int *var = kn_scratch(ctx, (size_t)n, sizeof *var);
    if (!var) return KN_ENOMEM;
    for (int i = 0; i < n; i++) rational = rational || list[i].rational;
    kn_status status = KN_OK;
    for (int i = 0; i < n && status == KN_OK; i++) {
        status = kn_construct_operand(ctx, call, &s[i], &list[i], rational);
        if (status == KN_OK && (s[i].nvars != s[0].nvars || s[i].ncomp != s[0].ncomp))
            status = kn_fail(ctx, KN_EDOMAIN, "%s: %d and %d variables, dimensions %d and %d", call, s[0].nvars,
                             s[i].nvars, kn_spline_dim(&s[0]), kn_spline_dim(&s[i]));
    }
    for (int d = s[0].nvars - 1; status == KN_OK && d >= 0; d--) { // in the order of kn_spline_make_compatible
        for (int i = 0; i < n; i++) var[i] = d;
        status = kn_construct_unite(ctx, call, s, var, n, 0);
    }
    return status;
}

kn_status kn_construct_extend(kn_ctx *ctx, const char *call, kn_spline *to, const kn_spline *a, int degree, int count)
{
    if (a->nvars == KN_MAX_VARS) return kn_fail(ctx, KN_ELIMIT, "%s: %d variables", call, a->nvars + 1);
    *to = (kn_spline){.nvars = a->nvars + 1, .ncomp = a->ncomp, .rational = a->rational};
    for (int d = 0; d < a->nvars; d++) to->degree[d] = a->degree[d], to->count[d] = a->count[d];
    to->degree[a->nvars] = degree, to->count[a->nvars] = count;
    kn_status status = kn_spline_in_scratch(ctx, call, to);
    for (int d = 0; d < a->nvars && status == KN_OK; d++)
        memcpy(to->knots[d], a->knots[d], (size_t)(a->count[d] + a->degree[d] + 1) * sizeof *to->knots[d]);
    return status;
}

kn_status kn_construct_check_weights(kn_ctx *ctx, const char *call, const kn_spline *s)
{
    size_t n = kn_spline_count(s);
    for (size_t i = 0; i < n && s->rational; i++) {
        double w = s->coef[n * (size_t)(s->ncomp - 1) + i];
        if (!(w > 0.0))
            return kn_fail(ctx, KN_EUNDEFINED, "%s: control point %zu would get the weight %g", call, i, w);
    }
    return KN_OK;
}
