// SPDX-License-Identifier: Apache-2.0
// Least squares on a grid: with A = A_0 x A_1 x .. and the given control points c' in their places, the free
// ones are A_free^+ (f - A c'), and the pseudoinverse of a tensor product is that of its factors: one banded
// system a variable.
#include <math.h>

#include "fit/internal.h"
#include "kernel/banded.h"
#include "kernel/context.h"
#include "spline/internal.h"

static const char call[] = "fit_least_squares";

typedef struct problem {
    int nvars, dim;
    kn_fit_axis axis[KN_MAX_VARS];
    kn_band basis[KN_MAX_VARS];
    int first[KN_MAX_VARS], nfree[KN_MAX_VARS];
    size_t room; // numbers of the largest grid on the way from coefficients to sites
    double *buffer[2];
} problem;

static kn_status prepare_axis(kn_ctx *ctx, problem *w, int d, const kn_spline *s, int nsites, const double *sites,
                              const kn_fit_fixed *fixed)
{
    kn_fit_axis *axis = &w->axis[d];
    *axis = (kn_fit_axis){d, s->degree[d], s->count[d], s->knots[d], nsites, sites};
    w->first[d] = fixed ? fixed->first[d] : 0;
    w->nfree[d] = axis->count - w->first[d] - (fixed ? fixed->last[d] : 0);
    if (nsites < w->nfree[d])
        return kn_fail(ctx, KN_EUNDEFINED, "%s: variable %d: %d sites for %d coefficients", call, d, nsites,
                       w->nfree[d]);
    int *span = kn_scratch(ctx, (size_t)nsites, sizeof *span);
    kn_status status = span ? kn_fit_spans(ctx, call, span, axis) : KN_ENOMEM;
    if (status == KN_OK) status = kn_fit_suits(ctx, call, axis, w->first[d], w->first[d] + w->nfree[d]);
    if (status == KN_OK) status = kn_fit_basis(ctx, &w->basis[d], axis, span);
    return status;
}

static kn_status prepare(kn_ctx *ctx, problem *w, const kn_spline *s, const int *nsites, const double *const *sites,
                         const kn_fit_fixed *fixed)
{
    kn_status status = kn_fit_check_fixed(ctx, call, s->nvars, s->count, fixed);
    w->nvars = s->nvars, w->dim = s->ncomp, w->room = (size_t)s->ncomp;
    for (int d = 0; d < w->nvars && status == KN_OK; d++) {
        size_t larger = (size_t)(nsites[d] > s->count[d] ? nsites[d] : s->count[d]);
        if (larger > KN_MAX_COEFS / w->room)
            return kn_fail(ctx, KN_ELIMIT, "%s: more than %zu values", call, KN_MAX_COEFS);
        w->room *= larger;
        status = prepare_axis(ctx, w, d, s, nsites[d], sites[d], fixed);
    }
    for (int i = 0; i < 2 && status == KN_OK; i++) {
        w->buffer[i] = kn_scratch(ctx, w->room, sizeof *w->buffer[i]);
        if (!w->buffer[i]) status = KN_ENOMEM;
    }
    return status;
}

static size_t product(const int *n, int from, int to)
{
    size_t count = 1;
    for (int d = from; d < to; d++) count *= (size_t)n[d];
    return count;
}

// The values of a spline at the sites, in one of the buffers; the last variable first, so that the first grows last.
static double *at_sites(const problem *w, const double *coef, const int *count)
{
    int n[KN_MAX_VARS];
    const double *from = coef;
    for (int d = 0; d < w->nvars; d++) n[d] = count[d];
    for (int d = w->nvars - 1; d >= 0; d--) {
        double *to = w->buffer[from == w->buffer[0]];
        kn_band_apply(to, &w->basis[d], from, (size_t)w->dim * product(n, 0, d), n[d], product(n, d + 1, w->nvars));
        n[d] = w->axis[d].nsites;
        from = to;
    }
    return w->buffer[from == w->buffer[1]];
}

// The rows of A without the given columns: `width` numbers from column first[i] on.
static void free_rows(double *rows, int *first, const problem *w, int d, int width)
{
    const kn_band *basis = &w->basis[d];
    const double *values = basis->w;
    for (int i = 0; i < basis->rows; i++, rows += width, values += basis->width) {
        int at = basis->first[i] - w->first[d], start = at < 0 ? 0 : at;
        if (start > w->nfree[d] - 1) start = w->nfree[d] - 1;
        first[i] = start;
        for (int k = 0; k < width; k++) {
            int from = start + k - at;
            bool inside = from >= 0 && from < basis->width && start + k < w->nfree[d];
            rows[k] = inside ? values[from] : 0.0;
        }
    }
}

