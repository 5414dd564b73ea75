// SPDX-License-Identifier: Apache-2.0
// Products, component by component.
#include "bezier/combine.h"

static bool is_small(const kn_bezier *a)
{
    return a->coef && (a->nvars == 1 || a->nvars == 2) && a->ncomp > a->rational && a->ncomp <= KN_MAX_COMPS &&
           (unsigned)a->degree[0] <= KN_SMALL_DEGREE && (unsigned)a->degree[a->nvars - 1] <= KN_SMALL_DEGREE;
}

static kn_small_operand small_operand(const kn_bezier *a)
{
    int rows = a->nvars == 2 ? a->degree[0] + 1 : 1;
    return (kn_small_operand){a->coef, rows, a->degree[a->nvars - 1] + 1, a->ncomp - a->rational, !a->rational};
}

// Operands that are small and go together, whose general path would take longer to set up than to compute. A result
// of out's shape goes straight into place.
static kn_status product_small(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b, int ncomp)
{
    int nvars = a->nvars, d0 = a->degree[0] + b->degree[0], d1 = nvars == 2 ? a->degree[1] + b->degree[1] : 0;
    bool rational = a->rational || b->rational;
    kn_small_operand x = small_operand(a), y = small_operand(b);
    if (out->coef && out->nvars == nvars && out->ncomp == ncomp && out->degree[0] == d0 &&
        (nvars == 1 || out->degree[1] == d1)) {
        kn_small_product(out->coef, &x, &y, rational);
        out->rational = rational;
        return KN_OK;
    }
    kn_bezier c = {.nvars = nvars, .ncomp = ncomp, .rational = rational, .degree = {d0, d1}};
    kn_status status = kn_bezier_begin_checked(ctx, &c, out, false);
    if (status != KN_OK) return status;
    kn_small_product(c.coef, &x, &y, rational);
    kn_bezier_end(ctx, out, &c);
    return KN_OK;
}

kn_status kn_bezier_product(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const kn_bezier *b)
{
    int na = a->ncomp - a->rational, nb = b->ncomp - b->rational, dim = na > nb ? na : nb;
    bool rational = a->rational || b->rational, fit = na == nb || na == 1 || nb == 1;
    if (fit && is_small(a) && is_small(b) && a->nvars == b->nvars && dim + rational <= KN_MAX_COMPS &&
        kn_small_here())
        return product_small(ctx, out, a, b, dim + rational);
    kn_status status = kn_bezier_check_pair(ctx, "product", a, b);
    if (status != KN_OK) return status;
    if (!fit) return kn_fail(ctx, KN_EDOMAIN, "product: %d and %d components", na, nb);
    kn_term terms[KN_MAX_COMPS + 1];
    const kn_bezier *const operands[] = {a, b};
    kn_formula f = {.ncomp = dim + rational, .rational = rational, .terms = terms};
    f.nterms = kn_product_terms(terms, na, nb, rational);
    return kn_bezier_multiply(ctx, "product", out, operands, &f);
}
