// SPDX-License-Identifier: Apache-2.0
// The Jacobian over the boxes of a shell's grid, in the forms in which its sign is looked at.
#include "fold/internal.h"
#include "kernel/bernstein.h"
#include "kernel/binomial.h"
#include "kernel/context.h"
#include "solve/net.h"

#include <math.h>

static double largest(const kn_bezier *b, int comp)
{
    size_t n = kn_bezier_count(b);
    return kn_largest(b->coef + (size_t)comp * n, n);
}

size_t kn_fold_boxes(const kn_shell *shell)
{
    int n[3];
    kn_shell_jacobian_grid(shell, n);
    return (size_t)n[0] * (size_t)n[1] * (size_t)n[2];
}

kn_status kn_fold_piece(kn_ctx *ctx, kn_shell_jacobian_piece *out, const kn_shell *shell, size_t index)
{
    int n[3], at[3];
    kn_shell_jacobian_grid(shell, n);
    at[2] = (int)(index % (size_t)n[2]);
    at[1] = (int)(index / (size_t)n[2] % (size_t)n[1]);
    at[0] = (int)(index / (size_t)n[2] / (size_t)n[1]);
    return kn_shell_jacobian_piece_init(ctx, out, shell, at);
}

// b_0 .. b_m over [0,width] are sum_k C(m,k) (difference k of b at 0) (s / width)^k. A difference of order k sums 2^k
// coefficients.
static void to_powers(double *out, double *error, const kn_bezier *b, double known, double width)
{
    int m = b->degree[2];
    size_t row = (size_t)m + 1, n = kn_bezier_count(b) / row;
    double line[KN_MAX_DEGREE + 1], most = largest(b, 0);
    for (size_t i = 0; i < n; i++) {
        double scale = 1.0;
        for (int k = 0; k <= m; k++) line[k] = b->coef[i * row + (size_t)k];
        for (int k = 0; k <= m; k++) {
            out[(size_t)k * n + i] = kn_binomial(m, k) * line[0] * scale;
            scale /= width;
            for (int j = 0; j < m - k; j++) line[j] = line[j + 1] - line[j];
        }
    }
    double grow = 1.0;
    for (int k = 0; k <= m; k++) {
        error[k] = 1.001 * kn_binomial(m, k) * grow * (known + kn_rounding(3.0 * k + 4.0) * most);
        grow *= 2.0 / width;
    }
}

kn_status kn_fold_to_heights(kn_ctx *ctx, kn_shell_jacobian_piece *p, bool below)
{
    if (p->j.nvars == 2) {
        size_t n = kn_bezier_count(&p->j);
        for (int k = 1; k < p->j.ncomp && below; k += 2)
            for (size_t i = 0; i < n; i++) p->j.coef[(size_t)k * n + i] *= -1.0;
        return KN_OK;
    }
    kn_bezier c = {0};
    double known = p->error[0];
    kn_status status = kn_bezier_init(ctx, &c, 2, p->j.degree[2] + 1, false, p->j.degree);
    if (status != KN_OK) return status;
    to_powers(c.coef, p->error, &p->j, known, p->hi[2] - p->lo[2]);
    kn_bezier_swap(&p->j, &c);
    kn_bezier_clear(ctx, &c);
    return KN_OK;
}

// Powers of w over [w0,w1], as Bernstein polynomials: the third variable. error[l], of row l: power k has the row
// (the mean of products of k ends of [w0,w1]) there, which the same mean of magnitudes bounds.
static kn_status spread(kn_ctx *ctx, kn_bezier *out, double *error, const kn_bezier *j, const double *known,
                        double w0, double w1)
{
    int top = j->ncomp - 1, degree[3] = {j->degree[0], j->degree[1], top};
    size_t n = kn_bezier_count(j), row = (size_t)top + 1;
    double power[KN_MAX_COMPS], sum[KN_MAX_COMPS] = {0};
    kn_bezier b = {0};
    kn_status status = kn_bezier_init(ctx, &b, 3, 1, false, degree);
    if (status != KN_OK) return status;
    for (int k = 0; k <= top; k++) {
        kn_bernstein_power(power, k, top, w0, w1);
        for (size_t i = 0; i < n; i++)
            for (size_t l = 0; l < row; l++) b.coef[i * row + l] += j->coef[(size_t)k * n + i] * power[l];
        double each = known[k] + kn_rounding(8.0 * top + 16.0) * largest(j, k);
        kn_bernstein_power(power, k, top, fabs(w0), fabs(w1));
        for (size_t l = 0; l < row; l++) sum[l] += each * power[l];
    }
    for (size_t l = 0; l < row; l++) error[l] = 1.001 * sum[l];
    kn_bezier_swap(out, &b);
    kn_bezier_clear(ctx, &b);
    return KN_OK;
}

// A function of (u,v) as one of (u,v,w), of degree top in w.
static kn_status repeat(kn_ctx *ctx, kn_bezier *d, int top)
{
    int degree[3] = {d->degree[0], d->degree[1], top};
    kn_bezier b = {0};
    kn_status status = kn_bezier_init(ctx, &b, 3, 1, false, degree);
    if (status != KN_OK) return status;
    size_t n = kn_bezier_count(d), row = (size_t)top + 1;
    for (size_t i = 0; i < n * row; i++) b.coef[i] = d->coef[i / row];
    kn_bezier_swap(d, &b);
    kn_bezier_clear(ctx, &b);
    return KN_OK;
}

kn_status kn_fold_to_box(kn_ctx *ctx, kn_shell_jacobian_piece *p, double *error, const double lo[3],
                         const double hi[3])
{
    int top = p->j.ncomp - 1;
    bool plane = p->j.nvars == 2;
    for (int k = 0; k <= top; k++) p->error[k] = 1.001 * (p->error[k] + kn_rounding(1024.0) * largest(&p->j, k));
    kn_status status = kn_bezier_restrict(ctx, &p->j, &p->j, lo, hi);
    if (status == KN_OK && p->denominator.coef)
        status = kn_bezier_restrict(ctx, &p->denominator, &p->denominator, lo, hi);
    if (status == KN_OK && plane) status = spread(ctx, &p->j, error, &p->j, p->error, lo[2], hi[2]);
    for (int l = 0; !plane && l <= p->j.degree[2]; l++) error[l] = p->error[0];
    if (status == KN_OK && plane && p->denominator.coef) status = repeat(ctx, &p->denominator, top);
    return status;
}
