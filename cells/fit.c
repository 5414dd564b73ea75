// SPDX-License-Identifier: Apache-2.0
// A polynomial for each cell that stands for S(map): interpolation, then a bound.
#include "cells/fit.h"
#include "cells/internal.h"
#include "kernel/context.h"
#include "kernel/knots.h"

#include <knurl/fit.h>
#include <math.h>

enum { LEAST = 3, MOST = 7, PLACES = 3 };

typedef struct fitting {
    const kn_spline *surface, *map;
    double *lines[2]; // distinct knots of map, in scratch
    int *smooth[2];   // how often the fit is differentiable across each
    int n[2];         // cells
} fitting;

// ---- what is to be fitted ----

static kn_status check(kn_ctx *ctx, const kn_spline *surface, const kn_spline *map, double tolerance)
{
    kn_status status = kn_cells_expect(ctx, "fit", surface);
    if (status == KN_OK) status = kn_cells_expect_map(ctx, "fit", surface, map);
    if (status != KN_OK) return status;
    if (!(tolerance > 0.0)) return kn_fail(ctx, KN_EDOMAIN, "fit: tolerance %g", tolerance);
    for (int d = 0; d < 2; d++) {
        int p = surface->degree[d];
        for (int i = p + 1; i + p < surface->count[d]; i++)
            if (surface->knots[d][i] == surface->knots[d][i + p])
                return kn_fail(ctx, KN_EDOMAIN, "fit: the surface jumps at %g in variable %d", surface->knots[d][i],
                               d);
    }
    return KN_OK;
}

// How often S is differentiable across the image of line i of variable d, when that is a knot line of S: all
// coefficients of the map there are the knot, but for rounding. Otherwise 2, all that is asked for.
static kn_status smooth_across(kn_ctx *ctx, int *smooth, const fitting *f, int d, int i)
{
    const kn_spline *s = f->surface;
    kn_spline line = {0};
    kn_status status = kn_spline_isoparametric(ctx, &line, f->map, d, f->lines[d][i]);
    if (status != KN_OK) return status;
    size_t n = kn_spline_count(&line);
    const double *at = line.coef + (size_t)d * n;
    double lo = at[0], hi = at[0];
    for (size_t k = 1; k < n; k++) lo = fmin(lo, at[k]), hi = fmax(hi, at[k]);
    double slack = 0x1p-44 * fmax(fabs(lo), fabs(hi)) + 0x1p-1000;
    int p = s->degree[d];
    *smooth = 2;
    for (int k = p + 1, times = 1; k < s->count[d]; k += times) {
        double knot = s->knots[d][k];
        for (times = 1; s->knots[d][k + times] == knot;) times++;
        if (knot >= lo - slack && knot <= hi + slack && hi - lo <= slack) *smooth = p - times < 2 ? p - times : 2;
    }
    kn_spline_clear(ctx, &line);
    return KN_OK;
}

static kn_status make_lines(kn_ctx *ctx, fitting *f)
{
    for (int d = 0; d < 2; d++) {
        const kn_spline *m = f->map;
        int room = kn_spline_spans(m, d) + 1, *times = kn_scratch(ctx, (size_t)room, sizeof *times);
        f->lines[d] = kn_scratch(ctx, (size_t)room, sizeof *f->lines[d]);
        f->smooth[d] = kn_scratch(ctx, (size_t)room, sizeof *f->smooth[d]);
        if (!times || !f->lines[d] || !f->smooth[d]) return KN_ENOMEM;
        f->n[d] = kn_knots_breaks(f->lines[d], times, m->knots[d], m->degree[d], m->count[d]) - 1;
        for (int i = 1; i < f->n[d]; i++) {
            int own = m->degree[d] - times[i];
            kn_status status = own > 0 ? smooth_across(ctx, &f->smooth[d][i], f, d, i) : KN_OK;
            if (status != KN_OK) return status;
            if (own <= 0) f->smooth[d][i] = 0;
            if (f->smooth[d][i] > own) f->smooth[d][i] = own;
        }
    }
    return KN_OK;
}

// ---- S(map) on a grid ----

