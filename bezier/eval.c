// SPDX-License-Identifier: Apache-2.0
// Evaluation at a point: the plain version, which faster ones are tested against.
#include "bezier/shape.h"
#include "kernel/bernstein.h"

#include <string.h>

// Sums along the last variable first: contiguous, and each variable leaves less to do.
void kn_bezier_eval_plain(double *work, const kn_bezier *b, const double *at)
{
    size_t outer = (size_t)b->ncomp * kn_bezier_count(b);
    const double *from = b->coef;
    for (int d = b->nvars - 1; d >= 0; d--) {
        double basis[KN_MAX_DEGREE + 1];
        kn_bernstein_basis(basis, b->degree[d], at[d]);
        outer /= (size_t)b->degree[d] + 1;
        kn_bernstein_contract(work, from, outer, b->degree[d] + 1, 1, basis);
        from = work;
    }
    if (b->nvars == 0) memcpy(work, from, outer * sizeof *work);
}

kn_status kn_bezier_eval(kn_ctx *ctx, double *out, const kn_bezier *b, const double *at)
{
    kn_status status = kn_bezier_check_operand(ctx, "eval", b);
    if (status != KN_OK) return status;
    int dim = kn_bezier_dim(b), last = b->nvars ? b->degree[b->nvars - 1] : 0;
    kn_mark mark = kn_scratch_mark(ctx);
    double *value = kn_scratch(ctx, (size_t)b->ncomp * kn_bezier_count(b) / (size_t)(last + 1), sizeof *value);
    if (!value)
        status = KN_ENOMEM;
    else {
        kn_bezier_eval_plain(value, b, at);
        double w = b->rational ? value[dim] : 1.0;
        if (w == 0.0)
            status = kn_fail(ctx, KN_EUNDEFINED, "eval: the weight is zero");
        else
            for (int c = 0; c < dim; c++) out[c] = b->rational ? value[c] / w : value[c];
    }
    kn_scratch_release(ctx, mark);
    return status;
}
