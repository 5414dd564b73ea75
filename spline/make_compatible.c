// SPDX-License-Identifier: Apache-2.0
// Several splines on one grid.
#include "spline/in_scratch.h"

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

// Those that changed; the others still have their operand's arrays.
static kn_status store_changed(kn_ctx *ctx, kn_spline *list, kn_spline *s, kn_spline **outs, int n)
{
    int changed = 0;
    for (int i = 0; i < n; i++)
        if (s[i].coef != list[i].coef) outs[changed] = &list[i], s[changed++] = s[i];
    return changed > 0 ? kn_spline_store_all(ctx, outs, s, changed) : KN_OK;
}

kn_status kn_spline_make_compatible(kn_ctx *ctx, kn_spline *list, int n)
{
    kn_status status = check(ctx, list, n);
    if (status != KN_OK || n < 2) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_spline *s = kn_scratch(ctx, (size_t)n, sizeof *s);
    kn_spline **outs = s ? kn_scratch(ctx, (size_t)n, sizeof(void *)) : NULL;
    int *var = outs ? kn_scratch(ctx, (size_t)n, sizeof *var) : NULL;
    status = var ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        memcpy(s, list, (size_t)n * sizeof *s);
        for (int d = list->nvars - 1; d >= 0 && status == KN_OK; d--) {
            for (int i = 0; i < n; i++) var[i] = d;
            status = kn_spline_unite_all_in_scratch(ctx, s, var, n, 0);
        }
        if (status == KN_OK) status = store_changed(ctx, list, s, outs, n);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
