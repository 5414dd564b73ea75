// SPDX-License-Identifier: Apache-2.0
// The stages of batched evaluation in vectors of LANES doubles (2, 4 or 8), to be included once by a file that
// defines LANES and TARGET, the attribute of the machines it is for. Only the sums of surfaces have code of their own:
// all else is compiled once, for any degrees and numbers of variables and components.
//
// A block of points goes through: spans and local parameters, Bernstein polynomials (lanes are points), B-splines
// (lanes are control points), sums (lanes are components). The last two need no gathers: a point's control points lie
// side by side in the packed array. Vectors of 8 take two neighbours of the last variable at once.
#ifndef KERNEL_EVAL_STAGES_H
#define KERNEL_EVAL_STAGES_H

#include "kernel/eval_block.h"

#include <string.h>

#if LANES == 8
#include <immintrin.h>
#endif

// Loads and stores through it may alias doubles and be aligned as doubles are.
typedef double vec __attribute__((vector_size(LANES * sizeof(double)), aligned(sizeof(double)), may_alias));

// A vector of a B-spline's or a point's width.
enum { LOW = LANES < KN_EVAL_VECTOR ? LANES : KN_EVAL_VECTOR };
typedef double low __attribute__((vector_size(LOW * sizeof(double)), aligned(sizeof(double)), may_alias));

#define INLINE TARGET static inline __attribute__((always_inline))
#define STAGE TARGET static __attribute__((noinline)) // once, whoever calls it

INLINE void splat(vec *v, double x)
{
#if LANES == 2
    *v = (vec){x, x};
#elif LANES == 4
    *v = (vec){x, x, x, x};
#else
    *v = _mm512_set1_pd(x);
#endif
}

// A point's B-splines in one variable, or Bernstein polynomials: n[k * step], derivatives g[k * step]. point: from
// one point of the block to the next.
typedef struct view {
    const double *n, *g;
    size_t step, point, stride;
    int degree;
} view;

// ---- where a block of points lies ----

#if LANES == 8
// table[i], i < 32, from registers: a gather takes longer.
INLINE void lookup(__m512d *to, const __m512d *table, __m512i i)
{
    __m512d low16 = _mm512_permutex2var_pd(table[0], i, table[1]),
            high16 = _mm512_permutex2var_pd(table[2], i, table[3]);
    *to = _mm512_mask_blend_pd(_mm512_cmpgt_epi64_mask(i, _mm512_set1_epi64(15)), low16, high16);
}

// Of equal spans: the quotient is right or beside it.
STAGE void equal_spans(double *restrict x, double *restrict scale, int *restrict span, size_t *restrict offset,
                       const kn_eval_axis *a, const double *restrict t)
{
    __m512d lo = _mm512_set1_pd(a->lo), step = _mm512_set1_pd(a->step), inverse = _mm512_set1_pd(a->inverse[0]);
    __m512d last = _mm512_set1_pd(a->spans - 1), end = _mm512_set1_pd(a->end), one = _mm512_set1_pd(1.0);
    __m512d degree = _mm512_set1_pd(a->degree), slope = _mm512_mul_pd(degree, inverse), zero = _mm512_setzero_pd();
    __m512i even = _mm512_set1_epi64((long long)a->even);
    for (int i = 0; i < KN_EVAL_BLOCK; i += 8) {
        __m512d at = _mm512_loadu_pd(t + i), z = _mm512_mul_pd(_mm512_sub_pd(at, lo), inverse);
        z = _mm512_min_pd(_mm512_max_pd(z, zero), last); // max answers 0 for NaN
        z = _mm512_roundscale_pd(z, _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC);
        __m512d left = _mm512_add_pd(lo, _mm512_mul_pd(z, step)), next = _mm512_add_pd(z, one);
        __m512d right = _mm512_add_pd(lo, _mm512_mul_pd(next, step));
        z = _mm512_mask_sub_pd(z, _mm512_cmp_pd_mask(at, left, _CMP_LT_OQ), z, one);
        z = _mm512_mask_mov_pd(z, _mm512_cmp_pd_mask(at, right, _CMP_GE_OQ), next);
        z = _mm512_min_pd(_mm512_max_pd(z, zero), last);
        left = _mm512_add_pd(lo, _mm512_mul_pd(z, step));
        __m512d local = _mm512_mul_pd(_mm512_sub_pd(at, left), inverse);
        _mm512_storeu_pd(x + i, _mm512_mask_mov_pd(local, _mm512_cmp_pd_mask(at, end, _CMP_EQ_OQ), one));
        _mm512_storeu_pd(scale + i, slope);
        __m512i s = _mm512_cvttpd_epi64(z), *to = (__m512i *)(void *)(offset + i);
        _mm256_storeu_si256((__m256i *)(void *)(span + i), _mm512_cvtepi64_epi32(s));
        _mm512_storeu_si512(to, _mm512_add_epi64(_mm512_loadu_si512(to), _mm512_mul_epu32(s, even)));
    }
}

