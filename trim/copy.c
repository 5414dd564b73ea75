// SPDX-License-Identifier: Apache-2.0
// kn_trim_copy.
#include "kernel/context.h"

#include <knurl/trim.h>
#include <string.h>

kn_status kn_trim_copy(kn_ctx *ctx, kn_trim *out, const kn_trim *a)
{
    kn_trim copy = {0};
    kn_status status = KN_OK;
    if (a->nloops > 0) {
        copy.curves = kn_alloc_zero(ctx, (size_t)a->ncurves, sizeof *copy.curves);
        copy.loop_end = kn_alloc(ctx, (size_t)a->nloops, sizeof *copy.loop_end);
        if (!copy.curves || !copy.loop_end) status = KN_ENOMEM;
        if (status == KN_OK) {
            memcpy(copy.loop_end, a->loop_end, (size_t)a->nloops * sizeof *copy.loop_end);
            copy.nloops = a->nloops, copy.ncurves = a->ncurves;
        }
        for (int i = 0; status == KN_OK && i < a->ncurves; i++)
            status = kn_spline_copy(ctx, &copy.curves[i], &a->curves[i]);
    }
    if (status == KN_OK) {
        kn_trim old = *out;
        *out = copy;
        copy = old;
    }
    kn_trim_clear(ctx, &copy);
    return status;
}
