// SPDX-License-Identifier: Apache-2.0
#include "tile/blend.h"

#include <math.h>

double kn_tile_blend(const kn_tile_parameter *p, double x)
{
    if (p->lo < p->hi) x = fmin(fmax(x, p->lo), p->hi);
    return (x - p->value) / (p->target - p->value);
}