// Few spans: their tables fit into registers.
STAGE void find_spans(double *restrict x, double *restrict scale, int *restrict span, size_t *restrict offset,
                      const kn_eval_axis *a, const double *restrict t)
{
    __m512d lo = _mm512_set1_pd(a->lo), factor = _mm512_set1_pd(a->scale), last = _mm512_set1_pd(a->buckets - 1);
    __m512d end = _mm512_set1_pd(a->end), degree = _mm512_set1_pd(a->degree), left[4], inverse[4];
    int top = a->steps > 0 ? 1 << (a->steps - 1) : 0;
    bool few = a->spans < KN_EVAL_FEW;
    if (a->step > 0.0) {
        equal_spans(x, scale, span, offset, a, t);
        return;
    }
    for (int k = 0; k < 4; k++)
        left[k] = _mm512_loadu_pd(a->left + 8 * k), inverse[k] = _mm512_loadu_pd(a->inverse + 8 * k);
    for (int i = 0; i < KN_EVAL_BLOCK; i += 8) {
        __m512d at = _mm512_loadu_pd(t + i), z = _mm512_mul_pd(_mm512_sub_pd(at, lo), factor), bound, begin, inv;
        z = _mm512_min_pd(_mm512_max_pd(z, _mm512_setzero_pd()), last); // max answers 0 for NaN
        __m512i s = _mm512_cvtepi32_epi64(_mm256_i32gather_epi32(a->start, _mm512_cvttpd_epi32(z), 4));
        for (int w = top; w > 0; w /= 2) {
            __m512i step = _mm512_set1_epi64(w), next = _mm512_add_epi64(s, step);
            if (few)
                lookup(&bound, left, next);
            else
                bound = _mm512_i64gather_pd(next, a->left, 8);
            s = _mm512_mask_add_epi64(s, _mm512_cmp_pd_mask(at, bound, _CMP_GE_OQ), s, step);
        }
        if (few) {
            lookup(&begin, left, s);
            lookup(&inv, inverse, s);
        } else {
            begin = _mm512_i64gather_pd(s, a->left, 8);
            inv = _mm512_i64gather_pd(s, a->inverse, 8);
        }
        z = _mm512_mul_pd(_mm512_sub_pd(at, begin), inv);
        z = _mm512_mask_mov_pd(z, _mm512_cmp_pd_mask(at, end, _CMP_EQ_OQ), _mm512_set1_pd(1.0));
        _mm512_storeu_pd(x + i, z);
        _mm512_storeu_pd(scale + i, _mm512_mul_pd(degree, inv));
        _mm256_storeu_si256((__m256i *)(void *)(span + i), _mm512_cvtepi64_epi32(s));
        __m512i first = a->even ? _mm512_mul_epu32(s, _mm512_set1_epi64((long long)a->even))
                                : _mm512_i64gather_epi64(s, a->first, 8);
        __m512i *to = (__m512i *)(void *)(offset + i);
        _mm512_storeu_si512(to, _mm512_add_epi64(_mm512_loadu_si512(to), first));
    }
}
#else
STAGE void find_spans(double *restrict x, double *restrict scale, int *restrict span, size_t *restrict offset,
                      const kn_eval_axis *axis, const double *restrict t)
{
    const kn_eval_axis a = *axis; // in registers: stores below cannot change it
    for (int i = 0; i < KN_EVAL_BLOCK; i++) span[i] = kn_eval_bucket(&a, t[i]);
    for (int i = 0; i < KN_EVAL_BLOCK; i++) span[i] = a.start[span[i]];
    for (int w = a.steps > 0 ? 1 << (a.steps - 1) : 0; w > 0; w /= 2)
        for (int i = 0; i < KN_EVAL_BLOCK; i++) span[i] += t[i] >= a.left[span[i] + w] ? w : 0;
    for (int i = 0; i < KN_EVAL_BLOCK; i++) {
        offset[i] += a.first[span[i]];
        x[i] = t[i] == a.end ? 1.0 : (t[i] - a.left[span[i]]) * a.inverse[span[i]];
        scale[i] = a.degree * a.inverse[span[i]];
    }
}
#endif

