// SPDX-License-Identifier: Apache-2.0
// Fuzzes fits: knots, sites, values and fixed layers by bytes.
#include "tests/fuzz/feed.h"

#include <knurl/fit.h>

#include <string.h>

// A shape whose arrays have exactly the sizes that the calls are told; absurd numbers come with empty arrays.
typedef struct grid {
    int nvars, dim, degree[KN_MAX_VARS], count[KN_MAX_VARS], nsites[KN_MAX_VARS];
    const double *knots[KN_MAX_VARS], *sites[KN_MAX_VARS];
    size_t coefs, values; // of one component
} grid;

static double *make_sites(feed *f, int n, bool sorted)
{
    double *at = feed_parameters(f, (size_t)n);
    for (int i = 0; i < n && sorted; i++) at[i] = (i + at[i] * 0.9) / n;
    if (sorted && n > 0 && feed_byte(f) % 2) at[0] = 0.0, at[n - 1] = 1.0;
    return at;
}

static grid make_grid(feed *f, bool square)
{
    grid g = {.nvars = feed_int(f, 1, 3), .dim = feed_int(f, 1, 3), .coefs = 1, .values = 1};
    bool sorted = feed_byte(f) % 8 != 0;
    for (int d = 0; d < g.nvars; d++) {
        int most = g.nvars == 1 ? 12 : 3;
        g.degree[d] = feed_int(f, 0, g.nvars == 1 ? 7 : 3);
        g.count[d] = g.degree[d] + 1 + feed_int(f, 0, most);
        g.nsites[d] = square ? g.count[d] : feed_int(f, 0, most + 4);
        g.knots[d] = feed_knots(f, g.degree[d], g.count[d], 0.0, 1.0);
        g.sites[d] = make_sites(f, g.nsites[d], sorted);
        g.coefs *= (size_t)g.count[d], g.values *= (size_t)g.nsites[d];
    }
    return g;
}

static kn_fit_fixed make_fixed(feed *f, const grid *g)
{
    kn_fit_fixed fixed = {.coef = NULL};
    for (int d = 0; d < g->nvars; d++) fixed.first[d] = feed_wild(f, 0, 2), fixed.last[d] = feed_wild(f, 0, 2);
    fixed.coef = feed_numbers(f, g->coefs * (size_t)g->dim);
    return fixed;
}

static kn_status function(void *user, double *value, const double *at)
{
    const double *number = user; // kind, dim, nvars
    double sum = 0.0;
    for (int d = 0; d < (int)number[2]; d++) sum += at[d] * (d + 1);
    for (int c = 0; c < (int)number[1]; c++) value[c] = number[0] < 1.0 ? sin(sum + c) : 1.0 / (sum - number[0]);
    return number[0] == 7.0 ? KN_EUNDEFINED : KN_OK;
}

static kn_status fits(feed *f, int call, kn_spline *out)
{
    grid g = make_grid(f, call == 0);
    double residual;
    size_t dim = (size_t)g.dim;
    bool with_fixed = feed_byte(f) % 2;
    kn_fit_fixed fixed = make_fixed(f, &g);
    if (call == 0)
        return kn_fit_interpolate(f->ctx, out, g.nvars, g.dim, g.degree, g.count, g.knots, g.sites,
                                  feed_numbers(f, g.values * dim));
    if (call == 1)
        return kn_fit_least_squares(f->ctx, out, &residual, g.nvars, g.dim, g.degree, g.count, g.knots, g.nsites,
                                    g.sites, feed_numbers(f, g.values * dim), with_fixed ? &fixed : NULL);
    size_t n = (size_t)feed_int(f, 0, 40);
    const double *at = feed_parameters(f, n * (size_t)g.nvars), *values = feed_numbers(f, n * dim), *weights = NULL;
    if (feed_byte(f) % 2) weights = feed_parameters(f, n);
    return kn_fit_scattered(f->ctx, out, &residual, g.nvars, g.dim, g.degree, g.count, g.knots, n, at, values,
                            weights, with_fixed ? &fixed : NULL);
}

