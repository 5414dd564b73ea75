// SPDX-License-Identifier: Apache-2.0
// Batched evaluation in vectors of four doubles, and the choice at run time.
#include "kernel/eval_block.h"

#include <assert.h>

#if defined(__x86_64__)
#define LANES 4
#define TARGET __attribute__((target("avx2")))
#include "kernel/eval_stages.h"

const kn_eval_kernels kn_eval_avx2 = {points, axis_basis, rows};
#endif

kn_eval_level kn_eval_best(void)
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        return KN_EVAL_AVX512;
    if (__builtin_cpu_supports("avx2")) return KN_EVAL_AVX2;
#endif
    return KN_EVAL_SSE2;
}

const kn_eval_kernels *kn_eval_of_level(kn_eval_level level)
{
    assert(level > KN_EVAL_PLAIN && level <= kn_eval_best());
#if defined(__x86_64__)
    if (level == KN_EVAL_AVX512) return &kn_eval_avx512;
    if (level == KN_EVAL_AVX2) return &kn_eval_avx2;
#endif
    (void)level;
    return &kn_eval_sse2;
}

void kn_eval_planned(double *out, const kn_eval_plan *plan, size_t npoints, const double *at, bool partials,
                     kn_eval_level level)
{
    kn_eval_of_level(level)->points(out, plan, npoints, at, partials);
}
