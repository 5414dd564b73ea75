// SPDX-License-Identifier: Apache-2.0
// Knot vectors on raw arrays, and the linear maps along one axis that change them: no allocation, no status.
// A clamped knot vector of n coefficients of degree p has n + p + 1 knots; span s is the interval [t_s, t_s+1].
#ifndef KERNEL_KNOTS_H
#define KERNEL_KNOTS_H

#include <stdbool.h>
#include <stddef.h>

// NULL when the knots of a clamped vector are in order, else the rule that is broken (static storage).
const char *kn_knots_fault(const double *knots, int degree, int count);
// The span of the piece that serves t: the right-hand one at a knot, the end pieces beyond the domain and for NaN.
int kn_knots_span(const double *knots, int degree, int count, double t);
// The next non-empty span after s (-1 starts); count when there is none.
int kn_knots_next_span(const double *knots, int degree, int count, int s);
// The number of non-empty spans.
int kn_knots_spans(const double *knots, int degree, int count);
// The distinct knots, kn_knots_spans + 1 of them, and how often each occurs (either may be NULL). Returns how many.
int kn_knots_breaks(double *breaks, int *times, const double *knots, int degree, int count);
// Equal knots of two increasing lists a and b (bit for bit) become one. Returns how many; out NULL only counts.
int kn_knots_union(double *out, const double *a, int na, const double *b, int nb);
// For qsort: two doubles.
int kn_knots_by_value(const void *a, const void *b);
// Writes breaks[i] times[i] times. Returns how many knots were written; out NULL only counts.
int kn_knots_repeat(double *out, const double *breaks, const int *times, int nbreaks);

// The polar form (blossom) of the piece on span s at args[0 .. degree-1] is sum_k w[k] c[s - degree + k], with
// degree + 1 weights. With all args equal to t these are the values of the B-splines at t.
void kn_knots_blossom(double *w, const double *knots, int degree, int s, const double *args);
// values[d * (degree + 1) + k] = derivative d of B-spline s - degree + k at t, d = 0 .. order; any t, by the
// polynomials of span s.
void kn_knots_basis(double *values, const double *knots, int degree, int s, double t, int order);

// A banded map along one axis: out[i] = sum_k w[i * width + k] in[first[i] + k]. terms[i], when there is such an
// array, is how many of row i's weights count (else all width of them). divisor, when it is not 0, divides the sums
// of more than one (non-zero) term: weights that are integers over a common denominator stay exact.
typedef struct kn_band {
    int rows, width;
    int *first, *terms;
    double *w, divisor;
} kn_band;

// out (outer, rows, inner) = the map applied to in (outer, n, inner). Zero weights are skipped where there is no
// terms[]; a row with one weight 1 copies bit for bit.
void kn_band_apply(double *out, const kn_band *band, const double *in, size_t outer, int n, size_t inner);
void kn_band_apply_plain(double *out, const kn_band *band, const double *in, size_t outer, int n, size_t inner);
// The map to knots `to` (rows + degree + 1 of them, clamped) of width degree + 1. `to` is a refinement of knots, or
// of a part of them; where it reaches beyond their domain the end pieces are extended. Inside, all weights are >= 0,
// and with terms[] those that count are > 0. Where no new knot is concerned a row is one weight 1.
void kn_band_refine(kn_band *band, const double *knots, int degree, int count, const double *to);
void kn_band_refine_plain(kn_band *band, const double *knots, int degree, int count, const double *to);
// The map to degree + 1 on the same breaks, each knot once more often: `to` has rows + degree + 2 knots. All weights
// are >= 0. Width degree + 1; band->divisor becomes degree + 1.
void kn_band_elevate(kn_band *band, const double *knots, int degree, int count, const double *to);
void kn_band_elevate_plain(kn_band *band, const double *knots, int degree, int count, const double *to);
// The map from Bezier pieces (degree + 1 coefficients each, one after the other) on breaks to the B-spline
// coefficients on knots `to`, whose multiplicities allow no more than the pieces' continuity. Of the pieces that
// determine a coefficient the one with the smallest sum of |weights| is used, the lowest of equals. Width degree + 1.
void kn_band_join(kn_band *band, const double *breaks, int nbreaks, int degree, const double *to);

#endif
