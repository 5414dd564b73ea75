// SPDX-License-Identifier: Apache-2.0
// Banded maps along one axis: knot refinement, degree elevation, and the way from Bezier pieces to B-splines.
// All three are blossoms: the B-spline coefficient between knots t_j+1 .. t_j+p is the polar form of any piece in its
// support at these knots (Ramshaw, Blossoms are polar forms, CAGD 6, 1989).
#include "kernel/knots.h"

#include <assert.h>
#include <math.h>

#include <knurl/base.h>

// One row of the map over `inner` neighbours. The sums go from the first term to the last, four terms at a time.
static void apply_row(double *restrict out, const double *w, int terms, const double *restrict in, size_t inner)
{
    const double *a = in, *b = a + inner, *c = b + inner, *d = c + inner;
    if (terms == 1)
        for (size_t q = 0; q < inner; q++) out[q] = w[0] * a[q];
    else if (terms == 2)
        for (size_t q = 0; q < inner; q++) out[q] = w[0] * a[q] + w[1] * b[q];
    else if (terms == 3)
        for (size_t q = 0; q < inner; q++) out[q] = w[0] * a[q] + w[1] * b[q] + w[2] * c[q];
    else
        for (size_t q = 0; q < inner; q++) out[q] = w[0] * a[q] + w[1] * b[q] + w[2] * c[q] + w[3] * d[q];
    int k = 4;
    for (; k + 1 < terms; k += 2) {
        const double *e = in + (size_t)k * inner, *f = e + inner;
        for (size_t q = 0; q < inner; q++) out[q] = out[q] + w[k] * e[q] + w[k + 1] * f[q];
    }
    for (; k < terms; k++)
        for (size_t q = 0; q < inner; q++) out[q] += w[k] * in[(size_t)k * inner + q];
}

// Neighbours lie side by side: a row is a short dot product.
static void apply_curve(double *restrict out, const kn_band *band, const double *restrict in)
{
    const double *w = band->w;
    double divisor = band->divisor;
    for (int i = 0; i < band->rows; i++, w += band->width) {
        const double *c = in + band->first[i];
        int terms = band->terms[i];
        double sum = w[0] * c[0];
        for (int k = 1; k < terms; k++) sum += w[k] * c[k];
        out[i] = divisor != 0.0 && terms > 1 ? sum / divisor : sum;
    }
}

void kn_band_apply(double *out, const kn_band *band, const double *in, size_t outer, int n, size_t inner)
{
    if (!band->terms) {
        kn_band_apply_plain(out, band, in, outer, n, inner);
        return;
    }
    for (size_t o = 0; o < outer; o++, in += (size_t)n * inner) {
        if (inner == 1) {
            apply_curve(out, band, in);
            out += band->rows;
            continue;
        }
        for (int i = 0; i < band->rows; i++, out += inner) {
            int terms = band->terms[i];
            apply_row(out, band->w + (size_t)i * (size_t)band->width, terms, in + (size_t)band->first[i] * inner,
                      inner);
            if (band->divisor != 0.0 && terms > 1)
                for (size_t q = 0; q < inner; q++) out[q] /= band->divisor;
        }
    }
}

void kn_band_apply_plain(double *out, const kn_band *band, const double *in, size_t outer, int n, size_t inner)
{
    for (size_t o = 0; o < outer; o++, in += (size_t)n * inner)
        for (int i = 0; i < band->rows; i++, out += inner) {
            const double *w = band->w + (size_t)i * (size_t)band->width;
            const double *from = in + (size_t)band->first[i] * inner;
            int k = 0, terms = band->terms ? band->terms[i] : band->width;
            while (k < terms && w[k] == 0.0) k++;
            for (size_t q = 0; q < inner; q++) out[q] = k < terms ? w[k] * from[(size_t)k * inner + q] : 0.0;
            int used = 1;
            for (k++; k < terms; k++)
                if (w[k] != 0.0) {
                    for (size_t q = 0; q < inner; q++) out[q] += w[k] * from[(size_t)k * inner + q];
                    used++;
                }
            if (band->divisor != 0.0 && used > 1)
                for (size_t q = 0; q < inner; q++) out[q] /= band->divisor;
        }
}

static void all_terms(kn_band *band)
{
    for (int i = 0; band->terms && i < band->rows; i++) band->terms[i] = band->width;
}

// With span s of `knots` around to[j], the weights are discrete B-splines; where `to` refines `knots` the recurrence
// only adds and multiplies numbers >= 0 (Lyche and Morken; Oslo algorithm), so that there is no cancellation.
void kn_band_refine_plain(kn_band *band, const double *knots, int degree, int count, const double *to)
{
    band->width = degree + 1;
    all_terms(band);
    for (int j = 0; j < band->rows; j++) {
        int s = kn_knots_span(knots, degree, count, to[j]);
        band->first[j] = s - degree;
        kn_knots_blossom(band->w + (size_t)j * (size_t)band->width, knots, degree, s, to + j + 1);
    }
}

// F(x_1 .. x_p+1) = 1/(p+1) sum_i f(x_1 .. without x_i .. x_p+1): the polar form of the same polynomial with one
// argument more. Leaving out one knot of `to` leaves a refinement of `knots`, hence weights >= 0 as above.
void kn_band_elevate_plain(kn_band *band, const double *knots, int degree, int count, const double *to)
{
    double w[KN_MAX_DEGREE + 1], args[KN_MAX_DEGREE + 1];
    assert(degree < KN_MAX_DEGREE);
    band->width = degree + 1;
    band->divisor = degree + 1;
    all_terms(band);
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
        int used = 0, last = 0;
        for (int k = 0; k <= degree; k++)
            if (row[k] != 0.0) last = k, used++;
        if (used == 1) row[last] = 1.0; // a copy
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
