// SPDX-License-Identifier: Apache-2.0
// Where two splines of separate variables agree: a(x) w_b(y) - b(y) w_a(x) = 0 on the product of their knots.
#include "solve/cells.h"

#include "kernel/context.h"

// The knots of both, and as many coefficients as there are pairs.
static kn_status shape(kn_ctx *ctx, const char *what, kn_spline *out, const kn_spline *a, const kn_spline *b)
{
    const kn_spline *both[2] = {a, b};
    kn_status status = kn_spline_check(ctx, a);
    if (status == KN_OK) status = kn_spline_check(ctx, b);
    if (status != KN_OK) return status;
    if (kn_spline_dim(a) != kn_spline_dim(b))
        return kn_fail(ctx, KN_EDOMAIN, "%s: dimensions %d and %d", what, kn_spline_dim(a), kn_spline_dim(b));
    *out = (kn_spline){.ncomp = kn_spline_dim(a)};
    for (int s = 0; s < 2; s++)
        for (int d = 0; d < both[s]->nvars; d++, out->nvars++) {
            out->degree[out->nvars] = both[s]->degree[d];
            out->count[out->nvars] = both[s]->count[d];
            out->knots[out->nvars] = both[s]->knots[d];
        }
    double count = out->ncomp * (double)kn_spline_count(a) * (double)kn_spline_count(b);
    if (count > (double)KN_MAX_COEFS) return kn_fail(ctx, KN_ELIMIT, "%s: %g coefficients", what, count);
    return KN_OK;
}

// Two products and a difference: gamma(2) of the absolute values, which the largest of each bound.
static void fill(kn_spline *out, double *error, const kn_spline *a, const kn_spline *b)
{
    size_t na = kn_spline_count(a), nb = kn_spline_count(b);
    const double *wa = a->rational ? a->coef + (size_t)(a->ncomp - 1) * na : NULL;
    const double *wb = b->rational ? b->coef + (size_t)(b->ncomp - 1) * nb : NULL;
    double *to = out->coef, most_wa = wa ? kn_largest(wa, na) : 1.0, most_wb = wb ? kn_largest(wb, nb) : 1.0;
    for (int c = 0; c < out->ncomp; c++) {
        const double *pa = a->coef + (size_t)c * na, *pb = b->coef + (size_t)c * nb;
        for (size_t i = 0; i < na; i++)
            for (size_t j = 0; j < nb; j++) *to++ = pa[i] * (wb ? wb[j] : 1.0) - pb[j] * (wa ? wa[i] : 1.0);
        error[c] = kn_rounding(3.0) * (kn_largest(pa, na) * most_wb + kn_largest(pb, nb) * most_wa) + kn_underflow();
    }
}

kn_status kn_meet(kn_ctx *ctx, const char *what, kn_root **roots, size_t *nroots, kn_solve_report *report,
                  const kn_spline *a, const kn_spline *b, const kn_solve_options *options)
{
    kn_spline f = {0};
    double error[KN_MAX_COMPS];
    kn_status status = shape(ctx, what, &f, a, b);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    f.coef = kn_scratch(ctx, (size_t)f.ncomp * kn_spline_count(a) * kn_spline_count(b), sizeof *f.coef);
    if (!f.coef) status = KN_ENOMEM;
    if (status == KN_OK) {
        fill(&f, error, a, b);
        status = kn_zeros_within(ctx, roots, nroots, report, &f, 1, error, options);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
