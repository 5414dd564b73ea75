// SPDX-License-Identifier: Apache-2.0
// Greville sites.
#include "fit/internal.h"

// First knot plus the mean distance from it: exact where the knots are equal, and never beyond them.
static double mean(const double *t, int n)
{
    double sum = 0.0;
    for (int k = 1; k < n; k++) sum += t[k] - t[0];
    double x = t[0] + sum / n;
    return x > t[n - 1] ? t[n - 1] : x;
}

kn_status kn_fit_greville(kn_ctx *ctx, double *sites, const double *knots, int degree, int count)
{
    kn_status status = kn_fit_expect_axis(ctx, "fit_greville", knots, degree, count);
    for (int i = 0; i < count && status == KN_OK; i++)
        sites[i] = degree > 0 ? mean(knots + i + 1, degree) : knots[i] + 0.5 * (knots[i + 1] - knots[i]);
    return status;
}
