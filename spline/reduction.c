// SPDX-License-Identifier: Apache-2.0
// Degree reduction along one variable, and its certified error.
//
// From degree p to q a break of multiplicity m keeps max(m - (p - q), 1) knots: the continuity stays. On the knots of
// the elevated result both sides have coefficients, c and E d; where c = E d within rounding d comes from the Bezier
// pieces, reduced exactly and joined; elsewhere d is the least squares solution with both ends kept.
#include "spline/reduction.h"

#include <math.h>
#include <string.h>

#include "bezier/norm_bound.h"
#include "kernel/context.h"
#include "kernel/reduce.h"
#include "spline/in_scratch.h"
#include "spline/removal.h"

typedef struct work {
    int p, q, nbreaks, count, fine; // count, fine: coefficients of the result and of its elevation
    size_t width;
    double *breaks;
    int *times;
    double *knots, *fine_knots; // of the result and of its elevation
    kn_band e;                  // the elevation
    kn_rows rows;               // of the operand
    double *c, *d;              // rows: the operand on fine_knots, the result
} work;

static kn_status make_knots(kn_ctx *ctx, work *w)
{
    const kn_rows *r = &w->rows;
    size_t nknots = (size_t)r->count + (size_t)r->degree + 1;
    w->breaks = kn_scratch(ctx, nknots, sizeof *w->breaks);
    w->times = kn_scratch(ctx, nknots, sizeof *w->times);
    w->knots = kn_scratch(ctx, nknots, sizeof *w->knots);
    if (!w->breaks || !w->times || !w->knots) return KN_ENOMEM;
    w->nbreaks = kn_knots_breaks(w->breaks, w->times, r->knots, w->p, r->count);
    for (int i = 0; i < w->nbreaks; i++) {
        w->times[i] -= w->p - w->q;
        if (w->times[i] < 1) w->times[i] = 1;
    }
    w->count = kn_knots_repeat(w->knots, w->breaks, w->times, w->nbreaks) - w->q - 1;
    kn_status status = kn_spline_elevation_band(ctx, &w->e, &w->fine_knots, w->knots, w->q, w->count, w->p);
    w->fine = status == KN_OK ? w->e.rows : 0;
    return status;
}

