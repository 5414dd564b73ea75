// SPDX-License-Identifier: Apache-2.0
// Bounds of the first partial derivatives.
#include "bezier/bounds.h"
#include "bezier/combine.h"
#include "bezier/gradient.h"
#include "kernel/bernstein.h"
#include "kernel/bounds.h"

#include <math.h>
#include <string.h>

// The derivative's values are means of its coefficients, n (p_(k+1) - p_k), each with gamma(2).
static kn_status polynomial(kn_ctx *ctx, double *out, const kn_bezier *a)
{
    size_t all = (size_t)a->ncomp * kn_bezier_count(a);
    double *d = kn_scratch(ctx, all, sizeof *d);
    if (!d) return KN_ENOMEM;
    for (int v = 0; v < a->nvars; v++) {
        int n = a->degree[v];
        kn_axis x = kn_bezier_axis(a, v);
        kn_bernstein_differentiate(d, a->coef, x.outer, n, x.inner);
        out[v] = kn_hull_norm(kn_bezier_count(a) / (size_t)(n + 1) * (size_t)(n > 0 ? n : 1), a->ncomp, d);
    }
    return KN_OK;
}

// ---- rational pieces ----

// g = the numbers of N' and w' at a's degrees, and w behind them. sums: with sums for differences.
static void partials(kn_bezier *g, const kn_bezier *a, int var, bool sums)
{
    int n = a->degree[var];
    size_t count = kn_bezier_count(a), inner = kn_bezier_axis(a, var).inner;
    for (int c = 0; c < a->ncomp; c++) {
        double *to = kn_bezier_comp(g, c);
        const double *p = kn_bezier_comp(a, c);
        if (!sums) kn_bezier_partial(to, a, c, var, NULL);
        for (size_t i = 0; sums && i < count; i++) {
            int k = (int)(i / inner % (size_t)(n + 1));
            to[i] = (k > 0 ? k * (p[i] + p[i - inner]) : 0.0) + (k < n ? (n - k) * (p[i + inner] + p[i]) : 0.0);
        }
    }
    memcpy(kn_bezier_comp(g, a->ncomp), kn_bezier_comp(a, a->ncomp - 1), count * sizeof *g->coef);
}

// q, in scratch: N' w - w' N and w^2, or, with sums, their sizes: sums of absolute values.
static kn_status quotient_rule(kn_ctx *ctx, const char *what, kn_bezier *q, const kn_bezier *a, int var, bool sums)
{
    int dim = kn_bezier_dim(a), n = 0;
    kn_term terms[KN_MAX_TERMS];
    kn_bezier g = *a, c = {.nvars = a->nvars, .ncomp = a->ncomp, .rational = true};
    g.rational = false, g.ncomp = a->ncomp + 1;
    *q = c;
    for (int d = 0; d < a->nvars; d++) q->degree[d] = 2 * a->degree[d];
    kn_status status = kn_bezier_scratch(ctx, q, what);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    g.coef = kn_scratch(ctx, (size_t)g.ncomp * kn_bezier_count(a), sizeof *g.coef);
    status = g.coef ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        partials(&g, a, var, sums);
        for (int i = 0; i < dim; i++) {
            terms[n++] = (kn_term){i, i, dim, 1.0};
            terms[n++] = (kn_term){i, dim, i, sums ? 1.0 : -1.0};
        }
        terms[n++] = (kn_term){dim, dim + 1, dim, 1.0};
        status = kn_bezier_combine(ctx, what, q, &c, &g, a, terms, n);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// The derivative's values are means, with positive weights, of q_k / (w^2)_k; both with their errors.
static kn_status bound(kn_ctx *ctx, const char *what, double *out, const kn_bezier *a, const kn_bezier *size, int var,
                       double roundings)
{
    kn_bezier q, s;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = quotient_rule(ctx, what, &q, a, var, false);
    if (status == KN_OK) status = quotient_rule(ctx, what, &s, size, var, true);
    if (status == KN_OK) {
        int dim = kn_bezier_dim(a);
        size_t n = kn_bezier_count(&q);
        kn_hull_errors(s.coef, (size_t)s.ncomp * n, roundings, 0x1p-1000);
        const double *w = kn_bezier_comp(&q, dim), *ew = kn_bezier_comp(&s, dim);
        for (size_t i = 0; i < (size_t)dim * n; i++) {
            double least = w[i % n] - ew[i % n];
            q.coef[i] = least > 0.0 ? (fabs(q.coef[i]) + s.coef[i]) / least : INFINITY;
        }
        *out = kn_hull_norm(n, dim, q.coef);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// Numbers divided by a power of two, so that the largest weight is about 1: the quotients stay the same.
static kn_status scaled(kn_ctx *ctx, kn_bezier *to, const kn_bezier *a, const double *from, bool positive)
{
    const double *w = kn_bezier_comp(a, kn_bezier_dim(a));
    size_t count = kn_bezier_count(a);
    double most = w[0];
    for (size_t i = 1; i < count; i++) most = w[i] > most ? w[i] : most;
    *to = *a;
    kn_status status = kn_bezier_scratch(ctx, to, "lipschitz");
    for (size_t i = 0; status == KN_OK && i < (size_t)a->ncomp * count; i++)
        to->coef[i] = scalbn(positive ? fabs(from[i]) : from[i], -ilogb(most));
    return status;
}

kn_status kn_rational_lipschitz(kn_ctx *ctx, const char *what, double *out, const kn_bezier *a, const double *size,
                                double known)
{
    size_t count = kn_bezier_count(a);
    if (!kn_hull_positive(count, kn_bezier_comp(a, kn_bezier_dim(a)), NULL))
        return kn_fail(ctx, KN_EDOMAIN, "%s: a weight is not positive", what);
    for (int v = 0; v < a->nvars; v++)
        if (2 * a->degree[v] > KN_MAX_DEGREE)
            return kn_fail(ctx, KN_ELIMIT, "%s: degree %d of a rational", what, a->degree[v]);
    double roundings = 2.0 * (double)count + 3.0 * a->nvars + 8.0 + 2.0 * known;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_bezier b, s;
    kn_status status = scaled(ctx, &b, a, a->coef, false);
    if (status == KN_OK) status = scaled(ctx, &s, a, size ? size : a->coef, true);
    double *most = kn_scratch(ctx, KN_MAX_VARS, sizeof *most);
    if (!most) status = KN_ENOMEM;
    for (int v = 0; v < a->nvars && status == KN_OK; v++) status = bound(ctx, what, &most[v], &b, &s, v, roundings);
    if (status == KN_OK) memcpy(out, most, (size_t)a->nvars * sizeof *out);
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_bezier_lipschitz(kn_ctx *ctx, double *out, const kn_bezier *a)
{
    kn_status status = kn_bezier_check_operand(ctx, "lipschitz", a);
    if (status != KN_OK) return status;
    if (a->rational) return kn_rational_lipschitz(ctx, "lipschitz", out, a, NULL, 0.0);
    kn_mark mark = kn_scratch_mark(ctx);
    status = polynomial(ctx, out, a);
    kn_scratch_release(ctx, mark);
    return status;
}
