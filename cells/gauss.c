// SPDX-License-Identifier: Apache-2.0
// Gauss's quadrature rules.
#include "cells/internal.h"

#include <assert.h>
#include <math.h>

// P_m at x by the three-term recurrence, and its derivative m (x P_m - P_m-1) / (x^2 - 1).
static double legendre(double *slope, int m, double x)
{
    double p = 1.0, before = 0.0;
    for (int k = 1; k <= m; k++) {
        double next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
        before = p;
        p = next;
    }
    *slope = m * (x * p - before) / (x * x - 1.0);
    return p;
}

// Roots of P_m by Newton's method from cos(pi (i + 3/4) / (m + 1/2)), which lies next to root i and to no other.
void kn_cells_gauss(double *x, double *w, int m)
{
    const double pi = 3.14159265358979323846;
    assert(m >= 1 && m <= KN_CELLS_POINTS);
    for (int i = 0; i < m; i++) {
        double at = -cos(pi * (i + 0.75) / (m + 0.5)), slope;
        for (int k = 0; k < 8; k++) {
            double value = legendre(&slope, m, at);
            at -= value / slope;
        }
        (void)legendre(&slope, m, at);
        x[i] = 0.5 + 0.5 * at;
        w[i] = 1.0 / ((1.0 - at * at) * slope * slope);
    }
}
