// SPDX-License-Identifier: Apache-2.0
// B-spline interpolation along one axis. The collocation matrix is totally positive, so elimination without pivoting
// is stable (de Boor & Pinkus, Numer. Math. 27, 1977), and it stays inside the band.
#include "kernel/knots.h"
#include "trivar/internal.h"

#include <string.h>

size_t kn_collocation_room(int count, int degree)
{
    return (size_t)count * (size_t)(2 * degree + 1);
}

// Row i, column j lies at i * (2 degree + 1) + degree + j - i.
void kn_collocation_factor(kn_collocation *c, const double *knots, const double *site, const int *site_span)
{
    int p = c->degree, width = 2 * p + 1;
    double values[KN_MAX_DEGREE + 1];
    memset(c->band, 0, kn_collocation_room(c->count, p) * sizeof *c->band);
    for (int i = 0; i < c->count; i++) {
        kn_knots_basis(values, knots, p, site_span[i], site[i], 0);
        for (int k = 0; k <= p; k++) {
            int off = site_span[i] - p + k - i; // beyond the band the B-splines vanish at the site
            if (off >= -p && off <= p) c->band[i * width + p + off] = values[k];
        }
    }
    for (int k = 0; k < c->count; k++)
        for (int i = k + 1; i <= k + p && i < c->count; i++) {
            double *row = c->band + i * width + p - i, factor = row[k] /= c->band[k * width + p];
            for (int j = k + 1; j <= k + p && j < c->count; j++) row[j] -= factor * c->band[k * width + p + j - k];
        }
}

void kn_collocation_solve(const kn_collocation *c, double *data, size_t outer, size_t inner)
{
    int p = c->degree, width = 2 * p + 1, n = c->count;
    for (size_t o = 0; o < outer; o++) {
        double *x = data + o * (size_t)n * inner;
        for (int i = 0; i < n; i++)
            for (int k = i > p ? i - p : 0; k < i; k++) {
                double factor = c->band[i * width + p + k - i];
                const double *from = x + (size_t)k * inner;
                double *to = x + (size_t)i * inner;
                for (size_t j = 0; j < inner && factor != 0.0; j++) to[j] -= factor * from[j];
            }
        for (int i = n - 1; i >= 0; i--) {
            double *to = x + (size_t)i * inner, pivot = c->band[i * width + p];
            for (int k = i + 1; k <= i + p && k < n; k++) {
                double factor = c->band[i * width + p + k - i];
                const double *from = x + (size_t)k * inner;
                for (size_t j = 0; j < inner && factor != 0.0; j++) to[j] -= factor * from[j];
            }
            for (size_t j = 0; j < inner; j++) to[j] /= pivot;
        }
    }
}
