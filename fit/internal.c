// SPDX-License-Identifier: Apache-2.0
// What the fits share.
#include "fit/internal.h"

#include <string.h>

#include "kernel/context.h"
#include "spline/internal.h"

kn_status kn_fit_expect(kn_ctx *ctx, const char *call, int nvars, int dim, const int *degree, const int *count,
                        const double *const *knots)
{
    kn_status status = kn_spline_shape(ctx, call, nvars, dim, false, degree, count);
    for (int d = 0; d < nvars && status == KN_OK; d++) {
        const char *fault = kn_knots_fault(knots[d], degree[d], count[d]);
        if (fault) return kn_fail(ctx, KN_EDOMAIN, "%s: variable %d: %s", call, d, fault);
    }
    return status;
}

kn_status kn_fit_start(kn_ctx *ctx, const char *call, kn_spline *s, int nvars, int dim, const int *degree,
                       const int *count, const double *const *knots)
{
    kn_status status = kn_fit_expect(ctx, call, nvars, dim, degree, count, knots);
    if (status != KN_OK) return status;
    *s = (kn_spline){.nvars = nvars, .ncomp = dim};
    for (int d = 0; d < nvars; d++) s->degree[d] = degree[d], s->count[d] = count[d];
    status = kn_spline_in_scratch(ctx, call, s);
    for (int d = 0; d < nvars && status == KN_OK; d++)
        memcpy(s->knots[d], knots[d], (size_t)(count[d] + degree[d] + 1) * sizeof *s->knots[d]);
    return status;
}

kn_status kn_fit_expect_axis(kn_ctx *ctx, const char *call, const double *knots, int degree, int count)
{
    return kn_fit_expect(ctx, call, 1, 1, &degree, &count, &knots);
}

bool kn_fit_acts(const kn_fit_axis *axis, int i, double x)
{
    const double *t = axis->knots + i;
    int p = axis->degree;
    if (t[0] < x && x < t[p + 1]) return true;
    if (x == t[0]) return t[p] == x;
    return i == axis->count - 1 && x == t[p + 1]; // the end of the domain belongs to the last piece
}

kn_status kn_fit_spans(kn_ctx *ctx, const char *call, int *span, const kn_fit_axis *axis)
{
    double lo = axis->knots[0], hi = axis->knots[axis->count + axis->degree];
    for (int i = 0; i < axis->nsites; i++) {
        double x = axis->sites[i];
        if (!(x >= lo && x <= hi))
            return kn_fail(ctx, KN_EDOMAIN, "%s: variable %d: site %d, %g, is not in [%g, %g]", call, axis->var, i, x,
                           lo, hi);
        if (i > 0 && !(axis->sites[i - 1] < x))
            return kn_fail(ctx, KN_EDOMAIN, "%s: variable %d: site %d, %g, after %g: they must increase", call,
                           axis->var, i, x, axis->sites[i - 1]);
        span[i] = kn_knots_span(axis->knots, axis->degree, axis->count, x);
    }
    return KN_OK;
}

// B-splines and sites increase together: each takes the first site that is left and lies in its support.
kn_status kn_fit_suits(kn_ctx *ctx, const char *call, const kn_fit_axis *axis, int first, int end)
{
    const double *x = axis->sites;
    int k = 0;
    for (int i = first; i < end; i++, k++) {
        while (k < axis->nsites && (!kn_fit_acts(axis, i, x[k]) || (k > 0 && x[k] == x[k - 1]))) k++;
        if (k == axis->nsites)
            return kn_fail(ctx, KN_EUNDEFINED, "%s: variable %d: no site for B-spline %d on [%g, %g]", call,
                           axis->var, i, axis->knots[i], axis->knots[i + axis->degree + 1]);
    }
    return KN_OK;
}

kn_status kn_fit_basis(kn_ctx *ctx, kn_band *band, const kn_fit_axis *axis, const int *span)
{
    kn_status status = kn_spline_band(ctx, band, axis->nsites, axis->degree + 1);
    for (int i = 0; i < axis->nsites && status == KN_OK; i++) {
        band->first[i] = span[i] - axis->degree;
        kn_knots_basis(band->w + (size_t)i * (size_t)band->width, axis->knots, axis->degree, span[i], axis->sites[i],
                       0);
    }
    return status;
}

void kn_fit_by_component(double *to, const double *from, size_t n, int ncomp)
{
    for (int c = 0; c < ncomp; c++)
        for (size_t i = 0; i < n; i++) *to++ = from[i * (size_t)ncomp + (size_t)c];
}

kn_status kn_fit_check_fixed(kn_ctx *ctx, const char *call, int nvars, const int *count, const kn_fit_fixed *fixed)
{
    if (!fixed) return KN_OK;
    bool any = false;
    for (int d = 0; d < nvars; d++) {
        int first = fixed->first[d], last = fixed->last[d];
        if (first < 0 || last < 0 || first >= count[d] || last >= count[d] - first)
            return kn_fail(ctx, KN_EDOMAIN, "%s: variable %d: %d and %d fixed layers of %d", call, d, first, last,
                           count[d]);
        any = any || first > 0 || last > 0;
    }
    if (any && !fixed->coef) return kn_fail(ctx, KN_EDOMAIN, "%s: fixed layers without coefficients", call);
    return KN_OK;
}

// The place of control point `at` among the free ones; SIZE_MAX when it is fixed.
static size_t free_place(size_t at, int nvars, const int *count, const kn_fit_fixed *fixed)
{
    size_t place = 0, stride = 1;
    for (int d = nvars - 1; d >= 0; d--) {
        int n = count[d], i = (int)(at % (size_t)n), first = fixed ? fixed->first[d] : 0;
        int nfree = n - first - (fixed ? fixed->last[d] : 0);
        if (i < first || i >= first + nfree) return SIZE_MAX;
        place += (size_t)(i - first) * stride;
        stride *= (size_t)nfree;
        at /= (size_t)n;
    }
    return place;
}

static size_t product(int nvars, const int *count)
{
    size_t n = 1;
    for (int d = 0; d < nvars; d++) n *= (size_t)count[d];
    return n;
}

void kn_fit_put_fixed(double *coef, int nvars, int dim, const int *count, const kn_fit_fixed *fixed)
{
    size_t n = product(nvars, count);
    memset(coef, 0, n * (size_t)dim * sizeof *coef);
    for (size_t i = 0; i < n && fixed; i++)
        if (free_place(i, nvars, count, fixed) == SIZE_MAX)
            for (size_t c = 0; c < (size_t)dim; c++) coef[c * n + i] = fixed->coef[c * n + i];
}

void kn_fit_put_free(double *coef, const double *free, int nvars, int dim, const int *count,
                     const kn_fit_fixed *fixed)
{
    size_t n = product(nvars, count), nfree = 1;
    for (int d = 0; d < nvars; d++) nfree *= (size_t)(count[d] - (fixed ? fixed->first[d] + fixed->last[d] : 0));
    for (size_t i = 0; i < n; i++) {
        size_t place = free_place(i, nvars, count, fixed);
        for (size_t c = 0; c < (size_t)dim && place != SIZE_MAX; c++) coef[c * n + i] = free[c * nfree + place];
    }
}
