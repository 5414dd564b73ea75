// SPDX-License-Identifier: Apache-2.0
// C = A B: panels of PANEL columns of B stay in the first cache while blocks of rows of A pass over them.
#include "kernel/gemm.h"

#include <stdbool.h>
#include <string.h>

#if defined(__x86_64__) && defined(__GNUC__)
#define KN_X86 1
#include <immintrin.h>
#else
#define KN_X86 0
#endif

enum {
    PANEL = 16,
    MOST_ROWS = 12,
    // Rows of C lie on pages of their own: so many at a time are few enough for the first table of pages. Not where
    // B is larger than what stays in the second cache.
    ROWS_TOGETHER = 48,
    NUMBERS_TOGETHER = 1 << 16
};

size_t kn_gemm_room(size_t k, size_t n)
{
    return (n + PANEL - 1) / PANEL * PANEL * k;
}

// Panel after panel, each k rows of PANEL numbers, zeros beyond column n.
void kn_gemm_pack_some(double *packed, const double *b, size_t k, size_t first, size_t count, size_t n, size_t row,
                       size_t column)
{
    for (size_t at = 0; at < n; at += PANEL) {
        size_t width = n - at < PANEL ? n - at : PANEL;
        double *to = packed + at * k + first * PANEL;
        for (size_t p = 0; p < count; p++, to += PANEL) {
            const double *from = b + p * row + at * column;
            for (size_t j = 0; j < width; j++) to[j] = from[j * column];
            for (size_t j = width; j < PANEL; j++) to[j] = 0.0;
        }
    }
}

void kn_gemm_pack(double *packed, const double *b, size_t k, size_t n, size_t row, size_t column)
{
    kn_gemm_pack_some(packed, b, k, 0, k, n, row, column);
}

// A block: c[i][at .. at + PANEL-1] = row i of A times a panel, i < rows <= MOST_ROWS, where A(i, p) is
// a[p * stride + i]: one pointer to the numbers of all rows, for there are not registers for a pointer to each.
typedef void (*block)(double *const *c, size_t at, const double *a, int rows, size_t stride, const double *b,
                      size_t k);

static void block_plain(double *const *c, size_t at, const double *a, int rows, size_t stride, const double *b,
                        size_t k)
{
    for (int i = 0; i < rows; i++) {
        double s[PANEL] = {0.0};
        for (size_t p = 0; p < k; p++)
            for (int j = 0; j < PANEL; j++) s[j] += a[p * stride + (size_t)i] * b[p * PANEL + (size_t)j];
        memcpy(c[i] + at, s, sizeof s);
    }
}

#if KN_X86
#define INLINE static inline __attribute__((always_inline))

// Each is inlined with a constant number of rows, so that the sums live in registers.
INLINE void rows_sse2(double *const *c, size_t at, const double *a, int rows, size_t stride, const double *b,
                      size_t k)
{
    for (int half = 0; half < PANEL; half += 8) {
        __m128d s[3][4];
        for (int i = 0; i < rows; i++)
            for (int j = 0; j < 4; j++) s[i][j] = _mm_setzero_pd();
        for (size_t p = 0; p < k; p++)
            for (int j = 0; j < 4; j++) {
                __m128d bj = _mm_loadu_pd(b + p * PANEL + half + 2 * j);
                for (int i = 0; i < rows; i++)
                    s[i][j] = _mm_add_pd(s[i][j], _mm_mul_pd(_mm_set1_pd(a[p * stride + (size_t)i]), bj));
            }
        for (int i = 0; i < rows; i++)
            for (int j = 0; j < 4; j++) _mm_storeu_pd(c[i] + at + half + 2 * j, s[i][j]);
    }
}

static void block_sse2(double *const *c, size_t at, const double *a, int rows, size_t stride, const double *b,
                       size_t k)
{
    int i = 0;
    for (; i + 3 <= rows; i += 3) rows_sse2(c + i, at, a + i, 3, stride, b, k);
    for (; i < rows; i++) rows_sse2(c + i, at, a + i, 1, stride, b, k);
}

__attribute__((target("avx2,fma"))) INLINE void rows_avx2(double *const *c, size_t at, const double *a, int rows,
                                                          size_t stride, const double *b, size_t k)
{
    for (int half = 0; half < PANEL; half += 8) {
        __m256d s[6][2];
        for (int i = 0; i < rows; i++)
            for (int j = 0; j < 2; j++) s[i][j] = _mm256_setzero_pd();
        for (size_t p = 0; p < k; p++) {
            __m256d b0 = _mm256_loadu_pd(b + p * PANEL + half), b1 = _mm256_loadu_pd(b + p * PANEL + half + 4);
            for (int i = 0; i < rows; i++) {
                __m256d ai = _mm256_broadcast_sd(a + p * stride + i);
                s[i][0] = _mm256_fmadd_pd(ai, b0, s[i][0]);
                s[i][1] = _mm256_fmadd_pd(ai, b1, s[i][1]);
            }
        }
        for (int i = 0; i < rows; i++)
            for (int j = 0; j < 2; j++) _mm256_storeu_pd(c[i] + at + half + 4 * j, s[i][j]);
    }
}

__attribute__((target("avx2,fma"))) static void block_avx2(double *const *c, size_t at, const double *a, int rows,
                                                           size_t stride, const double *b, size_t k)
{
    int i = 0;
    for (; i + 6 <= rows; i += 6) rows_avx2(c + i, at, a + i, 6, stride, b, k);
    for (; i + 3 <= rows; i += 3) rows_avx2(c + i, at, a + i, 3, stride, b, k);
    for (; i < rows; i++) rows_avx2(c + i, at, a + i, 1, stride, b, k);
}

