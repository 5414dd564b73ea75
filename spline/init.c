// SPDX-License-Identifier: Apache-2.0
// Making a spline from its arrays.
#include <string.h>

#include "spline/internal.h"
#include "kernel/context.h"

kn_status kn_spline_init(kn_ctx *ctx, kn_spline *out, int nvars, int ncomp, bool rational, const int *degree,
                         const int *count, const double *const *knots, const double *coef)
{
    kn_status status = kn_spline_shape(ctx, "spline_init", nvars, ncomp, rational, degree, count);
    if (status != KN_OK) return status;
    for (int d = 0; d < nvars; d++) {
        const char *fault = kn_knots_fault(knots[d], degree[d], count[d]);
        if (fault) return kn_fail(ctx, KN_EDOMAIN, "spline_init: variable %d: %s", d, fault);
    }

    kn_spline s;
    status = kn_spline_alloc(ctx, &s, nvars, ncomp, rational, degree, count);
    if (status != KN_OK) return status;
    for (int d = 0; d < nvars; d++)
        memcpy(s.knots[d], knots[d], ((size_t)count[d] + (size_t)degree[d] + 1) * sizeof *s.knots[d]);
    size_t n = kn_spline_count(&s) * (size_t)ncomp;
    for (size_t i = 0; i < n; i++) s.coef[i] = coef ? coef[i] : 0.0;
    *out = s;
    return KN_OK;
}
