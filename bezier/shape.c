// SPDX-License-Identifier: Apache-2.0
// Checks and shapes that the operations on kn_bezier share.
#include "bezier/shape.h"
#include "kernel/bernstein.h"

#include <string.h>

size_t kn_bezier_count(const kn_bezier *b)
{
    return kn_bernstein_count(b->nvars, b->degree);
}

int kn_bezier_dim(const kn_bezier *b)
{
    return b->ncomp - (b->rational ? 1 : 0);
}

kn_status kn_bezier_check(kn_ctx *ctx, const char *what, int nvars, int ncomp, bool rational, const int *degree)
{
    if (nvars < 0 || ncomp < (rational ? 2 : 1))
        return kn_fail(ctx, KN_EDOMAIN, "%s: nvars %d, ncomp %d", what, nvars, ncomp);
    if (nvars > KN_MAX_VARS || ncomp > KN_MAX_COMPS)
        return kn_fail(ctx, KN_ELIMIT, "%s: nvars %d (at most %d), ncomp %d (at most %d)", what, nvars, KN_MAX_VARS,
                       ncomp, KN_MAX_COMPS);
    size_t count = (size_t)ncomp;
    for (int d = 0; d < nvars; d++) {
        if (degree[d] < 0) return kn_fail(ctx, KN_EDOMAIN, "%s: degree %d in variable %d", what, degree[d], d);
        if (degree[d] > KN_MAX_DEGREE)
            return kn_fail(ctx, KN_ELIMIT, "%s: degree %d in variable %d (at most %d)", what, degree[d], d,
                           KN_MAX_DEGREE);
        count *= (size_t)degree[d] + 1; // far from overflow: checked in every step
        if (count > KN_MAX_COEFS)
            return kn_fail(ctx, KN_ELIMIT, "%s: more than %zu coefficients", what, KN_MAX_COEFS);
    }
    return KN_OK;
}

kn_status kn_bezier_check_operand(kn_ctx *ctx, const char *what, const kn_bezier *a)
{
    if (!a->coef) return kn_fail(ctx, KN_EDOMAIN, "%s: a piece without coefficients", what);
    return kn_bezier_check(ctx, what, a->nvars, a->ncomp, a->rational, a->degree);
}

kn_status kn_bezier_check_pair(kn_ctx *ctx, const char *what, const kn_bezier *a, const kn_bezier *b)
{
    kn_status status = kn_bezier_check_operand(ctx, what, a);
    if (status == KN_OK) status = kn_bezier_check_operand(ctx, what, b);
    if (status != KN_OK || a->nvars == b->nvars) return status;
    return kn_fail(ctx, KN_EDOMAIN, "%s: %d and %d variables", what, a->nvars, b->nvars);
}

kn_status kn_bezier_check_var(kn_ctx *ctx, const char *what, const kn_bezier *b, int var)
{
    if (var >= 0 && var < b->nvars) return KN_OK;
    return kn_fail(ctx, KN_EDOMAIN, "%s: variable %d of %d", what, var, b->nvars);
}

kn_status kn_bezier_alloc(kn_ctx *ctx, kn_bezier *b, const char *what)
{
    b->coef = NULL;
    kn_status status = kn_bezier_check(ctx, what, b->nvars, b->ncomp, b->rational, b->degree);
    if (status != KN_OK) return status;
    b->coef = kn_alloc(ctx, (size_t)b->ncomp * kn_bezier_count(b), sizeof *b->coef);
    return b->coef ? KN_OK : KN_ENOMEM;
}

// ---- where results live ----
// All coefficients of all components; 0 for an empty piece.
static size_t numbers(const kn_bezier *b)
{
    return b->coef ? (size_t)b->ncomp * kn_bezier_count(b) : 0;
}

kn_status kn_bezier_scratch(kn_ctx *ctx, kn_bezier *c, const char *what)
{
    kn_status status = kn_bezier_check(ctx, what, c->nvars, c->ncomp, c->rational, c->degree);
    if (status != KN_OK) return status;
    c->coef = kn_scratch(ctx, (size_t)c->ncomp * kn_bezier_count(c), sizeof *c->coef);
    return c->coef ? KN_OK : KN_ENOMEM;
}

kn_status kn_bezier_store(kn_ctx *ctx, kn_bezier *out, const kn_bezier *c)
{
    if (kn_bezier_is(out, c)) { // the same array, or both are empty
        *out = *c;
        return KN_OK;
    }
    size_t n = numbers(c);
    double *coef = NULL, *old = out->coef;
    if (n > 0) {
        bool fits = n == numbers(out);
        coef = fits ? old : kn_alloc(ctx, n, sizeof *coef);
        if (!coef) return KN_ENOMEM;
        memcpy(coef, c->coef, n * sizeof *coef);
    }
    if (coef != old) kn_free(ctx, old);
    *out = *c;
    out->coef = coef;
    return KN_OK;
}

kn_status kn_bezier_begin(kn_ctx *ctx, kn_bezier *c, const kn_bezier *out, bool is_operand, const char *what)
{
    kn_status status = kn_bezier_check(ctx, what, c->nvars, c->ncomp, c->rational, c->degree);
    return status == KN_OK ? kn_bezier_begin_checked(ctx, c, out, is_operand) : status;
}

kn_status kn_bezier_begin_checked(kn_ctx *ctx, kn_bezier *c, const kn_bezier *out, bool is_operand)
{
    size_t n = (size_t)c->ncomp * kn_bezier_count(c);
    if (n != numbers(out))
        c->coef = kn_alloc(ctx, n, sizeof *c->coef);
    else
        c->coef = is_operand ? kn_scratch(ctx, n, sizeof *c->coef) : out->coef;
    return c->coef ? KN_OK : KN_ENOMEM;
}

void kn_bezier_end(kn_ctx *ctx, kn_bezier *out, kn_bezier *c)
{
    double *coef = c->coef, *old = out->coef;
    size_t n = numbers(c);
    if (n == numbers(out)) { // out's own array, or scratch
        if (coef != old) memcpy(old, coef, n * sizeof *old);
        coef = old;
    } else {
        kn_free(ctx, old);
    }
    *out = *c;
    out->coef = coef;
}

kn_status kn_bezier_finish(kn_ctx *ctx, kn_bezier *out, kn_bezier *result, kn_status status)
{
    if (status == KN_OK) kn_bezier_swap(out, result);
    kn_bezier_clear(ctx, result);
    return status;
}

kn_axis kn_bezier_axis(const kn_bezier *b, int var)
{
    return (kn_axis){(size_t)b->ncomp * kn_bernstein_count(var, b->degree),
                     kn_bernstein_count(b->nvars - var - 1, b->degree + var + 1)};
}
