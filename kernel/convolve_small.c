// SPDX-License-Identifier: Apache-2.0
// Small products in vectors of eight doubles: row r of the result is
//     sum_j x^j D_j,  D_j = sum_(i + k = r) a[i][j] b[k],
// b[k] a row in the lanes, a[i][j] in all of them. The D_j are independent sums of at most `rows` terms, which never
// leave the registers; then they are added, each shifted by one lane more than the one before. Two rows of the result
// share the numbers of a. A ninth column of b makes a sum of its own: with the first eight columns of a in the lanes.
#include "kernel/convolve_small.h"

#include "kernel/binomial.h"
#include "kernel/convolve.h"

enum { LANES = 8, MOST = KN_SMALL_DEGREE + 1, MOST_COMPS = 4 };

bool kn_small_in_order(const kn_term *terms, int nterms, int ncomp)
{
    int to = -1;
    for (int i = 0; i < nterms; i++) {
        if (terms[i].to != to && terms[i].to != to + 1) return false;
        to = terms[i].to;
    }
    return to == ncomp - 1;
}

bool kn_small_here(void)
{
#if defined(__x86_64__)
    return kn_convolve_best() == KN_CONVOLVE_AVX512 && __builtin_cpu_supports("fma");
#else
    return false;
#endif
}

bool kn_small_fits(int rows_a, int columns_a, int na, int rows_b, int columns_b, int nb)
{
    return rows_a <= MOST && rows_b <= MOST && columns_a <= MOST && columns_b <= MOST && na <= MOST_COMPS &&
           nb <= MOST_COMPS && kn_small_here();
}

#if defined(__x86_64__)
#include <immintrin.h>

#define TARGET target("avx512f,avx512vl,avx512dq,fma")
#define OUTLINE static __attribute__((noinline, TARGET))
#define INLINE static inline __attribute__((always_inline, TARGET))

// Scaled rows of a, and of b between two rows of zeros. Row i's number 8 lies apart from the others for b.
typedef struct spread {
    _Alignas(64) double row[MOST][2 * LANES];
} spread;
typedef struct lanes {
    _Alignas(64) double row[MOST + 2][LANES];
    double ninth[MOST + 2];
} lanes;

typedef struct pair {
    const spread *a;
    const lanes *b;
} pair;

// Everything about one component of the result.
typedef struct task {
    const pair *terms;
    int nterms, rows_a, rows_b, rows, columns;
    const double *row, *row_inverse, *column, *column_inverse; // binomials of the result's degrees
    double *out, *end;
} task;

// ---- operands; from NULL: the constant 1 ----
INLINE __mmask8 first(int n)
{
    return n >= LANES ? (__mmask8)0xff : (__mmask8)((1u << n) - 1u);
}

OUTLINE void pack_spread(spread *to, const double *from, int rows, int columns, double sign)
{
    const double *row = kn_pascal(rows - 1), *column = kn_pascal(columns - 1);
    __m512d weights = _mm512_maskz_loadu_pd(first(columns), column);
    for (int i = 0; i < rows; i++) {
        __m512d w = _mm512_mul_pd(weights, _mm512_set1_pd(sign * row[i]));
        if (from) w = _mm512_mul_pd(w, _mm512_maskz_loadu_pd(first(columns), from + i * columns));
        _mm512_store_pd(to->row[i], w);
        if (columns > LANES) to->row[i][LANES] = sign * row[i] * (from ? from[i * columns + LANES] : 1.0);
    }
}

OUTLINE void pack_lanes(lanes *to, const double *from, int rows, int columns)
{
    const double *row = kn_pascal(rows - 1), *column = kn_pascal(columns - 1);
    __m512d weights = _mm512_maskz_loadu_pd(first(columns), column);
    _mm512_store_pd(to->row[0], _mm512_setzero_pd());
    for (int i = 0; i < rows; i++) {
        __m512d w = _mm512_mul_pd(weights, _mm512_set1_pd(row[i]));
        if (from) w = _mm512_mul_pd(w, _mm512_maskz_loadu_pd(first(columns), from + i * columns));
        _mm512_store_pd(to->row[i + 1], w);
    }
    _mm512_store_pd(to->row[rows + 1], _mm512_setzero_pd());
    if (columns <= LANES) return;
    to->ninth[0] = to->ninth[rows + 1] = 0.0;
    for (int i = 0; i < rows; i++) to->ninth[i + 1] = row[i] * (from ? from[i * columns + LANES] : 1.0);
}

