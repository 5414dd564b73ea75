// SPDX-License-Identifier: Apache-2.0
// A quasi-interpolant on knots that are halved where samples ask for it. With Q = Q_0 Q_1 .. the error is
// f - Q f = (f - Q_0 f) + Q_0 (f - Q_1 f) + ..: each variable's own part is sampled on the lines through the sites of
// the others, and its spans are halved where it is too large; then the whole is sampled.
#include <math.h>
#include <string.h>

#include "fit/internal.h"
#include "kernel/context.h"
#include "spline/internal.h"

static const char call[] = "fit_to_tolerance";
enum { SAMPLES = 2 }; // in each span
static const double sample_place[SAMPLES] = {0.3, 0.75};

typedef struct search {
    kn_fit_function function;
    void *user;
    int nvars, dim, room; // room: control points in one variable
    const int *degree;
    double tolerance, share; // share: the part of the tolerance that one variable's error may take
    int nbreaks[KN_MAX_VARS];
    double *breaks[KN_MAX_VARS]; // two arrays of room + 1: the breaks, and room for the next ones
    double *sites[KN_MAX_VARS];
} search;

static kn_status make_spline(kn_ctx *ctx, kn_spline *s, const search *w)
{
    int count[KN_MAX_VARS];
    const double *knots[KN_MAX_VARS];
    double *to[KN_MAX_VARS];
    for (int d = 0; d < w->nvars; d++) {
        int p = w->degree[d], n = w->nbreaks[d];
        count[d] = n - 1 + p;
        knots[d] = to[d] = kn_scratch(ctx, (size_t)(n + 2 * p), sizeof *to[d]);
        if (!to[d]) return KN_ENOMEM;
        for (int i = 0; i < n + 2 * p; i++) {
            int k = i - p;
            to[d][i] = w->breaks[d][k < 0 ? 0 : k > n - 1 ? n - 1 : k];
        }
    }
    kn_spline fresh = {0};
    kn_status status = kn_spline_init(ctx, &fresh, w->nvars, w->dim, false, w->degree, count, knots, NULL);
    if (status == KN_OK) kn_spline_swap(s, &fresh);
    kn_spline_clear(ctx, &fresh);
    return status;
}

// x[d] (n[d] of them): the samples of each span of variable `var` (-1: of every variable), the sites of the others.
static void sample_places(double *const *x, int *n, const search *w, const kn_spline *s, int var)
{
    for (int d = 0; d < w->nvars; d++) {
        bool samples = d == var || var < 0;
        n[d] = samples ? SAMPLES * (w->nbreaks[d] - 1) : s->count[d];
        for (int i = 0; i < n[d]; i++) {
            const double *span = w->breaks[d] + i / SAMPLES;
            x[d][i] = samples ? span[0] + sample_place[i % SAMPLES] * (span[1] - span[0]) : w->sites[d][i];
        }
    }
}

// error[i] = the largest distance of the spline from the function on the grid with place i in variable var (0: all).
static kn_status largest_errors(kn_ctx *ctx, double *error, const search *w, const kn_spline *s, double *const *x,
                                const int *n, const kn_band *along, int var, const double *coef)
{
    int k[KN_MAX_VARS] = {0};
    size_t inner = kn_spline_inner(s, var < 0 ? 0 : var), total = kn_spline_count(s);
    double at[KN_MAX_VARS], value[KN_MAX_COMPS], own[KN_MAX_COMPS];
    for (int d = 0; d >= 0;) {
        size_t place = 0;
        for (int e = 0; e < w->nvars; e++) {
            at[e] = x[e][k[e]];
            place = place * (size_t)s->count[e] + (size_t)(along && e == var ? along->first[k[e]] : k[e]);
        }
        kn_status status = w->function(w->user, value, at);
        if (status != KN_OK) return kn_fail(ctx, status, "%s: the function failed", call);
        if (var < 0) status = kn_spline_eval(ctx, own, s, at);
        if (status != KN_OK) return status;
        double square = 0.0;
        for (size_t c = 0; c < (size_t)w->dim; c++) {
            if (along) own[c] = 0.0;
            for (int i = 0; along && i < along->width; i++)
                own[c] += along->w[k[var] * along->width + i] * coef[c * total + place + (size_t)i * inner];
            square += (own[c] - value[c]) * (own[c] - value[c]);
        }
        double *largest = &error[var < 0 ? 0 : k[var] / SAMPLES];
        if (!(sqrt(square) <= *largest)) *largest = sqrt(square); // NaN stays, and asks for more knots
        for (d = w->nvars - 1; d >= 0 && ++k[d] == n[d]; d--) k[d] = 0;
    }
    return KN_OK;
}

