// SPDX-License-Identifier: Apache-2.0
// Degree elevation.
#include "bezier/shape.h"
#include "kernel/bernstein.h"

#include <string.h>

// One variable after another: each step is the same map along one axis.
static void elevate_all(double *to, double *other, const kn_bezier *a, const int *degree)
{
    kn_bezier now = *a;
    for (int d = 0; d < a->nvars; d++) {
        if (degree[d] == a->degree[d]) continue;
        kn_axis x = kn_bezier_axis(&now, d);
        kn_bernstein_elevate(to, now.coef, x.outer, now.degree[d], degree[d], x.inner);
        now.degree[d] = degree[d];
        now.coef = to;
        to = other;
        other = now.coef;
    }
}

kn_status kn_bezier_elevate(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, const int *degree)
{
    kn_bezier c = {.nvars = a->nvars, .ncomp = a->ncomp, .rational = a->rational};
    int steps = 0;
    kn_status status = kn_bezier_check_operand(ctx, "elevate", a);
    if (status != KN_OK) return status;
    for (int d = 0; d < a->nvars; d++) {
        if (degree[d] < a->degree[d])
            return kn_fail(ctx, KN_EDOMAIN, "elevate: degree %d to %d in variable %d", a->degree[d], degree[d], d);
        c.degree[d] = degree[d];
        steps += degree[d] != a->degree[d];
    }
    if (steps == 0) return kn_bezier_copy(ctx, out, a);
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_bezier_check(ctx, "elevate", c.nvars, c.ncomp, c.rational, c.degree);
    double *work = NULL;
    if (status == KN_OK && steps > 1 &&
        !(work = kn_scratch(ctx, (size_t)c.ncomp * kn_bezier_count(&c), sizeof *work)))
        status = KN_ENOMEM;
    if (status == KN_OK) status = kn_bezier_begin(ctx, &c, out, kn_bezier_is(out, a), "elevate");
    if (status == KN_OK) { // so that the last of the alternating steps writes to c
        if (steps % 2 == 1)
            elevate_all(c.coef, work, a, degree);
        else
            elevate_all(work, c.coef, a, degree);
        kn_bezier_end(ctx, out, &c);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
