// SPDX-License-Identifier: Apache-2.0
// The derivative as a piece.
#include "bezier/combine.h"
#include "kernel/bernstein.h"

#include <string.h>

// The derivative of every component, the weight's too, as a polynomial piece.
static kn_status differentiate(kn_ctx *ctx, kn_bezier *c, const kn_bezier *a, int var)
{
    *c = *a;
    c->rational = false;
    c->degree[var] = a->degree[var] > 0 ? a->degree[var] - 1 : 0;
    kn_status status = kn_bezier_alloc(ctx, c, "derivative");
    kn_axis x = kn_bezier_axis(a, var);
    if (status == KN_OK) kn_bernstein_differentiate(c->coef, a->coef, x.outer, a->degree[var], x.inner);
    return status;
}

// (N/w)' = (N' w - w' N) / w^2. w^2 has one degree more in the variable than the numerator, which is raised.
static kn_status quotient_rule(kn_ctx *ctx, kn_bezier *c, const kn_bezier *a, int var)
{
    int dim = kn_bezier_dim(a), n = 0;
    kn_term terms[KN_MAX_TERMS], square = {0, dim, dim, 1.0};
    kn_bezier da = {0}, numerator = {.nvars = a->nvars, .ncomp = dim}, w2 = {.nvars = a->nvars, .ncomp = 1};
    for (int i = 0; i < dim; i++) {
        terms[n++] = (kn_term){i, i, dim, 1.0};
        terms[n++] = (kn_term){i, dim, i, -1.0};
    }
    *c = (kn_bezier){.nvars = a->nvars, .ncomp = a->ncomp, .rational = true};
    for (int d = 0; d < a->nvars; d++) c->degree[d] = 2 * a->degree[d];
    kn_status status = kn_bezier_alloc(ctx, c, "derivative");
    if (status == KN_OK) status = differentiate(ctx, &da, a, var);
    if (status == KN_OK) status = kn_bezier_combine(ctx, "derivative", &numerator, &da, a, terms, n);
    if (status == KN_OK) status = kn_bezier_combine(ctx, "derivative", &w2, a, a, &square, 1);
    if (status == KN_OK) {
        kn_axis x = kn_bezier_axis(&numerator, var);
        kn_bernstein_elevate(c->coef, numerator.coef, x.outer, numerator.degree[var], c->degree[var], x.inner);
        memcpy(kn_bezier_comp(c, dim), w2.coef, kn_bezier_count(&w2) * sizeof *w2.coef);
    }
    kn_bezier_clear(ctx, &da);
    kn_bezier_clear(ctx, &numerator);
    kn_bezier_clear(ctx, &w2);
    return status;
}

kn_status kn_bezier_derivative(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int var)
{
    kn_bezier c = {0};
    kn_status status = kn_bezier_check_operand(ctx, "derivative", a);
    if (status == KN_OK) status = kn_bezier_check_var(ctx, "derivative", a, var);
    if (status != KN_OK) return status;
    if (!a->rational)
        status = differentiate(ctx, &c, a, var);
    else if (a->degree[var] > 0)
        status = quotient_rule(ctx, &c, a, var);
    else // constant in this variable: 0/w
        status = kn_bezier_scale(ctx, &c, a, 0.0);
    return kn_bezier_finish(ctx, out, &c, status);
}
