// SPDX-License-Identifier: Apache-2.0
// Knot removal.
#include <math.h>

#include "spline/removal.h"
#include "kernel/context.h"

kn_status kn_spline_remove_knots(kn_ctx *ctx, kn_spline *out, double *error, const kn_spline *a, int var,
                                 double tolerance)
{
    kn_status status = kn_spline_expect(ctx, "spline_remove_knots", a, var);
    if (status == KN_OK) status = kn_spline_expect_tolerance(ctx, "spline_remove_knots", tolerance);
    if (status != KN_OK) return status;
    kn_spline s = *a;
    kn_rows rows;
    double bound = 0.0;
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_rows_of(ctx, &rows, a, var);
    if (status == KN_OK) status = kn_rows_remove(ctx, "spline_remove_knots", &rows, &bound, tolerance, NAN);
    if (status == KN_OK) status = kn_rows_to(ctx, &s, var, &rows);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    if (status == KN_OK && error) *error = bound;
    kn_scratch_release(ctx, mark);
    return status;
}