__attribute__((target("avx512f"))) INLINE void rows_avx512(double *const *c, size_t at, const double *a, int rows,
                                                           size_t stride, const double *b, size_t k)
{
    __m512d s[MOST_ROWS][2];
    for (int i = 0; i < rows; i++) {
        __builtin_prefetch(c[i] + at, 1); // there when the sums are
        __builtin_prefetch(c[i] + at + PANEL - 1, 1);
        for (int j = 0; j < 2; j++) s[i][j] = _mm512_setzero_pd();
    }
    for (size_t p = 0; p < k; p++, a += stride, b += PANEL) {
        __m512d b0 = _mm512_loadu_pd(b), b1 = _mm512_loadu_pd(b + 8);
        for (int i = 0; i < rows; i++) {
            __m512d ai = _mm512_set1_pd(a[i]);
            s[i][0] = _mm512_fmadd_pd(ai, b0, s[i][0]);
            s[i][1] = _mm512_fmadd_pd(ai, b1, s[i][1]);
        }
    }
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < 2; j++) _mm512_storeu_pd(c[i] + at + 8 * j, s[i][j]);
}

__attribute__((target("avx512f"))) static void block_avx512(double *const *c, size_t at, const double *a, int rows,
                                                            size_t stride, const double *b, size_t k)
{
    int i = 0;
    for (; i + 12 <= rows; i += 12) rows_avx512(c + i, at, a + i, 12, stride, b, k);
    for (; i + 6 <= rows; i += 6) rows_avx512(c + i, at, a + i, 6, stride, b, k);
    for (; i + 3 <= rows; i += 3) rows_avx512(c + i, at, a + i, 3, stride, b, k);
    for (; i < rows; i++) rows_avx512(c + i, at, a + i, 1, stride, b, k);
}
#endif

kn_gemm_kind kn_gemm_best(void)
{
#if KN_X86
    if (__builtin_cpu_supports("avx512f")) return KN_GEMM_AVX512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return KN_GEMM_AVX2;
    return KN_GEMM_SSE2;
#else
    return KN_GEMM_PLAIN;
#endif
}

static block block_of(kn_gemm_kind kind)
{
#if KN_X86
    if (kind == KN_GEMM_AVX512) return block_avx512;
    if (kind == KN_GEMM_AVX2) return block_avx2;
    if (kind == KN_GEMM_SSE2) return block_sse2;
#endif
    (void)kind;
    return block_plain;
}

// The last panel may reach beyond column n: its block works on rows of its own.
static void last_panel(block run, double *const *c, size_t at, size_t columns, const double *a, int rows,
                       const double *b, size_t k)
{
    double copy[MOST_ROWS][PANEL], *row[MOST_ROWS];
    for (int i = 0; i < MOST_ROWS; i++) row[i] = copy[i];
    run(row, 0, a, rows, (size_t)rows, b, k);
    for (int i = 0; i < rows; i++) memcpy(c[i] + at, copy[i], columns * sizeof(double));
}

static inline void gather_block(double *restrict to, const double *const *a, size_t rows, size_t k)
{
    for (size_t p = 0; p < k; p++)
        for (size_t i = 0; i < rows; i++) to[p * rows + i] = a[i][p];
}

// Blocks of MOST_ROWS rows, or what is left, one after the other: k times a number of each.
static void gather_rows(double *to, const double *const *a, size_t rows, size_t k)
{
    size_t i = 0;
    for (; i + MOST_ROWS <= rows; i += MOST_ROWS, to += MOST_ROWS * k) gather_block(to, a + i, MOST_ROWS, k);
    gather_block(to, a + i, rows - i, k);
}

// Asks for part `index` of `count` of a panel.
static void fetch(const double *panel, size_t k, size_t index, size_t count)
{
    for (size_t at = index * 2 * k / count; at < (index + 1) * 2 * k / count; at++)
        __builtin_prefetch(panel + at * (PANEL / 2), 0, 2);
}

void kn_gemm_as(kn_gemm_kind kind, double *const *c, const double *const *a, size_t rows, const double *packed,
                size_t k, size_t n, double *work)
{
    block run = block_of(kind);
    bool large = k * n > NUMBERS_TOGETHER;
    size_t together = large ? rows : ROWS_TOGETHER;
    gather_rows(work, a, rows, k);
    for (size_t first = 0; first < rows; first += together) {
        size_t end = rows - first < together ? rows : first + together;
        const double *panel = packed;
        for (size_t at = 0; at < n; at += PANEL, panel += PANEL * k)
            for (size_t i = first; i < end; i += MOST_ROWS) {
                int m = end - i < MOST_ROWS ? (int)(end - i) : MOST_ROWS;
                if (large && at + PANEL < n)
                    fetch(panel + PANEL * k, k, (i - first) / MOST_ROWS, (end - first + MOST_ROWS - 1) / MOST_ROWS);
                if (at + PANEL <= n)
                    run(c + i, at, work + i * k, m, (size_t)m, panel, k);
                else
                    last_panel(run, c + i, at, n - at, work + i * k, m, panel, k);
            }
    }
}

void kn_gemm(double *const *c, const double *const *a, size_t rows, const double *packed, size_t k, size_t n,
             double *work)
{
    kn_gemm_as(kn_gemm_best(), c, a, rows, packed, k, n, work);
}
