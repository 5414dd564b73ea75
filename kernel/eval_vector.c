// SPDX-License-Identifier: Apache-2.0
// Batched evaluation by vectors: one body, compiled for each kind of machine and chosen at run time.
//
// A block of points goes through: spans and local parameters (scalar), Bernstein polynomials (lanes are points),
// B-splines (lanes are control points), sums (lanes are components). The last two need no gathers: a point's control
// points lie side by side in the packed array.
#include "kernel/eval_block.h"

#include <assert.h>

// Loads and stores through it may alias doubles and be aligned as doubles are.
typedef double v4 __attribute__((vector_size(KN_EVAL_VECTOR * sizeof(double)), aligned(sizeof(double)), may_alias));

#define INLINE static inline __attribute__((always_inline))

// Where each point of a block lies: its span, and where its control points begin.
typedef struct places {
    int span[KN_EVAL_BLOCK];
    size_t first[KN_EVAL_BLOCK];
} places;

// Constants where it is worth it: a bicubic surface has code of its own.
INLINE int degree_of(const kn_eval_plan *plan, int d, bool cubic)
{
    return cubic ? 3 : plan->axis[d].degree;
}

INLINE void find_spans(double *restrict x, places *restrict to, const kn_eval_axis *axis, int n, const double *at,
                       int nvars)
{
    const kn_eval_axis a = *axis; // in registers: stores below cannot change it
    double t[KN_EVAL_BLOCK];
    int span[KN_EVAL_BLOCK];
    for (int i = 0; i < n; i++) t[i] = at[i * nvars];
    for (int i = n; i < KN_EVAL_BLOCK; i++) t[i] = a.lo;
    for (int i = 0; i < KN_EVAL_BLOCK; i++) span[i] = kn_eval_bucket(&a, t[i]);
    for (int i = 0; i < KN_EVAL_BLOCK; i++) span[i] = a.start[span[i]];
    for (int w = a.steps > 0 ? 1 << (a.steps - 1) : 0; w > 0; w /= 2)
        for (int i = 0; i < KN_EVAL_BLOCK; i++) span[i] += t[i] >= a.left[span[i] + w] ? w : 0;
    for (int i = 0; i < KN_EVAL_BLOCK; i++) {
        to->span[i] = span[i];
        to->first[i] += a.first[span[i]];
        x[i] = t[i] == a.end ? 1.0 : (t[i] - a.left[span[i]]) * a.inverse[span[i]];
    }
}

// b[r][i] = C(p,r) x_i^r (1-x_i)^(p-r).
INLINE void bernstein(double *restrict b, const double *restrict x, const double *binomial, int p)
{
    double xr[KN_EVAL_BLOCK], yr[KN_EVAL_BLOCK];
    for (int i = 0; i < KN_EVAL_BLOCK; i++) xr[i] = yr[i] = 1.0;
    for (int r = 0; r <= p; r++)
        for (int i = 0; i < KN_EVAL_BLOCK; i++) {
            b[r * KN_EVAL_BLOCK + i] = binomial[r] * xr[i];
            xr[i] *= x[i];
        }
    for (int r = p; r >= 0; r--)
        for (int i = 0; i < KN_EVAL_BLOCK; i++) {
            b[r * KN_EVAL_BLOCK + i] *= yr[i];
            yr[i] *= 1.0 - x[i];
        }
}

// basis[i][k] = sum_r b[r][i] E[r][k] of the point's span.
INLINE void b_splines(const kn_eval_axis *a, const places *to, const double *b, int n, int p, int width)
{
    double *basis = a->basis;
    const double *extract = a->extract;
    for (int i = 0; i < n && !extract; i++)
        for (int k = 0; k <= p; k++) basis[i * width + k] = b[k * KN_EVAL_BLOCK + i];
    for (int i = 0; i < n && extract; i++) {
        const double *e = extract + (size_t)to->span[i] * (size_t)((p + 1) * width);
        for (int k = 0; k < width; k += KN_EVAL_VECTOR) {
            v4 sum = b[i] * *(const v4 *)(e + k);
            for (int r = 1; r <= p; r++) sum += b[r * KN_EVAL_BLOCK + i] * *(const v4 *)(e + r * width + k);
            *(v4 *)(basis + i * width + k) = sum;
        }
    }
}

// The sums are handed back through pointers: a vector as a result would have another ABI on each kind of machine.
INLINE void sum1(v4 *sum, const double *c, const double *n, int p, size_t stride)
{
    v4 s = n[0] * *(const v4 *)c;
    for (int i = 1; i <= p; i++) s += n[i] * *(const v4 *)(c + (size_t)i * stride);
    *sum = s;
}

INLINE void sum2(v4 *sum, const double *c, const double *const *n, const int *p, const size_t *stride)
{
    v4 s = {0}, inner;
    for (int j = 0; j <= p[1]; j++) {
        sum1(&inner, c + (size_t)j * stride[1], n[0], p[0], stride[0]);
        s = j == 0 ? n[1][j] * inner : s + n[1][j] * inner;
    }
    *sum = s;
}

