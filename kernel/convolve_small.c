// SPDX-License-Identifier: Apache-2.0
// Small products in vectors of eight doubles. A row of b, q numbers and zeros behind them, fits into a vector in
// 9 - q positions: turned by one lane at a time it meets as many columns of a. Further columns of a meet the same
// turned rows, for sums of their own, which lie 9 - q columns further right in the result. As in
// kernel/convolve_stages.h the rows of b pass by and the sums move up.
#include "kernel/convolve_small.h"

#include "kernel/binomial.h"
#include "kernel/convolve.h"

enum { LANES = 8, MOST_COMPS = 4, MOST_ROWS = 8 };

bool kn_small_in_order(const kn_term *terms, int nterms, int ncomp)
{
    int to = -1;
    for (int i = 0; i < nterms; i++) {
        if (terms[i].to != to && terms[i].to != to + 1) return false;
        to = terms[i].to;
    }
    return to == ncomp - 1;
}

#if defined(__x86_64__)
#include <immintrin.h>

#define TARGET target("avx512f,avx512vl,avx512dq")
#define OUTLINE static __attribute__((TARGET))
#define INLINE static inline __attribute__((always_inline, TARGET))

bool kn_small_fits(int rows_a, int columns_a, int na, int rows_b, int columns_b, int nb)
{
    int places = LANES + 1 - columns_b;
    return rows_a <= MOST_ROWS && rows_b <= MOST_ROWS && columns_a <= LANES && columns_b <= LANES &&
           columns_a <= 2 * places && na <= MOST_COMPS && nb <= MOST_COMPS &&
           kn_convolve_best() == KN_CONVOLVE_AVX512;
}

typedef double packed[MOST_COMPS][MOST_ROWS][LANES];

// Everything about a product of two components.
typedef struct task {
    const double *a, *b; // scaled rows of LANES numbers
    int rows_a, rows_b, columns_a, places, columns;
    double sign;
    bool first, last;                // of the terms of one component of the result
    const double *row, *row_inverse; // binomials of the result's rows
    const double *column, *column_inverse;
    double *out;
    double (*sums)[2 * LANES];
} task;

OUTLINE void pack(packed to, const kn_small_operand *o)
{
    const double *row = kn_pascal(o->rows - 1), *from = o->coef;
    __m512d column = _mm512_loadu_pd(kn_pascal(o->columns - 1));
    __mmask8 used = (__mmask8)((1u << o->columns) - 1u);
    for (int c = 0; c < o->ncomp; c++)
        for (int i = 0; i < o->rows; i++, from += o->columns) {
            __m512d weight = _mm512_mul_pd(_mm512_set1_pd(row[i]), column);
            _mm512_storeu_pd(to[c][i], _mm512_mul_pd(weight, _mm512_maskz_loadu_pd(used, from)));
        }
    for (int i = 0; i < o->rows && o->with_one; i++)
        _mm512_storeu_pd(to[o->ncomp][i], _mm512_maskz_mul_pd(used, _mm512_set1_pd(row[i]), column));
}

INLINE __m512d divided(__m512d x, double weight, const double *column, double inverse, const double *column_inverse)
{
    __m512d d = _mm512_mul_pd(_mm512_set1_pd(weight), _mm512_loadu_pd(column));
    __m512d r = _mm512_mul_pd(_mm512_set1_pd(inverse), _mm512_loadu_pd(column_inverse));
    __m512d q = _mm512_mul_pd(x, r), rest = _mm512_fnmadd_pd(q, d, x);
    return _mm512_mask3_fmadd_pd(rest, r, q, _mm512_cmp_pd_mask(rest, rest, _CMP_ORD_Q));
}

// Row k of this term: to the sums, or with the last term divided to the result.
INLINE void put(const task *t, int k, __m512d near, __m512d far, bool two)
{
    __m512d sign = _mm512_set1_pd(t->sign), lo = near, hi = _mm512_setzero_pd();
    if (two) { // far lies `places` lanes further right
        __m512i from = _mm512_sub_epi64(_mm512_setr_epi64(0, 1, 2, 3, 4, 5, 6, 7), _mm512_set1_epi64(t->places));
        __mmask8 inside = (__mmask8)(0xffu << t->places);
        __m512d turned = _mm512_permutexvar_pd(from, far);
        lo = _mm512_mask_add_pd(lo, inside, lo, turned);
        hi = _mm512_maskz_mov_pd((__mmask8)~inside, turned);
    }
    double *sum = t->sums[k];
    lo = t->first ? _mm512_mul_pd(sign, lo) : _mm512_fmadd_pd(sign, lo, _mm512_loadu_pd(sum));
    if (two) hi = t->first ? _mm512_mul_pd(sign, hi) : _mm512_fmadd_pd(sign, hi, _mm512_loadu_pd(sum + LANES));
    if (!t->last) {
        _mm512_storeu_pd(sum, lo);
        if (two) _mm512_storeu_pd(sum + LANES, hi);
        return;
    }
    double *out = t->out + (size_t)k * (size_t)t->columns;
    int n = t->columns < LANES ? t->columns : LANES;
    lo = divided(lo, t->row[k], t->column, t->row_inverse[k], t->column_inverse);
    _mm512_mask_storeu_pd(out, (__mmask8)((1u << n) - 1u), lo);
    if (!two || t->columns <= LANES) return;
    hi = divided(hi, t->row[k], t->column + LANES, t->row_inverse[k], t->column_inverse + LANES);
    _mm512_mask_storeu_pd(out + LANES, (__mmask8)((1u << (t->columns - LANES)) - 1u), hi);
}

