// SPDX-License-Identifier: Apache-2.0
// Subdivision at a parameter.
#include "bezier/shape.h"
#include "kernel/bernstein.h"

#include <math.h>

kn_status kn_bezier_subdivide(kn_ctx *ctx, kn_bezier *left, kn_bezier *right, const kn_bezier *a, int var, double at)
{
    kn_status status = kn_bezier_check_operand(ctx, "subdivide", a);
    if (status == KN_OK) status = kn_bezier_check_var(ctx, "subdivide", a, var);
    if (status == KN_OK && !isfinite(at)) status = kn_fail(ctx, KN_EDOMAIN, "subdivide: at %g", at);
    if (status != KN_OK) return status;
    kn_bezier l = *a, r = *a;
    l.coef = r.coef = NULL;
    status = kn_bezier_alloc(ctx, &l, "subdivide");
    if (status == KN_OK) status = kn_bezier_alloc(ctx, &r, "subdivide");
    if (status == KN_OK) {
        kn_axis x = kn_bezier_axis(a, var);
        kn_bernstein_split(l.coef, r.coef, a->coef, x.outer, a->degree[var], x.inner, at);
    }
    (void)kn_bezier_finish(ctx, left, &l, status);
    return kn_bezier_finish(ctx, right, &r, status);
}