// ---- basis ----

// b[r][i] = C(p,r) x_i^r (1-x_i)^(p-r).
STAGE void bernstein(double *restrict b, const double *restrict x, const double *restrict binomial, int p)
{
    for (int i = 0; i < KN_EVAL_BLOCK; i += LANES) {
        vec xi = *(const vec *)(x + i), yi = 1.0 - xi, power, one;
        splat(&one, 1.0);
        power = one;
        for (int r = 0; r <= p; r++, power *= xi) *(vec *)(b + r * KN_EVAL_BLOCK + i) = binomial[r] * power;
        power = one;
        for (int r = p; r >= 0; r--, power *= yi) *(vec *)(b + r * KN_EVAL_BLOCK + i) *= power;
    }
}

// g[r][i] = scale_i (b_(r-1) - b_r), b of degree p - 1.
STAGE void slopes(double *restrict g, const double *restrict x, const double *restrict scale,
                  const double *restrict binomial, int p)
{
    bernstein(g, x, binomial, p - 1);
    for (int i = 0; i < KN_EVAL_BLOCK; i += LANES) {
        vec s = *(const vec *)(scale + i), here = {0};
        for (int r = p; r >= 0; r--) {
            vec before = {0};
            if (r > 0) before = *(vec *)(g + (r - 1) * KN_EVAL_BLOCK + i);
            *(vec *)(g + r * KN_EVAL_BLOCK + i) = s * (before - here);
            here = before;
        }
    }
}

// Both of degree 3; the same operations.
STAGE void cubic(double *restrict b, double *restrict g, const double *restrict x, const double *restrict scale,
                 bool partials)
{
    enum { N = KN_EVAL_BLOCK };
    for (int i = 0; i < N; i += LANES) {
        vec xi = *(const vec *)(x + i), yi = 1.0 - xi, x2 = xi * xi, y2 = yi * yi;
        *(vec *)(b + i) = y2 * yi;
        *(vec *)(b + N + i) = 3.0 * xi * y2;
        *(vec *)(b + 2 * N + i) = 3.0 * x2 * yi;
        *(vec *)(b + 3 * N + i) = x2 * xi;
        if (!partials) continue;
        vec s = *(const vec *)(scale + i), xy = 2.0 * xi * yi;
        *(vec *)(g + i) = s * (0.0 - y2);
        *(vec *)(g + N + i) = s * (y2 - xy);
        *(vec *)(g + 2 * N + i) = s * (xy - x2);
        *(vec *)(g + 3 * N + i) = s * x2;
    }
}

// basis[i][k] = sum_r b[r][i] E[r][k] of the point's span, and slope from g.
INLINE void b_splines(const kn_eval_axis *a, const int *span, int n, int p, int width, bool partials)
{
    const double *b = a->b, *g = a->g, *extract = a->extract;
    double *basis = a->basis, *slope = a->slope;
    for (int i = 0; i < n; i++) {
        const double *e = extract + (size_t)span[i] * (size_t)((p + 1) * width);
        for (int k = 0; k < width; k += LOW) {
            low sum = b[i] * *(const low *)(e + k), dsum = {0};
            if (partials) dsum = g[i] * *(const low *)(e + k);
            for (int r = 1; r <= p; r++) {
                low row = *(const low *)(e + r * width + k);
                sum += b[r * KN_EVAL_BLOCK + i] * row;
                if (partials) dsum += g[r * KN_EVAL_BLOCK + i] * row;
            }
            *(low *)(basis + i * width + k) = sum;
            if (partials) *(low *)(slope + i * width + k) = dsum;
        }
    }
}

