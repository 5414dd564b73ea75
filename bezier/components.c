// SPDX-License-Identifier: Apache-2.0
// Some components of a piece.
#include "bezier/shape.h"

#include <string.h>

kn_status kn_bezier_components(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int first, int count)
{
    kn_status status = kn_bezier_check_operand(ctx, "components", a);
    if (status != KN_OK) return status;
    if (first < 0 || count < 1 || first > a->ncomp - count)
        return kn_fail(ctx, KN_EDOMAIN, "components: %d from %d on, of %d", count, first, a->ncomp);
    kn_bezier c = *a;
    c.ncomp = count;
    c.rational = false;
    status = kn_bezier_alloc(ctx, &c, "components");
    if (status == KN_OK)
        memcpy(c.coef, kn_bezier_comp(a, first), (size_t)count * kn_bezier_count(a) * sizeof *c.coef);
    return kn_bezier_finish(ctx, out, &c, status);
}