static kn_status functions(feed *f, int call, kn_spline *out)
{
    grid g = make_grid(f, true);
    double kind[3] = {feed_int(f, 0, 7), g.dim, g.nvars}, estimate;
    if (call == 0) return kn_fit_quasi(f->ctx, out, g.nvars, g.dim, g.degree, g.count, g.knots, function, kind);
    const double *lo = feed_parameters(f, (size_t)g.nvars), *hi = feed_parameters(f, (size_t)g.nvars);
    return kn_fit_to_tolerance(f->ctx, out, &estimate, g.nvars, g.dim, g.degree, lo, hi, function, kind,
                               feed_number(f), feed_int(f, -1, g.nvars > 1 ? 12 : 60) | 1);
}

static kn_status vectors(feed *f, int call)
{
    grid g = make_grid(f, feed_byte(f) % 2);
    int p = g.degree[0], n = g.count[0], var = feed_wild(f, 0, g.nvars - 1), wild = feed_count(f, 1, 3);
    bool is_wild = wild < 0;
    size_t nknots = (size_t)p + (size_t)n + 1;
    switch (call) {
    case 0: return kn_fit_greville(f->ctx, feed_room(f, (size_t)n), g.knots[0], is_wild ? wild : p, n);
    case 1:
        return kn_fit_uniform_knots(f->ctx, feed_room(f, nknots), p, wild < 0 ? wild : n, feed_number(f),
                                    feed_number(f));
    case 2: return kn_fit_averaged_knots(f->ctx, feed_room(f, nknots), p, n, g.nsites[0], g.sites[0]);
    case 3: {
        double *sites = feed_room(f, var >= 0 && var < g.nvars ? (size_t)g.nsites[var] : 0);
        const double *points = feed_numbers(f, g.values * (size_t)g.dim);
        return kn_fit_parameters(f->ctx, sites, g.nvars, g.dim, g.nsites, points, var, feed_number(f));
    }
    default: {
        int norders = feed_wild(f, 1, p + 1);
        const double *derivatives = feed_numbers(f, (size_t)(p + 1) * (size_t)g.dim);
        double *coef = feed_room(f, (size_t)n * (size_t)g.dim);
        return kn_fit_end_coefficients(f->ctx, coef, g.dim, g.knots[0], p, n, feed_byte(f) % 2, norders, derivatives);
    }
    }
}

// Pieces of up to three variables, their edges too; few halvings, for the fuzzer's patience.
static kn_status limits(feed *f, kn_spline *out)
{
    bool rational = feed_byte(f) % 3 == 0;
    kn_bezier a = {.nvars = feed_int(f, 1, 3), .ncomp = feed_int(f, 1, 3) + rational, .rational = rational};
    size_t n = (size_t)a.ncomp;
    for (int d = 0; d < a.nvars; d++) {
        a.degree[d] = feed_int(f, 0, a.nvars < 3 ? 9 : 5);
        n *= (size_t)a.degree[d] + 1;
    }
    a.coef = feed_room(f, n);
    memcpy(a.coef, feed_numbers(f, n), n * sizeof *a.coef);
    for (size_t i = n - n / (size_t)a.ncomp; rational && i < n; i++) a.coef[i] = fabs(a.coef[i]);
    kn_fit_limits l = {.max_degree = feed_wild(f, 3, 6), .degree = feed_wild(f, 0, 4)};
    l.tolerance = feed_number(f), l.max_level = feed_int(f, 1, a.nvars < 3 ? 3 : 1);
    if (feed_byte(f) % 2) l.quantum = ldexp(1.0, -feed_int(f, 0, 60));
    kn_spline edges[4] = {{0}, {0}, {0}, {0}};
    kn_fit_limited report;
    bool with_edges = feed_byte(f) % 2;
    kn_status status = kn_fit_limit_degree(f->ctx, out, with_edges ? edges : NULL, &report, &a, &l);
    if (status == KN_OK && !(report.error <= l.tolerance)) abort();
    for (int e = 0; e < 4; e++) kn_spline_clear(f->ctx, &edges[e]);
    return status;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    feed f = feed_begin(data, size);
    kn_spline out = {0};
    int call = feed_byte(&f) % 11;
    kn_status status = call < 3    ? fits(&f, call, &out)
                       : call < 5  ? functions(&f, call - 3, &out)
                       : call < 10 ? vectors(&f, call - 5)
                                   : limits(&f, &out);
    if ((status == KN_OK) != (kn_ctx_error(f.ctx) == KN_OK) && status != KN_EUNDEFINED) abort();
    kn_spline_clear(f.ctx, &out);
    feed_end(&f);
    return 0;
}
