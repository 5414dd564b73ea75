// SPDX-License-Identifier: Apache-2.0
// Bounds of det dT/d(u,v,w) from coefficients.
//
// With A = S_u and B = S_v the determinant is n . ((A + w n_u) x (B + w n_v)) = J0 + w J1 + w^2 J2,
//     J0 = n . (A x B),  J1 = n . (n_u x B + A x n_v),  J2 = n . (n_u x n_v).
// For S = P/W put A W^2 = P_u W - P W_u, and so for B; then J0 + w W^2 J1 + w^2 W^4 J2 over W^4. At every (u,v) the
// quotient is a mean of the quotients of coefficients, weighted by the denominator's, which are positive.
#include "kernel/context.h"
#include "trivar/internal.h"

#include <math.h>

enum { DEPTH = 6 };

// One span of n: numerators of J0, J1, J2 in one degree, the denominator (empty when S is polynomial), and absolute
// bounds of the numerators' errors.
typedef struct quadratic {
    kn_bezier j[3], w4;
    double error[3];
} quadratic;

typedef struct range {
    double lo, hi;
} range;

static void quadratic_clear(kn_ctx *ctx, quadratic *q)
{
    for (int k = 0; k < 3; k++) kn_bezier_clear(ctx, &q->j[k]);
    kn_bezier_clear(ctx, &q->w4);
}

// c0 + c1 w + c2 w^2 over [w0,w1]: the ends and, when inside, the vertex.
static range quadratic_range(const double c[3], double w0, double w1)
{
    double a = c[0] + w0 * (c[1] + w0 * c[2]), b = c[0] + w1 * (c[1] + w1 * c[2]);
    range r = {fmin(a, b), fmax(a, b)};
    double vertex = -0.5 * c[1] / c[2];
    if (vertex > w0 && vertex < w1) {
        double v = c[0] + vertex * (c[1] + vertex * c[2]);
        r.lo = fmin(r.lo, v);
        r.hi = fmax(r.hi, v);
    }
    return r;
}

static range hull(const quadratic *q, double w0, double w1)
{
    size_t n = kn_bezier_count(&q->j[0]);
    double w = fmax(fabs(w0), fabs(w1)), error = q->error[0] + w * (q->error[1] + w * q->error[2]);
    range all = {INFINITY, -INFINITY};
    for (size_t i = 0; i < n; i++) {
        const double c[3] = {q->j[0].coef[i], q->j[1].coef[i], q->j[2].coef[i]};
        double slack = error + kn_gamma(16) * (fabs(c[0]) + w * (fabs(c[1]) + w * fabs(c[2])));
        range r = quadratic_range(c, w0, w1);
        double lo = r.lo - slack, hi = r.hi + slack;
        if (!(lo <= hi)) return (range){-INFINITY, INFINITY}; // overflow: nothing is known
        if (q->w4.coef) {
            double d = q->w4.coef[i], off = 0x1p-40; // far above the rounding of a product of positive numbers
            lo /= lo > 0.0 ? d * (1.0 + off) : d * (1.0 - off);
            hi /= hi > 0.0 ? d * (1.0 - off) : d * (1.0 + off);
        }
        all.lo = fmin(all.lo, lo);
        all.hi = fmax(all.hi, hi);
    }
    return all;
}

static kn_status split(kn_ctx *ctx, quadratic *first, quadratic *second, const quadratic *q, int var)
{
    kn_status status = KN_OK;
    for (int k = 0; k < 3 && status == KN_OK; k++) {
        status = kn_bezier_subdivide(ctx, &first->j[k], &second->j[k], &q->j[k], var, 0.5);
        first->error[k] = second->error[k] = q->error[k];
    }
    if (status == KN_OK && q->w4.coef) status = kn_bezier_subdivide(ctx, &first->w4, &second->w4, &q->w4, var, 0.5);
    return status;
}

// Widens *found to bounds over the box, which are subdivided as long as they lie outside `wanted`.
static kn_status search(kn_ctx *ctx, range *found, const quadratic *q, const double w[2], range wanted, int depth)
{
    range r = hull(q, w[0], w[1]);
    bool fine = r.lo >= fmin(wanted.lo, found->lo) && r.hi <= fmax(wanted.hi, found->hi);
    if (fine || depth == DEPTH) {
        found->lo = fmin(found->lo, r.lo);
        found->hi = fmax(found->hi, r.hi);
        return KN_OK;
    }
    quadratic first = {0}, second = {0};
    kn_status status = split(ctx, &first, &second, q, depth % 2);
    if (status == KN_OK) status = search(ctx, found, &first, w, wanted, depth + 1);
    if (status == KN_OK) status = search(ctx, found, &second, w, wanted, depth + 1);
    quadratic_clear(ctx, &first);
    quadratic_clear(ctx, &second);
    return status;
}

