// SPDX-License-Identifier: Apache-2.0
// Bounds of det dT/d(u,v,w) from coefficients.
//
// Over each box det = sum_k w^k j_k / d: at every (u,v) a mean of the quotients of coefficients, weighted by d's,
// which are positive. Each of them is a polynomial in w.
#include "kernel/context.h"
#include "trivar/internal.h"

#include <math.h>

enum { DEPTH = 6, VOLUME_DEPTH = 9 };

typedef struct range {
    double lo, hi;
} range;

typedef struct aim {
    range wanted, found;
    double w[2];
} aim;

// The sum of c_k w^k over [w0,w1] by the expansion about the middle.
static range about_middle(const double *c, size_t step, int degree, double w0, double w1)
{
    double middle = 0.5 * (w0 + w1), half = 0.5 * (w1 - w0), q[KN_MAX_COMPS], reach = 0.0;
    for (int k = 0; k <= degree; k++) q[k] = c[(size_t)k * step];
    for (int i = 0; i < degree; i++)
        for (int k = degree - 1; k >= i; k--) q[k] += middle * q[k + 1];
    for (int k = degree; k > 0; k--) reach = (reach + fabs(q[k])) * half;
    return (range){q[0] - reach, q[0] + reach};
}

// The same: of a quadratic its ends and, when inside, the vertex; above that slices.
static range in_heights(const double *c, size_t step, int degree, double w0, double w1)
{
    enum { SLICES = 16 };
    double a = 0.0, b = 0.0;
    for (int k = degree; k >= 0; k--) a = a * w0 + c[(size_t)k * step], b = b * w1 + c[(size_t)k * step];
    range r = {fmin(a, b), fmax(a, b)};
    double vertex = degree == 2 ? -0.5 * c[step] / c[2 * step] : w0;
    if (degree == 2 && vertex > w0 && vertex < w1) {
        double v = c[0] + vertex * (c[step] + vertex * c[2 * step]);
        r.lo = fmin(r.lo, v);
        r.hi = fmax(r.hi, v);
    }
    for (int s = 0; s < SLICES && degree > 2; s++) {
        double from = w0 + (w1 - w0) * s / SLICES, to = s + 1 < SLICES ? w0 + (w1 - w0) * (s + 1) / SLICES : w1;
        range part = about_middle(c, step, degree, from, to);
        r.lo = fmin(r.lo, part.lo);
        r.hi = fmax(r.hi, part.hi);
    }
    return r;
}

static range hull(const kn_shell_jacobian_piece *q, const double w[2])
{
    size_t n = kn_bezier_count(&q->j);
    int degree = q->j.ncomp - 1;
    double far = fmax(fabs(w[0]), fabs(w[1])), error = 0.0;
    for (int k = degree; k >= 0; k--) error = error * far + q->error[k];
    range all = {INFINITY, -INFINITY};
    for (size_t i = 0; i < n; i++) {
        double size = 0.0;
        for (int k = degree; k >= 0; k--) size = size * far + fabs(q->j.coef[(size_t)k * n + i]);
        double slack = 1.001 * error + kn_gamma(16.0 + 8.0 * degree) * size;
        range r = in_heights(q->j.coef + i, n, degree, w[0], w[1]);
        double lo = r.lo - slack, hi = r.hi + slack;
        if (!(lo <= hi)) return (range){-INFINITY, INFINITY}; // overflow: nothing is known
        if (q->denominator.coef) {
            double d = q->denominator.coef[i],
                   off = 0x1p-40; // far above the rounding of products of positive numbers
            if (!(d > 0.0)) return (range){-INFINITY, INFINITY}; // beyond the domain of a volume
            lo /= lo > 0.0 ? d * (1.0 + off) : d * (1.0 - off);
            hi /= hi > 0.0 ? d * (1.0 - off) : d * (1.0 + off);
        }
        all.lo = fmin(all.lo, lo);
        all.hi = fmax(all.hi, hi);
    }
    return all;
}

// The part of a volume's box with heights in [w0,w1]; the end boxes go on beyond the domain, where coefficients and
// their errors grow by (1 + 2 reach)^degree. *none: there is no such part.
static kn_status cut_heights(kn_ctx *ctx, kn_shell_jacobian_piece *q, bool *none, const double w[2], bool first,
                             bool last)
{
    double width = q->hi[2] - q->lo[2], lo[3] = {0.0}, hi[3] = {1.0, 1.0, 1.0};
    lo[2] = (w[0] - q->lo[2]) / width - 0x1p-48;
    hi[2] = (w[1] - q->lo[2]) / width + 0x1p-48;
    if (!first) lo[2] = fmax(lo[2], 0.0);
    if (!last) hi[2] = fmin(hi[2], 1.0);
    *none = !(lo[2] < hi[2]);
    if (*none) return KN_OK;
    double reach = fmax(0.0, fmax(-lo[2], hi[2] - 1.0)), size = kn_largest_vector(&q->j, 0, 1);
    double growth = pow(1.0 + 2.0 * reach, q->j.degree[2]);
    q->error[0] = 1.001 * growth * (q->error[0] + kn_gamma(512.0) * size);
    kn_status status = kn_bezier_restrict(ctx, &q->j, &q->j, lo, hi);
    if (status == KN_OK && q->denominator.coef)
        status = kn_bezier_restrict(ctx, &q->denominator, &q->denominator, lo, hi);
    return status;
}

