// SPDX-License-Identifier: Apache-2.0
// Colours for other programs.
#include "io/color.h"

#include <math.h>

double kn_color_srgb(double linear)
{
    double x = fmin(fmax(linear, 0.0), 1.0);
    double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055;
    return rint(encoded * 1e4) / 1e4;
}

int kn_color_srgb_byte(double linear)
{
    return (int)rint(255.0 * kn_color_srgb(linear));
}
