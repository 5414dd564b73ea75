// SPDX-License-Identifier: Apache-2.0
// A surface of the tile over several knot boxes: all of it, composed with the piece of each box, trimmed along the
// preimages of the knot lines.
#include "job/cross.h"

#include <math.h>

// A trim is no coarser than this in (u, v) of a cell, smooth as the base may be.
#define COARSEST 0x1p-8
#define FINEST 0x1p-40

// *error: by how much the pieces on the two sides of lines differ, within delta of them.
static kn_status find_error(kn_ctx *ctx, double *error, const kn_crossing *x, double delta)
{
    *error = 0.0;
    for (int var = 0; var < 2; var++)
        for (int i = 0; i <= x->n[0] - (var == 0); i++)
            for (int j = 0; j <= x->n[1] - (var == 1); j++) {
                double gap;
                kn_status status = kn_crossing_gap(ctx, &gap, x, var, i, j, delta);
                if (status != KN_OK) return status;
                *error = fmax(*error, gap);
            }
    // where lines meet, so do four pieces: two steps from one to the one across
    *error *= x->n[0] > 0 && x->n[1] > 0 ? 2.0 : 1.0;
    return KN_OK;
}

// *delta = a power of two for which that is no more than the tolerance.
static kn_status choose_delta(kn_ctx *ctx, double *delta, double *error, const kn_crossing *x, double tol)
{
    for (*delta = COARSEST;; *delta /= 4.0) {
        kn_status status = find_error(ctx, error, x, *delta);
        if (status != KN_OK || *error <= tol || *delta <= FINEST) return status;
    }
}

// f over the patch, and its slope.
static kn_status function_of(kn_ctx *ctx, kn_bezier *f, double *slope, const kn_crossing *x, const double line[3])
{
    double rise[2];
    size_t n = kn_bezier_count(x->d);
    kn_status status = kn_bezier_components(ctx, f, x->d, 0, 1);
    for (size_t i = 0; status == KN_OK && i < n; i++) {
        double u = x->d->coef[i], v = x->d->coef[n + i]; // exact where one coordinate does not count
        f->coef[i] = line[1] == 0.0   ? line[0] * u + line[2]
                     : line[0] == 0.0 ? line[1] * v + line[2]
                                      : line[0] * u + line[1] * v + line[2];
    }
    if (status == KN_OK) status = kn_bezier_lipschitz(ctx, rise, f);
    if (status == KN_OK) *slope = fmax(hypot(rise[0], rise[1]), 1e-300);
    return status;
}

kn_status kn_cross_cut_by(kn_ctx *ctx, kn_trim *below, kn_trim *above, kn_trim_cut_report *report,
                          const kn_crossing *x, const kn_trim *region, const double line[3], double delta)
{
    kn_bezier f = {0};
    double slope = 1.0;
    kn_status status = function_of(ctx, &f, &slope, x, line);
    double tol = fmin(0.02, 0.5 * delta / slope);
    for (int k = 0; status == KN_OK && k < 8; k++, tol /= 4.0) {
        status = kn_trim_cut(ctx, below, above, report, region, &f, tol);
        if (status != KN_OK || report->residual <= delta) break;
    }
    if (status == KN_OK && !(report->residual <= delta))
        status = kn_fail(ctx, KN_EUNDECIDED,
                         "job: a trim along a knot line or border is off by %g cells; %g are allowed",
                         report->residual, delta);
    kn_bezier_clear(ctx, &f);
    return status;
}

kn_status kn_cross_cut(kn_ctx *ctx, kn_trim *below, kn_trim *rest, kn_trim_cut_report *report, kn_crossing *x,
                       int var, double line, double delta)
{
    kn_trim above = {0};
    const double f[3] = {var == 0, var == 1, -line};
    kn_status status = kn_cross_cut_by(ctx, below, &above, report, x, rest, f, delta);
    if (status == KN_OK) {
        x->off = fmax(x->off, report->residual);
        kn_trim swap = *rest;
        *rest = above;
        above = swap;
    }
    kn_trim_clear(ctx, &above);
    return status;
}

static kn_status add(kn_ctx *ctx, const kn_crossing *x, kn_trim *trim, int i, int j)
{
    kn_job_leaf part = *x->leaf;
    part.alone = true;
    part.piece = x->piece[i][j];
    for (int c = 0; c < 2; c++) part.shift[c] = x->shift[i][j][c];
    part.trim = *trim;
    *trim = (kn_trim){0};
    kn_status status = kn_job_add_leaf(ctx, x->plan, &part);
    kn_trim_clear(ctx, &part.trim);
    return status;
}

// The strip between two lines of u, cut at the lines of v.
static kn_status cut_strip(kn_ctx *ctx, kn_crossing *x, kn_trim *strip, int i, double delta)
{
    kn_status status = KN_OK;
    kn_trim_cut_report report = {.above = true};
    for (int j = 0; status == KN_OK && report.above && j <= x->n[1]; j++) {
        kn_trim part = {0};
        if (j < x->n[1]) {
            status = kn_cross_cut(ctx, &part, strip, &report, x, 1, x->line[1][j], delta);
        } else {
            part = *strip;
            *strip = (kn_trim){0};
            report.below = true;
        }
        if (status == KN_OK && report.below) status = add(ctx, x, &part, i, j);
        kn_trim_clear(ctx, &part);
    }
    return status;
}

kn_status kn_cross_trim(kn_ctx *ctx, bool *crossed, kn_crossing *x)
{
    double tol = x->plan->job->options.crossing_tol, delta = COARSEST, error = 0.0;
    kn_status status = kn_crossing_pieces(ctx, crossed, x);
    if (status != KN_OK || !*crossed) return status;
    status = choose_delta(ctx, &delta, &error, x, tol);
    if (status == KN_OK && !(error <= tol)) {
        *crossed = false; // a smaller part may do: n's stand-ins differ less there
        return status;
    }
    kn_trim rest = {0};
    kn_trim_cut_report report = {.above = true};
    status = kn_trim_copy(ctx, &rest, &x->leaf->trim);
    for (int i = 0; status == KN_OK && report.above && i <= x->n[0]; i++) {
        kn_trim strip = {0};
        if (i < x->n[0]) {
            status = kn_cross_cut(ctx, &strip, &rest, &report, x, 0, x->line[0][i], delta);
        } else {
            strip = rest;
            rest = (kn_trim){0};
            report.below = true;
        }
        if (status == KN_OK && report.below) status = cut_strip(ctx, x, &strip, i, delta);
        kn_trim_clear(ctx, &strip);
    }
    kn_trim_clear(ctx, &rest);
    int exponent;
    (void)frexp(fmax(x->off, FINEST), &exponent); // the next power of two
    if (status == KN_OK) status = find_error(ctx, &error, x, fmin(delta, ldexp(1.0, exponent)));
    if (status == KN_OK) x->plan->crossing = fmax(x->plan->crossing, error);
    return status;
}
