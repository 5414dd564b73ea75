// SPDX-License-Identifier: Apache-2.0
// Curves of a trim: their ends, their direction, polylines.
#include "kernel/context.h"
#include "trim/internal.h"

void kn_trim_ends(const kn_spline *curve, double start[2], double end[2])
{
    int n = curve->count[0];
    for (int c = 0; c < 2; c++) {
        if (start) start[c] = curve->coef[c * n];
        if (end) end[c] = curve->coef[c * n + n - 1];
    }
}

static void swap(double *a, double *b)
{
    double t = *a;
    *a = *b;
    *b = t;
}

void kn_trim_turn(kn_spline *curve)
{
    int n = curve->count[0], m = n + curve->degree[0] + 1;
    for (int c = 0; c < curve->ncomp; c++)
        for (int i = 0, j = n - 1; i < j; i++, j--) swap(&curve->coef[c * n + i], &curve->coef[c * n + j]);
    for (int i = 0, j = m - 1; i < j; i++, j--) swap(&curve->knots[0][i], &curve->knots[0][j]);
    for (int i = 0; i < m; i++) curve->knots[0][i] = 0.0 - curve->knots[0][i]; // never -0
}

kn_status kn_trim_polyline(kn_ctx *ctx, kn_spline *out, const double *points, size_t n)
{
    if (n > 1000000) return kn_fail(ctx, KN_ELIMIT, "trim: a polyline of %zu points", n);
    kn_spline made = {0};
    const int degree = 1, count = (int)n;
    kn_mark mark = kn_scratch_mark(ctx);
    double *knots = kn_scratch(ctx, n + 2, sizeof *knots);
    kn_status status = knots ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        knots[0] = 0.0, knots[n + 1] = (double)(n - 1);
        for (size_t i = 0; i < n; i++) knots[i + 1] = (double)i;
        status = kn_spline_init(ctx, &made, 1, 2, false, &degree, &count, (const double *const[]){knots}, NULL);
    }
    for (size_t i = 0; status == KN_OK && i < n; i++)
        for (size_t c = 0; c < 2; c++) made.coef[c * n + i] = points[2 * i + c];
    if (status == KN_OK) kn_spline_swap(out, &made);
    kn_spline_clear(ctx, &made);
    kn_scratch_release(ctx, mark);
    return status;
}
