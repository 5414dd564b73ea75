// SPDX-License-Identifier: Apache-2.0
// kn_bezier_compose_outer_sensitivity, kn_bezier_compose_inner_sensitivity.
#include "bezier/shape.h"

#include <knurl/compose.h>

#include <string.h>

// The place of a multi-index, or KN_EDOMAIN.
static kn_status place_of(kn_ctx *ctx, size_t *place, const char *call, const kn_bezier *b, const int *index)
{
    *place = 0;
    for (int d = 0; d < b->nvars; d++) {
        if (index[d] < 0 || index[d] > b->degree[d])
            return kn_fail(ctx, KN_EDOMAIN, "%s: index %d in variable %d of degree %d", call, index[d], d,
                           b->degree[d]);
        *place = *place * ((size_t)b->degree[d] + 1) + (size_t)index[d];
    }
    return KN_OK;
}

// out = B_place over b's weight: the derivative of b by the homogeneous control point at that place. In scratch.
static kn_status basis_function(kn_ctx *ctx, kn_bezier *out, const kn_bezier *b, size_t place)
{
    size_t n = kn_bezier_count(b);
    *out = *b;
    out->ncomp = 1 + b->rational;
    kn_status status = kn_bezier_scratch(ctx, out, "sensitivity");
    if (status != KN_OK) return status;
    memset(out->coef, 0, n * sizeof *out->coef);
    out->coef[place] = 1.0;
    if (b->rational) memcpy(out->coef + n, b->coef + (size_t)(b->ncomp - 1) * n, n * sizeof *out->coef);
    return KN_OK;
}

// f(x) = sum_i c_i B_i(inner(x)) is linear in outer's control points: d f / d c_i = B_i(inner(x)), over outer's
// weight when it has one.
kn_status kn_bezier_compose_outer_sensitivity(kn_ctx *ctx, kn_bezier *out, const kn_bezier *outer,
                                              const kn_bezier *inner, const int *index)
{
    size_t place;
    kn_bezier basis;
    kn_status status = kn_bezier_check_operand(ctx, "outer sensitivity", outer);
    if (status == KN_OK) status = place_of(ctx, &place, "outer sensitivity", outer, index);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    status = basis_function(ctx, &basis, outer, place);
    if (status == KN_OK) status = kn_bezier_compose(ctx, out, &basis, inner);
    kn_scratch_release(ctx, mark);
    return status;
}

// out += y_d d_d outer. Of a rational outer y_d has degree 1 in every variable on which outer depends, so that all
// terms have one weight.
static kn_status add_radial(kn_ctx *ctx, kn_bezier *out, const kn_bezier *outer, int d)
{
    int degree[KN_MAX_VARS];
    kn_bezier y = {0}, term = {0};
    for (int k = 0; k < outer->nvars; k++) degree[k] = outer->rational ? outer->degree[k] > 0 : k == d;
    kn_status status = kn_bezier_init(ctx, &y, outer->nvars, 1, false, degree);
    if (status == KN_OK) {
        kn_axis axis = kn_bezier_axis(&y, d);
        size_t n = kn_bezier_count(&y);
        for (size_t i = 0; i < n; i++) y.coef[i] = (double)(i / axis.inner % 2);
        status = kn_bezier_derivative(ctx, &term, outer, d);
    }
    if (status == KN_OK) status = kn_bezier_product(ctx, &term, &y, &term);
    if (status == KN_OK && out->coef) status = kn_bezier_sum(ctx, out, out, &term);
    if (status == KN_OK && !out->coef) kn_bezier_swap(out, &term);
    kn_bezier_clear(ctx, &y);
    kn_bezier_clear(ctx, &term);
    return status;
}

// -sum_d y_d d_d outer: what the derivative by the weight of inner's control point carries.
static kn_status radial(kn_ctx *ctx, kn_bezier *out, const kn_bezier *outer)
{
    kn_status status = KN_OK;
    for (int d = 0; status == KN_OK && d < outer->nvars; d++)
        if (outer->degree[d] > 0) status = add_radial(ctx, out, outer, d);
    if (status == KN_OK && !out->coef) { // a constant: the derivative is zero
        status = kn_bezier_derivative(ctx, out, outer, 0);
    }
    return status == KN_OK ? kn_bezier_scale(ctx, out, out, -1.0) : status;
}

// With inner = X/w (w = 1 for a polynomial) and B the Bernstein polynomial of the control point,
//     d f / d X_comp = (d_comp outer)(inner) B / w,    d f / d w = -sum_d (y_d d_d outer)(inner) B / w.
kn_status kn_bezier_compose_inner_sensitivity(kn_ctx *ctx, kn_bezier *out, const kn_bezier *outer,
                                              const kn_bezier *inner, int comp, const int *index)
{
    size_t place;
    kn_bezier slope = {0}, basis;
    kn_status status = kn_bezier_check_operand(ctx, "inner sensitivity", outer);
    if (status == KN_OK) status = kn_bezier_check_operand(ctx, "inner sensitivity", inner);
    if (status == KN_OK) status = place_of(ctx, &place, "inner sensitivity", inner, index);
    if (status != KN_OK) return status;
    if (outer->nvars < 1 || kn_bezier_dim(inner) != outer->nvars || comp < 0 || comp >= inner->ncomp)
        return kn_fail(ctx, KN_EDOMAIN, "inner sensitivity: component %d of %d, %d outer variables", comp,
                       inner->ncomp, outer->nvars);
    kn_mark mark = kn_scratch_mark(ctx);
    status = comp < outer->nvars ? kn_bezier_derivative(ctx, &slope, outer, comp) : radial(ctx, &slope, outer);
    if (status == KN_OK) status = kn_bezier_compose(ctx, &slope, &slope, inner);
    if (status == KN_OK) status = basis_function(ctx, &basis, inner, place);
    if (status == KN_OK) status = kn_bezier_product(ctx, out, &slope, &basis);
    kn_bezier_clear(ctx, &slope);
    kn_scratch_release(ctx, mark);
    return status;
}