STAGE void cubic_b_splines(const kn_eval_axis *a, const int *span, int n)
{
    b_splines(a, span, n, 3, 4, false);
}

STAGE void cubic_slopes(const kn_eval_axis *a, const int *span, int n)
{
    b_splines(a, span, n, 3, 4, true);
}

STAGE void any_b_splines(const kn_eval_axis *a, const int *span, int n, bool partials)
{
    b_splines(a, span, n, a->degree, a->width, partials);
}

// t[i * apart], and something at the end of a block that is not full.
INLINE void gather(double *to, const double *t, size_t apart, int n, double rest)
{
    int i = 0;
#if LANES == 8
    const __m512i even = _mm512_set_epi64(14, 12, 10, 8, 6, 4, 2, 0);
    for (; apart == 2 && i + 8 < n; i += 8) // the last number of a whole vector may be nobody's
        _mm512_storeu_pd(to + i,
                         _mm512_permutex2var_pd(_mm512_loadu_pd(t + 2 * i), even, _mm512_loadu_pd(t + 2 * i + 8)));
#endif
    for (; i < n; i++) to[i] = t[(size_t)i * apart];
    for (; i < KN_EVAL_BLOCK; i++) to[i] = rest;
}

// Everything of one variable for the n <= KN_EVAL_BLOCK points t[i * apart].
STAGE void one_axis(view *v, size_t *offset, const kn_eval_axis *a, const double *t, size_t apart, int n,
                    bool partials)
{
    double x[KN_EVAL_BLOCK], scale[KN_EVAL_BLOCK], at[KN_EVAL_BLOCK];
    int span[KN_EVAL_BLOCK];
    gather(at, t, apart, n, a->lo);
    find_spans(x, scale, span, offset, a, at);
    if (a->degree == 3)
        cubic(a->b, a->g, x, scale, partials);
    else {
        bernstein(a->b, x, a->binomial, a->degree);
        if (partials) slopes(a->g, x, scale, a->low, a->degree);
    }
    *v = (view){.n = a->b, .g = a->g, .step = KN_EVAL_BLOCK, .point = 1, .stride = a->stride, .degree = a->degree};
    if (!a->extract) return;
    if (a->degree != 3)
        any_b_splines(a, span, n, partials);
    else if (partials)
        cubic_slopes(a, span, n);
    else
        cubic_b_splines(a, span, n);
    *v = (view){a->basis, a->slope, 1, (size_t)a->width, a->stride, a->degree};
}

// ---- sums over control points ----
// A sum begins with -0, which changes no bits of what is added to it.

INLINE void start(vec *sum, int results)
{
    for (int m = 0; m < results; m++) splat(&sum[m], -0.0);
}

// sum[0 .. d+1] += the terms of one B-spline n (derivative g) of variable d, s[0 .. d] the value and partials of the
// variables before it.
INLINE void add(vec *sum, const vec *s, vec n, vec g, int d, bool partials)
{
    for (int m = 0; m < (partials ? 1 + d : 1); m++) sum[m] += n * s[m];
    if (partials) sum[1 + d] += g * s[0];
}

// B-spline k of point i.
INLINE void add_scaled(vec *sum, const vec *s, const view *v, int k, size_t i, int d, bool partials)
{
    vec n, g = {0};
    size_t at = i * v->point + (size_t)k * v->step;
    splat(&n, v->n[at]);
    if (partials) splat(&g, v->g[at]);
    add(sum, s, n, g, d, partials);
}

// s: the sums over the first variable at coefficient c of point i.
INLINE void line(vec *s, const double *c, const view *v, size_t i, int fixed, bool partials)
{
    int p = fixed >= 0 ? fixed : v->degree;
    start(s, partials ? 2 : 1);
    for (int k = 0; k <= p; k++, c += v->stride) add_scaled(s, (const vec *)c, v, k, i, 0, partials);
}

