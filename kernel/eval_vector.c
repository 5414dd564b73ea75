// SPDX-License-Identifier: Apache-2.0
// Batched evaluation by vectors: one body, compiled for each kind of machine and chosen at run time.
//
// A block of points goes through: spans and local parameters (scalar), Bernstein polynomials (lanes are points),
// B-splines (lanes are control points), sums (lanes are components). The last two need no gathers: a point's control
// points lie side by side in the packed array.
#include "kernel/eval_block.h"

#include <assert.h>
#include <string.h>

typedef double v4 __attribute__((vector_size(KN_EVAL_VECTOR * sizeof(double)), may_alias));

#define INLINE static inline __attribute__((always_inline))

// Where the control points of each point of a block begin.
typedef struct places {
    const double *coef[KN_EVAL_BLOCK];
    int span[KN_EVAL_BLOCK];
} places;

INLINE void find_spans(double *restrict x, places *to, const kn_eval_axis *a, int n, const double *at, int nvars)
{
    for (int i = 0; i < n; i++) {
        double t = at[i * nvars];
        int s = a->start[kn_eval_bucket(a, t)];
        for (int w = a->steps > 0 ? 1 << (a->steps - 1) : 0; w > 0; w /= 2) s += t >= a->left[s + w] ? w : 0;
        to->span[i] = s;
        to->coef[i] += (size_t)a->first[s] * a->stride;
        x[i] = t == a->end ? 1.0 : (t - a->left[s]) * a->inverse[s];
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
    for (int i = 0; i < n; i++) {
        double *basis = a->basis + i * width;
        if (!a->extract) {
            for (int k = 0; k <= p; k++) basis[k] = b[k * KN_EVAL_BLOCK + i];
            continue;
        }
        const double *e = a->extract + (size_t)to->span[i] * (size_t)((p + 1) * width);
        for (int k = 0; k < width; k += KN_EVAL_VECTOR) {
            v4 sum = b[i] * *(const v4 *)(e + k);
            for (int r = 1; r <= p; r++) sum += b[r * KN_EVAL_BLOCK + i] * *(const v4 *)(e + r * width + k);
            *(v4 *)(basis + k) = sum;
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

// One block of n points in nvars variables of degrees p; those two are constants where it is worth it.
INLINE void block(double *out, const kn_eval_plan *plan, int n, const double *at, int nvars, const int *p)
{
    places to;
    size_t stride[KN_EVAL_MAX_VARS];
    int width[KN_EVAL_MAX_VARS], dim = plan->ncomp - plan->rational;
    for (int i = 0; i < n; i++) to.coef[i] = plan->packed;
    for (int i = n; i < KN_EVAL_BLOCK; i++) plan->x[i] = 0.0;
    for (int d = 0; d < nvars; d++) {
        const kn_eval_axis *a = &plan->axis[d];
        stride[d] = a->stride;
        width[d] = (p[d] + KN_EVAL_VECTOR) / KN_EVAL_VECTOR * KN_EVAL_VECTOR;
        find_spans(plan->x, &to, a, n, at + d, nvars);
        bernstein(plan->bernstein, plan->x, a->binomial, p[d]);
        b_splines(a, &to, plan->bernstein, n, p[d], width[d]);
    }
    for (int i = 0; i < n; i++) {
        const double *basis[KN_EVAL_MAX_VARS];
        double value[KN_MAX_COMPS] __attribute__((aligned(64)));
        for (int d = 0; d < nvars; d++) basis[d] = plan->axis[d].basis + i * width[d];
        for (int c = 0; c < plan->width; c += KN_EVAL_VECTOR) {
            const double *from = to.coef[i] + c;
            v4 *to_value = (v4 *)(value + c);
            if (nvars == 1)
                sum1(to_value, from, basis[0], p[0], stride[0]);
            else if (nvars == 2)
                sum2(to_value, from, basis, p, stride);
            else
                sum3(to_value, from, basis, p, stride);
        }
        for (int c = 0; c < dim; c++) out[i * dim + c] = plan->rational ? value[c] / value[dim] : value[c];
    }
}

INLINE void all_blocks(double *out, const kn_eval_plan *plan, size_t npoints, const double *at, int nvars,
                       const int *p)
{
    int dim = plan->ncomp - plan->rational;
    while (npoints > 0) {
        int n = npoints < KN_EVAL_BLOCK ? (int)npoints : KN_EVAL_BLOCK;
        block(out, plan, n, at, nvars, p);
        npoints -= (size_t)n, at += n * nvars, out += n * dim;
    }
}

INLINE void choose(double *out, const kn_eval_plan *plan, size_t npoints, const double *at)
{
    const int cubic[KN_EVAL_MAX_VARS] = {3, 3, 3};
    int p[KN_EVAL_MAX_VARS] = {0}, n = plan->nvars, cubics = 0;
    for (int d = 0; d < n; d++) p[d] = plan->axis[d].degree, cubics += p[d] == 3;
    if (n == 2 && cubics == 2)
        all_blocks(out, plan, npoints, at, 2, cubic);
    else
        all_blocks(out, plan, npoints, at, n, p);
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
