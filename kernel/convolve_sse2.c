// SPDX-License-Identifier: Apache-2.0
// Convolution in vectors of two doubles, not fused: the baseline of every machine.
#include "kernel/convolve_plane.h"

#include <string.h>

#define LANES 2
#define OUTLINE static
#define INLINE static inline __attribute__((always_inline))

typedef double vec __attribute__((vector_size(LANES * sizeof(double))));
typedef int tail;

INLINE vec zero(void)
{
    return (vec){0.0, 0.0};
}
INLINE vec splat(double x)
{
    return (vec){x, x};
}
INLINE vec load(const double *p)
{
    vec v;
    memcpy(&v, p, sizeof v);
    return v;
}
INLINE void store(double *p, vec v)
{
    memcpy(p, &v, sizeof v);
}
INLINE tail tail_of(int n)
{
    return n;
}
INLINE vec load_tail(const double *p, tail t)
{
    return t == LANES ? load(p) : (vec){p[0], 0.0};
}
INLINE void store_tail(double *p, tail t, vec v)
{
    p[0] = v[0];
    if (t == LANES) p[1] = v[1];
}
INLINE vec add(vec a, vec b)
{
    return a + b;
}
INLINE vec multiply(vec a, vec b)
{
    return a * b;
}
INLINE vec multiply_add(vec a, vec b, vec c)
{
    return a * b + c;
}
INLINE vec quotient(vec x, vec d, vec r)
{
    (void)r;
    return x / d;
}

#include "kernel/convolve_stages.h"

const kn_convolve_kernels kn_convolve_sse2 = {plane, pack_rows, divide_rows};
