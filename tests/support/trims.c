// SPDX-License-Identifier: Apache-2.0
#include "tests/support/trims.h"
#include "tests/support/support.h"
#include "kernel/context.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void trims_add_curve(kn_ctx *ctx, kn_trim *trim, int degree, const double *x, const double *y)
{
    double knots[2 * 4], coef[2 * 4];
    const int count = degree + 1;
    for (int i = 0; i <= degree; i++) {
        knots[i] = 0, knots[count + i] = 1;
        coef[i] = x[i], coef[count + i] = y[i];
    }
    kn_spline *curves = kn_resize(ctx, trim->curves, (size_t)trim->ncurves + 1, sizeof *curves);
    assert_non_null(curves);
    trim->curves = curves;
    curves[trim->ncurves] = (kn_spline){0};
    assert_int_equal(kn_spline_init(ctx, &curves[trim->ncurves++], 1, 2, false, &degree, &count,
                                    (const double *const[]){knots}, coef),
                     KN_OK);
}

void trims_end_loop(kn_ctx *ctx, kn_trim *trim)
{
    int *ends = kn_resize(ctx, trim->loop_end, (size_t)trim->nloops + 1, sizeof *ends);
    assert_non_null(ends);
    trim->loop_end = ends;
    ends[trim->nloops++] = trim->ncurves;
}

void trims_add_box(kn_ctx *ctx, kn_trim *trim, double x0, double y0, double x1, double y1)
{
    const double x[5] = {x0, x1, x1, x0, x0}, y[5] = {y0, y0, y1, y1, y0};
    for (int k = 0; k < 4; k++) trims_add_curve(ctx, trim, 1, x + k, y + k);
    trims_end_loop(ctx, trim);
}

void trims_add_oval(kn_ctx *ctx, kn_trim *trim, double cx, double cy, double a, double b, bool hole)
{
    static const double c[5] = {1, 0, -1, 0, 1}, s[5] = {0, 1, 0, -1, 0}, k = 0.5522847498;
    for (int q = 0; q < 4; q++) {
        int i = hole ? 4 - q : q, j = hole ? 3 - q : q + 1;
        double t = hole ? -k : k;
        const double x[4] = {cx + a * c[i], cx + a * (c[i] - t * s[i]), cx + a * (c[j] + t * s[j]), cx + a * c[j]};
        const double y[4] = {cy + b * s[i], cy + b * (s[i] + t * c[i]), cy + b * (s[j] - t * c[j]), cy + b * s[j]};
        trims_add_curve(ctx, trim, 3, x, y);
    }
    trims_end_loop(ctx, trim);
}

void trims_plate_with_hole(kn_ctx *ctx, kn_trim *trim)
{
    trims_add_box(ctx, trim, 0, 0, 1, 1);
    trims_add_oval(ctx, trim, 0.45, 0.52, 0.23, 0.27, true);
}

void trims_disc(kn_ctx *ctx, kn_trim *trim)
{
    trims_add_oval(ctx, trim, 0.5, 0.47, 0.38, 0.41, false);
}

void trims_bay(kn_ctx *ctx, kn_trim *trim)
{
    const double x[4] = {1, 0.9, 0.3, 0}, y[4] = {0.3, 0.9, 0.1, 0.8};
    trims_add_curve(ctx, trim, 1, (const double[]){0, 1}, (const double[]){0, 0});
    trims_add_curve(ctx, trim, 1, (const double[]){1, 1}, (const double[]){0, 0.3});
    trims_add_curve(ctx, trim, 3, x, y);
    trims_add_curve(ctx, trim, 1, (const double[]){0, 0}, (const double[]){0.8, 0});
    trims_end_loop(ctx, trim);
}

static double bezier(const double *c, int degree, double t)
{
    double x[4];
    memcpy(x, c, ((size_t)degree + 1) * sizeof *x);
    for (int m = degree; m > 0; m--)
        for (int n = 0; n < m; n++) x[n] = (1 - t) * x[n] + t * x[n + 1];
    return x[0];
}

double *trims_dense(const kn_trim *trim)
{
    double *p = malloc((size_t)trim->ncurves * (TRIMS_DENSE + 1) * 2 * sizeof *p);
    assert_non_null(p);
    for (int i = 0; i < trim->ncurves; i++) {
        const kn_spline *c = &trim->curves[i];
        for (int k = 0; k <= TRIMS_DENSE; k++)
            for (int d = 0; d < 2; d++)
                p[2 * (i * (TRIMS_DENSE + 1) + k) + d] = bezier(c->coef + d * c->count[0], c->degree[0],
                                                                (double)k / TRIMS_DENSE);
    }
    return p;
}

bool trims_is_inside(const kn_trim *trim, const double *points, double x, double y)
{
    int winding = 0;
    for (int i = 0; i < trim->ncurves; i++)
        for (int k = 0; k < TRIMS_DENSE; k++) {
            const double *p = points + 2 * (i * (TRIMS_DENSE + 1) + k), *q = p + 2;
            double left = (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
            if (p[1] <= y && q[1] > y && left > 0) winding++;
            if (p[1] > y && q[1] <= y && left < 0) winding--;
        }
    return winding > 0;
}

// The integral of x dy, of degree 5: three places by Gauss are exact.
double trims_area(const kn_trim *trim)
{
    static const double at[3] = {0.11270166537925831, 0.5, 0.88729833462074169}, weight[3] = {5, 8, 5};
    double area = 0;
    for (int i = 0; i < trim->ncurves; i++) {
        const double *x = trim->curves[i].coef;
        int p = trim->curves[i].degree[0];
        double dy[3];
        for (int k = 0; k < p; k++) dy[k] = p * (x[p + 2 + k] - x[p + 1 + k]);
        for (int k = 0; k < 3; k++) area += weight[k] / 18 * bezier(x, p, at[k]) * bezier(dy, p - 1, at[k]);
    }
    return area;
}

double trims_off(const kn_trim *trim, const double *points, double u, double v)
{
    double least = INFINITY;
    if (trims_is_inside(trim, points, u, v)) return 0;
    for (int i = 0; i < trim->ncurves; i++)
        for (int k = 0; k < TRIMS_DENSE; k++) {
            const double *p = points + 2 * (i * (TRIMS_DENSE + 1) + k), *q = p + 2;
            double a = (q[0] - p[0]) * 2, b = (q[1] - p[1]) * 3, x = (u - p[0]) * 2, y = (v - p[1]) * 3;
            double t = fmin(fmax((a * x + b * y) / (a * a + b * b), 0), 1);
            double dx = x - t * a, dy = y - t * b, square = dx * dx + dy * dy;
            if (square < least) least = square;
        }
    return sqrt(least);
}
