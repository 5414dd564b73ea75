// SPDX-License-Identifier: Apache-2.0
// Sums of splines.
#include <string.h>

#include "kernel/context.h"
#include "spline/combine.h"
#include "spline/in_scratch.h"

// a/w + b/w = (a + b)/w holds for one w: both polynomial, or the same weights on the same knots.
static bool same_weight(const kn_spline *a, const kn_spline *b)
{
    if (!a->rational && !b->rational) return true;
    if (!a->rational || !b->rational) return false;
    for (int d = 0; d < a->nvars; d++) {
        if (a->degree[d] != b->degree[d] || a->count[d] != b->count[d]) return false;
        for (int i = 0; i <= a->count[d] + a->degree[d]; i++)
            if (a->knots[d][i] != b->knots[d][i]) return false;
    }
    size_t n = kn_spline_count(a), at = n * (size_t)kn_spline_dim(a);
    return memcmp(a->coef + at, b->coef + at, n * sizeof *a->coef) == 0;
}

// s and t over [lo,hi] in variable var, with one degree and one knot vector.
static kn_status make_compatible(kn_ctx *ctx, kn_spline *s, kn_spline *t, int var, double lo, double hi)
{
    kn_spline *both[] = {s, t};
    kn_status status = KN_OK;
    int degree = s->degree[var] > t->degree[var] ? s->degree[var] : t->degree[var];
    for (int i = 0; i < 2 && status == KN_OK; i++) {
        double from, to;
        kn_spline_domain(both[i], var, &from, &to);
        if (from != lo || to != hi) status = kn_spline_restrict_in_scratch(ctx, both[i], var, lo, hi);
        if (status == KN_OK) status = kn_spline_elevate_in_scratch(ctx, both[i], var, degree);
    }
    if (status == KN_OK) status = kn_spline_unite_in_scratch(ctx, s, var, t->knots[var], t->count[var] + degree + 1);
    return status == KN_OK ? kn_spline_unite_in_scratch(ctx, t, var, s->knots[var], s->count[var] + degree + 1)
                           : status;
}

static kn_status add_over_one_weight(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b, double sign,
                                     const double *lo, const double *hi)
{
    kn_spline s = *a, t = *b;
    kn_status status = KN_OK;
    kn_mark mark = kn_scratch_mark(ctx);
    for (int d = a->nvars - 1; d >= 0 && status == KN_OK; d--) status = make_compatible(ctx, &s, &t, d, lo[d], hi[d]);
    size_t n = kn_spline_count(&s) * (size_t)kn_spline_dim(&s), all = kn_spline_count(&s) * (size_t)s.ncomp;
    double *sum = status == KN_OK ? kn_scratch(ctx, all, sizeof *sum) : NULL;
    if (sum) {
        for (size_t i = 0; i < n; i++) sum[i] = s.coef[i] + sign * t.coef[i];
        memcpy(sum + n, s.coef + n, (all - n) * sizeof *sum); // the weight
        s.coef = sum;
        status = kn_spline_store(ctx, out, &s);
    } else if (status == KN_OK) {
        status = KN_ENOMEM;
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_spline_add(kn_ctx *ctx, const char *call, kn_spline *out, const kn_spline *a, const kn_spline *b,
                        double sign)
{
    double lo[KN_MAX_VARS] = {0}, hi[KN_MAX_VARS] = {0};
    const kn_spline *const operands[] = {a, b};
    kn_status status = kn_spline_overlap(ctx, call, lo, hi, operands, 2);
    if (status != KN_OK) return status;
    int dim = kn_spline_dim(a);
    if (dim != kn_spline_dim(b))
        return kn_fail(ctx, KN_EDOMAIN, "%s: %d and %d components", call, dim, kn_spline_dim(b));
    if (same_weight(a, b)) return add_over_one_weight(ctx, out, a, b, sign, lo, hi);
    // a/wa + b/wb = (a wb + b wa) / (wa wb)
    kn_term terms[KN_MAX_TERMS + 1];
    kn_formula f = {.ncomp = dim + 1, .rational = true, .terms = terms, .nterms = kn_sum_terms(terms, dim, sign)};
    return kn_spline_multiply(ctx, call, out, operands, &f);
}

kn_status kn_spline_sum(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b)
{
    return kn_spline_add(ctx, "spline_sum", out, a, b, 1.0);
}
