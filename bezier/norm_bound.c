// SPDX-License-Identifier: Apache-2.0
// Tight upper bounds of how far pieces are from zero: coefficients of halves, quarters, ...
#include "bezier/norm_bound.h"

#include <math.h>

#include "kernel/bernstein.h"

enum { MOST_PIECES = 512, MOST_DEPTH = 40 };
static const double UNDERFLOW = 0x1p-1060; // some thousand operations whose results may be below the normal numbers

typedef struct search {
    double radius, rounding, bound, least;
    int pieces;
} search;

// The norm of point i, within 1e-13 or so from above; without overflow.
static double norm(const kn_bezier *d, size_t n, size_t i, double radius)
{
    int dim = d->ncomp - (radius >= 0.0);
    double most = 0.0, sum = 0.0;
    for (int c = 0; c < dim; c++) {
        double x = fabs(d->coef[(size_t)c * n + i]);
        if (x > most || isnan(x)) most = x;
    }
    if (most > 0.0 && isfinite(most)) {
        for (int c = 0; c < dim; c++) {
            double x = d->coef[(size_t)c * n + i] / most;
            sum += x * x;
        }
        most *= sqrt(sum);
    }
    return kn_round_up(radius >= 0.0 ? most + radius * fabs(d->coef[(size_t)dim * n + i]) : most);
}

// Coefficient i is at a corner when each index is 0 or the degree: then it is a value.
static bool is_corner(const kn_bezier *d, size_t i)
{
    for (int v = d->nvars - 1; v >= 0; v--) {
        size_t m = (size_t)d->degree[v] + 1, k = i % m;
        if (k != 0 && k != m - 1) return false;
        i /= m;
    }
    return true;
}

static kn_status look(kn_ctx *ctx, search *s, const kn_bezier *d, int depth)
{
    size_t n = kn_bezier_count(d);
    double most = 0.0;
    for (size_t i = 0; i < n; i++) {
        double x = norm(d, n, i, s->radius);
        if (x > most || isnan(x)) most = x;
        if (x > s->least && is_corner(d, i) && isfinite(x)) s->least = x;
    }
    s->pieces++;
    int var = -1;
    for (int k = 0; k < d->nvars && var < 0; k++)
        if (d->degree[(depth + k) % d->nvars] > 0) var = (depth + k) % d->nvars;
    if (most <= 1.25 * s->least || !isfinite(most) || var < 0 || s->pieces >= MOST_PIECES || depth >= MOST_DEPTH) {
        if (isnan(most)) most = INFINITY;
        if (most > s->bound) s->bound = most;
        return KN_OK;
    }
    kn_bezier left = *d, right = *d;
    kn_mark mark = kn_scratch_mark(ctx);
    left.coef = kn_scratch(ctx, n * (size_t)d->ncomp, sizeof *left.coef);
    right.coef = left.coef ? kn_scratch(ctx, n * (size_t)d->ncomp, sizeof *right.coef) : NULL;
    kn_status status = right.coef ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        kn_axis x = kn_bezier_axis(d, var);
        kn_bernstein_split(left.coef, right.coef, d->coef, x.outer, d->degree[var], x.inner, 0.5);
        status = look(ctx, s, &left, depth + 1);
    }
    if (status == KN_OK) status = look(ctx, s, &right, depth + 1);
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_bezier_norm_bound(kn_ctx *ctx, double *bound, double *least, const kn_bezier *d, double radius)
{
    search s = {.radius = radius, .least = *least};
    size_t n = kn_bezier_count(d);
    double most = 0.0;
    int degree = 0;
    for (int v = 0; v < d->nvars; v++) degree = d->degree[v] > degree ? d->degree[v] : degree;
    for (size_t i = 0; i < n; i++) most = fmax(most, norm(d, n, i, radius));
    kn_status status = look(ctx, &s, d, 0);
    if (status != KN_OK) return status;
    // halving: gamma(3 degree) of the largest coefficient each time
    s.bound = kn_round_up(s.bound + kn_gamma_up(3.0 * degree * MOST_DEPTH) * (s.pieces > 1 ? most : 0.0));
    if (isnan(s.bound)) s.bound = INFINITY;
    if (s.bound > *bound) *bound = s.bound;
    if (s.least > *least) *least = s.least;
    return KN_OK;
}