INLINE void sum3(v4 *sum, const double *c, const double *const *n, const int *p, const size_t *stride)
{
    v4 s = {0}, inner;
    for (int k = 0; k <= p[2]; k++) {
        sum2(&inner, c + (size_t)k * stride[2], n, p, stride);
        s = k == 0 ? n[2][k] * inner : s + n[2][k] * inner;
    }
    *sum = s;
}

// The sums of a block's points, `width` components each. value of four components or fewer goes straight to out:
// whole vectors, of which the next point overwrites what is too much, as long as that stays inside out's n points.
INLINE void contract(double *out, const kn_eval_plan *plan, const places *to, int n, int nvars, bool cubic)
{
    const double *packed = plan->packed, *basis[KN_EVAL_MAX_VARS] = {NULL};
    size_t stride[KN_EVAL_MAX_VARS] = {0};
    int p[KN_EVAL_MAX_VARS] = {0}, width[KN_EVAL_MAX_VARS] = {0}, dim = plan->ncomp - plan->rational;
    bool rational = plan->rational, narrow = plan->width == KN_EVAL_VECTOR;
    for (int d = 0; d < nvars; d++) {
        p[d] = degree_of(plan, d, cubic);
        width[d] = cubic ? KN_EVAL_VECTOR : plan->axis[d].width;
        stride[d] = plan->axis[d].stride;
        basis[d] = plan->axis[d].basis;
    }
    for (int i = 0; i < n; i++) {
        double value[KN_MAX_COMPS];
        for (int c = 0; c < (narrow ? KN_EVAL_VECTOR : plan->width); c += KN_EVAL_VECTOR) {
            const double *from = packed + to->first[i] + c;
            v4 sum;
            if (nvars == 1)
                sum1(&sum, from, basis[0], p[0], stride[0]);
            else if (nvars == 2)
                sum2(&sum, from, basis, p, stride);
            else
                sum3(&sum, from, basis, p, stride);
            if (narrow && rational) sum = sum / sum[dim];
            *(v4 *)(narrow && i * dim + KN_EVAL_VECTOR <= n * dim ? out + i * dim : value + c) = sum;
        }
        if (!narrow || i * dim + KN_EVAL_VECTOR > n * dim)
            for (int c = 0; c < dim; c++) out[i * dim + c] = rational && !narrow ? value[c] / value[dim] : value[c];
        for (int d = 0; d < nvars; d++) basis[d] += width[d];
    }
}

INLINE void block(double *out, const kn_eval_plan *plan, int n, const double *at, int nvars, bool cubic)
{
    places to;
    for (int i = 0; i < KN_EVAL_BLOCK; i++) to.first[i] = 0;
    for (int d = 0; d < nvars; d++) {
        const kn_eval_axis *a = &plan->axis[d];
        int p = degree_of(plan, d, cubic);
        find_spans(plan->x, &to, a, n, at + d, nvars);
        bernstein(plan->bernstein, plan->x, a->binomial, p);
        b_splines(a, &to, plan->bernstein, n, p, cubic ? KN_EVAL_VECTOR : a->width);
    }
    contract(out, plan, &to, n, nvars, cubic);
}

INLINE void all_blocks(double *out, const kn_eval_plan *plan, size_t npoints, const double *at, int nvars, bool cubic)
{
    int dim = plan->ncomp - plan->rational;
    while (npoints > 0) {
        int n = npoints < KN_EVAL_BLOCK ? (int)npoints : KN_EVAL_BLOCK;
        block(out, plan, n, at, nvars, cubic);
        npoints -= (size_t)n, at += n * nvars, out += n * dim;
    }
}

INLINE void choose(double *out, const kn_eval_plan *plan, size_t npoints, const double *at)
{
    int n = plan->nvars;
    if (n == 2 && plan->axis[0].degree == 3 && plan->axis[1].degree == 3)
        all_blocks(out, plan, npoints, at, 2, true);
    else if (n == 1)
        all_blocks(out, plan, npoints, at, 1, false);
    else if (n == 2)
        all_blocks(out, plan, npoints, at, 2, false);
    else
        all_blocks(out, plan, npoints, at, 3, false);
}

static void sse2(double *out, const kn_eval_plan *plan, size_t npoints, const double *at)
{
    choose(out, plan, npoints, at);
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) static void avx2(double *out, const kn_eval_plan *plan, size_t npoints,
                                                 const double *at)
{
    choose(out, plan, npoints, at);
}

__attribute__((target("avx2,avx512f,avx512dq,avx512vl"))) static void avx512(double *out, const kn_eval_plan *plan,
                                                                             size_t npoints, const double *at)
{
    choose(out, plan, npoints, at);
}
#endif

kn_eval_level kn_eval_best(void)
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        return KN_EVAL_AVX512;
    if (__builtin_cpu_supports("avx2")) return KN_EVAL_AVX2;
#endif
    return KN_EVAL_SSE2;
}

void kn_eval_planned(double *out, const kn_eval_plan *plan, size_t npoints, const double *at, kn_eval_level level)
{
    assert(level > KN_EVAL_PLAIN && level <= kn_eval_best());
#if defined(__x86_64__)
    if (level == KN_EVAL_AVX512) {
        avx512(out, plan, npoints, at);
        return;
    }
    if (level == KN_EVAL_AVX2) {
        avx2(out, plan, npoints, at);
        return;
    }
#endif
    sse2(out, plan, npoints, at);
}
