// SPDX-License-Identifier: Apache-2.0
// Bounds that hold in spite of rounding.
#include "kernel/bounds.h"

#include <math.h>

#include <knurl/base.h>

#define UNIT 0x1p-53 // u

// ---- ranges ----

static void range_of_numbers(double *lo, double *hi, size_t n, const double *x)
{
    double least = x[0], most = x[0];
    bool odd = false;
    for (size_t k = 0; k < n; k++) {
        least = x[k] < least ? x[k] : least;
        most = x[k] > most ? x[k] : most;
        odd |= isnan(x[k]);
    }
    *lo = odd ? -INFINITY : least;
    *hi = odd ? INFINITY : most;
}

// The sign of q w - x, exactly, for q = fl(x / w): the rest of a division is a double unless it underflows, and fma
// rounds it once. Where it might underflow: NaN, as for numbers that are none.
static double rest(double q, double x, double w)
{
    if (x == 0.0) return 0.0;
    return fabs(x) < 0x1p-900 ? NAN : fma(q, w, -x);
}

// Division is monotone, so that only quotients at the extreme so far need a closer look.
static void range_of_quotients(double *lo, double *hi, size_t n, const double *x, const double *w)
{
    double least = INFINITY, most = -INFINITY;
    for (size_t k = 0; k < n; k++) {
        double q = x[k] / w[k];
        if (!(q > least)) { // also NaN
            double down = rest(q, x[k], w[k]) <= 0.0 ? q : nextafter(q, -INFINITY);
            least = isnan(q) ? -INFINITY : down < least ? down : least;
        }
        if (!(q < most)) {
            double up = rest(q, x[k], w[k]) >= 0.0 ? q : nextafter(q, INFINITY);
            most = isnan(q) ? INFINITY : up > most ? up : most;
        }
    }
    *lo = least, *hi = most;
}

// Two sums and a quotient: 3 roundings, relative to the quotient, hence 4 u and one step outwards cover them all.
static void range_with_errors(double *lo, double *hi, size_t n, const double *x, const double *ex, const double *w,
                              const double *ew)
{
    double least = INFINITY, most = -INFINITY;
    bool odd = false;
    for (size_t k = 0; k < n; k++) {
        double a = x[k] - ex[k], b = x[k] + ex[k];
        if (w) {
            double small = w[k] - ew[k], large = w[k] + ew[k];
            a /= a < 0.0 ? small : large;
            b /= b < 0.0 ? large : small;
        }
        least = a < least ? a : least;
        most = b > most ? b : most;
        odd |= isnan(a) || isnan(b);
    }
    *lo = odd ? -INFINITY : nextafter(least - 4.0 * UNIT * fabs(least), -INFINITY);
    *hi = odd ? INFINITY : nextafter(most + 4.0 * UNIT * fabs(most), INFINITY);
}

void kn_hull_range(double *lo, double *hi, size_t n, const double *x, const double *ex, const double *w,
                   const double *ew)
{
    if (ex)
        range_with_errors(lo, hi, n, x, ex, w, ew);
    else if (w)
        range_of_quotients(lo, hi, n, x, w);
    else
        range_of_numbers(lo, hi, n, x);
    if (isnan(*lo) || isnan(*hi)) *lo = -INFINITY, *hi = INFINITY; // infinity less infinity
}

bool kn_hull_positive(size_t n, const double *w, const double *ew)
{
    for (size_t k = 0; k < n; k++)
        if (!(w[k] - (ew ? ew[k] : 0.0) > 0.0 && w[k] < INFINITY)) return false;
    return true;
}

// ---- norms ----

// Scaled by a power of two, so that squares neither overflow nor, where it matters, underflow. A square and dim sums
// under a root are (dim + 3) / 2 roundings, and gamma(8) comes with the components.
double kn_hull_norm(size_t n, int dim, const double *x)
{
    double big = 0.0, most = 0.0;
    bool odd = false;
    for (size_t k = 0; k < n * (size_t)dim; k++) {
        double a = fabs(x[k]);
        big = a > big ? a : big;
        odd |= !(a < INFINITY);
    }
    if (odd) return INFINITY;
    if (big == 0.0) return 0.0;
    int e = ilogb(big);
    for (size_t k = 0; k < n; k++) {
        double sum = 0.0;
        for (int c = 0; c < dim; c++) {
            double a = scalbn(x[(size_t)c * n + k], -e);
            sum += a * a;
        }
        most = sum > most ? sum : most;
    }
    double norm = scalbn(sqrt(most) * (1.0 + (dim + 16) * 2.0 * UNIT), e);
    return norm + 0x1p-1070; // what underflow in the components may hide
}

// ---- magnitudes ----

static void basis_size(double *basis, int n, double t)
{
    double s = fabs(1.0 - t);
    t = fabs(t);
    basis[0] = 1.0;
    for (int k = 1; k <= n; k++) {
        basis[k] = t * basis[k - 1];
        for (int i = k - 1; i > 0; i--) basis[i] = s * basis[i] + t * basis[i - 1];
        basis[0] *= s;
    }
}

void kn_bernstein_restriction_size(double *matrix, int n, double lo, double hi)
{
    for (int i = 0; i <= n; i++) {
        double a[KN_MAX_DEGREE + 1], b[KN_MAX_DEGREE + 1], *row = matrix + i * (n + 1);
        basis_size(a, n - i, lo);
        basis_size(b, i, hi);
        for (int j = 0; j <= n; j++) row[j] = 0.0;
        for (int k = 0; k <= i; k++)
            for (int j = 0; j <= n - i; j++) row[j + k] += a[j] * b[k];
    }
}

void kn_knots_blossom_size(double *w, const double *knots, int degree, int s, const double *args)
{
    w[0] = 1.0;
    for (int m = 1; m <= degree; m++) {
        double carry = 0.0, x = args[m - 1];
        for (int k = 0; k < m; k++) {
            double lo = knots[s - m + 1 + k], hi = knots[s + 1 + k], old = w[k];
            w[k] = carry + fabs((hi - x) / (hi - lo)) * old;
            carry = fabs((x - lo) / (hi - lo)) * old;
        }
        w[m] = carry;
    }
}

double kn_row_growth(const double *matrix, int rows, int columns)
{
    double most = 0.0;
    for (int i = 0; i < rows; i++) {
        double sum = 0.0;
        for (int j = 0; j < columns; j++) sum += fabs(matrix[(size_t)i * (size_t)columns + (size_t)j]);
        most = sum > most ? sum : most;
    }
    return most;
}

// gamma(n) / (1 - gamma(n)) < (n + 1) u for n < 2^25: size[k] is below its exact value by 1 - gamma(n) at most. Two
// roundings of the product and the sum are in the rest of n + 4.
void kn_hull_errors(double *size, size_t n, double roundings, double floor)
{
    double unit = (roundings + 4.0) * UNIT;
    for (size_t k = 0; k < n; k++) size[k] = size[k] * unit + floor;
}