// values[(i * n[1] + j) * 3 + c] at the parameters at[0] x at[1] of the map.
static kn_status values_on_grid(kn_ctx *ctx, double *values, const fitting *f, const size_t n[2],
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

// out: of these degrees, on the lines, through S(map) at its Greville sites.
static kn_status interpolate(kn_ctx *ctx, kn_spline *out, const fitting *f, const int degree[2])
{
    kn_mark mark = kn_scratch_mark(ctx);
    double *knots[2], *sites[2], *values = NULL;
    int count[2] = {0, 0};
    size_t n[2];
    kn_status status = KN_OK;
    for (int d = 0; status == KN_OK && d < 2; d++) {
        size_t room = ((size_t)f->n[d] + 1) * ((size_t)degree[d] + 1), k = 0;
        knots[d] = kn_scratch(ctx, room, sizeof *knots[d]);
        sites[d] = kn_scratch(ctx, room, sizeof *sites[d]);
        if (!knots[d] || !sites[d]) status = KN_ENOMEM;
        for (int i = 0; status == KN_OK && i <= f->n[d]; i++) {
            int times = i == 0 || i == f->n[d] ? degree[d] + 1 : degree[d] - f->smooth[d][i];
            while (times-- > 0) knots[d][k++] = f->lines[d][i];
        }
        count[d] = (int)k - degree[d] - 1, n[d] = (size_t)count[d];
        if (status == KN_OK) status = kn_fit_greville(ctx, sites[d], knots[d], degree[d], count[d]);
    }
    if (status == KN_OK) values = kn_scratch(ctx, n[0] * n[1], 3 * sizeof *values);
    if (status == KN_OK && !values) status = KN_ENOMEM;
    const double *const at[2] = {sites[0], sites[1]}, *const on[2] = {knots[0], knots[1]};
    if (status == KN_OK) status = values_on_grid(ctx, values, f, n, at);
    if (status == KN_OK) status = kn_fit_interpolate(ctx, out, 2, 3, degree, count, on, at, values);
    kn_scratch_release(ctx, mark);
    return status;
}

// The largest distance at PLACES x PLACES parameters of each cell.
static kn_status sample(kn_ctx *ctx, double *most, const kn_spline *out, const fitting *f)
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

static kn_status try_degrees(kn_ctx *ctx, kn_spline *out, double *sampled, const fitting *f, const int degree[2])
{
    kn_status status = interpolate(ctx, out, f, degree);
    return status == KN_OK ? sample(ctx, sampled, out, f) : status;
}

// One degree more in the variable that gains most by it; *more is false where both are at their limit.
static kn_status raise_degree(kn_ctx *ctx, kn_spline *fit, double *sampled, int degree[2], bool *more,
                              const fitting *f)
{
    kn_spline best = {0}, other = {0};
    int chosen = -1;
    double least = INFINITY, here;
    kn_status status = KN_OK;
    for (int d = 0; status == KN_OK && d < 2; d++) {
        if (degree[d] == MOST) continue;
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

kn_status kn_cells_fit(kn_ctx *ctx, kn_spline *out, double *error, const kn_spline *surface, const kn_spline *map,
                       double tolerance)
{
    kn_status status = check(ctx, surface, map, tolerance);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    fitting f = {.surface = surface, .map = map};
    kn_spline fit = {0};
    kn_piece_grid s = {.npieces = 0}, m = {.npieces = 0};
    double sampled = 0.0, bound = INFINITY;
    int degree[2] = {LEAST, LEAST};
    bool more = true;
    status = make_lines(ctx, &f);
    if (status == KN_OK) status = kn_piece_grid_init(ctx, &s, surface);
    if (status == KN_OK) status = kn_piece_grid_init(ctx, &m, map);
    if (status == KN_OK) status = try_degrees(ctx, &fit, &sampled, &f, degree);
    while (status == KN_OK) {
        bound = INFINITY;
        if (sampled <= tolerance) status = kn_cells_fit_bound(ctx, &bound, &fit, &s, &m, sampled);
        if (status == KN_OK && bound > tolerance) status = raise_degree(ctx, &fit, &sampled, degree, &more, &f);
        if (bound <= tolerance || !more) break;
    }
    if (status == KN_OK && !(bound <= tolerance))
        status = kn_fail(ctx, KN_EUNDECIDED,
                         "fit: %g in degrees %d and %d, and not the tolerance %g; more cells help",
                         fmin(bound, sampled), degree[0], degree[1], tolerance);
    if (status == KN_OK) {
        kn_spline_swap(out, &fit);
        if (error) *error = bound;
    }
    kn_piece_grid_clear(ctx, &s), kn_piece_grid_clear(ctx, &m);
    kn_spline_clear(ctx, &fit);
    kn_scratch_release(ctx, mark);
    return status;
}
