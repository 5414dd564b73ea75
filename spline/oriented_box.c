// SPDX-License-Identifier: Apache-2.0
// A small oriented box around a spline.
#include "bezier/bounds.h"
#include "spline/internal.h"

kn_status kn_spline_oriented_box(kn_ctx *ctx, kn_oriented_box *out, const kn_spline *s)
{
    kn_status status = kn_spline_expect(ctx, "spline_oriented_box", s, 0);
    if (status != KN_OK) return status;
    return kn_oriented_box_of(ctx, "spline_oriented_box", out, s->coef, kn_spline_dim(s), s->rational, s->nvars,
                              s->count);
}
