// SPDX-License-Identifier: Apache-2.0
// Small things that several parts of a shell need.
#include "kernel/context.h"
#include "trivar/internal.h"

#include <math.h>

int kn_interval(const double *breaks, int n, double x)
{
    int lo = 0, hi = n - 1;
    while (hi - lo > 1) {
        int mid = lo + (hi - lo) / 2;
        if (x < breaks[mid])
            hi = mid;
        else
            lo = mid;
    }
    return lo;
}

kn_extent kn_extent_of(const kn_spline *s)
{
    const double units = 0x1p-49;
    size_t count = kn_spline_count(s);
    kn_extent e = {0};
    for (size_t c = 0; c < 3; c++) {
        double lo = INFINITY, hi = -INFINITY;
        for (size_t i = 0; i < count; i++) {
            double x = s->coef[c * count + i] / (s->rational ? s->coef[3 * count + i] : 1.0);
            lo = fmin(lo, x), hi = fmax(hi, x);
        }
        e.size = fmax(e.size, hi - lo);
        e.middle[c] = 0.5 * lo + 0.5 * hi;
        e.slack = fmax(e.slack, units * fmax(-lo, hi));
    }
    return e;
}

kn_row kn_edge_row(const int count[2], int var, int end)
{
    kn_row row = {.step = var == 0 ? 1 : (size_t)count[1], .count = (size_t)count[1 - var]};
    if (end) row.first = (size_t)(count[var] - 1) * (var == 0 ? row.count : 1);
    return row;
}

bool kn_one_point(const double *coef, size_t size, bool rational, const kn_row *row, double near)
{
    for (size_t k = 1; k < row->count; k++) {
        const double *p = coef + row->first, *q = p + k * row->step;
        for (size_t c = 0; c < 3; c++) {
            double x = p[c * size], y = q[c * size];
            if (rational) x /= p[3 * size], y /= q[3 * size];
            if (!(fabs(y - x) <= near)) return false;
        }
    }
    return true;
}

double kn_gamma(double k)
{
    double ku = k * 0x1p-53;
    return ku / (1.0 - ku);
}

kn_status kn_fail_normal(kn_ctx *ctx, const kn_shell *shell, const double at[2], bool singular)
{
    double p[3];
    kn_status status = kn_spline_eval(ctx, p, &shell->surface, at);
    if (status != KN_OK) return status;
    if (singular)
        return kn_fail(ctx, KN_EUNDEFINED,
                       "shell: the surface has no normal at (%.6g, %.6g), at the point (%.6g, %.6g, %.6g)%s", at[0],
                       at[1], p[0], p[1], p[2], kn_thin_edge(shell));
    return kn_fail(ctx, KN_EUNDECIDED,
                   "shell: could not decide whether the surface has a normal everywhere near (%.6g, %.6g), the point "
                   "(%.6g, %.6g, %.6g)%s",
                   at[0], at[1], p[0], p[1], p[2], kn_thin_edge(shell));
}
