// SPDX-License-Identifier: Apache-2.0
// A certified bound of the distance of two splines, one on some of the knots of the other.
//
// On the finer knots f - g = sum_i (c_i - d_i) N_i, sum_i N_i = 1, N_i >= 0, hence |f - g| <= max |c_i - d_i|. For
// f = P/w and g = Q/v, C any point, R >= |g - C|: w (f - g) = (P - Q) - (w - v) g, so that
//     |f - g| <= max_i (|(P_i - Q_i) - (w_i - v_i) C| + |w_i - v_i| R) / w_i.
// d_i is computed by convex combinations, with the relative error gamma(6 p + 1) of the largest coefficient in it.
#include <math.h>

#include "spline/removal.h"
#include "kernel/context.h"

enum { SLACK = 32 };                       // roundings of the bound's own arithmetic, generously
static const double UNDERFLOW = 0x1p-1060; // what combinations of numbers below the normal ones lose

static double gamma_of(int n)
{
    double nu = n * 0x1p-53;
    return nu / (1.0 - nu);
}

// >= the Euclidean norm less its rounding, gamma(n + 4), without overflow.
static double norm(const double *x, int n)
{
    double most = 0.0, sum = 0.0;
    for (int i = 0; i < n; i++) most = fabs(x[i]) > most || isnan(x[i]) ? fabs(x[i]) : most;
    if (!(most > 0.0) || isinf(most)) return most;
    for (int i = 0; i < n; i++) sum += x[i] / most * (x[i] / most);
    return most * sqrt(sum);
}

typedef struct frame {
    double center[KN_MAX_COMPS], length, radius; // of a ball that contains g; length = |center|
} frame;

// The ball around the box of g's control points. false: a weight that is not positive.
static bool make_frame(frame *ball, const kn_rows *g)
{
    int dim = g->ncomp - 1;
    double lo[KN_MAX_COMPS], hi[KN_MAX_COMPS], x[KN_MAX_COMPS] = {0};
    size_t n = (size_t)g->count * g->lines;
    for (size_t i = 0; i < n; i++) {
        const double *point = g->row + i * (size_t)g->ncomp;
        if (!(point[dim] > 0.0)) return false;
        for (int c = 0; c < dim; c++) {
            double value = point[c] / point[dim];
            if (i == 0 || value < lo[c]) lo[c] = value;
            if (i == 0 || value > hi[c]) hi[c] = value;
        }
    }
    for (int c = 0; c < dim; c++) {
        ball->center[c] = 0.5 * lo[c] + 0.5 * hi[c];
        x[c] = fmax(hi[c] - ball->center[c], ball->center[c] - lo[c]) + 4 * 0x1p-53 * (fabs(lo[c]) + fabs(hi[c]));
    }
    ball->length = norm(ball->center, dim);
    ball->radius = norm(x, dim) * (1.0 + gamma_of(SLACK + 2 * KN_MAX_COMPS));
    return true;
}

// What |c - d| means at one point: d is known to `rounding` of `large`, the norms of the coefficients in it.
static double distance(const kn_rows *f, const frame *ball, const double *c, const double *d, const double *large,
                       double rounding)
{
    double x[KN_MAX_COMPS] = {0}, own = 1.0 + gamma_of(SLACK + 2 * f->ncomp);
    int dim = f->ncomp - f->rational;
    for (int k = 0; k < f->ncomp; k++) x[k] = c[k] - d[k];
    double lost = rounding > 0.0 ? UNDERFLOW : 0.0;
    if (!f->rational) return (norm(x, dim) + rounding * large[0] + lost) * own;
    double w = c[dim], dw = fabs(x[dim]);
    if (!(w > 0.0)) return INFINITY;
    double moved = 4 * 0x1p-53 * (norm(x, dim) + dw * ball->length);
    for (int k = 0; k < dim; k++) x[k] -= x[dim] * ball->center[k];
    double sum = norm(x, dim) + moved + dw * ball->radius;
    return (sum + rounding * (large[0] + large[1] * (ball->length + ball->radius)) + lost) / w * own;
}

// large[2 * i], large[2 * i + 1]: norm of the point and its weight, for all points of g.
static double *sizes(kn_ctx *ctx, const kn_rows *g)
{
    size_t n = (size_t)g->count * g->lines;
    int dim = g->ncomp - g->rational;
    double *large = kn_scratch(ctx, 2 * n, sizeof *large);
    for (size_t i = 0; large && i < n; i++) {
        const double *point = g->row + i * (size_t)g->ncomp;
        large[2 * i] = norm(point, dim);
        large[2 * i + 1] = g->rational ? fabs(point[dim]) : 0.0;
    }
    return large;
}

static double row_distance(const kn_rows *f, const frame *ball, int i, const double *d, const double *large,
                           int first, int terms)
{
    double most = 0.0, rounding = terms > 1 ? gamma_of(6 * f->degree + 3) : 0.0; // a copy is exact
    for (size_t l = 0; l < f->lines; l++) {
        double size[2] = {0.0, 0.0};
        for (int k = 0; k < terms; k++) {
            const double *from = large + 2 * ((size_t)(first + k) * f->lines + l);
            size[0] = fmax(size[0], from[0]), size[1] = fmax(size[1], from[1]);
        }
        size_t at = l * (size_t)f->ncomp;
        double x = distance(f, ball, f->row + (size_t)i * f->lines * (size_t)f->ncomp + at, d + at, size, rounding);
        most = x > most || isnan(x) ? x : most;
        if (isnan(most)) return INFINITY;
    }
    return most;
}

kn_status kn_rows_distance(kn_ctx *ctx, double *bound, double *local, const kn_rows *f, const kn_rows *g)
{
    size_t width = f->lines * (size_t)f->ncomp;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_band band;
    frame ball = {.length = 0.0};
    kn_status status = kn_spline_refining_band(ctx, &band, f->count, f->degree + 1);
    double *large = status == KN_OK ? sizes(ctx, g) : NULL;
    double *fine = large ? kn_scratch(ctx, (size_t)f->count * width, sizeof *fine) : NULL;
    if (!fine) status = KN_ENOMEM;
    if (status == KN_OK) {
        bool positive = !f->rational || make_frame(&ball, g);
        kn_band_refine(&band, g->knots, g->degree, g->count, f->knots);
        kn_band_apply(fine, &band, g->row, 1, g->count, width);
        *bound = 0.0;
        for (int i = 0; i < f->count; i++) {
            double x = positive
                           ? row_distance(f, &ball, i, fine + (size_t)i * width, large, band.first[i], band.terms[i])
                           : INFINITY;
            if (local) local[i] = x;
            *bound = x > *bound ? x : *bound;
        }
    }
    kn_scratch_release(ctx, mark);
    return status;
}