// ---- results ----
// x / (weight column), as in kernel/convolve.c; an infinite x stays.
INLINE __m512d divided(__m512d x, double weight, const double *column, double inverse, const double *column_inverse)
{
    __m512d d = _mm512_mul_pd(_mm512_set1_pd(weight), _mm512_loadu_pd(column));
    __m512d r = _mm512_mul_pd(_mm512_set1_pd(inverse), _mm512_loadu_pd(column_inverse));
    __m512d q = _mm512_mul_pd(x, r), rest = _mm512_fnmadd_pd(q, d, x);
    return _mm512_mask3_fmadd_pd(rest, r, q, _mm512_cmp_pd_mask(rest, rest, _CMP_ORD_Q));
}

// Whole vectors: what they write beyond a row the next ones write again, in this order; nothing beyond the end.
INLINE void put(const task *t, double *to, __m512d v)
{
    ptrdiff_t left = t->end - to;
    if (left >= LANES)
        _mm512_storeu_pd(to, v);
    else
        _mm512_mask_storeu_pd(to, (__mmask8)((1u << left) - 1u), v);
}

// Lanes move up by 1, 2 or 4; the highest ones of below come in.
INLINE __m512d up(__m512d v, __m512d below, int by)
{
    __m512i x = _mm512_castpd_si512(v), y = _mm512_castpd_si512(below);
    if (by == 1) return _mm512_castsi512_pd(_mm512_alignr_epi64(x, y, 7));
    if (by == 2) return _mm512_castsi512_pd(_mm512_alignr_epi64(x, y, 6));
    return _mm512_castsi512_pd(_mm512_alignr_epi64(x, y, 4));
}

// Polynomials in two vectors, hi[] for places from 8 on: the even ones += x^by times the odd ones after them. by 1:
// all of hi[] is zero and not there yet. Returns how many are left.
INLINE int fold(__m512d *lo, __m512d *hi, int n, int by, bool two)
{
    __m512d zero = _mm512_setzero_pd();
#pragma GCC unroll 4
    for (int m = 0; m < n / 2; m++) {
        __m512d l = lo[2 * m + 1];
        if (two) {
            __m512d h = up(by == 1 ? zero : hi[2 * m + 1], l, by);
            hi[m] = by == 1 ? h : _mm512_add_pd(hi[2 * m], h);
        }
        lo[m] = _mm512_add_pd(lo[2 * m], up(l, zero, by));
    }
    if (n % 2) lo[n / 2] = lo[n - 1];
    if (n % 2 && two) hi[n / 2] = by == 1 ? zero : hi[n - 1];
    return (n + 1) / 2;
}

// Row r = sum_j x^j sum[j], neighbours first; beyond: what belongs to the places from 8 on.
INLINE void finish(const task *t, int r, const __m512d *sum, int columns, bool two, bool nine, __m512d beyond)
{
    __m512d l[LANES], h[LANES], lo, hi;
    int n = columns < LANES ? columns : LANES;
#pragma GCC unroll 8
    for (int j = 0; j < n; j++) l[j] = sum[j];
    n = fold(l, h, n, 1, two);
    n = fold(l, h, n, 2, two);
    n = fold(l, h, n, 4, two);
    lo = l[0], hi = two ? h[0] : l[0];
    if (columns > LANES) hi = _mm512_add_pd(hi, sum[LANES]);
    if (nine) hi = _mm512_add_pd(hi, beyond);
    double *out = t->out + r * t->columns;
    put(t, out, divided(lo, t->row[r], t->column, t->row_inverse[r], t->column_inverse));
    if (!two) return;
    hi = divided(hi, t->row[r], t->column + LANES, t->row_inverse[r], t->column_inverse + LANES);
    put(t, out + LANES, hi);
}

