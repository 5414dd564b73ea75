// SPDX-License-Identifier: Apache-2.0
// Values of a polynomial in Bernstein form in some operations for each coefficient: of t <= 1/2 it is
// (1-t)^n sum C(n,i) c_i r^i, r = t / (1-t) <= 1, and of others t^n sum C(n,i) c_i r^(n-i), r = (1-t) / t (Schumaker
// and Volk, Efficient evaluation of multivariate polynomials, CAGD 3, 1986).
#include "solve/curves.h"

#include "kernel/binomial.h"

void kn_bernstein_scale(double *scaled, const double *c, int degree)
{
    double row[KN_MAX_DEGREE + 1];
    kn_binomial_row(row, degree);
    for (int i = 0; i <= degree; i++) scaled[i] = row[i] * c[i];
}

double kn_bernstein_horner(const double *scaled, int degree, double t)
{
    bool low = t <= 0.5;
    double s = low ? 1.0 - t : t, r = low ? t / s : (1.0 - t) / s, power = 1.0;
    double sum = scaled[low ? degree : 0];
    for (int i = 1; i <= degree; i++) sum = sum * r + scaled[low ? degree - i : i];
    for (int n = degree; n > 0; n /= 2, s *= s)
        if (n % 2 == 1) power *= s;
    return sum * power;
}
