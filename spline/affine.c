// SPDX-License-Identifier: Apache-2.0
// Affine maps of a spline's values.
#include <string.h>

#include "kernel/array.h"
#include "kernel/context.h"
#include "spline/internal.h"

kn_status kn_spline_affine(kn_ctx *ctx, kn_spline *out, const kn_spline *a, int dim, const double *matrix,
                           const double *offset)
{
    kn_status status = kn_spline_expect(ctx, "spline_affine", a, 0);
    if (status != KN_OK) return status;
    if (dim < 1) return kn_fail(ctx, KN_EDOMAIN, "spline_affine: %d rows", dim);
    if (dim > KN_MAX_COMPS - a->rational) return kn_fail(ctx, KN_ELIMIT, "spline_affine: %d rows", dim);
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline s = *a; // its knots
    s.ncomp = dim + a->rational;
    status = kn_spline_shape(ctx, "spline_affine", s.nvars, s.ncomp, s.rational, s.degree, s.count);
    size_t n = kn_spline_count(a);
    s.coef = status == KN_OK ? kn_scratch(ctx, (size_t)s.ncomp * n, sizeof *s.coef) : NULL;
    if (s.coef) {
        const double *weight = a->rational ? a->coef + (size_t)kn_spline_dim(a) * n : NULL;
        kn_array_affine(s.coef, a->coef, n, dim, kn_spline_dim(a), matrix, offset, weight);
        if (weight) memcpy(s.coef + (size_t)dim * n, weight, n * sizeof *weight);
        status = kn_spline_store(ctx, out, &s);
    } else if (status == KN_OK) {
        status = KN_ENOMEM;
    }
    kn_scratch_release(ctx, mark);
    return status;
}
