// SPDX-License-Identifier: Apache-2.0
// Batched evaluation in vectors of two doubles: the baseline.
#define LANES 2
#define TARGET
#include "kernel/eval_stages.h"

const kn_eval_kernels kn_eval_sse2 = {points, axis_basis, rows};
