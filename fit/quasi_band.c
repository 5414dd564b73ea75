// SPDX-License-Identifier: Apache-2.0
// The functionals of the quasi-interpolant. Coefficient j of a polynomial f is its blossom at the knots j+1 .. j+p; f
// is taken as the polynomial through degree + 1 sites near j. In the Bernstein form of that polynomial over an
// interval [a,b] around sites and knots, with the rows V of its values at the sites and the weights b of the blossom,
// the functional w on values is V^T w = b. V is totally positive.
#include "fit/internal.h"
#include "kernel/banded.h"
#include "kernel/context.h"
#include "spline/internal.h"

typedef struct functional {
    kn_collocation c;
    double *knots; // 2 (p + 1)
    int *span;
} functional;

static bool find_weights(double *w, functional *f, const double *args, const double *sites)
{
    int p = f->c.degree;
    double a = sites[0] < args[0] ? sites[0] : args[0], b = sites[p] > args[p - 1] ? sites[p] : args[p - 1];
    for (int i = 0; i <= p; i++) f->knots[i] = a, f->knots[p + 1 + i] = b;
    kn_knots_blossom(w, f->knots, p, p, args);
    kn_collocation_factor(&f->c, f->knots, sites, f->span);
    if (!kn_collocation_regular(&f->c)) return false;
    kn_collocation_solve_transposed(&f->c, w);
    return true;
}

kn_status kn_fit_quasi_band(kn_ctx *ctx, kn_band *band, const double *knots, int degree, int count,
                            const double *sites)
{
    int p = degree;
    kn_status status = kn_spline_band(ctx, band, count, p + 1);
    functional f = {.c = {.count = p + 1, .degree = p}};
    f.c.band = kn_scratch(ctx, kn_collocation_room(p + 1, p), sizeof *f.c.band);
    f.knots = kn_scratch(ctx, 2 * (size_t)(p + 1), sizeof *f.knots);
    f.span = kn_scratch(ctx, (size_t)p + 1, sizeof *f.span);
    if (status != KN_OK || !f.c.band || !f.knots || !f.span) return KN_ENOMEM;
    for (int i = 0; i <= p; i++) f.span[i] = p;
    for (int j = 0; j < count; j++) {
        int first = j - p / 2, last = count - 1 - p;
        first = first < 0 ? 0 : first > last ? last : first;
        band->first[j] = first;
        double *w = band->w + (size_t)j * (size_t)(p + 1);
        if (p == 0)
            w[0] = 1.0;
        else if (!find_weights(w, &f, knots + j + 1, sites + first))
            return kn_fail(ctx, KN_EUNDECIDED, "fit_quasi: sites of coefficient %d lie too close", j);
    }
    return KN_OK;
}
