// SPDX-License-Identifier: Apache-2.0
// Affine maps of values: rotations, projections, changes of dimension.
#include "bezier/shape.h"
#include "kernel/array.h"

#include <string.h>

// (M N/w + b) = (M N + b w) / w.
kn_status kn_bezier_affine(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int dim, const double *matrix,
                           const double *offset)
{
    kn_status status = kn_bezier_check_operand(ctx, "affine", a);
    if (status != KN_OK) return status;
    if (dim < 1) return kn_fail(ctx, KN_EDOMAIN, "affine: %d rows", dim);
    if (dim > KN_MAX_COMPS - a->rational) return kn_fail(ctx, KN_ELIMIT, "affine: %d rows", dim);
    kn_bezier c = *a;
    c.ncomp = dim + a->rational;
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_bezier_begin(ctx, &c, out, kn_bezier_is(out, a), "affine");
    if (status == KN_OK) {
        size_t n = kn_bezier_count(a);
        const double *weight = a->rational ? kn_bezier_comp(a, kn_bezier_dim(a)) : NULL;
        kn_array_affine(c.coef, a->coef, n, dim, kn_bezier_dim(a), matrix, offset, weight);
        if (weight) memcpy(kn_bezier_comp(&c, dim), weight, n * sizeof *weight);
        kn_bezier_end(ctx, out, &c);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