// ---- the three numerators over one span of n ----

enum { N, NU, NV, A, B, P, W, W2, T1, T2, T3, NTEMP };

// *out = (P_var W - P W_var) / step in variable var, or P_var / step when polynomial.
static kn_status tangent(kn_ctx *ctx, kn_bezier *out, kn_bezier *t, bool rational, int var, double step)
{
    kn_status status = kn_bezier_derivative(ctx, out, &t[P], var);
    if (rational && status == KN_OK) status = kn_bezier_product(ctx, out, &t[W], out);
    if (rational && status == KN_OK) status = kn_bezier_derivative(ctx, &t[T1], &t[W], var);
    if (rational && status == KN_OK) status = kn_bezier_product(ctx, &t[T1], &t[T1], &t[P]);
    if (rational && status == KN_OK) status = kn_bezier_difference(ctx, out, out, &t[T1]);
    if (status == KN_OK) status = kn_bezier_scale(ctx, out, out, 1.0 / step);
    return status;
}

static kn_status triple(kn_ctx *ctx, kn_bezier *out, kn_bezier *t, int a, int b)
{
    kn_status status = kn_bezier_cross(ctx, &t[T2], &t[a], &t[b]);
    return status == KN_OK ? kn_bezier_dot(ctx, out, &t[N], &t[T2]) : status;
}

static kn_status numerators(kn_ctx *ctx, quadratic *q, kn_bezier *t, bool rational)
{
    kn_status status = triple(ctx, &q->j[0], t, A, B);
    if (status == KN_OK) status = triple(ctx, &q->j[1], t, NU, B);
    if (status == KN_OK) status = triple(ctx, &t[T3], t, A, NV);
    if (status == KN_OK) status = kn_bezier_sum(ctx, &q->j[1], &q->j[1], &t[T3]);
    if (status == KN_OK) status = triple(ctx, &q->j[2], t, NU, NV);
    if (rational) {
        if (status == KN_OK) status = kn_bezier_product(ctx, &t[W2], &t[W], &t[W]);
        if (status == KN_OK) status = kn_bezier_product(ctx, &q->w4, &t[W2], &t[W2]);
        if (status == KN_OK) status = kn_bezier_product(ctx, &q->j[1], &q->j[1], &t[W2]);
        if (status == KN_OK) status = kn_bezier_product(ctx, &q->j[2], &q->j[2], &q->w4);
    }
    int degree[2] = {0};
    for (int v = 0; v < 2; v++)
        for (int k = 0; k < 3 && status == KN_OK; k++)
            degree[v] = q->j[k].degree[v] > degree[v] ? q->j[k].degree[v] : degree[v];
    for (int k = 0; k < 3 && status == KN_OK; k++) status = kn_bezier_elevate(ctx, &q->j[k], &q->j[k], degree);
    if (rational && status == KN_OK) status = kn_bezier_elevate(ctx, &q->w4, &q->w4, degree);
    return status;
}