INLINE void meet(__m512d *sum, const double *a, __m512d v, int rows)
{
#pragma GCC unroll 8
    for (int i = 0; i < rows; i++) sum[i] = _mm512_fmadd_pd(_mm512_set1_pd(a[i * LANES]), v, sum[i]);
}

// Lane 7 comes first.
INLINE __m512d turn(__m512d v)
{
    __m512i i = _mm512_castpd_si512(v);
    return _mm512_castsi512_pd(_mm512_alignr_epi64(i, i, 7));
}

// One more set of sums where all columns of a fit: odd columns have their own, so that fewer sums wait for each other.
INLINE void sweep(const task *t, int rows, bool two)
{
    __m512d near[MOST_ROWS], far[MOST_ROWS], zero = _mm512_setzero_pd();
#pragma GCC unroll 8
    for (int i = 0; i < rows; i++) near[i] = far[i] = zero;
    int both = two ? t->columns_a - t->places : t->columns_a / 2 * 2;
    for (int k = 0; k < t->rows_b; k++) {
        __m512d v = _mm512_loadu_pd(t->b + k * LANES);
        int j = 0;
        if (two) {
            for (; j < both; j++, v = turn(v)) {
                meet(near, t->a + j, v, rows);
                meet(far, t->a + j + t->places, v, rows);
            }
            for (; j < t->places; j++, v = turn(v)) meet(near, t->a + j, v, rows);
        } else {
            for (; j < both; j += 2, v = turn(turn(v))) {
                meet(near, t->a + j, v, rows);
                meet(far, t->a + j + 1, turn(v), rows);
            }
            if (j < t->columns_a) meet(near, t->a + j, v, rows);
        }
        if (two)
            put(t, k, near[0], far[0], true);
        else
            put(t, k, _mm512_add_pd(near[0], far[0]), zero, false);
#pragma GCC unroll 8
        for (int i = 0; i < rows; i++)
            near[i] = i + 1 < rows ? near[i + 1] : zero, far[i] = i + 1 < rows ? far[i + 1] : zero;
    }
#pragma GCC unroll 8
    for (int i = 0; i < rows - 1; i++) {
        if (two)
            put(t, t->rows_b + i, near[i], far[i], true);
        else
            put(t, t->rows_b + i, _mm512_add_pd(near[i], far[i]), zero, false);
    }
}

OUTLINE void sweep_one(const task *t)
{
    switch (t->rows_a) {
    case 1: sweep(t, 1, false); break;
    case 2: sweep(t, 2, false); break;
    case 3: sweep(t, 3, false); break;
    case 4: sweep(t, 4, false); break;
    case 5: sweep(t, 5, false); break;
    case 6: sweep(t, 6, false); break;
    case 7: sweep(t, 7, false); break;
    default: sweep(t, 8, false); break;
    }
}

OUTLINE void sweep_two(const task *t)
{
    switch (t->rows_a) {
    case 1: sweep(t, 1, true); break;
    case 2: sweep(t, 2, true); break;
    case 3: sweep(t, 3, true); break;
    case 4: sweep(t, 4, true); break;
    case 5: sweep(t, 5, true); break;
    case 6: sweep(t, 6, true); break;
    case 7: sweep(t, 7, true); break;
    default: sweep(t, 8, true); break;
    }
}

OUTLINE void run(double *out, const kn_small_operand *a, const kn_small_operand *b, const kn_term *terms, int nterms)
{
    packed pa, pb;
    double sums[2 * MOST_ROWS - 1][2 * LANES];
    task t;
    pack(pa, a);
    pack(pb, b);
    t.rows_a = a->rows, t.rows_b = b->rows, t.columns_a = a->columns, t.places = LANES + 1 - b->columns;
    t.columns = a->columns + b->columns - 1;
    int rows = a->rows + b->rows - 1;
    t.row = kn_pascal(rows - 1), t.row_inverse = kn_pascal_inverse(rows - 1);
    t.column = kn_pascal(t.columns - 1), t.column_inverse = kn_pascal_inverse(t.columns - 1);
    t.sums = sums;
    for (int i = 0; i < nterms; i++) {
        t.first = i == 0 || terms[i - 1].to != terms[i].to;
        t.last = i + 1 == nterms || terms[i + 1].to != terms[i].to;
        t.a = pa[terms[i].a][0], t.b = pb[terms[i].b][0], t.sign = terms[i].sign;
        t.out = out + (size_t)terms[i].to * (size_t)(rows * t.columns);
        if (t.columns_a <= t.places)
            sweep_one(&t);
        else
            sweep_two(&t);
    }
}

void kn_small_run(double *out, const kn_small_operand *a, const kn_small_operand *b, const kn_term *terms, int nterms)
{
    run(out, a, b, terms, nterms);
}
#else
bool kn_small_fits(int rows_a, int columns_a, int na, int rows_b, int columns_b, int nb)
{
    (void)rows_a, (void)columns_a, (void)na, (void)rows_b, (void)columns_b, (void)nb;
    return false;
}

void kn_small_run(double *out, const kn_small_operand *a, const kn_small_operand *b, const kn_term *terms, int nterms)
{
    (void)out, (void)a, (void)b, (void)terms, (void)nterms;
}
#endif