// n >= 2: over the variables 0 .. n-1, the lowest fastest; a sum that is complete is a term of the next one.
STAGE void many(vec *s, const double *c, const view *v, size_t i, int n, bool partials)
{
    vec sum[KN_MAX_VARS][KN_MAX_VARS + 1];
    int k[KN_MAX_VARS] = {0}, d;
    for (int m = 0; m < n; m++) start(sum[m], KN_MAX_VARS + 1);
    do {
        line(s, c, v, i, -1, partials);
        for (d = 1; d < n; d++) {
            int results = partials ? d + 2 : 1;
            add_scaled(sum[d], s, &v[d], k[d], i, d, partials);
            if (k[d] < v[d].degree) {
                k[d]++, c += v[d].stride;
                break;
            }
            c -= (size_t)k[d] * v[d].stride, k[d] = 0;
            memcpy(s, sum[d], (size_t)results * sizeof *s);
            start(sum[d], results);
        }
    } while (d < n);
}

// Over the variables 0 .. n-1.
INLINE void inner(vec *s, const double *c, const view *v, size_t i, int n, int fixed, bool partials)
{
    if (n == 0)
        s[0] = *(const vec *)c;
    else if (n == 1)
        line(s, c, v, i, fixed, partials);
    else
        many(s, c, v, i, n, partials);
}

// h[m] = result m: even and odd terms of the last variable apart.
INLINE void whole(vec *h, const double *c, const view *v, size_t i, int nvars, int fixed, bool partials)
{
    const view *last = &v[nvars - 1];
    int p = fixed >= 0 ? fixed : last->degree, results = partials ? 1 + nvars : 1;
    vec odd[KN_MAX_VARS + 1], s[KN_MAX_VARS + 1];
    start(h, results), start(odd, results);
    for (int k = 0; k <= p; k++, c += last->stride) {
        inner(s, c, v, i, nvars - 1, fixed, partials);
        add_scaled(k % 2 ? odd : h, s, last, k, i, nvars - 1, partials);
    }
    for (int m = 0; m < results; m++) h[m] = h[m] + odd[m];
}

#if LANES == 8
// As whole, for four components: terms k and k + 1 of the last variable in the low half of a vector and in the high
// one. Where there is no k + 1, what is in the high half belongs to nobody.
INLINE void whole_pairs(low *h, const double *c, const view *v, size_t i, int nvars, int fixed, bool partials)
{
    const view *last = &v[nvars - 1];
    int p = fixed >= 0 ? fixed : last->degree, results = partials ? 1 + nvars : 1;
    vec sum[KN_MAX_VARS + 1], s[KN_MAX_VARS + 1];
    start(sum, results);
    for (int k = 0; k <= p; k += 2) {
        size_t at = i * last->point + (size_t)k * last->step, next = k < p ? at + last->step : at;
        vec n = _mm512_mask_broadcastsd_pd(_mm512_set1_pd(last->n[at]), 0xF0, _mm_load_sd(last->n + next)), g = {0};
        if (partials) g = _mm512_mask_broadcastsd_pd(_mm512_set1_pd(last->g[at]), 0xF0, _mm_load_sd(last->g + next));
        inner(s, c + k * KN_EVAL_VECTOR, v, i, nvars - 1, fixed, partials);
        for (int m = 0; m < results; m++) {
            vec term = m == nvars ? g * s[0] : n * s[m];
            if (k < p)
                sum[m] = sum[m] + term;
            else
                sum[m] = _mm512_mask_add_pd(sum[m], 0x0F, sum[m], term);
        }
    }
    for (int m = 0; m < results; m++)
        h[m] = _mm256_add_pd(_mm512_castpd512_pd256(sum[m]), _mm512_extractf64x4_pd(sum[m], 1));
}
#endif

// ---- results ----

// From h[m * width + c], the weight last.
STAGE void divide(double *out, const double *h, int dim, int width, int results)
{
    double w = h[dim];
    for (int c = 0; c < dim; c++) out[c] = h[c] / w;
    for (int m = 1; m < results; m++)
        for (int c = 0; c < dim; c++) out[m * dim + c] = (h[m * width + c] - out[c] * h[m * width + dim]) / w;
}

