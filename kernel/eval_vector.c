// SPDX-License-Identifier: Apache-2.0
// Batched evaluation in vectors of four doubles, compiled for two kinds of machine, and the choice at run time.
#define LANES 4
#include "kernel/eval_stages.h"

#include <assert.h>

#if defined(__x86_64__)
__attribute__((target("avx2"))) static void avx2(double *out, const kn_eval_plan *plan, size_t npoints,
                                                 const double *at)
{
    choose(out, plan, npoints, at);
}

__attribute__((target("avx2,avx512f,avx512dq,avx512vl"))) static void avx512(double *out, const kn_eval_plan *plan,
                                                                             size_t npoints, const double *at)
{
    choose(out, plan, npoints, at);
}
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

void kn_eval_planned(double *out, const kn_eval_plan *plan, size_t npoints, const double *at, kn_eval_level level)
{
    assert(level > KN_EVAL_PLAIN && level <= kn_eval_best());
#if defined(__x86_64__)
    if (level == KN_EVAL_AVX512) {
        avx512(out, plan, npoints, at);
        return;
    }
    if (level == KN_EVAL_AVX2) {
        avx2(out, plan, npoints, at);
        return;
    }
#endif
    kn_eval_sse2(out, plan, npoints, at);
}