// The last column of degrees 8 + 8 in two rows: its binomial is 1.
INLINE void finish_corners(const task *t, int r, __m128d x)
{
    __m128d d = _mm_loadu_pd(t->row + r), i = _mm_loadu_pd(t->row_inverse + r); // beyond the row: not stored
    __m128d q = _mm_mul_pd(x, i), rest = _mm_fnmadd_pd(q, d, x);
    q = _mm_mask3_fmadd_pd(rest, i, q, _mm_cmp_pd_mask(rest, rest, _CMP_ORD_Q));
    double *out = t->out + r * t->columns + 2 * LANES;
    _mm_storel_pd(out, q);
    if (r + 1 < t->rows) _mm_storeh_pd(out + t->columns, q);
}

// The sums of two rows of the result.
typedef struct sums {
    __m512d even[MOST], odd[MOST], even_beyond, odd_beyond;
    __m128d corners;
} sums;

// += row i of a times row k of b, and row k + 1.
INLINE void meet(sums *s, const spread *from_a, const lanes *b, int i, int k, int columns, bool nine, bool fresh)
{
    const double *a = from_a->row[i], *ninths = b->ninth + k;
    __m512d v = _mm512_load_pd(b->row[k]), w = _mm512_load_pd(b->row[k + 1]), x = v;
#pragma GCC unroll 9
    for (int j = 0; j < columns; j++) {
        x = _mm512_set1_pd(a[j]);
        s->even[j] = fresh ? _mm512_mul_pd(x, v) : _mm512_fmadd_pd(x, v, s->even[j]);
        s->odd[j] = fresh ? _mm512_mul_pd(x, w) : _mm512_fmadd_pd(x, w, s->odd[j]);
    }
    if (!nine) return;
    __m128d c = _mm_loadu_pd(ninths), last = _mm512_castpd512_pd128(x);
    s->corners = fresh ? _mm_mul_pd(last, c) : _mm_fmadd_pd(last, c, s->corners);
    x = _mm512_load_pd(a);
    __m512d n = _mm512_set1_pd(ninths[0]), m = _mm512_set1_pd(ninths[1]);
    s->even_beyond = fresh ? _mm512_mul_pd(x, n) : _mm512_fmadd_pd(x, n, s->even_beyond);
    s->odd_beyond = fresh ? _mm512_mul_pd(x, m) : _mm512_fmadd_pd(x, m, s->odd_beyond);
}

// Rows r and r + 1 of the result, r even. columns: of a.
INLINE void sweep(const task *t, int columns, bool two, bool nine)
{
    for (int r = 0; r < t->rows; r += 2) {
        int from = r < t->rows_b ? 0 : r - t->rows_b + 1, to = r + 1 < t->rows_a ? r + 1 : t->rows_a - 1;
        const pair *p = t->terms, *end = p + t->nterms;
        int i = from, k = r - from + 1; // in the lanes, where row 0 is zero
        sums s;
        meet(&s, p->a, p->b, i, k, columns, nine, true);
        for (i++, k--;; i = from, k = r - from + 1) {
#pragma GCC unroll 1
            for (; i <= to; i++, k--) meet(&s, p->a, p->b, i, k, columns, nine, false);
            if (++p == end) break;
        }
        finish(t, r, s.even, columns, two, nine, s.even_beyond);
        if (r + 1 < t->rows) finish(t, r + 1, s.odd, columns, two, nine, s.odd_beyond);
        if (nine) finish_corners(t, r, s.corners);
    }
}

// Constant numbers of columns, so that the sums live in registers.
OUTLINE void sweep_narrow(const task *t, int columns)
{
    switch (columns) {
    case 1: sweep(t, 1, false, false); break;
    case 2: sweep(t, 2, false, false); break;
    case 3: sweep(t, 3, false, false); break;
    default: sweep(t, 4, false, false); break;
    }
}

OUTLINE void sweep_wide(const task *t, int columns)
{
    switch (columns) {
    case 2: sweep(t, 2, true, false); break;
    case 3: sweep(t, 3, true, false); break;
    case 4: sweep(t, 4, true, false); break;
    case 5: sweep(t, 5, true, false); break;
    case 6: sweep(t, 6, true, false); break;
    case 7: sweep(t, 7, true, false); break;
    case 8: sweep(t, 8, true, false); break;
    default: sweep(t, 9, true, false); break;
    }
}