// The same for at most four components in vectors, the weight in the last lane.
STAGE void divide_narrow(low *h, int results)
{
    enum { PARTS = KN_EVAL_VECTOR / LOW };
    double weight = h[PARTS - 1][LOW - 1];
    for (int c = 0; c < PARTS; c++) h[c] = h[c] / weight;
    for (int m = 1; m < results; m++) {
        double slope = h[m * PARTS + PARTS - 1][LOW - 1];
        for (int c = 0; c < PARTS; c++) h[m * PARTS + c] = (h[m * PARTS + c] - h[c] * slope) / weight;
    }
}

// ---- a block ----

typedef struct block {
    double *out;
    const kn_eval_plan *plan;
    const size_t *offset;
    const view *v;
    int n, dim;
} block;

// Points of four components or fewer: whole vectors, of which the next result overwrites what is too much.
INLINE void narrow(const block *b, int nvars, int fixed, bool split, bool partials)
{
    enum { PARTS = KN_EVAL_VECTOR / LOW };
    bool rational = b->plan->rational;
    int results = partials ? 1 + nvars : 1, dim = b->dim;
    const double *packed = b->plan->packed;
    const size_t *offset = b->offset;
    double *out = b->out;
    view v[KN_MAX_VARS];
    for (int d = 0; d < nvars; d++) v[d] = b->v[d];
    if (split) v[0].step = 1, v[0].point = KN_EVAL_VECTOR, v[1].step = KN_EVAL_BLOCK, v[1].point = 1;
    for (size_t i = 0, n = (size_t)b->n; i < n; i++, out += results * dim) {
        const double *c = packed + offset[i];
        low h[(KN_MAX_VARS + 1) * PARTS];
#if LANES == 8
        whole_pairs(h, c, v, i, nvars, fixed, partials);
#else
        for (int part = 0; part < PARTS; part++) {
            vec one[KN_MAX_VARS + 1];
            whole(one, c + part * LANES, v, i, nvars, fixed, partials);
            for (int m = 0; m < results; m++) h[m * PARTS + part] = one[m];
        }
#endif
        if (rational) {
            low apart[(KN_MAX_VARS + 1) * PARTS]; // so that h can stay in registers
            for (int m = 0; m < results * PARTS; m++) apart[m] = h[m];
            divide_narrow(apart, results);
            for (int m = 0; m < results * PARTS; m++) h[m] = apart[m];
        }
        for (int m = 0; m < results; m++)
            for (int part = 0; part < PARTS; part++) *(low *)(out + m * dim + part * LOW) = h[m * PARTS + part];
    }
}

// Of splines whose last variable is in Bezier form; a constant tells the compiler where all numbers lie. Narrow
// vectors gain too little by it.
INLINE bool is_split(const block *b)
{
    return LANES == 8 && b->v[0].step == 1 && b->v[1].step != 1;
}

STAGE void bicubic_values(const block *b)
{
    if (is_split(b))
        narrow(b, 2, 3, true, false);
    else
        narrow(b, 2, 3, false, false);
}

STAGE void bicubic_partials(const block *b)
{
    if (is_split(b))
        narrow(b, 2, 3, true, true);
    else
        narrow(b, 2, 3, false, true);
}

STAGE void surface_values(const block *b)
{
    narrow(b, 2, -1, false, false);
}

STAGE void surface_partials(const block *b)
{
    narrow(b, 2, -1, false, true);
}

STAGE void any_narrow(const block *b, bool partials)
{
    narrow(b, b->plan->nvars, -1, false, partials);
}

STAGE void any_wide(const block *b, bool partials)
{
    const kn_eval_plan *plan = b->plan;
    int width = plan->width, dim = b->dim, results = partials ? 1 + plan->nvars : 1;
    double h[(KN_MAX_VARS + 1) * KN_MAX_COMPS], *out = b->out;
    for (size_t i = 0; i < (size_t)b->n; i++, out += results * dim) {
        const double *c = plan->packed + b->offset[i];
        for (int part = 0; part < width; part += LANES) {
            vec one[KN_MAX_VARS + 1];
            whole(one, c + part, b->v, i, plan->nvars, -1, partials);
            for (int m = 0; m < results; m++) *(vec *)(h + m * width + part) = one[m];
        }
        if (plan->rational)
            divide(out, h, dim, width, results);
        else
            for (int m = 0; m < results; m++) memcpy(out + m * dim, h + m * width, (size_t)dim * sizeof *out);
    }
}