// out (rows of the knots `to`, in scratch) = the operand there.
static kn_status refined(kn_ctx *ctx, double **out, const kn_rows *r, const double *to, int rows)
{
    size_t width = r->lines * (size_t)r->ncomp;
    if ((size_t)rows > KN_MAX_COEFS / width) return kn_fail(ctx, KN_ELIMIT, "spline_reduce: %d rows", rows);
    *out = kn_scratch(ctx, (size_t)rows * width, sizeof **out);
    if (!*out) return KN_ENOMEM;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_band band;
    kn_status status = kn_spline_refining_band(ctx, &band, rows, r->degree + 1);
    if (status == KN_OK) {
        kn_band_refine(&band, r->knots, r->degree, r->count, to);
        kn_band_apply(*out, &band, r->row, 1, r->count, width);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// *joined (rows of the result) = the pieces of the operand, lowered one by one, joined.
static kn_status from_pieces(kn_ctx *ctx, double **joined, const work *w)
{
    int spans = w->nbreaks - 1, p = w->p, q = w->q;
    double *pieces = NULL, b[KN_MAX_DEGREE + 1], low[KN_MAX_DEGREE + 1];
    kn_band band;
    if ((size_t)w->nbreaks > KN_MAX_COEFS / (size_t)(p + 1))
        return kn_fail(ctx, KN_ELIMIT, "spline_reduce: %d breaks", w->nbreaks);
    *joined = kn_scratch(ctx, (size_t)w->count * w->width, sizeof **joined);
    double *to = kn_scratch(ctx, (size_t)w->nbreaks * (size_t)(p + 1), sizeof *to);
    if (!*joined || !to) return KN_ENOMEM;
    for (int i = 0; i < w->nbreaks * (p + 1); i++) to[i] = w->breaks[i / (p + 1)];
    kn_status status = refined(ctx, &pieces, &w->rows, to, spans * (p + 1));
    if (status == KN_OK) status = kn_spline_band(ctx, &band, w->count, q + 1);
    if (status != KN_OK) return status;
    for (int s = 0; s < spans; s++)
        for (size_t k = 0; k < w->width; k++) {
            for (int i = 0; i <= p; i++) b[i] = pieces[(size_t)(s * (p + 1) + i) * w->width + k];
            kn_bernstein_lower(low, q, b, p);
            for (int i = 0; i <= q; i++) pieces[(size_t)(s * (q + 1) + i) * w->width + k] = low[i]; // q < p
        }
    kn_band_join(&band, w->breaks, w->nbreaks, q, w->knots);
    kn_band_apply(*joined, &band, pieces, 1, spans * (q + 1), w->width);
    return KN_OK;
}

// Line by line the joined pieces replace the least squares solution where their elevation is the operand but for
// rounding; *same: everywhere, and bit for bit.
static kn_status restore_lines(kn_ctx *ctx, work *w, bool *same)
{
    double *joined = NULL, *back;
    kn_status status = from_pieces(ctx, &joined, w);
    if (status != KN_OK) return status;
    back = kn_scratch(ctx, (size_t)w->fine * w->width, sizeof *back);
    if (!back) return KN_ENOMEM;
    kn_band_apply(back, &w->e, joined, 1, w->count, w->width);
    double allowed = kn_gamma_up(32.0 * (w->p + 4));
    for (size_t k = 0; k < w->width; k++) {
        double misfit = 0.0, most = 0.0;
        for (size_t i = k; i < (size_t)w->fine * w->width; i += w->width) {
            double off = fabs(back[i] - w->c[i]);
            if (off > misfit || isnan(off)) misfit = off;
            most = fmax(most, fabs(w->c[i]));
        }
        if (misfit != 0.0) *same = false;
        if (!(misfit <= allowed * most)) continue;
        for (size_t i = k; i < (size_t)w->count * w->width; i += w->width) w->d[i] = joined[i];
    }
    return KN_OK;
}

static kn_status solve(kn_ctx *ctx, work *w, bool *same)
{
    kn_projection p;
    size_t room = kn_projection_room(w->fine, w->count, w->e.width);
    w->d = kn_scratch(ctx, (size_t)w->count * w->width, sizeof *w->d);
    if (!w->d) return KN_ENOMEM;
    kn_status status = refined(ctx, &w->c, &w->rows, w->fine_knots, w->fine);
    double *memory = status == KN_OK ? kn_scratch(ctx, room + w->width, sizeof *memory) : NULL;
    if (!memory) return status == KN_OK ? KN_ENOMEM : status;
    kn_projection_factor(&p, &w->e, w->count, w->q > 0, memory + w->width);
    if (w->q > 0) {
        memcpy(w->d, w->c, w->width * sizeof *w->d);
        memcpy(w->d + (size_t)(w->count - 1) * w->width, w->c + (size_t)(w->fine - 1) * w->width,
               w->width * sizeof *w->d);
    }
    kn_projection_solve(&p, w->d, w->c, w->width, memory);
    if (w->fine != w->rows.count) *same = false;
    return restore_lines(ctx, w, same);
}

kn_status kn_spline_reduce_axis(kn_ctx *ctx, kn_spline *s, bool *same, int var, int q)
{
    work w = {.p = s->degree[var], .q = q};
    kn_status status = kn_rows_of(ctx, &w.rows, s, var);
    if (status != KN_OK) return status;
    w.width = w.rows.lines * (size_t)w.rows.ncomp;
    status = make_knots(ctx, &w);
    if (status == KN_OK) status = solve(ctx, &w, same);
    if (status != KN_OK) return status;
    kn_rows low = w.rows;
    low.degree = q, low.count = w.count, low.knots = w.knots, low.row = w.d;
    return kn_rows_to(ctx, s, var, &low);
}

static void add(kn_parts *rounding, double operations, const kn_spline *s)
{
    kn_parts_add(rounding, kn_gamma_up(operations), s->coef, kn_spline_count(s), s->ncomp, s->rational);
}

// *d = a - low on the grid of both; *rounding: of each component, its way to Bezier pieces included.
static kn_status difference(kn_ctx *ctx, kn_spline *d, kn_parts *rounding, const kn_spline *a, const kn_spline *low)
{
    kn_spline f = *a, g = *low;
    kn_status status = KN_OK;
    double rises = 0.0, refinements = 1.0;
    for (int v = a->nvars - 1; v >= 0 && status == KN_OK; v--) {
        int p = a->degree[v];
        for (int k = g.degree[v]; k < p; k++) rises += 7.0 * k + 4.0;
        refinements += 6.0 * p + 3.0;
        status = kn_spline_elevate_in_scratch(ctx, &g, v, p);
        if (status == KN_OK) status = kn_spline_unite_in_scratch(ctx, &g, v, a->knots[v], a->count[v] + p + 1);
        if (status == KN_OK) status = kn_spline_unite_in_scratch(ctx, &f, v, g.knots[v], g.count[v] + p + 1);
    }
    if (status != KN_OK) return status;
    size_t n = kn_spline_count(&f) * (size_t)f.ncomp;
    *d = f;
    d->coef = kn_scratch(ctx, n, sizeof *d->coef);
    if (!d->coef) return KN_ENOMEM;
    for (size_t i = 0; i < n; i++) d->coef[i] = f.coef[i] - g.coef[i];
    *rounding = (kn_parts){0.0, 0.0};
    add(rounding, refinements, a);
    add(rounding, rises + refinements, low);
    add(rounding, refinements, d);
    return KN_OK;
}

static kn_status split(kn_ctx *ctx, kn_spline *d, int var)
{
    int p = d->degree[var], n = kn_knots_breaks(NULL, NULL, d->knots[var], p, d->count[var]);
    if ((size_t)n > KN_MAX_COEFS / (size_t)(p + 1)) return kn_fail(ctx, KN_ELIMIT, "spline_reduce: %d breaks", n);
    double *breaks = kn_scratch(ctx, (size_t)n, sizeof *breaks);
    double *to = kn_scratch(ctx, (size_t)n * (size_t)(p + 1), sizeof *to);
    if (!breaks || !to) return KN_ENOMEM;
    kn_knots_breaks(breaks, NULL, d->knots[var], p, d->count[var]);
    for (int i = 0; i < n * (p + 1); i++) to[i] = breaks[i / (p + 1)];
    return kn_spline_refine_in_scratch(ctx, d, var, to, (n - 1) * (p + 1));
}

// The bound of all pieces.
static kn_status look_at_pieces(kn_ctx *ctx, double *bound, const kn_spline *d, double radius)
{
    kn_bezier piece = {.nvars = d->nvars, .ncomp = d->ncomp};
    int first[KN_MAX_VARS] = {0};
    double least = 0.0;
    memcpy(piece.degree, d->degree, sizeof piece.degree);
    kn_status status = kn_bezier_scratch(ctx, &piece, "reduce");
    for (int v = 0; v >= 0 && status == KN_OK;) {
        kn_spline_get_piece(&piece, d, first);
        status = kn_bezier_norm_bound(ctx, bound, &least, &piece, radius);
        for (v = d->nvars - 1; v >= 0; v--) {
            if ((first[v] += d->degree[v] + 1) < d->count[v]) break;
            first[v] = 0;
        }
    }
    return status;
}

kn_status kn_spline_reduction_error(kn_ctx *ctx, double *error, const kn_spline *a, const kn_spline *low)
{
    kn_spline d;
    kn_deviation v;
    kn_parts rounding;
    double bound = 0.0;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = difference(ctx, &d, &rounding, a, low);
    if (status == KN_OK) {
        if (kn_deviation_of(&v, d.coef, kn_spline_count(&d), a->ncomp, a->rational, a->coef, kn_spline_count(a),
                            low->coef, kn_spline_count(low))) {
            for (int k = a->nvars - 1; k >= 0 && status == KN_OK; k--) status = split(ctx, &d, k);
            if (status == KN_OK) status = look_at_pieces(ctx, &bound, &d, v.radius);
            *error = kn_deviation_bound(&v, bound, &rounding, a->ncomp);
        } else {
            *error = INFINITY;
        }
    }
    kn_scratch_release(ctx, mark);
    return status;
}
