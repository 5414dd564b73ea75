// SPDX-License-Identifier: Apache-2.0
// How smooth a joint is. Both sides are run alike, with tangent T; A leads out of the one piece, B into the other.
//   G1: N = T x A and M = T x B are parallel, det(T, A, B) = 0, and point the same way, N . M > 0.
//   G2: then B = a A + b T, M = a N and B x A = b N, so that for each coordinate c, times N_c^2,
//       N_c^2 S_BB . N = M_c^2 S_AA . N + 2 M_c Q_c S_AT . N + Q_c^2 S_TT . N,   Q = B x A:
//       the normal curvatures along B agree, and so do all others (Pegna & Wolter, 1992).
#include "tile/net.h"

#include <float.h>
#include <knurl/solve.h>
#include <math.h>

enum { T, A, B, TT, AT, AA, BB, N, M, Q, NVECTORS, SAMPLES = 33, HALVINGS = 20 };

// Curves of dimension 3 along a joint, and bounds of their sizes: of second differences those of what is subtracted.
typedef struct frame {
    kn_bezier v[NVECTORS];
    double size[NVECTORS];
} frame;

// Sums of at most some 60 products each, a few levels of them; six terms in a determinant.
static const double ROUNDING = 2048.0 * 0.5 * DBL_EPSILON;

static double largest(const kn_bezier *b)
{
    size_t n = kn_bezier_count(b);
    double most = 0.0;
    for (size_t k = 0; k < n; k++) {
        double sum = 0.0;
        for (int c = 0; c < b->ncomp; c++) sum += b->coef[(size_t)c * n + k] * b->coef[(size_t)c * n + k];
        most = fmax(most, sum);
    }
    return sqrt(most) * (1.0 + 8.0 * DBL_EPSILON);
}

// Derivatives at a side, run with it or reversed: first out of the piece (or into it), second along that.
static kn_status derive(kn_ctx *ctx, kn_bezier *first, kn_bezier *second, double sizes[2], const kn_tile_net *net,
                        int side, bool inwards, bool reversed)
{
    const kn_bezier *b = &net->pieces[side / 4].surface;
    int var = side % 4 / 2, p = b->degree[var], n = b->degree[1 - var], end = side % 2 ? p : 0;
    int step = side % 2 ? -1 : 1;
    size_t count = kn_bezier_count(b), row = (size_t)b->degree[1] + 1;
    size_t along = var == 0 ? 1 : row, stride = var == 0 ? row : 1, points = (size_t)n + 1;
    kn_status status = kn_bezier_init(ctx, first, 1, 3, false, &n);
    if (status == KN_OK) status = kn_bezier_init(ctx, second, 1, 3, false, &n);
    if (status != KN_OK) return status;
    double most = 0.0;
    for (size_t c = 0; c < 3; c++)
        for (size_t k = 0; k < points; k++) {
            size_t at = reversed ? points - 1 - k : k;
            const double *x = b->coef + c * count + at * along;
            double x0 = x[(size_t)end * stride], d1 = p > 0 ? x0 - x[(size_t)(end + step) * stride] : 0.0;
            double d2 = p > 1 ? x[(size_t)(end + step) * stride] - x[(size_t)(end + 2 * step) * stride] : 0.0;
            first->coef[c * points + k] = (inwards ? -p : p) * d1;
            if (p > 1) second->coef[c * points + k] = p * (p - 1.0) * (d1 - d2);
            if (p > 1) most = fmax(most, p * (p - 1.0) * (fabs(d1) + fabs(d2)));
        }
    sizes[0] = largest(first);
    sizes[1] = 2.0 * most;
    return KN_OK;
}

static kn_status edge_curve(kn_ctx *ctx, kn_bezier *out, const kn_tile_net *net, int side)
{
    double p[KN_TILE_SIDE_POINTS][3];
    int n = kn_tile_side_points(p, net, side), degree = n - 1;
    kn_status status = kn_bezier_init(ctx, out, 1, 3, false, &degree);
    for (int k = 0; k < n && status == KN_OK; k++)
        for (int c = 0; c < 3; c++) out->coef[c * n + k] = p[k][c];
    return status;
}

