// SPDX-License-Identifier: Apache-2.0
// Sums and differences.
#include "bezier/combine.h"

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

// c = a + sign b over one weight, at the higher degree in each variable.
static kn_status add_elevated(kn_ctx *ctx, kn_bezier *c, const kn_bezier *a, const kn_bezier *b, double sign)
{
    int degree[KN_MAX_VARS];
    for (int d = 0; d < a->nvars; d++) degree[d] = a->degree[d] > b->degree[d] ? a->degree[d] : b->degree[d];
    kn_bezier eb = {0};
    kn_status status = kn_bezier_elevate(ctx, c, a, degree);
    if (status == KN_OK) status = kn_bezier_elevate(ctx, &eb, b, degree);
    if (status == KN_OK) {
        size_t n = (size_t)kn_bezier_dim(c) * kn_bezier_count(c);
        for (size_t i = 0; i < n; i++) c->coef[i] += sign * eb.coef[i];
    }
    kn_bezier_clear(ctx, &eb);
    return status;
}

// a/wa + b/wb = (a wb + b wa) / (wa wb), where the weight of a polynomial piece is 1.
static kn_status add_crosswise(kn_ctx *ctx, const char *what, kn_bezier *c, const kn_bezier *a, const kn_bezier *b,
                               double sign)
{
    int dim = kn_bezier_dim(a), n = 0;
    kn_term terms[KN_MAX_TERMS];
    *c = (kn_bezier){.nvars = a->nvars, .ncomp = dim + 1, .rational = true};
    for (int i = 0; i < dim; i++) {
        terms[n++] = (kn_term){i, i, kn_bezier_dim(b), 1.0};
        terms[n++] = (kn_term){i, dim, i, sign};
    }
    terms[n++] = kn_weight_term(c, a, b);
    return kn_bezier_combine(ctx, what, c, a, b, terms, n);
}

static kn_status add(kn_ctx *ctx, const char *what, kn_bezier *out, const kn_bezier *a, const kn_bezier *b,
                     double sign)
{
    kn_status status = kn_bezier_check_pair(ctx, what, a, b);
    if (status != KN_OK) return status;
    int dim = kn_bezier_dim(a);
    if (dim != kn_bezier_dim(b))
        return kn_fail(ctx, KN_EDOMAIN, "%s: %d and %d components", what, dim, kn_bezier_dim(b));
    kn_bezier c = {0};
    status = same_weight(a, b) ? add_elevated(ctx, &c, a, b, sign) : add_crosswise(ctx, what, &c, a, b, sign);
    return kn_bezier_finish(ctx, out, &c, status);
}

kn_status kn_bezier_sum(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b)
{
    return add(ctx, "sum", out, a, b, 1.0);
}

kn_status kn_bezier_difference(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b)
{
    return add(ctx, "difference", out, a, b, -1.0);
}
