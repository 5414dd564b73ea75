// SPDX-License-Identifier: Apache-2.0
// The partial derivative of a spline as a spline.
#include "spline/calculus.h"
#include "kernel/context.h"

static kn_status rational_piece(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const double *size, const void *user)
{
    int var = *(const int *)user;
    kn_status status = kn_bezier_derivative(ctx, out, a, var);
    size_t n = kn_bezier_count(out) * (size_t)kn_bezier_dim(out);
    for (size_t i = 0; i < n && status == KN_OK; i++) out->coef[i] /= size[var];
    return status;
}

// Coefficients p (c_i+1 - c_i) / (t_i+p+1 - t_i+1) on the same knots, those of multiplicity p + 1 once less: where a
// whole interval is empty (a jump) there is no such coefficient. The knots too are written; the count is the result.
static int difference_knots(double *to, const double *knots, int degree, int count)
{
    int rows = 0;
    for (int i = 0; i + 1 < count; i++)
        if (knots[i + degree + 1] > knots[i + 1]) to[rows++] = knots[i + 1];
    for (int k = 0; k < degree; k++) to[rows + k] = knots[count];
    return rows;
}

// Differences come first: what neighbours have in common is gone before anything is rounded much.
static void difference(double *to, const double *from, const double *knots, int p, int count, size_t outer,
                       size_t inner)
{
    for (size_t o = 0; o < outer; o++, from += inner) // the last row has no successor
        for (int i = 0; i + 1 < count; i++, from += inner) {
            double length = knots[i + p + 1] - knots[i + 1];
            if (!(length > 0.0)) continue;
            for (size_t j = 0; j < inner; j++) to[j] = p * (from[inner + j] - from[j]) / length;
            to += inner;
        }
}

kn_status kn_spline_differentiate_in_scratch(kn_ctx *ctx, kn_spline *s, int var)
{
    int p = s->degree[var], count = s->count[var];
    double *knots = kn_scratch(ctx, (size_t)count + (size_t)p, sizeof *knots);
    if (!knots) return KN_ENOMEM;
    kn_spline to = *s;
    to.degree[var]--;
    to.knots[var] = knots;
    to.count[var] = difference_knots(knots, s->knots[var], p, count);
    to.coef = kn_scratch(ctx, kn_spline_count(&to) * (size_t)s->ncomp, sizeof *to.coef);
    if (!to.coef) return KN_ENOMEM;
    difference(to.coef, s->coef, s->knots[var], p, count, kn_spline_outer(s, var), kn_spline_inner(s, var));
    *s = to;
    return KN_OK;
}

kn_status kn_spline_derivative(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int var)
{
    kn_status status = kn_spline_expect(ctx, "spline_derivative", a, var);
    if (status != KN_OK) return status;
    if (a->rational) {
        kn_bezier shape = {.nvars = a->nvars, .ncomp = a->ncomp, .rational = true};
        for (int d = 0; d < a->nvars; d++) shape.degree[d] = (a->degree[var] > 0 ? 2 : 1) * a->degree[d];
        return kn_spline_by_pieces(ctx, "spline_derivative", out, a, &shape, rational_piece, &var, var);
    }

    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline s = *a;
    if (a->degree[var] > 0) {
        status = kn_spline_differentiate_in_scratch(ctx, &s, var);
    } else { // constant on each span
        size_t n = kn_spline_count(a) * (size_t)a->ncomp;
        s.coef = kn_scratch(ctx, n, sizeof *s.coef);
        if (!s.coef) status = KN_ENOMEM;
        for (size_t i = 0; i < n && s.coef; i++) s.coef[i] = 0.0;
    }
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    kn_scratch_release(ctx, mark);
    return status;
}