static kn_status make_joint(kn_ctx *ctx, frame *j, const kn_tile_net *net, int side)
{
    const kn_tile_side *s = &net->sides[side];
    double sizes[2] = {0.0, 0.0};
    kn_status status = edge_curve(ctx, &j->v[T], net, side);
    if (status == KN_OK) status = kn_bezier_derivative(ctx, &j->v[T], &j->v[T], 0);
    if (status == KN_OK) status = kn_bezier_derivative(ctx, &j->v[TT], &j->v[T], 0);
    if (status == KN_OK) status = derive(ctx, &j->v[A], &j->v[AA], sizes, net, side, false, false);
    j->size[A] = sizes[0], j->size[AA] = sizes[1];
    if (status == KN_OK) status = derive(ctx, &j->v[B], &j->v[BB], sizes, net, s->mate, true, s->reversed);
    j->size[B] = sizes[0], j->size[BB] = sizes[1];
    if (status == KN_OK) status = kn_bezier_derivative(ctx, &j->v[AT], &j->v[A], 0);
    if (status == KN_OK) status = kn_bezier_cross(ctx, &j->v[N], &j->v[T], &j->v[A]);
    if (status == KN_OK) status = kn_bezier_cross(ctx, &j->v[M], &j->v[T], &j->v[B]);
    if (status == KN_OK) status = kn_bezier_cross(ctx, &j->v[Q], &j->v[B], &j->v[A]);
    if (status != KN_OK) return status;
    j->size[T] = largest(&j->v[T]);
    j->size[TT] = 2.0 * j->v[T].degree[0] * j->size[T];
    j->size[AT] = 2.0 * j->v[A].degree[0] * j->size[A];
    j->size[N] = j->size[T] * j->size[A];
    j->size[M] = j->size[T] * j->size[B];
    j->size[Q] = j->size[A] * j->size[B];
    return KN_OK;
}

// f, of dimension 1, is within `limit` everywhere by its coefficients: yes; a value is beyond it: no.
static kn_status vanishes(kn_ctx *ctx, kn_answer *out, const kn_bezier *f, double size, double limit)
{
    size_t n = kn_bezier_count(f);
    double most = 0.0, value = 0.0;
    for (size_t k = 0; k < n; k++) most = fmax(most, fabs(f->coef[k]));
    *out = most + ROUNDING * size <= limit ? KN_YES : KN_UNKNOWN;
    for (int k = 0; *out == KN_UNKNOWN && k < SAMPLES; k++) {
        double at = k / (SAMPLES - 1.0);
        kn_status status = kn_bezier_eval(ctx, &value, f, &at);
        if (status != KN_OK) return status;
        if (fabs(value) > limit + 2.0 * ROUNDING * size) *out = KN_NO;
    }
    return KN_OK;
}

// f >= -limit everywhere, and more than limit somewhere: yes; f < -limit somewhere, or f <= limit everywhere: no.
static kn_status goes_on(kn_ctx *ctx, kn_answer *out, const kn_bezier *f, double size, double limit)
{
    double most = -INFINITY, value;
    kn_bezier rest = {0};
    for (int k = 0; k < SAMPLES; k++) {
        double at = k / (SAMPLES - 1.0);
        kn_status status = kn_bezier_eval(ctx, &value, f, &at);
        if (status != KN_OK) return status;
        most = fmax(most, value);
        if (value < -limit - 2.0 * ROUNDING * size) {
            *out = KN_NO;
            return KN_OK;
        }
    }
    // f + limit is positive: boxes are halved where coefficients are not.
    kn_sign sign = KN_SIGN_UNKNOWN;
    kn_status status = kn_bezier_copy(ctx, &rest, f);
    for (size_t k = 0; status == KN_OK && k < kn_bezier_count(f); k++) rest.coef[k] += limit - ROUNDING * size;
    if (status == KN_OK) status = kn_solve_sign(ctx, &sign, &rest, NULL, NULL, HALVINGS);
    if (status == KN_OK)
        *out = sign != KN_SIGN_POSITIVE ? KN_UNKNOWN : most > limit + 2.0 * ROUNDING * size ? KN_YES : KN_UNKNOWN;
    kn_bezier_clear(ctx, &rest);
    return status;
}