static kn_status split(kn_ctx *ctx, kn_shell_jacobian_piece *first, kn_shell_jacobian_piece *second,
                       const kn_shell_jacobian_piece *q, int var)
{
    kn_status status = kn_bezier_subdivide(ctx, &first->j, &second->j, &q->j, var, 0.5);
    for (int k = 0; k < q->j.ncomp; k++) first->error[k] = second->error[k] = q->error[k];
    if (status == KN_OK && q->denominator.coef)
        status = kn_bezier_subdivide(ctx, &first->denominator, &second->denominator, &q->denominator, var, 0.5);
    return status;
}

// Widens a->found to bounds over the box, which are subdivided as long as they lie outside those wanted.
static kn_status search(kn_ctx *ctx, aim *a, const kn_shell_jacobian_piece *q, int depth)
{
    int nvars = q->j.nvars;
    range r = hull(q, a->w), *found = &a->found;
    bool fine = r.lo >= fmin(a->wanted.lo, found->lo) && r.hi <= fmax(a->wanted.hi, found->hi);
    if (fine || depth == (nvars == 2 ? DEPTH : VOLUME_DEPTH)) {
        found->lo = fmin(found->lo, r.lo);
        found->hi = fmax(found->hi, r.hi);
        return KN_OK;
    }
    kn_shell_jacobian_piece first = {0}, second = {0};
    kn_status status = split(ctx, &first, &second, q, depth % nvars);
    if (status == KN_OK) status = search(ctx, a, &first, depth + 1);
    if (status == KN_OK) status = search(ctx, a, &second, depth + 1);
    kn_shell_jacobian_piece_clear(ctx, &first);
    kn_shell_jacobian_piece_clear(ctx, &second);
    return status;
}

// ---- what to aim at: the determinant at four places of every box ----

static kn_status sampled(kn_ctx *ctx, range *r, const kn_shell *s, const double w[2])
{
    static const double places[4][2] = {{0.0, 0.0}, {0.5, 0.5}, {1.0, 0.5}, {0.5, 1.0}};
    *r = (range){INFINITY, -INFINITY};
    int columns = s->ncuts[1] - 1, n = (s->ncuts[0] - 1) * columns;
    for (int k = 0; k < 4 * n; k++) {
        const double *cut[2] = {s->cut[0] + k / 4 / columns, s->cut[1] + k / 4 % columns};
        double at[2], det[3], point[3], j[9];
        for (int v = 0; v < 2; v++) at[v] = cut[v][0] + places[k % 4][v] * (cut[v][1] - cut[v][0]);
        for (int m = 0; m < 3; m++) {
            double height = w[0] + 0.5 * m * (w[1] - w[0]);
            kn_status status = kn_shell_eval(ctx, point, j, s, at[0], at[1], height);
            if (status != KN_OK) return status;
            det[m] = j[0] * (j[4] * j[8] - j[5] * j[7]) - j[1] * (j[3] * j[8] - j[5] * j[6]) +
                     j[2] * (j[3] * j[7] - j[4] * j[6]);
            r->lo = fmin(r->lo, det[m]);
            r->hi = fmax(r->hi, det[m]);
        }
    }
    return KN_OK;
}

kn_status kn_shell_jacobian_bounds(kn_ctx *ctx, double *lo, double *hi, const kn_shell *shell, double w0, double w1)
{
    if (!(w0 <= w1) || !isfinite(w0) || !isfinite(w1))
        return kn_fail(ctx, KN_EDOMAIN, "shell: heights [%g, %g]", w0, w1);
    const double part = 0.02; // of the range: how far outside a bound may lie
    aim a = {.found = {INFINITY, -INFINITY}, .w = {w0, w1}};
    kn_status status = sampled(ctx, &a.wanted, shell, a.w);
    double reach = part * (a.wanted.hi - a.wanted.lo);
    a.wanted.lo -= reach, a.wanted.hi += reach;
    int boxes[3], at[3];
    kn_shell_jacobian_grid(shell, boxes); // in w; cells do not divide T
    for (int v = 0; v < 2; v++) boxes[v] = shell->ncuts[v] - 1;
    size_t n = (size_t)boxes[0] * (size_t)boxes[1] * (size_t)boxes[2];
    for (size_t k = 0; k < n && status == KN_OK; k++) {
        kn_shell_jacobian_piece q = {0};
        at[2] = (int)(k % (size_t)boxes[2]);
        at[1] = (int)(k / (size_t)boxes[2] % (size_t)boxes[1]);
        at[0] = (int)(k / (size_t)boxes[2] / (size_t)boxes[1]);
        status = kn_jacobian_box(ctx, &q, shell, shell->cut, at, false);
        bool none = false;
        if (status == KN_OK && q.j.nvars == 3)
            status = cut_heights(ctx, &q, &none, a.w, at[2] == 0, at[2] == boxes[2] - 1);
        if (status == KN_OK && !none) status = search(ctx, &a, &q, 0);
        kn_shell_jacobian_piece_clear(ctx, &q);
        if (status == KN_OK) status = kn_progress(ctx, "Jacobian", (double)(k + 1) / (double)n);
    }
    if (status == KN_OK) *lo = a.found.lo, *hi = a.found.hi;
    return status;
}