static kn_status solve_axis(kn_ctx *ctx, const problem *w, int d, double *x, double *data, size_t outer, size_t inner)
{
    int m = w->axis[d].nsites, n = w->nfree[d], width = w->basis[d].width;
    size_t step = (size_t)width, rows = (size_t)m * step;
    kn_mark mark = kn_scratch_mark(ctx);
    double *a = kn_scratch(ctx, rows, sizeof *a), *turn = kn_scratch(ctx, 2 * rows, sizeof *turn);
    double *r = kn_scratch(ctx, (size_t)n * step, sizeof *r);
    int *first = kn_scratch(ctx, (size_t)m, sizeof *first);
    kn_status status = a && turn && r && first ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        for (size_t i = 0; i < (size_t)n * step; i++) r[i] = 0.0;
        free_rows(a, first, w, d, width);
        for (size_t i = 0; i < (size_t)m; i++)
            kn_banded_turn_row(r, n, width, a + i * step, first[i], turn + 2 * i * step);
        for (int i = 0; i < n && status == KN_OK; i++) {
            double pivot = r[(size_t)i * step];
            if (!(pivot != 0.0 && isfinite(pivot)))
                status = kn_fail(ctx, KN_EUNDECIDED, "%s: variable %d: values of B-spline %d underflow", call, d,
                                 w->first[d] + i);
        }
    }
    for (size_t o = 0; o < outer && status == KN_OK; o++, x += (size_t)n * inner, data += (size_t)m * inner) {
        for (size_t i = 0; i < (size_t)n * inner; i++) x[i] = 0.0;
        for (size_t i = 0; i < (size_t)m; i++)
            kn_banded_turn_data(x, n, width, data + i * inner, first[i], turn + 2 * i * step, inner);
        kn_banded_back(r, n, width, x, inner);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// data: the values at the sites, less what the given control points contribute; in the end, in one of the two, the
// free control points.
static kn_status solve(kn_ctx *ctx, const problem *w, double **data, double *other)
{
    int n[KN_MAX_VARS];
    kn_status status = KN_OK;
    for (int d = 0; d < w->nvars; d++) n[d] = w->axis[d].nsites;
    for (int d = 0; d < w->nvars && status == KN_OK; d++) {
        status = solve_axis(ctx, w, d, other, *data, (size_t)w->dim * product(n, 0, d), product(n, d + 1, w->nvars));
        n[d] = w->nfree[d];
        double *result = other;
        other = *data, *data = result;
    }
    return status;
}

static double largest_distance(const double *a, const double *b, size_t n, int dim)
{
    double largest = 0.0;
    for (size_t i = 0; i < n; i++) {
        double sum = 0.0;
        for (size_t c = 0; c < (size_t)dim; c++) sum += (a[c * n + i] - b[c * n + i]) * (a[c * n + i] - b[c * n + i]);
        if (!(sum <= largest)) largest = sum; // NaN stays
    }
    return sqrt(largest);
}

static kn_status fit(kn_ctx *ctx, kn_spline *s, double *residual, const int *nsites, const double *const *sites,
                     const double *values, const kn_fit_fixed *fixed)
{
    problem w;
    kn_status status = prepare(ctx, &w, s, nsites, sites, fixed);
    if (status != KN_OK) return status;
    size_t n = product(nsites, 0, s->nvars);
    double *f = kn_scratch(ctx, n * (size_t)w.dim, sizeof *f);
    if (!f) return KN_ENOMEM;
    kn_fit_by_component(f, values, n, w.dim);
    kn_fit_put_fixed(s->coef, s->nvars, w.dim, s->count, fixed);
    double *data = at_sites(&w, s->coef, s->count), *other = w.buffer[data == w.buffer[0]];
    for (size_t i = 0; i < n * (size_t)w.dim; i++) data[i] = f[i] - data[i];
    status = solve(ctx, &w, &data, other);
    if (status != KN_OK) return status;
    kn_fit_put_free(s->coef, data, s->nvars, w.dim, s->count, fixed);
    *residual = largest_distance(at_sites(&w, s->coef, s->count), f, n, w.dim);
    return KN_OK;
}

kn_status kn_fit_least_squares(kn_ctx *ctx, kn_spline *out, double *residual, int nvars, int dim, const int *degree,
                               const int *count, const double *const *knots, const int *nsites,
                               const double *const *sites, const double *values, const kn_fit_fixed *fixed)
{
    kn_spline s;
    double found;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_fit_start(ctx, call, &s, nvars, dim, degree, count, knots);
    if (status == KN_OK) status = fit(ctx, &s, &found, nsites, sites, values, fixed);
    if (status == KN_OK) status = kn_spline_store(ctx, out, &s);
    if (status == KN_OK && residual) *residual = found;
    kn_scratch_release(ctx, mark);
    return status;
}
