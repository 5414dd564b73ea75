// SPDX-License-Identifier: Apache-2.0
// The end of a spline.
#include <knurl/spline.h>

void kn_spline_clear(kn_ctx *ctx, kn_spline *s)
{
    for (int d = 0; d < s->nvars; d++) kn_free(ctx, s->knots[d]);
    kn_free(ctx, s->coef);
    *s = (kn_spline){0};
}
