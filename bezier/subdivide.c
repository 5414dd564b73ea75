// SPDX-License-Identifier: Apache-2.0
// Subdivision at a parameter.
#include "bezier/shape.h"
#include "kernel/bernstein.h"

#include <math.h>

// Both or none: where right needs a new array it is made aside before left changes.
static kn_status store_both(kn_ctx *ctx, kn_bezier *left, kn_bezier *right, const kn_bezier *l, const kn_bezier *r)
{
    kn_bezier made = {0};
    bool fits = right->coef && (size_t)right->ncomp * kn_bezier_count(right) == (size_t)r->ncomp * kn_bezier_count(r);
    kn_status status = fits ? KN_OK : kn_bezier_store(ctx, &made, r);
    if (status == KN_OK) status = kn_bezier_store(ctx, left, l);
    if (status == KN_OK && fits) status = kn_bezier_store(ctx, right, r); // cannot fail
    if (status == KN_OK && !fits) kn_bezier_swap(right, &made);
    kn_bezier_clear(ctx, &made);
    return status;
}

kn_status kn_bezier_subdivide(kn_ctx *ctx, kn_bezier *left, kn_bezier *right, const kn_bezier *a, int var, double at)
{
    kn_status status = kn_bezier_check_operand(ctx, "subdivide", a);
    if (status == KN_OK) status = kn_bezier_check_var(ctx, "subdivide", a, var);
    if (status == KN_OK && !isfinite(at)) status = kn_fail(ctx, KN_EDOMAIN, "subdivide: at %g", at);
    if (status != KN_OK) return status;
    kn_bezier l = *a, r = *a;
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_bezier_scratch(ctx, &l, "subdivide");
    if (status == KN_OK) status = kn_bezier_scratch(ctx, &r, "subdivide");
    if (status == KN_OK) {
        kn_axis x = kn_bezier_axis(a, var);
        kn_bernstein_split(l.coef, r.coef, a->coef, x.outer, a->degree[var], x.inner, at);
        status = store_both(ctx, left, right, &l, &r);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
