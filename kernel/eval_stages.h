// SPDX-License-Identifier: Apache-2.0
// The stages of batched evaluation in vectors of LANES doubles, to be included once by a file that defines LANES, a
// divisor of KN_EVAL_VECTOR: gcc splits vectors wider than the machine's badly, so each width has its own file. All
// is inlined into functions with the target attribute of one kind of machine.
//
// A block of points goes through: spans and local parameters, Bernstein polynomials (lanes are points), B-splines
// (lanes are control points), sums (lanes are components). The last two need no gathers: a point's control points lie
// side by side in the packed array.
#ifndef KERNEL_EVAL_STAGES_H
#define KERNEL_EVAL_STAGES_H

#include "kernel/eval_block.h"

// Loads and stores through it may alias doubles and be aligned as doubles are.
typedef double vec __attribute__((vector_size(LANES * sizeof(double)), aligned(sizeof(double)), may_alias));

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
        for (int k = 0; k < width; k += LANES) {
            vec sum = b[i] * *(const vec *)(e + k);
            for (int r = 1; r <= p; r++) sum += b[r * KN_EVAL_BLOCK + i] * *(const vec *)(e + r * width + k);
            *(vec *)(basis + i * width + k) = sum;
        }
    }
}

// The sums are handed back through pointers: a vector as a result would have another ABI on each kind of machine.
INLINE void sum1(vec *sum, const double *c, const double *n, int p, size_t stride)
{
    vec s = n[0] * *(const vec *)c;
    for (int i = 1; i <= p; i++) s += n[i] * *(const vec *)(c + (size_t)i * stride);
    *sum = s;
}

INLINE void sum2(vec *sum, const double *c, const double *const *n, const int *p, const size_t *stride)
{
    vec s = {0}, inner;
    for (int j = 0; j <= p[1]; j++) {
        sum1(&inner, c + (size_t)j * stride[1], n[0], p[0], stride[0]);
        s = j == 0 ? n[1][j] * inner : s + n[1][j] * inner;
    }
    *sum = s;
}

INLINE void sum3(vec *sum, const double *c, const double *const *n, const int *p, const size_t *stride)
{
    vec s = {0}, inner;
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
        vec sum[KN_EVAL_VECTOR / LANES]; // of narrow values
        bool whole = narrow && i * dim + KN_EVAL_VECTOR <= n * dim;
        for (int c = 0; c < (narrow ? KN_EVAL_VECTOR : plan->width); c += LANES) {
            const double *from = packed + to->first[i] + c;
            vec *part = narrow ? &sum[c / LANES] : (vec *)(value + c);
            if (nvars == 1)
                sum1(part, from, basis[0], p[0], stride[0]);
            else if (nvars == 2)
                sum2(part, from, basis, p, stride);
            else
                sum3(part, from, basis, p, stride);
        }
        for (int c = 0; c < KN_EVAL_VECTOR && narrow; c += LANES) {
            vec part = sum[c / LANES];
            if (rational) part = part / sum[dim / LANES][dim % LANES];
            *(vec *)(whole ? out + i * dim + c : value + c) = part;
        }
        for (int c = 0; c < dim && !whole; c++)
            out[i * dim + c] = rational && !narrow ? value[c] / value[dim] : value[c];
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

#endif
