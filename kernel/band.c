// SPDX-License-Identifier: Apache-2.0
// Banded maps along one axis: knot refinement, degree elevation, and the way from Bezier pieces to B-splines.
// All three are blossoms: the B-spline coefficient between knots t_j+1 .. t_j+p is the polar form of any piece in its
// support at these knots (Ramshaw, Blossoms are polar forms, CAGD 6, 1989).
#include "kernel/knots.h"

#include <assert.h>
#include <math.h>

#include <knurl/base.h>

void kn_band_apply(double *out, const kn_band *band, const double *in, size_t outer, int n, size_t inner)
{
    for (size_t o = 0; o < outer; o++, in += (size_t)n * inner)
        for (int i = 0; i < band->rows; i++, out += inner) {
            const double *w = band->w + (size_t)i * (size_t)band->width;
            const double *from = in + (size_t)band->first[i] * inner;
            int k = 0;
            while (k < band->width && w[k] == 0.0) k++;
            for (size_t q = 0; q < inner; q++) out[q] = k < band->width ? w[k] * from[(size_t)k * inner + q] : 0.0;
            for (k++; k < band->width; k++)
                if (w[k] != 0.0)
                    for (size_t q = 0; q < inner; q++) out[q] += w[k] * from[(size_t)k * inner + q];
        }
}

// With span s of `knots` around to[j], the weights are discrete B-splines; where `to` refines `knots` the recurrence
// only adds and multiplies numbers >= 0 (Lyche and Morken; Oslo algorithm), so that there is no cancellation.
void kn_band_refine(kn_band *band, const double *knots, int degree, int count, const double *to)
{
    band->width = degree + 1;
    for (int j = 0; j < band->rows; j++) {
        int s = kn_knots_span(knots, degree, count, to[j]);
        band->first[j] = s - degree;
        kn_knots_blossom(band->w + (size_t)j * (size_t)band->width, knots, degree, s, to + j + 1);
    }
}

// F(x_1 .. x_p+1) = 1/(p+1) sum_i f(x_1 .. without x_i .. x_p+1): the polar form of the same polynomial with one
// argument more. Leaving out one knot of `to` leaves a refinement of `knots`, hence weights >= 0 as above.
void kn_band_elevate(kn_band *band, const double *knots, int degree, int count, const double *to)
{
    double w[KN_MAX_DEGREE + 1], args[KN_MAX_DEGREE + 1];
    assert(degree < KN_MAX_DEGREE);
    band->width = degree + 1;
    for (int j = 0; j < band->rows; j++) {
        double *row = band->w + (size_t)j * (size_t)band->width;
        int s = kn_knots_span(knots, degree, count, to[j]);
        band->first[j] = s - degree;
        for (int k = 0; k <= degree; k++) row[k] = 0.0;
        for (int i = 0; i <= degree; i++) {
            for (int k = 0; k < degree; k++) args[k] = to[j + 1 + k + (k >= i)];
            kn_knots_blossom(w, knots, degree, s, args);
            for (int k = 0; k <= degree; k++) row[k] += w[k];
        }
        for (int k = 0; k <= degree; k++) row[k] /= degree + 1;
    }
}

// The polar form of a Bezier piece over [lo,hi] at args; the result is the sum of |w|.
static double bezier_blossom(double *w, int degree, double lo, double hi, const double *args)
{
    w[0] = 1.0;
    for (int m = 1; m <= degree; m++) {
        double x = args[m - 1], up = (x - lo) / (hi - lo), down = (hi - x) / (hi - lo), carry = 0.0;
        for (int k = 0; k < m; k++) {
            double old = w[k];
            w[k] = carry + down * old;
            carry = up * old;
        }
        w[m] = carry;
    }
    double sum = 0.0;
    for (int k = 0; k <= degree; k++) sum += fabs(w[k]);
    return sum;
}

void kn_band_join(kn_band *band, const double *breaks, int nbreaks, int degree, const double *to)
{
    double w[KN_MAX_DEGREE + 1];
    assert(degree <= KN_MAX_DEGREE);
    band->width = degree + 1;
    for (int j = 0, lowest = 0; j < band->rows; j++) {
        double *row = band->w + (size_t)j * (size_t)band->width, best = INFINITY;
        while (lowest < nbreaks - 2 && breaks[lowest + 1] <= to[j]) lowest++;
        for (int piece = lowest; piece < nbreaks - 1 && breaks[piece] < to[j + degree + 1]; piece++) {
            double sum = bezier_blossom(w, degree, breaks[piece], breaks[piece + 1], to + j + 1);
            if (!(piece == lowest || sum < best * (1.0 - 1e-9))) continue; // ties by rounding stay with the lower one
            best = sum;
            band->first[j] = piece * (degree + 1);
            for (int k = 0; k <= degree; k++) row[k] = w[k];
        }
    }
}
