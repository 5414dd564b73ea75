// SPDX-License-Identifier: Apache-2.0
// All partial derivatives of a spline at one point.
#include "spline/internal.h"
#include "kernel/context.h"
#include "kernel/multi_index.h"

// sum over the control points that act at a point; the last variable first. basis[d] has degree[d] + 1 values.
static double contract(const kn_spline *s, const double *const *basis, const double *coef, size_t inner, int d)
{
    double sum = 0.0;
    for (int i = 0; i <= s->degree[d]; i++) {
        const double *c = coef + (size_t)i * inner;
        sum += basis[d][i] * (d + 1 < s->nvars ? contract(s, basis, c, inner / (size_t)s->count[d + 1], d + 1) : *c);
    }
    return sum;
}

// values[place * ncomp + c]: derivatives of each component. tables[d] from kn_knots_basis; first: of the local array.
static void derive_components(double *values, const kn_spline *s, double *const *tables, size_t first, int n)
{
    int a[KN_MAX_VARS] = {0};
    size_t all = kn_spline_count(s);
    for (int place = 0; place < n; place++) {
        const double *basis[KN_MAX_VARS];
        for (int d = 0; d < s->nvars; d++) basis[d] = tables[d] + a[d] * (s->degree[d] + 1);
        for (int c = 0; c < s->ncomp; c++)
            values[(size_t)place * (size_t)s->ncomp + (size_t)c] = contract(
                s, basis, s->coef + (size_t)c * all + first, all / (size_t)s->count[0], 0);
        kn_multi_index_next(s->nvars, a);
    }
}

static kn_status check(kn_ctx *ctx, const kn_spline *s, int order)
{
    kn_status status = kn_spline_expect(ctx, "spline_derivatives", s, 0);
    if (status != KN_OK) return status;
    if (order < 0) return kn_fail(ctx, KN_EDOMAIN, "spline_derivatives: order %d", order);
    if (order > KN_MAX_DEGREE || kn_derivative_count(s->nvars, order) == 0)
        return kn_fail(ctx, KN_ELIMIT, "spline_derivatives: order %d of %d variables", order, s->nvars);
    return KN_OK;
}

kn_status kn_spline_derivatives(kn_ctx *ctx, double *out, const kn_spline *s, const double *at, int order)
{
    kn_status status = check(ctx, s, order);
    if (status != KN_OK) return status;

    int n = kn_derivative_count(s->nvars, order);
    kn_mark mark = kn_scratch_mark(ctx);
    double *tables[KN_MAX_VARS], *values = out;
    size_t first = 0;
    for (int d = 0; d < s->nvars && status == KN_OK; d++) {
        int p = s->degree[d], span = kn_knots_span(s->knots[d], p, s->count[d], at[d]);
        tables[d] = kn_scratch(ctx, (size_t)(order + 1) * (size_t)(p + 1), sizeof *tables[d]);
        if (tables[d])
            kn_knots_basis(tables[d], s->knots[d], p, span, at[d], order);
        else
            status = KN_ENOMEM;
        first = first * (size_t)s->count[d] + (size_t)(span - p);
    }
    if (status == KN_OK && s->rational) {
        values = kn_scratch(ctx, (size_t)n * (size_t)s->ncomp, sizeof *values);
        if (!values) status = KN_ENOMEM;
    }
    if (status == KN_OK) derive_components(values, s, tables, first, n);
    if (status == KN_OK && s->rational) {
        if (values[s->ncomp - 1] == 0.0)
            status = kn_fail(ctx, KN_EUNDEFINED, "spline_derivatives: the weight is zero");
        else
            kn_quotient_derivatives(out, values, s->nvars, s->ncomp - 1, order);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
