// SPDX-License-Identifier: Apache-2.0
// Halving boxes until a test settles each.
#include "solve/net.h"

#include "kernel/bernstein.h"
#include "kernel/context.h"

// A halving has n exact products by 1/2 and n roundings of sums that lie within the largest coefficient.
static void halve(double *left, double *right, double *left_error, double *right_error, const kn_net *net, int var)
{
    for (int c = 0; c < net->ncomp; c++) { // right holds the whole
        double most = kn_largest(right + (size_t)c * net->count, net->count);
        right_error[c] += kn_rounding(net->degree[var]) * most + kn_underflow();
        left_error[c] = right_error[c] *= 1.0 + 0x1p-50;
    }
    size_t inner = kn_net_inner(net, var), rows = (size_t)(net->degree[var] + 1) * inner;
    kn_bernstein_split(left, right, right, (size_t)net->ncomp * net->count / rows, net->degree[var], inner, 0.5);
}

enum { SHALLOW = 4 };

// A stack of boxes that are still to do, each with the halvings it has behind it: never more than depth + 1. Once one
// is left undecided the others are looked at only shallowly: for signs that differ, which settle the question.
static kn_status run(kn_ctx *ctx, bool *settled, const kn_net *net, double *coef, double *error, int *level,
                     int depth, kn_box_test test, void *user)
{
    size_t size = (size_t)net->ncomp * net->count, m = (size_t)net->ncomp, done = 0, rhythm = 4 * kn_net_rhythm(size);
    kn_status status = KN_OK;
    kn_verdict verdict = KN_DONE;
    level[0] = 0;
    *settled = true;
    for (size_t top = 1; top > 0 && status == KN_OK; done++) {
        double *c = coef + (top - 1) * size, *e = error + (top - 1) * m;
        verdict = test(user, net, c, e);
        int var = verdict == KN_HALVE && level[top - 1] < depth ? kn_net_steepest(net, c, e) : -1;
        if (verdict == KN_STOP) break;
        if (verdict == KN_DONE) {
            top--;
        } else if (var < 0) {
            top--;
            *settled = false;
            depth = depth < SHALLOW ? depth : SHALLOW;
        } else {
            halve(c + size, c, e + m, e, net, var);
            level[top] = ++level[top - 1];
            top++;
        }
        if ((done + 1) % rhythm == 0) status = kn_progress(ctx, "dividing boxes", 0.0);
    }
    if (verdict == KN_STOP) *settled = false;
    return status;
}

kn_status kn_net_divide(kn_ctx *ctx, bool *settled, const kn_net *net, const double *coef, const double *error,
                        int depth, kn_box_test test, void *user)
{
    size_t size = (size_t)net->ncomp * net->count, m = (size_t)net->ncomp, levels = (size_t)depth + 1;
    *settled = false;
    kn_verdict first = test(user, net, coef, error); // most questions end here
    if (first == KN_DONE) *settled = true;
    if (first != KN_HALVE || depth == 0) return KN_OK;
    kn_mark mark = kn_scratch_mark(ctx);
    double *c = kn_scratch(ctx, levels * size, sizeof *c), *e = kn_scratch(ctx, levels * m, sizeof *e);
    int *level = kn_scratch(ctx, levels, sizeof *level);
    kn_status status = c && e && level ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        for (size_t i = 0; i < size; i++) c[i] = coef[i];
        for (size_t i = 0; i < m; i++) e[i] = error[i];
        status = run(ctx, settled, net, c, e, level, depth, test, user);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
