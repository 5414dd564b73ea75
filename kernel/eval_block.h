// SPDX-License-Identifier: Apache-2.0
// What the files of batched evaluation share.
#ifndef KERNEL_EVAL_BLOCK_H
#define KERNEL_EVAL_BLOCK_H

#include "kernel/eval.h"

enum {
    KN_EVAL_VECTOR = 4, // numbers in the vectors that components and B-splines are padded to
    KN_EVAL_BLOCK = 64, // points that go through each stage together
    KN_EVAL_FEW = 32,   // tables of fewer spans fit into registers, and are at least that long
};

// Grows with t; 0 for NaN. Conversions stay inside int.
static inline int kn_eval_bucket(const kn_eval_axis *a, double t)
{
    double z = (t - a->lo) * a->scale, last = a->buckets - 1;
    z = z > 0.0 ? z : 0.0;
    return (int)(z < last ? z : last);
}

static inline size_t kn_eval_aligned(size_t n)
{
    return (n + 7) / 8 * 8; // numbers in whole blocks of 64 bytes
}

// The numbers of memory that the tables of variable d take; lays them out in memory, which may be NULL. bezier: no
// extraction matrices. stride: of the coefficients of this variable.
size_t kn_eval_lay_axis(kn_eval_axis *a, const kn_eval_function *f, int d, bool bezier, size_t stride,
                        double *memory);
void kn_eval_fill_axis(kn_eval_axis *a, const kn_eval_function *f, int d);

// A weighted sum of rows for each parameter:
// out[i * out_row + x] = sum_k basis[i * width + k] in[first[i] * scale + k * in_row + x], x < length.
typedef struct kn_eval_rows {
    double *out;
    const double *in, *basis;
    const size_t *first;
    size_t scale, out_row, in_row, n, length;
    int degree, width;
} kn_eval_rows;

// The stages at one level.
typedef struct kn_eval_kernels {
    void (*points)(double *out, const kn_eval_plan *plan, size_t npoints, const double *at, bool partials);
    // basis[i * width + k] and first[i] for n parameters.
    void (*basis)(double *basis, size_t *first, const kn_eval_axis *axis, size_t n, const double *at);
    void (*rows)(const kn_eval_rows *r);
} kn_eval_kernels;

const kn_eval_kernels *kn_eval_of_level(kn_eval_level level);
extern const kn_eval_kernels kn_eval_sse2;
#if defined(__x86_64__)
extern const kn_eval_kernels kn_eval_avx2, kn_eval_avx512;
#endif

#endif
