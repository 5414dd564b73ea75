// SPDX-License-Identifier: Apache-2.0
// The end of a trimmed region.
#include "kernel/context.h"

#include <knurl/trim.h>

void kn_trim_clear(kn_ctx *ctx, kn_trim *trim)
{
    if (!trim) return;
    for (int i = 0; i < trim->ncurves; i++) kn_spline_clear(ctx, &trim->curves[i]);
    kn_free(ctx, trim->curves);
    kn_free(ctx, trim->loop_end);
    *trim = (kn_trim){0};
}
