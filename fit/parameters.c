// SPDX-License-Identifier: Apache-2.0
// Parameters of data from the distances of its points.
#include <math.h>
#include <string.h>

#include "fit/internal.h"
#include "kernel/context.h"

static double distance(const double *a, const double *b, int dim)
{
    double sum = 0.0;
    for (int c = 0; c < dim; c++) sum += (a[c] - b[c]) * (a[c] - b[c]);
    return sqrt(sum);
}

// step[i] += the part of segment i in the whole length of one line; stride in numbers. False: no length.
static bool add_line(double *step, const double *line, int n, size_t stride, int dim, double exponent)
{
    double total = 0.0;
    for (int i = 0; i < n - 1; i++)
        total += pow(distance(line + (size_t)i * stride, line + (size_t)(i + 1) * stride, dim), exponent);
    if (!(total > 0.0) || !isfinite(total)) return false;
    for (int i = 0; i < n - 1; i++)
        step[i] += pow(distance(line + (size_t)i * stride, line + (size_t)(i + 1) * stride, dim), exponent) / total;
    return true;
}

static kn_status accumulate(kn_ctx *ctx, double *sites, const double *step, int n)
{
    double total = 0.0, sum = 0.0;
    for (int i = 0; i < n - 1; i++) total += step[i];
    if (!(total > 0.0)) return kn_fail(ctx, KN_EUNDEFINED, "fit_parameters: no line has a length");
    for (int i = 0; i < n; i++) {
        double before = i > 0 ? sites[i - 1] : -1.0;
        sites[i] = i == n - 1 ? 1.0 : sum / total;
        if (!(sites[i] > before))
            return kn_fail(ctx, KN_EUNDEFINED, "fit_parameters: points %d and %d coincide", i - 1, i);
        if (i < n - 1) sum += step[i];
    }
    return KN_OK;
}

kn_status kn_fit_parameters(kn_ctx *ctx, double *sites, int nvars, int dim, const int *n, const double *points,
                            int var, double exponent)
{
    if (nvars < 1 || nvars > KN_MAX_VARS || dim < 1 || dim > KN_MAX_COMPS || var < 0 || var >= nvars ||
        !(exponent >= 0.0 && isfinite(exponent)))
        return kn_fail(ctx, KN_EDOMAIN, "fit_parameters: nvars %d, dim %d, variable %d, exponent %g", nvars, dim, var,
                       exponent);
    size_t outer = 1, inner = 1;
    for (int d = 0; d < nvars; d++) {
        if (n[d] < (d == var ? 2 : 1) || (size_t)n[d] > KN_MAX_COEFS / outer / inner)
            return kn_fail(ctx, KN_EDOMAIN, "fit_parameters: %d points in variable %d", n[d], d);
        *(d < var ? &outer : &inner) *= d == var ? 1 : (size_t)n[d];
    }
    kn_mark mark = kn_scratch_mark(ctx);
    int count = n[var];
    double *step = kn_scratch(ctx, (size_t)count, sizeof *step), *x = kn_scratch(ctx, (size_t)count, sizeof *x);
    kn_status status = step && x ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        memset(step, 0, (size_t)count * sizeof *step);
        for (size_t o = 0; o < outer; o++)
            for (size_t i = 0; i < inner; i++) {
                const double *line = points + (o * (size_t)count * inner + i) * (size_t)dim;
                (void)add_line(step, line, count, inner * (size_t)dim, dim,
                               exponent); // points without length: left out
            }
        status = accumulate(ctx, x, step, count);
    }
    if (status == KN_OK) memcpy(sites, x, (size_t)count * sizeof *x);
    kn_scratch_release(ctx, mark);
    return status;
}