static kn_status first_order(kn_ctx *ctx, kn_answer *out, const frame *j, double angle)
{
    kn_bezier f = {0};
    double size = 6.0 * j->size[T] * j->size[A] * j->size[B];
    kn_status status = kn_bezier_determinant(ctx, &f, &j->v[T], &j->v[A], &j->v[B]);
    if (status == KN_OK) status = vanishes(ctx, out, &f, size, angle * size / 6.0);
    if (status == KN_OK && *out == KN_YES) {
        size = j->size[N] * j->size[M];
        status = kn_bezier_dot(ctx, &f, &j->v[N], &j->v[M]);
        if (status == KN_OK) status = goes_on(ctx, out, &f, size, angle * size);
    }
    kn_bezier_clear(ctx, &f);
    return status;
}

// sum += factor x y z.
static kn_status add(kn_ctx *ctx, kn_bezier *sum, double factor, const kn_bezier *x, const kn_bezier *y,
                     const kn_bezier *z)
{
    kn_bezier term = {0};
    kn_status status = kn_bezier_product(ctx, &term, x, y);
    if (status == KN_OK) status = kn_bezier_product(ctx, &term, &term, z);
    if (status == KN_OK) status = kn_bezier_scale(ctx, &term, &term, factor);
    if (status == KN_OK && sum->coef) status = kn_bezier_sum(ctx, &term, sum, &term);
    if (status == KN_OK) kn_bezier_swap(sum, &term);
    kn_bezier_clear(ctx, &term);
    return status;
}

// The identity above in coordinate c; second[]: S_BB, S_AA, S_AT, S_TT times N.
static kn_status residual(kn_ctx *ctx, kn_bezier *out, const frame *j, const kn_bezier second[4], int c)
{
    kn_bezier n = {0}, m = {0}, q = {0};
    kn_status status = kn_bezier_components(ctx, &n, &j->v[N], c, 1);
    if (status == KN_OK) status = kn_bezier_components(ctx, &m, &j->v[M], c, 1);
    if (status == KN_OK) status = kn_bezier_components(ctx, &q, &j->v[Q], c, 1);
    if (status == KN_OK) status = add(ctx, out, 1.0, &n, &n, &second[0]);
    if (status == KN_OK) status = add(ctx, out, -1.0, &m, &m, &second[1]);
    if (status == KN_OK) status = add(ctx, out, -2.0, &m, &q, &second[2]);
    if (status == KN_OK) status = add(ctx, out, -1.0, &q, &q, &second[3]);
    kn_bezier_clear(ctx, &n);
    kn_bezier_clear(ctx, &m);
    kn_bezier_clear(ctx, &q);
    return status;
}

