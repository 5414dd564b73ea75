// SPDX-License-Identifier: Apache-2.0
// Degree elevation: every knot as much more often as the degree rises, the continuity as it was.
#include "spline/in_scratch.h"
#include "kernel/context.h"

kn_status kn_spline_elevate(kn_ctx *ctx, kn_spline *out, const kn_spline *a, const int *degree)
{
    kn_status status = kn_spline_expect(ctx, "spline_elevate", a, 0);
    if (status != KN_OK) return status;
    for (int d = 0; d < a->nvars; d++) {
        if (degree[d] < a->degree[d])
            return kn_fail(ctx, KN_EDOMAIN, "spline_elevate: degree %d to %d in variable %d", a->degree[d], degree[d],
                           d);
        if (degree[d] > KN_MAX_DEGREE)
            return kn_fail(ctx, KN_ELIMIT, "spline_elevate: degree %d in variable %d", degree[d], d);
    }
    kn_spline s = *a; // its shape at first, the result's
    for (int d = 0; d < a->nvars; d++)
        s.count[d] = kn_spline_elevated_count(a, d, degree[d]), s.degree[d] = degree[d];
    status = kn_spline_shape(ctx, "spline_elevate", s.nvars, s.ncomp, s.rational, s.degree, s.count);
    if (status != KN_OK) return status;
    s = *a;
    kn_mark mark = kn_scratch_mark(ctx);
    for (int d = a->nvars - 1; d >= 0 && status == KN_OK; d--)
        status = kn_spline_elevate_in_scratch(ctx, &s, d, degree[d]);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    kn_scratch_release(ctx, mark);
    return status;
}
