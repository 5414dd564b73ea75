// SPDX-License-Identifier: Apache-2.0
// Knot refinement and degree elevation with no more work than new knots ask for.
//
// Let the arguments of a coefficient's polar form f be v new knots x_1 <= .. <= x_v and p - v old ones, which are
// then neighbours t_m+1 .. t_m+p-v of the old vector. With d_i^r = f(x_1 .. x_r, t_i+1 .. t_i+p-r), d_i^0 = c_i,
//
//     d_i^r = (t_i+p-r+1 - x_r)/(t_i+p-r+1 - t_i) d_i-1^r-1 + (x_r - t_i)/(t_i+p-r+1 - t_i) d_i^r-1
//
// and d_m^v is the coefficient: v (v + 1) / 2 steps on the v + 1 coefficients c_m-v .. c_m instead of p (p + 1) / 2
// (Lyche and Morken, Making the Oslo algorithm more efficient, SINUM 23, 1986). Where the new vector holds all old
// knots, t_m <= to_j <= x_r <= t_m+p-v+1, hence both factors are >= 0. Of equal knots the old ones count as first,
// and copies of to_j itself in the window count as old as long as the old vector has more of them before the window:
// then t_m < x_r < t_m+p-v+1, all factors are > 0, and none is 0/0.
#include "kernel/knots.h"

#include <assert.h>
#include <string.h>

#include <knurl/base.h>

// The weights of c_m-v .. c_m in d_m^v; x holds the v new knots.
static void triangle(double *restrict w, const double *restrict knots, int degree, int m, const double *restrict x,
                     int v)
{
    w[0] = 1.0;
    for (int r = v; r > 0; r--) { // entry k belongs to i = m - v + r + k
        const double *lo = knots + (m - v + r), *hi = lo + (degree - r + 1);
        double carry = 0.0, at = x[r - 1];
        for (int k = 0; k <= v - r; k++) {
            double length = hi[k] - lo[k], old = w[k];
            w[k] = carry + (hi[k] - at) / length * old;
            carry = (at - lo[k]) / length * old;
        }
        w[v - r + 1] = carry;
    }
}

// The same, written out for the usual small v.
static inline void weights(double *restrict w, const double *restrict knots, int degree, int m,
                           const double *restrict x, int v)
{
    if (v == 0) {
        w[0] = 1.0;
    } else if (v == 1) {
        double lo = knots[m], hi = knots[m + degree], length = hi - lo;
        w[0] = (hi - x[0]) / length;
        w[1] = (x[0] - lo) / length;
    } else if (v == 2) {
        double lo = knots[m], hi = knots[m + degree - 1], length = hi - lo;
        double a = (hi - x[1]) / length, b = (x[1] - lo) / length;
        double lo0 = knots[m - 1], hi0 = knots[m + degree - 1], length0 = hi0 - lo0;
        double hi1 = knots[m + degree], length1 = hi1 - lo;
        w[0] = (hi0 - x[0]) / length0 * a;
        w[1] = (x[0] - lo0) / length0 * a + (hi1 - x[0]) / length1 * b;
        w[2] = (x[0] - lo) / length1 * b;
    } else {
        triangle(w, knots, degree, m, x, v);
    }
}

// Writes row j: v + 1 weights for the coefficients from m - v on, or with zeros around them from s - degree on.
static inline void put_row(kn_band *band, int j, int s, const double *knots, int degree, int m, const double *x,
                           int v)
{
    double *row = band->w + (size_t)j * (size_t)band->width;
    if (band->terms) {
        weights(row, knots, degree, m, x, v);
        band->first[j] = m - v, band->terms[j] = v + 1;
        return;
    }
    band->first[j] = s - degree;
    for (int k = 0; k <= degree; k++) row[k] = 0.0;
    weights(row + (m - v - (s - degree)), knots, degree, m, x, v);
}

// The new knots of a window that slides along `to`: those from `head` to `tail` of x.
typedef struct window {
    double x[4 * KN_MAX_DEGREE];
    int head, tail;
} window;

static inline void push(window *n, double x)
{
    if (n->tail == 4 * KN_MAX_DEGREE) {
        memmove(n->x, n->x + n->head, (size_t)(n->tail - n->head) * sizeof *n->x);
        n->tail -= n->head, n->head = 0;
    }
    n->x[n->tail++] = x;
}

