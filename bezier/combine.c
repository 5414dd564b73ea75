// SPDX-License-Identifier: Apache-2.0
// Sums of products of components, on scaled coefficients.
#include "bezier/combine.h"
#include "kernel/bernstein.h"

#include <string.h>

// An operand made ready: its components scaled, behind them the constant 1 if a weight is wanted that it lacks.
typedef struct factor {
    double *scaled;
    size_t *place; // of its coefficients in the result
    size_t count;
    int row;
} factor;

static bool factor_init(kn_ctx *ctx, factor *f, const kn_bezier *a, const int *target, bool one)
{
    size_t n = kn_bezier_count(a), ncomp = (size_t)a->ncomp;
    double *weight = kn_scratch(ctx, n, sizeof *weight);
    *f = (factor){.count = n, .row = a->nvars ? a->degree[a->nvars - 1] + 1 : 1};
    f->scaled = kn_scratch(ctx, n * (ncomp + one), sizeof *f->scaled);
    f->place = kn_scratch(ctx, n, sizeof *f->place);
    if (!weight || !f->scaled || !f->place) return false;
    kn_bernstein_weights(weight, a->nvars, a->degree);
    kn_bernstein_places(f->place, a->nvars, a->degree, target);
    for (size_t c = 0; c < ncomp; c++)
        for (size_t i = 0; i < n; i++) f->scaled[c * n + i] = weight[i] * a->coef[c * n + i];
    if (one) memcpy(f->scaled + ncomp * n, weight, n * sizeof *weight);
    return true;
}

static void accumulate(kn_bezier *result, const factor *f, const factor *g, const kn_term *t)
{
    kn_bernstein_convolve(kn_bezier_comp(result, t->to), f->scaled + (size_t)t->a * f->count, f->place, f->count,
                          g->scaled + (size_t)t->b * g->count, g->place, g->count, g->row, t->sign);
}

// Whether a term wants the weight of a polynomial operand (which: 0 the first, 1 the second).
static bool wants_one(const kn_bezier *x, const kn_term *terms, int nterms, int which)
{
    bool wanted = false;
    for (int i = 0; i < nterms; i++) wanted |= (which ? terms[i].b : terms[i].a) == x->ncomp;
    return wanted;
}

kn_status kn_bezier_combine(kn_ctx *ctx, const char *what, kn_bezier *result, const kn_bezier *a, const kn_bezier *b,
                            const kn_term *terms, int nterms)
{
    factor f, g;
    for (int d = 0; d < a->nvars; d++) result->degree[d] = a->degree[d] + b->degree[d];
    kn_status status = kn_bezier_alloc(ctx, result, what);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    size_t n = kn_bezier_count(result), ncomp = (size_t)result->ncomp;
    double *weight = kn_scratch(ctx, n, sizeof *weight);
    if (weight && factor_init(ctx, &f, a, result->degree, wants_one(a, terms, nterms, 0)) &&
        factor_init(ctx, &g, b, result->degree, wants_one(b, terms, nterms, 1))) {
        memset(result->coef, 0, n * ncomp * sizeof *result->coef);
        for (int i = 0; i < nterms; i++) accumulate(result, &f, &g, &terms[i]);
        kn_bernstein_weights(weight, result->nvars, result->degree);
        for (size_t c = 0; c < ncomp; c++)
            for (size_t i = 0; i < n; i++) result->coef[c * n + i] /= weight[i];
    } else {
        status = KN_ENOMEM;
        kn_bezier_clear(ctx, result);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
