// SPDX-License-Identifier: Apache-2.0
// The colours of heat maps: two ramps that meet in a step of lightness, so that what does not fit stands out for eyes
// of every kind. Steps along a ramp are even in Oklab.
// Source: Ottosson, A perceptual color space for image processing, 2020.
#include "cli/check.h"

#include <math.h>

typedef struct lab {
    double l, a, b;
} lab;

// sRGB: what does not fit, worst first; what fits, just so first.
static const double unfit[][3] = {{0.16, 0.02, 0.07}, {0.52, 0.05, 0.11}, {0.83, 0.20, 0.13}, {0.93, 0.45, 0.22}};
static const double fit[][3] = {{0.98, 0.92, 0.68}, {0.79, 0.88, 0.74}, {0.58, 0.79, 0.80}, {0.46, 0.65, 0.78}};
enum { STOPS = sizeof fit / sizeof *fit };

static double encoded(double x)
{
    x = fmin(fmax(x, 0.0), 1.0);
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}

static lab to_lab(const double srgb[3])
{
    double r = cli_linear_of_srgb(srgb[0]), g = cli_linear_of_srgb(srgb[1]), b = cli_linear_of_srgb(srgb[2]);
    double l = cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
    double m = cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
    double s = cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
    return (lab){0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
                 1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
                 0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s};
}

static void from_lab(lab c, double srgb[3])
{
    double l = c.l + 0.3963377774 * c.a + 0.2158037573 * c.b;
    double m = c.l - 0.1055613458 * c.a - 0.0638541728 * c.b;
    double s = c.l - 0.0894841775 * c.a - 1.2914855480 * c.b;
    l = l * l * l, m = m * m * m, s = s * s * s;
    srgb[0] = encoded(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s);
    srgb[1] = encoded(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s);
    srgb[2] = encoded(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s);
}

static double distance(lab x, lab y)
{
    return sqrt((x.l - y.l) * (x.l - y.l) + (x.a - y.a) * (x.a - y.a) + (x.b - y.b) * (x.b - y.b));
}

// The colour at a share of the ramp's length.
static void along(const double ramp[STOPS][3], double share, double srgb[3])
{
    lab stop[STOPS];
    double length = 0;
    for (int i = 0; i < STOPS; i++) {
        stop[i] = to_lab(ramp[i]);
        if (i > 0) length += distance(stop[i - 1], stop[i]);
    }
    double left = share * length;
    int i = 1;
    for (; i < STOPS - 1 && left > distance(stop[i - 1], stop[i]); i++) left -= distance(stop[i - 1], stop[i]);
    double x = fmin(left / distance(stop[i - 1], stop[i]), 1.0);
    lab a = stop[i - 1], b = stop[i];
    from_lab((lab){a.l + x * (b.l - a.l), a.a + x * (b.a - a.a), a.b + x * (b.b - a.b)}, srgb);
}

void heat_color(double t, double srgb[3])
{
    if (t < 0)
        along(unfit, fmax(1 + t, 0.0), srgb);
    else
        along(fit, fmin(t, 1.0), srgb);
}

void heat_linear_color(double t, float rgb[3])
{
    double srgb[3];
    heat_color(t, srgb);
    for (int c = 0; c < 3; c++) rgb[c] = (float)cli_linear_of_srgb(srgb[c]);
}
