// SPDX-License-Identifier: Apache-2.0
// Bernstein polynomials of functions in Bernstein form.
#include "compose/basis.h"
#include "kernel/binomial.h"

kn_bezier *kn_compose_list(kn_ctx *ctx, int n)
{
    return kn_alloc_zero(ctx, (size_t)n, sizeof(kn_bezier));
}

static void clear_all(kn_ctx *ctx, kn_bezier *list, int n)
{
    for (int i = 0; i < n; i++) kn_bezier_clear(ctx, &list[i]);
}

void kn_compose_list_clear(kn_ctx *ctx, kn_bezier *list, int n)
{
    if (!list) return;
    clear_all(ctx, list, n);
    kn_free(ctx, list);
}

kn_status kn_compose_powers(kn_ctx *ctx, kn_bezier *power, int p, const kn_bezier *x)
{
    static const int constant[KN_MAX_VARS] = {0};
    kn_status status = kn_bezier_init(ctx, &power[0], x->nvars, 1, false, constant);
    if (status == KN_OK) power[0].coef[0] = 1.0;
    for (int i = 1; status == KN_OK && i <= p; i++)
        status = i == 1 ? kn_bezier_copy(ctx, &power[1], x) : kn_bezier_product(ctx, &power[i], &power[i - 1], x);
    if (status != KN_OK) clear_all(ctx, power, p + 1);
    return status;
}

// w - x; the constant 1 has all its Bernstein coefficients 1.
static kn_status complement(kn_ctx *ctx, kn_bezier *out, const kn_bezier *x, const kn_bezier *w)
{
    kn_status status = kn_bezier_copy(ctx, out, x);
    size_t n = status == KN_OK ? kn_bezier_count(x) : 0;
    for (size_t i = 0; i < n; i++) out->coef[i] = (w ? w->coef[i] : 1.0) - x->coef[i];
    return status;
}

kn_status kn_compose_basis(kn_ctx *ctx, kn_bezier *basis, int p, const kn_bezier *x, const kn_bezier *w)
{
    kn_bezier rest = {0}, *power = kn_compose_list(ctx, 2 * (p + 1));
    if (!power) return KN_ENOMEM;
    kn_status status = complement(ctx, &rest, x, w);
    if (status == KN_OK) status = kn_compose_powers(ctx, power, p, x);
    if (status == KN_OK) status = kn_compose_powers(ctx, power + p + 1, p, &rest);
    for (int i = 0; status == KN_OK && i <= p; i++) {
        status = kn_bezier_product(ctx, &basis[i], &power[i], &power[p + 1 + p - i]);
        if (status == KN_OK) status = kn_bezier_scale(ctx, &basis[i], &basis[i], kn_binomial(p, i));
    }
    if (status != KN_OK) clear_all(ctx, basis, p + 1);
    kn_bezier_clear(ctx, &rest);
    kn_compose_list_clear(ctx, power, 2 * (p + 1));
    return status;
}
