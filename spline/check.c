// SPDX-License-Identifier: Apache-2.0
// Whether a spline keeps the rules of its type.
#include <math.h>

#include "spline/internal.h"
#include "kernel/context.h"

kn_status kn_spline_check(kn_ctx *ctx, const kn_spline *s)
{
    if (s->nvars == 0 && !s->coef) return KN_OK;
    kn_status status = kn_spline_shape(ctx, "spline", s->nvars, s->ncomp, s->rational, s->degree, s->count);
    if (status != KN_OK) return status;
    if (!s->coef) return kn_fail(ctx, KN_EDOMAIN, "spline: no coefficients");
    for (int d = 0; d < s->nvars; d++) {
        const char *fault = s->knots[d] ? kn_knots_fault(s->knots[d], s->degree[d], s->count[d]) : "no knots";
        if (fault) return kn_fail(ctx, KN_EDOMAIN, "spline: variable %d: %s", d, fault);
    }
    size_t n = kn_spline_count(s), weights = s->rational ? n * (size_t)(s->ncomp - 1) : n * (size_t)s->ncomp;
    for (size_t i = 0; i < n * (size_t)s->ncomp; i++) {
        if (!isfinite(s->coef[i]))
            return kn_fail(ctx, KN_EDOMAIN, "spline: control point %zu: component %zu is %g", i % n, i / n,
                           s->coef[i]);
        if (i >= weights && s->coef[i] <= 0.0)
            return kn_fail(ctx, KN_EDOMAIN, "spline: control point %zu: weight %g", i % n, s->coef[i]);
    }
    return KN_OK;
}
