// SPDX-License-Identifier: Apache-2.0
// Knot vectors: spans, blossoms, basis functions.
#include "kernel/knots.h"

#include <assert.h>
#include <math.h>

#include <knurl/base.h>

const char *kn_knots_fault(const double *knots, int degree, int count)
{
    int last = count + degree;
    for (int i = 0; i <= last; i++)
        if (!isfinite(knots[i])) return "a knot is not finite";
    for (int i = 0; i < last; i++)
        if (knots[i] > knots[i + 1]) return "knots decrease";
    if (knots[degree] != knots[0] || knots[count] != knots[last]) return "knots are not clamped";
    if (knots[0] == knots[last]) return "the domain is empty";
    if (!isfinite(knots[last] - knots[0])) return "the domain's length is not finite";
    for (int i = 0; i + degree + 1 <= last; i++)
        if (knots[i] == knots[i + degree + 1]) return "a knot occurs more than degree + 1 times";
    return NULL;
}

int kn_knots_span(const double *knots, int degree, int count, double t)
{
    int lo = degree, hi = count; // knots[lo] <= t < knots[hi], but for the ends
    while (hi - lo > 1) {
        int mid = lo + (hi - lo) / 2;
        if (t >= knots[mid])
            lo = mid;
        else
            hi = mid;
    }
    return lo;
}

int kn_knots_next_span(const double *knots, int degree, int count, int s)
{
    for (s = s < degree ? degree : s + 1; s < count; s++)
        if (knots[s] < knots[s + 1]) return s;
    return count;
}

int kn_knots_spans(const double *knots, int degree, int count)
{
    int n = 0;
    for (int s = degree; s < count; s++) n += knots[s] < knots[s + 1];
    return n;
}

int kn_knots_breaks(double *breaks, int *times, const double *knots, int degree, int count)
{
    int n = 0, last = count + degree;
    for (int i = 0, run = 1; i <= last; i++, run++) {
        if (i < last && knots[i] == knots[i + 1]) continue;
        if (breaks) breaks[n] = knots[i];
        if (times) times[n] = run;
        n++, run = 0;
    }
    return n;
}

int kn_knots_by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int kn_knots_union(double *out, const double *a, int na, const double *b, int nb)
{
    int n = 0;
    for (int i = 0, j = 0; i < na || j < nb; n++) {
        double x = j >= nb || (i < na && a[i] <= b[j]) ? a[i] : b[j];
        if (i < na && a[i] == x) i++;
        if (j < nb && b[j] == x) j++;
        if (out) out[n] = x;
    }
    return n;
}

int kn_knots_repeat(double *out, const double *breaks, const int *times, int nbreaks)
{
    int n = 0;
    for (int i = 0; i < nbreaks; i++)
        for (int k = 0; k < times[i]; k++, n++)
            if (out) out[n] = breaks[i];
    return n;
}

// One factor R_m(x) of the product R_1(x_1) ... R_p(x_p) that gives the polar form: level m of Cox and de Boor.
// w has m entries before and m + 1 after; entry k belongs to B-spline s - m + k of degree m.
static void raise_level(double *w, const double *knots, int s, int m, double x)
{
    double carry = 0.0;
    for (int k = 0; k < m; k++) {
        double lo = knots[s - m + 1 + k], hi = knots[s + 1 + k], old = w[k];
        w[k] = carry + (hi - x) / (hi - lo) * old; // the quotients are exactly 0 and 1 at lo and hi
        carry = (x - lo) / (hi - lo) * old;
    }
    w[m] = carry;
}

void kn_knots_blossom(double *w, const double *knots, int degree, int s, const double *args)
{
    w[0] = 1.0;
    for (int m = 1; m <= degree; m++) raise_level(w, knots, s, m, args[m - 1]);
}

// Derivative d of the spline with coefficients c has coefficients by differences: D c at level m of degree m is
// m (c_i - c_i-1) / (t_i+m - t_i). Read as a map on weights it turns those of degree m - 1 into those of degree m.
static void raise_difference(double *w, const double *knots, int s, int m)
{
    double carry = 0.0;
    for (int k = 0; k < m; k++) {
        double part = m * w[k] / (knots[s + 1 + k] - knots[s - m + 1 + k]);
        w[k] = carry - part;
        carry = part;
    }
    w[m] = carry;
}

void kn_knots_basis(double *values, const double *knots, int degree, int s, double t, int order)
{
    double low[KN_MAX_DEGREE + 1], w[KN_MAX_DEGREE + 1];
    assert(degree <= KN_MAX_DEGREE);
    low[0] = 1.0;
    for (int m = 0; m <= degree; m++) { // low: the values of degree m, which serve derivative degree - m
        if (m > 0) raise_level(low, knots, s, m, t);
        int d = degree - m;
        if (d > order) continue;
        for (int k = 0; k <= m; k++) w[k] = low[k];
        for (int n = m + 1; n <= degree; n++) raise_difference(w, knots, s, n);
        for (int k = 0; k <= degree; k++) values[d * (degree + 1) + k] = w[k];
    }
    for (int d = degree + 1; d <= order; d++)
        for (int k = 0; k <= degree; k++) values[d * (degree + 1) + k] = 0.0;
}
