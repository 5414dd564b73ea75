// SPDX-License-Identifier: Apache-2.0
// Several splines on one grid.
#include "spline/view.h"

#include <string.h>

#include "kernel/context.h"

static kn_status check(kn_ctx *ctx, const kn_spline *list, int n)
{
    if (n < 0) return kn_fail(ctx, KN_EDOMAIN, "spline_make_compatible: %d splines", n);
    for (int i = 0; i < n; i++) {
        kn_status status = kn_spline_expect_pair(ctx, "spline_make_compatible", &list[0], &list[i]);
        if (status != KN_OK) return status;
    }
    return KN_OK;
}

// All views get the highest degree in variable var, then the union of their knots.
static kn_status unite(kn_ctx *ctx, kn_spline *views, int n, int var)
{
    int degree = 0, nall;
    for (int i = 0; i < n; i++) degree = views[i].degree[var] > degree ? views[i].degree[var] : degree;
    kn_status status = KN_OK;
    for (int i = 0; i < n && status == KN_OK; i++) status = kn_view_elevate(ctx, &views[i], var, degree);
    if (status != KN_OK) return status;
    double *all = views[0].knots[var];
    nall = views[0].count[var] + degree + 1;
    for (int i = 1; i < n; i++) {
        int have = views[i].count[var] + degree + 1, total;
        total = kn_knots_union(NULL, all, nall, views[i].knots[var], have);
        if (total == nall) continue;
        double *more = kn_scratch(ctx, (size_t)total, sizeof *more);
        if (!more) return KN_ENOMEM;
        kn_knots_union(more, all, nall, views[i].knots[var], have);
        all = more, nall = total;
    }
    for (int i = 0; i < n && status == KN_OK; i++) status = kn_view_union(ctx, &views[i], var, all, nall);
    return status;
}

// Results for all that changed, before any of the list changes: a view that did not still has its operand's arrays.
static kn_status store(kn_ctx *ctx, kn_spline *list, kn_spline *made, const kn_spline *views, int n)
{
    kn_status status = KN_OK;
    for (int i = 0; i < n && status == KN_OK; i++)
        if (views[i].coef != list[i].coef) status = kn_view_store(ctx, &made[i], &views[i]);
    for (int i = 0; i < n; i++) {
        if (status == KN_OK && made[i].nvars > 0) kn_spline_swap(&list[i], &made[i]);
        kn_spline_clear(ctx, &made[i]);
    }
    return status;
}

kn_status kn_spline_make_compatible(kn_ctx *ctx, kn_spline *list, int n)
{
    kn_status status = check(ctx, list, n);
    if (status != KN_OK || n < 2) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline *views = kn_scratch(ctx, (size_t)n, sizeof *views);
    kn_spline *made = views ? kn_scratch(ctx, (size_t)n, sizeof *made) : NULL;
    status = made ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        memcpy(views, list, (size_t)n * sizeof *views);
        memset(made, 0, (size_t)n * sizeof *made);
        for (int d = list->nvars - 1; d >= 0 && status == KN_OK; d--) status = unite(ctx, views, n, d);
        if (status == KN_OK) status = store(ctx, list, made, views, n);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
