// SPDX-License-Identifier: Apache-2.0
// Knots that suit given sites.
#include <math.h>
#include <string.h>

#include "fit/internal.h"
#include "kernel/context.h"
#include "spline/internal.h"

// t_j+p = the mean of the sites j .. j+p-1: strictly between its neighbours, so that t_i < x_i < t_i+p+1.
static double mean_of_sites(const double *x, int j, int p)
{
    if (p == 0) return x[j - 1] + 0.5 * (x[j] - x[j - 1]);
    double sum = 0.0;
    for (int i = j + 1; i < j + p; i++) sum += x[i] - x[j];
    return x[j] + sum / p;
}

// With d = m / (n - p) sites for each span, t_p+j lies between the sites at i - 1 and i, i = floor(j d).
static double spread(const double *x, int nsites, int spans, int j)
{
    double d = (double)nsites / spans, at = j * d;
    int i = (int)at;
    double part = at - i;
    return x[i - 1] + part * (x[i] - x[i - 1]);
}

kn_status kn_fit_averaged_knots(kn_ctx *ctx, double *knots, int degree, int count, int nsites, const double *sites)
{
    kn_status status = kn_spline_shape(ctx, "fit_averaged_knots", 1, 1, false, &degree, &count);
    if (status != KN_OK) return status;
    if (nsites < count || nsites < 2 || !isfinite(sites[nsites - 1] - sites[0]))
        return kn_fail(ctx, KN_EDOMAIN, "fit_averaged_knots: %d sites for %d coefficients", nsites, count);
    for (int i = 1; i < nsites; i++)
        if (!(sites[i - 1] < sites[i]))
            return kn_fail(ctx, KN_EDOMAIN, "fit_averaged_knots: site %d, %g, after %g", i, sites[i], sites[i - 1]);
    size_t n = (size_t)count + (size_t)degree + 1;
    kn_mark mark = kn_scratch_mark(ctx);
    double *to = kn_scratch(ctx, n, sizeof *to);
    const char *fault = NULL;
    if (to) {
        for (int i = 0; i <= degree; i++) to[i] = sites[0], to[count + i] = sites[nsites - 1];
        for (int j = 1; j < count - degree; j++)
            to[degree + j] = nsites == count ? mean_of_sites(sites, j, degree)
                                             : spread(sites, nsites, count - degree, j);
        fault = kn_knots_fault(to, degree, count); // sites may be neighbouring numbers
        if (!fault) memcpy(knots, to, n * sizeof *to);
    }
    kn_scratch_release(ctx, mark);
    if (fault) return kn_fail(ctx, KN_EDOMAIN, "fit_averaged_knots: %s", fault);
    return to ? KN_OK : KN_ENOMEM;
}
