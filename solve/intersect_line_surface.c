// SPDX-License-Identifier: Apache-2.0
// Where a line meets a surface: (S - p) x d = 0, of which the two components with the largest part of d say it all.
#include "solve/cells.h"

#include "kernel/context.h"

// (S_i - p_i) d_k - (S_k - p_k) d_i for both i that are not k. With S = P / w, a = P - w p: one rounding of the
// difference, and one of w p where w is not 1; two products and a difference on top.
static void equations(double *coef, double *error, const kn_spline *s, const double *p, const double *d)
{
    int k = fabs(d[0]) > fabs(d[1]) ? 0 : 1;
    if (fabs(d[2]) > fabs(d[k])) k = 2;
    size_t n = kn_spline_count(s);
    const double *w = s->rational ? s->coef + 3 * n : NULL, *pk = s->coef + (size_t)k * n;
    for (int e = 0; e < 2; e++) {
        int i = (k + 1 + e) % 3;
        const double *pi = s->coef + (size_t)i * n;
        error[e] = 0.0;
        for (size_t j = 0; j < n; j++) {
            double wj = w ? w[j] : 1.0, ai = pi[j] - wj * p[i], ak = pk[j] - wj * p[k];
            double size = fabs(ai) * fabs(d[k]) + fabs(ak) * fabs(d[i]);
            double shift = w ? wj * (fabs(p[i]) * fabs(d[k]) + fabs(p[k]) * fabs(d[i])) : 0.0;
            coef[(size_t)e * n + j] = ai * d[k] - ak * d[i];
            error[e] = fmax(error[e], kn_rounding(4.0) * size + kn_rounding(2.0) * shift);
        }
        error[e] = error[e] * (1.0 + 0x1p-40) + kn_underflow();
    }
}

// The line's parameter of each point, as a value and not as a bound.
static kn_status along(kn_ctx *ctx, kn_root *roots, size_t n, const kn_spline *s, const double *p, const double *d)
{
    double dd = d[0] * d[0] + d[1] * d[1] + d[2] * d[2], x[3];
    kn_status status = KN_OK;
    for (size_t i = 0; i < n && status == KN_OK; i++) {
        status = kn_spline_eval(ctx, x, s, roots[i].at);
        double t = 0.0;
        for (int c = 0; c < 3; c++) t += (x[c] - p[c]) * (d[c] / dd);
        roots[i].at[2] = roots[i].lo[2] = roots[i].hi[2] = t;
    }
    return status;
}

kn_status kn_solve_intersect_line_surface(kn_ctx *ctx, kn_root **roots, size_t *nroots, kn_solve_report *report,
                                          const kn_spline *surface, const double *point, const double *direction,
                                          const kn_solve_options *options)
{
    double size = fabs(direction[0]) + fabs(direction[1]) + fabs(direction[2]), error[2];
    size_t n = 0, found = 0;
    kn_root *list = NULL;
    kn_solve_report r = {0};
    kn_status status = kn_spline_check(ctx, surface);
    if (status != KN_OK) return status;
    if (surface->nvars != 2 || kn_spline_dim(surface) != 3)
        return kn_fail(ctx, KN_EDOMAIN, "line: %d variables, dimension %d", surface->nvars, kn_spline_dim(surface));
    if (!(size > 0.0 && size < 0x1p500) || !(fabs(point[0]) + fabs(point[1]) + fabs(point[2]) < 0x1p500))
        return kn_fail(ctx, KN_EDOMAIN, "line: point %g %g %g, direction %g %g %g", point[0], point[1], point[2],
                       direction[0], direction[1], direction[2]);
    n = kn_spline_count(surface);
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline f = *surface;
    f.ncomp = 2, f.rational = false;
    f.coef = kn_scratch(ctx, 2 * n, sizeof *f.coef);
    status = f.coef ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        equations(f.coef, error, surface, point, direction);
        status = kn_zeros_within(ctx, &list, &found, &r, &f, 1, error, options);
    }
    if (status == KN_OK) status = along(ctx, list, found, surface, point, direction);
    if (status == KN_OK) {
        *roots = list, *nroots = found;
        if (report) *report = r;
    } else {
        kn_free(ctx, list);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
