// SPDX-License-Identifier: Apache-2.0
// The box of a spline over a part of its domain, or over a box beyond it: of its coefficients there.
#include <math.h>

#include "bezier/bounds.h"
#include "kernel/bounds.h"
#include "kernel/context.h"
#include "spline/internal.h"

static kn_status check_box(kn_ctx *ctx, const kn_spline *s, const double *lo, const double *hi)
{
    kn_status status = kn_spline_expect(ctx, "spline_box_over", s, 0);
    for (int d = 0; d < s->nvars && status == KN_OK; d++)
        if (!isfinite(lo[d]) || !isfinite(hi[d]) || lo[d] > hi[d])
            status = kn_fail(ctx, KN_EDOMAIN, "spline_box_over: [%g, %g] in variable %d", lo[d], hi[d], d);
    return status;
}

// The knots of the restriction, rows + degree + 1 of them. Where it ends in a jump the value there is that of the
// piece to the right: one coefficient more. A single point: one coefficient.
static int restricted_knots(double *to, const kn_spline *s, int var, double lo, double hi)
{
    int p = s->degree[var], n = 0, jump = 0;
    for (int k = 0; k <= p; k++) to[n++] = lo;
    for (int i = p + 1; i < s->count[var]; i++) {
        double t = s->knots[var][i];
        if (t > lo && t < hi) to[n++] = t;
        jump += t == hi;
    }
    if (lo < hi)
        for (int k = 0; k < p; k++) to[n++] = hi;
    to[n++] = hi;
    if (lo < hi && jump > p) to[n++] = hi;
    return n - p - 1;
}

typedef struct restriction {
    double *coef, *size; // size: what roundings are relative to
    double roundings, growth;
} restriction;

static double *map(kn_ctx *ctx, const kn_band *band, const double *from, const kn_spline *shape, int var)
{
    size_t outer = kn_spline_outer(shape, var), inner = kn_spline_inner(shape, var);
    double *to = kn_scratch(ctx, outer * (size_t)band->rows * inner, sizeof *to);
    if (to) kn_band_apply(to, band, from, outer, shape->count[var], inner);
    return to;
}

// The coefficients are polar forms of the pieces; shape->count follows.
static kn_status restrict_variable(kn_ctx *ctx, restriction *r, kn_spline *shape, int var, double lo, double hi)
{
    int p = shape->degree[var], count = shape->count[var];
    const double *knots = shape->knots[var];
    kn_band band;
    double *to = kn_scratch(ctx, (size_t)count + (size_t)p + 2, sizeof *to);
    if (!to) return KN_ENOMEM;
    kn_status status = kn_spline_band(ctx, &band, restricted_knots(to, shape, var, lo, hi), p + 1);
    if (status != KN_OK) return status;
    for (int size = 0; size < 2; size++) {
        for (int j = 0; j < band.rows && (size == 0 || lo < knots[0] || hi > knots[count]); j++) {
            int s = kn_knots_span(knots, p, count, to[j]);
            double *row = band.w + (size_t)j * (size_t)(p + 1);
            band.first[j] = s - p;
            if (size == 0)
                kn_knots_blossom(row, knots, p, s, to + j + 1);
            else
                kn_knots_blossom_size(row, knots, p, s, to + j + 1);
        }
        double **from = size == 0 ? &r->coef : &r->size;
        *from = map(ctx, &band, *from, shape, var);
        if (!*from) return KN_ENOMEM;
    }
    r->roundings += 6.0 * p + 1.0;
    r->growth *= fmax(1.0, kn_row_growth(band.w, band.rows, p + 1));
    shape->count[var] = band.rows;
    return KN_OK;
}

static kn_status restrict_all(kn_ctx *ctx, kn_hull *out, const kn_spline *s, const double *lo, const double *hi)
{
    size_t all = kn_spline_count(s) * (size_t)s->ncomp;
    restriction r = {.coef = s->coef, .growth = 1.0};
    double most = 0.0;
    r.size = kn_scratch(ctx, all, sizeof *r.size);
    if (!r.size) return KN_ENOMEM;
    for (size_t i = 0; i < all; i++) {
        r.size[i] = fabs(s->coef[i]);
        most = r.size[i] > most ? r.size[i] : most;
    }
    kn_spline shape = *s;
    bool whole = true;
    for (int d = 0; d < s->nvars; d++) {
        double from, to;
        kn_spline_domain(s, d, &from, &to);
        if (lo[d] == from && hi[d] == to) continue;
        kn_status status = restrict_variable(ctx, &r, &shape, d, lo[d], hi[d]);
        if (status != KN_OK) return status;
        whole = false;
    }
    out->n = kn_spline_count(&shape);
    out->coef = r.coef, out->error = whole ? NULL : r.size;
    if (!whole) kn_hull_errors(r.size, out->n * (size_t)s->ncomp, r.roundings, 0x1p-1040 * r.growth * (1.0 + most));
    return KN_OK;
}

kn_status kn_spline_box_over(kn_ctx *ctx, double *box_lo, double *box_hi, const kn_spline *s, const double *lo,
                             const double *hi)
{
    kn_hull hull;
    kn_status status = check_box(ctx, s, lo, hi);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    status = restrict_all(ctx, &hull, s, lo, hi);
    if (status == KN_OK)
        status = kn_hull_box(ctx, "spline_box_over", box_lo, box_hi, &hull, kn_spline_dim(s), s->rational);
    kn_scratch_release(ctx, mark);
    return status;
}
