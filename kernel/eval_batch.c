// SPDX-License-Identifier: Apache-2.0
// Batched evaluation with scratch from a context.
#include "kernel/context.h"
#include "kernel/eval.h"

kn_status kn_eval_batch(kn_ctx *ctx, double *out, const kn_eval_function *f, size_t npoints, const double *at,
                        bool partials)
{
    if (!kn_eval_wants_plan(f, npoints)) {
        kn_eval_plain(out, f, npoints, at, partials);
        return KN_OK;
    }
    kn_mark mark = kn_scratch_mark(ctx);
    double *memory = kn_scratch(ctx, kn_eval_room(f), sizeof *memory);
    if (memory) {
        kn_eval_plan plan;
        kn_eval_prepare(&plan, f, memory);
        kn_eval_planned(out, &plan, npoints, at, partials, kn_eval_best());
    }
    kn_scratch_release(ctx, mark);
    return memory ? KN_OK : KN_ENOMEM;
}