OUTLINE void sweep_nine(const task *t)
{
    sweep(t, 9, true, true);
}

// Fewer columns are fewer sums, but the lanes take eight, or nine with nine.
static bool swaps(int columns_a, int columns_b)
{
    int low = columns_a < columns_b ? columns_a : columns_b, high = columns_a + columns_b - low;
    return columns_b != (high > LANES && low <= LANES ? low : high);
}

// Columns of the one that is spread, and of the one in the lanes.
INLINE void run_task(task *t, int columns, int other)
{
    if (columns + other - 1 <= LANES && columns <= 4)
        sweep_narrow(t, columns);
    else if (other > LANES)
        sweep_nine(t);
    else
        sweep_wide(t, columns);
}

INLINE void task_init(task *t, const kn_small_operand *a, const kn_small_operand *b)
{
    t->rows_a = a->rows, t->rows_b = b->rows, t->rows = a->rows + b->rows - 1;
    t->columns = a->columns + b->columns - 1;
    t->row = kn_pascal(t->rows - 1), t->row_inverse = kn_pascal_inverse(t->rows - 1);
    t->column = kn_pascal(t->columns - 1), t->column_inverse = kn_pascal_inverse(t->columns - 1);
}

// ---- squares of the usual degrees, all loops unrolled ----
// rows = columns for both operands, which nothing has packed yet; b's rows stay in registers.
INLINE void square(double *out, const double *from_a, const double *from_b, int size)
{
    const int all = 2 * size - 1;
    const bool two = all > LANES;
    const double *row = kn_pascal(size - 1);
    __mmask8 used = first(size);
    __m512d column = _mm512_loadu_pd(row), b[MOST], zero = _mm512_setzero_pd();
    spread a;
    task t = {.columns = all, .out = out, .end = out + all * all};
    t.row = t.column = kn_pascal(all - 1), t.row_inverse = t.column_inverse = kn_pascal_inverse(all - 1);
#pragma GCC unroll 6
    for (int i = 0; i < size; i++) {
        __m512d w = _mm512_mul_pd(_mm512_set1_pd(row[i]), column);
        _mm512_store_pd(a.row[i], _mm512_mul_pd(w, _mm512_maskz_loadu_pd(used, from_a + i * size)));
        b[i] = _mm512_mul_pd(w, _mm512_maskz_loadu_pd(used, from_b + i * size));
    }
#pragma GCC unroll 11
    for (int r = 0; r < all; r++) {
        __m512d sum[MOST];
        int low = r < size ? 0 : r - size + 1, high = r < size ? r + 1 : size;
#pragma GCC unroll 6
        for (int i = low; i < high; i++)
#pragma GCC unroll 6
            for (int j = 0; j < size; j++) {
                __m512d x = _mm512_set1_pd(a.row[i][j]);
                sum[j] = i == low ? _mm512_mul_pd(x, b[r - i]) : _mm512_fmadd_pd(x, b[r - i], sum[j]);
            }
        finish(&t, r, sum, size, two, false, zero);
    }
}

OUTLINE void square_2(double *out, const double *a, const double *b)
{
    square(out, a, b, 2);
}
OUTLINE void square_3(double *out, const double *a, const double *b)
{
    square(out, a, b, 3);
}
OUTLINE void square_4(double *out, const double *a, const double *b)
{
    square(out, a, b, 4);
}
OUTLINE void square_5(double *out, const double *a, const double *b)
{
    square(out, a, b, 5);
}
OUTLINE void square_6(double *out, const double *a, const double *b)
{
    square(out, a, b, 6);
}

static bool is_square(const kn_small_operand *a, const kn_small_operand *b)
{
    int n = a->rows;
    return n >= 2 && n <= 6 && a->columns == n && b->rows == n && b->columns == n;
}

OUTLINE void run_square(double *out, const double *a, const double *b, int size)
{
    switch (size) {
    case 2: square_2(out, a, b); break;
    case 3: square_3(out, a, b); break;
    case 4: square_4(out, a, b); break;
    case 5: square_5(out, a, b); break;
    default: square_6(out, a, b); break;
    }
}

