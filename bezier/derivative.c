// SPDX-License-Identifier: Apache-2.0
// The derivative as a piece.
#include "bezier/combine.h"
#include "bezier/gradient.h"
#include "kernel/bernstein.h"

#include <string.h>

static kn_status differentiate(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int var)
{
    kn_bezier c = *a;
    c.degree[var] = a->degree[var] > 0 ? a->degree[var] - 1 : 0;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_bezier_begin(ctx, &c, out, kn_bezier_is(out, a), "derivative");
    if (status == KN_OK) {
        kn_axis x = kn_bezier_axis(a, var);
        kn_bernstein_differentiate(c.coef, a->coef, x.outer, a->degree[var], x.inner);
        kn_bezier_end(ctx, out, &c);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// (N/w)' = (N' w - w' N) / w^2, N' and w' at the degrees of N and w, so that both parts have the same degrees:
// products with N and w of one piece that holds N', w' and w.
static kn_status quotient_rule(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int var)
{
    int dim = kn_bezier_dim(a), n = 0;
    kn_term terms[KN_MAX_TERMS];
    kn_bezier g = *a, c = {.nvars = a->nvars, .ncomp = a->ncomp, .rational = true};
    g.rational = false, g.ncomp = dim + 2;
    kn_mark mark = kn_scratch_mark(ctx);
    g.coef = kn_scratch(ctx, (size_t)g.ncomp * kn_bezier_count(a), sizeof *g.coef);
    kn_status status = g.coef ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        for (int i = 0; i <= dim; i++) kn_bezier_partial(kn_bezier_comp(&g, i), a, i, var, NULL);
        memcpy(kn_bezier_comp(&g, dim + 1), kn_bezier_comp(a, dim), kn_bezier_count(a) * sizeof *g.coef);
        for (int i = 0; i < dim; i++) {
            terms[n++] = (kn_term){i, i, dim, 1.0};
            terms[n++] = (kn_term){i, dim, i, -1.0};
        }
        terms[n++] = (kn_term){dim, dim + 1, dim, 1.0};
        status = kn_bezier_combine(ctx, "derivative", out, &c, &g, a, terms, n);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_bezier_derivative(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int var)
{
    kn_status status = kn_bezier_check_operand(ctx, "derivative", a);
    if (status == KN_OK) status = kn_bezier_check_var(ctx, "derivative", a, var);
    if (status != KN_OK) return status;
    if (!a->rational) return differentiate(ctx, out, a, var);
    if (a->degree[var] == 0) return kn_bezier_scale(ctx, out, a, 0.0); // constant in this variable: 0/w
    return quotient_rule(ctx, out, a, var);
}
