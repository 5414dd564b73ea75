// SPDX-License-Identifier: Apache-2.0
// What the files of batched evaluation share.
#ifndef KERNEL_EVAL_BLOCK_H
#define KERNEL_EVAL_BLOCK_H

#include "kernel/eval.h"

enum {
    KN_EVAL_VECTOR = 4, // numbers in the vectors that components and B-splines are padded to
    KN_EVAL_BLOCK = 64, // points that go through each stage together
};

// Grows with t; 0 for NaN. Conversions stay inside int.
static inline int kn_eval_bucket(const kn_eval_axis *a, double t)
{
    double z = (t - a->lo) * a->scale, last = a->buckets - 1;
    z = z > 0.0 ? z : 0.0;
    return (int)(z < last ? z : last);
}

void kn_eval_sse2(double *out, const kn_eval_plan *plan, size_t npoints, const double *at);

#endif
