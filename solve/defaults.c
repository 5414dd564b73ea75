// SPDX-License-Identifier: Apache-2.0
// Options of the search.
#include "solve/search.h"

#include "kernel/context.h"

kn_solve_options kn_solve_defaults(void)
{
    return (kn_solve_options){
        .tolerance = 0x1p-50, .residual = 1e-12, .max_depth = 200, .max_boxes = 500000, .max_undecided = 2048};
}

kn_status kn_solve_settle(kn_ctx *ctx, kn_solve_options *out, const kn_solve_options *options)
{
    kn_solve_options o = kn_solve_defaults();
    if (options) {
        if (!(options->tolerance >= 0.0 && options->tolerance <= 1.0) ||
            !(options->residual >= 0.0 && options->residual <= 1.0) || options->max_depth < 0 ||
            options->max_depth > KN_SOLVE_MAX_DEPTH)
            return kn_fail(ctx, KN_EDOMAIN, "solve: tolerance %g, residual %g, max_depth %d", options->tolerance,
                           options->residual, options->max_depth);
        if (options->tolerance > 0.0) o.tolerance = options->tolerance;
        if (options->residual > 0.0) o.residual = options->residual;
        if (options->max_depth > 0) o.max_depth = options->max_depth;
        if (options->max_boxes > 0) o.max_boxes = options->max_boxes;
        if (options->max_undecided > 0) o.max_undecided = options->max_undecided;
    }
    *out = o;
    return KN_OK;
}
