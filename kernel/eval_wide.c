// SPDX-License-Identifier: Apache-2.0
// Batched evaluation in vectors of eight doubles.
#if defined(__x86_64__)
#define LANES 8
#define TARGET __attribute__((target("avx2,avx512f,avx512dq,avx512vl")))
#include "kernel/eval_stages.h"

const kn_eval_kernels kn_eval_avx512 = {points, axis_basis, rows};
#else
typedef int kn_eval_wide_is_empty; // a file needs a declaration
#endif
