// SPDX-License-Identifier: Apache-2.0
// All partial derivatives at a point.
#include "bezier/shape.h"
#include "kernel/bernstein.h"
#include "kernel/multi_index.h"

#include <limits.h>
#include <string.h>

int kn_derivative_count(int nvars, int order)
{
    if (nvars < 0 || order < 0) return 0;
    int64_t count = 1; // C(order + i, i), each division exact
    int less = nvars < order ? nvars : order, more = nvars < order ? order : nvars;
    for (int i = 1; i <= less; i++) {
        count = count * ((int64_t)more + i) / i;
        if (count > INT_MAX) return 0;
    }
    return (int)count;
}

int kn_derivative_index(int nvars, const int *a)
{
    return kn_multi_index_place(nvars, a);
}

// ---- homogeneous derivatives: differences first, so that a large constant part cancels exactly, then values ----
typedef struct table {
    const kn_bezier *piece;
    const double *at;
    double *out; // ncomp numbers for each multi-index
    int index[KN_MAX_VARS];
} table;

// values (ncomp, prod over variables < nvars) are already differentiated and evaluated in the variables from nvars
// on. Spends `left` on the last variable that remains, then goes on to the one before. work: as large as values,
// twice, for each variable.
static void derive(table *t, const double *values, double *work, int nvars, int left)
{
    size_t ncomp = (size_t)t->piece->ncomp;
    if (nvars == 0) {
        int place = kn_derivative_index(t->piece->nvars, t->index);
        memcpy(t->out + (size_t)place * ncomp, values, ncomp * sizeof *values);
        return;
    }
    int var = nvars - 1, n = t->piece->degree[var];
    size_t outer = ncomp * kn_bernstein_count(var, t->piece->degree);
    double *diff = work, *value = work + outer * (size_t)(n + 1);
    memcpy(diff, values, outer * (size_t)(n + 1) * sizeof *diff);
    for (int k = 0; k <= left && k <= n; k++) { // beyond the degree derivatives are zero, as out already is
        double basis[KN_MAX_DEGREE + 1];
        kn_bernstein_basis(basis, n - k, t->at[var]);
        kn_bernstein_contract(value, diff, outer, n - k + 1, 1, basis);
        t->index[var] = k;
        derive(t, value, value + outer, var, left - k);
        if (k < n) kn_bernstein_differentiate(diff, diff, outer, n - k, 1);
    }
    t->index[var] = 0;
}

static size_t work_size(const kn_bezier *b)
{
    size_t size = 0;
    for (int d = b->nvars; d > 0; d--)
        size += (size_t)b->ncomp * (kn_bernstein_count(d, b->degree) + kn_bernstein_count(d - 1, b->degree));
    return size;
}

static kn_status fill(kn_ctx *ctx, double *out, const kn_bezier *b, const double *at, int order, int count)
{
    int dim = kn_bezier_dim(b);
    size_t size = work_size(b), n = (size_t)count * (size_t)b->ncomp;
    double *work = kn_scratch(ctx, size, sizeof *work), *h = out;
    if (b->rational) h = kn_scratch(ctx, n, sizeof *h);
    if (!work || !h) return KN_ENOMEM;
    table t = {.piece = b, .at = at, .out = h};
    memset(h, 0, n * sizeof *h);
    derive(&t, b->coef, work, b->nvars, order);
    if (!b->rational) return KN_OK;
    if (h[dim] == 0.0) return kn_fail(ctx, KN_EUNDEFINED, "derivatives: the weight is zero");
    kn_quotient_derivatives(out, h, b->nvars, dim, order);
    return KN_OK;
}

kn_status kn_bezier_derivatives(kn_ctx *ctx, double *out, const kn_bezier *b, const double *at, int order)
{
    kn_status status = kn_bezier_check_operand(ctx, "derivatives", b);
    if (status == KN_OK && order < 0) status = kn_fail(ctx, KN_EDOMAIN, "derivatives: order %d", order);
    if (status != KN_OK) return status;
    int count = kn_derivative_count(b->nvars, order);
    if (count == 0 || order > KN_MAX_DEGREE)
        return kn_fail(ctx, KN_ELIMIT, "derivatives: order %d in %d variables", order, b->nvars);
    if (b->nvars == 0) return kn_bezier_eval(ctx, out, b, at); // a constant: one value, whatever the order
    kn_mark mark = kn_scratch_mark(ctx);
    status = fill(ctx, out, b, at, order, count);
    kn_scratch_release(ctx, mark);
    return status;
}
