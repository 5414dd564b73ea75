// SPDX-License-Identifier: Apache-2.0
// Restriction (or extension) to a box of parameters.
#include "bezier/shape.h"
#include "kernel/bernstein.h"

#include <math.h>
#include <string.h>

static kn_status check_box(kn_ctx *ctx, const kn_bezier *a, const double *lo, const double *hi)
{
    kn_status status = kn_bezier_check_operand(ctx, "restrict", a);
    for (int d = 0; d < a->nvars && status == KN_OK; d++)
        if (!isfinite(lo[d]) || !isfinite(hi[d]))
            status = kn_fail(ctx, KN_EDOMAIN, "restrict: [%g, %g] in variable %d", lo[d], hi[d], d);
    return status;
}

kn_status kn_bezier_restrict(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const double *lo, const double *hi)
{
    kn_status status = check_box(ctx, a, lo, hi);
    if (status != KN_OK) return status;
    kn_bezier c = *a;
    kn_mark mark = kn_scratch_mark(ctx);
    size_t bytes = (size_t)a->ncomp * kn_bezier_count(a) * sizeof *a->coef;
    size_t side = KN_MAX_DEGREE + 1;
    double *matrix = kn_scratch(ctx, side * side, sizeof *matrix), *work = kn_scratch(ctx, bytes, 1);
    status = matrix && work ? kn_bezier_begin(ctx, &c, out, kn_bezier_is(out, a), "restrict") : KN_ENOMEM;
    if (status == KN_OK) {
        memcpy(c.coef, a->coef, bytes);
        for (int d = 0; d < c.nvars; d++) {
            if (lo[d] == 0.0 && hi[d] == 1.0) continue; // exactly unchanged
            kn_axis x = kn_bezier_axis(&c, d);
            int m = c.degree[d] + 1;
            memcpy(work, c.coef, bytes);
            kn_bernstein_restriction(matrix, m - 1, lo[d], hi[d]);
            kn_bernstein_transform(c.coef, work, x.outer, m, m, x.inner, matrix);
        }
        kn_bezier_end(ctx, out, &c);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
