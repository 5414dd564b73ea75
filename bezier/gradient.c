// SPDX-License-Identifier: Apache-2.0
// All first partial derivatives in one piece.
#include "bezier/gradient.h"
#include "bezier/combine.h"
#include "kernel/bernstein.h"
#include "kernel/calculus.h"

#include <string.h>

void kn_bezier_partial(double *to, const kn_bezier *a, int comp, int var, const double *size)
{
    size_t outer = kn_bernstein_count(var, a->degree), n = kn_bezier_count(a);
    kn_bernstein_partial(to, kn_bezier_comp(a, comp), outer, a->degree[var], kn_bezier_axis(a, var).inner);
    for (size_t i = 0; size && i < n; i++) to[i] /= size[var];
}

// d_v (N/w) = (d_v N w - N d_v w) / w^2: products with N and w of one piece that holds d_v N, d_v w and w.
static kn_status quotient_rule(kn_ctx *ctx, const char *what, kn_bezier *out, const kn_bezier *a, const double *size)
{
    int dim = kn_bezier_dim(a), nvars = a->nvars, n = 0;
    size_t count = kn_bezier_count(a);
    kn_term terms[KN_MAX_TERMS];
    kn_bezier c = {.nvars = nvars, .ncomp = dim * nvars + 1, .rational = true};
    kn_bezier g = *a; // may have more components than a piece of the interface
    g.rational = false, g.ncomp = a->ncomp * nvars + 1;
    kn_mark mark = kn_scratch_mark(ctx);
    g.coef = kn_scratch(ctx, (size_t)g.ncomp * count, sizeof *g.coef);
    kn_status status = g.coef ? KN_OK : KN_ENOMEM;
    for (int v = 0; v < nvars && status == KN_OK; v++)
        for (int i = 0; i <= dim; i++) {
            kn_bezier_partial(kn_bezier_comp(&g, i * nvars + v), a, i, v, size);
            if (i == dim) continue;
            terms[n++] = (kn_term){i * nvars + v, i * nvars + v, dim, 1.0};
            terms[n++] = (kn_term){i * nvars + v, dim * nvars + v, i, -1.0};
        }
    if (status == KN_OK) {
        memcpy(kn_bezier_comp(&g, g.ncomp - 1), kn_bezier_comp(a, dim), count * sizeof *g.coef);
        terms[n++] = (kn_term){dim * nvars, g.ncomp - 1, dim, 1.0};
        status = kn_bezier_combine(ctx, what, out, &c, &g, a, terms, n);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_bezier_gradient_over(kn_ctx *ctx, const char *what, kn_bezier *out, const kn_bezier *a,
                                  const double *size)
{
    kn_status status = kn_bezier_check_operand(ctx, what, a);
    if (status == KN_OK) status = kn_bezier_check_var(ctx, what, a, 0); // a constant has no gradient
    if (status != KN_OK) return status;
    int dim = kn_bezier_dim(a);
    kn_bezier c = *a;
    c.ncomp = dim * a->nvars + a->rational;
    if (c.ncomp > KN_MAX_COMPS) return kn_fail(ctx, KN_ELIMIT, "%s: %d components", what, c.ncomp);
    if (a->rational) return quotient_rule(ctx, what, out, a, size);
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_bezier_begin(ctx, &c, out, kn_bezier_is(out, a), what);
    if (status == KN_OK) {
        for (int i = 0; i < c.ncomp; i++)
            kn_bezier_partial(kn_bezier_comp(&c, i), a, i / a->nvars, i % a->nvars, size);
        kn_bezier_end(ctx, out, &c);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_bezier_gradient(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a)
{
    return kn_bezier_gradient_over(ctx, "gradient", out, a, NULL);
}
