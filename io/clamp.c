// SPDX-License-Identifier: Apache-2.0
// The clamped form of a spline variable. kn_spline holds clamped variables alone, so its own knot insertion cannot
// start from a floating one.
#include "io/clamp.h"
#include "kernel/context.h"

bool kn_axis_clamped(const kn_axis *axis)
{
    int n = axis->count, p = axis->degree;
    return axis->knots[0] == axis->knots[p] && axis->knots[n] == axis->knots[n + p];
}

// Boehm's insertion of x once, t_k <= x < t_k+1, x having multiplicity s already:
//     q_i = a_i p_i + (1 - a_i) p_i-1,  a_i = (x - t_i) / (t_i+p - t_i)  for k-p < i <= k-s,
// q_i = p_i before and p_i-1 behind. The lines of the array are taken one by one (outer, inner).
static kn_status insert(kn_ctx *ctx, kn_axis *axis, double x, int k, int s)
{
    int n = axis->count, p = axis->degree;
    size_t lines = axis->outer * axis->inner;
    double *knots = kn_alloc(ctx, (size_t)(n + p) + 2, sizeof *knots);
    double *coef = knots != NULL ? kn_alloc(ctx, lines * ((size_t)n + 1), sizeof *coef) : NULL;
    if (coef == NULL) {
        kn_free(ctx, knots);
        return KN_ENOMEM;
    }
    for (int i = 0; i <= n + p + 1; i++) knots[i] = i <= k ? axis->knots[i] : i == k + 1 ? x : axis->knots[i - 1];
    for (size_t o = 0; o < axis->outer; o++)
        for (int i = 0; i <= n; i++) {
            double a = i <= k - p ? 1.0 : 0.0;
            if (i > k - p && i <= k - s) a = (x - axis->knots[i]) / (axis->knots[i + p] - axis->knots[i]);
            const double *here = axis->coef + (o * (size_t)n + (size_t)i) * axis->inner;
            double *to = coef + (o * ((size_t)n + 1) + (size_t)i) * axis->inner;
            for (size_t j = 0; j < axis->inner; j++) {
                double value = a > 0.0 ? a * here[j] : 0.0;
                to[j] = a < 1.0 ? value + (1.0 - a) * *(here - axis->inner + j) : value;
            }
        }
    kn_free(ctx, axis->knots);
    kn_free(ctx, axis->coef);
    axis->knots = knots, axis->coef = coef, axis->count = n + 1;
    return KN_OK;
}

// The last i with knots[i] <= x, and how many knots equal x.
static int find(const kn_axis *axis, double x, int *multiplicity)
{
    int last = axis->count + axis->degree, k = last;
    while (k > 0 && axis->knots[k] > x) k--;
    *multiplicity = 0;
    for (int i = 0; i <= last; i++) *multiplicity += axis->knots[i] == x;
    return k;
}

// Inserts x until it is there degree times: then a control point lies on the curve there.
static kn_status saturate(kn_ctx *ctx, kn_axis *axis, double x)
{
    int s;
    int k = find(axis, x, &s);
    kn_status status = KN_OK;
    for (; s < axis->degree && status == KN_OK; k++, s++) status = insert(ctx, axis, x, k, s);
    return status;
}

// Keeps control points first .. first+count-1 and the knots that go with them.
static void cut(kn_axis *axis, int first, int count)
{
    size_t n = (size_t)axis->count, m = (size_t)count;
    for (size_t o = 0; o < axis->outer; o++)
        for (size_t i = 0; i < m * axis->inner; i++)
            axis->coef[o * m * axis->inner + i] = axis->coef[(o * n + (size_t)first) * axis->inner + i];
    for (int i = 0; i <= count + axis->degree; i++) axis->knots[i] = axis->knots[first + i];
    axis->count = count;
}

kn_status kn_axis_clamp(kn_ctx *ctx, kn_axis *axis)
{
    int p = axis->degree, s;
    double lo = axis->knots[p], hi = axis->knots[axis->count];
    kn_status status = saturate(ctx, axis, lo);
    if (status == KN_OK) status = saturate(ctx, axis, hi);
    if (status != KN_OK) return status;
    // with hi at k-s+1 .. k the last control point that matters is k-s
    int k = find(axis, hi, &s);
    cut(axis, 0, k - s + 1);
    // with lo last at k the first control point that matters is k-p
    k = find(axis, lo, &s);
    cut(axis, k - p, axis->count - (k - p));
    // the outermost knot at each end bears on nothing inside the domain: moving it there changes no value
    axis->knots[0] = lo;
    axis->knots[axis->count + p] = hi;
    return KN_OK;
}
