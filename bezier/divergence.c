// SPDX-License-Identifier: Apache-2.0
// The divergence of a vector field.
#include "bezier/combine.h"
#include "bezier/gradient.h"

#include <string.h>

// to = sum_v d_v a_v. work: as large.
static void sum_partials(double *to, double *work, const kn_bezier *a, const double *size)
{
    size_t count = kn_bezier_count(a);
    kn_bezier_partial(to, a, 0, 0, size);
    for (int v = 1; v < a->nvars; v++) {
        kn_bezier_partial(work, a, v, v, size);
        for (size_t i = 0; i < count; i++) to[i] += work[i];
    }
}

// div (N/w) = (div N w - sum_v N_v d_v w) / w^2: products with N and w of one piece that holds div N, d_v w and w.
static kn_status quotient_rule(kn_ctx *ctx, const char *what, kn_bezier *out, const kn_bezier *a, const double *size)
{
    int dim = kn_bezier_dim(a), n = 0;
    size_t count = kn_bezier_count(a);
    kn_term terms[KN_MAX_VARS + 2];
    kn_bezier g = *a, c = {.nvars = a->nvars, .ncomp = 2, .rational = true};
    g.rational = false, g.ncomp = dim + 2;
    kn_mark mark = kn_scratch_mark(ctx);
    g.coef = kn_scratch(ctx, (size_t)g.ncomp * count, sizeof *g.coef);
    kn_status status = g.coef ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        sum_partials(g.coef, kn_bezier_comp(&g, 1), a, size);
        memcpy(kn_bezier_comp(&g, dim + 1), kn_bezier_comp(a, dim), count * sizeof *g.coef);
        terms[n++] = (kn_term){0, 0, dim, 1.0};
        terms[n++] = (kn_term){1, dim + 1, dim, 1.0};
        for (int v = 0; v < dim; v++) {
            kn_bezier_partial(kn_bezier_comp(&g, 1 + v), a, dim, v, size);
            terms[n++] = (kn_term){0, 1 + v, v, -1.0};
        }
        status = kn_bezier_combine(ctx, what, out, &c, &g, a, terms, n);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status polynomial(kn_ctx *ctx, const char *what, kn_bezier *out, const kn_bezier *a, const double *size)
{
    kn_bezier c = *a;
    c.ncomp = 1;
    kn_mark mark = kn_scratch_mark(ctx);
    double *work = kn_scratch(ctx, kn_bezier_count(a), sizeof *work);
    kn_status status = work ? kn_bezier_begin(ctx, &c, out, kn_bezier_is(out, a), what) : KN_ENOMEM;
    if (status == KN_OK) {
        sum_partials(c.coef, work, a, size);
        kn_bezier_end(ctx, out, &c);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_bezier_divergence_over(kn_ctx *ctx, const char *what, kn_bezier *out, const kn_bezier *a,
                                    const double *size)
{
    kn_status status = kn_bezier_check_operand(ctx, what, a);
    if (status != KN_OK) return status;
    if (kn_bezier_dim(a) != a->nvars)
        return kn_fail(ctx, KN_EDOMAIN, "%s: %d components over %d variables", what, kn_bezier_dim(a), a->nvars);
    return a->rational ? quotient_rule(ctx, what, out, a, size) : polynomial(ctx, what, out, a, size);
}

kn_status kn_bezier_divergence(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a)
{
    return kn_bezier_divergence_over(ctx, "divergence", out, a, NULL);
}
