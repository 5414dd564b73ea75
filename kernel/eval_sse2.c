// SPDX-License-Identifier: Apache-2.0
// Batched evaluation in vectors of two doubles: the baseline.
#define LANES 2
#include "kernel/eval_stages.h"

void kn_eval_sse2(double *out, const kn_eval_plan *plan, size_t npoints, const double *at)
{
    choose(out, plan, npoints, at);
}