// Code of its own where it is worth it.
static void choose(const block *b, bool partials)
{
    const kn_eval_plan *plan = b->plan;
    bool cubic = plan->axis[0].degree == 3 && plan->axis[1].degree == 3;
    if (plan->width > KN_EVAL_VECTOR)
        any_wide(b, partials);
    else if (plan->nvars != 2)
        any_narrow(b, partials);
    else if (cubic && partials)
        bicubic_partials(b);
    else if (cubic)
        bicubic_values(b);
    else if (partials)
        surface_partials(b);
    else
        surface_values(b);
}

TARGET static void points(double *out, const kn_eval_plan *plan, size_t npoints, const double *at, bool partials)
{
    int vars = plan->nvars, dim = plan->ncomp - plan->rational;
    size_t each = (size_t)dim * (partials ? 1 + (size_t)vars : 1);
    double end[(KN_EVAL_BLOCK * (KN_MAX_VARS + 1) + 1) * KN_EVAL_VECTOR]; // for a block with too little behind it
    view v[KN_MAX_VARS];
    block b = {.plan = plan, .v = v, .dim = dim};
    for (int n; npoints > 0; npoints -= (size_t)n, at += n * vars, out += (size_t)n * each) {
        n = npoints < KN_EVAL_BLOCK ? (int)npoints : KN_EVAL_BLOCK;
        bool aside = (npoints - (size_t)n) * each < KN_EVAL_VECTOR && plan->width == KN_EVAL_VECTOR;
        size_t offset[KN_EVAL_BLOCK] = {0};
        for (int d = 0; d < vars; d++) one_axis(&v[d], offset, &plan->axis[d], at + d, (size_t)vars, n, partials);
        b.n = n, b.offset = offset, b.out = aside ? end : out;
        choose(&b, partials);
        if (aside) memcpy(out, end, (size_t)n * each * sizeof *out);
    }
}

// ---- grids ----

TARGET static void axis_basis(double *basis, size_t *first, const kn_eval_axis *a, size_t n, const double *at)
{
    for (size_t done = 0; done < n; done += KN_EVAL_BLOCK) {
        int m = n - done < KN_EVAL_BLOCK ? (int)(n - done) : KN_EVAL_BLOCK;
        size_t offset[KN_EVAL_BLOCK] = {0};
        view v;
        one_axis(&v, offset, a, at + done, 1, m, false);
        for (int i = 0; i < m; i++, basis += a->width) {
            *first++ = offset[i];
            for (int k = 0; k <= a->degree; k++) basis[k] = v.n[(size_t)i * v.point + (size_t)k * v.step];
        }
    }
}

INLINE void row_part(double *out, const double *in, size_t in_row, const double *n, int p)
{
    vec sum = n[0] * *(const vec *)in;
    for (int k = 1; k <= p; k++) sum += n[k] * *(const vec *)(in + (size_t)k * in_row);
    *(vec *)out = sum;
}

// What is left of a row is done with the vector that ends it, some of it twice.
INLINE void one_row(double *restrict out, const double *restrict in, size_t in_row, const double *restrict n, int p,
                    size_t length)
{
    for (size_t x = 0; x + LANES <= length; x += LANES) row_part(out + x, in + x, in_row, n, p);
    if (length % LANES != 0 && length > LANES) row_part(out + length - LANES, in + length - LANES, in_row, n, p);
    for (size_t x = 0; length < LANES && x < length; x++) {
        double sum = n[0] * in[x];
        for (int k = 1; k <= p; k++) sum += n[k] * in[(size_t)k * in_row + x];
        out[x] = sum;
    }
}

TARGET static void rows(const kn_eval_rows *r)
{
    for (size_t i = 0; i < r->n; i++) {
        double *out = r->out + i * r->out_row;
        const double *in = r->in + r->first[i] * r->scale, *n = r->basis + i * (size_t)r->width;
        if (r->degree == 3)
            one_row(out, in, r->in_row, n, 3, r->length);
        else
            one_row(out, in, r->in_row, n, r->degree, r->length);
    }
}

#endif