// A ball around the control points of Q/v. false: a weight is not positive.
static bool ball_of(double *center, kn_deviation *v, const double *b, size_t n, int dim)
{
    double square = 0.0, radius = 0.0;
    v->least = INFINITY;
    for (size_t i = 0; i < n; i++) {
        if (!(b[(size_t)dim * n + i] > 0.0)) return false;
        v->least = fmin(v->least, b[(size_t)dim * n + i]);
    }
    for (int c = 0; c < dim; c++) {
        double lo = INFINITY, hi = -INFINITY;
        for (size_t i = 0; i < n; i++) {
            double x = b[(size_t)c * n + i] / b[(size_t)dim * n + i];
            lo = fmin(lo, x), hi = fmax(hi, x);
        }
        center[c] = 0.5 * lo + 0.5 * hi;
        double half = fmax(hi - center[c], center[c] - lo) + 0x1p-50 * (fabs(lo) + fabs(hi));
        radius = hypot(radius, half), square = hypot(square, center[c]);
    }
    v->radius = kn_round_up(radius), v->length = kn_round_up(square);
    return true;
}

bool kn_deviation_of(kn_deviation *v, double *d, size_t n, int ncomp, bool rational, const double *a, size_t na,
                     const double *b, size_t nb)
{
    double center[KN_MAX_COMPS];
    int dim = ncomp - rational;
    *v = (kn_deviation){.radius = -1.0, .weight = 1.0};
    if (!rational) return true;
    if (!ball_of(center, v, b, nb, dim)) return false;
    v->weight = INFINITY;
    for (size_t i = 0; i < na; i++) v->weight = fmin(v->weight, a[(size_t)dim * na + i]);
    if (!(v->weight > 0.0)) return false;
    for (size_t i = 0; i < n; i++) {
        double dw = d[(size_t)dim * n + i], length = 0.0;
        v->apart = fmax(v->apart, fabs(dw));
        for (int c = 0; c < dim; c++) {
            double *x = &d[(size_t)c * n + i];
            length = hypot(length, *x);
            *x -= dw * center[c];
        }
        v->extra = fmax(v->extra, kn_round_up(0x1p-51 * (length + fabs(dw) * v->length)));
    }
    return true;
}

void kn_parts_add(kn_parts *rounding, double factor, const double *coef, size_t n, int ncomp, bool rational)
{
    size_t coordinates = n * (size_t)(ncomp - rational), all = n * (size_t)ncomp;
    double most[2] = {0.0, 0.0};
    for (size_t i = 0; i < all; i++) most[i >= coordinates] = fmax(most[i >= coordinates], fabs(coef[i]));
    rounding->coordinate = kn_round_up(rounding->coordinate + factor * most[0] + (most[0] > 0.0 ? UNDERFLOW : 0.0));
    rounding->weight = kn_round_up(rounding->weight + factor * most[1] + (most[1] > 0.0 ? UNDERFLOW : 0.0));
}

// e = x - dw C: what x and dw are wrong by, and R dw. Twice, because e may have been mapped further. The ball about Q/v
// is too small by what control points Q/v are wrong by, and w may be less.
double kn_deviation_bound(const kn_deviation *v, double bound, const kn_parts *rounding, int ncomp)
{
    double each = rounding->coordinate * sqrt(ncomp) + 2.0 * v->extra, weight = v->weight;
    if (v->radius >= 0.0) {
        double reach = v->length + v->radius, least = v->least - rounding->weight;
        weight = (weight - rounding->weight) * (1.0 - 0x1p-50);
        if (!(weight > 0.0) || !(least > 0.0)) return INFINITY;
        double off = kn_round_up((rounding->coordinate * sqrt(ncomp) + reach * rounding->weight) / least);
        each += 2.0 * rounding->weight * (reach + off) + off * v->apart;
    }
    double sum = kn_round_up((bound + kn_round_up(each)) / weight);
    if (each > 0.0) sum = nextafter(sum, INFINITY); // the quotient may underflow
    return isnan(sum) ? INFINITY : sum;
}
