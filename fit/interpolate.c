// SPDX-License-Identifier: Apache-2.0
// Tensor-product interpolation: (A_0 x A_1 x ..) c = f is solved by one banded system for each variable.
#include "fit/internal.h"
#include "kernel/banded.h"
#include "kernel/context.h"
#include "spline/internal.h"

static kn_status solve_axis(kn_ctx *ctx, kn_spline *s, int var, const double *sites)
{
    kn_fit_axis axis = {var, s->degree[var], s->count[var], s->knots[var], s->count[var], sites};
    kn_collocation c = {.count = axis.count, .degree = axis.degree};
    int *span = kn_scratch(ctx, (size_t)axis.count, sizeof *span);
    c.band = kn_scratch(ctx, kn_collocation_room(c.count, c.degree), sizeof *c.band);
    if (!span || !c.band) return KN_ENOMEM;
    kn_status status = kn_fit_spans(ctx, "fit_interpolate", span, &axis);
    for (int i = 0; i < axis.count && status == KN_OK; i++)
        if (!kn_fit_acts(&axis, i, sites[i]))
            status = kn_fail(ctx, KN_EUNDEFINED,
                             "fit_interpolate: variable %d: site %d, %g, is outside B-spline %d "
                             "on [%g, %g]",
                             var, i, sites[i], i, axis.knots[i], axis.knots[i + axis.degree + 1]);
    if (status != KN_OK) return status;
    kn_collocation_factor(&c, axis.knots, sites, span);
    if (!kn_collocation_regular(&c))
        return kn_fail(ctx, KN_EUNDECIDED,
                       "fit_interpolate: variable %d: singular to working precision, or by underflow", var);
    kn_collocation_solve(&c, s->coef, kn_spline_outer(s, var), kn_spline_inner(s, var));
    return KN_OK;
}

kn_status kn_fit_interpolate(kn_ctx *ctx, kn_spline *out, int nvars, int dim, const int *degree, const int *count,
                             const double *const *knots, const double *const *sites, const double *values)
{
    kn_spline s;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_fit_start(ctx, "fit_interpolate", &s, nvars, dim, degree, count, knots);
    if (status == KN_OK) kn_fit_by_component(s.coef, values, kn_spline_count(&s), dim);
    for (int d = 0; d < nvars && status == KN_OK; d++) {
        kn_mark axis = kn_scratch_mark(ctx);
        status = solve_axis(ctx, &s, d, sites[d]);
        kn_scratch_release(ctx, axis);
    }
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    kn_scratch_release(ctx, mark);
    return status;
}