void kn_band_refine(kn_band *band, const double *knots, int degree, int count, const double *to)
{
    int p = degree, rows = band->rows, last = count + p;
    assert(p <= KN_MAX_DEGREE);
    if (p == 0 || to[0] < knots[0] || to[rows + p] > knots[last]) {
        kn_band_refine_plain(band, knots, degree, count, to);
        return;
    }
    window n = {.head = 0};
    int next = 0, m = 0, s = p; // next: the first old knot that is not matched; m: the last one up to to[j]
    if (to[0] > knots[0]) {
        next = kn_knots_span(knots, p, count, to[0]) + 1;
        while (knots[next - 1] == to[0]) next--;
    }
    m = next - 1;
    band->width = p + 1;
    for (int j = 0; j < p; j++) {
        if (knots[next] == to[j])
            next++;
        else
            push(&n, to[j]);
    }
    for (int j = 0; j < rows; j++) {
        if (next <= last && knots[next] == to[j + p])
            next++;
        else
            push(&n, to[j + p]);
        if (knots[m + 1] == to[j])
            m++;
        else
            n.head++; // to[j] itself is new
        int old = m, from = n.head;
        while (from < n.tail && n.x[from] == to[j] && knots[old] == to[j]) from++, old--;
        if (!band->terms)
            while (s < count - 1 && knots[s + 1] <= to[j]) s++;
        put_row(band, j, s, knots, p, old, n.x + from, n.tail - from);
    }
}

// The first of the coefficients that make f(args), and how many of them (*terms); args holds `degree` knots >= start,
// in order, with all old knots between the first and the last of them; s is the last old knot <= start.
static int inner_blossom(double *w, int *terms, const double *knots, int degree, int s, double start,
                         const double *args)
{
    double x[KN_MAX_DEGREE + 1];
    int v = 0, copies = 0, old = 0, next = s + 1;
    while (copies < degree && args[copies] == start) copies++;
    while (old < copies && knots[s - old] == start) old++;
    for (int k = old; k < copies; k++) x[v++] = start;
    for (int k = copies; k < degree; k++) {
        if (knots[next] == args[k])
            next++;
        else
            x[v++] = args[k];
    }
    weights(w, knots, degree, s - old, x, v);
    *terms = v + 1;
    return s - old - v;
}

// Of equal knots it does not matter which one is left out: one blossom for all of them.
static void elevated_row(double *row, const double *knots, int degree, int s, const double *to)
{
    double w[KN_MAX_DEGREE + 2], args[KN_MAX_DEGREE + 1];
    const double *all = to + 1;
    int terms, base = s - degree;
    for (int k = 0; k <= degree; k++) row[k] = 0.0;
    for (int k = 0; k < degree; k++) args[k] = all[k + 1]; // without all[0]
    for (int i = 0, same = 1; i <= degree; i += same, same = 1) {
        while (i + same <= degree && all[i + same] == all[i]) same++;
        int first = inner_blossom(w, &terms, knots, degree, s, to[0], args);
        for (int k = 0; k < terms; k++) row[first - base + k] += same * w[k];
        for (int k = i; k < i + same && k < degree; k++) args[k] = all[k]; // put it back, and leave out the next
    }
}

void kn_band_elevate(kn_band *band, const double *knots, int degree, int count, const double *to)
{
    int s = degree, width = degree + 1;
    assert(degree < KN_MAX_DEGREE);
    band->width = width;
    band->divisor = degree + 1;
    for (int j = 0; j < band->rows; j++) {
        double *row = band->w + (size_t)j * (size_t)width;
        while (s < count - 1 && knots[s + 1] <= to[j]) s++;
        elevated_row(row, knots, degree, s, to + j);
        int from = 0, end = width;
        while (row[from] == 0.0) from++;
        while (row[end - 1] == 0.0) end--;
        if (end - from == 1) row[from] = 1.0; // a copy
        band->first[j] = s - degree;
        if (!band->terms) continue;
        band->first[j] += from, band->terms[j] = end - from;
        if (from > 0) memmove(row, row + from, (size_t)(end - from) * sizeof *row);
    }
}
