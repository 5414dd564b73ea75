// SPDX-License-Identifier: Apache-2.0
// The largest coefficient vector of a piece.
#include "bezier/norm_bound.h"

#include <math.h>

// max |x[i]|; four of them at a time, each of which waits for itself alone.
static double largest_number(const double *x, size_t n)
{
    double most[4] = {0.0}, all = 0.0;
    size_t i = 0;
    for (; i + 4 <= n; i += 4)
        for (size_t k = 0; k < 4; k++) most[k] = fabs(x[i + k]) > most[k] ? fabs(x[i + k]) : most[k];
    for (; i < n; i++) all = fabs(x[i]) > all ? fabs(x[i]) : all;
    for (size_t k = 0; k < 4; k++) all = most[k] > all ? most[k] : all;
    return all;
}

double kn_largest_vector(const kn_bezier *b, int first, int count)
{
    size_t n = kn_bezier_count(b);
    const double *coef = b->coef + (size_t)first * n;
    double most = largest_number(coef, (size_t)count * n), largest[2] = {0.0};
    if (!(most > 0.0) || isinf(most) || count == 1) return most;
    int exponent; // squares of the numbers themselves may underflow
    (void)frexp(most, &exponent);
    double scale = exponent > -1000 ? ldexp(1.0, -exponent) : 0x1p1000;
    for (size_t i = 0; i < n; i++) {
        double square = 0.0;
        for (size_t c = 0; c < (size_t)count; c++) square += coef[c * n + i] * scale * (coef[c * n + i] * scale);
        largest[i % 2] = square > largest[i % 2] ? square : largest[i % 2];
    }
    return sqrt(largest[0] > largest[1] ? largest[0] : largest[1]) / scale;
}
