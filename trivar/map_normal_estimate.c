// SPDX-License-Identifier: Apache-2.0
// The estimate of equation (4): J at w = 0 in place of its inverse transpose.
#include "kernel/context.h"

#include <knurl/shell.h>

#include <math.h>

kn_status kn_shell_map_normal_estimate(kn_ctx *ctx, double out[3], const kn_shell *shell, const double uvw[3],
                                       const double normal[3])
{
    double j[9], point[3], sum[3], big = 0.0, square = 0.0;
    if (!isfinite(uvw[2])) return kn_fail(ctx, KN_EDOMAIN, "shell: a normal at height %g", uvw[2]);
    if (!isfinite(normal[0]) || !isfinite(normal[1]) || !isfinite(normal[2]))
        return kn_fail(ctx, KN_EDOMAIN, "shell: normal (%g, %g, %g)", normal[0], normal[1], normal[2]);
    kn_status status = kn_shell_eval(ctx, point, j, shell, uvw[0], uvw[1], 0.0);
    if (status != KN_OK) return status;
    for (int c = 0; c < 3; c++) {
        sum[c] = j[3 * c] * normal[0] + j[3 * c + 1] * normal[1] + j[3 * c + 2] * normal[2];
        big = fmax(big, fabs(sum[c]));
    }
    if (!(big > 0.0) || !isfinite(big))
        return kn_fail(ctx, KN_EUNDEFINED, "shell: no estimate at (%.17g, %.17g)", uvw[0], uvw[1]);
    for (int c = 0; c < 3; c++) square += sum[c] / big * (sum[c] / big);
    for (int c = 0; c < 3; c++) out[c] = sum[c] / big / sqrt(square);
    return KN_OK;
}
