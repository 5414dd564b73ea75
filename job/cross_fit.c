// SPDX-License-Identifier: Apache-2.0
// A surface of the tile over several knot boxes: one untrimmed patch.
#include "job/cross.h"

kn_status kn_cross_fit(kn_ctx *ctx, bool *crossed, kn_crossing *x)
{
    (void)ctx, (void)x;
    *crossed = false;
    return KN_OK;
}
