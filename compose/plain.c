// SPDX-License-Identifier: Apache-2.0
// The plain reference of kn_bezier_compose, for tests and measurements.
#include "compose/basis.h"
#include "compose/nest.h"

#include <string.h>

// outer(x) = sum_i coef_i prod_d B_(i_d)(x_d). One variable after the other, the last one first:
//     f_d(i_0 .. i_(d-1)) = sum over i_d of B_(i_d)(x_d) f_(d+1)(i_0 .. i_d),    f_N(i) = coef_i,
// so that the number of polynomial products is the number of control points of the leading variables only. With
// rational inner functions x = X/W each B is replaced by W^p B(X/W) = C(p,i) X^i (W - X)^(p-i), a polynomial again,
// and the common factor W^(sum of p) stays beside as the weight (or cancels, when outer is rational).
typedef struct expansion {
    const kn_bezier *outer;
    kn_bezier *basis[KN_MAX_VARS]; // basis[d][i], i <= outer->degree[d]
    int inner_vars;
} expansion;

// f_(N-1): a linear combination of the last variable's polynomials, `at` the place of the first coefficient.
static kn_status combine(kn_ctx *ctx, kn_bezier *out, const expansion *e, size_t at)
{
    int last = e->outer->nvars - 1;
    const kn_bezier *b = e->basis[last];
    size_t count = kn_bezier_count(b), stride = kn_bezier_count(e->outer);
    kn_bezier f = {0};
    kn_status status = kn_bezier_init(ctx, &f, e->inner_vars, e->outer->ncomp, false, b->degree);
    for (int c = 0; status == KN_OK && c < f.ncomp; c++)
        for (int i = 0; i <= e->outer->degree[last]; i++) {
            double factor = e->outer->coef[(size_t)c * stride + at + (size_t)i];
            for (size_t k = 0; k < count; k++) f.coef[(size_t)c * count + k] += factor * b[i].coef[k];
        }
    if (status == KN_OK) kn_bezier_swap(out, &f);
    kn_bezier_clear(ctx, &f);
    return status;
}

// f_d; `at` the place of coefficient (i_0 .. i_(d-1), 0 .. 0). The recursion is nvars deep.
static kn_status expand(kn_ctx *ctx, kn_bezier *out, const expansion *e, int d, size_t at)
{
    if (d == e->outer->nvars - 1) return combine(ctx, out, e, at);
    size_t step = 1;
    for (int k = d + 1; k < e->outer->nvars; k++) step *= (size_t)e->outer->degree[k] + 1;
    kn_bezier sum = {0}, term = {0};
    kn_status status = KN_OK;
    for (int i = 0; status == KN_OK && i <= e->outer->degree[d]; i++) {
        status = expand(ctx, &term, e, d + 1, at + (size_t)i * step);
        if (status == KN_OK) status = kn_bezier_product(ctx, &term, &e->basis[d][i], &term);
        if (status == KN_OK && i > 0) status = kn_bezier_sum(ctx, &sum, &sum, &term);
        if (status == KN_OK && i == 0) kn_bezier_swap(&sum, &term);
    }
    if (status == KN_OK) kn_bezier_swap(out, &sum);
    kn_bezier_clear(ctx, &sum);
    kn_bezier_clear(ctx, &term);
    return status;
}

// out = f with the weight of the composition appended: w^p.
static kn_status append_weight(kn_ctx *ctx, kn_bezier *f, const kn_bezier *w, int p)
{
    kn_bezier *power = kn_compose_list(ctx, p + 1), all = {0};
    if (!power) return KN_ENOMEM;
    kn_status status = kn_compose_powers(ctx, power, p, w);
    if (status == KN_OK) status = kn_bezier_init(ctx, &all, f->nvars, f->ncomp + 1, true, f->degree);
    if (status == KN_OK) {
        size_t count = kn_bezier_count(f);
        memcpy(all.coef, f->coef, (size_t)f->ncomp * count * sizeof *f->coef);
        memcpy(all.coef + (size_t)f->ncomp * count, power[p].coef, count * sizeof *f->coef);
        kn_bezier_swap(f, &all);
    }
    kn_bezier_clear(ctx, &all);
    kn_compose_list_clear(ctx, power, p + 1);
    return status;
}

static kn_status make_bases(kn_ctx *ctx, expansion *e, const kn_bezier *inner, const kn_bezier *w)
{
    kn_status status = KN_OK;
    for (int d = 0; status == KN_OK && d < e->outer->nvars; d++) {
        kn_bezier x = {0};
        int p = e->outer->degree[d];
        if (!(e->basis[d] = kn_compose_list(ctx, p + 1))) return KN_ENOMEM;
        status = kn_bezier_components(ctx, &x, inner, d, 1);
        if (status == KN_OK) status = kn_compose_basis(ctx, e->basis[d], p, &x, inner->rational ? w : NULL);
        kn_bezier_clear(ctx, &x);
    }
    return status;
}

kn_status kn_compose_plain(kn_ctx *ctx, kn_bezier *out, const kn_bezier *outer, const kn_bezier *inner)
{
    int sum = 0;
    kn_status status = KN_OK;
    for (int d = 0; d < outer->nvars; d++) sum += outer->degree[d];
    expansion e = {.outer = outer, .inner_vars = inner->nvars};
    kn_bezier w = {0}, result = {0};
    if (inner->rational) status = kn_bezier_components(ctx, &w, inner, inner->ncomp - 1, 1);
    if (status == KN_OK) status = make_bases(ctx, &e, inner, &w);
    if (status == KN_OK) status = expand(ctx, &result, &e, 0, 0);
    if (status == KN_OK && inner->rational && !outer->rational) status = append_weight(ctx, &result, &w, sum);
    if (status == KN_OK) {
        result.rational = outer->rational || inner->rational;
        kn_bezier_swap(out, &result);
    }
    for (int d = 0; d < outer->nvars; d++) kn_compose_list_clear(ctx, e.basis[d], outer->degree[d] + 1);
    kn_bezier_clear(ctx, &w);
    kn_bezier_clear(ctx, &result);
    return status;
}