// Sizes of the factors and of their errors; the errors of products follow by the product rule, and rounding by
// gamma of the number of terms. Everything against the largest coefficients.
static void numerator_errors(quadratic *q, const kn_bezier *t, bool rational, const double step[2])
{
    int top = t[N].degree[0] + t[N].degree[1] + t[P].degree[0] + t[P].degree[1] + 4;
    double data = kn_gamma(16.0 * top), w = rational ? kn_largest_vector(&t[W], 0, 1) : 1.0, p, terms = 0.0;
    p = kn_largest_vector(&t[P], 0, 3);
    for (int k = 0; k < 3; k++) terms = fmax(terms, (double)kn_bezier_count(&q->j[k]));
    double n = kn_largest_vector(&t[N], 0, 3), en = data * n, size[2][2], err[2][2]; // [tangent, n's][variable]
    for (int v = 0; v < 2; v++) {
        size[0][v] = kn_largest_vector(&t[v == 0 ? A : B], 0, 3);
        size[1][v] = kn_largest_vector(&t[v == 0 ? NU : NV], 0, 3);
        err[0][v] = 8.0 * t[P].degree[v] * data * p * w * (rational ? 2.0 : 1.0) / step[v];
        err[1][v] = 4.0 * t[N].degree[v] * en / step[v];
    }
    // Products that may underflow lose more than rounding: then nothing is known.
    double round = size[0][0] * size[0][1] < 0x1p-900 ? INFINITY : 4.0 * kn_gamma(6.0 * terms + 64.0);
    const int pair[4][3] = {{0, 0, 0}, {1, 1, 0}, {1, 0, 1}, {2, 1, 1}}; // of j: tangent or n's in u and in v
    for (int k = 0; k < 3; k++) q->error[k] = 0.0;
    for (int k = 0; k < 4; k++) {
        double a = size[pair[k][1]][0], b = size[pair[k][2]][1], ea = err[pair[k][1]][0], eb = err[pair[k][2]][1];
        double more = rational ? pow(w, 2.0 * pair[k][0]) : 1.0;
        q->error[pair[k][0]] += 1.1 * more * (round * n * a * b + en * a * b + n * (ea * b + a * eb + ea * eb));
    }
}

static kn_status span_quadratic(kn_ctx *ctx, quadratic *q, const kn_shell *s, int i, int j)
{
    kn_bezier t[NTEMP] = {0}, piece = {0};
    const int at[2] = {i, j};
    double lo[2], hi[2], step[2];
    int from[2];
    bool rational = s->surface.rational;
    for (int v = 0; v < 2; v++) {
        const double *cut = s->cut[v] + at[v];
        from[v] = kn_interval(s->knot[v], s->nknots[v], cut[0]);
        double a = s->knot[v][from[v]], width = s->knot[v][from[v] + 1] - a;
        lo[v] = (cut[0] - a) / width;
        hi[v] = (cut[1] - a) / width;
        step[v] = cut[1] - cut[0];
    }
    kn_status status = kn_bezier_restrict(ctx, &piece, &s->span[from[0] * (s->nknots[1] - 1) + from[1]], lo, hi);
    if (status == KN_OK) status = kn_bezier_components(ctx, &t[P], &piece, 0, 3);
    if (status == KN_OK && rational) status = kn_bezier_components(ctx, &t[W], &piece, 3, 1);
    if (status == KN_OK) status = kn_bezier_copy(ctx, &t[N], &s->normal_piece[i * (s->ncuts[1] - 1) + j]);
    for (int v = 0; v < 2 && status == KN_OK; v++) {
        kn_bezier *nd = &t[v == 0 ? NU : NV];
        status = kn_bezier_derivative(ctx, nd, &t[N], v);
        if (status == KN_OK) status = kn_bezier_scale(ctx, nd, nd, 1.0 / step[v]);
        if (status == KN_OK) status = tangent(ctx, &t[v == 0 ? A : B], t, rational, v, step[v]);
    }
    if (status == KN_OK) status = numerators(ctx, q, t, rational);
    if (status == KN_OK) numerator_errors(q, t, rational, step);
    for (int k = 0; k < NTEMP; k++) kn_bezier_clear(ctx, &t[k]);
    kn_bezier_clear(ctx, &piece);
    return status;
}

// ---- what to aim at: the determinant at four places of every span ----

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
    if (shell->kind != KN_SHELL_NORMAL || shell->thickness.whole.coef || shell->nfields > 0) {
        *lo = -INFINITY, *hi = INFINITY; // the quadratic below is that of S + w n
        return KN_OK;
    }
    const double w[2] = {w0, w1}, part = 0.02; // of the range: how far outside a bound may lie
    range wanted, found = {INFINITY, -INFINITY};
    kn_status status = sampled(ctx, &wanted, shell, w);
    double reach = part * (wanted.hi - wanted.lo);
    wanted.lo -= reach, wanted.hi += reach;
    for (int i = 0; i + 1 < shell->ncuts[0]; i++)
        for (int j = 0; j + 1 < shell->ncuts[1] && status == KN_OK; j++) {
            quadratic q = {0};
            status = span_quadratic(ctx, &q, shell, i, j);
            if (status == KN_OK) status = search(ctx, &found, &q, w, wanted, 0);
            quadratic_clear(ctx, &q);
        }
    if (status == KN_OK) *lo = found.lo, *hi = found.hi;
    return status;
}