// Component c of an operand of dimension 1 or more; beyond all of them its weight.
INLINE const double *component(const kn_small_operand *o, int c, int dim)
{
    int n = c == dim ? o->ncomp : o->ncomp > 1 ? c : 0;
    return n == o->ncomp && o->with_one ? NULL : o->coef + n * o->rows * o->columns;
}

OUTLINE void product(double *out, const kn_small_operand *a, const kn_small_operand *b, bool rational)
{
    spread pa;
    lanes pb;
    const pair term = {&pa, &pb};
    task t;
    int dim = a->ncomp > b->ncomp ? a->ncomp : b->ncomp;
    task_init(&t, a, b);
    t.terms = &term, t.nterms = 1, t.out = out;
    bool same = is_square(a, b);
    for (int c = 0; c < dim + rational; c++, t.out = t.end) {
        const double *x = component(a, c, dim), *y = component(b, c, dim);
        t.end = t.out + t.rows * t.columns;
        if (same && x && y) {
            run_square(t.out, x, y, a->rows);
            continue;
        }
        if (c == 0 || c == dim || a->ncomp > 1) pack_spread(&pa, x, a->rows, a->columns, 1.0);
        if (c == 0 || c == dim || b->ncomp > 1) pack_lanes(&pb, y, b->rows, b->columns);
        run_task(&t, a->columns, b->columns);
    }
}

void kn_small_product(double *out, const kn_small_operand *a, const kn_small_operand *b, bool rational)
{
    if (a->ncomp == 1 && b->ncomp == 1 && !rational && is_square(a, b)) {
        run_square(out, a->coef, b->coef, a->rows);
        return;
    }
    bool swap = swaps(a->columns, b->columns);
    product(out, swap ? b : a, swap ? a : b, rational);
}

// ---- sums of products ----
enum { MOST_PAIRS = 2 * KN_MAX_COMPS }; // as in bezier/combine.h

// Negative terms have a negative first factor.
OUTLINE void run(double *out, const kn_small_operand *a, const kn_small_operand *b, const kn_term *terms, int nterms,
                 bool swap)
{
    spread pa[2 * MOST_COMPS];
    lanes pb[MOST_COMPS];
    pair pairs[MOST_PAIRS];
    task t;
    bool minus = false;
    int na = a->ncomp + a->with_one, nb = b->ncomp + b->with_one;
    for (int i = 0; i < nterms; i++) minus |= terms[i].sign < 0.0;
    for (int c = 0; c < na; c++) {
        const double *from = c < a->ncomp ? a->coef + c * a->rows * a->columns : NULL;
        pack_spread(&pa[c], from, a->rows, a->columns, 1.0);
        if (minus) pack_spread(&pa[MOST_COMPS + c], from, a->rows, a->columns, -1.0);
    }
    for (int c = 0; c < nb; c++)
        pack_lanes(&pb[c], c < b->ncomp ? b->coef + c * b->rows * b->columns : NULL, b->rows, b->columns);
    task_init(&t, a, b);
    t.terms = pairs, t.end = out;
    for (int i = 0; i < nterms;) {
        int to = terms[i].to;
        for (t.nterms = 0; i < nterms && terms[i].to == to; i++) {
            int ca = swap ? terms[i].b : terms[i].a, cb = swap ? terms[i].a : terms[i].b;
            pairs[t.nterms++] = (pair){&pa[ca + (terms[i].sign < 0.0 ? MOST_COMPS : 0)], &pb[cb]};
        }
        t.out = t.end, t.end += t.rows * t.columns;
        run_task(&t, a->columns, b->columns);
    }
}

void kn_small_run(double *out, const kn_small_operand *a, const kn_small_operand *b, const kn_term *terms, int nterms)
{
    bool swap = swaps(a->columns, b->columns);
    run(out, swap ? b : a, swap ? a : b, terms, nterms, swap);
}
#else
void kn_small_product(double *out, const kn_small_operand *a, const kn_small_operand *b, bool rational)
{
    (void)out, (void)a, (void)b, (void)rational;
}

void kn_small_run(double *out, const kn_small_operand *a, const kn_small_operand *b, const kn_term *terms, int nterms)
{
    (void)out, (void)a, (void)b, (void)terms, (void)nterms;
}
#endif
