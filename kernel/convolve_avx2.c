// SPDX-License-Identifier: Apache-2.0
// Convolution in vectors of four doubles, fused.
#include "kernel/convolve_plane.h"

#if defined(__x86_64__)
#include <immintrin.h>

#define LANES 4
#define OUTLINE static __attribute__((target("avx2,fma")))
#define INLINE static inline __attribute__((always_inline, target("avx2,fma")))

typedef __m256d vec;
typedef __m256i tail;

INLINE vec zero(void)
{
    return _mm256_setzero_pd();
}
INLINE vec splat(double x)
{
    return _mm256_set1_pd(x);
}
INLINE vec load(const double *p)
{
    return _mm256_loadu_pd(p);
}
INLINE void store(double *p, vec v)
{
    _mm256_storeu_pd(p, v);
}
INLINE tail tail_of(int n)
{
    return _mm256_cmpgt_epi64(_mm256_set1_epi64x(n), _mm256_setr_epi64x(0, 1, 2, 3));
}
INLINE vec load_tail(const double *p, tail t)
{
    return _mm256_maskload_pd(p, t);
}
INLINE void store_tail(double *p, tail t, vec v)
{
    _mm256_maskstore_pd(p, t, v);
}
INLINE vec add(vec a, vec b)
{
    return _mm256_add_pd(a, b);
}
INLINE vec multiply(vec a, vec b)
{
    return _mm256_mul_pd(a, b);
}
INLINE vec multiply_add(vec a, vec b, vec c)
{
    return _mm256_fmadd_pd(a, b, c);
}

// As in kernel/convolve.c; an infinite x stays.
INLINE vec quotient(vec x, vec d, vec r)
{
    vec q = _mm256_mul_pd(x, r), rest = _mm256_fnmadd_pd(q, d, x);
    return _mm256_blendv_pd(q, _mm256_fmadd_pd(rest, r, q), _mm256_cmp_pd(rest, rest, _CMP_ORD_Q));
}

#include "kernel/convolve_stages.h"

const kn_convolve_kernels kn_convolve_avx2 = {plane, pack_rows, divide_rows};
#endif
