// SPDX-License-Identifier: Apache-2.0
// A polynomial for each cell that stands for S(map): interpolation, then a bound.
#include "cells/fit.h"
#include "cells/internal.h"
#include "kernel/context.h"

#include <knurl/fit.h>
#include <math.h>

enum { LEAST = 3, MOST = 7, PLACES = 3, WRAP = 16 };

// ---- what is to be fitted ----

static kn_status check(kn_ctx *ctx, const kn_spline *surface, const kn_spline *map, const kn_cells_fit_options *o)
{
    kn_status status = kn_cells_expect(ctx, "fit", surface);
    if (status == KN_OK) status = kn_cells_expect_map(ctx, "fit", surface, map);
    if (status != KN_OK) return status;
    if (!(o->tolerance > 0.0)) return kn_fail(ctx, KN_EDOMAIN, "fit: tolerance %g", o->tolerance);
    if (!(o->at_most >= 0.0)) return kn_fail(ctx, KN_EDOMAIN, "fit: at most %g", o->at_most);
    if (o->degree_sum != 0 && o->degree_sum < 2 * LEAST)
        return kn_fail(ctx, KN_EDOMAIN, "fit: degrees of a sum of %d, at least %d", o->degree_sum, 2 * LEAST);
    for (int d = 0; d < 2; d++) {
        int p = surface->degree[d];
        for (int i = p + 1; i + p < surface->count[d]; i++)
            if (surface->knots[d][i] == surface->knots[d][i + p])
                return kn_fail(ctx, KN_EDOMAIN, "fit: the surface jumps at %g in variable %d", surface->knots[d][i],
                               d);
    }
    return KN_OK;
}

// ---- S(map) on a grid ----

// values[(i * n[1] + j) * 3 + c] at the parameters at[0] x at[1] of the map.
static kn_status values_on_grid(kn_ctx *ctx, double *values, const kn_cells_target *f, const size_t n[2],
                                const double *const at[2])
{
    kn_mark mark = kn_scratch_mark(ctx);
    double *uv = kn_scratch(ctx, n[0] * n[1], 2 * sizeof *uv);
    kn_status status = uv ? kn_spline_eval_grid(ctx, uv, f->map, n, at) : KN_ENOMEM;
    for (int d = 0; status == KN_OK && d < 2; d++) { // rounding takes nothing out of the domain
        double lo, hi;
        kn_spline_domain(f->surface, d, &lo, &hi);
        for (size_t k = (size_t)d; k < 2 * n[0] * n[1]; k += 2) uv[k] = fmin(fmax(uv[k], lo), hi);
    }
    if (status == KN_OK) status = kn_spline_eval_batch(ctx, values, f->surface, n[0] * n[1], uv);
    kn_scratch_release(ctx, mark);
    return status;
}

// One variable of the fit: its knots, and the Greville sites. A closed one goes on for `wrap` cells at both ends.
typedef struct axis {
    int wrap, degree, count;
    double *knots, *sites;
    double *at; // the sites, taken back into the map's domain
} axis;

static kn_status make_axis(kn_ctx *ctx, axis *a, const kn_cells_target *f, int d, int degree)
{
    int n = f->n[d], wrap = f->closed[d] ? WRAP : 0, k = 0;
    size_t room = ((size_t)n + 2 * (size_t)wrap + 1) * ((size_t)degree + 1);
    double *all = kn_scratch(ctx, 3 * room, sizeof *all), first = f->lines[d][0], last = f->lines[d][n];
    if (!all) return KN_ENOMEM;
    *a = (axis){.wrap = wrap, .degree = degree, .knots = all, .sites = all + room, .at = all + 2 * room};
    for (int i = -wrap; i <= n + wrap; i++) {
        int periods = i < 0 ? -((n - 1 - i) / n) : i > n ? (i - 1) / n : 0, of = i - periods * n;
        bool end = i == -wrap || i == n + wrap;
        double line = f->lines[d][of] + periods * (last - first);
        for (int times = end ? degree + 1 : degree - f->smooth[d][of]; times > 0; times--) a->knots[k++] = line;
    }
    a->count = k - degree - 1;
    kn_status status = kn_fit_greville(ctx, a->sites, a->knots, degree, a->count);
    for (int i = 0; status == KN_OK && i < a->count; i++) {
        double x = a->sites[i], periods = x < first || x > last ? floor((x - first) / (last - first)) : 0.0;
        a->at[i] = fmin(fmax(x - periods * (last - first), first), last);
    }
    return status;
}

