// SPDX-License-Identifier: Apache-2.0
// Sums of splines.
#include <string.h>

#include "bezier/combine.h"
#include "spline/internal.h"
#include "kernel/context.h"

// a/wa + b/wb on one piece, always over the weight wa wb, so that all pieces have one shape.
static kn_status add_piece(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b, const double *size,
                           const void *user)
{
    (void)size, (void)user;
    kn_term terms[KN_MAX_TERMS];
    int dim = kn_bezier_dim(a), n = 0;
    kn_bezier sum = {.nvars = a->nvars, .ncomp = dim + 1, .rational = true};
    for (int i = 0; i < dim; i++) {
        terms[n++] = (kn_term){i, i, kn_bezier_dim(b), 1.0};
        terms[n++] = (kn_term){i, dim, i, 1.0};
    }
    terms[n++] = kn_weight_term(&sum, a, b);
    kn_status status = kn_bezier_combine(ctx, "spline_sum", &sum, a, b, terms, n);
    return kn_bezier_finish(ctx, out, &sum, status);
}

// s on the knots of s and other in variable var, each as often as the one that has it more often.
static kn_status refine_to_union(kn_ctx *ctx, kn_spline *s, const kn_spline *other, int var)
{
    int p = s->degree[var], n = s->count[var] + p + 1, m = other->count[var] + p + 1;
    kn_mark mark = kn_scratch_mark(ctx);
    double *to = kn_scratch(ctx, (size_t)n + (size_t)m, sizeof *to);
    kn_status status = KN_ENOMEM;
    if (to) {
        int total = kn_knots_union(to, s->knots[var], n, other->knots[var], m);
        status = kn_spline_refine_axis(ctx, s, var, to, total - p - 1);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// a and b become equal in degrees and knots.
static kn_status make_compatible(kn_ctx *ctx, kn_spline *a, kn_spline *b)
{
    int degree[KN_MAX_VARS];
    for (int d = 0; d < a->nvars; d++) degree[d] = a->degree[d] > b->degree[d] ? a->degree[d] : b->degree[d];
    kn_status status = kn_spline_elevate(ctx, a, a, degree);
    if (status == KN_OK) status = kn_spline_elevate(ctx, b, b, degree);
    for (int d = 0; d < a->nvars && status == KN_OK; d++) {
        status = refine_to_union(ctx, a, b, d);
        if (status == KN_OK) status = refine_to_union(ctx, b, a, d);
    }
    return status;
}

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

kn_status kn_spline_sum(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const kn_spline *b)
{
    kn_status status = kn_spline_expect_pair(ctx, "spline_sum", a, b);
    if (status != KN_OK) return status;
    if (kn_spline_dim(a) != kn_spline_dim(b))
        return kn_fail(ctx, KN_EDOMAIN, "spline_sum: %d and %d components", kn_spline_dim(a), kn_spline_dim(b));
    if (kn_spline_dim(a) >= KN_MAX_COMPS && a->rational != b->rational)
        return kn_fail(ctx, KN_ELIMIT, "spline_sum: %d components and a weight", kn_spline_dim(a));
    if (!same_weight(a, b)) return kn_spline_by_pieces(ctx, "spline_sum", out, a, b, add_piece, NULL, -1);

    kn_spline s = {0}, t = {0};
    status = kn_spline_copy(ctx, &s, a);
    if (status == KN_OK) status = kn_spline_copy(ctx, &t, b);
    if (status == KN_OK) status = make_compatible(ctx, &s, &t);
    if (status == KN_OK) {
        size_t n = kn_spline_count(&s) * (size_t)kn_spline_dim(&s);
        for (size_t i = 0; i < n; i++) s.coef[i] += t.coef[i];
        kn_spline_swap(out, &s);
    }
    kn_spline_clear(ctx, &s);
    kn_spline_clear(ctx, &t);
    return status;
}
