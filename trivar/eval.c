// SPDX-License-Identifier: Apache-2.0
// T, its Jacobian matrix, and the true unit normal at a point.
#include "kernel/context.h"
#include "trivar/internal.h"

#include <math.h>
#include <string.h>

// w^power and its derivative.
static void power_of(double out[2], double w, int power)
{
    double lower = 1.0;
    for (int k = 1; k < power; k++) lower *= w;
    out[0] = lower * w;
    out[1] = power * lower;
}

// Adds w^power h f: point, and the columns of jacobian when it is not NULL. f and h: value, d/du, d/dv; h NULL: 1.
static void add_field(double point[3], double *jacobian, const double *f, const double *h, double w, int power)
{
    double wk[2];
    power_of(wk, w, power);
    for (int c = 0; c < 3; c++) {
        double value = h ? h[0] * f[c] : f[c];
        point[c] += wk[0] * value;
        if (!jacobian) continue;
        for (int v = 1; v <= 2; v++)
            jacobian[3 * c + v - 1] += wk[0] * (h ? h[v] * f[c] + h[0] * f[3 * v + c] : f[3 * v + c]);
        jacobian[3 * c + 2] += wk[1] * value;
    }
}

static kn_status eval_volume(kn_ctx *ctx, double point[3], double *jacobian, const kn_spline *volume,
                             const double at[3])
{
    double d[12]; // value and three derivatives of three components each
    kn_status status = kn_spline_derivatives(ctx, d, volume, at, jacobian ? 1 : 0);
    for (int c = 0; c < 3 && status == KN_OK; c++) {
        point[c] = d[c];
        for (int v = 0; v < 3 && jacobian; v++) jacobian[3 * c + v] = d[3 * (v + 1) + c];
    }
    return status;
}

static kn_status eval_sum(kn_ctx *ctx, double point[3], double *jacobian, const kn_shell *shell, const double at[2],
                          double w)
{
    double f[9], h[3], p[3], j[9] = {0}, *into = jacobian ? j : NULL; // value, d/du, d/dv of each
    int order = jacobian ? 1 : 0;
    bool thick = shell->thickness.whole.coef != NULL;
    kn_status status = kn_spline_derivatives(ctx, f, &shell->surface, at, order);
    for (int c = 0; c < 3 && status == KN_OK; c++) {
        p[c] = f[c];
        for (int v = 0; v < 2 && jacobian; v++) j[3 * c + v] = f[3 * (v + 1) + c];
    }
    if (status == KN_OK && shell->normal.coef) {
        status = kn_spline_derivatives(ctx, f, &shell->normal, at, order);
        if (status == KN_OK && thick) status = kn_spline_derivatives(ctx, h, &shell->thickness.whole, at, order);
        if (status == KN_OK) add_field(p, into, f, thick ? h : NULL, w, 1);
    }
    for (int k = 0; k < shell->nfields && status == KN_OK; k++) {
        status = kn_spline_derivatives(ctx, f, &shell->field[k].whole, at, order);
        if (status == KN_OK) add_field(p, into, f, NULL, w, shell->field[k].power);
    }
    if (status != KN_OK) return status;
    memcpy(point, p, sizeof p);
    if (jacobian) memcpy(jacobian, j, sizeof j);
    return KN_OK;
}

kn_status kn_shell_eval(kn_ctx *ctx, double point[3], double *jacobian, const kn_shell *shell, double u, double v,
                        double w)
{
    const double at[3] = {u, v, w};
    if (!isfinite(u) || !isfinite(v) || !isfinite(w))
        return kn_fail(ctx, KN_EDOMAIN, "shell: evaluation at (%g, %g, %g)", u, v, w);
    if (shell->volume.coef) return eval_volume(ctx, point, jacobian, &shell->volume, at);
    return eval_sum(ctx, point, jacobian, shell, at, w);
}

// S_u x S_v itself, where the shell keeps no directions.
static kn_status cross_normal(kn_ctx *ctx, double unit[3], const kn_shell *shell, const double at[2])
{
    double d[9], n[3], largest = 0.0, length = 0.0;
    kn_status status = kn_spline_derivatives(ctx, d, &shell->surface, at, 1);
    if (status != KN_OK) return status;
    for (int c = 0; c < 3; c++) {
        int a = (c + 1) % 3, b = (c + 2) % 3;
        n[c] = d[3 + a] * d[6 + b] - d[3 + b] * d[6 + a];
        largest = fmax(largest, fabs(n[c]));
    }
    if (!(largest > 0.0) || !isfinite(largest)) return kn_fail_normal(ctx, shell, at, true);
    for (int c = 0; c < 3; c++) length += n[c] / largest * (n[c] / largest);
    for (int c = 0; c < 3; c++) unit[c] = n[c] / largest / sqrt(length);
    return KN_OK;
}

kn_status kn_shell_unit_normal(kn_ctx *ctx, double normal[3], const kn_shell *shell, double u, double v)
{
    const double at[2] = {u, v};
    double x[2], unit[3];
    int span[2];
    if (!isfinite(u) || !isfinite(v)) return kn_fail(ctx, KN_EDOMAIN, "shell: normal at (%g, %g)", u, v);
    if (!shell->direction) return cross_normal(ctx, normal, shell, at);
    for (int k = 0; k < 2; k++) {
        const double *knot = shell->knot[k];
        span[k] = kn_interval(knot, shell->nknots[k], at[k]);
        x[k] = (at[k] - knot[span[k]]) / (knot[span[k] + 1] - knot[span[k]]);
    }
    if (!kn_direction_unit(unit, &shell->direction[span[0] * (shell->nknots[1] - 1) + span[1]].n, x))
        return kn_fail_normal(ctx, shell, at, true);
    for (int c = 0; c < 3; c++) normal[c] = unit[c];
    return KN_OK;
}
