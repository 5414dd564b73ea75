// SPDX-License-Identifier: Apache-2.0
// The value of a spline at one point.
#include "spline/internal.h"
#include "kernel/context.h"

// sum over the control points that act at a point; the last variable first. basis[d] has degree[d] + 1 values.
static double contract(const kn_spline *s, double (*basis)[KN_MAX_DEGREE + 1], const double *coef, size_t inner,
                       int d)
{
    double sum = 0.0;
    for (int i = 0; i <= s->degree[d]; i++) {
        const double *c = coef + (size_t)i * inner;
        double value = d + 1 < s->nvars ? contract(s, basis, c, inner / (size_t)s->count[d + 1], d + 1) : *c;
        sum += basis[d][i] * value;
    }
    return sum;
}

kn_status kn_spline_eval(kn_ctx *ctx, double *out, const kn_spline *s, const double *at)
{
    kn_status status = kn_spline_expect(ctx, "spline_eval", s, 0);
    if (status != KN_OK) return status;

    double basis[KN_MAX_VARS][KN_MAX_DEGREE + 1], value[KN_MAX_COMPS];
    size_t n = kn_spline_count(s), first = 0;
    for (int d = 0; d < s->nvars; d++) {
        int span = kn_knots_span(s->knots[d], s->degree[d], s->count[d], at[d]);
        kn_knots_basis(basis[d], s->knots[d], s->degree[d], span, at[d], 0);
        first = first * (size_t)s->count[d] + (size_t)(span - s->degree[d]);
    }
    for (int c = 0; c < s->ncomp; c++)
        value[c] = contract(s, basis, s->coef + (size_t)c * n + first, n / (size_t)s->count[0], 0);

    int dim = kn_spline_dim(s);
    if (s->rational && value[dim] == 0.0) return kn_fail(ctx, KN_EUNDEFINED, "spline_eval: the weight is zero");
    for (int c = 0; c < dim; c++) out[c] = s->rational ? value[c] / value[dim] : value[c];
    return KN_OK;
}
