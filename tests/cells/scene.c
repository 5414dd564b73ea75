// SPDX-License-Identifier: Apache-2.0
#include "tests/cells/scene.h"

#include "tests/support/support.h"

void scene_hills(kn_ctx *ctx, kn_spline *out, void (*at)(double p[3], double u, double v))
{
    const double knots[] = {0, 0, 0, 0, 0.25, 0.5, 0.75, 1, 1, 1, 1};
    const double *both[2] = {knots, knots};
    double coef[3 * 49];
    for (int i = 0; i < 49; i++) {
        double p[3];
        at(p, i / 7 / 6.0, i % 7 / 6.0);
        for (int c = 0; c < 3; c++) coef[49 * c + i] = p[c];
    }
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, (const int[]){3, 3}, (const int[]){7, 7}, both, coef),
                     KN_OK);
}