// The error of variable var alone, for each of its spans: Q_var of the values at the sites, against the function.
static kn_status errors_along(kn_ctx *ctx, double *error, const search *w, const kn_spline *s, double *const *x,
                              const double *values, int var)
{
    int n[KN_MAX_VARS], nspans = w->nbreaks[var] - 1;
    kn_band band, along;
    kn_fit_axis axis = {var, s->degree[var], s->count[var], s->knots[var], SAMPLES * nspans, x[var]};
    sample_places(x, n, w, s, var);
    int *span = kn_scratch(ctx, (size_t)axis.nsites, sizeof *span);
    double *coef = kn_scratch(ctx, kn_spline_count(s) * (size_t)w->dim, sizeof *coef);
    if (!span || !coef) return KN_ENOMEM;
    kn_status status = kn_fit_spans(ctx, call, span, &axis);
    if (status == KN_OK) status = kn_fit_basis(ctx, &along, &axis, span);
    if (status == KN_OK)
        status = kn_fit_quasi_band(ctx, &band, s->knots[var], s->degree[var], s->count[var], w->sites[var]);
    if (status != KN_OK) return status;
    kn_band_apply(coef, &band, values, kn_spline_outer(s, var), s->count[var], kn_spline_inner(s, var));
    for (int i = 0; i < nspans; i++) error[i] = 0.0;
    return largest_errors(ctx, error, w, s, x, n, &along, var, coef);
}

// Halves the spans of var whose error is too large; *any: there were some.
static kn_status halve(kn_ctx *ctx, search *w, int var, const double *error, bool *any)
{
    double *old = w->breaks[var], *fresh = old + w->room + 1, limit = w->share * w->tolerance;
    int n = 0, nspans = w->nbreaks[var] - 1;
    double shortest = 0x1p-40 * fmax(fabs(old[0]), fabs(old[nspans])); // sites and samples stay apart
    for (int i = 0; i < nspans; i++) {
        double middle = old[i] + 0.5 * (old[i + 1] - old[i]);
        bool split = !(error[i] <= limit) || w->share < 0x1p-20; // errors off all lines end in smaller spans, too
        if (n + 1 + split + w->degree[var] > w->room || (split && !(old[i + 1] - old[i] > shortest)))
            return kn_fail(ctx, KN_EUNDECIDED, "%s: variable %d: error %g at %g, more than %d control points needed",
                           call, var, error[i], middle, w->room);
        fresh[n++] = old[i];
        if (split) fresh[n++] = middle;
        *any = *any || split;
    }
    fresh[n++] = old[nspans];
    memcpy(old, fresh, (size_t)n * sizeof *old);
    w->nbreaks[var] = n;
    return KN_OK;
}

