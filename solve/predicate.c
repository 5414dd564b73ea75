// SPDX-License-Identifier: Apache-2.0
// What the predicates share: their operands, and the sign of one function.
#include "solve/net.h"

#include "kernel/context.h"

static kn_status check(kn_ctx *ctx, const char *what, const kn_bezier *f, const double *lo, const double *hi,
                       int depth)
{
    if (!f->coef) return kn_fail(ctx, KN_EDOMAIN, "%s: an empty piece", what);
    if (f->nvars < 0 || f->nvars > KN_MAX_VARS || f->ncomp < 1 || f->ncomp > KN_MAX_COMPS)
        return kn_fail(ctx, KN_EDOMAIN, "%s: nvars %d, ncomp %d", what, f->nvars, f->ncomp);
    if (depth < 0 || depth > KN_SOLVE_MAX_DEPTH) return kn_fail(ctx, KN_EDOMAIN, "%s: depth %d", what, depth);
    for (int d = 0; d < f->nvars; d++) {
        if (f->degree[d] < 0 || f->degree[d] > KN_MAX_DEGREE)
            return kn_fail(ctx, KN_EDOMAIN, "%s: degree %d in variable %d", what, f->degree[d], d);
        if ((lo == NULL) != (hi == NULL) || (lo && !(lo[d] >= 0.0 && lo[d] <= hi[d] && hi[d] <= 1.0)))
            return kn_fail(ctx, KN_EDOMAIN, "%s: the box in variable %d", what, d);
    }
    size_t n = kn_bezier_count(f);
    const double *w = f->coef + (size_t)(f->ncomp - 1) * n;
    for (size_t i = 0; i < n && f->rational; i++)
        if (!(w[i] > 0.0)) return kn_fail(ctx, KN_EDOMAIN, "%s: weight %zu is %g", what, i, w[i]);
    return KN_OK;
}

kn_status kn_predicate_start(kn_ctx *ctx, const char *what, kn_net *net, double **coef, double **error,
                             const kn_bezier *f, const double *lo, const double *hi, int depth)
{
    kn_status status = check(ctx, what, f, lo, hi, depth);
    if (status != KN_OK) return status;
    *net = kn_net_make(f->nvars, kn_bezier_dim(f), f->degree);
    size_t size = (size_t)net->ncomp * net->count;
    double *c = kn_scratch(ctx, 2 * size, sizeof *c), *e = kn_scratch(ctx, (size_t)net->ncomp, sizeof *e);
    if (!c || !e) return KN_ENOMEM;
    for (int i = 0; i < net->ncomp; i++) e[i] = 0.0;
    if (lo)
        kn_net_restrict(c, e, net, f->coef, lo, hi, c + size);
    else
        for (size_t i = 0; i < size; i++) c[i] = f->coef[i];
    *coef = c;
    *error = e;
    return KN_OK;
}

typedef struct seen {
    bool positive, negative;
} seen;

// All coefficients on one side settle a box. Coefficients at corners are values: two of different sign settle all.
static kn_verdict sign_of_box(void *user, const kn_net *net, const double *coef, const double *error)
{
    seen *s = user;
    bool positive = true, negative = true;
    for (size_t i = 0; i < net->count; i++) {
        positive = positive && coef[i] > *error;
        negative = negative && coef[i] < -*error;
    }
    if (!positive && !negative)
        for (unsigned corner = 0; corner < 1u << net->nvars; corner++) {
            size_t at = 0;
            for (int d = 0; d < net->nvars; d++)
                at = at * (size_t)(net->degree[d] + 1) + (corner >> d & 1u ? (size_t)net->degree[d] : 0);
            s->positive = s->positive || coef[at] > *error;
            s->negative = s->negative || coef[at] < -*error;
        }
    s->positive = s->positive || positive;
    s->negative = s->negative || negative;
    if (s->positive && s->negative) return KN_STOP;
    return positive || negative ? KN_DONE : KN_HALVE;
}

kn_status kn_predicate_sign(kn_ctx *ctx, kn_sign *out, const kn_net *net, double *coef, double *error, int depth)
{
    seen s = {0};
    bool settled = false;
    kn_status status = kn_net_divide(ctx, &settled, net, coef, error, depth, sign_of_box, &s);
    if (status != KN_OK) return status;
    *out = KN_SIGN_UNKNOWN;
    if (s.positive && s.negative)
        *out = KN_SIGN_MIXED;
    else if (settled)
        *out = s.positive ? KN_SIGN_POSITIVE : KN_SIGN_NEGATIVE;
    return KN_OK;
}
