// SPDX-License-Identifier: Apache-2.0
// Normals through T. With a, b, c the columns of J, T_u, T_v and T_w,
//     J^-T N = (N_u b x c + N_v c x a + N_w a x b) / det(a, b, c),
// a covector: what lies on N's side in texture space lies on the image's side in space, whatever the sign of det.
//
// At a pole along u T_u vanishes as d tau with the distance d > 0 inwards, tau = T_uv or -T_uv. Put a = d tau: as d
// goes to 0 J^-T N goes to infinity along N_u b x c / det(tau, b, c), or when N_u = 0 to (N_v c x tau + N_w tau x b)
// / det(tau, b, c).
#include "kernel/context.h"
#include "trivar/internal.h"

#include <math.h>
#include <string.h>

// Columns of J are known to some 1e-15 of S's size over the domain's width: a determinant of unit columns below this
// is mostly that rounding, and so would the normal be.
static const double SINGULAR = 1e-12;

static void cross(double out[3], const double a[3], const double b[3])
{
    for (int c = 0; c < 3; c++) out[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// a becomes a unit vector; its length, 0 when that cannot be.
static double normalize(double a[3])
{
    double big = fmax(fabs(a[0]), fmax(fabs(a[1]), fabs(a[2])));
    if (!(big > 0.0) || !isfinite(big)) return 0.0;
    for (int c = 0; c < 3; c++) a[c] /= big;
    double length = sqrt(dot(a, a));
    for (int c = 0; c < 3; c++) a[c] /= length;
    return big * length;
}

// ---- the mixed derivative T_uv ----

// of f g where there is a factor g: values, d/du, d/dv, d/duu, d/duv, d/dvv of three components, and of one.
static void add_mixed(double out[3], const double *f, const double *g, double factor)
{
    for (int c = 0; c < 3; c++)
        out[c] += factor * (g ? g[4] * f[c] + g[1] * f[6 + c] + g[2] * f[3 + c] + g[0] * f[12 + c] : f[12 + c]);
}

static kn_status mixed(kn_ctx *ctx, double out[3], const kn_shell *s, const double at[3])
{
    double f[30], h[6];
    memset(out, 0, 3 * sizeof *out);
    if (s->volume.coef) {
        static const int uv[3] = {1, 1, 0};
        kn_status status = kn_spline_derivatives(ctx, f, &s->volume, at, 2);
        if (status == KN_OK) memcpy(out, f + 3 * kn_derivative_index(3, uv), 3 * sizeof *out);
        return status;
    }
    kn_status status = kn_spline_derivatives(ctx, f, &s->surface, at, 2);
    if (status == KN_OK) add_mixed(out, f, NULL, 1.0);
    if (status == KN_OK && s->normal.coef && s->kind == KN_SHELL_NORMAL) {
        bool thick = s->thickness.whole.coef != NULL;
        status = kn_spline_derivatives(ctx, f, &s->normal, at, 2);
        if (status == KN_OK && thick) status = kn_spline_derivatives(ctx, h, &s->thickness.whole, at, 2);
        if (status == KN_OK) add_mixed(out, f, thick ? h : NULL, at[2]);
    }
    for (int k = 0; k < s->nfields && status == KN_OK; k++) {
        status = kn_spline_derivatives(ctx, f, &s->field[k].whole, at, 2);
        if (status == KN_OK) add_mixed(out, f, NULL, pow(at[2], s->field[k].power));
    }
    return status;
}

// Where a column is 0 at an end of the domain it becomes its limit's direction; *pole is its number.
static kn_status open_pole(kn_ctx *ctx, double column[3][3], double length[3], int *pole, const kn_shell *s,
                           const double uvw[3])
{
    double tau[3];
    *pole = -1;
    for (int var = 0; var < 2; var++) { // T is constant along var, at an end of the other one
        int other = 1 - var;
        double lo = s->knot[other][0], hi = s->knot[other][s->nknots[other] - 1];
        if (uvw[other] != lo && uvw[other] != hi) continue;
        kn_status status = mixed(ctx, tau, s, uvw);
        if (status != KN_OK) return status;
        double size = normalize(tau) * (hi - lo);
        if (!(size > 0.0) || length[var] > SINGULAR * size) continue;
        for (int c = 0; c < 3; c++) column[var][c] = uvw[other] == lo ? tau[c] : -tau[c];
        length[var] = 1.0;
        *pole = var;
        return KN_OK;
    }
    return KN_OK;
}

kn_status kn_shell_map_normal(kn_ctx *ctx, double out[3], const kn_shell *shell, const double uvw[3],
                              const double normal[3])
{
    double j[9], point[3], column[3][3], length[3], part[3][3], sum[3] = {0},
                                                                n[3] = {normal[0], normal[1], normal[2]};
    int pole;
    if (!(normalize(n) > 0.0)) return kn_fail(ctx, KN_EDOMAIN, "shell: a normal without direction");
    kn_status status = kn_shell_eval(ctx, point, j, shell, uvw[0], uvw[1], uvw[2]);
    if (status != KN_OK) return status;
    for (int d = 0; d < 3; d++) {
        for (int c = 0; c < 3; c++) column[d][c] = j[3 * c + d];
        length[d] = normalize(column[d]);
    }
    status = open_pole(ctx, column, length, &pole, shell, uvw);
    if (status != KN_OK) return status;
    for (int d = 0; d < 3; d++) cross(part[d], column[(d + 1) % 3], column[(d + 2) % 3]);
    double det = dot(column[0], part[0]), most = 0.0;
    if (!(fabs(det) > SINGULAR) || !(length[0] > 0.0 && length[1] > 0.0 && length[2] > 0.0))
        return kn_fail(ctx, KN_EUNDEFINED, "shell: the Jacobian is singular at (%.17g, %.17g, %.17g)", uvw[0], uvw[1],
                       uvw[2]);
    for (int d = 0; d < 3; d++) {
        n[d] = pole >= 0 && n[pole] != 0.0 && d != pole ? 0.0 : n[d] / length[d];
        most = fmax(most, fabs(n[d]));
    }
    for (int d = 0; d < 3; d++)
        for (int c = 0; c < 3; c++) sum[c] += n[d] / most * part[d][c] * (det > 0.0 ? 1.0 : -1.0);
    if (!(normalize(sum) > 0.0)) return kn_fail(ctx, KN_EUNDEFINED, "shell: numbers beyond the range");
    memcpy(out, sum, sizeof sum);
    return KN_OK;
}