// The two edges across a closed variable become one, bit for bit.
static void close_edges(kn_spline *s, int d)
{
    size_t inner = d == 0 ? (size_t)s->count[1] : 1, n = (size_t)s->count[d],
           outer = d == 0 ? 3 : 3 * (size_t)s->count[0];
    for (size_t o = 0; o < outer; o++)
        for (size_t k = 0; k < inner; k++) s->coef[(o * n + n - 1) * inner + k] = s->coef[o * n * inner + k];
}

// out: of these degrees, on the lines, through S(map) at its Greville sites.
static kn_status interpolate(kn_ctx *ctx, kn_spline *out, const kn_cells_target *f, const int degree[2])
{
    kn_mark mark = kn_scratch_mark(ctx);
    axis a[2];
    double *values = NULL, lo[2], hi[2];
    kn_status status = KN_OK;
    for (int d = 0; d < 2 && status == KN_OK; d++) {
        status = make_axis(ctx, &a[d], f, d, degree[d]);
        lo[d] = f->lines[d][0], hi[d] = f->lines[d][f->n[d]];
    }
    if (status == KN_OK) {
        const size_t n[2] = {(size_t)a[0].count, (size_t)a[1].count};
        const double *const on[2] = {a[0].knots, a[1].knots}, *const sites[2] = {a[0].sites, a[1].sites};
        values = kn_scratch(ctx, n[0] * n[1], 3 * sizeof *values);
        status = values ? values_on_grid(ctx, values, f, n, (const double *const[]){a[0].at, a[1].at}) : KN_ENOMEM;
        const int count[2] = {a[0].count, a[1].count};
        if (status == KN_OK) status = kn_fit_interpolate(ctx, out, 2, 3, degree, count, on, sites, values);
        if (status == KN_OK && (f->closed[0] || f->closed[1])) status = kn_spline_restrict(ctx, out, out, lo, hi);
        for (int d = 0; d < 2 && status == KN_OK; d++)
            if (f->closed[d]) close_edges(out, d);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// The largest distance at PLACES x PLACES parameters of each cell.
static kn_status sample(kn_ctx *ctx, double *most, const kn_spline *out, const kn_cells_target *f)
{
    static const double places[PLACES] = {0.13, 0.5, 0.83};
    kn_mark mark = kn_scratch_mark(ctx);
    double *at[2];
    size_t n[2];
    for (int d = 0; d < 2; d++) {
        n[d] = PLACES * (size_t)f->n[d];
        at[d] = kn_scratch(ctx, n[d], sizeof *at[d]);
        for (size_t k = 0; at[d] && k < n[d]; k++) {
            const double *line = f->lines[d] + k / PLACES;
            at[d][k] = line[0] + places[k % PLACES] * (line[1] - line[0]);
        }
    }
    double *want = kn_scratch(ctx, n[0] * n[1], 6 * sizeof *want), *got = want ? want + 3 * n[0] * n[1] : NULL;
    kn_status status = at[0] && at[1] && want ? KN_OK : KN_ENOMEM;
    const double *const on[2] = {at[0], at[1]};
    if (status == KN_OK) status = values_on_grid(ctx, want, f, n, on);
    if (status == KN_OK) status = kn_spline_eval_grid(ctx, got, out, n, on);
    *most = 0.0;
    for (size_t k = 0; status == KN_OK && k < n[0] * n[1]; k++) {
        double x = got[3 * k] - want[3 * k], y = got[3 * k + 1] - want[3 * k + 1],
               z = got[3 * k + 2] - want[3 * k + 2];
        double distance = sqrt(x * x + y * y + z * z);
        *most = distance > *most || isnan(distance) ? distance : *most;
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// ---- degrees ----

static kn_status try_degrees(kn_ctx *ctx, kn_spline *out, double *sampled, const kn_cells_target *f,
                             const int degree[2])
{
    kn_status status = interpolate(ctx, out, f, degree);
    return status == KN_OK ? sample(ctx, sampled, out, f) : status;
}

// One degree more in the variable that gains most by it; *more is false where they are at their limit.
static kn_status raise_degree(kn_ctx *ctx, kn_spline *fit, double *sampled, int degree[2], bool *more, int degree_sum,
                              const kn_cells_target *f)
{
    kn_spline best = {0}, other = {0};
    int chosen = -1;
    double least = INFINITY, here;
    kn_status status = KN_OK;
    for (int d = 0; status == KN_OK && d < 2; d++) {
        if (degree[d] == MOST || degree[0] + degree[1] == degree_sum) continue;
        int raised[2] = {degree[0], degree[1]};
        raised[d]++;
        status = try_degrees(ctx, &other, &here, f, raised);
        if (status != KN_OK || (chosen >= 0 && !(here < least))) continue;
        kn_spline_swap(&best, &other);
        chosen = d, least = here;
    }
    if (status == KN_OK && chosen >= 0) {
        kn_spline_swap(fit, &best);
        *sampled = least, degree[chosen]++;
    }
    if (status == KN_OK) *more = chosen >= 0;
    kn_spline_clear(ctx, &best), kn_spline_clear(ctx, &other);
    return status;
}

// The lowest degrees that meet the tolerance, or the last ones tried; *bound of what is in fit, INFINITY for none.
static kn_status search(kn_ctx *ctx, kn_spline *fit, double *bound, double *sampled, int degree[2],
                        const kn_cells_target *f, const kn_cells_fit_options *o)
{
    bool more = true;
    kn_status status = try_degrees(ctx, fit, sampled, f, degree);
    while (status == KN_OK) {
        *bound = INFINITY;
        if (*sampled <= o->tolerance) status = kn_cells_fit_bound(ctx, bound, fit, &f->s, &f->m, *sampled);
        if (status == KN_OK && *bound > o->tolerance)
            status = raise_degree(ctx, fit, sampled, degree, &more, o->degree_sum, f);
        if (*bound <= o->tolerance || !more) break;
    }
    if (status == KN_OK && isinf(*bound) && *sampled <= o->at_most)
        status = kn_cells_fit_bound(ctx, bound, fit, &f->s, &f->m, *sampled);
    return status;
}

static kn_status not_met(kn_ctx *ctx, double bound, double sampled, const int degree[2], double most)
{
    if (sampled > most)
        return kn_fail(ctx, KN_EUNDECIDED,
                       "fit: a distance of %g occurs in degrees %d and %d, beyond the tolerance %g; more cells help",
                       sampled, degree[0], degree[1], most);
    return kn_fail(ctx, KN_EUNDECIDED,
                   "fit: certainly within %g in degrees %d and %d (%g occurs), but not within the tolerance %g; more "
                   "cells help",
                   bound, degree[0], degree[1], sampled, most);
}

kn_status kn_cells_fit(kn_ctx *ctx, kn_spline *out, double *error, const kn_spline *surface, const kn_spline *map,
                       const kn_cells_fit_options *options)
{
    kn_status status = check(ctx, surface, map, options);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_cells_target f;
    kn_spline fit = {0};
    double sampled = 0.0, bound = INFINITY, most = fmax(options->tolerance, options->at_most);
    int degree[2] = {LEAST, LEAST};
    status = kn_cells_target_init(ctx, &f, surface, map);
    if (status == KN_OK) status = search(ctx, &fit, &bound, &sampled, degree, &f, options);
    if (status == KN_OK && !(bound <= most)) status = not_met(ctx, bound, sampled, degree, most);
    if (status == KN_OK) {
        kn_spline_swap(out, &fit);
        if (error) *error = bound;
    }
    kn_cells_target_clear(ctx, &f);
    kn_spline_clear(ctx, &fit);
    kn_scratch_release(ctx, mark);
    return status;
}
