// SPDX-License-Identifier: Apache-2.0
// The integral over the unit box.
#include "bezier/shape.h"
#include "kernel/array.h"

// All Bernstein polynomials of one degree have the same integral: the mean of the coefficients.
kn_status kn_bezier_integral(kn_ctx *ctx, double *out, const kn_bezier *a)
{
    kn_status status = kn_bezier_check_operand(ctx, "integral", a);
    if (status != KN_OK) return status;
    if (a->rational) return kn_fail(ctx, KN_EDOMAIN, "integral: of a rational piece");
    const double *ones[KN_MAX_VARS] = {NULL};
    int count[KN_MAX_VARS];
    for (int d = 0; d < a->nvars; d++) count[d] = a->degree[d] + 1;
    for (int c = 0; c < a->ncomp; c++)
        out[c] = kn_array_weighted_sum(kn_bezier_comp(a, c), a->nvars, count, ones) / (double)kn_bezier_count(a);
    return KN_OK;
}
