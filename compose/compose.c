// SPDX-License-Identifier: Apache-2.0
// kn_bezier_compose: outer(inner).
#include "bezier/shape.h"
#include "compose/nest.h"

#include <knurl/compose.h>

static kn_status check(kn_ctx *ctx, const kn_bezier *outer, const kn_bezier *inner)
{
    kn_status status = kn_bezier_check_operand(ctx, "compose", outer);
    if (status == KN_OK) status = kn_bezier_check_operand(ctx, "compose", inner);
    if (status != KN_OK) return status;
    if (outer->nvars < 1 || kn_bezier_dim(inner) != outer->nvars)
        return kn_fail(ctx, KN_EDOMAIN, "compose: %d outer variables, %d inner components", outer->nvars,
                       kn_bezier_dim(inner));
    return KN_OK;
}

// The result's shape, without coefficients.
static kn_status shape_of(kn_ctx *ctx, kn_bezier *result, int sum, const kn_bezier *outer, const kn_bezier *inner)
{
    bool rational = outer->rational || inner->rational;
    *result = (kn_bezier){.nvars = inner->nvars, .ncomp = kn_bezier_dim(outer) + rational, .rational = rational};
    for (int d = 0; d < inner->nvars; d++) result->degree[d] = sum * inner->degree[d];
    return kn_bezier_check(ctx, "compose", result->nvars, result->ncomp, rational, result->degree);
}

// The scaled result: with rational inner functions x = X/W each B(x) is replaced by W^p B(X/W), a polynomial again,
// and the common factor W^(sum of p) is the weight, or cancels when outer is rational.
static kn_status scaled(kn_ctx *ctx, double *value, const kn_nest *nest, const kn_bezier *outer,
                        const kn_bezier *inner, const double *lo, const double *hi)
{
    size_t n = kn_bezier_count(inner);
    double *factor = kn_scratch(ctx, 2 * (size_t)nest->outer * n, sizeof *factor);
    kn_status status = factor ? kn_nest_factors(ctx, factor, nest, inner, lo, hi) : KN_ENOMEM;
    if (status == KN_OK) status = kn_nest_run(ctx, value, nest, outer, factor);
    if (status == KN_OK && inner->rational && !outer->rational)
        status = kn_nest_power(ctx, value + (size_t)outer->ncomp * nest->room[nest->sum], nest,
                               inner->coef + (size_t)(inner->ncomp - 1) * n);
    return status;
}

static kn_status compute(kn_ctx *ctx, kn_bezier *out, int sum, const kn_bezier *outer, const kn_bezier *inner,
                         const double *lo, const double *hi)
{
    kn_bezier result;
    kn_status status = shape_of(ctx, &result, sum, outer, inner);
    if (status != KN_OK) return status;
    kn_nest *nest = kn_scratch(ctx, 1, sizeof *nest);
    if (!nest) return KN_ENOMEM;
    kn_nest_plan(nest, outer, inner);
    double *value = kn_scratch(ctx, (size_t)result.ncomp * nest->room[sum], sizeof *value);
    status = value ? scaled(ctx, value, nest, outer, inner, lo, hi) : KN_ENOMEM;
    if (status == KN_OK) status = kn_bezier_begin(ctx, &result, out, false, "compose"); // the operands are used up
    if (status != KN_OK) return status;
    kn_nest_divide(result.coef, nest, value, result.ncomp);
    kn_bezier_end(ctx, out, &result);
    return KN_OK;
}

kn_status kn_compose_over(kn_ctx *ctx, kn_bezier *out, const kn_bezier *outer, const kn_bezier *inner,
                          const double *lo, const double *hi)
{
    int sum = 0;
    kn_status status = check(ctx, outer, inner);
    if (status != KN_OK) return status;
    for (int d = 0; d < outer->nvars; d++) sum += outer->degree[d];
    kn_mark mark = kn_scratch_mark(ctx);
    status = compute(ctx, out, sum, outer, inner, lo, hi);
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_bezier_compose(kn_ctx *ctx, kn_bezier *out, const kn_bezier *outer, const kn_bezier *inner)
{
    return kn_compose_over(ctx, out, outer, inner, NULL, NULL);
}
