// SPDX-License-Identifier: Apache-2.0
// Banded systems of B-spline fitting along one axis.
#include "kernel/banded.h"

#include <math.h>
#include <string.h>

#include "kernel/knots.h"

#include <knurl/base.h>

// ---- collocation ----

size_t kn_collocation_room(int count, int degree)
{
    return (size_t)count * (size_t)(2 * degree + 1);
}

// Row i, column j lies at i * (2 degree + 1) + degree + j - i.
void kn_collocation_factor(kn_collocation *c, const double *knots, const double *site, const int *site_span)
{
    int p = c->degree;
    size_t width = 2 * (size_t)p + 1;
    double values[KN_MAX_DEGREE + 1];
    memset(c->band, 0, kn_collocation_room(c->count, p) * sizeof *c->band);
    for (int i = 0; i < c->count; i++) {
        kn_knots_basis(values, knots, p, site_span[i], site[i], 0);
        for (int k = 0; k <= p; k++) {
            int off = site_span[i] - p + k - i; // beyond the band the B-splines vanish at the site
            if (off >= -p && off <= p) c->band[(size_t)i * width + (size_t)(p + off)] = values[k];
        }
    }
    for (int k = 0; k < c->count; k++) {
        const double *pivot = c->band + (size_t)k * width + p; // of columns k, k + 1, ..
        for (int i = k + 1; i <= k + p && i < c->count; i++) {
            double *row = c->band + (size_t)i * width + p - (i - k), factor = row[0] /= pivot[0];
            for (int j = 1; j <= p && k + j < c->count; j++) row[j] -= factor * pivot[j];
        }
    }
}

void kn_collocation_solve(const kn_collocation *c, double *data, size_t outer, size_t inner)
{
    int p = c->degree, n = c->count;
    size_t width = 2 * (size_t)p + 1;
    for (size_t o = 0; o < outer; o++) {
        double *x = data + o * (size_t)n * inner;
        for (int i = 0; i < n; i++)
            for (int k = i > p ? i - p : 0; k < i; k++) {
                double factor = c->band[(size_t)i * width + (size_t)(p + k - i)];
                const double *from = x + (size_t)k * inner;
                double *to = x + (size_t)i * inner;
                for (size_t j = 0; j < inner && factor != 0.0; j++) to[j] -= factor * from[j];
            }
        for (int i = n - 1; i >= 0; i--) {
            const double *row = c->band + (size_t)i * width + p;
            double *to = x + (size_t)i * inner, pivot = row[0];
            for (int k = i + 1; k <= i + p && k < n; k++) {
                double factor = row[k - i];
                const double *from = x + (size_t)k * inner;
                for (size_t j = 0; j < inner && factor != 0.0; j++) to[j] -= factor * from[j];
            }
            for (size_t j = 0; j < inner; j++) to[j] /= pivot;
        }
    }
}

bool kn_collocation_regular(const kn_collocation *c)
{
    for (int i = 0; i < c->count; i++) {
        double pivot = c->band[(size_t)i * (size_t)(2 * c->degree + 1) + (size_t)c->degree];
        if (!(pivot > 0.0 && isfinite(pivot))) return false;
    }
    return true;
}

// (L U)^T = U^T L^T: the lower factor first, with U's pivots, then L's unit diagonal.
void kn_collocation_solve_transposed(const kn_collocation *c, double *b)
{
    int p = c->degree, n = c->count;
    size_t width = 2 * (size_t)p + 1;
    const double *diagonal = c->band + p;
    for (int i = 0; i < n; i++) {
        for (int k = i > p ? i - p : 0; k < i; k++) b[i] -= diagonal[(size_t)k * width + (size_t)(i - k)] * b[k];
        b[i] /= diagonal[(size_t)i * width];
    }
    for (int i = n - 1; i >= 0; i--)
        for (int k = i + 1; k <= i + p && k < n; k++) {
            const double *row = diagonal + (size_t)k * width; // L holds column i at i - k < 0
            b[i] -= row[i - k] * b[k];
        }
}

// ---- least squares ----

void kn_banded_turn_row(double *r, int columns, int width, double *row, int first, double *turn)
{
    for (int k = 0; k < width; k++, turn += 2) {
        turn[0] = 1.0, turn[1] = 0.0;
        if (first + k >= columns || row[k] == 0.0) continue;
        double *to = r + (size_t)(first + k) * (size_t)width, a = fabs(to[0]), b = fabs(row[k]);
        double large = a > b ? a : b, small = a > b ? b : a, ratio = small / large;
        double length = large * sqrt(1.0 + ratio * ratio), c = to[0] / length, s = row[k] / length;
        turn[0] = c, turn[1] = s;
        to[0] = length, row[k] = 0.0;
        for (int j = 1; k + j < width; j++) { // row j of r reaches further only where rows before this one did not
            double old = to[j];
            to[j] = c * old + s * row[k + j];
            row[k + j] = c * row[k + j] - s * old;
        }
    }
}

void kn_banded_turn_data(double *x, int columns, int width, double *y, int first, const double *turn, size_t inner)
{
    for (int k = 0; k < width && first + k < columns; k++) {
        double c = turn[2 * k], s = turn[2 * k + 1], *to = x + (size_t)(first + k) * inner;
        if (s == 0.0) continue;
        for (size_t j = 0; j < inner; j++) {
            double old = to[j];
            to[j] = c * old + s * y[j];
            y[j] = c * y[j] - s * old;
        }
    }
}

void kn_banded_back(const double *r, int columns, int width, double *x, size_t inner)
{
    for (int i = columns - 1; i >= 0; i--) {
        const double *row = r + (size_t)i * (size_t)width;
        double *to = x + (size_t)i * inner;
        for (int k = 1; k < width && i + k < columns; k++)
            for (size_t j = 0; j < inner && row[k] != 0.0; j++) to[j] -= row[k] * x[(size_t)(i + k) * inner + j];
        for (size_t j = 0; j < inner; j++) to[j] /= row[0];
    }
}
