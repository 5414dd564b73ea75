// SPDX-License-Identifier: Apache-2.0
// The stages of batched evaluation in vectors of LANES doubles (2, 4 or 8), to be included once by a file that defines
// LANES and TARGET, the attribute of the machines it is for. Everything is inlined into functions of that target.
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

// A point's B-splines in one variable, or Bernstein polynomials: n[k * step], derivatives g[k * step]. point: from one
// point of the block to the next.
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

// Few spans: their tables fit into registers.
INLINE void find_spans(double *restrict x, double *restrict scale, int *restrict span, size_t *restrict offset,
                       const kn_eval_axis *a, const double *restrict t)
{
    __m512d lo = _mm512_set1_pd(a->lo), factor = _mm512_set1_pd(a->scale), last = _mm512_set1_pd(a->buckets - 1);
    __m512d end = _mm512_set1_pd(a->end), degree = _mm512_set1_pd(a->degree), left[4], inverse[4];
    int top = a->steps > 0 ? 1 << (a->steps - 1) : 0;
    bool few = a->spans < KN_EVAL_FEW;
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
INLINE void find_spans(double *restrict x, double *restrict scale, int *restrict span, size_t *restrict offset,
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
INLINE void bernstein(double *restrict b, const double *restrict x, const double *restrict binomial, int p)
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
INLINE void slopes(double *restrict g, const double *restrict x, const double *restrict scale,
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

// basis[i][k] = sum_r b[r][i] E[r][k] of the point's span, and slope from g.
INLINE void b_splines(double *restrict basis, double *restrict slope, const kn_eval_axis *a, const int *span, int n,
                      int p, int width, bool partials)
{
    const double *b = a->b, *g = a->g, *extract = a->extract;
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

// Everything of one variable for the n <= KN_EVAL_BLOCK points t[i * apart]. fixed: the degree, or -1.
INLINE void one_axis(view *v, size_t *offset, const kn_eval_axis *a, const double *t, size_t apart, int n, int fixed,
                     bool partials)
{
    double x[KN_EVAL_BLOCK], scale[KN_EVAL_BLOCK], at[KN_EVAL_BLOCK];
    int span[KN_EVAL_BLOCK], p = fixed >= 0 ? fixed : a->degree;
    for (int i = 0; i < n; i++) at[i] = t[(size_t)i * apart];
    for (int i = n; i < KN_EVAL_BLOCK; i++) at[i] = a->lo;
    find_spans(x, scale, span, offset, a, at);
    bernstein(a->b, x, a->binomial, p);
    if (partials) slopes(a->g, x, scale, a->low, p);
    *v = (view){.n = a->b, .g = a->g, .step = KN_EVAL_BLOCK, .point = 1, .stride = a->stride, .degree = p};
    if (!a->extract) return;
    int width = fixed >= 0 ? (fixed + KN_EVAL_VECTOR) / KN_EVAL_VECTOR * KN_EVAL_VECTOR : a->width;
    b_splines(a->basis, a->slope, a, span, n, p, width, partials);
    *v = (view){a->basis, a->slope, 1, (size_t)width, a->stride, p};
}

// ---- sums over control points ----

// sum[0 .. d+1] += the terms of one B-spline n (derivative g) of variable d, s[0 .. d] the value and partials of the
// variables before it.
INLINE void add(vec *sum, const vec *s, vec n, vec g, bool first, int d, bool partials)
{
    int results = partials ? 1 + d : 1;
    for (int m = 0; m < results && first; m++) sum[m] = n * s[m];
    for (int m = 0; m < results && !first; m++) sum[m] += n * s[m];
    if (partials && first) sum[1 + d] = g * s[0];
    if (partials && !first) sum[1 + d] += g * s[0];
}

INLINE void add_scaled(vec *sum, const vec *s, const view *v, int k, size_t i, int d, bool first, bool partials)
{
    vec n, g = {0};
    size_t at = i * v->point + (size_t)k * v->step;
    splat(&n, v->n[at]);
    if (partials) splat(&g, v->g[at]);
    add(sum, s, n, g, first, d, partials);
}

// s: the sums over the variables 0 .. n-1 at coefficient c of point i.
INLINE void inner1(vec *s, const double *c, const view *v, size_t i, int fixed, bool partials)
{
    add_scaled(s, (const vec *)c, &v[0], 0, i, 0, true, partials);
    for (int k = 1; k <= (fixed >= 0 ? fixed : v[0].degree); k++)
        add_scaled(s, (const vec *)(c + (size_t)k * v[0].stride), &v[0], k, i, 0, false, partials);
}

INLINE void inner2(vec *s, const double *c, const view *v, size_t i, int fixed, bool partials)
{
    vec t[2];
    inner1(t, c, v, i, fixed, partials);
    add_scaled(s, t, &v[1], 0, i, 1, true, partials);
    for (int k = 1; k <= (fixed >= 0 ? fixed : v[1].degree); k++) {
        inner1(t, c + (size_t)k * v[1].stride, v, i, fixed, partials);
        add_scaled(s, t, &v[1], k, i, 1, false, partials);
    }
}

// n >= 3: over all of the variables 2 .. n-1, the lowest fastest; a sum that is complete is a term of the next one.
INLINE void inner_many(vec *s, const double *c, const view *v, size_t i, int n, bool partials)
{
    vec sum[KN_MAX_VARS][KN_MAX_VARS + 1];
    int k[KN_MAX_VARS] = {0}, d = 0;
    memset(sum, 0, (size_t)n * sizeof *sum);
    do {
        inner2(s, c, v, i, -1, partials);
        for (d = 2; d < n; d++) {
            add_scaled(sum[d], s, &v[d], k[d], i, d, k[d] == 0, partials);
            if (k[d] < v[d].degree) {
                k[d]++, c += v[d].stride;
                break;
            }
            c -= (size_t)k[d] * v[d].stride, k[d] = 0;
            memcpy(s, sum[d], (partials ? (size_t)d + 2 : 1) * sizeof *s);
        }
    } while (d < n);
}

INLINE void inner(vec *s, const double *c, const view *v, size_t i, int n, int fixed, bool partials)
{
    if (n == 0)
        s[0] = *(const vec *)c;
    else if (n == 1)
        inner1(s, c, v, i, fixed, partials);
    else if (n == 2)
        inner2(s, c, v, i, fixed, partials);
    else
        inner_many(s, c, v, i, n, partials);
}

// Term k of the last variable.
INLINE void last_term(vec *sum, const double *c, const view *v, int k, size_t i, int nvars, int fixed, bool first,
                      bool partials)
{
    vec s[KN_MAX_VARS + 1];
    const view *last = &v[nvars - 1];
    inner(s, c + (size_t)k * last->stride, v, i, nvars - 1, fixed, partials);
    add_scaled(sum, s, last, k, i, nvars - 1, first, partials);
}

// h[m] = result m: even and odd terms of the last variable apart.
INLINE void whole(vec *h, const double *c, const view *v, size_t i, int nvars, int fixed, bool partials)
{
    int p = fixed >= 0 ? fixed : v[nvars - 1].degree;
    vec odd[KN_MAX_VARS + 1];
    last_term(h, c, v, 0, i, nvars, fixed, true, partials);
    if (p == 0) return;
    last_term(odd, c, v, 1, i, nvars, fixed, true, partials);
    for (int k = 2; k <= p; k += 2) {
        last_term(h, c, v, k, i, nvars, fixed, false, partials);
        if (k < p) last_term(odd, c, v, k + 1, i, nvars, fixed, false, partials);
    }
    for (int m = 0; m <= (partials ? nvars : 0); m++) h[m] = h[m] + odd[m];
}

#if LANES == 8
INLINE void pair(vec *v, const double *n, size_t step)
{
    *v = _mm512_mask_broadcastsd_pd(_mm512_set1_pd(n[0]), 0xF0, _mm_load_sd(n + step));
}

// Terms k and k + 1 of the last variable, of four components: in the low half of a vector and in the high one.
INLINE void last_pair(vec *sum, const double *c, const view *v, int k, size_t i, int nvars, int fixed, bool first,
                      bool partials)
{
    const view *last = &v[nvars - 1];
    size_t at = i * last->point + (size_t)k * last->step;
    vec s[KN_MAX_VARS + 1], n, g = {0};
    pair(&n, last->n + at, last->step);
    if (partials) pair(&g, last->g + at, last->step);
    inner(s, c + k * KN_EVAL_VECTOR, v, i, nvars - 1, fixed, partials);
    add(sum, s, n, g, first, nvars - 1, partials);
}

// As whole, for four components.
INLINE void whole_pairs(low *h, const double *c, const view *v, size_t i, int nvars, int fixed, bool partials)
{
    int p = fixed >= 0 ? fixed : v[nvars - 1].degree, results = partials ? 1 + nvars : 1;
    vec sum[KN_MAX_VARS + 1], one[KN_MAX_VARS + 1];
    if (p == 0) { // what is in the high half belongs to nobody
        last_term(one, c, v, 0, i, nvars, fixed, true, partials);
        for (int m = 0; m < results; m++) h[m] = _mm512_castpd512_pd256(one[m]);
        return;
    }
    last_pair(sum, c, v, 0, i, nvars, fixed, true, partials);
    for (int k = 2; k < p; k += 2) last_pair(sum, c, v, k, i, nvars, fixed, false, partials);
    if (p % 2 == 0) { // here too
        last_term(one, c, v, p, i, nvars, fixed, true, partials);
        for (int m = 0; m < results; m++) sum[m] = _mm512_mask_add_pd(sum[m], 0x0F, sum[m], one[m]);
    }
    for (int m = 0; m < results; m++)
        h[m] = _mm256_add_pd(_mm512_castpd512_pd256(sum[m]), _mm512_extractf64x4_pd(sum[m], 1));
}
#endif

// ---- results ----

// From h[m * width + c], the weight last.
INLINE void divide(double *out, const double *h, int dim, int width, int results)
{
    double w = h[dim];
    for (int c = 0; c < dim; c++) out[c] = h[c] / w;
    for (int m = 1; m < results; m++)
        for (int c = 0; c < dim; c++) out[m * dim + c] = (h[m * width + c] - out[c] * h[m * width + dim]) / w;
}

// The same for at most four components in vectors, the weight in the last lane.
INLINE void divide_narrow(low *h, int results)
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

// A point of four components or fewer: whole vectors, of which the next result overwrites what is too much; `room`
// tells that the last one may do so, too.
INLINE void narrow_point(double *out, bool room, int dim, bool rational, const double *c, const view *v, size_t i,
                         int nvars, int fixed, bool partials)
{
    enum { PARTS = KN_EVAL_VECTOR / LOW };
    int results = partials ? 1 + nvars : 1;
    double copy[(KN_MAX_VARS + 1) * KN_EVAL_VECTOR], *to = room ? out : copy;
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
    if (rational) divide_narrow(h, results);
    for (int m = 0; m < results; m++)
        for (int part = 0; part < PARTS; part++) *(low *)(to + m * dim + part * LOW) = h[m * PARTS + part];
    if (!room) memcpy(out, copy, (size_t)(results * dim) * sizeof *out);
}

INLINE void wide_point(double *out, const kn_eval_plan *plan, const double *c, const view *v, size_t i, int nvars,
                       bool partials)
{
    int dim = plan->ncomp - plan->rational, results = partials ? 1 + nvars : 1, width = plan->width;
    double h[(KN_MAX_VARS + 1) * KN_MAX_COMPS];
    for (int part = 0; part < width; part += LANES) {
        vec one[KN_MAX_VARS + 1];
        whole(one, c + part, v, i, nvars, -1, partials);
        for (int m = 0; m < results; m++) *(vec *)(h + m * width + part) = one[m];
    }
    if (plan->rational)
        divide(out, h, dim, width, results);
    else
        for (int m = 0; m < results; m++) memcpy(out + m * dim, h + m * width, (size_t)dim * sizeof *out);
}

// nvars 0: any number, and any number of components.
INLINE void all_blocks(double *out, const kn_eval_plan *plan, size_t npoints, const double *at, int nvars, int fixed,
                       bool partials)
{
    int vars = nvars > 0 ? nvars : plan->nvars;
    int dim = plan->ncomp - plan->rational;
    bool rational = plan->rational;
    size_t each = (size_t)dim * (partials ? 1 + (size_t)vars : 1);
    const double *end = out + npoints * each;
    while (npoints > 0) {
        int n = npoints < KN_EVAL_BLOCK ? (int)npoints : KN_EVAL_BLOCK;
        view v[KN_MAX_VARS];
        size_t offset[KN_EVAL_BLOCK] = {0};
        for (int d = 0; d < vars; d++)
            one_axis(&v[d], offset, &plan->axis[d], at + d, (size_t)vars, n, fixed, partials);
        const double *packed = plan->packed;
        for (int i = 0; i < n; i++, out += each)
            if (nvars > 0 || plan->width == KN_EVAL_VECTOR) {
                bool room = end - out >= (ptrdiff_t)each + KN_EVAL_VECTOR;
                narrow_point(out, room, dim, rational, packed + offset[i], v, (size_t)i, vars, fixed, partials);
            } else
                wide_point(out, plan, packed + offset[i], v, (size_t)i, vars, partials);
        npoints -= (size_t)n, at += n * vars;
    }
}

// The degree when it is the same in all variables and common, else -1.
INLINE int common_degree(const kn_eval_plan *plan)
{
    int p = plan->axis[0].degree;
    for (int d = 1; d < plan->nvars; d++)
        if (plan->axis[d].degree != p) return -1;
    return p;
}

// Code of its own where it is worth it.
INLINE void choose(double *out, const kn_eval_plan *plan, size_t npoints, const double *at, bool partials)
{
    int p = common_degree(plan);
    switch (plan->width == KN_EVAL_VECTOR ? plan->nvars : 0) {
    case 1:
        if (p == 3)
            all_blocks(out, plan, npoints, at, 1, 3, partials);
        else
            all_blocks(out, plan, npoints, at, 1, -1, partials);
        return;
    case 2:
        if (p == 3)
            all_blocks(out, plan, npoints, at, 2, 3, partials);
        else if (p == 2)
            all_blocks(out, plan, npoints, at, 2, 2, partials);
        else
            all_blocks(out, plan, npoints, at, 2, -1, partials);
        return;
    case 3:
        if (p == 3)
            all_blocks(out, plan, npoints, at, 3, 3, partials);
        else
            all_blocks(out, plan, npoints, at, 3, -1, partials);
        return;
    default: all_blocks(out, plan, npoints, at, 0, -1, partials);
    }
}

TARGET static void points(double *out, const kn_eval_plan *plan, size_t npoints, const double *at, bool partials)
{
    if (partials)
        choose(out, plan, npoints, at, true);
    else
        choose(out, plan, npoints, at, false);
}

// ---- grids ----

TARGET static void axis_basis(double *basis, size_t *first, const kn_eval_axis *a, size_t n, const double *at)
{
    for (size_t done = 0; done < n; done += KN_EVAL_BLOCK) {
        int m = n - done < KN_EVAL_BLOCK ? (int)(n - done) : KN_EVAL_BLOCK;
        size_t offset[KN_EVAL_BLOCK] = {0};
        view v;
        if (a->degree == 3)
            one_axis(&v, offset, a, at + done, 1, m, 3, false);
        else
            one_axis(&v, offset, a, at + done, 1, m, -1, false);
        for (int i = 0; i < m; i++, basis += a->width) {
            *first++ = offset[i];
            for (int k = 0; k <= a->degree; k++) basis[k] = v.n[(size_t)i * v.point + (size_t)k * v.step];
        }
    }
}

INLINE void one_row(double *restrict out, const double *restrict in, size_t in_row, const double *restrict n, int p,
                    size_t length)
{
    size_t x = 0;
    for (; x + LANES <= length; x += LANES) {
        vec sum = n[0] * *(const vec *)(in + x);
        for (int k = 1; k <= p; k++) sum += n[k] * *(const vec *)(in + (size_t)k * in_row + x);
        *(vec *)(out + x) = sum;
    }
    for (; x < length; x++) {
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
        switch (r->degree) {
        case 1: one_row(out, in, r->in_row, n, 1, r->length); break;
        case 2: one_row(out, in, r->in_row, n, 2, r->length); break;
        case 3: one_row(out, in, r->in_row, n, 3, r->length); break;
        default: one_row(out, in, r->in_row, n, r->degree, r->length);
        }
    }
}

#endif
