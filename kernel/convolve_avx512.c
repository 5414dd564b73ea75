// SPDX-License-Identifier: Apache-2.0
// Convolution in vectors of eight doubles, fused.
#include "kernel/convolve_plane.h"

#if defined(__x86_64__)
#include <immintrin.h>

#define LANES 8
#define OUTLINE static __attribute__((target("avx512f,avx512vl,avx512dq")))
#define INLINE static inline __attribute__((always_inline, target("avx512f,avx512vl,avx512dq")))

typedef __m512d vec;
typedef __mmask8 tail;

INLINE vec zero(void)
{
    return _mm512_setzero_pd();
}
INLINE vec splat(double x)
{
    return _mm512_set1_pd(x);
}
INLINE vec load(const double *p)
{
    return _mm512_loadu_pd(p);
}
INLINE void store(double *p, vec v)
{
    _mm512_storeu_pd(p, v);
}
INLINE tail tail_of(int n)
{
    return (tail)((1u << n) - 1u);
}
INLINE vec load_tail(const double *p, tail t)
{
    return _mm512_maskz_loadu_pd(t, p);
}
INLINE void store_tail(double *p, tail t, vec v)
{
    _mm512_mask_storeu_pd(p, t, v);
}
INLINE vec add(vec a, vec b)
{
    return _mm512_add_pd(a, b);
}
INLINE vec multiply(vec a, vec b)
{
    return _mm512_mul_pd(a, b);
}
INLINE vec multiply_add(vec a, vec b, vec c)
{
    return _mm512_fmadd_pd(a, b, c);
}

// As in kernel/convolve.c; an infinite x stays.
INLINE vec quotient(vec x, vec d, vec r)
{
    vec q = _mm512_mul_pd(x, r), rest = _mm512_fnmadd_pd(q, d, x);
    return _mm512_mask3_fmadd_pd(rest, r, q, _mm512_cmp_pd_mask(rest, rest, _CMP_ORD_Q));
}

#include "kernel/convolve_stages.h"

const kn_convolve_kernels kn_convolve_avx512 = {plane, pack_rows, divide_rows};
#endif
