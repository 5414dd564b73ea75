// SPDX-License-Identifier: Apache-2.0
// The sum of two splines over different variables.
#include <string.h>

#include "construct/internal.h"
#include "kernel/context.h"
#include "spline/internal.h"

// P/p + T/t = (P t + T p) / (p t): control points are combined in pairs, because B-splines of different variables
// multiply to those of both.
static void add(kn_spline *s, const kn_spline *p, const kn_spline *t)
{
    size_t np = kn_spline_count(p), nt = kn_spline_count(t), dim = (size_t)kn_spline_dim(p);
    double *to = s->coef;
    for (size_t c = 0; c < (size_t)s->ncomp; c++)
        for (size_t i = 0; i < np; i++)
            for (size_t j = 0; j < nt; j++, to++) {
                double wp = p->rational ? p->coef[dim * np + i] : 1.0, wt = t->rational ? t->coef[dim * nt + j] : 1.0;
                *to = c == dim ? wp * wt : p->coef[c * np + i] * wt + t->coef[c * nt + j] * wp;
            }
}

kn_status kn_construct_swept(kn_ctx *ctx, kn_spline *out, const kn_spline *profile, const kn_spline *trajectory)
{
    static const char call[] = "construct_swept";
    const kn_spline *p = profile, *t = trajectory;
    kn_status status = kn_spline_expect(ctx, call, p, 0);
    if (status == KN_OK) status = kn_spline_expect(ctx, call, t, 0);
    if (status != KN_OK) return status;
    if (kn_spline_dim(p) != kn_spline_dim(t))
        return kn_fail(ctx, KN_EDOMAIN, "%s: dimensions %d and %d", call, kn_spline_dim(p), kn_spline_dim(t));
    if (p->nvars + t->nvars > KN_MAX_VARS)
        return kn_fail(ctx, KN_ELIMIT, "%s: %d variables", call, p->nvars + t->nvars);
    kn_spline s = {.nvars = p->nvars + t->nvars, .rational = p->rational || t->rational};
    s.ncomp = kn_spline_dim(p) + s.rational;
    for (int d = 0; d < s.nvars; d++) {
        const kn_spline *from = d < p->nvars ? p : t;
        int e = d < p->nvars ? d : d - p->nvars;
        s.degree[d] = from->degree[e], s.count[d] = from->count[e];
    }
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_spline_in_scratch(ctx, call, &s);
    if (status == KN_OK) {
        for (int d = 0; d < s.nvars; d++) {
            const double *from = d < p->nvars ? p->knots[d] : t->knots[d - p->nvars];
            memcpy(s.knots[d], from, (size_t)(s.count[d] + s.degree[d] + 1) * sizeof *from);
        }
        add(&s, p, t);
        status = kn_spline_store(ctx, out, &s);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
