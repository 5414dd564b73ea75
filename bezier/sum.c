// SPDX-License-Identifier: Apache-2.0
// Sums and differences.
#include "bezier/combine.h"
#include "kernel/bernstein.h"

#include <string.h>

// a/w + b/w = (a + b)/w holds for one w: both polynomial, or the same weights coefficient by coefficient.
static bool same_weight(const kn_bezier *a, const kn_bezier *b)
{
    if (!a->rational && !b->rational) return true;
    if (!a->rational || !b->rational) return false;
    for (int d = 0; d < a->nvars; d++)
        if (a->degree[d] != b->degree[d]) return false;
    const double *wa = kn_bezier_comp(a, kn_bezier_dim(a)), *wb = kn_bezier_comp(b, kn_bezier_dim(b));
    return memcmp(wa, wb, kn_bezier_count(a) * sizeof *wa) == 0;
}

// One variable after another; to receives the last step, other is room for those before.
static void raise_degrees(double *to, double *other, const kn_bezier *a, const int *degree)
{
    kn_bezier now = *a;
    int steps = 0;
    for (int d = 0; d < a->nvars; d++) steps += degree[d] != a->degree[d];
    for (int d = 0; d < a->nvars; d++) {
        if (degree[d] == a->degree[d]) continue;
        kn_axis x = kn_bezier_axis(&now, d);
        double *next = --steps % 2 ? other : to;
        kn_bernstein_elevate(next, now.coef, x.outer, now.degree[d], degree[d], x.inner);
        now.degree[d] = degree[d], now.coef = next;
    }
}

// c = a with c's degrees; a's own array when these are its own.
static kn_status elevated(kn_ctx *ctx, kn_bezier *c, const kn_bezier *a, const char *what)
{
    if (memcmp(c->degree, a->degree, (size_t)a->nvars * sizeof *a->degree) == 0) {
        *c = *a;
        return KN_OK;
    }
    c->nvars = a->nvars, c->ncomp = a->ncomp, c->rational = a->rational;
    kn_status status = kn_bezier_scratch(ctx, c, what);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    double *other = kn_scratch(ctx, (size_t)c->ncomp * kn_bezier_count(c), sizeof *other);
    if (other) raise_degrees(c->coef, other, a, c->degree);
    kn_scratch_release(ctx, mark);
    return other ? KN_OK : KN_ENOMEM;
}

// out = a + sign b over one weight, at the higher degree in each variable.
static kn_status add_elevated(kn_ctx *ctx, const char *what, kn_bezier *out, const kn_bezier *a, const kn_bezier *b,
                              double sign)
{
    kn_bezier x = {0}, y = {0}, c;
    for (int d = 0; d < a->nvars; d++) x.degree[d] = a->degree[d] > b->degree[d] ? a->degree[d] : b->degree[d];
    y = x;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = elevated(ctx, &x, a, what);
    if (status == KN_OK) status = elevated(ctx, &y, b, what);
    c = x;
    if (status == KN_OK) status = kn_bezier_begin(ctx, &c, out, kn_bezier_is(out, a) || kn_bezier_is(out, b), what);
    if (status == KN_OK) {
        size_t n = (size_t)kn_bezier_dim(&c) * kn_bezier_count(&c), all = (size_t)c.ncomp * kn_bezier_count(&c);
        for (size_t i = 0; i < n; i++) c.coef[i] = x.coef[i] + sign * y.coef[i];
        if (all > n) memcpy(c.coef + n, x.coef + n, (all - n) * sizeof *c.coef); // the weight
        kn_bezier_end(ctx, out, &c);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// a/wa + b/wb = (a wb + b wa) / (wa wb), where the weight of a polynomial piece is 1.
static kn_status add_crosswise(kn_ctx *ctx, const char *what, kn_bezier *out, const kn_bezier *a, const kn_bezier *b,
                               double sign)
{
    int dim = kn_bezier_dim(a);
    kn_term terms[KN_MAX_TERMS + 1];
    const kn_bezier *const operands[] = {a, b};
    kn_formula f = {.ncomp = dim + 1, .rational = true, .terms = terms, .nterms = kn_sum_terms(terms, dim, sign)};
    return kn_bezier_multiply(ctx, what, out, operands, &f);
}

static kn_status add(kn_ctx *ctx, const char *what, kn_bezier *out, const kn_bezier *a, const kn_bezier *b,
                     double sign)
{
    kn_status status = kn_bezier_check_pair(ctx, what, a, b);
    if (status != KN_OK) return status;
    int dim = kn_bezier_dim(a);
    if (dim != kn_bezier_dim(b))
        return kn_fail(ctx, KN_EDOMAIN, "%s: %d and %d components", what, dim, kn_bezier_dim(b));
    return same_weight(a, b) ? add_elevated(ctx, what, out, a, b, sign) : add_crosswise(ctx, what, out, a, b, sign);
}

kn_status kn_bezier_sum(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b)
{
    return add(ctx, "sum", out, a, b, 1.0);
}

kn_status kn_bezier_difference(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b)
{
    return add(ctx, "difference", out, a, b, -1.0);
}