static kn_status second_order(kn_ctx *ctx, kn_answer *out, const frame *j, double angle)
{
    static const int which[4] = {BB, AA, AT, TT};
    kn_bezier second[4] = {{0}, {0}, {0}, {0}}, f = {0};
    int nn = j->v[N].degree[0], mm = j->v[M].degree[0], qq = j->v[Q].degree[0], most = nn > mm ? nn : mm;
    int more = j->v[A].degree[0] > j->v[B].degree[0] ? j->v[A].degree[0] : j->v[B].degree[0];
    *out = KN_UNKNOWN;
    if (2 * (most > qq ? most : qq) + nn + more > KN_MAX_DEGREE) return KN_OK;
    const double *s = j->size;
    double size = s[N] *
                  (s[N] * s[N] * s[BB] + s[M] * s[M] * s[AA] + 2.0 * s[M] * s[Q] * s[AT] + s[Q] * s[Q] * s[TT]);
    kn_status status = KN_OK;
    for (int k = 0; k < 4 && status == KN_OK; k++) status = kn_bezier_dot(ctx, &second[k], &j->v[which[k]], &j->v[N]);
    *out = KN_YES;
    for (int c = 0; c < 3 && status == KN_OK && *out != KN_NO; c++) {
        kn_answer one = KN_UNKNOWN;
        kn_bezier_clear(ctx, &f);
        status = residual(ctx, &f, j, second, c);
        if (status == KN_OK) status = vanishes(ctx, &one, &f, size, angle * size);
        if (one != KN_YES) *out = one;
    }
    for (int k = 0; k < 4; k++) kn_bezier_clear(ctx, &second[k]);
    kn_bezier_clear(ctx, &f);
    return status;
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// What is amiss at a parameter: the angle between the normals, or the difference of the normal curvatures along B.
static kn_status measure(kn_ctx *ctx, double *out, const frame *j, double at, int order)
{
    double x[NVECTORS][3];
    for (int k = 0; k < NVECTORS; k++) {
        kn_status status = kn_bezier_eval(ctx, x[k], &j->v[k], &at);
        if (status != KN_OK) return status;
    }
    double nn = dot(x[N], x[N]), mm = dot(x[M], x[M]), nm = dot(x[N], x[M]), bb = dot(x[B], x[B]), cross = 0.0;
    *out = 0.0;
    if (!(sqrt(nn) > 1e-6 * j->size[N]) || !(sqrt(mm) > 1e-6 * j->size[M])) return KN_OK;
    for (int c = 0; c < 3; c++) {
        int d = (c + 1) % 3, e = (c + 2) % 3;
        double y = x[N][d] * x[M][e] - x[N][e] * x[M][d];
        cross += y * y;
    }
    double a = nm / nn, b = dot(x[Q], x[N]) / nn;
    if (order == 0)
        *out = atan2(sqrt(cross), nm);
    else
        *out = fabs(dot(x[BB], x[N]) - a * a * dot(x[AA], x[N]) - 2.0 * a * b * dot(x[AT], x[N]) -
                    b * b * dot(x[TT], x[N])) /
               (sqrt(nn) * bb);
    return KN_OK;
}

static kn_status find_worst(kn_ctx *ctx, kn_tile_joint *out, const frame *j)
{
    for (int k = 0; k < SAMPLES; k++) {
        double at = k / (SAMPLES - 1.0), amount = 0.0;
        kn_status status = measure(ctx, &amount, j, at, out->order);
        if (status != KN_OK) return status;
        if (amount > out->amount || k == 0) out->at = at, out->amount = amount;
    }
    return KN_OK;
}

kn_status kn_tile_joint_order(kn_ctx *ctx, kn_tile_joint *out, const kn_tile_net *net, int side, double angle,
                              int most)
{
    frame j = {.size = {0.0}};
    kn_answer answer = KN_UNKNOWN;
    kn_tile_joint joint = {.order = 0};
    kn_status status = make_joint(ctx, &j, net, side);
    if (status == KN_OK) status = first_order(ctx, &answer, &j, angle);
    if (status == KN_OK && answer == KN_YES && (joint.order = 1) < most)
        status = second_order(ctx, &answer, &j, angle);
    if (answer == KN_YES) joint.order = most;
    joint.decided = answer != KN_UNKNOWN;
    if (status == KN_OK && joint.order < most) status = find_worst(ctx, &joint, &j);
    for (int k = 0; k < NVECTORS; k++) kn_bezier_clear(ctx, &j.v[k]);
    if (status == KN_OK) *out = joint;
    return status;
}