// One round: the quasi-interpolant on the breaks, then more breaks where its error asks for them.
static kn_status improve(kn_ctx *ctx, search *w, kn_spline *s, double *estimate, bool *done)
{
    double *x[KN_MAX_VARS] = {NULL}, *error[KN_MAX_VARS] = {NULL};
    int n[KN_MAX_VARS];
    kn_status status = make_spline(ctx, s, w);
    if (status != KN_OK) return status;
    size_t total = kn_spline_count(s) * (size_t)w->dim;
    double *values = kn_scratch(ctx, total, sizeof *values);
    if (!values) return KN_ENOMEM;
    for (int d = 0; d < w->nvars; d++) {
        size_t most = (size_t)SAMPLES * (size_t)(w->nbreaks[d] + s->degree[d]);
        x[d] = kn_scratch(ctx, most, sizeof *x[d]);
        error[d] = kn_scratch(ctx, (size_t)w->nbreaks[d], sizeof *error[d]);
        w->sites[d] = kn_scratch(ctx, (size_t)s->count[d], sizeof *w->sites[d]);
        if (!x[d] || !error[d] || !w->sites[d]) return KN_ENOMEM;
        status = kn_fit_greville(ctx, w->sites[d], s->knots[d], s->degree[d], s->count[d]);
        if (status != KN_OK) return status;
    }
    status = kn_fit_sample(ctx, s, w->sites, w->function, w->user);
    if (status == KN_OK) memcpy(values, s->coef, total * sizeof *values);
    for (int d = 0; d < w->nvars && status == KN_OK; d++) status = errors_along(ctx, error[d], w, s, x, values, d);
    bool any = false;
    for (int d = 0; d < w->nvars && status == KN_OK; d++) status = halve(ctx, w, d, error[d], &any);
    if (status != KN_OK || any) return status;
    status = kn_fit_quasi_apply(ctx, s, w->sites);
    if (status != KN_OK) return status;
    sample_places(x, n, w, s, -1);
    *estimate = 0.0;
    status = largest_errors(ctx, estimate, w, s, x, n, NULL, -1, NULL);
    *done = *estimate <= w->tolerance;
    w->share *= 0.5;
    return status;
}

static kn_status check(kn_ctx *ctx, int nvars, int dim, const int *degree, const double *lo, const double *hi,
                       double tolerance, int max_count)
{
    if (nvars < 1 || nvars > KN_MAX_VARS || dim < 1 || dim > KN_MAX_COMPS || !(tolerance > 0.0) || max_count < 0)
        return kn_fail(ctx, KN_EDOMAIN, "%s: nvars %d, dim %d, tolerance %g, max_count %d", call, nvars, dim,
                       tolerance, max_count);
    for (int d = 0; d < nvars; d++) {
        if (degree[d] < 1 || !(lo[d] < hi[d]) || !isfinite(hi[d] - lo[d]))
            return kn_fail(ctx, KN_EDOMAIN, "%s: variable %d: degree %d over [%g, %g]", call, d, degree[d], lo[d],
                           hi[d]);
        if (degree[d] > KN_MAX_DEGREE)
            return kn_fail(ctx, KN_ELIMIT, "%s: variable %d: degree %d", call, d, degree[d]);
    }
    return KN_OK;
}

kn_status kn_fit_to_tolerance(kn_ctx *ctx, kn_spline *out, double *estimate, int nvars, int dim, const int *degree,
                              const double *lo, const double *hi, kn_fit_function function, void *user,
                              double tolerance, int max_count)
{
    kn_status status = check(ctx, nvars, dim, degree, lo, hi, tolerance, max_count);
    if (status != KN_OK) return status;
    search w = {.function = function, .user = user, .nvars = nvars, .dim = dim, .degree = degree};
    w.tolerance = tolerance, w.share = 1.0 / nvars, w.room = max_count ? max_count : 4096;
    kn_spline s = {0};
    kn_mark mark = kn_scratch_mark(ctx);
    for (int d = 0; d < nvars && status == KN_OK; d++) {
        w.breaks[d] = kn_scratch(ctx, 2 * (size_t)(w.room + 1), sizeof *w.breaks[d]);
        if (!w.breaks[d])
            status = KN_ENOMEM;
        else
            w.breaks[d][0] = lo[d], w.breaks[d][1] = hi[d], w.nbreaks[d] = 2;
    }
    double found = 0.0;
    for (bool done = false; status == KN_OK && !done;) {
        kn_mark round = kn_scratch_mark(ctx);
        status = improve(ctx, &w, &s, &found, &done);
        kn_scratch_release(ctx, round);
    }
    kn_scratch_release(ctx, mark);
    if (status == KN_OK) {
        kn_spline_swap(out, &s);
        if (estimate) *estimate = found;
    }
    kn_spline_clear(ctx, &s);
    return status;
}
