// SPDX-License-Identifier: Apache-2.0
// A spline seen along one variable, and back.
#include <string.h>

#include "spline/removal.h"
#include "kernel/context.h"

kn_status kn_spline_expect_tolerance(kn_ctx *ctx, const char *call, double tolerance)
{
    return tolerance >= 0.0 ? KN_OK : kn_fail(ctx, KN_EDOMAIN, "%s: tolerance %g", call, tolerance);
}

// Between (components, pre, count, inner) and (count, pre, inner, components).
static void turn(double *rows, double *coef, size_t ncomp, size_t pre, size_t count, size_t inner, bool back)
{
    for (size_t c = 0; c < ncomp; c++)
        for (size_t o = 0; o < pre; o++)
            for (size_t i = 0; i < count; i++)
                for (size_t q = 0; q < inner; q++) {
                    double *a = rows + ((i * pre + o) * inner + q) * ncomp + c;
                    double *b = coef + ((c * pre + o) * count + i) * inner + q;
                    if (back)
                        *b = *a;
                    else
                        *a = *b;
                }
}

kn_status kn_rows_of(kn_ctx *ctx, kn_rows *rows, const kn_spline *s, int var)
{
    size_t inner = kn_spline_inner(s, var), pre = kn_spline_outer(s, var) / (size_t)s->ncomp;
    size_t nknots = (size_t)s->count[var] + (size_t)s->degree[var] + 1, count = (size_t)s->count[var];
    *rows = (kn_rows){.count = s->count[var], .degree = s->degree[var], .ncomp = s->ncomp, .rational = s->rational};
    rows->lines = pre * inner;
    rows->knots = kn_scratch(ctx, nknots, sizeof *rows->knots);
    rows->row = kn_scratch(ctx, count * rows->lines * (size_t)s->ncomp, sizeof *rows->row);
    if (!rows->knots || !rows->row) return KN_ENOMEM;
    memcpy(rows->knots, s->knots[var], nknots * sizeof *rows->knots);
    turn(rows->row, s->coef, (size_t)s->ncomp, pre, count, inner, false);
    return KN_OK;
}

kn_status kn_rows_to(kn_ctx *ctx, kn_spline *s, int var, const kn_rows *rows)
{
    size_t inner = kn_spline_inner(s, var), pre = kn_spline_outer(s, var) / (size_t)s->ncomp;
    double *coef = kn_scratch(ctx, (size_t)rows->count * rows->lines * (size_t)rows->ncomp, sizeof *coef);
    if (!coef) return KN_ENOMEM;
    turn(rows->row, coef, (size_t)s->ncomp, pre, (size_t)rows->count, inner, true);
    s->count[var] = rows->count, s->degree[var] = rows->degree;
    s->knots[var] = rows->knots, s->coef = coef;
    return KN_OK;
}
